//! A profile built in code, and the checks that every profile passes.

use core::ops::Range;

use super::{Arc, PlaneMap, Point, Profile, ProfileError, ProfileErrorKind, Segment, Subpath};
use crate::numeric::gamma;

/// Collects subpaths, point by point, and checks them at the end.
///
/// ```
/// # fn main() -> Result<(), rondure::ProfileError> {
/// let tumbler = rondure::Profile::builder()
///     .move_to(0.0, 0.0)
///     .line_to(0.9, 0.0)
///     .arc_to([0.1, 0.1], 0.0, false, true, 1.0, 0.1)
///     .line_to(1.2, 3.0)
///     .build()?;
/// assert_eq!(tumbler.segments().count(), 3);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct ProfileBuilder {
    subpaths: Vec<Subpath>,
    current: Vec<Segment>,
    spans: Vec<Option<Range<usize>>>,
    start: Point,
    end: Point,
    span: Option<Range<usize>>,
    error: Option<ProfileError>,
}

impl Profile {
    /// The image of the profile under a map of the half plane; arcs stay arcs.
    ///
    /// # Errors
    ///
    /// As for [`ProfileBuilder::build`]: above all, the image must not go to r < 0.
    pub fn mapped(&self, map: &PlaneMap) -> Result<Self, ProfileError> {
        let builder = ProfileBuilder {
            subpaths: self.subpaths.clone(),
            spans: vec![None; self.segments().count()],
            ..ProfileBuilder::default()
        };
        builder.map(map).build()
    }
}

impl ProfileBuilder {
    /// Begins a new subpath at (r, z).
    #[must_use]
    pub fn move_to(mut self, r: f64, z: f64) -> Self {
        self.finish_subpath(false);
        self.start = Point::new(r, z);
        self.end = self.start;
        self
    }

    /// Draws a straight line to (r, z). Without a `move_to` before it, the first segment begins at
    /// (0, 0).
    #[must_use]
    pub fn line_to(self, r: f64, z: f64) -> Self {
        let line = Segment::Line([self.end, Point::new(r, z)]);
        self.segment(line)
    }

    /// Draws a quadratic Bézier curve with the control point `c` to (r, z).
    #[must_use]
    pub fn quad_to(self, c: [f64; 2], r: f64, z: f64) -> Self {
        let curve = Segment::Quadratic([self.end, Point::new(c[0], c[1]), Point::new(r, z)]);
        self.segment(curve)
    }

    /// Draws a cubic Bézier curve with the control points `c1` and `c2` to (r, z).
    #[must_use]
    pub fn cubic_to(self, c1: [f64; 2], c2: [f64; 2], r: f64, z: f64) -> Self {
        let (c1, c2) = (Point::new(c1[0], c1[1]), Point::new(c2[0], c2[1]));
        let curve = Segment::Cubic([self.end, c1, c2, Point::new(r, z)]);
        self.segment(curve)
    }

    /// Draws an elliptical arc to (r, z) as SVG's `A` does: the two radii, the rotation of the
    /// ellipse in radians, whether the longer arc is meant, and whether it turns from r towards z.
    #[must_use]
    pub fn arc_to(
        mut self,
        radii: [f64; 2],
        rotation: f64,
        large: bool,
        sweep: bool,
        r: f64,
        z: f64,
    ) -> Self {
        let end = Point::new(r, z);
        if let Some(&radius) = radii.iter().find(|x| !x.is_finite() || **x < 0.0) {
            self.fail(ProfileErrorKind::ArcRadius { radius });
        } else if !rotation.is_finite() {
            self.fail(ProfileErrorKind::NotFinite { point: Point::new(rotation, rotation) });
        }
        match Arc::from_endpoints(self.end, end, radii, rotation, large, sweep) {
            Some(arc) => self.segment(Segment::Arc(arc)),
            None => {
                let line = Segment::Line([self.end, end]);
                self.segment(line)
            }
        }
    }

    /// Closes the current subpath, with a straight line unless it has come back to its start.
    #[must_use]
    pub fn close(mut self) -> Self {
        if self.current.is_empty() {
            return self;
        }
        if self.end != self.start {
            let start = self.start;
            self = self.line_to(start.r, start.z);
        }
        self.finish_subpath(true);
        self.end = self.start;
        self
    }

    /// Maps all that has been drawn so far; arcs stay arcs.
    #[must_use]
    pub fn map(mut self, map: &PlaneMap) -> Self {
        self.each_segment(|segment| *segment = map.segment(segment));
        self.start = map.point(self.start);
        self.end = map.point(self.end);
        self
    }

    /// Puts the points that lie within `distance` of the axis on it: ends, control points, and the
    /// centres of arcs.
    ///
    /// [`map_rounding`](Self::map_rounding) is the distance that undoes what rounding has done to
    /// points that were drawn on the axis.
    #[must_use]
    pub fn snap_to_axis(mut self, distance: f64) -> Self {
        let snap = |p: &mut Point| {
            if p.r.abs() <= distance {
                p.r = 0.0;
            }
        };
        self.each_segment(|segment| match segment {
            Segment::Line(p) => p.iter_mut().for_each(snap),
            Segment::Quadratic(p) => p.iter_mut().for_each(snap),
            Segment::Cubic(p) => p.iter_mut().for_each(snap),
            Segment::Arc(a) => [&mut a.start, &mut a.end, &mut a.center].into_iter().for_each(snap),
        });
        snap(&mut self.start);
        snap(&mut self.end);
        self
    }

    /// How far rounding can move the r of a point when `map` is applied to what has been drawn so
    /// far, counting the decimal coordinates and the relative steps that it was written with.
    ///
    /// Let X be the largest absolute value of a coordinate and n the number of segments. A point is
    /// a sum of at most n + 2 steps; each literal is rounded when it is read (u times its size, at
    /// most 2 X), each addition by u X: together 3 (n + 2) u X, to which the map adds its own
    /// rounding and its own magnitude.
    pub fn map_rounding(&self, map: &PlaneMap) -> f64 {
        let finished = self.subpaths.iter().flat_map(Subpath::segments);
        let all = finished.chain(&self.current).flat_map(controls);
        let reach =
            all.fold(Point::default(), |m, p| Point::new(m.r.max(p.r.abs()), m.z.max(p.z.abs())));
        let steps = u32::try_from(self.spans.len()).unwrap_or(u32::MAX / 8).min(u32::MAX / 8);
        map.rounding_of_r(reach, 3 * (steps + 2))
    }

    fn each_segment(&mut self, mut change: impl FnMut(&mut Segment)) {
        for subpath in &mut self.subpaths {
            subpath.segments.iter_mut().for_each(&mut change);
        }
        self.current.iter_mut().for_each(change);
    }

    /// Checks everything and returns the profile.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] for the first segment that is not finite or goes to r < 0, and for a profile
    /// that is empty, has no extent, or is larger than 1e100 or smaller than 1e-100.
    pub fn build(mut self) -> Result<Profile, ProfileError> {
        self.finish_subpath(false);
        if let Some(error) = self.error {
            return Err(error);
        }
        let profile = Profile { subpaths: self.subpaths };
        check(&profile).map_err(|mut error| {
            error.span = error.segment.and_then(|i| self.spans[i].clone());
            error
        })?;
        Ok(profile)
    }

    /// Remembers the bytes of the source text that the next segments come from.
    pub(super) fn at(&mut self, span: Range<usize>) {
        self.span = Some(span);
    }

    /// The current point.
    pub(super) fn position(&self) -> Point {
        self.end
    }

    fn segment(mut self, segment: Segment) -> Self {
        self.end = segment.end();
        self.current.push(segment);
        self.spans.push(self.span.clone());
        self
    }

    fn finish_subpath(&mut self, closed: bool) {
        if !self.current.is_empty() {
            let segments = core::mem::take(&mut self.current);
            // A chain that comes back to its start bit for bit is closed, however it was written.
            let closed = closed || self.end == self.start;
            self.subpaths.push(Subpath { segments, closed });
        }
    }

    fn fail(&mut self, kind: ProfileErrorKind) {
        let segment = Some(self.spans.len());
        let span = self.span.clone();
        self.error.get_or_insert(ProfileError { kind, segment, span });
    }
}

/// Squares of lengths, and products of two of them, must neither overflow nor vanish.
pub(super) const LARGEST: f64 = 1e100;
const SMALLEST: f64 = 1e-100;

pub(super) fn check(profile: &Profile) -> Result<(), ProfileError> {
    let at = |i: usize, kind| ProfileError { kind, segment: Some(i), span: None };
    for (i, segment) in profile.segments().enumerate() {
        if let Some(&point) = controls(segment).iter().find(|p| !p.is_finite()) {
            return Err(at(i, ProfileErrorKind::NotFinite { point }));
        }
    }
    let Some(first) = profile.segments().next() else {
        return Err(ProfileErrorKind::Empty.into());
    };
    let all = || profile.segments().flat_map(controls);
    let largest = all().fold(0.0_f64, |m, p| m.max(p.r.abs()).max(p.z.abs()));
    if profile.segments().all(Segment::is_point) {
        return Err(ProfileErrorKind::NoExtent { point: first.start() }.into());
    }
    if profile.segments().all(|s| !matches!(s, Segment::Arc(_))) && all().all(|p| p.r == 0.0) {
        return Err(ProfileErrorKind::OnAxis.into());
    }
    let extent = all().fold(0.0_f64, |m, p| m.max((p - first.start()).length()).max(p.r.abs()));
    for size in [largest, extent] {
        if !(SMALLEST..=LARGEST).contains(&size) {
            return Err(ProfileErrorKind::Magnitude { largest: size }.into());
        }
    }
    for (i, segment) in profile.segments().enumerate() {
        let (point, s) = lowest_radius(segment);
        if point.r < -radius_rounding(segment) {
            return Err(at(i, ProfileErrorKind::NegativeRadius { point, s }));
        }
    }
    Ok(())
}

/// How far below zero rounding alone can bring the radius of a segment that touches the axis: the
/// point at a turning point of r is a combination of at most four control radii in at most eight
/// operations. End points are not computed, and have no such excuse.
fn radius_rounding(segment: &Segment) -> f64 {
    let ends = segment.start().r.min(segment.end().r);
    if ends < 0.0 {
        return 0.0;
    }
    gamma(8) * controls(segment).iter().fold(0.0_f64, |m, p| m.max(p.r.abs()))
}

/// The point of a segment with the smallest r, and its parameter.
fn lowest_radius(segment: &Segment) -> (Point, f64) {
    let mut lowest = (segment.start(), 0.0);
    for s in super::monotone::turning_parameters_of_r(segment).into_iter().chain([1.0]) {
        let point = segment.point(s);
        if point.r < lowest.0.r {
            lowest = (point, s);
        }
    }
    lowest
}

fn controls(segment: &Segment) -> Vec<Point> {
    match segment {
        Segment::Line(p) => p.to_vec(),
        Segment::Quadratic(p) => p.to_vec(),
        Segment::Cubic(p) => p.to_vec(),
        Segment::Arc(a) => {
            let reach = a.radii[0].max(a.radii[1]);
            vec![a.start, a.end, a.center, a.center + Point::new(reach, reach)]
        }
    }
}

impl Extend<kurbo::PathEl> for ProfileBuilder {
    /// Appends the elements of a [`kurbo::BezPath`]: x is r, y is z.
    fn extend<I: IntoIterator<Item = kurbo::PathEl>>(&mut self, elements: I) {
        for element in elements {
            let builder = core::mem::take(self);
            *self = match element {
                kurbo::PathEl::MoveTo(p) => builder.move_to(p.x, p.y),
                kurbo::PathEl::LineTo(p) => builder.line_to(p.x, p.y),
                kurbo::PathEl::QuadTo(c, p) => builder.quad_to([c.x, c.y], p.x, p.y),
                kurbo::PathEl::CurveTo(c, d, p) => {
                    builder.cubic_to([c.x, c.y], [d.x, d.y], p.x, p.y)
                }
                kurbo::PathEl::ClosePath => builder.close(),
            };
        }
    }
}

//! One side of a wall: the parallels of all segments of a subpath, joined.
//!
//! Where two segments meet at an angle the parallels leave a gap on the outside of the corner, which an
//! arc about the corner fills, and cross on the inside, where both are cut. An end on the axis is a
//! corner between the curve and its mirror image.

use super::parallel::{Parallel, cross, dot, tangent};
use super::{ACCURACY, Point, Segment, Subpath, fit};
use crate::numeric::gamma;
use crate::profile::{Arc, ProfileError, ProfileErrorKind};

/// The ends of a subpath.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    Closed,
    /// Both.
    OnAxis,
    StartOnAxis,
    EndOnAxis,
    Free,
}

/// A subpath whose parallels are wanted, without what has no extent or lies on the axis at its ends.
#[derive(Debug)]
pub(super) struct Traced<'a> {
    segments: Vec<(&'a Segment, usize)>,
    pub(super) ends: Ends,
    pub(super) first: usize,
    size: f64,
}

/// Segments in a row, each with the number of the segment of the profile that it comes from.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub(super) chain: Vec<(Segment, usize)>,
    pub(super) closed: bool,
}

impl Drawn {
    pub(super) fn start(&self) -> Point {
        self.chain[0].0.start()
    }

    pub(super) fn end(&self) -> Point {
        self.chain[self.chain.len() - 1].0.end()
    }

    pub(super) fn reversed(mut self) -> Self {
        self.chain.reverse();
        for (segment, _) in &mut self.chain {
            *segment = match *segment {
                Segment::Line([a, b]) => Segment::Line([b, a]),
                Segment::Quadratic([a, b, c]) => Segment::Quadratic([c, b, a]),
                Segment::Cubic([a, b, c, d]) => Segment::Cubic([d, c, b, a]),
                Segment::Arc(arc) => Segment::Arc(Arc {
                    start: arc.end,
                    end: arc.start,
                    start_angle: arc.start_angle + arc.sweep_angle,
                    sweep_angle: -arc.sweep_angle,
                    ..arc
                }),
            };
        }
        self
    }
}

/// The part of a segment's parallel that belongs to the side.
#[derive(Clone, Copy, Debug)]
struct Part {
    range: [f64; 2],
    ends: [Point; 2],
}

/// What stands between two parts.
#[derive(Clone, Copy, Debug)]
enum Joint {
    None,
    /// An arc about a corner: where it begins and ends, the centre, and whether it turns to the left.
    Arc {
        from: Point,
        to: Point,
        left: bool,
    },
}

impl<'a> Traced<'a> {
    /// `first` is the number of the subpath's first segment in the profile.
    pub(super) fn new(subpath: &'a Subpath, first: usize, size: f64) -> Result<Self, ProfileError> {
        let all = subpath.segments.iter().enumerate().map(|(i, s)| (s, first + i));
        let mut segments: Vec<_> = all.filter(|(s, _)| !s.is_point()).collect();
        if !subpath.closed {
            let on_axis = |(s, _): &(&Segment, usize)| match s {
                Segment::Line(p) => p.iter().all(|p| p.r == 0.0),
                Segment::Quadratic(p) => p.iter().all(|p| p.r == 0.0),
                Segment::Cubic(p) => p.iter().all(|p| p.r == 0.0),
                Segment::Arc(_) => false,
            };
            let begin = segments.iter().take_while(|s| on_axis(s)).count();
            segments.drain(..begin);
            let end = segments.iter().rev().take_while(|s| on_axis(s)).count();
            segments.truncate(segments.len() - end);
        }
        let (Some((start, first)), Some((end, _))) = (segments.first(), segments.last()) else {
            let point = subpath.start();
            let kind = ProfileErrorKind::NoExtent { point };
            return Err(ProfileError { kind, segment: Some(first), span: None });
        };
        let ends = match (subpath.closed, start.start().r == 0.0, end.end().r == 0.0) {
            (true, _, _) => Ends::Closed,
            (false, true, true) => Ends::OnAxis,
            (false, true, false) => Ends::StartOnAxis,
            (false, false, true) => Ends::EndOnAxis,
            (false, false, false) => Ends::Free,
        };
        let first = *first;
        Ok(Self { segments, ends, first, size })
    }

    /// The number of the last segment.
    pub(super) fn last(&self) -> usize {
        self.segments[self.segments.len() - 1].1
    }

    /// Ends that are no farther apart than this are one point.
    fn near(&self) -> f64 {
        ACCURACY * self.size
    }

    /// The parallel at the signed distance d, to the right if positive.
    pub(super) fn side(&self, d: f64) -> Result<Drawn, ProfileError> {
        let closed = self.ends == Ends::Closed;
        if d == 0.0 {
            let chain = self.segments.iter().map(|(s, source)| (**s, *source)).collect();
            return Ok(Drawn { chain, closed });
        }
        let mut parts = Vec::new();
        for &(segment, source) in &self.segments {
            let parallel = Parallel { segment, d };
            let ends = parallel.point(0.0).zip(parallel.point(1.0));
            let (a, b) = ends.ok_or_else(|| corner(source, segment.start()))?;
            parts.push(Part { range: [0.0, 1.0], ends: [a, b] });
        }
        let count = parts.len();
        // The joint before each part; that of the first is between it and the last.
        let mut joints = Vec::with_capacity(count);
        for i in 0..count {
            joints.push(if closed || i > 0 {
                self.join(&mut parts, (i + count - 1) % count, i, d)?
            } else {
                Joint::None
            });
        }
        let mut last = Joint::None;
        if matches!(self.ends, Ends::OnAxis | Ends::StartOnAxis) {
            joints[0] = self.meet_axis(&mut parts[0], 0, d)?;
        }
        if matches!(self.ends, Ends::OnAxis | Ends::EndOnAxis) {
            last = self.meet_axis(&mut parts[count - 1], 1, d)?;
        }
        let mut chain = Vec::new();
        for ((part, joint), &(segment, source)) in parts.iter().zip(joints).zip(&self.segments) {
            self.arc(joint, d, source, &mut chain);
            self.draw(part, &Parallel { segment, d }, source, &mut chain)?;
        }
        self.arc(last, d, self.last(), &mut chain);
        Ok(Drawn { chain, closed })
    }

    fn arc(&self, joint: Joint, d: f64, source: usize, chain: &mut Vec<(Segment, usize)>) {
        if let Joint::Arc { from, to, left } = joint {
            let arc = Arc::from_endpoints(from, to, [d.abs(); 2], 0.0, false, left);
            chain.push((arc.map_or(Segment::Line([from, to]), Segment::Arc), source));
        }
    }

    fn draw(
        &self,
        part: &Part,
        parallel: &Parallel<'_>,
        source: usize,
        chain: &mut Vec<(Segment, usize)>,
    ) -> Result<(), ProfileError> {
        let ([from, to], [start, end]) = (part.range, part.ends);
        if from >= to {
            return Err(corner(source, parallel.segment.point(from.clamp(0.0, 1.0))));
        }
        if let Some(fold) = parallel.fold(part.range) {
            let point = parallel.segment.point(fold.s);
            let (s, radius, distance) = (fold.s, fold.radius, parallel.d.abs());
            let kind = ProfileErrorKind::WallFolds { point, s, radius, distance };
            return Err(ProfileError { kind, segment: Some(source), span: None });
        }
        match parallel.segment {
            Segment::Line(_) => chain.push((Segment::Line([start, end]), source)),
            Segment::Arc(arc) if arc.radii[0] == arc.radii[1] => {
                let radius = arc.radii[0] + parallel.d * arc.sweep_angle.signum();
                chain.push((
                    Segment::Arc(Arc {
                        start,
                        end,
                        radii: [radius; 2],
                        start_angle: arc.start_angle + from * arc.sweep_angle,
                        sweep_angle: (to - from) * arc.sweep_angle,
                        ..*arc
                    }),
                    source,
                ));
            }
            _ => {
                let mut cubics = Vec::new();
                fit::fit(parallel, part.range, part.ends, self.near(), &mut cubics)
                    .ok_or_else(|| corner(source, parallel.segment.point(from)))?;
                chain.extend(cubics.into_iter().map(|cubic| (cubic, source)));
            }
        }
        Ok(())
    }

    /// Joins two parts, cutting both on the inside of their corner.
    fn join(
        &self,
        parts: &mut [Part],
        one: usize,
        two: usize,
        d: f64,
    ) -> Result<Joint, ProfileError> {
        let [(before, _), (after, source)] = [self.segments[one], self.segments[two]];
        let vertex = after.start();
        let tangents = tangent(before, 1.0).zip(tangent(after, 0.0));
        let (t0, t1) = tangents.ok_or_else(|| corner(source, vertex))?;
        let (from, to) = (parts[one].ends[1], parts[two].ends[0]);
        let (turn, ahead) = (cross(t0, t1), dot(t0, t1));
        if (to - from).length() <= self.near() && ahead > 0.0 {
            let middle = from.lerp(to, 0.5);
            parts[one].ends[1] = middle;
            parts[two].ends[0] = middle;
            return Ok(Joint::None);
        }
        if d * turn > 0.0 {
            return Ok(Joint::Arc { from, to, left: turn > 0.0 });
        }
        let cut = meeting(
            [Parallel { segment: before, d }, Parallel { segment: after, d }],
            d.abs() * turn.abs() / (1.0 + ahead),
            self.size,
        );
        let (u, v, point) = cut.ok_or_else(|| corner(source, vertex))?;
        parts[one].range[1] = u;
        parts[one].ends[1] = point;
        parts[two].range[0] = v;
        parts[two].ends[0] = point;
        Ok(Joint::None)
    }

    /// Brings the start (0) or the end (1) of a part to the axis, as if the curve's mirror image joined it
    /// there.
    fn meet_axis(&self, part: &mut Part, end: usize, d: f64) -> Result<Joint, ProfileError> {
        let (segment, source) = self.segments[if end == 0 { 0 } else { self.segments.len() - 1 }];
        let s = end as f64;
        let (pole, at) = (segment.point(s), part.ends[end]);
        if at.r.abs() <= self.near() {
            part.ends[end].r = 0.0;
            return Ok(Joint::None);
        }
        if at.r > 0.0 {
            // Half way round the corner the normal lies along the axis.
            let on_axis = Point::new(0.0, if end == 0 { pole.z - d } else { pole.z + d });
            let left = d > 0.0;
            return Ok(match end {
                0 => Joint::Arc { from: on_axis, to: at, left },
                _ => Joint::Arc { from: at, to: on_axis, left },
            });
        }
        let parallel = Parallel { segment, d };
        let cut = first_on_axis(&parallel, s).ok_or(ProfileError {
            kind: ProfileErrorKind::WallCrossesAxis { point: at },
            segment: Some(source),
            span: None,
        })?;
        part.range[end] = cut;
        let height = parallel.point(cut).map_or(pole.z, |p| p.z);
        part.ends[end] = Point::new(0.0, height);
        Ok(Joint::None)
    }
}

fn corner(segment: usize, point: Point) -> ProfileError {
    let kind = ProfileErrorKind::WallCorner { point };
    ProfileError { kind, segment: Some(segment), span: None }
}

/// Where the end of one parallel crosses the beginning of the next: both parameters and the point. `back` is
/// how far before the corner that would be if both were straight.
fn meeting([one, two]: [Parallel<'_>; 2], back: f64, size: f64) -> Option<(f64, f64, Point)> {
    let speed = |p: &Parallel<'_>, s: f64| p.jet(s).map(|(_, v)| v.length());
    let (u, v) = (1.0 - back / speed(&one, 1.0)?, back / speed(&two, 0.0)?);
    let straight = refined([one, two], [u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)], size);
    straight.or_else(|| {
        let [u, v] = crossing_of_polylines([one, two])?;
        refined([one, two], [u, v], size)
    })
}

/// Newton's iteration for one(u) = two(v).
fn refined(
    [one, two]: [Parallel<'_>; 2],
    [mut u, mut v]: [f64; 2],
    size: f64,
) -> Option<(f64, f64, Point)> {
    const STEPS: usize = 32;
    let rounding = gamma(64) * size;
    for _ in 0..STEPS {
        let ((a, da), (b, db)) = (one.jet(u)?, two.jet(v)?);
        let apart = b - a;
        if apart.length() <= rounding {
            return Some((u, v, a.lerp(b, 0.5)));
        }
        let determinant = cross(da, db);
        u += cross(apart, db) / determinant;
        v += cross(apart, da) / determinant;
        if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
            return None;
        }
    }
    None
}

/// Parameters near a crossing: that of two polylines, the last on the first and the first on the last.
fn crossing_of_polylines([one, two]: [Parallel<'_>; 2]) -> Option<[f64; 2]> {
    const STEPS: u32 = 64;
    let sampled = |p: &Parallel<'_>| -> Option<Vec<(f64, Point)>> {
        let s = |i: u32| f64::from(i) / f64::from(STEPS);
        (0..=STEPS).map(|i| Some((s(i), p.point(s(i))?))).collect()
    };
    let (one, two) = (sampled(&one)?, sampled(&two)?);
    for a in one.windows(2).rev() {
        for b in two.windows(2) {
            let (along, other) = (a[1].1 - a[0].1, b[1].1 - b[0].1);
            let (between, area) = (b[0].1 - a[0].1, cross(along, other));
            let (s, t) = (cross(between, other) / area, cross(between, along) / area);
            if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
                return Some([a[0].0 + s * (a[1].0 - a[0].0), b[0].0 + t * (b[1].0 - b[0].0)]);
            }
        }
    }
    None
}

/// The parameter, seen from the end s (0 or 1), at which a parallel that begins beyond the axis reaches
/// it.
fn first_on_axis(parallel: &Parallel<'_>, s: f64) -> Option<f64> {
    const STEPS: u32 = 256;
    let at = |x: f64| if s == 0.0 { x } else { 1.0 - x };
    let radius = |x: f64| parallel.point(at(x)).map(|p| p.r);
    let step = |i: u32| f64::from(i) / f64::from(STEPS);
    let over = (1..=STEPS).find(|&i| radius(step(i)).is_some_and(|r| r >= 0.0))?;
    let (mut beyond, mut on_side) = (step(over - 1), step(over));
    loop {
        let middle = 0.5 * (beyond + on_side);
        if middle <= beyond || middle >= on_side {
            return Some(at(on_side));
        }
        *(if radius(middle)? < 0.0 { &mut beyond } else { &mut on_side }) = middle;
    }
}

//! Walls: a profile that is a bare curve, given a thickness.
//!
//! ```text
//! curve c(s), right normal n = (z', -r') / |c'|
//! wall  = { c + d n : low <= d <= high },   high - low = thickness
//! sides = parallel curves at d = low and d = high                          side.rs
//! each a chain of c + d n, segment by segment                              parallel.rs, fit.rs
//! ```
//!
//! Between the sides lie the rims, at ends off the axis; at an end on the axis both sides end on it. Where
//! the curve has a corner, the side round the outside of it keeps its distance by an arc, and on the inside
//! the parallels of the two segments are cut where they meet. At the axis the curve counts as
//! joined to its mirror image.

mod fit;
mod parallel;
mod side;

use super::{Arc, Point, Profile, ProfileError, ProfileErrorKind, Segment, Subpath};
use crate::orientation::outward_of_curve;
use crate::solid::{FillRule, Solid};

use crate::Vec3;
use side::{Drawn, Ends, Traced};

/// How far a parallel of a Bézier curve or an ellipse may be from its exact place, as a fraction of the
/// profile's size. Those of lines and circles are lines and circles.
pub const ACCURACY: f64 = 1e-10;

/// The wall that a curve is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thickness {
    /// From one side of the wall to the other.
    pub thickness: f64,
    /// On which side of the curve the wall is.
    pub side: Side,
    /// How the wall ends where the curve ends off the axis.
    pub rim: Rim,
}

impl Thickness {
    /// A wall inside the curve with flat rims.
    pub fn new(thickness: f64) -> Self {
        Self { thickness, side: Side::default(), rim: Rim::default() }
    }
}

/// Where a wall is. Outside is the side that does not lie between the curve and the axis; of a curve that
/// bounds a solid, the outside of that. A curve that is neither, such as a level line, has its outside to
/// the right of the direction in which it is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Inside: the curve is the outer face of the wall.
    #[default]
    Inward,
    /// Outside: the curve is its inner face.
    Outward,
    /// Half on either side.
    Centered,
}

/// The end of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rim {
    /// Straight across; the wall is as long as the curve.
    #[default]
    Flat,
    /// Half a circle, by which the wall is half its thickness longer than the curve.
    Round,
}

impl Profile {
    /// The wall of a given thickness along the profile: a profile that bounds a solid.
    ///
    /// Lines and circular arcs are offset exactly, all other curves to [`ACCURACY`]. Subpaths that
    /// bound a solid become shells.
    ///
    /// ```
    /// # fn main() -> Result<(), rondure::ProfileError> {
    /// use rondure::{Profile, profile::Thickness};
    ///
    /// let tube = Profile::from_path_data("M 2 0 L 2 5")?.thickened(&Thickness::new(0.5))?;
    /// assert_eq!(tube, Profile::from_path_data("M 2 0 L 2 5 L 1.5 5 L 1.5 0 Z")?);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    ///
    /// [`ProfileError`] with the segment of this profile at fault and the place: if the thickness is
    /// not positive; if a curve bends more tightly than the wall is thick on that side, or a corner leaves
    /// nothing of a segment beside it; if the wall crosses the axis, or overlaps itself.
    pub fn thickened(&self, wall: &Thickness) -> Result<Self, ProfileError> {
        let Thickness { thickness, side, rim } = *wall;
        let size = size(self);
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Err(ProfileErrorKind::Thickness { thickness }.into());
        }
        let mut subpaths = Vec::new();
        let mut sources = Vec::new();
        let mut first = 0;
        for (subpath, outward) in self.subpaths.iter().zip(outward_of_curve(self)) {
            let [low, high] = match side {
                Side::Inward => [-thickness, 0.0],
                Side::Outward => [0.0, thickness],
                Side::Centered => [-0.5 * thickness, 0.5 * thickness],
            };
            let [low, high] = if outward > 0.0 { [low, high] } else { [-high, -low] };
            let curve = Traced::new(subpath, first, size)?;
            for drawn in outline(&curve, curve.side(high)?, curve.side(low)?, rim) {
                sources.extend(drawn.chain.iter().map(|(_, source)| *source));
                let segments = drawn.chain.into_iter().map(|(segment, _)| segment).collect();
                subpaths.push(Subpath { segments, closed: drawn.closed });
            }
            first += subpath.segments.len();
        }
        let wall = Self { subpaths };
        super::builder::check(&wall).map_err(|error| match error.kind {
            ProfileErrorKind::NegativeRadius { point, .. } => ProfileError {
                kind: ProfileErrorKind::WallCrossesAxis { point },
                segment: error.segment.map(|i| sources[i]),
                span: None,
            },
            _ => error,
        })?;
        match overlap(&wall, thickness) {
            Some((segment, point)) => Err(ProfileError {
                kind: ProfileErrorKind::WallOverlaps { point },
                segment: Some(sources[segment]),
                span: None,
            }),
            None => Ok(wall),
        }
    }
}

/// The outline of a wall with these two sides, the right one and the left one.
fn outline(curve: &Traced<'_>, right: Drawn, left: Drawn, rim: Rim) -> Vec<Drawn> {
    let left = left.reversed();
    let across = |from: &Drawn, to: &Drawn| {
        let (a, b) = (from.end(), to.start());
        let flat = Segment::Line([a, b]);
        match rim {
            Rim::Flat => flat,
            // From the right side to the left one round the end, or from the left to the right round
            // the start: counterclockwise either way.
            Rim::Round => {
                let radius = 0.5 * (b - a).length();
                Arc::from_endpoints(a, b, [radius; 2], 0.0, false, true).map_or(flat, Segment::Arc)
            }
        }
    };
    let join = |mut one: Drawn, two: Drawn, source: usize| {
        one.chain.push((across(&one, &two), source));
        one.chain.extend(two.chain);
        one
    };
    match curve.ends {
        Ends::Closed | Ends::OnAxis => vec![right, left],
        Ends::StartOnAxis => vec![join(right, left, curve.last())],
        Ends::EndOnAxis => vec![join(left, right, curve.first)],
        Ends::Free => {
            let back = (across(&left, &right), curve.first);
            let mut all = join(right, left, curve.last());
            all.chain.push(back);
            all.closed = true;
            vec![all]
        }
    }
}

/// The larger of the largest radius and the extent along the axis.
fn size(profile: &Profile) -> f64 {
    let points = || profile.segments().flat_map(|s| [s.start(), s.point(0.5), s.end()]);
    let low = points().fold(f64::INFINITY, |m, p| m.min(p.z));
    let high = points().fold(f64::NEG_INFINITY, |m, p| m.max(p.z));
    points().fold(high - low, |m, p| m.max(p.r))
}

/// Where a wall overlaps itself, by its segment and a point: where its outline has not the inside on one
/// side alone. Looked for at so many places on every segment.
fn overlap(wall: &Profile, thickness: f64) -> Option<(usize, Point)> {
    const PLACES: u32 = 8;
    /// Beside the outline, as a fraction of the thickness: farther than it may be off, nearer than
    /// the other side.
    const BESIDE: f64 = 1.0 / 1024.0;
    let solid = Solid::new(wall, FillRule::NonZero).ok()?;
    let inside = |p: Point| solid.contains(Vec3::new(p.r, 0.0, p.z));
    let places = wall.segments().enumerate().flat_map(|(i, segment)| {
        (0..PLACES).map(move |k| (i, segment, (f64::from(k) + 0.5) / f64::from(PLACES)))
    });
    places
        .filter_map(|(i, segment, s)| {
            let (at, along) = (segment.point(s), parallel::tangent(segment, s)?);
            let aside = Point::new(along.z, -along.r) * (BESIDE * thickness);
            let [right, left] = [at + aside, at - aside];
            // The mirror image of what lies beyond the axis.
            let mirrored = |p: Point| Point { r: p.r.abs(), ..p };
            (at.r > thickness * BESIDE && inside(mirrored(right)) == inside(mirrored(left)))
                .then_some((i, at))
        })
        .next()
}

//! What can be wrong with a profile, and where.

use super::Point;
use core::{fmt, ops::Range};

/// Why a profile was refused.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileError {
    /// What is wrong.
    pub kind: ProfileErrorKind,
    /// The segment at fault, counted from 0 over all subpaths; `None` if it is not about one.
    pub segment: Option<usize>,
    /// The bytes of the path data at fault, if the profile was read from text.
    pub span: Option<Range<usize>>,
}

/// What is wrong with a profile.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ProfileErrorKind {
    /// There is no segment at all.
    Empty,
    /// The path data is not well-formed.
    Syntax {
        /// What was found, and what was expected.
        message: String,
    },
    /// A coordinate is infinite or NaN.
    NotFinite {
        /// The point with that coordinate.
        point: Point,
    },
    /// The curve leaves the half plane r >= 0.
    NegativeRadius {
        /// The point of the segment that lies farthest beyond the axis.
        point: Point,
        /// Its parameter on the segment, from 0 to 1.
        s: f64,
    },
    /// The profile is a single point, however many segments it has.
    NoExtent {
        /// That point.
        point: Point,
    },
    /// The whole profile lies on the axis, and sweeps no surface.
    OnAxis,
    /// The coordinates are so large or so small that their squares leave the range of an f64.
    Magnitude {
        /// The largest absolute value of a coordinate.
        largest: f64,
    },
    /// An arc has a radius that is negative, infinite or NaN.
    ArcRadius {
        /// That radius.
        radius: f64,
    },
    /// The thickness of a wall is not positive and finite.
    Thickness {
        /// That thickness.
        thickness: f64,
    },
    /// A side of a wall folds: it is farther from the curve than the curve's radius of curvature.
    WallFolds {
        /// The point of the curve that bends most tightly to that side.
        point: Point,
        /// Its parameter on the segment, from 0 to 1.
        s: f64,
        /// The radius of curvature there.
        radius: f64,
        /// The distance of the side from the curve.
        distance: f64,
    },
    /// A corner takes more of a segment, on its inside, than the segment is long.
    WallCorner {
        /// The corner, or the segment's first point.
        point: Point,
    },
    /// A side of a wall crosses the axis.
    WallCrossesAxis {
        /// Its point farthest beyond the axis.
        point: Point,
    },
    /// A wall overlaps another part of itself.
    WallOverlaps {
        /// A point of the wall's outline that lies inside the wall.
        point: Point,
    },
    /// Too few points for a curve.
    TooFewPoints {
        /// How many there are.
        found: usize,
    },
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(segment) = self.segment {
            write!(f, "segment {segment}: ")?;
        }
        match &self.kind {
            ProfileErrorKind::Empty => write!(f, "the profile has no segments"),
            ProfileErrorKind::Syntax { message } => f.write_str(message),
            ProfileErrorKind::NotFinite { point } => {
                write!(f, "the point (r = {}, z = {}) is not finite", point.r, point.z)
            }
            ProfileErrorKind::NegativeRadius { point, s } => write!(
                f,
                "the curve crosses the axis: it reaches r = {} at z = {} (s = {s}); r must not be \
                 negative",
                point.r, point.z
            ),
            ProfileErrorKind::NoExtent { point } => write!(
                f,
                "the whole profile is the single point (r = {}, z = {})",
                point.r, point.z
            ),
            ProfileErrorKind::OnAxis => {
                write!(f, "the whole profile lies on the axis, r = 0: it sweeps no surface")
            }
            ProfileErrorKind::Magnitude { largest } => write!(
                f,
                "the largest coordinate is {largest:e}; sizes from 1e-100 to 1e100 can be handled"
            ),
            ProfileErrorKind::ArcRadius { radius } => {
                write!(f, "an arc's radius is {radius}; it must be finite and not negative")
            }
            ProfileErrorKind::Thickness { thickness } => {
                write!(f, "a wall's thickness is {thickness}; it must be positive and finite")
            }
            ProfileErrorKind::WallFolds { point, s, radius, distance } => write!(
                f,
                "the wall folds: at r = {}, z = {} (s = {}) the curve's radius is {}, and one side of \
                 the wall is {} away on the inside of the bend",
                short(point.r),
                short(point.z),
                short(*s),
                short(*radius),
                short(*distance)
            ),
            ProfileErrorKind::WallCorner { point } => write!(
                f,
                "the wall folds: beside the corner at r = {}, z = {} it is too thick for the length of \
                 the segment",
                short(point.r),
                short(point.z)
            ),
            ProfileErrorKind::WallCrossesAxis { point } => write!(
                f,
                "the wall crosses the axis: one side of it reaches r = {} at z = {}",
                short(point.r),
                short(point.z)
            ),
            ProfileErrorKind::WallOverlaps { point } => write!(
                f,
                "the wall overlaps itself: at r = {}, z = {} one side of it lies within another part",
                short(point.r),
                short(point.z)
            ),
            ProfileErrorKind::TooFewPoints { found } => {
                write!(
                    f,
                    "a curve needs at least 2 points; there {} {found}",
                    if *found == 1 { "is" } else { "are" }
                )
            }
        }
    }
}

/// A computed number to six digits.
fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

impl core::error::Error for ProfileError {}

impl From<ProfileErrorKind> for ProfileError {
    fn from(kind: ProfileErrorKind) -> Self {
        Self { kind, segment: None, span: None }
    }
}

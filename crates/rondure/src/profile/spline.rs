//! A profile through given points: a polyline, or a smooth curve.

use super::{Point, Profile, ProfileError};

/// How a curve runs through given points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spline {
    /// Straight from point to point.
    Polyline,
    /// Natural cubic spline: continuous curvature, none at the ends.
    Natural,
    /// Catmull-Rom spline: the tangent at a point is parallel to the line between its neighbours.
    CatmullRom,
}

impl Profile {
    /// The profile through the points, in their order; closed if the last point equals the first.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] if there are fewer than two points, or the curve fails the checks of
    /// [`ProfileBuilder::build`](super::ProfileBuilder::build).
    pub fn through_points(points: &[Point], spline: Spline) -> Result<Self, ProfileError> {
        let _ = (points, spline);
        unimplemented!()
    }
}

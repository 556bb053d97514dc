//! Shells: regions that enclose what a part of the profile sweeps, and whether a ray meets them.
//!
//! | shell | region | where |
//! | --- | --- | --- |
//! | cylinder, CY | `z0 <= z <= z1`, `w0 <= rho^2 <= w1` | [`cylinder`] |
//! | cone, CO | the same slab, `inner <= rho - slope z <= outer` | [`cone`] |
//! | hybrid, HY | one of the two | [`hybrid`] |
//! | box and strip, BS | the cylinder shell cut with `low <= rho^2 - p z <= high` | [`strip`] |
//! | rectangle, KJ | a rectangle in the plane (z, rho^2), along a chord | [`rectangle`] |
//!
//! Along a ray z is linear, and both rho and rho^2 are convex. Every wall is therefore the set where
//! a convex function of the ray parameter lies between two values: outside an inner interval and
//! within an outer one, as the paper's intersection intervals have it ([`interval`]). Shells are
//! padded once, when they are built, by what rounding can do to a ray inside them.

pub(crate) mod cone;
pub(crate) mod cylinder;
pub(crate) mod hybrid;
pub(crate) mod interval;
pub(crate) mod rectangle;
pub(crate) mod strip;

pub(crate) use cone::Cone;
pub(crate) use cylinder::Cylinder;
pub(crate) use interval::Intervals;
pub(crate) use rectangle::Rectangle;
pub(crate) use strip::Strip;

use crate::meridian::Meridian;
use crate::numeric::gamma;
use crate::piece::Piece;

/// A region that encloses a part of the surface.
pub(crate) trait Shell {
    /// A stretch of the ray between the parameters `range` that holds every point of the ray inside
    /// the shell there; `None` if there is none.
    fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]>;

    /// The intersection interval (paper, section 3.2): where a stretch of the ray, as [`meet`]
    /// returns it, lies inside the outer and not inside the inner wall. None, one or two intervals,
    /// in order.
    ///
    /// [`meet`]: Self::meet
    fn intervals(&self, ray: &Meridian, stretch: [f64; 2]) -> Intervals;
}

/// The stretch of the ray between the parameters `range` that lies between two heights.
#[inline]
fn slab(z: [f64; 2], ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
    let [near, far] = if ray.dz >= 0.0 { z } else { [z[1], z[0]] };
    // Where dz = 0 these are infinite, or NaN for a ray in the plane, which max and min ignore.
    let lo = range[0].max((near - ray.oz) * ray.inverse_dz);
    let hi = range[1].min((far - ray.oz) * ray.inverse_dz);
    (lo <= hi).then_some([lo, hi])
}

/// How far rounding can move a point of a ray inside the sphere of this radius, counting all steps
/// from the given ray to the comparison: fewer than 64, each of a number no larger than twice the
/// radius.
pub(crate) fn padding(radius: f64) -> f64 {
    2.0 * gamma(64) * radius
}

fn heights(pieces: &[Piece], radius: f64) -> [f64; 2] {
    let [low, high] = ends(pieces, |p| p.z);
    [low - padding(radius), high + padding(radius)]
}

/// The smallest and the largest value of a coordinate; as pieces are monotone, they occur at ends.
fn ends(pieces: &[Piece], coordinate: impl Fn(&Piece) -> [f64; 4]) -> [f64; 2] {
    pieces.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], piece| {
        let c = coordinate(piece);
        [low.min(c[0]).min(c[3]), high.max(c[0]).max(c[3])]
    })
}

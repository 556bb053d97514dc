//! The cone shell, CO (paper, section 4.1.1): two coaxial cones along the chord of a part of the
//! profile, and two planes.

use super::interval::{Intervals, roots};
use super::{Shell, ends, heights, padding, slab};
use crate::meridian::Meridian;
use crate::piece::Piece;

/// `z0 <= z <= z1` and `inner <= rho - slope z <= outer`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    pub(crate) z: [f64; 2],
    pub(crate) slope: f64,
    pub(crate) offsets: [f64; 2],
}

impl Cone {
    /// The shell round some pieces; `None` where the chord from their first to their last point is
    /// horizontal.
    pub(crate) fn around(pieces: &[Piece], radius: f64) -> Option<Self> {
        let (first, last) = (pieces.first()?.start(), pieces.last()?.end());
        let slope = (last.r - first.r) / (last.z - first.z);
        if !slope.is_finite() {
            return None;
        }
        let mut offsets = [f64::INFINITY, f64::NEG_INFINITY];
        for piece in pieces {
            let controls = core::array::from_fn(|i| piece.r[i] - slope * piece.z[i]);
            let (low, high) = piece.range(&controls);
            offsets = [offsets[0].min(low), offsets[1].max(high)];
        }
        let pad = padding(radius) * (1.0 + slope.abs());
        let offsets = [offsets[0] - pad, offsets[1] + pad];
        Some(Self { z: heights(pieces, radius), slope, offsets })
    }

    /// The shell round some pieces; where the chord is horizontal, the cones of slope 0.
    pub(crate) fn or_upright(pieces: &[Piece], radius: f64) -> Self {
        Self::around(pieces, radius).unwrap_or_else(|| {
            let ([low, high], pad) = (ends(pieces, |p| p.r), padding(radius));
            Self { z: heights(pieces, radius), slope: 0.0, offsets: [low - pad, high + pad] }
        })
    }

    /// The area of the shell's section with the half plane.
    pub(crate) fn area(&self) -> f64 {
        (self.z[1] - self.z[0]) * (self.offsets[1] - self.offsets[0])
    }
}

impl Shell for Cone {
    #[inline]
    fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
        slab(self.z, ray, range)
            .filter(|stretch| between_cones(self.slope, self.offsets, ray, *stretch))
    }

    fn intervals(&self, ray: &Meridian, stretch: [f64; 2]) -> Intervals {
        cone_intervals(self.slope, self.offsets, ray, stretch)
    }
}

/// Whether a stretch of the ray has a point between two cones.
#[inline]
pub(super) fn between_cones(
    slope: f64,
    [inner, outer]: [f64; 2],
    ray: &Meridian,
    [lo, hi]: [f64; 2],
) -> bool {
    let w = [lo, hi].map(|t| {
        let x = ray.offset + ray.speed * t;
        x * x + ray.delta2
    });
    let axial = [lo, hi].map(|t| slope * (ray.oz + t * ray.dz));
    let beyond = |i: usize| {
        let rho = axial[i] + inner;
        rho <= 0.0 || w[i] >= rho * rho
    };
    let within = |i: usize| {
        let rho = axial[i] + outer;
        rho >= 0.0 && w[i] <= rho * rho
    };
    (beyond(0) || beyond(1)) && (within(0) || within(1) || dips_within(ray, slope, outer, [lo, hi]))
}

/// Whether rho - slope z, which exceeds `outer` at both ends of a stretch of the ray, turns between
/// them and reaches `outer` there.
///
/// With g = slope dz its derivative speed X / rho - g vanishes at X = g delta / sqrt(speed^2 - g^2),
/// where rho = speed delta / sqrt(speed^2 - g^2).
fn dips_within(ray: &Meridian, slope: f64, outer: f64, [lo, hi]: [f64; 2]) -> bool {
    let g = slope * ray.dz;
    let rest = ray.speed * ray.speed - g * g;
    if rest <= 0.0 {
        return false;
    }
    let scale = (ray.delta2 / rest).sqrt();
    let t = (g * scale - ray.offset) / ray.speed;
    lo < t && t < hi && ray.speed * scale <= slope * (ray.oz + t * ray.dz) + outer
}

/// Where a stretch of the ray lies between two cones.
#[inline]
pub(super) fn cone_intervals(
    slope: f64,
    offsets: [f64; 2],
    ray: &Meridian,
    stretch: [f64; 2],
) -> Intervals {
    let [inner, outer] = offsets.map(|offset| inside_cone(slope, offset, ray));
    Intervals::between(stretch, outer, inner)
}

/// Where the ray lies inside a cone, rho <= L with L = slope z + offset: an interval, as rho is
/// convex.
///
/// Squared this becomes U t^2 + 2 V t + W <= 0, which also holds inside the other nappe, rho <= -L
/// (equation 11 of the paper, in ray parameters). With l the value of L at t = 0, g its derivative
/// and rho^2 = X^2 + delta^2, the discriminant is (speed l - g X(0))^2 - delta^2 U.
fn inside_cone(slope: f64, offset: f64, ray: &Meridian) -> Option<[f64; 2]> {
    const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    let (a, b, c) = ray.squared_distance();
    let (l, g) = (slope * ray.oz + offset, slope * ray.dz);
    let (u, v, w) = (a - g * g, b - g * l, c - l * l);
    let across = ray.speed * l - g * ray.offset;
    let discriminant = across * across - ray.delta2 * u;
    if u > 0.0 {
        // Both roots lie on one nappe: between them rho <= |L|, so that L does not vanish.
        let [t0, t1] = roots(u, v, w, discriminant)?;
        return (l + g * (0.5 * t0 + 0.5 * t1) >= 0.0).then_some([t0, t1]);
    }
    if g == 0.0 {
        // Parallel to the axis and to the wall.
        return (l >= 0.0 && w <= 0.0).then_some(EVERYWHERE);
    }
    // The ray is at least as steep as the cone, and inside each nappe from one root on.
    let [below, above] = if u < 0.0 {
        roots(-u, -v, -w, discriminant.max(0.0))?
    } else {
        // As steep as the cone: it enters one nappe, at the root of 2 V t + W.
        let t = -0.5 * w / v;
        if v < 0.0 { [f64::NEG_INFINITY, t] } else { [t, f64::INFINITY] }
    };
    Some(if g > 0.0 { [above, f64::INFINITY] } else { [f64::NEG_INFINITY, below] })
}

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

    /// The cylinder shell round some pieces, as two cones of slope 0: the same region but for the
    /// padding, and the same test as any other cone shell.
    pub(crate) fn upright(pieces: &[Piece], radius: f64) -> Self {
        let ([low, high], pad) = (ends(pieces, |p| p.r), padding(radius));
        Self { z: heights(pieces, radius), slope: 0.0, offsets: [low - pad, high + pad] }
    }

    /// The shell round some pieces; where the chord is horizontal, the upright one.
    pub(crate) fn or_upright(pieces: &[Piece], radius: f64) -> Self {
        Self::around(pieces, radius).unwrap_or_else(|| Self::upright(pieces, radius))
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
        let [inner, outer] = self.offsets.map(|offset| inside_cone(self.slope, offset, ray));
        Intervals::between(stretch, outer, inner)
    }
}

/// The walls of a cone along a ray: with L = slope z + offset, l its value at t = 0 and g its
/// derivative by t, and rho^2 = X^2 + delta^2, rho <= L becomes
///
/// ```text
/// U t^2 + 2 V t + W <= 0,   U = speed^2 - g^2,   V = speed X(0) - g l,   W = rho(0)^2 - l^2,
/// V^2 - U W = (speed l - g X(0))^2 - delta^2 U
/// ```
///
/// (equation 11 of the paper, in ray parameters). The other nappe, rho <= -L, satisfies it too. Where
/// U > 0 both roots lie on one nappe, and in their middle L has the sign of speed l - g X(0).
struct Crossing {
    l: f64,
    g: f64,
    u: f64,
    v: f64,
    /// speed l - g X(0).
    across: f64,
    discriminant: f64,
}

impl Crossing {
    #[inline]
    fn new(slope: f64, offset: f64, ray: &Meridian) -> Self {
        let (l, g) = (slope * ray.oz + offset, slope * ray.dz);
        let u = ray.speed * ray.speed - g * g;
        let v = ray.speed * ray.offset - g * l;
        let across = ray.speed * l - g * ray.offset;
        Self { l, g, u, v, across, discriminant: across * across - ray.delta2 * u }
    }

    /// Whether a ray that is outside the cone at both ends of a stretch is inside it in between.
    #[inline]
    fn dips_between(&self, [lo, hi]: [f64; 2]) -> bool {
        // The middle between the roots, -V / U, lies within the stretch.
        self.u > 0.0
            && self.across >= 0.0
            && self.discriminant >= 0.0
            && self.u * lo + self.v < 0.0
            && self.u * hi + self.v > 0.0
    }
}

/// Whether a stretch of the ray has a point between two cones.
#[inline]
fn between_cones(slope: f64, [inner, outer]: [f64; 2], ray: &Meridian, [lo, hi]: [f64; 2]) -> bool {
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
    (beyond(0) || beyond(1))
        && (within(0) || within(1) || Crossing::new(slope, outer, ray).dips_between([lo, hi]))
}

/// Where the ray lies inside a cone, rho <= slope z + offset: an interval, as rho is convex.
fn inside_cone(slope: f64, offset: f64, ray: &Meridian) -> Option<[f64; 2]> {
    let Crossing { l, g, u, v, across, discriminant } = Crossing::new(slope, offset, ray);
    let (_, _, c) = ray.squared_distance();
    let w = c - l * l;
    if u > 0.0 {
        return if across >= 0.0 { roots(u, v, w, discriminant) } else { None };
    }
    if g == 0.0 {
        // Parallel to the axis and to the wall.
        let inside = l >= 0.0 && w <= 0.0;
        return inside.then_some([f64::NEG_INFINITY, f64::INFINITY]);
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

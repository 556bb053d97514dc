//! Box and strip, BS: the cylinder shell cut with a strip along the chord in the plane (z, rho^2),
//! that is, with the region between two paraboloids of revolution. As tight as a cone shell, and its
//! test needs no square root.

use super::interval::{Intervals, sublevel};
use super::{Cylinder, Shell, padding, slab};
use crate::meridian::Meridian;
use crate::piece::{Kind, Piece};

/// A cylinder shell with `low <= rho^2 - p z <= high`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strip {
    pub(crate) cylinder: Cylinder,
    pub(crate) p: f64,
    pub(crate) range: [f64; 2],
}

impl Strip {
    /// The shell round some frusta.
    pub(crate) fn around(frusta: &[Piece], radius: f64) -> Self {
        let cylinder = Cylinder::around(frusta, radius);
        let p = match (frusta.first(), frusta.last()) {
            (Some(first), Some(last)) => {
                let (a, b) = (first.start(), last.end());
                (b.r - a.r) * (b.r + a.r) / (b.z - a.z)
            }
            _ => 0.0,
        };
        // On a horizontal chord the box alone is as good.
        let p = if p.is_finite() { p } else { 0.0 };
        let [low, high] = range_over(frusta, 1.0, -p);
        let pad = padding(radius) * (radius + p.abs());
        Self { cylinder, p, range: [low - pad, high + pad] }
    }
}

impl Shell for Strip {
    #[inline]
    fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
        let [lo, hi] = slab(self.cylinder.z, ray, range)?;
        let x = [ray.offset + ray.speed * lo, ray.offset + ray.speed * hi];
        let w = x.map(|x| x * x + ray.delta2);
        let turns = x[0] < 0.0 && x[1] > 0.0;
        let nearest = if turns { ray.delta2 } else { w[0].min(w[1]) };
        let [w0, w1] = self.cylinder.w;
        if !(w[0].max(w[1]) >= w0 && nearest <= w1) {
            return None;
        }
        // D = rho^2 - p z along the ray, and half its derivative at the ends.
        let d = [w[0] - self.p * (ray.oz + lo * ray.dz), w[1] - self.p * (ray.oz + hi * ray.dz)];
        let fall = 0.5 * self.p * ray.dz;
        let slopes = x.map(|x| ray.speed * x - fall);
        let met = d[0].max(d[1]) >= self.range[0]
            && (d[0].min(d[1]) <= self.range[1]
                || (slopes[0] < 0.0 && slopes[1] > 0.0 && {
                    // The vertex: D = d - D'^2 / (4 a).
                    let a = ray.speed * ray.speed;
                    d[0] - slopes[0] * slopes[0] / a <= self.range[1]
                }));
        met.then_some([lo, hi])
    }

    fn intervals(&self, ray: &Meridian, stretch: [f64; 2]) -> Intervals {
        let (a, b, c) = ray.squared_distance();
        let (b, c) = (b - 0.5 * self.p * ray.dz, c - self.p * ray.oz);
        let [inner, outer] = self.range.map(|d| sublevel(a, b, c - d));
        Intervals::between(stretch, outer, inner)
    }
}

/// The smallest and the largest value of q rho^2 + p z on some frusta, for q >= 0: convex on each of
/// them, so that the largest occurs at an end and the smallest there or where it turns.
pub(super) fn range_over(frusta: &[Piece], q: f64, p: f64) -> [f64; 2] {
    let value = |r: f64, z: f64| q * (r * r) + p * z;
    frusta.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], frustum| {
        debug_assert_eq!(frustum.kind, Kind::Line);
        let (a, b) = (frustum.start(), frustum.end());
        let (dr, dz) = (b.r - a.r, b.z - a.z);
        let (first, last) = (value(a.r, a.z), value(b.r, b.z));
        // The derivative by s, halved: q r dr + p dz / 2 = 0.
        let s = -(q * a.r * dr + 0.5 * p * dz) / (q * dr * dr);
        let turn = if 0.0 < s && s < 1.0 { value(a.r + s * dr, a.z + s * dz) } else { first };
        [low.min(first).min(last).min(turn), high.max(first).max(last)]
    })
}

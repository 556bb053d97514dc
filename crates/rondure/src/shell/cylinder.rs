//! The cylinder shell, CY (paper, section 3.1): two coaxial cylinders and two planes; a box in
//! (z, rho^2).

use super::interval::{Intervals, sublevel};
use super::{Shell, ends, heights, padding, slab};
use crate::meridian::Meridian;
use crate::piece::Piece;

/// `z0 <= z <= z1` and `w0 <= rho^2 <= w1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cylinder {
    pub(crate) z: [f64; 2],
    pub(crate) w: [f64; 2],
}

impl Cylinder {
    /// The shell round some pieces.
    pub(crate) fn around(pieces: &[Piece], radius: f64) -> Self {
        let r = ends(pieces, |p| p.r);
        let pad = padding(radius) * radius;
        Self { z: heights(pieces, radius), w: [r[0] * r[0] - pad, r[1] * r[1] + pad] }
    }
}

impl Shell for Cylinder {
    #[inline]
    fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
        slab(self.z, ray, range).filter(|stretch| between_cylinders(self.w, ray, *stretch))
    }

    fn intervals(&self, ray: &Meridian, stretch: [f64; 2]) -> Intervals {
        let (a, b, c) = ray.squared_distance();
        let [inner, outer] = self.w.map(|w| sublevel(a, b, c - w));
        Intervals::between(stretch, outer, inner)
    }
}

/// Whether a stretch of the ray has a point between two cylinders, given by their squared radii.
#[inline]
fn between_cylinders([w0, w1]: [f64; 2], ray: &Meridian, [lo, hi]: [f64; 2]) -> bool {
    let x = [ray.offset + ray.speed * lo, ray.offset + ray.speed * hi];
    let w = x.map(|x| x * x + ray.delta2);
    let turns = x[0] < 0.0 && x[1] > 0.0;
    let nearest = if turns { ray.delta2 } else { w[0].min(w[1]) };
    w[0].max(w[1]) >= w0 && nearest <= w1
}

//! The hits at eight spots at once, each on a leaf of its own: what [`leaf`](super::leaf) does for one, for batches.
//!
//! Each number of eight rays and spots is a vector; curves come as rows, which are turned into columns.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::leaf::{LAST_STEP2, ROUNDING};
use crate::numeric::UNIT_ROUNDOFF;

/// How many spots are looked at together.
pub(super) const WIDTH: usize = 8;

/// As many steps are taken; what needs more is left to be answered one by one.
const MOST_STEPS: u32 = 4;

/// Eight rays, in columns, each with a spot that it is to hit.
pub(super) struct Aim<S: Simd> {
    /// The curves, by powers.
    pub(super) curve: [f64x8<S>; WIDTH],
    pub(super) origin: [f64x8<S>; 3],
    pub(super) direction: [f64x8<S>; 3],
    pub(super) length2: f64x8<S>,
    pub(super) far: f64x8<S>,
    /// The ray's own parameter is tau + shift.
    pub(super) shift: f64x8<S>,
    /// About which parameters on the curves, and on the rays.
    pub(super) s: f64x8<S>,
    pub(super) tau: f64x8<S>,
    /// How far off the latter may be.
    pub(super) blur: f64x8<S>,
    /// Between which parameters on the rays hits count,
    pub(super) range: [f64x8<S>; 2],
    /// and between which on the curves what is known of the spots holds.
    pub(super) valid: [f64x8<S>; 2],
    /// The squares of the longest steps in s that can be the last, where r is 1 or more.
    pub(super) last2: f64x8<S>,
}

/// Where Newton's steps led.
pub(super) struct Landing<S: Simd> {
    /// In which lanes that is a hit for certain, as a set of bits.
    pub(super) certain: u32,
    pub(super) s: f64x8<S>,
    /// In the ray's own parameter.
    pub(super) t: f64x8<S>,
    /// How far off rounding may put that.
    pub(super) margin: f64x8<S>,
}

impl<S: Simd> Aim<S> {
    /// Takes Newton's steps, until they are done in all the lanes that are wanted or there have been [`MOST_STEPS`]; curves are all
    /// conics or none is.
    #[inline(always)]
    pub(super) fn hit(&self, simd: S, conic: bool, wanted: u32) -> Landing<S> {
        if conic { self.hit_on::<true>(simd, wanted) } else { self.hit_on::<false>(simd, wanted) }
    }

    #[inline(always)]
    fn hit_on<const CONIC: bool>(&self, simd: S, wanted: u32) -> Landing<S> {
        let ([ox, oy, oz], [dx, dy, dz]) = (self.origin, self.direction);
        let (half, one, zero) = (splat(simd, 0.5), splat(simd, 1.0), splat(simd, 0.0));
        let (spot, mut s, mut tau) = (self.tau, self.s, self.tau);
        let (mut per, mut along, mut across) = (zero, zero, zero);
        let mut last = 0;
        for step in 0..MOST_STEPS {
            let [r, dr, z, drop] = self.at::<CONIC>(one, s);
            let (x, y) = (dx.mul_add(tau, ox), dy.mul_add(tau, oy));
            let f = (-dz).mul_add(tau, z - oz);
            let g = half * ((x * x + y * y) - r * r);
            let rho = x * dx + y * dy;
            let w = r * dr;
            per = one / drop.mul_sub(rho, w * dz);
            let by_s = f.mul_add(rho, dz * g) * per;
            let by_tau = drop.mul_add(g, w * f) * per;
            s -= by_s;
            tau -= by_tau;
            // One is never enough.
            if step == 0 {
                continue;
            }
            along = dz.abs().mul_add(r, rho.abs());
            across = r * (dr.abs() + drop.abs());
            let least = r.min(one);
            let is_last = (by_s * by_s).simd_le(self.last2 * least)
                & (by_tau * by_tau * self.length2).simd_le(splat(simd, LAST_STEP2) * least);
            last = is_last.to_bitmask() as u32;
            if wanted & !last == 0 {
                break;
            }
        }
        let rounding = (self.far + splat(simd, 2.0)) * splat(simd, ROUNDING) * per.abs();
        let (off_s, off) = (rounding * along, rounding * across);
        let off = (tau.abs() + self.shift.abs()).mul_add(splat(simd, 4.0 * UNIT_ROUNDOFF), off);
        let is = (tau - spot).abs().simd_le(self.blur + self.blur)
            & s.simd_ge(self.valid[0])
            & s.simd_le(self.valid[1])
            & s.simd_gt(off_s)
            & s.simd_lt(one - off_s)
            & tau.simd_gt(self.range[0] + off)
            & tau.simd_lt(self.range[1] - off);
        let t = tau + self.shift;
        Landing { certain: is.to_bitmask() as u32 & last & wanted, s, t, margin: off }
    }

    /// r, r', z and z', as [`Curve`](super::leaf::Curve) has them.
    #[inline(always)]
    fn at<const CONIC: bool>(&self, one: f64x8<S>, s: f64x8<S>) -> [f64x8<S>; 4] {
        let [r0, r1, r2, r3, z0, z1, z2, z3] = self.curve;
        if CONIC {
            let q = r3;
            let per = one / (q * s).mul_add(one - s, one);
            let slope = q - (q + q) * s;
            let (last_r, last_z) = (r2 * s, z2 * s);
            let r = (last_r + r1).mul_add(s, r0) * per;
            let z = (last_z + z1).mul_add(s, z0) * per;
            let dr = (last_r + last_r + r1 - r * slope) * per;
            let dz = (last_z + last_z + z1 - z * slope) * per;
            return [r, dr, z, dz];
        }
        let (inner_r, inner_z) = (r3.mul_add(s, r2), z3.mul_add(s, z2));
        let r = inner_r.mul_add(s, r1).mul_add(s, r0);
        let z = inner_z.mul_add(s, z1).mul_add(s, z0);
        let dr = r3.mul_add(s, inner_r + inner_r).mul_add(s, r1);
        let dz = z3.mul_add(s, inner_z + inner_z).mul_add(s, z1);
        [r, dr, z, dz]
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> f64x8<S> {
    f64x8::splat(simd, value)
}

/// Rows as columns.
#[inline(always)]
pub(super) fn columns<S: Simd>(simd: S, rows: [&[f64; WIDTH]; WIDTH]) -> [f64x8<S>; WIDTH] {
    let [a, b, c, d, e, f, g, h] = rows;
    let mut columns = [splat(simd, 0.0); WIDTH];
    for (i, column) in columns.iter_mut().enumerate() {
        let numbers = [a[i], b[i], c[i], d[i], e[i], f[i], g[i], h[i]];
        *column = f64x8::from_slice(simd, &numbers);
    }
    columns
}

//! The hits at eight spots at once, each on a leaf of its own: what [`leaf`](super::leaf) does for one, for batches.
//!
//! Spots come as rows, which are turned into columns; then each number of eight spots is a vector.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::leaf::{LAST_STEP2, ROUNDING};
use crate::numeric::UNIT_ROUNDOFF;

/// How many spots are looked at together.
pub(super) const WIDTH: usize = 8;

/// Eight spots, each on a leaf that is no conic, with a row for each; all are in the range without a shift.
#[repr(C, align(64))]
pub(super) struct Eight {
    /// The curves, by powers.
    pub(super) curves: [[f64; WIDTH]; WIDTH],
    /// Origins, directions, squared lengths, and how far the origins are.
    pub(super) rays: [[f64; WIDTH]; WIDTH],
    /// The first guesses of s and tau, the blur, the ends of the range of tau and of that of s.
    pub(super) spots: [[f64; WIDTH]; WIDTH],
    /// s and tau of the hits.
    pub(super) found: [[f64; WIDTH]; 2],
}

impl Eight {
    pub(super) const EMPTY: Self = Self {
        curves: [[0.0; WIDTH]; WIDTH],
        rays: [[0.0; WIDTH]; WIDTH],
        spots: [[0.0; WIDTH]; WIDTH],
        found: [[0.0; WIDTH]; 2],
    };

    /// Finds hits as [`Leaf::hit`](super::leaf::Leaf::hit) does; says which were found, as a set of bits.
    #[inline(always)]
    pub(super) fn hits<S: Simd>(&mut self, simd: S) -> u32 {
        let [r0, r1, r2, r3, z0, z1, z2, z3] = columns(simd, &self.curves);
        let [ox, oy, oz, dx, dy, dz, length2, far] = columns(simd, &self.rays);
        let [guess, spot, blur, start, end, low, high, _] = columns(simd, &self.spots);
        let half = f64x8::splat(simd, 0.5);
        let (mut s, mut tau) = (guess, spot);
        let (mut by_s, mut by_tau) = (guess, spot);
        let (mut per, mut along, mut across, mut radius) = (guess, guess, guess, guess);
        for _ in 0..2 {
            let (inner_r, inner_z) = (r3.mul_add(s, r2), z3.mul_add(s, z2));
            let r = inner_r.mul_add(s, r1).mul_add(s, r0);
            let z = inner_z.mul_add(s, z1).mul_add(s, z0);
            let dr = r3.mul_add(s, inner_r + inner_r).mul_add(s, r1);
            let drop = z3.mul_add(s, inner_z + inner_z).mul_add(s, z1);
            let (x, y) = (dx.mul_add(tau, ox), dy.mul_add(tau, oy));
            let f = (-dz).mul_add(tau, z - oz);
            let g = half * ((x * x + y * y) - r * r);
            let rho = x * dx + y * dy;
            let w = r * dr;
            per = f64x8::splat(simd, 1.0) / drop.mul_sub(rho, w * dz);
            by_s = f.mul_add(rho, dz * g) * per;
            by_tau = drop.mul_add(g, w * f) * per;
            s -= by_s;
            tau -= by_tau;
            along = dz.abs().mul_add(r, rho.abs());
            across = r * (dr.abs() + drop.abs());
            radius = r;
        }
        let last2 = f64x8::splat(simd, LAST_STEP2) * radius.min(f64x8::splat(simd, 1.0));
        let rounding = (far + f64x8::splat(simd, 2.0)) * f64x8::splat(simd, ROUNDING) * per.abs();
        let (off_s, off) = (rounding * along, rounding * across);
        let off = tau.abs().mul_add(f64x8::splat(simd, 4.0 * UNIT_ROUNDOFF), off);
        let is = (by_s * by_s).simd_le(last2)
            & (by_tau * by_tau * length2).simd_le(last2)
            & (tau - spot).abs().simd_le(blur + blur)
            & s.simd_ge(low)
            & s.simd_le(high)
            & s.simd_gt(off_s)
            & s.simd_lt(f64x8::splat(simd, 1.0) - off_s)
            & tau.simd_gt(start + off)
            & tau.simd_lt(end - off);
        s.store_array(&mut self.found[0]);
        tau.store_array(&mut self.found[1]);
        is.to_bitmask() as u32
    }
}

/// Rows as columns: three perfect shuffles.
#[inline(always)]
fn columns<S: Simd>(simd: S, rows: &[[f64; WIDTH]; WIDTH]) -> [f64x8<S>; WIDTH] {
    let zero = f64x8::splat(simd, 0.0);
    let mut c = [zero; WIDTH];
    for (column, row) in c.iter_mut().zip(rows) {
        *column = f64x8::from_slice(simd, row);
    }
    for _ in 0..3 {
        let (a, b) = c[0].interleave(c[4]);
        let (d, e) = c[1].interleave(c[5]);
        let (f, g) = c[2].interleave(c[6]);
        let (h, i) = c[3].interleave(c[7]);
        c = [a, b, d, e, f, g, h, i];
    }
    c
}

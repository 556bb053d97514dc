//! Eight leaves at once: where a ray meets the quadrics beside them.
//!
//! With zeta0 the ray's height at tau = 0 above the middle of a leaf, Q along the ray is
//! U tau^2 + 2 V tau + W:
//!
//! ```text
//! H = beta / 2 + p zeta0        U = alpha a + p dz^2
//!                               V = alpha b + dz H
//!                               W = alpha c + zeta0 (H + beta / 2) + gamma
//! ```
//!
//! Let the curve be off by `e` at the most: |Q| <= e on it. Where |Q| <= e along the ray, Q' is at least
//! 2 sqrt(V^2 - U W - |U| e). If that is more than the curve's own h' lambda' (see
//! [`quadric`](super::quadric)), the ray crosses the leaf once at the most about each of the two roots,
//! no farther from it than e / sqrt(V^2 - U W); that is so beyond `tangency`. Below minus that there is no
//! crossing. Between the two the ray may be tangent, which is left to the exact engine.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::course::{Course, NEAR};
use super::quadric::Quadric;
use crate::numeric::UNIT_ROUNDOFF;

/// How many leaves are tested at once.
pub(super) const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Eight leaves.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    z: Lanes,
    alpha: Lanes,
    half_beta: Lanes,
    gamma: Lanes,
    p: Lanes,
    lambda: [Lanes; 3],
    /// The largest |zeta|.
    height: Lanes,
    /// For a direction of length 1; it grows with the square of the length.
    tangency: Lanes,
    /// It grows with |U|, too.
    bend: Lanes,
    /// By how much lambda may be off, times sqrt(V^2 - U W), for a direction of length 1.
    room: Lanes,
    /// The same for tau, for any length.
    blur: Lanes,
}

/// What was found of eight leaves.
pub(super) struct Meeting<S: Simd> {
    /// The two roots, the first one less than the second, how far off each may be, and the least that
    /// they may be.
    pub(super) tau: [f64x8<S>; 2],
    pub(super) blur: f64x8<S>,
    pub(super) low: [f64x8<S>; 2],
    /// lambda there.
    pub(super) lambda: [f64x8<S>; 2],
    /// Which leaves may have a hit at the first root, and above those eight bits, at the second one; no
    /// more than one each.
    pub(super) may: u32,
    /// Which leaves have one for certain, if that was asked for.
    pub(super) sure: u32,
    /// Which leaves the ray may be tangent to.
    pub(super) tangent: u32,
}

impl Block {
    pub(super) const EMPTY: Self = Self {
        z: [0.0; LANES],
        alpha: [0.0; LANES],
        half_beta: [0.0; LANES],
        gamma: [0.0; LANES],
        p: [0.0; LANES],
        lambda: [[0.0; LANES]; 3],
        height: [0.0; LANES],
        // Q vanishes everywhere: the discriminant is never more, nor less, than nothing.
        tangency: [-1.0; LANES],
        bend: [0.0; LANES],
        room: [0.0; LANES],
        blur: [0.0; LANES],
    };

    /// `radius` is a bound on the distance of the leaves from the centre.
    pub(super) fn set(&mut self, lane: usize, q: &Quadric, radius: f64) {
        let (a, b, c, p) = (q.alpha.abs(), q.beta.abs(), q.gamma.abs(), q.p.abs());
        // Neither origins nor hits are farther away than that, nor is zeta larger.
        let far = NEAR + radius;
        // No term of U tau^2 + 2 V tau + W is larger than this, and the roundings are fewer than 64.
        let largest = far * far * (a + p) + far * b + c;
        let error = 1.01 * q.error + 64.0 * UNIT_ROUNDOFF * largest;
        let growth = q.growth();
        let steepest = 0.5 * q.slope * growth;
        let v_most = far * (a + p) + b;
        let rounding = 64.0 * UNIT_ROUNDOFF * v_most * v_most;
        let tangency = 1.01 * steepest * steepest + rounding;
        let finite = |v: f64| if v.is_finite() { v } else { 1e200 };
        let room = error * growth + 64.0 * UNIT_ROUNDOFF * v_most;
        self.z[lane] = q.z;
        self.alpha[lane] = q.alpha;
        self.half_beta[lane] = 0.5 * q.beta;
        self.gamma[lane] = q.gamma;
        self.p[lane] = q.p;
        for (lanes, own) in self.lambda.iter_mut().zip(q.lambda) {
            lanes[lane] = own;
        }
        self.height[lane] = q.height + 16.0 * UNIT_ROUNDOFF * far;
        self.tangency[lane] = finite(tangency);
        self.bend[lane] = finite(2.0 * error);
        self.room[lane] = finite(1.01 * room);
        self.blur[lane] = finite(1.01 * error);
    }

    /// Which of the leaves the ray may hit before `end`, and about where.
    #[inline(always)]
    pub(super) fn test<S: Simd, const SURE: bool>(
        &self,
        simd: S,
        ray: &Course,
        end: f64,
    ) -> Meeting<S> {
        let (dz, b) = (-ray.direction.z, -ray.b);
        let (alpha, p) = (load(simd, &self.alpha), load(simd, &self.p));
        let half_beta = load(simd, &self.half_beta);
        let zeta = splat(simd, ray.origin.z) - load(simd, &self.z);
        let h = p.mul_add(zeta, half_beta);
        let u = p.mul_add(splat(simd, dz * dz), alpha * splat(simd, ray.a));
        // -V
        let v = h.mul_add(splat(simd, dz), alpha * splat(simd, b));
        let w = alpha.mul_add(splat(simd, ray.c), load(simd, &self.gamma));
        let w = zeta.mul_add(h + half_beta, w);
        let discriminant = v.mul_sub(v, u * w);
        let tangency = load(simd, &self.tangency) * splat(simd, ray.length2);
        let tangency = load(simd, &self.bend).mul_add(u.abs(), tangency);
        let steep = discriminant.simd_gt(tangency);
        let root = discriminant.sqrt();
        let q = v + root.copysign(v);
        let (tau_a, tau_b) = (q / u, w / q);
        let (near, far) = (tau_a.min(tau_b), tau_a.max(tau_b));
        let per_root = reciprocal(root);
        let one = splat(simd, 1.0);
        let room = (load(simd, &self.room) * splat(simd, ray.length2.sqrt())).mul_add(per_root, one);
        let blur = load(simd, &self.blur) * per_root;
        // lambda as a quadratic in tau.
        let [l0, l1, l2] = &self.lambda;
        let (lz, lw) = (load(simd, l0), load(simd, l1));
        let l0 = lz.mul_add(zeta, lw.mul_add(splat(simd, ray.c), load(simd, l2)));
        let l1 = lz.mul_add(splat(simd, ray.direction.z), lw * splat(simd, ray.b + ray.b));
        let l2 = lw * splat(simd, ray.a);
        let at_near = l2.mul_add(near, l1).mul_add(near, l0);
        let at_far = l2.mul_add(far, l1).mul_add(far, l0);
        // Another point of the quadric with the same lambda has another height.
        let height = splat(simd, dz.abs()).mul_add(blur, load(simd, &self.height));
        let dz = splat(simd, ray.direction.z);
        let near_height = dz.mul_add(near, zeta).abs().simd_le(height);
        let far_height = dz.mul_add(far, zeta).abs().simd_le(height);
        let (start, end) = (splat(simd, ray.range[0]), splat(simd, end));
        let near_ends = [near - blur, near + blur];
        let far_ends = [far - blur, far + blur];
        let may = [
            steep
                & near_height
                & at_near.abs().simd_le(room)
                & near_ends[1].simd_ge(start)
                & near_ends[0].simd_le(end),
            steep
                & far_height
                & at_far.abs().simd_le(room)
                & far_ends[1].simd_ge(start)
                & far_ends[0].simd_le(end),
        ];
        let mut sure = 0;
        if SURE {
            let room = one + one - room;
            let first = may[0]
                & at_near.abs().simd_le(room)
                & near_ends[0].simd_ge(start)
                & near_ends[1].simd_le(end);
            let second = may[1]
                & at_far.abs().simd_le(room)
                & far_ends[0].simd_ge(start)
                & far_ends[1].simd_le(end);
            sure = (first | second).to_bitmask() as u32;
        }
        // Also where one is not a number.
        let clear = steep | discriminant.simd_lt(-tangency);
        let mut tangent = !clear.to_bitmask() as u32 & 0xff;
        if tangent != 0 {
            // Where it would be, how far round it, and whether the leaf is there.
            let middle = v / u;
            let around = ((tangency + tangency).sqrt() + load(simd, &self.blur)) / u.abs();
            let slope = l1.abs() + (l2 + l2).abs() * (middle.abs() + around);
            let lambda = l2.mul_add(middle, l1).mul_add(middle, l0).abs() - slope * around;
            let away = lambda.simd_gt(splat(simd, 1.125))
                | (middle + around).simd_lt(start)
                | (middle - around).simd_gt(end);
            tangent &= !away.to_bitmask() as u32;
        }
        let low = [near_ends[0], far_ends[0]];
        let may = (may[0].to_bitmask() | may[1].to_bitmask() << LANES) as u32;
        Meeting { tau: [near, far], blur, low, lambda: [at_near, at_far], may, sure, tangent }
    }
}

/// One over a number; on all but AVX-512 that is a division.
#[inline(always)]
fn reciprocal<S: Simd>(x: f64x8<S>) -> f64x8<S> {
    x.approximate_recip()
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &Lanes) -> f64x8<S> {
    f64x8::from_slice(simd, lanes)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> f64x8<S> {
    f64x8::splat(simd, value)
}

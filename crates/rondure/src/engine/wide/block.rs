//! Eight leaves at once: where a ray meets the quadrics beside them, in f32.
//!
//! The ray begins where it enters the box round the block, and heights and squared radii count from a corner
//! of that box: no number is then larger than the block demands, and f32 is good to a few millionths of it. With
//! zeta0 the ray's height there above the middle of a leaf, Q along the ray is U tau^2 + 2 V tau + W:
//!
//! ```text
//! H = beta / 2 + p zeta0        U = alpha a + p dz^2
//!                               V = alpha b + dz H
//!                               W = alpha c + zeta0 (H + beta / 2) + gamma
//! ```
//!
//! Let Q be off by `e` at the most: the fit's error and the rounding of f32. Where |Q| <= e along the ray, Q' is
//! at least 2 sqrt(V^2 - U W - |U| e). If that is more than the curve's own h' lambda' (see
//! [`quadric`](super::quadric)), the ray crosses the leaf once at the most about each of the two roots,
//! no farther from it than e / sqrt(V^2 - U W); that is so beyond `tangency`. Below minus that there is no
//! crossing. Between the two the ray may be tangent, which is left to the exact engine.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::boxes::{Extent, PADDING};
use super::course::Course;
use super::quadric::Quadric;
use crate::numeric::UNIT_ROUNDOFF;

/// How many leaves are tested at once.
pub(super) const LANES: usize = 8;

/// The unit roundoff of f32.
const ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;

/// What f32 holds the products of.
const LARGEST: f64 = 1e12;
/// Bounds are raised by this: more than their own roundings, and than the error of an approximate reciprocal,
/// which is good to 2^-11 at least.
const SLACK: f64 = 1.01;
/// Beyond this lambda a leaf's quadric need not be near the curve (see [`quadric`](super::quadric)), which has ended long
/// before.
const BEYOND: f32 = 1.125;
/// More than any discriminant, and than any error that matters.
const UNKNOWN: f32 = 1e30;

/// How far off rounding may put a hit of the exact engine, of a radius of at most 2.
const EXACT: f64 = 128.0 * UNIT_ROUNDOFF;

type Lanes = [f32; LANES];

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
    /// From where z and w count.
    corner: [f64; 2],
}

/// What was found of eight leaves.
pub(super) struct Meeting<S: Simd> {
    /// Where tau counts from.
    pub(super) origin: f64,
    /// The two roots, the first one less than the second, how far off each may be, and the least that
    /// they may be.
    pub(super) tau: [f32x8<S>; 2],
    pub(super) blur: f32x8<S>,
    pub(super) low: [f32x8<S>; 2],
    /// lambda there.
    pub(super) lambda: [f32x8<S>; 2],
    /// Which leaves may have a hit at the first root, and above those eight bits, at the second one; no
    /// more than one each.
    pub(super) may: u32,
    /// Which leaves have one for certain, if that was asked for.
    pub(super) sure: u32,
    /// Which leaves the ray may be tangent to.
    pub(super) tangent: u32,
}

impl<S: Simd> Meeting<S> {
    /// Whether the ray misses all leaves.
    #[inline(always)]
    pub(super) fn misses(&self) -> bool {
        self.may | self.tangent == 0
    }
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
        corner: [0.0; 2],
    };

    /// A block of leaves within `extent`.
    pub(super) fn new<'a>(fits: impl Iterator<Item = &'a Quadric>, extent: &Extent) -> Self {
        let mut block = Self { corner: [extent.z[0], extent.w[0]], ..Self::EMPTY };
        for (lane, fit) in fits.enumerate().take(LANES) {
            block.set(lane, fit, extent);
        }
        block
    }

    fn set(&mut self, lane: usize, q: &Quadric, extent: &Extent) {
        let [z, w] = self.corner;
        let gamma = q.gamma + q.alpha * w;
        let (a, b, c, p) = (q.alpha.abs(), q.beta.abs(), gamma.abs(), q.p.abs());
        // The ray's origin and all hits lie in the box, which is padded.
        let height = (extent.z[1] - extent.z[0]) + 2.0 * PADDING[0];
        let depth = (extent.w[1] - extent.w[0]) + 2.0 * PADDING[1];
        let width = extent.w[1] + PADDING[1];
        let diameter = (4.0 * width + height * height).sqrt();
        // No terms of U tau^2 + 2 V tau + W are larger than these, with |zeta| <= height and
        // |b tau| <= 2 width, and fewer than 12 roundings go into each, those of the ray among them.
        let largest =
            a * (8.0 * width + depth) + 3.0 * (b * height) + 6.0 * (p * height * height) + c;
        // The exact engine may find hits that lie by its own roundings beside the ray.
        let error = SLACK * q.error + 12.0 * ROUNDOFF * largest + EXACT;
        let growth = q.growth();
        let all = [a, b, c, p, growth, q.lambda[0], q.lambda[1], q.lambda[2], q.slope, q.error];
        if !all.iter().all(|v| v.abs() < LARGEST) {
            // So short, or so curved, that f32 says nothing of it: it may always be hit.
            self.tangency[lane] = UNKNOWN;
            self.height[lane] = UNKNOWN;
            return;
        }
        let steepest = 0.5 * q.slope * growth;
        let v_most = a * width.sqrt() + b + 2.0 * (p * height);
        let w_most = a * depth + 2.0 * (b * height) + p * height * height + c;
        // The roundings of the discriminant, which may be larger than it.
        let tangency =
            SLACK * steepest * steepest + 16.0 * ROUNDOFF * (v_most * v_most + (a + p) * w_most);
        // No root of the discriminant is larger, and tau is off by its roundings, too.
        let most = v_most + ((a + p) * w_most).sqrt();
        let blur = error + 8.0 * ROUNDOFF * (diameter * most);
        let [lz, lw, l0] = q.lambda;
        let l0 = l0 + lw * w;
        let lambda_size = (lz * height).abs() + 8.0 * (lw * width).abs() + l0.abs();
        let room = blur * growth + 12.0 * ROUNDOFF * (lambda_size * most);
        let finite = |v: f64| if v < f64::from(UNKNOWN) { v as f32 } else { UNKNOWN };
        self.z[lane] = (q.z - z) as f32;
        self.alpha[lane] = q.alpha as f32;
        self.half_beta[lane] = (0.5 * q.beta) as f32;
        self.gamma[lane] = gamma as f32;
        self.p[lane] = q.p as f32;
        for (lanes, own) in self.lambda.iter_mut().zip([lz, lw, l0]) {
            lanes[lane] = own as f32;
        }
        self.height[lane] = (q.height + 8.0 * ROUNDOFF * height + EXACT) as f32;
        self.tangency[lane] = finite(SLACK * tangency);
        self.bend[lane] = finite(2.0 * SLACK * error);
        self.room[lane] = finite(SLACK * room);
        self.blur[lane] = finite(SLACK * blur);
    }

    /// Which of the leaves the ray may hit before `end`, and about where, if it enters the block's box at
    /// `origin`.
    #[inline(always)]
    pub(super) fn test<S: Simd, const SURE: bool>(
        &self,
        simd: S,
        ray: &Course,
        origin: f32,
        end: f64,
    ) -> Meeting<S> {
        let origin = f64::from(origin);
        let (own_a, own_b) = (ray.a as f32, ray.a * origin + ray.b);
        // w there, which is (own_b + b) origin + c.
        let own_c = ((own_b + ray.b) * origin + (ray.c - self.corner[1])) as f32;
        let own_z = (ray.direction.z * origin + (ray.origin.z - self.corner[0])) as f32;
        let (own_b, own_dz) = (own_b as f32, ray.direction.z as f32);
        let length2 = ray.length2 as f32;
        let [start, end] = [ray.range[0], end].map(|t| (t - origin) as f32);
        let (alpha, p) = (load(simd, &self.alpha), load(simd, &self.p));
        let half_beta = load(simd, &self.half_beta);
        let (a, b, c) = (splat(simd, own_a), splat(simd, own_b), splat(simd, own_c));
        let dz = splat(simd, own_dz);
        let zeta = splat(simd, own_z) - load(simd, &self.z);
        let h = p.mul_add(zeta, half_beta);
        let u = p.mul_add(splat(simd, own_dz * own_dz), alpha * a);
        // -V
        let v = h.mul_sub(-dz, alpha * b);
        let w = zeta.mul_add(h + half_beta, alpha.mul_add(c, load(simd, &self.gamma)));
        let discriminant = v.mul_sub(v, u * w);
        let tangency = load(simd, &self.tangency) * splat(simd, length2);
        let tangency = load(simd, &self.bend).mul_add(u.abs(), tangency);
        let steep = discriminant.simd_gt(tangency);
        let root = discriminant.sqrt();
        let q = v + root.copysign(v);
        let (tau_a, tau_b) = (q / u, w / q);
        let (near, far) = (tau_a.min(tau_b), tau_a.max(tau_b));
        let per_root = root.approximate_recip();
        let one = splat(simd, 1.0);
        let room = (load(simd, &self.room) * splat(simd, length2.sqrt())).mul_add(per_root, one);
        let blur = load(simd, &self.blur) * per_root;
        // lambda as a quadratic in tau.
        let [l0, l1, l2] = &self.lambda;
        let (lz, lw) = (load(simd, l0), load(simd, l1));
        let l0 = lz.mul_add(zeta, lw.mul_add(c, load(simd, l2)));
        let l1 = lz.mul_add(dz, lw * (b + b));
        let l2 = lw * a;
        let at_near = l2.mul_add(near, l1).mul_add(near, l0);
        let at_far = l2.mul_add(far, l1).mul_add(far, l0);
        // Another point of the quadric with the same lambda has another height.
        let height = dz.abs().mul_add(blur, load(simd, &self.height));
        let near_height = dz.mul_add(near, zeta).abs();
        let far_height = dz.mul_add(far, zeta).abs();
        let (start, end) = (splat(simd, start), splat(simd, end));
        let near_ends = [near - blur, near + blur];
        let far_ends = [far - blur, far + blur];
        let may = [
            steep
                & near_height.simd_le(height)
                & at_near.abs().simd_le(room)
                & near_ends[1].simd_ge(start)
                & near_ends[0].simd_le(end),
            steep
                & far_height.simd_le(height)
                & at_far.abs().simd_le(room)
                & far_ends[1].simd_ge(start)
                & far_ends[0].simd_le(end),
        ];
        let mut sure = 0;
        if SURE {
            let room = one + one - room;
            let height = (dz.abs() * blur).mul_add(splat(simd, -2.0), height);
            let first = may[0]
                & near_height.simd_le(height)
                & at_near.abs().simd_le(room)
                & near_ends[0].simd_ge(start)
                & near_ends[1].simd_le(end);
            let second = may[1]
                & far_height.simd_le(height)
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
            let zeta = dz.mul_add(middle, zeta).abs() - dz.abs() * around;
            let away = lambda.simd_gt(splat(simd, BEYOND))
                | zeta.simd_gt(load(simd, &self.height))
                | (middle + around).simd_lt(start)
                | (middle - around).simd_gt(end);
            tangent &= !away.to_bitmask() as u32;
        }
        let low = [near_ends[0], far_ends[0]];
        let may = (may[0].to_bitmask() | may[1].to_bitmask() << LANES) as u32;
        let lambda = [at_near, at_far];
        Meeting { origin, tau: [near, far], blur, low, lambda, may, sure, tangent }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &Lanes) -> f32x8<S> {
    f32x8::from_slice(simd, lanes)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

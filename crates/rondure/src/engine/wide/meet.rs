//! Where rays meet the quadrics beside leaves, in f32: one ray and eight leaves, or sixteen rays and one leaf.
//!
//! A ray begins where it enters the box round the block, and heights and squared radii count from a corner
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
use fearless_simd::{Simd, SimdFloat};

/// Beyond this lambda a leaf's quadric need not be near the curve (see [`quadric`](super::quadric)), which has ended long
/// before.
const BEYOND: f32 = 1.125;

/// Leaves, one in each lane or the same in all.
pub(super) struct Shells<V> {
    pub(super) z: V,
    pub(super) alpha: V,
    pub(super) half_beta: V,
    pub(super) gamma: V,
    pub(super) p: V,
    pub(super) lambda: [V; 3],
    pub(super) height: V,
    pub(super) tangency: V,
    pub(super) bend: V,
    pub(super) room: V,
    pub(super) blur: V,
}

/// Rays that have entered a block's box, one in each lane or the same in all.
pub(super) struct Beam<V> {
    /// w = a tau^2 + 2 b tau + c above the box's corner, and the height there, with tau from where the box is entered.
    pub(super) a: V,
    pub(super) b: V,
    pub(super) c: V,
    pub(super) z: V,
    pub(super) dz: V,
    pub(super) dz2: V,
    /// The length of the direction, and its square.
    pub(super) length: V,
    pub(super) length2: V,
    /// Between which parameters hits count.
    pub(super) range: [V; 2],
}

/// What was found, lane by lane.
pub(super) struct Meeting<V, M> {
    /// The two roots, the first one less than the second, how far off each may be, and the least that
    /// they may be.
    pub(super) tau: [V; 2],
    pub(super) blur: V,
    pub(super) low: [V; 2],
    /// lambda there.
    pub(super) lambda: [V; 2],
    /// In which lanes there may be a hit at the first root, and at the second one; no more than one each.
    pub(super) may: [u32; 2],
    /// The same.
    pub(super) masks: [M; 2],
    /// In which lanes there is one for certain, if that was asked for.
    pub(super) sure: u32,
    /// In which lanes the ray may be tangent.
    pub(super) tangent: u32,
    /// Where it may touch there, at the earliest; of no meaning elsewhere.
    pub(super) touch: V,
}

impl<V, M> Meeting<V, M> {
    /// Whether no lane has anything.
    #[inline(always)]
    pub(super) fn misses(&self) -> bool {
        !self.may_hit() && self.tangent == 0
    }

    /// Whether there may be a hit at a root.
    #[inline(always)]
    pub(super) fn may_hit(&self) -> bool {
        self.may[0] | self.may[1] != 0
    }
}

/// In which lanes a ray may hit a leaf, and about where.
#[inline(always)]
pub(super) fn meet<S: Simd, V: SimdFloat<S, Element = f32>, const SURE: bool>(
    simd: S,
    leaf: &Shells<V>,
    ray: &Beam<V>,
) -> Meeting<V, V::Mask> {
    let one = V::splat(simd, 1.0);
    let &Beam { a, b, c, dz, length2, .. } = ray;
    let [start, end] = ray.range;
    let zeta = ray.z - leaf.z;
    let h = leaf.p.mul_add(zeta, leaf.half_beta);
    let u = leaf.p.mul_add(ray.dz2, leaf.alpha * a);
    // -V
    let v = h.mul_sub(-dz, leaf.alpha * b);
    let w = zeta.mul_add(h + leaf.half_beta, leaf.alpha.mul_add(c, leaf.gamma));
    let discriminant = v.mul_sub(v, u * w);
    let tangency = leaf.bend.mul_add(u.abs(), leaf.tangency * length2);
    let steep = discriminant.simd_gt(tangency);
    let root = discriminant.sqrt();
    let q = v + root.copysign(v);
    let (tau_a, tau_b) = (q / u, w / q);
    let (near, far) = (tau_a.min(tau_b), tau_a.max(tau_b));
    let per_root = root.approximate_recip();
    let room = (leaf.room * ray.length).mul_add(per_root, one);
    let blur = leaf.blur * per_root;
    // lambda as a quadratic in tau.
    let [lz, lw, l0] = leaf.lambda;
    let l0 = lz.mul_add(zeta, lw.mul_add(c, l0));
    let l1 = lz.mul_add(dz, lw * (b + b));
    let l2 = lw * a;
    let at_near = l2.mul_add(near, l1).mul_add(near, l0);
    let at_far = l2.mul_add(far, l1).mul_add(far, l0);
    // Another point of the quadric with the same lambda has another height.
    let height = dz.abs().mul_add(blur, leaf.height);
    let near_height = dz.mul_add(near, zeta).abs();
    let far_height = dz.mul_add(far, zeta).abs();
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
        let height = (dz.abs() * blur).mul_add(V::splat(simd, -2.0), height);
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
    let mut tangent = (!clear).to_bitmask() as u32;
    let mut touch = start;
    if tangent != 0 {
        // Where it would be, how far round it, and whether the leaf is there.
        let middle = v / u;
        let around = ((tangency + tangency).sqrt() + leaf.blur) / u.abs();
        let slope = l1.abs() + (l2 + l2).abs() * (middle.abs() + around);
        let lambda = l2.mul_add(middle, l1).mul_add(middle, l0).abs() - slope * around;
        let zeta = dz.mul_add(middle, zeta).abs() - dz.abs() * around;
        let away = lambda.simd_gt(V::splat(simd, BEYOND))
            | zeta.simd_gt(leaf.height)
            | (middle + around).simd_lt(start)
            | (middle - around).simd_gt(end);
        touch = middle - around;
        tangent &= !away.to_bitmask() as u32;
    }
    Meeting {
        tau: [near, far],
        blur,
        low: [near_ends[0], far_ends[0]],
        lambda: [at_near, at_far],
        may: [may[0].to_bitmask() as u32, may[1].to_bitmask() as u32],
        masks: may,
        sure,
        tangent,
        touch,
    }
}

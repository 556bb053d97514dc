//! Sixteen leaves at once: where a ray meets the quadrics beside them, in f32.
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
//! Let Q be off by `e` in all: the fit's error and the rounding of f32. Where |Q| <= e, Q' is at least
//! 2 sqrt(V^2 - U W - |U| e). If that is more than the curve's own h' lambda' (see
//! [`quadric`](super::quadric)), the ray crosses the leaf once at the most about each of the two roots,
//! no farther from it than e / sqrt(V^2 - U W); that is so beyond `tangency`. Below minus that there is no
//! crossing. Between the two the ray may be tangent, which is left to the exact engine.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::course::Course;
use super::quadric::Quadric;

/// How many leaves or boxes are tested at once.
pub(super) const LANES: usize = 16;

/// The unit roundoff of f32.
const ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;

type Lanes = [f32; LANES];

/// Sixteen leaves.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    z: Lanes,
    alpha: Lanes,
    half_beta: Lanes,
    gamma: Lanes,
    p: Lanes,
    lambda: [Lanes; 3],
    tangency: Lanes,
    /// How far off, in lambda and in tau, times sqrt(V^2 - U W).
    room: Lanes,
    blur: Lanes,
}

/// A ray for these tests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    pub(super) a: f32,
    pub(super) b: f32,
    pub(super) c: f32,
    pub(super) oz: f32,
    pub(super) dz: f32,
    pub(super) length2: f32,
    pub(super) start: f32,
    pub(super) end: f32,
}

impl Probe {
    #[inline(always)]
    pub(super) fn new(course: &Course) -> Self {
        let (o, d) = (course.origin, course.direction);
        let a = d.x * d.x + d.y * d.y;
        Self {
            a: a as f32,
            b: (o.x * d.x + o.y * d.y) as f32,
            c: (o.x * o.x + o.y * o.y) as f32,
            oz: o.z as f32,
            dz: d.z as f32,
            length2: (a + d.z * d.z) as f32,
            start: course.range[0] as f32,
            end: course.range[1] as f32,
        }
    }
}

/// What was found of sixteen leaves.
pub(super) struct Meeting<S: Simd> {
    /// The two roots, the first one less than the second, and how far off each may be.
    pub(super) tau: [f32x16<S>; 2],
    pub(super) blur: f32x16<S>,
    /// lambda there.
    pub(super) lambda: [f32x16<S>; 2],
    /// Which leaves may have a hit at either root, no more than one each.
    pub(super) may: [mask32x16<S>; 2],
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
        // Q vanishes everywhere: the discriminant is never more, nor less, than nothing.
        tangency: [-1.0; LANES],
        room: [0.0; LANES],
        blur: [0.0; LANES],
    };

    pub(super) fn set(&mut self, lane: usize, q: &Quadric) {
        let (a, b, c, p) = (q.alpha.abs(), q.beta.abs(), q.gamma.abs(), q.p.abs());
        // The radius is at most 2, and so are |o|, |zeta| / 2 and |tau| at hits; lengths of directions
        // are at most the square root of 2. Counting roundings, of f64 to f32 among them, U, V and W
        // are off by at most these times the roundoff, and Q with them:
        let off_u = 5.0 * 2.0 * (a + p);
        let off_v = 6.0 * 1.5 * (2.0 * a + 0.5 * b + 4.0 * p);
        let off_w = 8.0 * (4.0 * a + 4.0 * b + 16.0 * p + c);
        let rounding = ROUNDOFF * (4.0 * off_u + 4.0 * off_v + off_w);
        let error = q.error + rounding;
        let growth = 1.5 * q.growth();
        let v_most = 1.5 * (2.0 * a + 0.5 * b + 4.0 * p);
        let u_most = 2.0 * (a + p);
        let steepest = 0.5 * q.slope * growth;
        // For a squared length of 1/2 or more.
        let tangency =
            2.0 * (steepest * steepest + 2.0 * u_most * error + 8.0 * ROUNDOFF * v_most * v_most);
        // No root of the discriminant is larger than this.
        let most = v_most + (u_most * (4.0 * a + 4.0 * b + 16.0 * p + c)).sqrt();
        let blur = error + 32.0 * ROUNDOFF * most;
        let lambda_rounding =
            8.0 * ROUNDOFF * (8.0 * q.lambda[0].abs() + 16.0 * q.lambda[1].abs() + 2.0);
        let room = blur * growth + lambda_rounding * most;
        let finite = |v: f64| if v.is_finite() { v as f32 } else { f32::MAX };
        self.z[lane] = q.z as f32;
        self.alpha[lane] = q.alpha as f32;
        self.half_beta[lane] = (0.5 * q.beta) as f32;
        self.gamma[lane] = q.gamma as f32;
        self.p[lane] = q.p as f32;
        for (lanes, own) in self.lambda.iter_mut().zip(q.lambda) {
            lanes[lane] = own as f32;
        }
        self.tangency[lane] = finite(1.01 * tangency);
        self.room[lane] = finite(1.01 * room);
        self.blur[lane] = finite(1.01 * blur);
    }

    /// Which of the leaves the ray may hit, and about where.
    #[inline(always)]
    pub(super) fn test<S: Simd, const SURE: bool>(&self, simd: S, ray: &Probe) -> Meeting<S> {
        let load = |lanes: &Lanes| f32x16::from_slice(simd, lanes);
        let splat = |value: f32| f32x16::splat(simd, value);
        let (a, b, c) = (splat(ray.a), splat(ray.b), splat(ray.c));
        let (dz, dz2) = (splat(ray.dz), splat(ray.dz * ray.dz));
        let (alpha, half_beta, p) = (load(&self.alpha), load(&self.half_beta), load(&self.p));
        let zeta = splat(ray.oz) - load(&self.z);
        let h = p.mul_add(zeta, half_beta);
        let u = p.mul_add(dz2, alpha * a);
        let v = dz.mul_add(h, alpha * b);
        let w = zeta.mul_add(h + half_beta, alpha.mul_add(c, load(&self.gamma)));
        let discriminant = v.mul_add(v, -(u * w));
        let tangency = load(&self.tangency) * splat(ray.length2);
        let steep = discriminant.simd_gt(tangency);
        let root = discriminant.sqrt();
        let q = -(v + root.copysign(v));
        let (tau_a, tau_b) = (q / u, w / q);
        let (near, far) = (tau_a.min(tau_b), tau_a.max(tau_b));
        let per_root = root.approximate_recip();
        let one = splat(1.0);
        let room = load(&self.room).mul_add(per_root, one);
        let blur = load(&self.blur) * per_root;
        // lambda as a quadratic in tau.
        let lambda = [load(&self.lambda[0]), load(&self.lambda[1]), load(&self.lambda[2])];
        let l0 = lambda[0].mul_add(zeta, lambda[1].mul_add(c, lambda[2]));
        let l1 = lambda[0].mul_add(dz, lambda[1] * (b + b));
        let l2 = lambda[1] * a;
        let at_near = l2.mul_add(near, l1).mul_add(near, l0);
        let at_far = l2.mul_add(far, l1).mul_add(far, l0);
        let (start, end) = (splat(ray.start), splat(ray.end));
        let may = |tau: f32x16<S>, lambda: f32x16<S>| {
            steep
                & lambda.abs().simd_le(room)
                & (tau + blur).simd_ge(start)
                & (tau - blur).simd_le(end)
        };
        let may = [may(near, at_near), may(far, at_far)];
        let mut sure = 0;
        if SURE {
            let within = one + one - room;
            let hit = |tau: f32x16<S>, lambda: f32x16<S>| {
                lambda.abs().simd_le(within)
                    & (tau - blur).simd_ge(start)
                    & (tau + blur).simd_le(end)
            };
            let hits = may[0] & hit(near, at_near) | may[1] & hit(far, at_far);
            sure = hits.to_bitmask() as u32;
        }
        // Also where one is not a number.
        let clear = steep | discriminant.simd_lt(-tangency);
        let mut tangent = !clear.to_bitmask() as u32 & 0xffff;
        if tangent != 0 {
            // Where it would be, how far round it, and whether the leaf is there.
            let middle = -v / u;
            let around = ((tangency + tangency).sqrt() + load(&self.blur)) / u.abs();
            let slope = l1.abs() + (l2 + l2).abs() * (middle.abs() + around);
            let lambda = l2.mul_add(middle, l1).mul_add(middle, l0).abs() - slope * around;
            let away = lambda.simd_gt(splat(1.125))
                | (middle + around).simd_lt(start)
                | (middle - around).simd_gt(end);
            tangent &= !away.to_bitmask() as u32;
        }
        Meeting { tau: [near, far], blur, lambda: [at_near, at_far], may, sure, tangent }
    }
}

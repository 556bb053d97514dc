//! The course of a ray through the half plane, in one form for all rays.
//!
//! With w = rho^2, a = dx^2 + dy^2, b = ox dx + oy dy and k = ox dy - oy dx, a ray meets the points of
//! the half plane where
//!
//! ```text
//! F = X^2 + kappa - eta w = 0,    X = z - oz + dz b / a,    eta = dz^2 / a,    kappa = eta k^2 / a:
//! ```
//!
//! the form that [`Meridian`](crate::meridian) has for shallow rays, one division away from the ray.
//! For steep rays it grows with eta, but so do its errors: it stays sound as long as `a` does not
//! vanish beside dz^2.

#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is not a number must fail the comparisons, too"
)]

use super::arithmetic::greater;
use crate::frame::Frame;
use crate::{Ray, Vec3};

/// A ray in the half plane of the profile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) a: f64,
    pub(super) b: f64,
    k2: f64,
    per_a: f64,
    pub(super) oz: f64,
    pub(super) dz: f64,
    pub(super) eta: f64,
    pub(super) kappa: f64,
    /// X at z = 0.
    pub(super) x: f64,
    /// What the ray's own parameter is more than that used here.
    pub(super) shift: f64,
}

/// What there is to do about a ray.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Approach {
    /// It passes the surface.
    Misses,
    Meets,
    /// It runs along the axis, comes from very far away, or is no ray: not for this engine.
    Strange,
}

/// Rays from no farther away, in radii, keep their origin: rounding errors are still small.
const NEAR: f64 = 16.0;
/// Rays from farther away are strange.
const FAR: f64 = (1_u64 << 30) as f64;
/// Squares of directions, and of their parts across the axis, for which nothing overflows, vanishes, or
/// differs too much.
const LONGEST: f64 = (1_u64 << 40) as f64;
const SHORTEST: f64 = 1.0 / (1_u64 << 20) as f64;
const STEEPEST: f64 = (1_u64 << 12) as f64;

impl Course {
    const NONE: Self = Self {
        a: 0.0,
        b: 0.0,
        k2: 0.0,
        per_a: 0.0,
        oz: 0.0,
        dz: 0.0,
        eta: 0.0,
        kappa: 0.0,
        x: 0.0,
        shift: 0.0,
    };

    /// A ray as a surface sees it that stands in a frame, with points no farther from its centre than
    /// `radius`, and from its axis than the square root of `reach2`.
    #[inline(always)]
    pub(super) fn new(frame: &Frame, ray: &Ray, radius: f64, reach2: f64) -> (Approach, Self) {
        // Also false where one is not a number.
        if !(ray.t_min <= ray.t_max) {
            return (Approach::Misses, Self::NONE);
        }
        let [mut o, d] = frame.turn(ray);
        let far = greater(greater(o.x.abs(), o.y.abs()), o.z.abs());
        let a = d.x * d.x + d.y * d.y;
        let mut shift = 0.0;
        if !(far <= NEAR * radius) {
            let length2 = a + d.z * d.z;
            shift = -o.dot(d) / length2;
            if !(far <= FAR * radius && (SHORTEST..=LONGEST).contains(&length2)) {
                return (Approach::Strange, Self::NONE);
            }
            o = approached(frame, ray, shift);
        }
        let k = o.x * d.y - o.y * d.x;
        let k2 = k * k;
        if k2 > a * reach2 && a >= SHORTEST {
            return (Approach::Misses, Self::NONE);
        }
        let dz2 = d.z * d.z;
        if !((SHORTEST..=LONGEST).contains(&a) && dz2 <= STEEPEST * a) {
            return (Approach::Strange, Self::NONE);
        }
        let b = o.x * d.x + o.y * d.y;
        let per_a = 1.0 / a;
        let eta = dz2 * per_a;
        let rise = d.z * b * per_a;
        let course = Self {
            a,
            b,
            k2,
            per_a,
            oz: o.z,
            dz: d.z,
            eta,
            kappa: eta * (k2 * per_a),
            x: rise - o.z,
            shift,
        };
        (Approach::Meets, course)
    }

    /// w where a t + b, half its derivative, has a value.
    #[inline(always)]
    pub(super) fn w(&self, half_derivative: f64) -> f64 {
        (half_derivative * half_derivative + self.k2) * self.per_a
    }

    /// The ray parameter, counted from the origin used here, at a point of the half plane that lies on the
    /// course, with X >= 0 or not. See [`Meridian::t`](crate::meridian::Meridian::t).
    #[inline(always)]
    pub(super) fn t(&self, r: f64, z: f64, above: bool) -> f64 {
        let reach = self.a * (r * r) - self.k2;
        let dz2 = self.dz * self.dz;
        if self.a > dz2 && reach >= dz2 * (r * r) {
            let outward = above == (self.dz >= 0.0);
            let root = greater(reach, 0.0).sqrt();
            ((if outward { root } else { -root }) - self.b) * self.per_a
        } else {
            (z - self.oz) / self.dz
        }
    }
}

/// The origin moved along a ray from far away, without losing what cancels.
#[cold]
fn approached(frame: &Frame, ray: &Ray, shift: f64) -> Vec3 {
    let [(x, xl), (y, yl), (z, zl)] = frame.relative(ray.origin);
    let d = ray.direction;
    let moved = Vec3::new(
        shift.mul_add(d.x, x) + xl,
        shift.mul_add(d.y, y) + yl,
        shift.mul_add(d.z, z) + zl,
    );
    frame.turned(moved)
}

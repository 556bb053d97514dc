//! A ray near the surface, in the surface's own size: what the wide engine works on.
//!
//! Lengths are measured in a power of two near the surface's radius R, so that R is between 1 and 2; the
//! direction is brought to a squared length between 1/2 and 2 by another power of two. Neither rounds
//! anything. The origin moves along the ray to the point closest to the surface's centre
//! ([`frame`](crate::frame) says why). Then
//!
//! ```text
//! t = (tau + shift) scale,    |o| <= R,    w(tau) = a tau^2 + 2 b tau + c,    z(tau) = oz + tau dz,
//! ```
//!
//! and nothing here can overflow, vanish, or lose what cancels.

#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is not a number must fail the comparisons, too"
)]

use super::arithmetic::{Fused, greater};
use crate::frame::{Frame, LocalRay};
use crate::{Ray, Vec3};

/// A ray in the surface's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    /// Between which parameters hits count.
    pub(super) range: [f64; 2],
    /// The ray's own parameter is (tau + shift) scale.
    pub(super) shift: f64,
    pub(super) scale: f64,
}

/// What there is to do about a ray.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Approach {
    /// It passes the surface.
    Misses,
    Meets,
    /// It comes from very far away, has a direction of extreme length, or is no ray: not for this engine.
    Strange,
}

/// How a surface is seen from afar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    /// A power of two that brings the radius to between 1 and 2.
    pub(super) unit: f64,
    /// A bound on the square of that radius, in these units,
    pub(super) radius2: f64,
    /// and on the squared distance of the surface from its axis.
    pub(super) reach2: f64,
}

/// From so far away, in these units, k is good to 2^-40: [`Outline::reach2`] has room for that.
pub(super) const FAR: f64 = 4096.0;
/// In a frame that turns rays, from so far away the differences to the centre are good enough.
const FAR_TURNED: f64 = 16.0;

/// The exponents, biased as in an f64, that a direction's squared length may have.
const EXPONENTS: core::ops::RangeInclusive<u64> = 1023 - 400..=1023 + 400;

/// Two to the power `exponent`, which must be that of an ordinary f64.
#[inline(always)]
fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

impl Course {
    const NONE: Self = Self {
        origin: Vec3::ZERO,
        direction: Vec3::ZERO,
        range: [0.0; 2],
        shift: 0.0,
        scale: 0.0,
    };

    /// A ray as a surface sees it that stands in a frame.
    #[inline(always)]
    pub(super) fn new(
        fma: impl Fused,
        frame: &Frame,
        ray: &Ray,
        outline: &Outline,
    ) -> (Approach, Self) {
        // Also false where one is not a number.
        if !(ray.t_min <= ray.t_max) {
            return (Approach::Misses, Self::NONE);
        }
        let unit = outline.unit;
        let [o, d] = frame.turn(ray);
        let turned = frame.inverse().is_some();
        // What the difference to the centre has lost; on the axis nothing but in z.
        let (z, z_low) = if turned { (o.z, 0.0) } else { frame.relative(ray.origin)[2] };
        let o = Vec3::new(o.x * unit, o.y * unit, z * unit);
        let far = greater(greater(o.x.abs(), o.y.abs()), o.z.abs());
        let a = d.x * d.x + d.y * d.y;
        let length2 = d.z * d.z + a;
        let exponent = length2.to_bits() >> 52;
        if !(far <= if turned { FAR_TURNED } else { FAR }) || !EXPONENTS.contains(&exponent) {
            return (Approach::Strange, Self::NONE);
        }
        let k = o.x * d.y - o.y * d.x;
        if !(k * k <= a * outline.reach2) {
            return (Approach::Misses, Self::NONE);
        }
        let halves = (exponent as i64 - 1022) >> 1;
        let (up, down) = (power_of_two(halves), power_of_two(-halves));
        let shift = -o.dot(d) / length2;
        let origin = Vec3::new(
            fma.fused(shift, d.x, o.x),
            fma.fused(shift, d.y, o.y),
            fma.fused(shift, d.z, o.z) + z_low * unit,
        );
        if !(origin.dot(origin) <= outline.radius2) {
            return (Approach::Misses, Self::NONE);
        }
        let (scale_in, scale) = (unit * up, down / unit);
        let shift = shift * up;
        let range = [ray.t_min * scale_in - shift, ray.t_max * scale_in - shift];
        (Approach::Meets, Self { origin, direction: d * down, range, shift, scale })
    }

    /// A ray that has come near already, with parameters of its own.
    pub(super) fn of(ray: &LocalRay, outline: &Outline) -> Self {
        let length2 = ray.direction.length_squared();
        let halves = (((length2.to_bits() >> 52) as i64) - 1022) >> 1;
        let (up, down) = (power_of_two(halves), power_of_two(-halves));
        let scale_in = outline.unit * up;
        Self {
            origin: ray.origin * outline.unit,
            direction: ray.direction * down,
            range: ray.range.map(|t| t * scale_in),
            shift: 0.0,
            scale: down / outline.unit,
        }
    }

    /// The parameter in units of the ray's own direction.
    #[inline(always)]
    pub(super) fn world_t(&self, tau: f64) -> f64 {
        (tau + self.shift) * self.scale
    }

    /// The inverse of [`world_t`](Self::world_t).
    #[inline(always)]
    pub(super) fn tau(&self, t: f64) -> f64 {
        t / self.scale - self.shift
    }
}

/// Whether a ray surely passes the axis too far away, by a few multiplications alone: most rays of a
/// picture do. Only for surfaces that stand where they were built, on the z axis.
#[inline(always)]
pub(super) fn passes(ray: &Ray, outline: &Outline) -> bool {
    let (o, d) = (ray.origin, ray.direction);
    let (x, y) = (o.x * outline.unit, o.y * outline.unit);
    let k = x * d.y - y * d.x;
    // From farther away rounding could say so.
    let near = x.abs() <= FAR && y.abs() <= FAR;
    near && k * k > (d.x * d.x + d.y * d.y) * outline.reach2
}

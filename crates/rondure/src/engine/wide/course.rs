//! A ray near the surface, in the surface's own size: what the wide engine works on.
//!
//! Lengths are measured in a power of two near the surface's radius R, so that R is between 1 and 2, which
//! rounds nothing. A ray from afar first moves along itself to the point closest to the surface's centre
//! ([`frame`](crate::frame) says why). With t = tau + shift,
//!
//! ```text
//! w(tau) = rho^2 = a tau^2 + 2 b tau + c,    z(tau) = oz + tau dz.
//! ```

#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is not a number must fail the comparisons, too"
)]

use super::arithmetic::{Fused, greater};
use crate::frame::{Frame, LocalRay};
use crate::{Ray, Vec3};

/// A ray in the surface's frame.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Course {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
    /// The squared length of the direction.
    pub(super) length2: f64,
    /// The largest coordinate of the origin, or more.
    pub(super) far: f64,
    /// The terms that the direction was turned by, whose rounding moves points by as much times tau.
    pub(super) turn: f64,
    /// Between which parameters hits count.
    pub(super) range: [f64; 2],
    pub(super) shift: f64,
}

/// Why there is no course.
#[derive(Clone, Copy)]
pub(super) enum Astray {
    /// The ray passes the surface.
    Misses,
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
    /// [`FAR`] in the units of rays.
    pub(super) far: f64,
}

/// Rays from no farther away, in these units, keep their origin.
pub(super) const NEAR: f64 = 8.0;
/// From so far away k is good to 2^-40: [`Outline::reach2`] has room for that.
pub(super) const FAR: f64 = 4096.0;

/// Room for what squares of a ray that is all but parallel to the axis lose when they vanish.
pub(super) const VANISHING: f64 = f64::MIN_POSITIVE;

/// A placement that is so flat that turning a ray cancels all but this part of it is for the exact engine.
pub(super) const FLAT: f64 = 64.0;

/// Squared lengths of directions, in these units, for which nothing overflows, not even in f32, or vanishes.
pub(super) const SHORTEST: f64 = 1.0 / (1_u64 << 60) as f64;
pub(super) const LONGEST: f64 = (1_u64 << 60) as f64;

impl Course {
    /// A ray as a surface sees it that stands in a frame. If that is not `PLACED`, the ray does not
    /// [pass](passes) it.
    #[inline(always)]
    pub(super) fn new<const PLACED: bool>(
        fma: impl Fused,
        frame: &Frame,
        ray: &Ray,
        outline: &Outline,
    ) -> Result<Self, Astray> {
        // Also false where one is not a number.
        if !(ray.t_min <= ray.t_max) {
            return Err(Astray::Misses);
        }
        let unit = outline.unit;
        let [o, d] = if PLACED {
            frame.turn(ray)
        } else {
            let origin = Vec3 { z: ray.origin.z - frame.center_z(), ..ray.origin };
            [origin, ray.direction]
        };
        let (mut origin, direction) = (o * unit, d * unit);
        let a = direction.x * direction.x + direction.y * direction.y;
        let distance = greater(greater(origin.x.abs(), origin.y.abs()), origin.z.abs());
        let length2 = direction.z * direction.z + a;
        if !(SHORTEST..=LONGEST).contains(&length2) || !(distance <= FAR) {
            return Err(Astray::Strange);
        }
        if PLACED {
            let k = origin.x * direction.y - origin.y * direction.x;
            if !(k * k <= a * outline.reach2 + VANISHING) {
                return Err(Astray::Misses);
            }
        }
        let (mut far, mut turn) = (distance, 0.0);
        if PLACED && frame.inverse().is_some() {
            let [of_origin, of_direction] = frame.turned_size(ray);
            turn = of_direction * unit;
            let lost =
                of_origin * unit > FLAT * (distance + 2.0) || turn * turn > FLAT * FLAT * length2;
            if lost {
                return Err(Astray::Strange);
            }
            far = greater(distance, of_origin * unit);
        }
        let mut shift = 0.0;
        if distance > NEAR {
            shift = -origin.dot(direction) / length2;
            origin = approached(fma, frame, ray, unit, shift);
            // Moving it has lost nothing; turning it may have.
            far = if PLACED { greater(far, NEAR) } else { NEAR };
        }
        let b = origin.x * direction.x + origin.y * direction.y;
        let c = origin.x * origin.x + origin.y * origin.y;
        let along = fma.fused(origin.z, direction.z, b);
        let outside = fma.fused(origin.z, origin.z, c) - outline.radius2;
        if !(along * along >= outside * length2) {
            return Err(Astray::Misses);
        }
        let range = [ray.t_min - shift, ray.t_max - shift];
        Ok(Self { origin, direction, a, b, c, length2, far, turn, range, shift })
    }

    /// A ray that has come near already, with a direction between 1 and 4 long; tau is its own parameter times the
    /// unit of length.
    pub(super) fn of(ray: &LocalRay, outline: &Outline) -> Self {
        let (o, d) = (ray.origin * outline.unit, ray.direction);
        let a = d.x * d.x + d.y * d.y;
        Self {
            origin: o,
            direction: d,
            a,
            b: o.x * d.x + o.y * d.y,
            c: o.x * o.x + o.y * o.y,
            length2: a + d.z * d.z,
            far: o.max_abs(),
            turn: 0.0,
            range: ray.range.map(|t| t * outline.unit),
            shift: 0.0,
        }
    }
}

/// The origin moved along a ray from far away, without losing what cancels.
#[inline(always)]
fn approached(fma: impl Fused, frame: &Frame, ray: &Ray, unit: f64, shift: f64) -> Vec3 {
    let [(x, xl), (y, yl), (z, zl)] = frame.relative(ray.origin);
    let d = ray.direction;
    let moved = Vec3::new(
        fma.fused(shift, d.x, x) + xl,
        fma.fused(shift, d.y, y) + yl,
        fma.fused(shift, d.z, z) + zl,
    );
    frame.turned(moved) * unit
}

/// Whether a ray surely passes the axis too far away, by a few multiplications alone: most rays of a
/// picture do. Only for surfaces that stand where they were built, on the z axis.
#[inline(always)]
pub(super) fn passes(ray: &Ray, outline: &Outline) -> bool {
    let (o, d) = (ray.origin, ray.direction);
    let k = (o.x * d.y - o.y * d.x) * outline.unit;
    // From farther away rounding could say so.
    let near = o.x.abs() <= outline.far && o.y.abs() <= outline.far;
    near && k * k > (d.x * d.x + d.y * d.y) * outline.reach2 + VANISHING
}

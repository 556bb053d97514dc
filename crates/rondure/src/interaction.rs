//! The full answer at a hit: point, normal, parameters, partial derivatives, error bound.

use core::f64::consts::TAU;

use crate::frame::Frame;
use crate::meridian::Meridian;
use crate::numeric::reciprocal_power_of_two;
use crate::profile::Point;
use crate::{Affine, Hit, Ray, Surface, Vec3};

/// Everything about the surface at a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interaction {
    /// The point, on the surface to within [`error`](Self::error).
    pub point: Vec3,
    /// The geometric normal, of unit length. It points out of a solid; on an open profile to the
    /// right of the drawing direction, r to the right and z up: outwards if drawn upwards.
    pub normal: Vec3,
    /// u, the angle round the axis over 2 pi, in [0, 1), and v, the fraction of the profile's arc
    /// length, in [0, 1].
    pub uv: [f64; 2],
    /// The partial derivative of the point by u.
    pub dp_du: Vec3,
    /// The partial derivative of the point by v.
    pub dp_dv: Vec3,
    /// A bound on how far rounding can have moved [`point`](Self::point) off the surface, and can
    /// move a ray that starts near it.
    pub error: f64,
}

impl Interaction {
    /// The ray that leaves the surface here: its origin lies off the surface by the error bound, on
    /// the side to which `direction` points, so that it does not hit the place that it leaves.
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        self.footing().spawn(direction)
    }

    /// The part of it that rays go on from.
    #[inline]
    pub fn footing(&self) -> Footing {
        Footing { point: self.point, normal: self.normal, error: self.error }
    }
}

/// What of an [`Interaction`] a ray needs that goes on from there; it takes half the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// As [`Interaction::point`].
    pub point: Vec3,
    /// As [`Interaction::normal`].
    pub normal: Vec3,
    /// As [`Interaction::error`].
    pub error: f64,
}

impl Footing {
    /// The ray that leaves the surface here; see [`Interaction::spawn`].
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let side = self.error.copysign(self.normal.dot(direction));
        Ray::new(self.point + self.normal * side, direction)
    }
}

/// A hit by its place on the profile and its direction from the axis.
struct Place {
    /// The point of the profile, its height above the surface's centre.
    profile: Point,
    /// The unit tangent of the profile in its drawing direction.
    tangent: Point,
    /// The cosine and the sine of the angle round the axis.
    angle: [f64; 2],
}

impl Place {
    fn of(surface: &Surface, frame: &Frame, ray: &Ray, hit: &Hit) -> Self {
        let (profile, tangent) = surface.profile_at(hit);
        // The hit lies on the circle of radius r exactly; the ray only tells in which direction.
        let line = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
        let angle = frame.enter(&line).map_or([1.0, 0.0], |local| {
            // From far away t is less exact than the place on the profile, which tells it anew.
            let rough = local.local_t(hit.t);
            let meridian = Meridian::new(local.origin, local.direction);
            let [a, b] = [true, false].map(|above| meridian.t(profile.r, profile.z, above));
            let t = if (a - rough).abs() <= (b - rough).abs() { a } else { b };
            let p = local.origin + local.direction * t;
            // Beside the axis the coordinates may be subnormal, and know few digits of a quotient.
            let near_one = reciprocal_power_of_two(p.x.abs().max(p.y.abs()));
            let (x, y) = (p.x * near_one, p.y * near_one);
            let rho = x.hypot(y);
            if rho > 0.0 { [x / rho, y / rho] } else { [1.0, 0.0] }
        });
        Self::new((profile, tangent), angle)
    }

    /// From the point of the profile, the derivative there by any parameter, and the angle's cosine and
    /// sine.
    fn new((profile, tangent): (Point, Point), angle: [f64; 2]) -> Self {
        let speed = tangent.length();
        Self { profile, tangent: Point::new(tangent.r / speed, tangent.z / speed), angle }
    }

    /// The unit normal in the world, on the side that `sense` tells (see [`Detail`]).
    ///
    /// [`Detail`]: crate::surface::Detail
    fn normal(&self, inverse: Option<&[Vec3; 3]>, sense: f64) -> Vec3 {
        let ([cos, sin], Point { r: dr, z: dz }) = (self.angle, self.tangent);
        let own = Vec3::new(dz * cos, dz * sin, -dr) * sense;
        match inverse {
            Some(rows) => (rows[0] * own.x + rows[1] * own.y + rows[2] * own.z).normalized(),
            None => own,
        }
    }

    fn interaction(
        &self,
        surface: &Surface,
        inverse: Option<&[Vec3; 3]>,
        placement: &Affine,
        rounding: f64,
        hit: &Hit,
    ) -> Interaction {
        let (curve, detail, s) = surface.curve_at(hit);
        let normal = self.normal(inverse, detail.sense);
        let ([cos, sin], Point { r: dr, z: dz }) = (self.angle, self.tangent);
        let (r, z) = (self.profile.r, self.profile.z + surface.center_z);
        let turn = sin.atan2(cos) / TAU;
        let u = if turn < 0.0 { turn + 1.0 } else { turn };
        let along = detail.length_before + detail.length.until(curve, s);
        Interaction {
            point: placement.point(Vec3::new(r * cos, r * sin, z)),
            normal,
            // A tiny negative angle rounds to a full turn, which is none.
            uv: [if u < 1.0 { u } else { 0.0 }, (along / surface.length).clamp(0.0, 1.0)],
            dp_du: placement.vector(Vec3::new(-r * sin, r * cos, 0.0) * TAU),
            dp_dv: placement.vector(Vec3::new(dr * cos, dr * sin, dz) * surface.length),
            error: rounding,
        }
    }
}

/// The normal alone at a hit of a surface that stands in `frame`.
pub(crate) fn normal(surface: &Surface, frame: &Frame, ray: &Ray, hit: &Hit) -> Vec3 {
    let sense = surface.curve_at(hit).1.sense;
    Place::of(surface, frame, ray, hit).normal(frame.inverse(), sense)
}

/// The interaction at a hit of a surface that stands in `frame`, where `placement` put it.
pub(crate) fn interaction(
    surface: &Surface,
    frame: &Frame,
    placement: &Affine,
    rounding: f64,
    ray: &Ray,
    hit: &Hit,
) -> Interaction {
    let place = Place::of(surface, frame, ray, hit);
    place.interaction(surface, frame.inverse(), placement, rounding, hit)
}

/// The same without parameters and derivatives.
pub(crate) fn footing(
    surface: &Surface,
    frame: &Frame,
    placement: &Affine,
    rounding: f64,
    ray: &Ray,
    hit: &Hit,
) -> Footing {
    let sense = surface.curve_at(hit).1.sense;
    let place = Place::of(surface, frame, ray, hit);
    let ([cos, sin], Point { r, z }) = (place.angle, place.profile);
    Footing {
        point: placement.point(Vec3::new(r * cos, r * sin, z + surface.center_z)),
        normal: place.normal(frame.inverse(), sense),
        error: rounding,
    }
}

/// The interaction at a place of the profile and at `turn`, the angle round the axis over 2 pi;
/// `inverse` has the rows of the placement's inverse, `None` for the identity.
pub(crate) fn interaction_at(
    surface: &Surface,
    inverse: Option<&[Vec3; 3]>,
    placement: &Affine,
    rounding: f64,
    turn: f64,
    (piece, s): (u32, f64),
) -> Interaction {
    let hit = Hit { t: 0.0, piece, s };
    let (sin, cos) = (turn * TAU).sin_cos();
    let place = Place::new(surface.profile_at(&hit), [cos, sin]);
    place.interaction(surface, inverse, placement, rounding, &hit)
}

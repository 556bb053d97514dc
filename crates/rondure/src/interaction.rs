//! The full answer at a hit: point, normal, parameters, partial derivatives, error bound.

use core::f64::consts::TAU;

use crate::frame::{Frame, turned_back};
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

/// From no farther than so many radii away the rounding of origin + t direction, some 2^-53 of that distance, turns the place by no more
/// than rounding in the engine's own hit does; the place stays on its circle whatever the angle.
const NEAR: f64 = 16.0;

impl Place {
    #[inline]
    fn of(surface: &Surface, frame: &Frame, ray: &Ray, hit: &Hit) -> Self {
        let (profile, tangent) = surface.profile_at(hit);
        // The hit lies on the circle of radius r exactly; the ray only tells in which direction.
        let [origin, direction] = frame.turn(ray);
        let p = if origin.max_abs() <= NEAR * surface.radius {
            Some(origin + direction * hit.t)
        } else {
            from_afar(frame, ray, profile, hit.t)
        };
        let angle = p.and_then(|p| unit_vector(p.x, p.y)).unwrap_or([1.0, 0.0]);
        Self::new((profile, tangent), angle)
    }

    /// From the point of the profile, the derivative there by any parameter, and the angle's cosine and
    /// sine.
    fn new((profile, tangent): (Point, Point), angle: [f64; 2]) -> Self {
        let [r, z] = unit_vector(tangent.r, tangent.z).unwrap_or([f64::NAN; 2]);
        Self { profile, tangent: Point::new(r, z), angle }
    }

    /// The unit normal in the surface's own frame, on the side that `sense` tells (see [`Detail`]).
    ///
    /// [`Detail`]: crate::surface::Detail
    #[inline]
    fn normal(&self, sense: f64) -> Vec3 {
        let ([cos, sin], Point { r: dr, z: dz }) = (self.angle, self.tangent);
        Vec3::new(dz * cos, dz * sin, -dr) * sense
    }

    fn interaction(
        &self,
        surface: &Surface,
        inverse: Option<&[Vec3; 3]>,
        placement: &Affine,
        rounding: f64,
        hit: &Hit,
    ) -> Interaction {
        let normal = self.normal(surface.detail_at(hit).sense());
        let normal = inverse.map_or(normal, |rows| turned_back(rows, normal));
        let ([cos, sin], Point { r: dr, z: dz }) = (self.angle, self.tangent);
        let (r, z) = (self.profile.r, self.profile.z + surface.center_z);
        let turn = sin.atan2(cos) / TAU;
        let u = if turn < 0.0 { turn + 1.0 } else { turn };
        let along = surface.length_at(hit);
        Interaction {
            point: placement.point(Vec3::new(r * cos, r * sin, z)),
            normal,
            // A tiny negative angle rounds to a full turn, which is none.
            uv: [if u < 1.0 { u } else { 0.0 }, (along / surface.length()).clamp(0.0, 1.0)],
            dp_du: placement.vector(Vec3::new(-r * sin, r * cos, 0.0) * TAU),
            dp_dv: placement.vector(Vec3::new(dr * cos, dr * sin, dz) * surface.length()),
            error: rounding,
        }
    }
}

/// The vector of length 1 in the direction of (x, y); `None` of zero.
#[inline]
fn unit_vector(x: f64, y: f64) -> Option<[f64; 2]> {
    // Where squares would vanish, or have few digits, or be too large: beside the axis, beside a handle of length zero.
    let near_one = reciprocal_power_of_two(x.abs().max(y.abs()));
    let (x, y) = (x * near_one, y * near_one);
    let length = (x * x + y * y).sqrt();
    (length > 0.0).then(|| [x / length, y / length])
}

/// Where a ray from far away hits: t is less exact than the place on the profile, which tells it anew.
#[cold]
fn from_afar(frame: &Frame, ray: &Ray, profile: Point, t: f64) -> Option<Vec3> {
    let local = frame.enter(&ray.whole())?;
    let rough = local.local_t(t);
    let meridian = Meridian::new(local.origin, local.direction);
    let [a, b] = [true, false].map(|above| meridian.t(profile.r, profile.z, above));
    let t = if (a - rough).abs() <= (b - rough).abs() { a } else { b };
    Some(local.origin + local.direction * t)
}

/// The normal alone at a hit of a surface that stands in `frame`.
pub(crate) fn normal(surface: &Surface, frame: &Frame, ray: &Ray, hit: &Hit) -> Vec3 {
    let sense = surface.detail_at(hit).sense();
    frame.normal(Place::of(surface, frame, ray, hit).normal(sense))
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
    let sense = surface.detail_at(hit).sense();
    let place = Place::of(surface, frame, ray, hit);
    let ([cos, sin], Point { r, z }) = (place.angle, place.profile);
    Footing {
        point: frame.point(placement, Vec3::new(r * cos, r * sin, z + surface.center_z)),
        normal: frame.normal(place.normal(sense)),
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

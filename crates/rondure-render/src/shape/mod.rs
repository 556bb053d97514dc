//! The simple shapes, which are solved in place.
//!
//! All keep one contract, that of turned surfaces ([`rondure::Instance`]): the closest hit in the ray's range, the
//! full answer on demand, and with it a bound on how far rounding moved the point off the surface,
//! so that the next ray starts clear of it. No tolerance depends on anything but rounding.

mod flat;
mod flats;
mod sphere;

pub(crate) use flat::{Disk, Plane, Rectangle};
pub(crate) use flats::Flats;
pub(crate) use sphere::Sphere;

use rondure::{Bounds, Footing, Hit, Interaction, Ray, Vec3, numeric::gamma};

/// A shape that is no turned surface.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Sphere(Sphere),
    Disk(Disk),
    Rectangle(Rectangle),
    Plane(Plane),
}

impl Shape {
    /// Whether the shape has an inside, and its normals point out of it.
    pub(crate) fn is_solid(&self) -> bool {
        matches!(self, Self::Sphere(_))
    }

    /// The box round the shape; that of a plane is all of space.
    pub(crate) fn bounds(&self) -> Bounds {
        match self {
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Disk(disk) => disk.bounds(),
            Self::Rectangle(rectangle) => rectangle.bounds(),
            Self::Plane(_) => {
                Bounds { min: Vec3::splat(f64::NEG_INFINITY), max: Vec3::splat(f64::INFINITY) }
            }
        }
    }

    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Sphere(sphere) => sphere.closest(ray),
            Self::Disk(disk) => disk.closest(ray),
            Self::Rectangle(rectangle) => rectangle.closest(ray),
            Self::Plane(plane) => plane.closest(ray),
        }
        .map(hit_at)
    }

    /// The point, the normal and the dual vectors of a rectangle, or of a plane, whose duals are zero.
    fn flat(&self) -> Option<[Vec3; 4]> {
        match self {
            Self::Rectangle(rectangle) => Some(rectangle.parts()),
            Self::Plane(plane) => Some(plane.parts()),
            Self::Sphere(_) | Self::Disk(_) => None,
        }
    }

    /// All hits in the ray's range, in order. `hits` is cleared first.
    pub(crate) fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        match self {
            Self::Sphere(sphere) => hits.extend(sphere.all(ray).map(hit_at)),
            _ => hits.extend(self.closest(ray)),
        }
    }

    /// The place and the normal of a hit, alone.
    #[inline]
    pub(crate) fn footing(&self, ray: &Ray, hit: &Hit) -> Footing {
        match self {
            Self::Sphere(sphere) => sphere.footing(ray, hit.t),
            Self::Disk(disk) => disk.footing(ray, hit.t),
            Self::Rectangle(rectangle) => rectangle.footing(ray, hit.t),
            Self::Plane(plane) => plane.footing(ray, hit.t),
        }
    }

    /// The full answer. On flat shapes (u, v) are lengths along the shape, from its centre.
    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        match self {
            Self::Sphere(sphere) => sphere.interaction(ray, hit.t),
            Self::Disk(disk) => disk.interaction(ray, hit.t),
            Self::Rectangle(rectangle) => rectangle.interaction(ray, hit.t),
            Self::Plane(plane) => plane.interaction(ray, hit.t),
        }
    }
}

#[inline]
fn hit_at(t: f64) -> Hit {
    Hit { t, piece: 0, s: 0.0 }
}

/// How far off a surface a point can lie that was computed on it from a centre: the coordinates
/// relative to the centre, at most `extent`, pass through at most 16 roundings, and so does their
/// sum with the centre.
///
/// It is twice what the shapes here need, so that a ray that starts this far off stays on its side
/// when its own origin is subtracted from the centre again. The least is a number at all: at the world's origin nothing
/// is rounded, but there, too, the ray has to start on a side.
#[inline]
fn point_error(center: Vec3, extent: f64) -> f64 {
    gamma(32) * (center.max_abs() + extent) + f64::MIN_POSITIVE
}

/// The box grown by the rounding of its own corners.
fn padded(center: Vec3, half: Vec3) -> Bounds {
    let half = half + Vec3::splat(gamma(8) * (half.max_abs() + center.max_abs()));
    Bounds { min: center - half, max: center + half }
}

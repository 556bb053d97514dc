//! The shapes that rays meet: turned surfaces, and the simple ones that are solved in place.
//!
//! All keep one contract, that of [`rondure::Instance`]: the closest hit in the ray's range, the
//! full answer on demand, and with it a bound on how far rounding moved the point off the surface,
//! so that the next ray starts clear of it. No tolerance depends on anything but rounding.

mod flat;
mod sphere;

pub(crate) use flat::{Disk, Plane, Rectangle};
pub(crate) use sphere::Sphere;

use rondure::{Bounds, Hit, Instance, Interaction, Ray, Vec3, numeric::gamma};

/// Anything that a ray can meet.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Turned(Instance),
    Sphere(Sphere),
    Disk(Disk),
    Rectangle(Rectangle),
    Plane(Plane),
}

impl Shape {
    pub(crate) fn new(shape: &rondure_scene::Shape) -> Self {
        use rondure_scene::Shape as Described;
        match *shape {
            Described::Turned(ref instance) => Self::Turned(instance.clone()),
            Described::Plane { point, normal } => Self::Plane(Plane::new(point, normal)),
            Described::Disk { center, normal, radius } => {
                Self::Disk(Disk::new(center, normal, radius))
            }
            Described::Rectangle { center, edges } => {
                Self::Rectangle(Rectangle::new(center, edges))
            }
            Described::Sphere { center, radius } => Self::Sphere(Sphere::new(center, radius)),
        }
    }

    /// Whether the shape has an inside, and its normals point out of it.
    pub(crate) fn is_solid(&self) -> bool {
        match self {
            Self::Turned(instance) => instance.surface().profile().bounds_solid(),
            Self::Sphere(_) => true,
            Self::Disk(_) | Self::Rectangle(_) | Self::Plane(_) => false,
        }
    }

    /// The box round the shape; a plane has none.
    pub(crate) fn bounds(&self) -> Option<Bounds> {
        match self {
            Self::Turned(instance) => Some(instance.bounds()),
            Self::Sphere(sphere) => Some(sphere.bounds()),
            Self::Disk(disk) => Some(disk.bounds()),
            Self::Rectangle(rectangle) => Some(rectangle.bounds()),
            Self::Plane(_) => None,
        }
    }

    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Turned(instance) => instance.closest(ray),
            Self::Sphere(sphere) => sphere.closest(ray).map(hit_at),
            Self::Disk(disk) => disk.closest(ray).map(hit_at),
            Self::Rectangle(rectangle) => rectangle.closest(ray).map(hit_at),
            Self::Plane(plane) => plane.closest(ray).map(hit_at),
        }
    }

    #[inline]
    pub(crate) fn any(&self, ray: &Ray) -> bool {
        match self {
            Self::Turned(instance) => instance.any(ray),
            Self::Sphere(sphere) => sphere.closest(ray).is_some(),
            Self::Disk(disk) => disk.closest(ray).is_some(),
            Self::Rectangle(rectangle) => rectangle.closest(ray).is_some(),
            Self::Plane(plane) => plane.closest(ray).is_some(),
        }
    }

    /// All hits in the ray's range, in order. `hits` is cleared first.
    pub(crate) fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        match self {
            Self::Turned(instance) => instance.all(ray, hits),
            Self::Sphere(sphere) => {
                hits.clear();
                hits.extend(sphere.all(ray).map(hit_at));
            }
            Self::Disk(_) | Self::Rectangle(_) | Self::Plane(_) => {
                hits.clear();
                hits.extend(self.closest(ray));
            }
        }
    }

    /// The normal at a hit, alone.
    #[inline]
    pub(crate) fn normal(&self, ray: &Ray, hit: &Hit) -> Vec3 {
        match self {
            Self::Turned(instance) => instance.normal(ray, hit),
            _ => self.interaction(ray, hit).normal,
        }
    }

    /// The full answer. On flat shapes (u, v) are lengths along the shape, from its centre.
    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        match self {
            Self::Turned(instance) => instance.interaction(ray, hit),
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
/// when its own origin is subtracted from the centre again.
#[inline]
fn point_error(center: Vec3, extent: f64) -> f64 {
    gamma(32) * (center.max_abs() + extent)
}

/// The box grown by the rounding of its own corners.
fn padded(center: Vec3, half: Vec3) -> Bounds {
    let half = half + Vec3::splat(gamma(8) * (half.max_abs() + center.max_abs()));
    Bounds { min: center - half, max: center + half }
}

//! The world that rays see: shapes behind trees of boxes, lights and sky.
//!
//! Three trees: one over all that the eye can see, one over what blocks light, one over clear
//! glass, through which shadow rays pass. Planes have no box and are tested one by one.

use rondure::{Hit, Interaction, Ray};
use rondure_scene::{Light, Scene};

use crate::{
    RenderError,
    bvh::Bvh,
    color::Rgb,
    finish::Finish,
    fresnel,
    light::{Heaven, Lamp},
    shape::{Disk, Shape, Sphere},
};

/// What a shape is in the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Role {
    /// A surface: the index of its finish, and whether it has an inside.
    Surface { finish: u32, solid: bool },
    /// The body of a lamp.
    Lamp(u32),
}

#[derive(Clone, Debug)]
struct Thing {
    shape: Shape,
    role: Role,
}

/// Where a ray meets the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub(crate) thing: u32,
    pub(crate) hit: Hit,
}

/// Everything that rays ask about a scene.
#[derive(Clone, Debug)]
pub(crate) struct World {
    things: Vec<Thing>,
    finishes: Vec<Finish>,
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) sky: Heaven,
    /// The radiance that comes out white in the picture.
    pub(crate) white: f64,
    /// The most radiance that a ray can meet; at least white.
    pub(crate) brightest: f64,
    visible: Bvh,
    opaque: Bvh,
    clear: Bvh,
    opaque_planes: Vec<u32>,
    clear_planes: Vec<u32>,
}

impl World {
    pub(crate) fn new(scene: &Scene) -> Result<Self, RenderError> {
        let mut things = Vec::with_capacity(scene.objects.len() + scene.lights.len());
        for object in &scene.objects {
            if object.material >= scene.materials.len() {
                return Err(RenderError::NoSuchMaterial {
                    object: object.name.clone(),
                    material: object.material,
                    materials: scene.materials.len(),
                });
            }
            let shape = Shape::new(&object.shape);
            let role = Role::Surface { finish: object.material as u32, solid: shape.is_solid() };
            things.push(Thing { shape, role });
        }
        for (i, light) in scene.lights.iter().enumerate() {
            let shape = match *light {
                Light::Disk { center, normal, radius, .. } => {
                    Shape::Disk(Disk::new(center, normal, radius).one_sided())
                }
                Light::Sphere { center, radius, .. } => Shape::Sphere(Sphere::new(center, radius)),
                Light::Point { .. } | Light::Sun { .. } => continue,
            };
            things.push(Thing { shape, role: Role::Lamp(i as u32) });
        }
        if u32::try_from(things.len()).is_err() {
            return Err(RenderError::TooManyObjects);
        }
        let finishes: Vec<_> = scene.materials.iter().map(Finish::new).collect();
        let kind = |thing: &Thing| match thing.role {
            Role::Lamp(_) => Kind::Lamp,
            Role::Surface { finish, .. } if finishes[finish as usize].is_clear() => Kind::Clear,
            Role::Surface { .. } => Kind::Opaque,
        };
        let numbered = || (0_u32..).zip(&things);
        let tree = |accept: &dyn Fn(Kind) -> bool| {
            Bvh::new(
                numbered()
                    .filter(|(_, thing)| accept(kind(thing)))
                    .filter_map(|(i, thing)| Some((i, thing.shape.bounds()?))),
            )
        };
        let planes = |wanted: Kind| {
            numbered()
                .filter(|(_, thing)| thing.shape.bounds().is_none() && kind(thing) == wanted)
                .map(|(i, _)| i)
                .collect()
        };
        let lamps: Vec<_> = scene.lights.iter().map(Lamp::new).collect();
        let sky = Heaven::new(&scene.sky);
        let seen = lamps.iter().map(Lamp::radiance).chain(sky.extremes());
        let brightest = seen.map(Rgb::max_channel).fold(0.0, f64::max);
        let white = 1.0 / scene.film.exposure;
        Ok(Self {
            lamps,
            sky,
            white,
            brightest: brightest.max(white),
            visible: tree(&|_| true),
            opaque: tree(&|kind| kind == Kind::Opaque),
            clear: tree(&|kind| kind == Kind::Clear),
            opaque_planes: planes(Kind::Opaque),
            clear_planes: planes(Kind::Clear),
            finishes,
            things,
        })
    }

    #[inline]
    pub(crate) fn role(&self, thing: u32) -> Role {
        self.things[thing as usize].role
    }

    #[inline]
    pub(crate) fn finish(&self, finish: u32) -> &Finish {
        &self.finishes[finish as usize]
    }

    /// The absorption and the index of refraction inside a thing of glass.
    #[inline]
    pub(crate) fn glass(&self, thing: u32) -> (Rgb, f64) {
        match self.role(thing) {
            Role::Surface { finish, .. } => match *self.finish(finish) {
                Finish::Glass { absorption, ior } => (absorption, ior),
                _ => (Rgb::BLACK, 1.0),
            },
            Role::Lamp(_) => (Rgb::BLACK, 1.0),
        }
    }

    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, contact: &Contact) -> Interaction {
        self.things[contact.thing as usize].shape.interaction(ray, &contact.hit)
    }

    /// The first thing that the ray meets.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<Contact> {
        let mut ray = *ray;
        let mut best = None;
        for &thing in self.opaque_planes.iter().chain(&self.clear_planes) {
            self.try_thing(thing, &mut ray, &mut best);
        }
        self.visible.walk(&mut ray, |thing, ray| {
            self.try_thing(thing, ray, &mut best);
            false
        });
        best
    }

    #[inline]
    fn try_thing(&self, thing: u32, ray: &mut Ray, best: &mut Option<Contact>) {
        if let Some(hit) = self.things[thing as usize].shape.closest(ray) {
            ray.t_max = hit.t;
            *best = Some(Contact { thing, hit });
        }
    }

    /// Whether something that is not clear stands in the ray's range. Lamps never do.
    #[inline]
    fn is_blocked(&self, ray: &Ray) -> bool {
        let blocks = |thing: u32, ray: &Ray| self.things[thing as usize].shape.any(ray);
        self.opaque_planes.iter().any(|&plane| blocks(plane, ray))
            || self.opaque.walk(&mut { *ray }, |thing, ray| blocks(thing, ray))
    }

    /// The share of the light that passes along the ray's range: none if something opaque is in the
    /// way; clear glass is passed straight, without refraction, and takes what its two sides
    /// reflect and what its colour absorbs. The ray's direction is of unit length.
    #[inline]
    pub(crate) fn transmittance(&self, ray: &Ray) -> Rgb {
        if self.is_blocked(ray) {
            return Rgb::BLACK;
        }
        if self.clear.is_empty() && self.clear_planes.is_empty() {
            return Rgb::WHITE;
        }
        self.clear_transmittance(ray)
    }

    /// All surfaces of glass count alike, in any order: no matter how bodies overlap.
    fn clear_transmittance(&self, ray: &Ray) -> Rgb {
        let mut passed = 1.0;
        // The optical depth is the sum of absorption times where a ray leaves less where it enters.
        let mut depth = Rgb::BLACK;
        let mut open = Rgb::BLACK;
        let mut hits = Vec::new();
        let mut pass = |thing: u32| {
            let shape = &self.things[thing as usize].shape;
            shape.all(ray, &mut hits);
            if hits.is_empty() {
                return;
            }
            let (absorption, ior) = self.glass(thing);
            let solid = matches!(self.role(thing), Role::Surface { solid: true, .. });
            for hit in &hits {
                let cos = shape.normal(ray, hit).dot(ray.direction);
                // Seen from the air on both sides: straight through a pane, that is the truth.
                let reflectance = fresnel::from_air(cos.abs().min(1.0), ior);
                if solid {
                    passed *= 1.0 - reflectance;
                    let sign = 1.0_f64.copysign(cos);
                    depth += absorption * (sign * hit.t);
                    open += absorption * -sign;
                } else {
                    passed *= 1.0 - fresnel::sheet(reflectance);
                }
            }
        };
        self.clear_planes.iter().for_each(|&plane| pass(plane));
        self.clear.walk(&mut { *ray }, |thing, _| {
            pass(thing);
            false
        });
        if ray.t_max < f64::INFINITY {
            depth += open.map(|v| v.max(0.0)) * ray.t_max;
        }
        depth.map(|v| (-v.max(0.0)).exp()) * passed
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Opaque,
    Clear,
    Lamp,
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rondure::{Affine, Instance, Profile, Surface, Vec3};
    use rondure_scene::Shape as Described;

    use super::*;
    use crate::{
        sampler::{Key, Sample},
        shape::Shape,
        warp::{self, Frame},
    };

    fn convex_shapes(center: Vec3, size: f64) -> Vec<Described> {
        let ball = Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap();
        let placement = Affine::translate(center)
            .after(&Affine::rotate(Vec3::new(1.0, 2.0, 0.5), 0.4))
            .after(&Affine::scale(Vec3::new(size, 0.7 * size, 1.2 * size)));
        let edges = [Vec3::new(1.3, 0.4, 0.0) * size, Vec3::new(-0.3, 0.7, 0.9) * size];
        let normal = Vec3::new(0.3, -1.0, 0.9).normalized();
        vec![
            Described::Sphere { center, radius: size },
            Described::Disk { center, normal, radius: size },
            Described::Rectangle { center, edges },
            Described::Plane { point: center, normal },
            Described::Turned(Instance::new(Arc::new(Surface::new(&ball)), placement).unwrap()),
        ]
    }

    /// From points of convex shapes, found from near and from far away, no ray that leaves on the
    /// outside meets the shape again, however flat it leaves.
    #[test]
    fn rays_that_leave_convex_shapes_do_not_come_back() {
        let mut tried = 0;
        for size in [1e-3, 1.0, 1e4] {
            for offset in [0.0, 1e3, 1e6] {
                let center = Vec3::new(1.0, -0.7, 0.3) * (offset * size);
                for described in convex_shapes(center, size) {
                    let shape = Shape::new(&described);
                    for i in 0..4000 {
                        let sample = Sample::new(3, i, 0, 0, 1);
                        let distance = if i % 2 == 0 { 3.0 } else { 1e5 } * size;
                        let outwards = warp::cap(sample.pair(Key::ROOT), 2.0);
                        let aim = warp::cap(sample.pair(Key::LENS), 2.0) * (0.9 * size);
                        let origin = center + outwards * distance;
                        let ray = Ray::new(origin, (center + aim - origin).normalized());
                        let Some(hit) = shape.closest(&ray) else { continue };
                        let surface = shape.interaction(&ray, &hit);
                        let out = if surface.normal.dot(ray.direction) > 0.0 {
                            -surface.normal
                        } else {
                            surface.normal
                        };
                        let up = warp::cosine_hemisphere(sample.pair(Key::FILTER));
                        for flat in [1.0, 1e-3, 1e-8, 1e-15] {
                            let direction = Vec3::new(up.x, up.y, up.z * flat).normalized();
                            let direction = Frame::new(out).to_world(direction);
                            if !(direction.dot(out) > 0.0) {
                                continue;
                            }
                            tried += 1;
                            assert!(
                                !shape.any(&surface.spawn(direction)),
                                "{described:?} {ray:?} {surface:?} {direction:?}"
                            );
                        }
                    }
                }
            }
        }
        assert!(tried > 100_000);
    }

    /// A ray that goes into a body comes out of it once.
    #[test]
    fn rays_that_enter_solids_leave_them() {
        for size in [1e-3, 1.0, 1e4] {
            let center = Vec3::new(1.0, -0.7, 0.3) * (100.0 * size);
            for described in convex_shapes(center, size) {
                let shape = Shape::new(&described);
                if !shape.is_solid() {
                    continue;
                }
                for i in 0..2000 {
                    let sample = Sample::new(3, i, 0, 0, 1);
                    let outwards = warp::cap(sample.pair(Key::ROOT), 2.0);
                    let ray = Ray::new(center + outwards * (4.0 * size), -outwards);
                    let hit = shape.closest(&ray).unwrap();
                    let surface = shape.interaction(&ray, &hit);
                    let up = warp::cosine_hemisphere(sample.pair(Key::FILTER));
                    let inwards = Frame::new(-surface.normal).to_world(up);
                    let inner = surface.spawn(inwards);
                    let hit = shape.closest(&inner).unwrap();
                    let far = shape.interaction(&inner, &hit);
                    assert!(far.normal.dot(inwards) > 0.0, "{described:?} {i}");
                    assert!(shape.closest(&far.spawn(inwards)).is_none(), "{described:?} {i}");
                }
            }
        }
    }
}

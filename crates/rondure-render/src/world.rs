//! The world that rays see: shapes behind trees of boxes, lights and sky.
//!
//! Three trees: one over all that the eye can see, one over what blocks light, one over clear
//! glass, through which shadow rays pass. Planes have no box and are tested one by one.

use rondure::{Hit, Interaction, Ray, Vec3};
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
    visible: Bvh,
    opaque: Bvh,
    clear: Bvh,
    opaque_planes: Vec<u32>,
    clear_planes: Vec<u32>,
}

/// How many surfaces of clear glass a shadow ray passes; what lies behind more is in shadow.
const MAX_CLEAR_SURFACES: u32 = 256;

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
        Ok(Self {
            lamps: scene.lights.iter().map(Lamp::new).collect(),
            sky: Heaven::new(&scene.sky),
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
        self.clear_transmittance(*ray)
    }

    fn clear_transmittance(&self, mut ray: Ray) -> Rgb {
        let mut passed = 1.0;
        // The optical depth is the sum of absorption times where a ray leaves less where it enters,
        // in any order: no matter how bodies overlap.
        let mut depth = Rgb::BLACK;
        let mut open = Rgb::BLACK;
        let mut travelled = 0.0;
        for _ in 0..MAX_CLEAR_SURFACES {
            let Some(contact) = self.closest_clear(&ray) else {
                if ray.t_max < f64::INFINITY {
                    depth += open.map(|v| v.max(0.0)) * (travelled + ray.t_max);
                }
                return depth.map(|v| (-v.max(0.0)).exp()) * passed;
            };
            let interaction = self.interaction(&ray, &contact);
            let (absorption, ior) = self.glass(contact.thing);
            let cos = interaction.normal.dot(ray.direction);
            // Seen from the air on both sides: straight through a pane, that is the truth.
            let reflectance = fresnel::from_air(cos.abs().min(1.0), ior);
            let at = travelled + contact.hit.t;
            if let Role::Surface { solid: true, .. } = self.role(contact.thing) {
                passed *= 1.0 - reflectance;
                let sign = 1.0_f64.copysign(cos);
                depth += absorption * (sign * at);
                open += absorption * -sign;
            } else {
                passed *= 1.0 - fresnel::sheet(reflectance);
            }
            let range = ray.t_max - contact.hit.t;
            ray = interaction.leave(ray.direction).with_range(0.0, range);
            travelled = at;
        }
        Rgb::BLACK
    }

    fn closest_clear(&self, ray: &Ray) -> Option<Contact> {
        let mut ray = *ray;
        let mut best = None;
        for &thing in &self.clear_planes {
            self.try_thing(thing, &mut ray, &mut best);
        }
        self.clear.walk(&mut ray, |thing, ray| {
            self.try_thing(thing, ray, &mut best);
            false
        });
        best
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Opaque,
    Clear,
    Lamp,
}

/// Leaving a surface.
pub(crate) trait Leave {
    /// The ray that leaves in this direction, starting clear of the surface.
    fn leave(&self, direction: Vec3) -> Ray;
}

impl Leave for Interaction {
    #[inline]
    fn leave(&self, direction: Vec3) -> Ray {
        let side = self.error.copysign(direction.dot(self.normal));
        let away = |p: f64, offset: f64| {
            let moved = p + offset;
            if offset > 0.0 {
                moved.next_up()
            } else if offset < 0.0 {
                moved.next_down()
            } else {
                moved
            }
        };
        let (p, offset) = (self.point, self.normal * side);
        let origin = Vec3::new(away(p.x, offset.x), away(p.y, offset.y), away(p.z, offset.z));
        Ray::new(origin, direction)
    }
}

//! The world that rays see: things behind trees of boxes, lights and sky.
//!
//! Two trees, if there are more than a few things: one over what blocks light, one over what lets it pass, clear glass and lamps. Bodies,
//! which may be of several materials, have a third.

mod batch;
mod shadow;

use std::collections::HashMap;

use rondure::{Bounds, Bvh, Footing, Hit, Instance, Interaction, Ray, Vec3};

use rondure_scene::{Integrator, Light, Scene, Shape as Described};

pub(crate) use self::{batch::Batch, shadow::transmitted};
use crate::{
    RenderError,
    bodies::{Bodies, Place},
    color::Rgb,
    few::Few,
    finish::Finish,
    gather::{Gathered, materials},
    light::{Heaven, Lamp, Shining},
    optics::Optics,
    shape::{Disk, Shape, Sphere},
    texture::{Own, Pattern, Relief, Spot},
    things::Things,
};

/// The most things that shine and are looked for as lamps; what more there are, is found by chance.
const MOST_SHINING: usize = 256;

/// What a thing is in the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Role {
    /// A surface: the index of its finish, and whether it has an inside.
    Surface { finish: u32, solid: bool },
    /// The body of a lamp.
    Lamp(u32),
}

/// Where a ray meets the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// The number of the thing, or behind all things that of the body.
    pub(crate) thing: u32,
    pub(crate) t: f64,
    on: On,
}

/// What a contact is on.
#[derive(Clone, Copy, Debug)]
enum On {
    Thing(Hit),
    Body(Place),
}

/// Few things in lists.
#[derive(Clone, Debug)]
struct Lists {
    all: Few,
    /// For rays towards lamps: what is clear stands in boxes.
    shadows: Few,
    /// There, the boxes of what blocks light, and of surfaces that let it pass.
    blocking: u32,
    passing: u32,
}

/// Everything that rays ask about a scene.
#[derive(Clone, Debug)]
pub(crate) struct World {
    things: Things,
    /// For each thing the index of its role in `roles`: those of the objects, then of the lights.
    role_of: Vec<u32>,
    roles: Vec<Role>,
    /// For each body the index of its object in the scene.
    body_objects: Vec<u32>,
    /// The own frame of each body; `None` for flat ones.
    body_frames: Vec<Option<Own>>,
    /// For each role the first thing, and for each object the first body.
    first_things: Vec<u32>,
    first_bodies: Vec<u32>,
    finishes: Vec<Finish>,
    /// The same materials for the path tracer.
    optics: Vec<Optics>,
    /// Of things that shine, and are looked for as lamps, the number of the lamp.
    shining: HashMap<u32, u32>,
    /// The reliefs of finishes that have one.
    reliefs: Vec<Option<Relief>>,
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) sky: Heaven,
    /// The radiance that comes out white in the picture.
    pub(crate) white: f64,
    /// The most radiance that a ray can meet; at least white.
    pub(crate) brightest: f64,
    blocking: Bvh,
    passing: Bvh,
    /// Lists in the place of those trees, if things are few.
    few: Option<Lists>,
    bodies: Option<Bodies>,
    has_glass: bool,
}

impl World {
    pub(crate) fn new(scene: &Scene) -> Result<Self, RenderError> {
        let mut builder = Gathered::default();
        let turned = scene.objects.iter().filter(|o| matches!(o.shape, Described::Turned(_)));
        let count = turned.map(|o| o.copies.count()).fold(0, u64::saturating_add);
        builder.reserve(count).ok_or(RenderError::OutOfMemory { count })?;
        for (object, role) in scene.objects.iter().zip(0..) {
            for material in materials(object).chain(scene.section.iter().filter_map(|s| s.material))
            {
                if material >= scene.materials.len() {
                    return Err(RenderError::NoSuchMaterial {
                        object: object.name.clone(),
                        material,
                        materials: scene.materials.len(),
                    });
                }
            }
            builder.add(object, role, &scene.section)?;
        }
        for (light, role) in scene.lights.iter().zip(scene.objects.len() as u32..) {
            let shape = match *light {
                Light::Disk { center, normal, radius, .. } => {
                    Shape::Disk(Disk::new(center, normal, radius).one_sided())
                }
                Light::Sphere { center, radius, .. } => Shape::Sphere(Sphere::new(center, radius)),
                Light::Point { .. } | Light::Sun { .. } => continue,
            };
            builder.add_simple(shape, role);
        }
        let Gathered {
            things,
            turned_roles: mut role_of,
            simple_roles,
            body_objects,
            body_placements,
            bodies,
            ..
        } = builder;
        role_of.extend(simple_roles);
        let body_frames = body_placements.iter().map(|p| p.as_ref().map(Own::of)).collect();
        let finishes: Vec<_> = scene.materials.iter().map(Finish::new).collect();
        let optics: Vec<_> = scene.materials.iter().map(Optics::new).collect();
        let bodies = bodies.build(&finishes)?;
        let mut roles: Vec<_> = scene
            .objects
            .iter()
            .map(|object| Role::Surface { finish: object.material as u32, solid: false })
            .collect();
        roles.extend((0..scene.lights.len() as u32).map(Role::Lamp));
        let mut has_glass = bodies.as_ref().is_some_and(Bodies::has_clear);
        for (thing, &role) in (0..).zip(&role_of) {
            if let Role::Surface { finish, solid } = &mut roles[role as usize] {
                *solid = things.is_solid(thing);
                has_glass |= finishes[*finish as usize].is_clear();
            }
        }
        let is_clear = |thing: u32| match roles[role_of[thing as usize] as usize] {
            Role::Surface { finish, .. } => Some(finishes[finish as usize].is_clear()),
            Role::Lamp(_) => None,
        };
        let blocks = |thing| is_clear(thing) == Some(false);
        let few = Few::new(&things, |_| true).and_then(|all| {
            let shadows = Few::new(&things, blocks)?;
            let blocking = shadows.boxes(blocks);
            let passing = shadows.boxes(|thing| is_clear(thing) == Some(true));
            Some(Lists { all, shadows, blocking, passing })
        });
        // What has an empty box is never met.
        let tree = |of_blocking: bool| {
            let bounds = |thing| {
                if blocks(thing) == of_blocking { things.bounds(thing) } else { Bounds::EMPTY }
            };
            Bvh::new(things.len(), bounds)
        };
        let (blocking, passing) = (tree(true)?, tree(false)?);
        let mut lamps: Vec<_> = scene.lights.iter().map(Lamp::new).collect();
        let mut shining = HashMap::new();
        if scene.film.integrator != Integrator::Whitted {
            for thing in 0..things.turned.len() as u32 {
                let Role::Surface { finish, .. } = roles[role_of[thing as usize] as usize] else {
                    continue;
                };
                let emission = optics[finish as usize].emission;
                if emission.is_black() || shining.len() >= MOST_SHINING {
                    continue;
                }
                let turned = &things.turned;
                let placed = Instance::new(turned.surface(thing).clone(), *turned.placement(thing));
                if let Some(found) = placed.and_then(|placed| Shining::new(&placed, emission)) {
                    shining.insert(thing, lamps.len() as u32);
                    lamps.push(Lamp::Turned(Box::new(found)));
                }
            }
        }
        let sky = Heaven::new(&scene.sky);
        let seen = lamps.iter().map(Lamp::radiance).chain(sky.extremes());
        let brightest = seen.map(Rgb::max_channel).fold(0.0, f64::max);
        let white = 1.0 / scene.film.exposure;
        Ok(Self {
            few,
            things,
            roles,
            first_things: firsts(&role_of, scene.objects.len() + scene.lights.len()),
            first_bodies: firsts(&body_objects, scene.objects.len()),
            role_of,
            body_objects,
            body_frames,
            reliefs: scene.reliefs.iter().map(|r| r.as_ref().map(Relief::new)).collect(),
            finishes,
            optics,
            shining,
            lamps,
            sky,
            white,
            brightest: brightest.max(white),
            blocking,
            passing,
            bodies,
            has_glass,
        })
    }

    #[inline]
    fn role(&self, thing: u32) -> Role {
        self.roles[self.role_of[thing as usize] as usize]
    }

    /// What a ray meets at a contact.
    #[inline]
    pub(crate) fn met(&self, ray: &Ray, contact: &Contact) -> Role {
        match (&contact.on, &self.bodies) {
            (On::Body(place), Some(bodies)) => {
                let body = self.body(contact);
                let finish = bodies.finish_at(body, place, ray.at(contact.t));
                Role::Surface { finish, solid: bodies.is_solid(body) }
            }
            _ => self.role(contact.thing),
        }
    }

    /// The index in the scene of the object that a contact is on; lamps come behind all objects.
    pub(crate) fn object(&self, contact: &Contact) -> u32 {
        match contact.on {
            On::Body(_) => self.body_objects[self.body(contact) as usize],
            On::Thing(_) => self.role_of[contact.thing as usize],
        }
    }

    /// The own frame of what a contact is on.
    fn own(&self, contact: &Contact, at: &Interaction) -> Own {
        match contact.on {
            On::Body(_) => {
                self.body_frames[self.body(contact) as usize].unwrap_or_else(|| Own::flat(at))
            }
            On::Thing(_) => self.things.own(contact.thing, at),
        }
    }

    /// The spot that patterns are looked up at, seen from the direction `outgoing`.
    pub(crate) fn spot(&self, contact: &Contact, at: &Interaction, outgoing: Vec3) -> Spot {
        let copy = match contact.on {
            On::Body(_) => {
                let body = self.body(contact);
                body - self.first_bodies[self.body_objects[body as usize] as usize]
            }
            On::Thing(_) => {
                let role = self.role_of[contact.thing as usize];
                contact.thing - self.first_things[role as usize]
            }
        };
        self.own(contact, at).spot(at, outgoing, copy)
    }

    /// The normal that light sees there: that of the surface, turned by the relief of its finish. It is on the
    /// same side.
    pub(crate) fn shading_normal(
        &self,
        finish: u32,
        contact: &Contact,
        at: &Interaction,
        spot: &Spot,
        outgoing: Vec3,
    ) -> Vec3 {
        match self.reliefs.get(finish as usize) {
            Some(Some(relief)) => self.own(contact, at).shading_normal(relief, spot, at, outgoing),
            _ => at.normal,
        }
    }

    /// The colour of a pattern where a ray meets a surface, whose normal there is `normal`, and the normal that light sees, on the same side.
    /// Most surfaces have one colour and no relief: then nothing is looked up.
    #[inline]
    pub(crate) fn seen(
        &self,
        ray: &Ray,
        contact: &Contact,
        finish: u32,
        pattern: &Pattern,
        normal: Vec3,
    ) -> (Rgb, Vec3) {
        match pattern.plain() {
            Some(color) if !self.has_relief(finish) => (color, normal),
            _ => self.looked_up(ray, contact, finish, pattern),
        }
    }

    #[inline(never)]
    fn looked_up(
        &self,
        ray: &Ray,
        contact: &Contact,
        finish: u32,
        pattern: &Pattern,
    ) -> (Rgb, Vec3) {
        let (surface, outgoing) = (self.interaction(ray, contact), -ray.direction);
        let spot = self.spot(contact, &surface, outgoing);
        let normal = self.shading_normal(finish, contact, &surface, &spot, outgoing);
        (pattern.at(&spot), normal)
    }

    /// Whether a finish has a relief.
    #[inline]
    fn has_relief(&self, finish: u32) -> bool {
        matches!(self.reliefs.get(finish as usize), Some(Some(_)))
    }

    fn body(&self, contact: &Contact) -> u32 {
        contact.thing - self.things.len() as u32
    }

    #[inline]
    pub(crate) fn finish(&self, finish: u32) -> &Finish {
        &self.finishes[finish as usize]
    }

    #[inline]
    pub(crate) fn optics(&self, finish: u32) -> &Optics {
        &self.optics[finish as usize]
    }

    /// How many things and bodies there are.
    pub(crate) fn count(&self) -> usize {
        self.things.len() + self.bodies.as_ref().map_or(0, Bodies::len)
    }

    /// The box round a thing, or behind all things a body.
    pub(crate) fn bounds(&self, thing: u32) -> Bounds {
        match (thing as usize).checked_sub(self.things.len()) {
            None => self.things.bounds(thing),
            Some(body) => {
                self.bodies.as_ref().map_or(Bounds::EMPTY, |bodies| bodies.bounds(body as u32))
            }
        }
    }

    /// The greatest share of light that some surface of a thing sends on by narrow lobes, about; `None`
    /// for a lamp.
    pub(crate) fn focus(&self, thing: u32) -> Option<f64> {
        let body = (thing as usize).checked_sub(self.things.len());
        match (body, &self.bodies) {
            (Some(body), Some(bodies)) => {
                let focus = bodies.finishes(body as u32).map(|f| self.optics(f).focus());
                Some(focus.fold(0.0, f64::max))
            }
            _ => match self.role(thing) {
                Role::Surface { finish, .. } => Some(self.optics(finish).focus()),
                Role::Lamp(_) => None,
            },
        }
    }

    /// Whether photons can come to rest anywhere.
    pub(crate) fn is_some_surface_wide(&self) -> bool {
        self.optics.iter().any(Optics::is_wide)
    }

    /// One of the lamps for a place, in proportion to how much each may light it, and its probability. `choice` makes a number
    /// between 0 and 1.
    pub(crate) fn choose_lamp(
        &self,
        at: Vec3,
        choice: impl FnOnce() -> f64,
    ) -> Option<(usize, f64)> {
        if self.lamps.len() <= 1 {
            return (!self.lamps.is_empty()).then_some((0, 1.0));
        }
        let sum: f64 = self.lamps.iter().map(|lamp| lamp.importance(at)).sum();
        let mut left = choice() * sum;
        let mut last = None;
        for (i, lamp) in self.lamps.iter().enumerate() {
            let importance = lamp.importance(at);
            if importance > 0.0 {
                last = Some((i, importance / sum));
                left -= importance;
                if left < 0.0 {
                    break;
                }
            }
        }
        last
    }

    /// The probability with which [`choose_lamp`](Self::choose_lamp) finds a lamp.
    pub(crate) fn lamp_share(&self, at: Vec3, lamp: usize) -> f64 {
        if self.lamps.len() == 1 {
            return 1.0;
        }
        let sum: f64 = self.lamps.iter().map(|lamp| lamp.importance(at)).sum();
        if sum > 0.0 { self.lamps[lamp].importance(at) / sum } else { 0.0 }
    }

    /// The number of the lamp that a thing is.
    #[inline]
    pub(crate) fn lamp_of(&self, thing: u32) -> Option<u32> {
        self.shining.get(&thing).copied()
    }

    /// The absorption and the index of refraction of glass.
    #[inline]
    pub(crate) fn glass(&self, finish: u32) -> (Rgb, f64) {
        match *self.finish(finish) {
            Finish::Glass { absorption, ior } => (absorption, ior),
            _ => (Rgb::BLACK, 1.0),
        }
    }

    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, contact: &Contact) -> Interaction {
        match (&contact.on, &self.bodies) {
            (On::Body(place), Some(bodies)) => bodies.interaction(self.body(contact), ray, place),
            // Only a world with bodies makes such contacts, and they do not leave it.
            (On::Body(_), None) => unreachable!("a contact with a body of another world"),
            (On::Thing(hit), _) => self.things.interaction(contact.thing, ray, hit),
        }
    }

    /// The place and the normal of a contact, alone.
    #[inline]
    pub(crate) fn footing(&self, ray: &Ray, contact: &Contact) -> Footing {
        match &contact.on {
            On::Thing(hit) => self.things.footing(contact.thing, ray, hit),
            On::Body(_) => self.interaction(ray, contact).footing(),
        }
    }

    /// The first thing that the ray meets; of several at the same place the one with the smallest
    /// number.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<Contact> {
        let mut best: Option<(u32, Hit)> = None;
        let mut shortened = *ray;
        if let Some(few) = &self.few
            && let Some((thing, t)) = few.all.flats().closest(ray)
        {
            best = Some((thing, Hit { t, piece: 0, s: 0.0 }));
            shortened.t_max = t;
        }
        let start = shortened;
        let mut visit = |thing| {
            if let Some(hit) = self.things.closest(thing, &shortened) {
                if best.is_none_or(|best| hit.t < best.1.t || thing < best.0) {
                    best = Some((thing, hit));
                }
                shortened.t_max = hit.t;
            }
            shortened.t_max
        };
        match &self.few {
            Some(few) => few.all.walk(&start, visit),
            None => {
                let mut cut = *ray;
                for tree in [&self.blocking, &self.passing] {
                    tree.walk(&{ cut }, |thing| {
                        cut.t_max = visit(thing);
                        cut.t_max
                    });
                }
            }
        }
        self.or_body(best, shortened)
    }

    /// The nearest of a thing, which a ray was shortened to, and the bodies.
    #[inline]
    fn or_body(&self, thing: Option<(u32, Hit)>, mut shortened: Ray) -> Option<Contact> {
        let thing = thing.map(|(thing, hit)| Contact { thing, t: hit.t, on: On::Thing(hit) });
        let Some(bodies) = &self.bodies else { return thing };
        match bodies.closest(&mut shortened) {
            Some((body, t, place)) if thing.is_none_or(|thing| t < thing.t) => {
                let number = self.things.len() as u32 + body;
                Some(Contact { thing: number, t, on: On::Body(place) })
            }
            _ => thing,
        }
    }
}

/// For each of `count` values the index of the first one that has it; 0 if none has.
fn firsts(values: &[u32], count: usize) -> Vec<u32> {
    let mut first = vec![0; count];
    for (i, &value) in values.iter().enumerate().rev() {
        first[value as usize] = i as u32;
    }
    first
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rondure::{Affine, Instance, Profile, Surface};
    use rondure_scene::{Copies, Cut, Object, Shape as Described};

    use super::*;
    use crate::{
        sampler::{Key, Sample},
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

    /// The shape as the only thing.
    fn alone(shape: &Described) -> Things {
        let mut builder = Gathered::default();
        let copies = Copies::default();
        let (shape, section) = (shape.clone(), Cut::default());
        let object = Object { name: String::new(), shape, material: 0, copies, section };
        builder.add(&object, 0, &[]).unwrap();
        builder.things
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
                    let shape = alone(&described);
                    for i in 0..4000 {
                        let sample = Sample::new(3, i, 0, 0);
                        let distance = if i % 2 == 0 { 3.0 } else { 1e5 } * size;
                        let outwards = warp::cap(sample.pair(Key::ROOT), 2.0);
                        let aim = warp::cap(sample.pair(Key::LENS), 2.0) * (0.9 * size);
                        let origin = center + outwards * distance;
                        let ray = Ray::new(origin, (center + aim - origin).normalized());
                        let Some(hit) = shape.closest(0, &ray) else { continue };
                        let surface = shape.interaction(0, &ray, &hit);
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
                                !shape.any(0, &surface.spawn(direction)),
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
                let shape = alone(&described);
                if !shape.is_solid(0) {
                    continue;
                }
                for i in 0..2000 {
                    let sample = Sample::new(3, i, 0, 0);
                    let outwards = warp::cap(sample.pair(Key::ROOT), 2.0);
                    let ray = Ray::new(center + outwards * (4.0 * size), -outwards);
                    let hit = shape.closest(0, &ray).unwrap();
                    let surface = shape.interaction(0, &ray, &hit);
                    let up = warp::cosine_hemisphere(sample.pair(Key::FILTER));
                    let inwards = Frame::new(-surface.normal).to_world(up);
                    let inner = surface.spawn(inwards);
                    let hit = shape.closest(0, &inner).unwrap();
                    let far = shape.interaction(0, &inner, &hit);
                    assert!(far.normal.dot(inwards) > 0.0, "{described:?} {i}");
                    assert!(shape.closest(0, &far.spawn(inwards)).is_none(), "{described:?} {i}");
                }
            }
        }
    }
}

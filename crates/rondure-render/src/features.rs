//! What the eye sees first along a ray, for the layers beside the light.
//!
//! Only where a film keeps it. Mirrors, clear glass and lamps have a white albedo: what they show is not theirs.

use rondure::Ray;
use rondure_film::{Center, Guide};

use crate::{
    camera::View,
    color::Rgb,
    finish::Finish,
    world::{Contact, Role, World},
};

/// Albedo and normal of what a ray meets.
pub(crate) fn guide(world: &World, ray: &Ray, met: Option<&Contact>) -> Guide {
    let Some(contact) = met else { return Guide::default() };
    let surface = world.interaction(ray, contact);
    let outgoing = -ray.direction;
    let spot = world.spot(contact, &surface, outgoing);
    let (albedo, shading) = match world.met(ray, contact) {
        Role::Lamp(_) => (Rgb::WHITE, surface.normal),
        Role::Surface { finish, .. } => {
            let albedo = match world.finish(finish) {
                Finish::Matte { color } | Finish::Glossy { color, .. } => color.at(&spot),
                Finish::Mirror { .. } | Finish::Glass { .. } => Rgb::WHITE,
            };
            (albedo, world.shading_normal(finish, contact, &surface, &spot, outgoing))
        }
    };
    let normal = if spot.front { shading } else { -shading };
    Guide { albedo: [albedo.r, albedo.g, albedo.b], normal: [normal.x, normal.y, normal.z] }
}

/// What the ray through the middle of a pixel and of the lens meets.
pub(crate) fn center(world: &World, view: &View, x: u32, y: u32) -> Center {
    let ray = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, (0.5, 0.5));
    let Some(contact) = world.closest(&ray) else { return Center::SKY };
    let point = world.interaction(&ray, &contact).point;
    let (object, material) = match world.met(&ray, &contact) {
        Role::Lamp(_) => (0, 0),
        Role::Surface { finish, .. } => (1 + world.object(&contact), 1 + finish),
    };
    let position = [point.x as f32, point.y as f32, point.z as f32];
    Center { depth: view.depth(point) as f32, position, object, material }
}

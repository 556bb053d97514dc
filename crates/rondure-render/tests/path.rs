//! The path tracer where closed forms tell what is to be seen: white furnaces, lamps, light through glass.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::{f64::consts::PI, sync::Arc};

use common::{BLACK, Build, WHITE, at, matte, mean, scene};
use rondure::{Affine, Instance, Profile, Surface, Vec3};
use rondure_render::Picture;
use rondure_scene::{
    Glass, Integrator, Light, Material, Paint, Principled, Projection, Scene, Shape,
};

const BALL: Shape = Shape::Sphere { center: Vec3::ZERO, radius: 1.0 };
const FLOOR: Shape = Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z };

fn principled() -> Principled {
    Principled {
        base_color: Paint::Solid([1.0; 3]),
        base_metalness: 0.0,
        specular_weight: 1.0,
        specular_roughness: 0.3,
        specular_ior: 1.5,
        transmission_weight: 0.0,
        transmission: Glass::clear([1.0; 3], 1.5),
        coat_weight: 0.0,
        coat_roughness: 0.0,
        coat_ior: 1.6,
        coat_color: [1.0; 3],
        fuzz_weight: 0.0,
        fuzz_color: [1.0; 3],
        fuzz_roughness: 0.5,
        emission: [0.0; 3],
    }
}

fn made(change: impl FnOnce(&mut Principled)) -> Material {
    let mut p = principled();
    change(&mut p);
    Material::Principled(Box::new(p))
}

/// A thing alone under a white sky.
fn furnace(shape: Shape, material: Material) -> f64 {
    let eye = Vec3::new(0.0, -6.0, 0.5);
    let mut scene = scene(16, 256, eye, Vec3::ZERO, Projection::Perspective { fov: 0.3 });
    scene.film.depth = 60;
    scene.film.integrator = Integrator::Path;
    mean(&scene.under(WHITE).with(shape, material).shoot())
}

/// The mean over a picture of a thing that returns all light is 1, whatever it is made of.
#[test]
fn white_things_vanish_in_a_white_room() {
    let glossy =
        |roughness| Material::Glossy { color: Paint::Solid([1.0; 3]), specular: 1.0, roughness };
    let glass = |roughness| Material::Glass(Glass { roughness, ..Glass::clear([1.0; 3], 1.5) });
    let metal = |roughness| made(|p| (p.base_metalness, p.specular_roughness) = (1.0, roughness));
    for (name, material) in [
        ("matte", matte(1.0)),
        ("smooth gloss", glossy(0.0)),
        ("rough gloss", glossy(0.6)),
        ("mirror", Material::Mirror { color: Paint::Solid([1.0; 3]) }),
        ("metal", metal(0.2)),
        ("rough metal", metal(0.9)),
        ("glass", glass(0.0)),
        ("dull glass", glass(0.3)),
        ("frosted glass", glass(0.8)),
        (
            "dispersive glass",
            Material::Glass(Glass { abbe: Some(20.0), ..Glass::clear([1.0; 3], 1.7) }),
        ),
        ("half metal", made(|p| p.base_metalness = 0.5)),
        ("coat on a matte base", made(|p| (p.coat_weight, p.specular_weight) = (1.0, 0.0))),
        (
            "rough coat on metal",
            made(|p| (p.coat_weight, p.coat_roughness, p.base_metalness) = (1.0, 0.4, 1.0)),
        ),
        ("fuzz", made(|p| (p.fuzz_weight, p.fuzz_roughness) = (1.0, 0.3))),
        ("fuzz on a coat", made(|p| (p.fuzz_weight, p.coat_weight) = (0.5, 0.7))),
        ("half glass", made(|p| p.transmission_weight = 0.5)),
    ] {
        let found = furnace(BALL, material);
        assert!((found - 1.0).abs() < 5e-3, "{name}: {found}");
    }
}

#[test]
fn glass_walls_vanish_in_a_white_room() {
    let goblet = Profile::from_path_data(include_str!("../../../profiles/goblet.path")).unwrap();
    let placement = Affine::translate(Vec3::new(0.0, 0.0, -0.5));
    let goblet = Instance::new(Arc::new(Surface::new(&goblet)), placement).unwrap();
    let found = furnace(Shape::Turned(goblet), Material::Glass(Glass::clear([1.0; 3], 1.5)));
    assert!((found - 1.0).abs() < 5e-3, "{found}");
}

/// The floor seen from above, `height` units across.
fn from_above(size: u32, spp: u32, height: f64) -> Scene {
    let eye = Vec3::new(0.0, 0.0, 100.0);
    let mut scene = scene(size, spp, eye, Vec3::ZERO, Projection::Orthographic { height });
    scene.camera.up = Vec3::Y;
    scene.film.integrator = Integrator::Path;
    scene
}

#[test]
fn lamps_light_a_floor_by_their_closed_forms() {
    let (center, radius) = (Vec3::new(0.0, 0.0, 2.0), 0.5);
    let disk = Light::Disk { center, normal: -Vec3::Z, radius, radiance: [1.0; 3] };
    let sphere = Light::Sphere { center, radius, radiance: [1.0; 3] };
    for (light, irradiance) in [(disk, PI * 0.25 / 4.25), (sphere, PI * 0.0625)] {
        let mut scene = from_above(8, 256, 0.02).with(FLOOR, matte(0.5)).lit(light);
        // From below the lamp, which would hide the floor.
        scene.camera.eye = Vec3::new(0.0, 0.0, 1.0);
        let found = mean(&scene.shoot());
        let expected = 0.5 * irradiance / PI;
        assert!((found - expected).abs() < 5e-3 * expected, "{found} {expected}");
    }
}

/// A light between two parallel walls of a closed room, all of one reflectance: the radiance is that of an
/// endless series, E / (1 - rho) for emission E everywhere.
#[test]
fn light_goes_on_from_wall_to_wall() {
    let mut scene = scene(8, 1024, Vec3::ZERO, Vec3::Y, Projection::Perspective { fov: 0.5 });
    scene.film.depth = 60;
    scene.film.integrator = Integrator::Path;
    let wall = made(|p| {
        p.base_color = Paint::Solid([0.6; 3]);
        p.specular_weight = 0.0;
        p.emission = [0.25; 3];
    });
    let found = mean(&scene.under(BLACK).with(BALL, wall).shoot());
    let expected = 0.25 / (1.0 - 0.6);
    assert!((found - expected).abs() < 5e-3 * expected, "{found} {expected}");
}

/// Under a slab of glass the sun straight above lights as much as passes its two sides, all ways to and fro
/// added up: (1 - R) / (1 + R). The floor is black to the slab, so none comes back.
#[test]
fn photons_bring_what_passes_a_slab() {
    let slab = Profile::from_path_data("M 0 1 L 3 1 L 3 1.5 L 0 1.5").unwrap();
    let slab = Instance::new(Arc::new(Surface::new(&slab)), Affine::IDENTITY).unwrap();
    let sun = Light::Sun { direction: Vec3::Z, irradiance: [2.0; 3], angular_radius: 0.0 };
    let mut scene = from_above(8, 64, 1.0)
        .with(FLOOR, matte(0.1))
        .with(Shape::Turned(slab), Material::Glass(Glass::clear([1.0; 3], 1.5)))
        .lit(sun);
    // Between the slab and the floor.
    scene.camera.eye = Vec3::new(0.0, 0.0, 0.5);
    let found = mean(&scene.shoot());
    let reflectance = 0.04;
    let direct = 0.1 / PI * 2.0 * (1.0 - reflectance) / (1.0 + reflectance);
    // The slab mirrors the floor back onto it, about by the reflectance of glass for even light, 2 x 0.092.
    let expected = direct * (1.0 + 0.1 * 0.157);
    assert!((found - expected).abs() < 0.02 * expected, "{found} {expected}");
    // The reference sends no photons, and no path meets the sun: what is left came past the slab.
    scene.film.integrator = Integrator::Reference;
    let found = mean(&scene.shoot());
    assert!(found < 0.01 * expected, "{found} {expected}");
}

/// What a lamp sends through a ball of glass onto a floor is the same by photons and, slowly, by chance, as the reference
/// has it; and the same lamp as a thing that shines is nothing that photons come from.
#[test]
fn photons_and_chance_agree() {
    let ball = Shape::Sphere { center: Vec3::new(0.0, 0.0, 1.5), radius: 1.0 };
    let glass = || Material::Glass(Glass::clear([1.0; 3], 1.5));
    let (center, radius) = (Vec3::new(0.0, 0.0, 5.0), 1.5);
    let look = || {
        let eye = Vec3::new(0.0, -9.0, 4.0);
        let mut scene = scene(12, 1024, eye, Vec3::ZERO, Projection::Perspective { fov: 0.25 });
        scene.film.integrator = Integrator::Path;
        scene.with(FLOOR, matte(0.5)).with(ball.clone(), glass())
    };
    let lamp = Light::Sphere { center, radius, radiance: [4.0; 3] };
    let mut scene = look().lit(lamp);
    let by_photons = mean(&scene.shoot());
    scene.film.integrator = Integrator::Reference;
    let reference = mean(&scene.shoot());
    assert!((by_photons - reference).abs() < 0.02 * reference, "{by_photons} {reference}");
    let shining = made(|p| {
        p.emission = [4.0; 3];
        p.base_color = Paint::Solid([0.0; 3]);
        p.specular_weight = 0.0;
    });
    let by_chance = mean(&look().with(Shape::Sphere { center, radius }, shining).shoot());
    assert!((by_photons - by_chance).abs() < 0.02 * by_chance, "{by_photons} {by_chance}");
}

/// The same on a glossy floor, in whose lobe the lamp is seen through the ball: there both ways count.
#[test]
fn photons_and_chance_share_what_a_glossy_floor_shows() {
    let ball = Shape::Sphere { center: Vec3::new(0.0, 0.0, 1.5), radius: 1.0 };
    let (center, radius) = (Vec3::new(0.0, 4.0, 3.5), 1.0);
    let look = |spp| {
        let eye = Vec3::new(0.0, -9.0, 4.0);
        let at = Vec3::new(0.0, -2.45, 0.0);
        let mut scene = scene(12, spp, eye, at, Projection::Perspective { fov: 0.05 });
        scene.film.integrator = Integrator::Path;
        let gloss =
            Material::Glossy { color: Paint::Solid([0.05; 3]), specular: 1.0, roughness: 0.25 };
        scene.with(FLOOR, gloss).with(ball.clone(), Material::Glass(Glass::clear([1.0; 3], 1.5)))
    };
    let lamp = || Light::Sphere { center, radius, radiance: [40.0; 3] };
    let shining = made(|p| {
        p.emission = [40.0; 3];
        p.base_color = Paint::Solid([0.0; 3]);
        p.specular_weight = 0.0;
    });
    let by_chance = look(1024).with(Shape::Sphere { center, radius }, shining).shoot();
    let expected = mean(&by_chance);
    let found = mean(&look(256).lit(lamp()).shoot());
    assert!((found - expected).abs() < 0.02 * expected, "{found} {expected}");
    // No disk of a single photon is seen: squares of 4 x 4 pixels have light like those by chance.
    let few = look(16).lit(lamp()).shoot();
    let square = |picture: &Picture, i: u32| {
        let pixels = (0..16).map(|j| at(picture, i % 3 * 4 + j % 4, i / 3 * 4 + j / 4));
        pixels.sum::<f64>() / 16.0
    };
    for i in 0..9 {
        let (found, expected) = (square(&few, i), square(&by_chance, i));
        assert!((found - expected).abs() < 0.15 * expected, "{i}: {found} {expected}");
    }
}

/// A large sphere shines inwards, too, and photons do not bring that: a white ball in glass vanishes.
#[test]
fn what_shines_all_round_is_seen_through_glass() {
    let eye = Vec3::new(0.0, -6.0, 0.5);
    let mut scene = scene(8, 64, eye, Vec3::ZERO, Projection::Perspective { fov: 0.2 });
    scene.film.depth = 60;
    scene.film.integrator = Integrator::Path;
    let hall = Light::Sphere { center: Vec3::ZERO, radius: 30.0, radiance: [1.0; 3] };
    let core = Shape::Sphere { center: Vec3::ZERO, radius: 0.5 };
    let glass = Material::Glass(Glass::clear([1.0; 3], 1.5));
    let found = mean(&scene.lit(hall).with(core, matte(1.0)).with(BALL, glass).shoot());
    assert!((found - 1.0).abs() < 1e-2, "{found}");
}

/// Two sheets of glass under a wide lamp reflect 2 r / (1 + r) of its light, where one reflects r. Each sample shows
/// r, and what comes back from the second sheet or not: none shows the whole lamp because its path, in a branch that
/// carries less, was let go on in place of others.
#[test]
fn paths_that_branch_leave_no_sparks() {
    let eye = Vec3::new(0.0, -1.0, 1.0);
    let mut scene = scene(16, 1, eye, Vec3::ZERO, Projection::Orthographic { height: 0.5 });
    scene.film.depth = 60;
    scene.film.integrator = Integrator::Path;
    let (center, radiance, ior) = (Vec3::Z * 5.0, 30.0, 2.4_f64);
    let radius = 1e3;
    scene = scene.lit(Light::Disk { center, normal: -Vec3::Z, radius, radiance: [radiance; 3] });
    for z in [0.0, -0.1] {
        let sheet = Shape::Plane { point: Vec3::Z * z, normal: Vec3::Z };
        scene = scene.with(sheet, Material::Glass(Glass::clear([1.0; 3], ior)));
    }
    // Fresnel's reflectance at 45 degrees; of a sheet, all ways to and fro added up.
    let (cos, inside) = (0.5_f64.sqrt(), (1.0 - 0.5 / (ior * ior)).sqrt());
    let s = ((cos - ior * inside) / (cos + ior * inside)).powi(2);
    let p = ((ior * cos - inside) / (ior * cos + inside)).powi(2);
    let one = 0.5 * (s + p);
    let r = 2.0 * one / (1.0 + one);
    let expected = radiance * 2.0 * r / (1.0 + r);
    let picture = scene.shoot();
    let found = mean(&picture);
    assert!((found - expected).abs() < 0.05 * expected, "{found} {expected}");
    let (least, most) = (radiance * r, radiance * r * (2.0 - r));
    for i in 0..256 {
        let pixel = at(&picture, i % 16, i / 16);
        assert!(pixel > 0.999 * least && pixel < 1.001 * most, "{i}: {pixel} {least} {most}");
    }
}

/// The middle of the floor of a shining pipe: of all directions weighted by the cosine, the opening at height h
/// takes R^2 / (R^2 + h^2). The light is looked for on the pipe, and found by chance in the noise of a few samples.
#[test]
fn a_shining_pipe_lights_its_floor() {
    let pipe = Profile::from_path_data("M 0.5 0 L 0.5 1.2").unwrap();
    let look = |placement| {
        let pipe = Instance::new(Arc::new(Surface::new(&pipe)), placement).unwrap();
        let shining = made(|p| {
            p.emission = [3.0; 3];
            p.base_color = Paint::Solid([0.0; 3]);
            p.specular_weight = 0.0;
        });
        let mut scene =
            from_above(8, 256, 0.01).with(FLOOR, matte(0.5)).with(Shape::Turned(pipe), shining);
        scene.film.depth = 1;
        mean(&scene.shoot())
    };
    let seen = 1.44 / (0.25 + 1.44);
    let expected = 0.5 * 3.0 * seen;
    for placement in [Affine::IDENTITY, Affine::scale(Vec3::new(-1.0, 1.0, 1.0))] {
        let found = look(placement);
        assert!((found - expected).abs() < 5e-3 * expected, "{found} {expected}");
    }
}

#[test]
fn a_sphere_as_a_profile_is_the_sphere() {
    let look = |shape| {
        let eye = Vec3::new(0.0, -6.0, 1.0);
        let mut scene = scene(24, 64, eye, Vec3::ZERO, Projection::Perspective { fov: 0.5 });
        scene.film.integrator = Integrator::Path;
        let light = Light::Disk {
            center: Vec3::new(3.0, -3.0, 4.0),
            normal: Vec3::new(-3.0, 3.0, -4.0).normalized(),
            radius: 1.0,
            radiance: [20.0; 3],
        };
        let floor = Shape::Plane { point: -Vec3::Z, normal: Vec3::Z };
        scene.under(WHITE).lit(light).with(floor, matte(0.4)).with(shape, made(|_| {})).shoot()
    };
    let profile = Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap();
    let turned = Instance::new(Arc::new(Surface::new(&profile)), Affine::IDENTITY).unwrap();
    let (a, b) = (look(BALL), look(Shape::Turned(turned)));
    // The frames of both differ, and with them the noise.
    assert!((mean(&a) - mean(&b)).abs() < 4e-3 * mean(&a), "{} {}", mean(&a), mean(&b));
    let off = (0..24).map(|i| (at(&a, i, 12) - at(&b, i, 12)).abs()).sum::<f64>() / 24.0;
    assert!(off < 0.05 * mean(&a), "{off}");
}

/// Wine in a glass, the two overlapping: by its priority the glass fills the overlap, and the picture is that
/// of glass and wine which touch, wherever in the wall the wine ends.
#[test]
fn what_overlaps_is_filled_by_priority() {
    let ball = |radius| Shape::Sphere { center: Vec3::ZERO, radius };
    let look = |wine_radius| {
        let eye = Vec3::new(0.0, -6.0, 0.5);
        let mut scene = scene(24, 64, eye, Vec3::ZERO, Projection::Perspective { fov: 0.45 });
        scene.film.integrator = Integrator::Path;
        scene.film.depth = 30;
        let wall =
            Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1 L 0 0.8 A 0.8 0.8 0 0 0 0 -0.8 Z");
        let wall = Instance::new(Arc::new(Surface::new(&wall.unwrap())), Affine::IDENTITY).unwrap();
        let glass = Glass { priority: 1, ..Glass::clear([0.9; 3], 1.5) };
        let wine = Glass::clear([0.6, 0.2, 0.3], 1.34);
        scene
            .under(WHITE)
            .with(Shape::Turned(wall), Material::Glass(glass))
            .with(ball(wine_radius), Material::Glass(wine))
            .shoot()
    };
    let (a, b) = (mean(&look(0.85)), mean(&look(0.95)));
    assert!((a - b).abs() < 2e-3 * a, "{a} {b}");
}

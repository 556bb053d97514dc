//! Light and shadow where closed forms tell what is to be seen.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Build, at, matte, mean, scene};
use rondure::Vec3;
use rondure_scene::{Glass, Light, Material, Paint, Projection, Scene, Shape, Sky};

const FLOOR: Shape = Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z };

/// The floor seen from above, `height` units across; x to the right, y upwards.
fn from_above(size: u32, spp: u32, height: f64) -> Scene {
    let eye = Vec3::new(0.0, 0.0, 100.0);
    let mut scene = scene(size, spp, eye, Vec3::ZERO, Projection::Orthographic { height });
    scene.camera.up = Vec3::Y;
    scene
}

#[test]
fn point_light_falls_off_with_the_square() {
    let light = Light::Point { position: Vec3::new(0.0, 0.0, 2.0), intensity: [3.0; 3] };
    let picture = from_above(41, 64, 4.1).with(FLOOR, matte(0.5)).lit(light).shoot();
    for (x, distance) in [(20, 0.0_f64), (30, 1.0), (40, 2.0)] {
        let d2 = 4.0 + distance * distance;
        let expected = 0.5 / std::f64::consts::PI * 3.0 * (2.0 / d2.sqrt()) / d2;
        let found = at(&picture, x, 20);
        assert!((found - expected).abs() < 5e-3 * expected, "{distance}: {found} {expected}");
    }
}

#[test]
fn shadow_of_a_ball_has_its_radius_and_place() {
    // A light straight above at height 4, a ball of radius 1/2 at height 2: the cone that touches
    // the ball has sine 1/4, and meets the floor in a circle of radius 4 tan.
    let light = Light::Point { position: Vec3::new(0.3, 0.0, 4.0), intensity: [16.0; 3] };
    let ball = Shape::Sphere { center: Vec3::new(0.3, 0.0, 2.0), radius: 0.5 };
    let mut scene = from_above(200, 16, 4.0).with(FLOOR, matte(1.0)).with(ball, matte(0.0));
    scene.lights.push(light);
    let picture = scene.shoot();
    // Seen from above the black ball hides the middle of its shadow.
    let dark: f64 = picture
        .pixels()
        .iter()
        .zip(0..)
        .map(|(p, i)| {
            let (x, y) = (f64::from(i % 200) + 0.5 - 100.0, f64::from(i / 200) + 0.5 - 100.0);
            let r2 = ((x / 50.0 - 0.3).powi(2) + (y / 50.0).powi(2)) / 16.0;
            1.0 - f64::from(p[0]) * std::f64::consts::PI * (1.0 + r2).powf(1.5)
        })
        .sum();
    let radius = (dark / std::f64::consts::PI).sqrt() / 50.0;
    let expected = 4.0 * 0.25_f64.asin().tan();
    assert!((radius - expected).abs() < 2e-3, "{radius} {expected}");
}

#[test]
fn sky_lights_by_the_cosine() {
    // Straight up the mean of the radiance weighted by the cosine: horizon + 2/3 of the way up.
    let sky = Sky::Gradient { zenith: [1.0; 3], horizon: [0.4; 3], ground: [9.0; 3] };
    let bright = mean(&from_above(8, 256, 1.0).under(sky).with(FLOOR, matte(0.5)).shoot());
    assert!((bright - 0.5 * 0.8).abs() < 1e-4, "{bright}");
}

#[test]
fn lamps_are_seen_from_their_bright_side() {
    let center = Vec3::new(0.0, 0.0, 1.0);
    let disk = |normal| Light::Disk { center, normal, radius: 1.0, radiance: [7.0; 3] };
    let floor = || from_above(9, 4, 1.0).with(FLOOR, matte(0.0));
    assert_eq!(at(&floor().lit(disk(Vec3::Z)).shoot(), 4, 4), 7.0);
    assert_eq!(at(&floor().lit(disk(-Vec3::Z)).shoot(), 4, 4), 0.0);
    let ball = Light::Sphere { center, radius: 1.0, radiance: [7.0; 3] };
    assert_eq!(at(&floor().lit(ball).shoot(), 4, 4), 7.0);
    let mirror = Material::Mirror { color: Paint::Solid([0.5; 3]) };
    let seen = from_above(9, 4, 0.1).with(FLOOR, mirror).lit(disk(-Vec3::Z)).shoot();
    assert!((at(&seen, 4, 4) - 3.5).abs() < 1e-6);
}

#[test]
fn rough_reflection_of_a_lamp_does_not_depend_on_its_kind() {
    // A ball and a disk that fill the same cone of directions give the same reflection, though
    // they are sampled in different ways.
    let lamp = Light::Sphere { center: Vec3::new(0.0, 0.0, 3.0), radius: 0.8, radiance: [1.0; 3] };
    let gloss =
        |roughness| Material::Glossy { color: Paint::Solid([0.0; 3]), specular: 1.0, roughness };
    for roughness in [0.2, 0.5, 0.9] {
        let mut scene = from_above(4, 4096, 0.1).with(FLOOR, gloss(roughness)).lit(lamp.clone());
        scene.camera.eye = Vec3::new(2.0, 0.0, 3.0);
        scene.camera.look_at = Vec3::ZERO;
        let ball = mean(&scene.shoot());
        let cos = (1.0_f64 - 0.64 / 9.0).sqrt();
        let distance = 3.0 * cos * cos;
        scene.lights = vec![Light::Disk {
            center: Vec3::new(0.0, 0.0, distance),
            normal: -Vec3::Z,
            radius: distance * (1.0 - cos * cos).sqrt() / cos,
            radiance: [1.0; 3],
        }];
        let disk = mean(&scene.shoot());
        assert!((ball - disk).abs() < 2e-2 * disk, "{roughness}: {ball} {disk}");
    }
}

#[test]
fn glass_casts_a_light_shadow() {
    // A pane across the way of a vertical sun: what two sides at n = 1.5 let through.
    let sun = Light::Sun { direction: Vec3::Z, irradiance: [1.0; 3], angular_radius: 0.0 };
    let floor = || {
        let mut scene = from_above(5, 16, 0.1).with(FLOOR, matte(1.0)).lit(sun.clone());
        scene.camera.eye = Vec3::new(3.0, 0.0, 2.0);
        scene
    };
    let free = mean(&floor().shoot());
    let glass = |color| Material::Glass(Glass::clear([color; 3], 1.5));
    let center = Vec3::new(0.0, 0.0, 4.0);
    let pane = Shape::Disk { center, normal: Vec3::Z, radius: 0.5 };
    let behind_pane = mean(&floor().with(pane, glass(1.0)).shoot());
    let sheet = 2.0 * 0.04 / 1.04;
    assert!((behind_pane / free - (1.0 - sheet)).abs() < 1e-6);
    let ball = Shape::Sphere { center, radius: 0.5 };
    let behind_ball = mean(&floor().with(ball.clone(), glass(0.5)).shoot());
    assert!((behind_ball / free - 0.96 * 0.96 * 0.5).abs() < 3e-3);
    let behind_stone = mean(&floor().with(ball, matte(1.0)).shoot());
    assert_eq!(behind_stone, 0.0);
}

#[test]
fn highlight_of_a_point_light_stands_at_the_mirror_angle() {
    let gloss = Material::Glossy { color: Paint::Solid([0.0; 3]), specular: 1.0, roughness: 0.0 };
    let light = Light::Point { position: Vec3::new(-2.0, 0.0, 2.0), intensity: [1.0; 3] };
    let mut scene = from_above(101, 16, 1.0).with(FLOOR, gloss).lit(light);
    scene.camera.eye = Vec3::new(2.0, 0.0, 2.0);
    scene.camera.projection = Projection::Perspective { fov: 0.4 };
    let picture = scene.shoot();
    let brightest = (0..101 * 101)
        .max_by(|&a, &b| at(&picture, a % 101, a / 101).total_cmp(&at(&picture, b % 101, b / 101)))
        .unwrap();
    let (x, y) = (brightest % 101, brightest / 101);
    assert!(x.abs_diff(50) <= 1 && y.abs_diff(50) <= 1, "{x} {y}");
    assert!(at(&picture, 50, 50) > 0.0);
}

//! Looking for light, chance, and both together: the same in the mean, and together never much worse than the better.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use rondure::{Ray, Vec3};
use rondure_scene::{
    Camera, Copies, Cut, Film, Light, Material, Object, Projection, Scene, Shape, Sky,
};

use super::*;

/// A metal floor of some roughness, seen at 45 degrees, and above it where its mirror image is seen a lamp of some
/// radius.
fn world(roughness: f64, radius: f64, sky: Sky) -> World {
    world_of(Material::Metal { eta: [1.6; 3], k: [9.0; 3], roughness }, radius, sky)
}

/// The same with a floor of any material.
pub(super) fn world_of(material: Material, radius: f64, sky: Sky) -> World {
    let camera = Camera {
        eye: Vec3::new(0.0, -1.0, 1.0),
        look_at: Vec3::ZERO,
        up: Vec3::Z,
        projection: Projection::Orthographic { height: 1.0 },
        lens: None,
    };
    let floor = Object {
        name: String::new(),
        shape: Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z },
        material: 0,
        copies: Copies::default(),
        section: Cut::default(),
    };
    let normal = Vec3::new(0.0, -1.0, -1.0).normalized();
    let lamp = Light::Disk { center: normal * -3.0, normal, radius, radiance: [1.0; 3] };
    let scene = Scene {
        film: Film::default(),
        keys: Vec::new(),
        camera,
        sky,
        lights: vec![lamp],
        objects: vec![floor],
        materials: vec![material],
        reliefs: vec![None],
        section: Vec::new(),
    };
    World::new(&scene).unwrap()
}

/// Mean, variance of a sample, and variance of the mean.
fn measure(world: &World, weighting: Weighting, count: u32) -> [f64; 3] {
    let ray = Ray::new(Vec3::new(0.02, -1.0, 1.0), Vec3::new(0.0, 1.0, -1.0).normalized());
    let mut tracer = Tracer { weighting, ..Tracer::new(world, None, 0, true) };
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..count {
        // Other pixels, so that samples know nothing of each other.
        let light = tracer.camera_ray(Sample::new(5, i, 0, 0), &ray, world.closest(&ray)).g;
        sum += light;
        squares += light * light;
    }
    let n = f64::from(count);
    let variance = (squares - sum * sum / n) / (n - 1.0);
    [sum / n, variance, variance / n]
}

#[test]
fn both_ways_agree_and_share_the_work() {
    const COUNT: u32 = 10_000;
    let black = || Sky::Constant { color: [0.0; 3] };
    let bright = || Sky::Constant { color: [0.7; 3] };
    // How much worse than both together either is somewhere.
    let (mut looking_fails, mut chance_fails) = (0.0_f64, 0.0_f64);
    for (roughness, radius, sky) in [
        (0.2, 0.1, black()),
        (0.2, 1.5, black()),
        (0.7, 0.1, black()),
        (0.7, 1.5, black()),
        (0.4, 0.5, black()),
        (0.3, 0.3, bright()),
        (0.9, 0.3, bright()),
    ] {
        let world = world(roughness, radius, sky);
        let [both, looking, chance] = [Weighting::Both, Weighting::LookedFor, Weighting::Chance]
            .map(|w| measure(&world, w, COUNT));
        for alone in [looking, chance] {
            let error = (both[2] + alone[2]).sqrt();
            let off = (both[0] - alone[0]).abs();
            assert!(off < 4.0 * error, "{roughness} {radius}: {both:?} {alone:?}");
        }
        let (best, worst) = (looking[1].min(chance[1]), looking[1].max(chance[1]));
        assert!(both[1] < worst, "{roughness} {radius}: {both:?} {looking:?} {chance:?}");
        // Veach's bound on how far the power heuristic is off the best weights leaves room for the square of the mean.
        assert!(
            both[1] < best + both[0] * both[0],
            "{roughness} {radius}: {both:?} {looking:?} {chance:?}"
        );
        looking_fails = looking_fails.max(looking[1] / both[1]);
        chance_fails = chance_fails.max(chance[1] / both[1]);
    }
    assert!(looking_fails > 10.0 && chance_fails > 10.0, "{looking_fails} {chance_fails}");
}

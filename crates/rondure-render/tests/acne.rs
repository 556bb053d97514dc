//! A ball lit from where it is seen shows the cosine law and no dark speck, at any size and far from
//! the origin.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::{f64::consts::PI, sync::Arc};

use common::{Build, at, matte, mean, scene};
use rondure::{Affine, Instance, Profile, Surface, Vec3};
use rondure_scene::{Integrator, Light, Projection, Shape};

fn sphere(center: Vec3, radius: f64) -> Shape {
    Shape::Sphere { center, radius }
}

fn turned(center: Vec3, radius: f64) -> Shape {
    let ball = Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap();
    let placement = Affine::translate(center)
        .after(&Affine::rotate(Vec3::new(1.0, 2.0, 0.5), 0.4))
        .after(&Affine::scale(Vec3::splat(radius)));
    Shape::Turned(Instance::new(Arc::new(Surface::new(&ball)), placement).unwrap())
}

#[test]
fn balls_show_the_cosine_law_at_any_size() {
    const N: u32 = 48;
    for shape in [sphere, turned] {
        for size in [1e-3, 1.0, 1e4] {
            for offset in [0.0, 1e3, 1e6] {
                let center = Vec3::new(offset, -2.0 * offset, 0.5 * offset) * size;
                let eye = center + Vec3::new(0.5, -6.0, 2.0) * size;
                let direction = (eye - center).normalized();
                let sun = Light::Sun { direction, irradiance: [PI; 3], angular_radius: 0.0 };
                let picture =
                    scene(N, 16, eye, center, Projection::Orthographic { height: 2.2 * size })
                        .with(shape(center, size), matte(1.0))
                        .lit(sun)
                        .shoot();
                for y in 0..N {
                    for x in 0..N {
                        let place = |i: u32| (f64::from(i) + 0.5 - f64::from(N) / 2.0) / 24.0 * 1.1;
                        let r2 = place(x).powi(2) + place(y).powi(2);
                        // One of 16 samples in shadow would take 6 %.
                        if r2 < 0.8 {
                            let (found, law) = (at(&picture, x, y), (1.0 - r2).sqrt());
                            assert!(
                                (found - law).abs() < 0.025,
                                "size {size}, offset {offset}, {x} {y}: {found} {law}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// Rays leave a large surface farther from where it was hit than from a small one, and are so much nearer to a lamp, which must not
/// hide itself for that. A turned floor, large beside the way to the lamp, is lit as a flat shape is.
#[test]
fn a_lamp_does_not_hide_itself_from_a_large_surface() {
    let eye = Vec3::new(0.3, 0.2, 6.0);
    let lamp = Light::Disk {
        center: Vec3::new(0.0, 0.0, 2.0),
        normal: Vec3::new(0.0, 0.0, -1.0),
        radius: 0.5,
        radiance: [4.0; 3],
    };
    let profile = Profile::from_path_data("M 0 0 L 1000 0 L 1000 1000").unwrap();
    let floor = Instance::new(Arc::new(Surface::new(&profile)), Affine::IDENTITY).unwrap();
    let turned = Shape::Turned(floor);
    let flat = Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z };
    for integrator in [Integrator::Path, Integrator::Whitted] {
        let [a, b] = [&turned, &flat].map(|shape| {
            let aim = Vec3::new(0.3, 0.21, 0.0);
            let mut scene = scene(24, 16, eye, aim, Projection::Orthographic { height: 4.0 })
                .with(shape.clone(), matte(0.5))
                .lit(lamp.clone());
            scene.film.integrator = integrator;
            scene.film.depth = 1;
            mean(&scene.shoot())
        });
        assert!(b > 0.05 && (a - b).abs() < 0.01 * b, "{integrator:?}: {a} {b}");
    }
}

//! What a caller of `render` relies on.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::sync::{
    Mutex,
    atomic::{AtomicBool, AtomicU32, Ordering},
};

use common::{Build, WHITE, matte, scene};
use rondure::Vec3;
use rondure_render::{Progress, RenderError, Settings, render};
use rondure_scene::{Glass, Lens, Light, Material, Paint, Projection, Scene, Shape};

/// Something of everything, on a film that tiles do not divide.
fn mixture() -> Scene {
    let eye = Vec3::new(0.0, -6.0, 2.0);
    let mut scene = scene(75, 5, eye, Vec3::ZERO, Projection::Perspective { fov: 0.7 });
    scene.film.height = 41;
    scene.camera.lens = Some(Lens { radius: 0.05, focus: 6.0 });
    let ball = |x: f64| Shape::Sphere { center: Vec3::new(x, 0.0, 0.0), radius: 0.6 };
    let paint = || Paint::Solid([0.8, 0.6, 0.4]);
    scene
        .under(WHITE)
        .lit(Light::Sphere {
            center: Vec3::new(1.0, -2.0, 3.0),
            radius: 0.4,
            radiance: [5.0, 4.0, 3.0],
        })
        .lit(Light::Sun { direction: Vec3::Z, irradiance: [1.0; 3], angular_radius: 0.05 })
        .with(ball(-2.0), Material::Glass(Glass::clear([0.9, 0.8, 0.7], 1.5)))
        .with(ball(-0.7), Material::Glossy { color: paint(), specular: 1.0, roughness: 0.4 })
        .with(ball(0.7), Material::Mirror { color: paint() })
        .with(ball(2.0), matte(0.5))
        .with(
            Shape::Plane { point: Vec3::new(0.0, 0.0, -0.6), normal: Vec3::Z },
            Material::Matte {
                color: Paint::Checker { colors: [[0.2; 3], [0.8; 3]], size: [0.5, 0.5] },
            },
        )
}

fn with_threads(threads: Option<usize>, seed: u64) -> rondure_render::Picture {
    render(&mixture(), &Settings { threads, seed }, &()).unwrap()
}

#[test]
fn pictures_are_the_same_bit_for_bit_for_any_number_of_threads() {
    let one = with_threads(Some(1), 7);
    for threads in [Some(2), Some(5), None] {
        assert!(one == with_threads(threads, 7), "{threads:?}");
    }
    assert!(one.pixels() != with_threads(Some(1), 8).pixels());
    assert_eq!(one.statistics().camera_rays, 75 * 41 * 5);
}

#[derive(Default)]
struct Watch {
    seen: Mutex<Vec<f64>>,
    stop: AtomicBool,
    rows: AtomicU32,
}

impl Progress for Watch {
    fn advance(&self, done: f64) {
        self.seen.lock().unwrap().push(done);
    }

    fn is_cancelled(&self) -> bool {
        self.rows.fetch_add(1, Ordering::Relaxed) > 10 && self.stop.load(Ordering::Relaxed)
    }
}

#[test]
fn progress_reaches_the_end_in_order_on_one_thread() {
    let watch = Watch::default();
    render(&mixture(), &Settings { threads: Some(1), seed: 0 }, &watch).unwrap();
    let seen = watch.seen.lock().unwrap();
    assert!(seen.is_sorted() && seen.len() > 5);
    assert_eq!(seen.last(), Some(&1.0));
}

#[test]
fn rendering_can_be_cancelled() {
    for threads in [Some(1), Some(2)] {
        let watch = Watch { stop: true.into(), ..Watch::default() };
        let result = render(&mixture(), &Settings { threads, seed: 0 }, &watch);
        assert!(matches!(result, Err(RenderError::Cancelled)));
        assert!(watch.rows.load(Ordering::Relaxed) < 41);
    }
}

#[test]
fn impossible_scenes_get_clear_errors() {
    let error = |change: &dyn Fn(&mut Scene)| {
        let mut scene = mixture();
        change(&mut scene);
        render(&scene, &Settings::default(), &()).unwrap_err().to_string()
    };
    assert!(error(&|s| s.film.width = 0).contains("0x41"));
    assert!(error(&|s| s.film.spp = 0).contains("0 samples"));
    assert!(error(&|s| s.camera.look_at = s.camera.eye).contains("must differ"));
    assert!(error(&|s| s.objects[2].material = 9).contains("\"object 2\" has material 9"));
    let huge = error(&|s| (s.film.width, s.film.height) = (u32::MAX, u32::MAX));
    assert!(huge.contains("memory"), "{huge}");
}

#[test]
fn samples_that_are_no_light_are_left_out_and_counted() {
    let mut scene = mixture();
    scene.lights.push(Light::Point { position: Vec3::Z, intensity: [f64::NAN; 3] });
    let picture = render(&scene, &Settings { threads: Some(1), seed: 0 }, &()).unwrap();
    assert!(picture.statistics().invalid_samples > 0);
    assert!(picture.pixels().iter().flatten().all(|v| v.is_finite()));
}

#[test]
fn facing_mirrors_end() {
    let wall = |y: f64| Shape::Plane { point: Vec3::new(0.0, y, 0.0), normal: Vec3::Y };
    let mirror = || Material::Mirror { color: Paint::Solid([1.0; 3]) };
    let mut scene = scene(8, 4, Vec3::ZERO, Vec3::Y, Projection::Perspective { fov: 1.0 })
        .with(wall(1.0), mirror())
        .with(wall(-1.0), mirror());
    scene.film.depth = u32::MAX;
    scene.shoot();
}

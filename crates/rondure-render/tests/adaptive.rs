//! A limit of noise: samples go where the noise is, and the picture does not depend on how it was made.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::sync::atomic::{AtomicU32, Ordering};

use common::{Build, WHITE, matte, scene};
use rondure::Vec3;
use rondure_film::{Film, Layers, Portion, Room, Share, Window};
use rondure_render::{Job, NOISE_BLOCK, Outcome, Progress, RenderError, Settings, Work};
use rondure_scene::{Integrator, Light, Projection, Scene, Shape};

const NOISE: f64 = 0.02;

/// A ball in a soft light on a plane, with clear sky above.
fn still(spp: u32) -> Scene {
    let eye = Vec3::new(0.0, -6.0, 1.0);
    let mut scene = scene(44, spp, eye, Vec3::Z, Projection::Perspective { fov: 0.7 });
    scene.film.height = 35;
    scene.film.integrator = Integrator::Path;
    let center = Vec3::new(1.0, -2.0, 4.0);
    scene
        .under(WHITE)
        .lit(Light::Sphere { center, radius: 0.8, radiance: [9.0, 8.0, 7.0] })
        .with(Shape::Sphere { center: Vec3::ZERO, radius: 0.6 }, matte(0.5))
        .with(Shape::Plane { point: Vec3::new(0.0, 0.0, -0.6), normal: Vec3::Z }, matte(0.3))
}

fn settings() -> Settings {
    Settings { threads: None, seed: 5 }
}

fn work(job: &Job<'_>, edge: u32) -> Work {
    Work::with_tiles(job, job.whole(), &Room::default(), edge).unwrap().until(job, NOISE).unwrap()
}

fn samples(film: &Film) -> Vec<u32> {
    let [width, height] = film.size();
    (0..height).flat_map(|y| (0..width).map(move |x| film.samples(x, y))).collect()
}

/// Stops after so many tiles.
struct Fuse(AtomicU32);

impl Progress for Fuse {
    fn is_enough(&self) -> bool {
        self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1)).is_err()
    }
}

#[test]
fn threads_tiles_and_interruptions_change_no_bit() {
    let scene = still(80);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let film = |edge, threads| {
        let mut work = work(&job, edge);
        assert_eq!(work.run(&job, Some(threads), &()).unwrap(), Outcome::Finished);
        work.sums().film().unwrap().into_owned()
    };
    let whole = film(32, 1);
    let counts = samples(&whole);
    assert!(counts.contains(&16) && counts.contains(&80), "{counts:?}");
    for (edge, threads) in [(5, 2), (8, 1), (13, 2), (100, 1)] {
        assert!(whole == film(edge, threads), "{edge} {threads}");
    }
    // Sums that are not in memory.
    let room = Room { memory: 0, ..Room::default() };
    let mut scratch =
        Work::with_tiles(&job, job.whole(), &room, 13).unwrap().until(&job, NOISE).unwrap();
    scratch.run(&job, Some(2), &()).unwrap();
    assert!(*scratch.sums().film().unwrap() == whole);
    // Tiles that cut blocks, and stops in the middle of passes.
    let mut work = work(&job, 5);
    let mut runs = 0;
    while work.run(&job, Some(1 + runs % 2), &Fuse(AtomicU32::new(29))).unwrap() == Outcome::Stopped
    {
        runs += 1;
        assert!(runs < 1000);
    }
    assert!(runs > 10 && *work.sums().film().unwrap() == whole, "{runs}");
}

#[test]
fn samples_go_where_the_noise_is() {
    let scene = still(256);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let mut adaptive = work(&job, 32);
    adaptive.run(&job, None, &()).unwrap();
    let film = &*adaptive.sums().film().unwrap();
    // The sky has no noise, the shadow below the ball has.
    assert_eq!(film.samples(3, 3), 16);
    assert!(film.samples(18, 24) > 64, "{}", film.samples(18, 24));
    let errors = |film: &Film| {
        let variance = film.variance(18, 24)[1] / (film.light(18, 24)[1].powi(2) + 0.01);
        variance.sqrt()
    };
    assert!(errors(film) < 2.0 * NOISE, "{}", errors(film));
    let taken: u32 = samples(film).iter().sum();
    assert!(taken < 44 * 35 * 256 / 2, "{taken}");
}

#[test]
fn what_has_no_noise_to_judge_is_refused() {
    let scene = still(32);
    let few = Job::new(&scene, &settings(), Layers { variance: false, guides: true }).unwrap();
    let until = |job: &Job<'_>, portion| {
        Work::new(job, portion, &Room::default()).unwrap().until(job, NOISE)
    };
    assert!(matches!(until(&few, few.whole()), Err(RenderError::NoVariance)));
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let part =
        |x, y, width, height| Portion { window: Window { x, y, width, height }, ..job.whole() };
    for cut in [part(0, 0, 7, 8), part(0, 0, 8, 9), part(1, 0, 7, 8), part(40, 32, 4, 2)] {
        assert!(matches!(until(&job, cut), Err(RenderError::NoisePart)));
    }
    let early = Portion { samples: 0..16, ..job.whole() };
    assert!(matches!(until(&job, early), Err(RenderError::NoisePart)));
    assert!(until(&job, part(40, 32, 4, 3)).is_ok());
}

#[test]
fn parts_make_the_whole() {
    let scene = still(80);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let mut whole = work(&job, 32);
    whole.run(&job, None, &()).unwrap();
    let mut sum = Film::new(job.size(), job.whole().window, Layers::ALL).unwrap();
    for k in [4, 1, 5, 3, 2] {
        let part = Share::portion(&job.whole(), k, 5, NOISE_BLOCK).unwrap();
        let mut work = Work::new(&job, part, &Room::default()).unwrap().until(&job, NOISE).unwrap();
        work.run(&job, None, &()).unwrap();
        assert_eq!(work.snapshot().done(), 1.0);
        sum.merge(&work.sums().film().unwrap()).unwrap();
    }
    assert!(*whole.sums().film().unwrap() == sum);
}

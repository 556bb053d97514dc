//! However the work is cut up, the sums on the film have the same bits.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::sync::atomic::{AtomicU32, Ordering};

use common::{Build, WHITE, matte, scene};
use rondure::Vec3;
use rondure_film::{Film, Layers, Portion, Room, Window};
use rondure_render::{Job, Outcome, Progress, Settings, Snapshot, Work};
use rondure_scene::{Glass, Integrator, Lens, Light, Material, Paint, Projection, Scene, Shape};

/// The same with all ways that light can go, photons among them.
fn bright(width: u32, height: u32, spp: u32) -> Scene {
    let mut scene = still(width, height, spp);
    scene.film.integrator = Integrator::Path;
    scene
}

/// A mirror, glass and a soft shadow, on a film that tiles do not divide.
fn still(width: u32, height: u32, spp: u32) -> Scene {
    let eye = Vec3::new(0.0, -6.0, 2.0);
    let mut scene = scene(width, spp, eye, Vec3::ZERO, Projection::Perspective { fov: 0.7 });
    scene.film.height = height;
    scene.camera.lens = Some(Lens { radius: 0.05, focus: 6.0 });
    let ball = |x: f64| Shape::Sphere { center: Vec3::new(x, 0.0, 0.0), radius: 0.6 };
    let center = Vec3::new(1.0, -2.0, 3.0);
    let tint = Paint::Solid([0.8, 0.6, 0.4]);
    scene
        .under(WHITE)
        .lit(Light::Sphere { center, radius: 0.4, radiance: [5.0, 4.0, 3.0] })
        .with(ball(-1.3), Material::Glass(Glass::clear([0.9, 0.8, 0.7], 1.5)))
        .with(ball(0.0), Material::Mirror { color: tint })
        .with(ball(1.3), matte(0.5))
        .with(Shape::Plane { point: Vec3::new(0.0, 0.0, -0.6), normal: Vec3::Z }, matte(0.2))
}

fn settings() -> Settings {
    Settings { threads: None, seed: 5 }
}

fn finished(job: &Job<'_>, portion: Portion, edge: u32, threads: usize) -> Film {
    let mut work = Work::with_tiles(job, portion, &Room::default(), edge).unwrap();
    assert_eq!(work.run(job, Some(threads), &()).unwrap(), Outcome::Finished);
    work.sums().film().unwrap().into_owned()
}

#[test]
fn threads_and_tiles_change_no_bit() {
    for scene in [still(37, 21, 11), bright(37, 21, 3)] {
        let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
        let film = finished(&job, job.whole(), 32, 1);
        assert_eq!(film.samples(36, 20), scene.film.spp);
        for (edge, threads) in [(1, 2), (7, 1), (8, 2), (32, 2), (1000, 1), (u32::MAX, 2)] {
            assert!(film == finished(&job, job.whole(), edge, threads), "{edge} {threads}");
        }
    }
}

/// Sums in a scratch file.
fn scratch(folder: &tempfile::TempDir) -> Room {
    Room { memory: 0, folder: folder.path().to_owned() }
}

#[test]
fn pictures_without_memory_have_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let scene = bright(37, 41, 3);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let film = finished(&job, job.whole(), 32, 1);
    for (edge, threads) in [(32, 2), (7, 1), (100, 2)] {
        let mut work = Work::with_tiles(&job, job.whole(), &scratch(&folder), edge).unwrap();
        assert_eq!(work.run(&job, Some(threads), &()).unwrap(), Outcome::Finished);
        assert!(*work.sums().film().unwrap() == film, "{edge} {threads}");
    }
}

#[test]
fn seven_parts_in_any_order_make_the_whole() {
    let scene = bright(23, 16, 19);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let whole = job.whole();
    let film = finished(&job, whole.clone(), 32, 1);
    let cut =
        |x, y, width, height, samples| Portion { window: Window { x, y, width, height }, samples };
    let portions = [
        cut(0, 0, 23, 16, 17..18),
        cut(0, 0, 23, 16, 0..5),
        cut(4, 3, 19, 13, 5..17),
        cut(0, 0, 4, 16, 5..11),
        cut(0, 0, 4, 16, 11..17),
        cut(4, 0, 19, 3, 5..17),
        cut(0, 0, 23, 16, 18..19),
    ];
    assert!(whole.missing(&portions).is_empty());
    let mut parts: Vec<_> =
        portions.into_iter().map(|portion| finished(&job, portion, 8, 1)).collect();
    for turn in 0..7 {
        parts.rotate_left(turn);
        parts.swap(turn, (3 * turn) % 7);
        let mut sum = Film::new(job.size(), whole.window, Layers::ALL).unwrap();
        parts.iter().for_each(|part| sum.merge(part).unwrap());
        assert!(sum == film);
    }
}

/// Stops after some rows or tiles.
struct Fuse {
    left: AtomicU32,
    at_once: bool,
}

impl Fuse {
    fn burnt(&self) -> bool {
        self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1)).is_err()
    }
}

impl Progress for Fuse {
    fn is_cancelled(&self) -> bool {
        self.at_once && self.burnt()
    }

    fn is_enough(&self) -> bool {
        !self.at_once && self.burnt()
    }

    fn landed(&self, so_far: &Snapshot<'_>) {
        let taken: f64 = so_far.covered().iter().map(Portion::count).sum();
        assert!((taken - so_far.done() * 37.0 * 21.0 * 6.0).abs() < 1e-6);
    }
}

#[test]
fn work_goes_on_where_it_was_stopped() {
    let scene = still(37, 21, 6);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let film = finished(&job, job.whole(), 32, 1);
    for threads in [1, 2] {
        let mut work = Work::with_tiles(&job, job.whole(), &Room::default(), 8).unwrap();
        let mut stops = 0;
        for i in 0.. {
            let fuse = Fuse { left: (5 + 7 * i).into(), at_once: i % 2 == 0 };
            match work.run(&job, Some(threads), &fuse).unwrap() {
                Outcome::Finished => break,
                Outcome::Stopped => stops += 1,
            }
        }
        assert!(stops > 3);
        assert!(*work.sums().film().unwrap() == film);
    }
}

/// Stops after some reports of what is made before a pass.
struct Impatient {
    left: AtomicU32,
    at_once: bool,
    seen: AtomicU32,
}

impl Impatient {
    fn is_gone(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}

impl Progress for Impatient {
    fn preparing(&self, done: f64) {
        assert!((0.0..=1.0).contains(&done));
        self.seen.fetch_add(1, Ordering::Relaxed);
        let _ = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1));
    }

    fn is_cancelled(&self) -> bool {
        self.at_once && self.is_gone()
    }

    fn is_enough(&self) -> bool {
        !self.at_once && self.is_gone()
    }

    fn landed(&self, _: &Snapshot<'_>) {
        assert!(!self.is_gone(), "photons were made to the end");
    }
}

#[test]
fn photons_can_be_interrupted() {
    let scene = bright(17, 11, 3);
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let film = finished(&job, job.whole(), 32, 1);
    for (threads, at_once) in [(1, true), (1, false), (2, true), (2, false)] {
        let mut work = Work::new(&job, job.whole(), &Room::default()).unwrap();
        let patience = |left: u32| Impatient { left: left.into(), at_once, seen: 0.into() };
        let progress = patience(3);
        assert_eq!(work.run(&job, Some(threads), &progress).unwrap(), Outcome::Stopped);
        assert_eq!(work.snapshot().done(), 0.0);
        let seen = progress.seen.load(Ordering::Relaxed);
        assert!((3..10).contains(&seen), "{seen}");
        assert_eq!(work.run(&job, Some(threads), &patience(u32::MAX)).unwrap(), Outcome::Finished);
        assert!(*work.sums().film().unwrap() == film);
    }
}

#[test]
fn layers_tell_what_is_seen_first() {
    let mut scene = still(41, 31, 16);
    scene.camera.lens = None;
    let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
    let film = finished(&job, job.whole(), 32, 2);
    // The mirror ball is in the middle, the matte one on the right, the ground below; the sky above.
    let middle = film.center(20, 15).unwrap();
    assert_eq!((middle.object, middle.material), (2, 2));
    let eye = Vec3::new(0.0, -6.0, 2.0);
    let radius = eye.length();
    assert!((f64::from(middle.depth) - (radius - 0.6)).abs() < 1e-6, "{middle:?}");
    let towards = eye / radius;
    for (found, expected) in middle.position.iter().zip([0.0, towards.y * 0.6, towards.z * 0.6]) {
        assert!((f64::from(*found) - expected).abs() < 1e-6);
    }
    let guide = film.guide(20, 15).unwrap();
    assert_eq!(guide.albedo, [1.0; 3]);
    assert!(guide.normal[1] < -0.9 && guide.normal[2] > 0.2, "{guide:?}");
    let ground = film.guide(20, 30).unwrap();
    assert!((ground.albedo[0] - 0.2).abs() < 1e-11);
    assert!((ground.normal[2] - 1.0).abs() < 1e-11);
    assert_eq!(film.center(20, 30).unwrap().object, 4);
    let sky = film.center(0, 0).unwrap();
    assert_eq!((sky.object, sky.material, sky.depth), (0, 0, f32::INFINITY));
    assert_eq!(film.guide(0, 0).unwrap().albedo, [0.0; 3]);
    assert_eq!(film.variance(0, 0), [0.0; 3]);
    assert!(film.variance(28, 15)[0] > 0.0);
}

#[test]
fn small_and_narrow_pictures() {
    for (width, height) in [(16, 16), (1, 10_000)] {
        let scene = still(width, height, 1);
        let job = Job::new(&scene, &settings(), Layers::ALL).unwrap();
        let film = finished(&job, job.whole(), 32, 2);
        assert!(film == finished(&job, job.whole(), 5, 1));
        assert_eq!(film.samples(width - 1, height - 1), 1);
    }
}

//! Small pictures of hits in the views in which other renderers of lathes draw wrong pixels, every pixel
//! against the oracle; and the rays that leave the hits.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

use rondure::{Affine, Instance, Profile, Ray, Surface, Vec3};
use rondure_oracle::{
    Oracle, Tally,
    profiles::standard,
    views::{orthographic, perspective},
};
use std::sync::Arc;

struct Scene {
    surface: Surface,
    oracle: Oracle,
    tally: Tally,
}

impl Scene {
    fn new(profile: &Profile) -> Self {
        Self {
            surface: Surface::new(profile),
            oracle: Oracle::new(profile),
            tally: Tally::default(),
        }
    }

    fn look(&mut self, rays: &[Ray]) {
        for ray in rays {
            self.tally.compare(&self.surface, &self.oracle, ray, true);
        }
    }

    #[track_caller]
    fn finish(self, pixels_hit: u64) {
        self.tally.assert_clean();
        assert!(self.tally.hits >= pixels_hit, "hardly anything in the picture: {}", self.tally);
    }
}

fn path(text: &str) -> Profile {
    Profile::from_path_data(text).expect(text)
}

const LOOKED_AT: [&str; 2] = ["goblet", "pawn"];

#[test]
fn camera_at_the_height_of_the_object() {
    for name in LOOKED_AT {
        let mut scene = Scene::new(&standard(name));
        for height in [0.3, 0.5] {
            let eye = Vec3::new(3.0, 0.4, height);
            scene.look(&perspective(eye, Vec3::new(0.0, 0.0, height), 0.2));
        }
        scene.finish(500);
    }
}

#[test]
fn camera_at_the_heights_of_vertices() {
    for name in LOOKED_AT {
        let profile = standard(name);
        let mut scene = Scene::new(&profile);
        for segment in profile.segments() {
            let height = segment.end().z;
            let rays = perspective(Vec3::new(3.0, 0.0, height), Vec3::new(0.0, 0.0, height), 0.2);
            // The rows about eye level.
            let row = rondure_oracle::views::WIDTH;
            let middle = rays.len() / 2 - row / 2;
            scene.look(&rays[middle - 2 * row..middle + 3 * row]);
        }
        scene.finish(500);
    }
}

#[test]
fn orthographic_camera_tilted_by_a_little() {
    for tilt in [1e-9, 1e-7, 1e-5, 1e-3, 1e-2] {
        let mut scene = Scene::new(&standard("goblet"));
        let forward = Affine::rotate(Vec3::Y, tilt).vector(-Vec3::X);
        scene.look(&orthographic(Vec3::new(0.0, 0.0, 0.5), forward, 3.0, 0.55));
        scene.finish(500);
    }
}

#[test]
fn long_lens() {
    for degrees in [0.3_f64, 0.03, 0.001] {
        let mut scene = Scene::new(&standard("pawn"));
        let half_angle = 0.5 * degrees.to_radians();
        let eye = Vec3::new(0.55 / half_angle, 0.1, 0.5);
        scene.look(&perspective(eye, Vec3::new(0.0, 0.0, 0.5), half_angle));
        scene.finish(500);
    }
}

#[test]
fn sizes_from_1e_minus_5_to_1e5() {
    for size in [1e-5, 1e-3, 1e4, 1e5] {
        let profile = scaled("goblet", size, 0.0);
        let mut scene = Scene::new(&profile);
        scene.look(&perspective(Vec3::new(2.0, 1.0, 1.2) * size, Vec3::Z * (0.5 * size), 0.25));
        scene.finish(500);
    }
}

#[test]
fn standing_at_10_30_and_100_times_its_size() {
    for height in [10.0, 30.0, 100.0] {
        let mut scene = Scene::new(&scaled("goblet", 1.0, height));
        let target = Vec3::Z * (height + 0.5);
        scene.look(&perspective(target + Vec3::new(2.0, 1.0, 0.7), target, 0.25));
        scene.finish(500);
    }
}

#[test]
fn straight_lines_drawn_as_beziers() {
    // The handles are off by 1e-7, as drawing programs leave them.
    let text = "M 0 0 C 0.1 0 0.2 1e-7 0.3 0 C 0.3000001 0.33 0.3 0.67 0.3 1 \
        C 0.2 1 0.1 1.0000001 0 1";
    let mut scene = Scene::new(&path(text));
    for eye in [Vec3::new(2.0, 0.0, 0.5), Vec3::new(2.0, 1.0, 2.0), Vec3::new(2.0, 0.3, 1.0)] {
        scene.look(&perspective(eye, Vec3::Z * 0.5, 0.3));
    }
    scene.finish(500);
}

#[test]
fn handle_beyond_the_axis() {
    let mut scene = Scene::new(&path("M 0 0 L 0.5 0 C -0.1 0.3 -0.1 0.7 0.5 1 L 0 1"));
    scene.look(&perspective(Vec3::new(2.0, 1.0, 0.5), Vec3::Z * 0.5, 0.3));
    scene.finish(500);
}

#[test]
fn small_caps() {
    let mut scene = Scene::new(&path("M 0 0 L 1e-5 0 C 0.5 0.3 0.5 0.7 1e-5 1 L 0 1"));
    scene.look(&perspective(Vec3::new(1e-4, 0.0, 3.0), Vec3::Z, 1e-5));
    scene.look(&perspective(Vec3::new(2.0, 0.0, 2.0), Vec3::Z, 1e-5));
    scene.finish(500);
}

#[test]
fn poles_from_above() {
    for name in ["pawn", "sphere"] {
        let mut scene = Scene::new(&standard(name));
        let eye = Vec3::Z * 4.0;
        scene.look(&perspective(eye, Vec3::ZERO, 0.1));
        scene.look(&perspective(eye, Vec3::ZERO, 1e-9));
        scene.look(&orthographic(Vec3::ZERO, -Vec3::Z, 3.0, 1e-3));
        assert_eq!(scene.tally.tangent, 0, "{name}");
        scene.finish(500);
    }
}

/// Rays that leave the hits of a picture for a point light: those that leave a convex object outwards
/// must not meet it again, whatever its size and place.
#[test]
fn spawned_rays_leave_convex_objects() {
    let bodies = [
        "M 0 -1 A 1 1 0 0 1 0 1",
        "M 0 0 L 1 0 L 1 2 L 0 2 Z",
        "M 0 0 L 1 0 L 0 2 Z",
        "M 0 0 Q 2 1 0 2",
    ];
    let mut spawned = 0;
    for text in bodies {
        let surface = Arc::new(Surface::new(&path(text)));
        for size in [1e-5, 1e-3, 1.0, 1e4, 1e5] {
            for offset in [0.0, 1.0, 100.0] {
                let map = Affine::translate(Vec3::new(offset, -0.3 * offset, 0.7 * offset) * size)
                    .after(&Affine::rotate(Vec3::new(1.0, 2.0, 0.5), 0.3 * offset))
                    .after(&Affine::scale(Vec3::splat(size)));
                let instance = Instance::new(Arc::clone(&surface), map).unwrap();
                let center = map.point(Vec3::Z * 0.5);
                let eye = center + Vec3::new(6.0, 2.0, 1.0) * size;
                for ray in perspective(eye, center, 0.4).iter().step_by(3) {
                    let Some(hit) = instance.closest(ray) else { continue };
                    let at = instance.interaction(ray, &hit);
                    let light = center + Vec3::new(5.0, 8.0, 9.0) * size;
                    for direction in
                        [light - at.point, eye - at.point, at.normal, at.dp_du, at.dp_dv]
                    {
                        // Along the surface rounding decides the side; outwards is outwards.
                        let sine = direction.normalized().dot(at.normal);
                        if sine > 1e-14 {
                            let ray = at.spawn(direction);
                            assert!(
                                !instance.any(&ray),
                                "{text} size {size:e} offset {offset}: {ray:?}"
                            );
                            spawned += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(spawned > 20_000, "{spawned}");
}

/// On objects with hollows a spawned ray must hit exactly what the oracle says.
#[test]
fn shadow_rays_in_hollows() {
    for size in [1e-5, 1.0, 1e5] {
        let mut scene = Scene::new(&scaled("goblet", size, 0.0));
        let eye = Vec3::new(1.0, 0.4, 1.6) * size;
        let light = Vec3::new(0.8, -1.5, 2.0) * size;
        let mut shadows = Vec::new();
        for ray in perspective(eye, Vec3::Z * (0.6 * size), 0.3) {
            if let Some(hit) = scene.surface.closest(&ray) {
                let at = scene.surface.interaction(&ray, &hit);
                let direction = light - at.point;
                let mut shadow = at.spawn(direction);
                shadow.t_max = 1.0;
                shadows.push(shadow);
            }
        }
        scene.look(&shadows);
        scene.finish(100);
    }
}

/// A standard profile of Béziers in another size, at another height.
fn scaled(name: &str, factor: f64, offset: f64) -> Profile {
    let mut builder = Profile::builder();
    let profile = standard(name);
    let z = |z: f64| z * factor + offset;
    for subpath in profile.subpaths() {
        builder = builder.move_to(subpath.start().r * factor, z(subpath.start().z));
        for segment in subpath.segments() {
            let rondure::Segment::Cubic([_, c, d, e]) = segment else {
                unreachable!("{segment:?}")
            };
            builder = builder.cubic_to(
                [c.r * factor, z(c.z)],
                [d.r * factor, z(d.z)],
                e.r * factor,
                z(e.z),
            );
        }
    }
    builder.build().unwrap()
}

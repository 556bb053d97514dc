//! What is told about a hit, and what must not change it.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use rondure::{Affine, Instance, Profile, Ray, Segment, Surface, Vec3};
use rondure_oracle::{
    Oracle, Random, Tally,
    profiles::{STANDARD, standard},
};
use std::sync::Arc;

fn hits(surface: &Surface, ray: &Ray) -> Vec<rondure::Hit> {
    let mut hits = Vec::new();
    surface.all(ray, &mut hits);
    hits
}

/// Calls `check` with hits of random lines at every standard profile.
fn for_hits(lines: usize, mut check: impl FnMut(&str, &Surface, &Oracle, &Ray, &rondure::Hit)) {
    for (name, _) in STANDARD {
        let profile = standard(name);
        let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
        let mut random = Random::new(31);
        for _ in 0..lines {
            let ray = random.line(oracle.center(), oracle.size());
            for hit in hits(&surface, &ray) {
                check(name, &surface, &oracle, &ray, &hit);
            }
        }
    }
}

#[test]
fn points_lie_on_the_surface_to_within_their_error() {
    for_hits(300, |name, surface, oracle, ray, hit| {
        let at = surface.interaction(ray, hit);
        let along_normal = Ray::line(at.point, at.normal);
        let nearest =
            oracle.hits(&along_normal).iter().map(|h| h.t.hi.abs()).fold(f64::INFINITY, f64::min);
        // At the very edge of an open profile the normal may miss it.
        let on_edge = at.uv[1] < 1e-9 || at.uv[1] > 1.0 - 1e-9;
        assert!(nearest <= at.error || on_edge, "{name} {ray:?} {nearest:e} {:e}", at.error);
        assert!(at.error < 1e-13 * oracle.size(), "{name} {:e}", at.error);
    });
}

#[test]
fn normals_are_perpendicular_to_the_partial_derivatives() {
    for_hits(1000, |name, surface, _, ray, hit| {
        let at = surface.interaction(ray, hit);
        assert!((at.normal.length() - 1.0).abs() < 1e-15, "{name}");
        assert!(
            at.normal.dot(at.dp_du).abs() <= 1e-15 * at.dp_du.length(),
            "{name} {ray:?} {at:?}"
        );
        assert!(
            at.normal.dot(at.dp_dv).abs() <= 1e-15 * at.dp_dv.length(),
            "{name} {ray:?} {at:?}"
        );
        assert!((0.0..1.0).contains(&at.uv[0]) && (0.0..=1.0).contains(&at.uv[1]), "{name} {at:?}");
        let angle = at.uv[0] * core::f64::consts::TAU;
        let rho = at.point.x.hypot(at.point.y);
        let off = Vec3::new(at.point.x - rho * angle.cos(), at.point.y - rho * angle.sin(), 0.0);
        assert!(off.length() < 1e-14, "{name} {at:?}");
    });
}

/// p(u + du, v + dv) = p + p_u du + p_v dv + O(du^2 + dv^2), seen at a neighbouring ray's hit.
#[test]
fn partial_derivatives_agree_with_finite_differences() {
    let mut compared = 0;
    for_hits(300, |name, surface, oracle, ray, hit| {
        let at = surface.interaction(ray, hit);
        let step = 1e-6 * oracle.size();
        let sine = at.normal.dot(ray.direction).abs() / ray.direction.length();
        for shift in [Vec3::X, Vec3::Y, Vec3::Z] {
            let near = Ray { origin: ray.origin + shift * step, ..*ray };
            let Some(neighbour) = hits(surface, &near).into_iter().find(|h| {
                surface.segment(h) == surface.segment(hit)
                    && (h.t - hit.t).abs() * ray.direction.length() < 4.0 * step / sine
            }) else {
                continue;
            };
            let there = surface.interaction(&near, &neighbour);
            let mut du = there.uv[0] - at.uv[0];
            du -= du.round();
            let dv = there.uv[1] - at.uv[1];
            let moved = there.point - at.point;
            let predicted = at.dp_du * du + at.dp_dv * dv;
            let curvature = moved.length() / at.point.x.hypot(at.point.y).min(0.01 * oracle.size());
            if sine > 0.1 && curvature < 1e-2 {
                let error = (moved - predicted).length();
                assert!(
                    error < (10.0 * curvature + 1e-8) * moved.length(),
                    "{name} {ray:?} {error:e} {moved:?} {curvature:e}"
                );
                compared += 1;
            }
        }
    });
    assert!(compared > 1000, "{compared}");
}

#[test]
fn a_quarter_turn_round_the_axis_changes_no_bit() {
    for_hits(300, |name, surface, _, ray, _| {
        let turn = |v: Vec3| Vec3::new(-v.y, v.x, v.z);
        let turned = Ray::line(turn(ray.origin), turn(ray.direction));
        assert_eq!(hits(surface, ray), hits(surface, &turned), "{name} {ray:?}");
    });
}

#[test]
fn scaling_by_a_power_of_two_changes_no_bit() {
    for (name, _) in STANDARD {
        let profile = standard(name);
        let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
        for factor in [2f64.powi(-40), 2f64.powi(33)] {
            let scaled = Surface::new(&scale(&profile, factor));
            let mut random = Random::new(32);
            for _ in 0..300 {
                let ray = random.line(oracle.center(), oracle.size());
                let grown = Ray::line(ray.origin * factor, ray.direction * factor);
                assert_eq!(
                    hits(&surface, &ray),
                    hits(&scaled, &grown),
                    "{name} {factor:e} {ray:?}"
                );
            }
        }
    }
}

fn scale(profile: &Profile, factor: f64) -> Profile {
    let mut path = Profile::builder();
    for subpath in profile.subpaths() {
        path = path.move_to(subpath.start().r * factor, subpath.start().z * factor);
        for segment in subpath.segments() {
            let end = segment.end() * factor;
            path = match segment {
                Segment::Line(_) => path.line_to(end.r, end.z),
                Segment::Quadratic(p) => {
                    path.quad_to([p[1].r * factor, p[1].z * factor], end.r, end.z)
                }
                Segment::Cubic([_, c, d, _]) => path.cubic_to(
                    [c.r * factor, c.z * factor],
                    [d.r * factor, d.z * factor],
                    end.r,
                    end.z,
                ),
                Segment::Arc(a) => path.arc_to(
                    a.radii.map(|r| r * factor),
                    a.rotation,
                    a.sweep_angle.abs() > 3.5,
                    a.sweep_angle > 0.0,
                    end.r,
                    end.z,
                ),
            };
        }
        if subpath.is_closed() {
            path = path.close();
        }
    }
    path.build().unwrap()
}

#[test]
fn placed_surfaces_agree_with_exact_placement() {
    let mut random = Random::new(33);
    let turn = Affine::rotate(Vec3::new(1.0, -2.0, 0.4), 1.1);
    let shear = Affine {
        columns: [Vec3::new(1.0, 0.0, 0.3), Vec3::new(-0.7, 1.2, 0.0), Vec3::new(0.4, 0.5, 0.9)],
        translation: Vec3::new(1.0, 2.0, -3.0),
    };
    let maps = [
        ("turned", turn),
        ("sheared", shear),
        ("mirrored", Affine::scale(Vec3::new(1.0, -1.0, 1.0)).after(&turn)),
        ("mirrored in z", Affine::scale(Vec3::new(1.0, 1.0, -1.0))),
        ("stretched", turn.after(&Affine::scale(Vec3::new(0.3, 2.0, 5.0)))),
        ("flattened", shear.after(&Affine::scale(Vec3::new(1.0, 1.0, 1e-3)))),
        ("tiny", turn.after(&Affine::scale(Vec3::splat(1e-5)))),
        ("huge", shear.after(&Affine::scale(Vec3::splat(1e5)))),
        ("far away", Affine::translate(Vec3::new(1e3, -2e3, 1e3)).after(&shear)),
        ("farther away", Affine::translate(Vec3::new(-1e6, 0.0, 1e6)).after(&turn)),
    ];
    for (name, text) in STANDARD.iter().filter(|(name, _)| *name != "column") {
        let profile = Profile::from_path_data(text).unwrap();
        let (surface, oracle) = (Arc::new(Surface::new(&profile)), Oracle::new(&profile));
        for (kind, map) in &maps {
            let instance = Instance::new(Arc::clone(&surface), *map).unwrap();
            let mut tally = Tally::default();
            for _ in 0..150 {
                let own = random.line(oracle.center(), oracle.size());
                let ray = Ray::line(map.point(own.origin), map.vector(own.direction));
                tally.compare(&instance, &oracle, &ray, profile.bounds_solid());
            }
            assert!(tally.is_clean(), "{name} {kind}: {tally}");
        }
    }
}

//! The oracle against closed forms and against itself.

use rondure::{Affine, Profile, Ray, Vec3};
use rondure_oracle::{
    ExactLine, Oracle, Random,
    profiles::{SOLIDS, standard},
};

#[test]
fn oracle_agrees_with_closed_forms() {
    for (name, solid) in SOLIDS {
        let oracle = Oracle::new(&standard(name));
        let mut random = Random::new(1);
        let mut count = 0;
        for _ in 0..5_000 {
            let ray = random.line(oracle.center(), oracle.size());
            let (found, expected) = (oracle.hits(&ray), solid.hits(&ray));
            assert_eq!(found.len(), expected.len(), "{name} {ray:?} {found:?} {expected:?}");
            for (f, e) in found.iter().zip(&expected) {
                // Arcs begin at angles that are rounded, hence not at exactly the vertices.
                let error = ((f.t.hi - e.hi) + (f.t.lo - e.lo)).abs();
                assert!(error * f.incidence < 1e-16, "{name} {ray:?} {error:e} {f:?}");
            }
            count += found.len();
        }
        assert!(count > 4_000, "{name} {count}");
    }
}

#[test]
fn lines_through_solids_hit_an_even_number_of_times() {
    let mut random = Random::new(2);
    for _ in 0..300 {
        let profile = random.profile();
        let oracle = Oracle::new(&profile);
        for _ in 0..20 {
            let ray = random.line(oracle.center(), oracle.size());
            let hits = oracle.hits(&ray);
            let count: usize = hits.iter().map(|h| h.changes).sum();
            assert!(
                !profile.bounds_solid() || count.is_multiple_of(2),
                "{ray:?} {hits:?} {profile:?}"
            );
        }
    }
}

#[test]
fn hits_lie_on_the_surface() {
    // Against the profile's own f64 evaluation, which is good to some 1e-15.
    let mut random = Random::new(3);
    for _ in 0..300 {
        let profile = random.profile();
        let oracle = Oracle::new(&profile);
        for _ in 0..20 {
            let ray = random.line(oracle.center(), oracle.size());
            for hit in oracle.hits(&ray) {
                let point = ray.at(hit.t.hi);
                let on = profile.segments().nth(hit.segment).unwrap().point(hit.s);
                let rho = point.x.hypot(point.y);
                let error = (rho - on.r).abs().max((point.z - on.z).abs());
                assert!(
                    error < 1e-15 * (10.0 * oracle.size() + ray.origin.max_abs()),
                    "{ray:?} {hit:?} {error:e}"
                );
            }
        }
    }
}

#[test]
fn no_root_is_missed_between_samples() {
    // F changes sign between samples of the profile exactly as often as there are hits there.
    let mut random = Random::new(4);
    for name in ["goblet", "vase", "pawn"] {
        let profile = standard(name);
        let oracle = Oracle::new(&profile);
        for _ in 0..100 {
            let ray = random.line(oracle.center(), oracle.size());
            let (o, d) = (ray.origin, ray.direction);
            let mut crossings = 0;
            for segment in profile.segments() {
                let inside = |s: f64| {
                    let p = segment.point(s);
                    let q = ray.at((p.z - o.z) / d.z);
                    q.x.hypot(q.y) < p.r
                };
                let n = 400;
                crossings += (0..n)
                    .filter(|&i| inside(i as f64 / n as f64) != inside((i + 1) as f64 / n as f64))
                    .count();
            }
            let hits = oracle.hits(&ray);
            assert!(crossings <= hits.len(), "{name} {ray:?} {crossings} {hits:?}");
            assert!(hits.len() - crossings <= 2 && (hits.len() - crossings).is_multiple_of(2));
        }
    }
}

#[test]
fn tangency_is_the_distance_to_another_count() {
    let oracle = Oracle::new(&standard("sphere"));
    for gap in [1e-3, -1e-3, 1e-9, -1e-9, 1e-14, -1e-14] {
        for d in [Vec3::X, Vec3::new(1.0, 0.0, 0.3), Vec3::new(1e-7, 0.0, 1.0)] {
            let across = Vec3::new(-d.z, 0.0, d.x).normalized();
            let ray = Ray::line(across * (1.0 + gap) + d * -3.0, d);
            let distance = oracle.tangency(&ray) * oracle.size();
            let rounding = 1e-15;
            assert!(
                (distance / f64::abs(gap) - 1.0).abs() < 0.01 + rounding / f64::abs(gap),
                "{gap} {d:?} {distance:e}"
            );
            assert_eq!(oracle.hits(&ray).len(), if gap < -1e-15 { 2 } else { 0 }, "{gap} {d:?}");
        }
    }
}

#[test]
fn flat_rays_agree_with_level_ones() {
    let oracle = Oracle::new(&standard("vase"));
    let at =
        |dz: f64| oracle.hits(&Ray::line(Vec3::new(-2.0, 0.05, 0.37), Vec3::new(1.0, 0.01, dz)));
    let level = at(0.0);
    assert_eq!(level.len(), 2);
    for dz in [1e-6, 1e-12, 1e-30, -1e-100, 1e-300] {
        let tilted = at(dz);
        assert_eq!(tilted.len(), 2);
        for (x, y) in level.iter().zip(&tilted) {
            let error = ((x.t.hi - y.t.hi) + (x.t.lo - y.t.lo)).abs();
            assert!(error < 10.0 * dz.abs() + 1e-28, "{dz} {error:e}");
        }
    }
}

#[test]
fn placed_lines_agree_with_the_maps_that_round_nothing() {
    let oracle = Oracle::new(&standard("goblet"));
    let map = Affine {
        columns: [Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, -4.0, 0.0), Vec3::new(1.0, 0.0, 0.5)],
        translation: Vec3::new(3.0, 5.0, -7.0),
    };
    let mut random = Random::new(5);
    for _ in 0..200 {
        let ray = random.line(oracle.center(), oracle.size());
        // Short enough that the map rounds nothing.
        let short = |v: Vec3| Vec3::new(v.x as f32 as f64, v.y as f32 as f64, v.z as f32 as f64);
        let ray = Ray::line(short(ray.origin), short(ray.direction));
        let world = Ray::line(map.point(ray.origin), map.vector(ray.direction));
        let (own, placed) =
            (oracle.hits(&ray), oracle.hits_of_line(&ExactLine::placed(&world, &map)));
        assert_eq!(own.len(), placed.len());
        for (x, y) in own.iter().zip(&placed) {
            assert_eq!(x.t.hi, y.t.hi);
            assert!((x.incidence - y.incidence).abs() < 1e-12);
        }
    }
}

#[test]
fn on_the_axis_poles_count_once_and_axis_parts_not_at_all() {
    for (name, count) in [("sphere", 2), ("cone", 2), ("cylinder", 2), ("torus", 0), ("goblet", 2)]
    {
        let oracle = Oracle::new(&standard(name));
        let hits = oracle.hits(&Ray::line(Vec3::new(0.0, 0.0, -5.0), Vec3::Z));
        assert_eq!(hits.len(), count, "{name} {hits:?}");
    }
}

#[test]
fn a_line_through_a_joint_hits_once() {
    let profile = Profile::builder()
        .move_to(1.0, 0.0)
        .line_to(1.5, 1.0)
        .cubic_to([1.7, 1.4], [1.0, 1.6], 1.2, 2.0)
        .build()
        .unwrap();
    let oracle = Oracle::new(&profile);
    let joint = Vec3::new(1.5, 0.0, 1.0);
    for d in
        [Vec3::X, Vec3::new(0.0, 1.0, 0.5), Vec3::new(1.0, 1.0, 0.25), Vec3::new(1.0, 0.0, 1.0)]
    {
        let hits = oracle.hits(&Ray::line(joint + d * -4.0, d));
        let near = hits.iter().filter(|h| h.joint_distance < 1e-15 && (h.t.hi - 4.0).abs() < 1e-12);
        let tangent = d.x == 0.0;
        assert!(near.count() == 1 || tangent, "{d:?} {hits:?}");
    }
}

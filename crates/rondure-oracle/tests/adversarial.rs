//! Every degenerate ray and profile that the engine must simply cope with, by name, against the oracle.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

use rondure::{FillRule, Point, Profile, ProfileErrorKind, Ray, Solid, Spline, Surface, Vec3};
use rondure_oracle::{
    Oracle, Random, Tally,
    profiles::{STANDARD, standard},
    solids::scalar_surface,
};
use std::sync::Arc;

/// Path data of profiles with all kinds of features, beside the standard ones.
const FEATURES: &[(&str, &str)] = &[
    ("smooth poles", "M 0 0 C 0.7 0 1 0.5 1 1 C 1 1.6 0.6 2 0 2"),
    ("pointed poles", "M 0 0 L 1 1 Q 0.2 1.2 0 2"),
    ("touching the axis", "M 0 0 L 1 0.5 L 0 1 L 1 1.5 L 0 2"),
    ("touching the axis smoothly", "M 1 0 Q -1 1 1 2 L 1 0 Z"),
    ("caps", "M 0 0 L 1 0 L 1 0.1 L 0.1 0.1 L 0.1 1 L 0 1"),
    ("cusp", "M 0 0 C 2 1 -0.2 1 1 0 L 1 -1 L 0 -1"),
    ("vertical parts", "M 0.5 0 L 0.5 1 L 0.7 1 L 0.7 2 C 0.7 2.3 0.7 2.5 0.7 3"),
    ("almost horizontal parts", "M 0 0 L 1 1e-9 L 1 1 C 0.7 1.0000001 0.4 1 0 1.00000001"),
    ("folding back in z", "M 0 0 L 1 0 C 1 1 0.5 1.5 0.8 0.5 C 1 0 0.3 0.2 0.3 1 L 0 1"),
    ("crossing itself", "M 0 0 C 3 1 -1 1 1 0 L 0.2 1.5 L 0 1.5"),
    ("torus", "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z"),
    ("open bowl", "M 0.2 0 Q 1 0.1 1.2 1"),
    ("ellipse", "M 0 -1 A 2 1 0 0 1 0 1"),
    ("turned ellipse", "M 2 0 A 1 0.4 30 1 1 1.5 0.7 Z"),
    ("repeated points", "M 0 0 L 1 0 L 1 0 L 1 0 C 1 0 1 0 1 0 L 1 1 L 1 1 L 0 1"),
    (
        "tiny segments",
        "M 0 0 L 1 0 L 1 1e-17 L 1 2e-17 L 1 0.5 Q 1 0.50000000000000011 0.9999999999999999 0.5 L 0 1",
    ),
    (
        "nearly straight Béziers",
        "M 0 0 C 0.33 0.0000001 0.67 0 1 0 C 1.0000001 0.33 1 0.67 1 1 C 0.7 1 0.3 0.9999999 0 1",
    ),
    ("handle beyond the axis", "M 0.5 0 C -0.1 0.3 -0.1 0.7 0.5 1"),
    ("small caps", "M 0 0 L 1e-6 0 C 0.5 0.3 0.5 0.7 1e-7 1 L 0 1"),
];

fn every_profile() -> Vec<(String, Profile)> {
    FEATURES
        .iter()
        .chain(STANDARD)
        .map(|(name, text)| (name.to_string(), Profile::from_path_data(text).expect(name)))
        .collect()
}

/// Compares the rays that `rays` makes for every profile.
fn check_all(rays: impl Fn(&Oracle, &Profile, &mut Random) -> Vec<Ray>) {
    for (name, profile) in every_profile() {
        let tally = check(&profile, &rays);
        assert!(tally.is_clean(), "{name}: {tally}");
    }
}

fn check(profile: &Profile, rays: &impl Fn(&Oracle, &Profile, &mut Random) -> Vec<Ray>) -> Tally {
    let (surface, oracle) = (Surface::new(profile), Oracle::new(profile));
    let mut tally = Tally::default();
    for ray in rays(&oracle, profile, &mut Random::new(21)) {
        tally.compare(&surface, &oracle, &ray, profile.bounds_solid());
    }
    if profile.bounds_solid() {
        let rays = rays(&oracle, profile, &mut Random::new(21));
        check_spans(profile, &oracle, &rays);
    }
    tally
}

/// Spans are in order, disjoint and of both fill rules' making, and their ends are hits: all of them by
/// the even-odd rule, but those that rounding cannot tell apart.
fn check_spans(profile: &Profile, oracle: &Oracle, rays: &[Ray]) {
    let surface = scalar_surface(profile);
    let [even_odd, non_zero] = [FillRule::EvenOdd, FillRule::NonZero]
        .map(|rule| Solid::from_surface(Arc::clone(&surface), rule).expect("a closed profile"));
    let (mut spans, mut hits) = (Vec::new(), Vec::new());
    for ray in rays {
        surface.all(ray, &mut hits);
        for solid in [&even_odd, &non_zero] {
            solid.spans(ray, &mut spans);
            assert!(spans.iter().all(|s| s.enter.t < s.exit.t), "{profile:?} {ray:?} {spans:?}");
            assert!(spans.is_sorted_by(|a, b| a.exit.t < b.enter.t), "{profile:?} {ray:?}");
            for end in spans.iter().flat_map(|s| [s.enter, s.exit]) {
                let cut = end.t == ray.t_min || end.t == ray.t_max;
                let found = end.wall.map_or(cut, |wall| hits.contains(&wall.hit));
                assert!(found, "{profile:?} {ray:?} {end:?}");
            }
            if solid.fill_rule() == FillRule::EvenOdd && ray.t_min == f64::NEG_INFINITY {
                let walls: Vec<_> =
                    spans.iter().flat_map(|s| [s.enter.wall, s.exit.wall]).flatten().collect();
                let others = hits.iter().filter(|h| walls.iter().all(|wall| wall.hit != **h));
                let ts: Vec<f64> = others.map(|h| h.t).collect();
                let (pairs, rest) = ts.as_chunks::<2>();
                // Hits that are none of the spans' lie two by two, as near as rounding makes them.
                let apart = pairs.iter().map(|[a, b]| b - a).fold(0.0, f64::max);
                let speed = ray.direction.max_abs();
                let thin =
                    apart * speed < 1e-6 * oracle.size() || nearly_along(&surface, ray, &hits);
                assert!(rest.is_empty() && thin, "{profile:?} {ray:?} {apart:e}");
            }
        }
    }
}

/// Whether the ray runs along the surface somewhere, so that rounding moves a hit far along it.
fn nearly_along(surface: &Surface, ray: &Ray, hits: &[rondure::Hit]) -> bool {
    let speed = ray.direction.max_abs();
    hits.iter()
        .any(|hit| surface.interaction(ray, hit).normal.dot(ray.direction).abs() < 1e-6 * speed)
}

fn random_lines(n: usize) -> impl Fn(&Oracle, &Profile, &mut Random) -> Vec<Ray> {
    move |oracle, _, random| (0..n).map(|_| random.line(oracle.center(), oracle.size())).collect()
}

/// Points where rays go through: vertices and random points of the profile, at random angles.
fn targets(profile: &Profile, random: &mut Random) -> Vec<Vec3> {
    let mut points = Vec::new();
    let segments: Vec<_> = profile.segments().collect();
    let step = segments.len().div_ceil(8);
    for segment in segments.iter().step_by(step) {
        for p in [segment.start(), segment.end(), segment.point(random.unit())] {
            points.push(Vec3::new(p.r, 0.0, p.z));
            let (sin, cos) = (random.unit() * 7.0).sin_cos();
            points.push(Vec3::new(p.r * cos, p.r * sin, p.z));
        }
    }
    points
}

#[test]
fn random_lines_at_every_feature() {
    check_all(random_lines(300));
}

#[test]
fn parallel_to_the_axis() {
    check_all(|oracle, profile, random| {
        let below = oracle.center().z - 3.0 * oracle.size();
        let mut rays: Vec<_> = (0..100)
            .map(|_| {
                let p = random.cube() * oracle.size();
                Ray::line(Vec3::new(p.x, p.y, below), Vec3::Z)
            })
            .collect();
        rays.extend(
            targets(profile, random).iter().map(|p| Ray::line(Vec3::new(p.x, p.y, below), Vec3::Z)),
        );
        rays
    });
}

#[test]
fn on_the_axis() {
    check_all(|oracle, _, _| {
        let below = Vec3::new(0.0, 0.0, oracle.center().z - 3.0 * oracle.size());
        vec![
            Ray::line(below, Vec3::Z),
            Ray::line(below, -Vec3::Z),
            Ray::new(below, Vec3::Z),
            Ray::new(oracle.center(), Vec3::Z * 1e-7),
            Ray::line(below, Vec3::new(-0.0, 0.0, 1.0)),
            Ray::line(below, Vec3::new(0.0, -0.0, -1.0)),
        ]
    });
}

#[test]
fn nearly_parallel_to_the_axis() {
    check_all(|oracle, profile, random| {
        let mut rays = Vec::new();
        for tilt in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-20, 1e-100, 1e-200, 1e-300] {
            for p in targets(profile, random).into_iter().take(12) {
                let d = Vec3::new(tilt, tilt * random.within(-1.0, 1.0), 1.0);
                rays.push(Ray::line(p + d * (-2.0 * oracle.size()), d));
            }
            let d = Vec3::new(tilt, 0.0, -1.0);
            rays.push(Ray::line(
                oracle.center() + random.cube() * (0.3 * oracle.size()) - d * 3.0,
                d,
            ));
        }
        rays
    });
}

#[test]
fn perpendicular_to_the_axis() {
    check_all(|oracle, profile, random| {
        let mut rays: Vec<_> = (0..100)
            .map(|_| {
                let line = random.line(oracle.center(), oracle.size());
                let d = line.direction;
                let height = oracle.center().z + random.within(-0.5, 0.5) * oracle.size();
                let o = line.origin;
                Ray::line(Vec3::new(o.x, o.y, height), Vec3::new(d.x, d.y, 0.0))
            })
            .collect();
        for p in targets(profile, random) {
            rays.push(Ray::line(Vec3::new(-3.0, 0.1, p.z), Vec3::new(1.0, -0.02, 0.0)));
            rays.push(Ray::line(Vec3::new(-3.0, 0.0, p.z), Vec3::X));
            rays.push(Ray::line(Vec3::new(3.0, 0.2, p.z), Vec3::new(-1.0, 0.0, -0.0)));
        }
        rays
    });
}

#[test]
fn almost_perpendicular_to_the_axis() {
    check_all(|oracle, profile, random| {
        let mut rays = Vec::new();
        for tilt in [1e-2, 1e-4, 1e-8, 1e-12, 1e-15, 1e-17, 1e-30, 1e-100, 1e-200, 1e-300, 5e-324] {
            for p in targets(profile, random).into_iter().take(10) {
                let d = Vec3::new(
                    1.0,
                    random.within(-0.3, 0.3),
                    if random.below(2) == 0 { tilt } else { -tilt },
                );
                rays.push(Ray::line(p + d * (-2.0 * oracle.size()), d));
                let side = Vec3::new(0.0, random.within(-0.4, 0.4), 0.0) * oracle.size();
                rays.push(Ray::line(Vec3::new(-3.0, 0.0, p.z) + side, Vec3::new(1.0, 0.0, tilt)));
            }
        }
        rays
    });
}

#[test]
fn through_the_axis() {
    check_all(|oracle, profile, random| {
        let mut rays = Vec::new();
        for p in targets(profile, random) {
            // In the plane y = 0, where k is exactly 0.
            let on_axis =
                Vec3::new(0.0, 0.0, oracle.center().z + random.within(-0.5, 0.5) * oracle.size());
            let d = Vec3::new(1.0, 0.0, random.within(-1.0, 1.0));
            rays.push(Ray::line(on_axis - d * 4.0, d));
            if p.y == 0.0 {
                rays.push(Ray::line(p + (p - on_axis) * 2.0, on_axis - p));
            }
        }
        rays.retain(|r| r.direction.max_abs() > 0.0);
        rays
    });
}

#[test]
fn tangent() {
    // At 1e-11 to 1e-6 of the size from the surface counts must be right; nearer, even.
    check_all(|oracle, profile, random| {
        let mut rays = Vec::new();
        for segment in profile.segments().take(12) {
            for _ in 0..4 {
                let s = random.within(0.05, 0.95);
                let (p, q, o) =
                    (segment.point(s), segment.point(s + 1e-6), segment.point(s - 1e-6));
                let (tr, tz) = (q.r - o.r, q.z - o.z);
                let length = tr.hypot(tz);
                if length == 0.0 {
                    continue;
                }
                let normal = Vec3::new(tz / length, 0.0, -tr / length);
                let along =
                    Vec3::new(tr / length, 0.0, tz / length) + Vec3::Y * random.within(-1.0, 1.0);
                for gap in [0.0, 1e-16, 1e-14, 1e-11, -1e-11, 1e-9, -1e-9, 1e-6, -1e-6] {
                    let origin = Vec3::new(p.r, 0.0, p.z) + normal * (gap * oracle.size());
                    rays.push(Ray::line(origin - along * 2.0, along));
                }
            }
        }
        rays
    });
}

#[test]
fn through_a_joint() {
    check_all(|oracle, profile, random| {
        let mut rays = Vec::new();
        for p in targets(profile, random) {
            for d in [random.direction(), Vec3::new(1.0, 0.0, 0.25), Vec3::new(0.5, 1.0, -0.5)] {
                rays.push(Ray::line(p - d * 2.0, d));
                rays.push(Ray::line(p - d * (4.0 * oracle.size()), d));
            }
        }
        rays
    });
}

#[test]
fn starting_on_the_surface() {
    // The rest of the ray must be right, whether or not the start itself counts.
    check_all(|_, profile, random| {
        let mut rays = Vec::new();
        for p in targets(profile, random) {
            for _ in 0..4 {
                rays.push(Ray::new(p, random.direction()));
            }
        }
        rays
    });
}

#[test]
fn from_a_million_sizes_away() {
    check_all(|oracle, profile, random| {
        let mut rays = Vec::new();
        for p in targets(profile, random) {
            for distance in [1e3, 1e6] {
                let d = random.direction();
                rays.push(Ray::line(p - d * (distance * oracle.size()), d));
            }
        }
        rays
    });
}

#[test]
fn directions_of_any_length() {
    check_all(|oracle, _, random| {
        let mut rays = Vec::new();
        for exponent in [-200, -150, -100, -20, 20, 100, 150, 200] {
            for _ in 0..20 {
                let line = random.line(oracle.center(), oracle.size());
                rays.push(Ray::line(line.origin, line.direction * 10f64.powi(exponent)));
            }
        }
        rays
    });
}

#[test]
fn sizes_from_1e_6_to_1e6() {
    for (name, _) in STANDARD {
        for exponent in [-20, -6, -5, 5, 6, 20] {
            let profile = scaled(&standard(name), 10f64.powi(exponent), 0.0);
            let tally = check(&profile, &random_lines(100));
            assert!(tally.is_clean(), "{name} 1e{exponent}: {tally}");
        }
    }
}

#[test]
fn far_from_the_origin() {
    for (name, _) in STANDARD {
        for offset in [10.0, 30.0, 100.0, 1e6, -1e6] {
            let profile = scaled(&standard(name), 1.0, offset);
            let tally = check(&profile, &random_lines(200));
            assert!(tally.is_clean(), "{name} at {offset:e}: {tally}");
        }
    }
}

#[test]
fn polyline_of_ten_thousand_points() {
    let points: Vec<_> = (0..10_000)
        .map(|i| {
            let z = i as f64 / 10_000.0;
            Point::new(0.6 + 0.25 * (7.0 * z).sin() + 0.1 * (17.0 * z).sin(), z)
        })
        .collect();
    let mut builder = Profile::builder().move_to(points[0].r, points[0].z);
    for p in &points[1..] {
        builder = builder.line_to(p.r, p.z);
    }
    let profile = builder.build().unwrap();
    let tally = check(&profile, &random_lines(60));
    tally.assert_clean();
}

#[test]
fn splines_through_points() {
    let points: Vec<_> = [(0.0, 0.0), (1.0, 0.2), (0.6, 1.0), (1.1, 2.0), (0.3, 2.5)]
        .map(|(r, z)| Point::new(r, z))
        .into();
    for spline in [Spline::Polyline, Spline::Natural, Spline::CatmullRom] {
        let profile = Profile::through_points(&points, spline).unwrap();
        check(&profile, &random_lines(300)).assert_clean();
    }
}

#[test]
fn profile_that_crosses_the_axis_is_refused() {
    for text in [
        "M 1 0 L -0.5 1",
        "M 1 0 Q -2 0.5 1 1",
        "M 1 0 C -2 0 -2 1 1 1",
        "M 1 0 A 2 2 0 1 0 1 1",
        "M 0.5 0 L -1e-300 1",
    ] {
        let error = Profile::from_path_data(text).expect_err(text);
        let ProfileErrorKind::NegativeRadius { point, s } = error.kind else {
            panic!("{text}: {error}");
        };
        assert!(
            point.r < 0.0 && (0.0..=1.0).contains(&s) && error.segment == Some(0),
            "{text}: {error}"
        );
    }
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let surface = Surface::new(&standard("goblet"));
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let mut rays = vec![Ray::line(Vec3::ZERO, Vec3::ZERO)];
    for x in bad {
        rays.push(Ray::line(Vec3::new(x, 0.0, 0.0), Vec3::X));
        rays.push(Ray::line(Vec3::new(0.0, 0.0, x), Vec3::Z));
        rays.push(Ray::line(Vec3::new(-3.0, 0.0, 0.5), Vec3::new(x, 0.0, 0.0)));
        rays.push(Ray::line(Vec3::new(-3.0, 0.0, 0.5), Vec3::new(1.0, 0.0, x)));
    }
    rays.push(Ray::new(Vec3::new(-3.0, 0.0, 0.5), Vec3::X).with_range(5.0, 1.0));
    let mut hits = Vec::new();
    for ray in rays {
        surface.all(&ray, &mut hits);
        assert!(
            hits.is_empty() && surface.closest(&ray).is_none() && !surface.any(&ray),
            "{ray:?}"
        );
    }
}

/// The profile times `factor`, then shifted along the axis; every coordinate is rounded once or twice.
fn scaled(profile: &Profile, factor: f64, offset: f64) -> Profile {
    use rondure::Segment;
    let mut path = Profile::builder();
    let z = |z: f64| z * factor + offset;
    for subpath in profile.subpaths() {
        path = path.move_to(subpath.start().r * factor, z(subpath.start().z));
        for segment in subpath.segments() {
            let end = segment.end();
            let (r1, z1) = (end.r * factor, z(end.z));
            path = match segment {
                Segment::Line(_) => path.line_to(r1, z1),
                Segment::Quadratic([_, c, _]) => path.quad_to([c.r * factor, z(c.z)], r1, z1),
                Segment::Cubic([_, c, d, _]) => {
                    path.cubic_to([c.r * factor, z(c.z)], [d.r * factor, z(d.z)], r1, z1)
                }
                Segment::Arc(arc) => {
                    let radii = arc.radii.map(|r| r * factor);
                    let large = arc.sweep_angle.abs() > core::f64::consts::PI;
                    path.arc_to(radii, arc.rotation, large, arc.sweep_angle > 0.0, r1, z1)
                }
            };
        }
        if subpath.is_closed() {
            path = path.close();
        }
    }
    path.build().unwrap()
}

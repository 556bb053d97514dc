//! Spans, inside tests and distances of solids: closed forms, each against the others, and fill rules.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use rondure::{FillRule, Profile, Ray, Solid, Vec3, solid::Span};
use rondure_oracle::{
    Oracle, Random,
    closed_form::Solid as Equation,
    profiles::{SOLIDS, STANDARD, standard},
    solids::{RULES, corners_differ, scalar_surface},
};

fn solid(path: &str, rule: FillRule) -> Solid {
    Solid::new(&Profile::from_path_data(path).unwrap(), rule).unwrap()
}

fn spans(solid: &Solid, ray: &Ray) -> Vec<Span> {
    let mut spans = Vec::new();
    solid.spans(ray, &mut spans);
    spans
}

fn ends(spans: &[Span]) -> Vec<[f64; 2]> {
    spans.iter().map(|s| [s.enter.t, s.exit.t]).collect()
}

/// Profiles that bound solids: the standard ones, and what crosses, touches and repeats itself.
fn profiles() -> Vec<(String, Profile)> {
    const MORE: &[&str] = &[
        "M 0 0 C 3 1 -1 1 1 0 L 0.2 1.5 L 0 1.5",
        "M 0 0 L 1 0.5 L 0 1 L 1 1.5 L 0 2",
        "M 1 0 L 3 0 L 1 2 L 3 2 Z",
        "M 1 0 C 4 3 -1.5 3 2 0 Z",
        // Squares within, beside, across and upon each other.
        "M 1 0 H 4 V 3 H 1 Z M 2 1 H 3 V 2 H 2 Z",
        "M 1 0 H 4 V 3 H 1 Z M 2 1 V 2 H 3 V 1 Z",
        "M 1 0 H 2 V 1 H 1 Z M 2 0 H 3 V 1 H 2 Z",
        "M 1 0 H 3 V 2 H 1 Z M 2 1 H 4 V 3 H 2 Z",
        "M 1 0 H 3 V 2 H 1 Z M 1 0 H 3 V 2 H 1 Z",
        "M 1 0 H 3 V 2 H 1 Z M 1 0 V 2 H 3 V 0 Z",
    ];
    let standard = STANDARD.iter().map(|&(name, text)| (name, text));
    standard
        .chain(MORE.iter().map(|text| (*text, *text)))
        .map(|(name, text)| (name.to_string(), Profile::from_path_data(text).unwrap()))
        .filter(|(_, profile)| profile.bounds_solid())
        .collect()
}

fn for_rays(rays: usize, mut check: impl FnMut(&str, &Solid, f64, &Ray)) {
    let mut random = Random::new(51);
    let drawn = (0..40).map(|i| {
        loop {
            let profile = random.profile();
            if profile.bounds_solid() {
                return (format!("random {i}: {profile:?}"), profile);
            }
        }
    });
    let all: Vec<_> = profiles().into_iter().chain(drawn).collect();
    for (name, profile) in &all {
        let oracle = Oracle::new(profile);
        for rule in RULES {
            let solid = Solid::new(profile, rule).unwrap();
            for _ in 0..rays {
                check(name, &solid, oracle.size(), &random.line(oracle.center(), oracle.size()));
            }
        }
    }
}

#[test]
fn spans_are_ordered_and_disjoint() {
    for_rays(500, |name, solid, _, ray| {
        let spans = spans(solid, ray);
        assert!(spans.iter().all(|s| s.enter.t < s.exit.t), "{name} {ray:?} {spans:?}");
        assert!(spans.is_sorted_by(|a, b| a.exit.t < b.enter.t), "{name} {ray:?} {spans:?}");
        assert!(spans.iter().all(|s| s.enter.wall.is_some() && s.exit.wall.is_some()), "{name}");
    });
}

#[test]
fn spans_lie_between_the_hits_of_the_equation() {
    let mut random = Random::new(52);
    for (name, equation) in SOLIDS {
        let profile = standard(name);
        let (solid, oracle) =
            (Solid::new(&profile, FillRule::NonZero).unwrap(), Oracle::new(&profile));
        let mut other_count = 0;
        for _ in 0..5000 {
            let ray = random.line(oracle.center(), oracle.size());
            let expected: Vec<f64> = equation.hits(&ray).iter().map(|t| t.hi).collect();
            let found: Vec<f64> = ends(&spans(&solid, &ray)).into_iter().flatten().collect();
            if found.len() != expected.len() {
                other_count += 1;
                continue;
            }
            for (f, e) in found.iter().zip(&expected) {
                let off = (f - e).abs() * ray.direction.length();
                assert!(off < 1e-10 * oracle.size(), "{name} {ray:?} {off:e}");
            }
        }
        assert_eq!(other_count, 0, "{name}");
    }
}

#[test]
fn the_middle_of_a_span_is_inside_and_that_of_a_gap_is_not() {
    let (mut middles, mut thin) = (0, 0);
    for_rays(500, |name, solid, size, ray| {
        let spans = spans(solid, ray);
        let mut check = |from: f64, to: f64, inside: bool| {
            let middle = 0.5 * (from + to);
            middles += 1;
            if solid.contains(ray.at(middle)) != inside {
                assert!(
                    corners_differ(solid, ray.at(middle), 1e-12 * size),
                    "{name} {ray:?} {from} {to} {inside}"
                );
                thin += 1;
            }
        };
        for span in &spans {
            check(span.enter.t, span.exit.t, true);
        }
        for pair in spans.windows(2) {
            check(pair[0].exit.t, pair[1].enter.t, false);
        }
    });
    assert!(middles > 40_000 && thin < middles / 1000, "{middles} {thin}");
}

#[test]
fn normals_face_the_ray_where_it_enters() {
    for_rays(200, |name, solid, _, ray| {
        for span in spans(solid, ray) {
            for (end, sign) in [(span.enter, -1.0), (span.exit, 1.0)] {
                let at = solid.interaction(ray, &end.wall.unwrap());
                let sine = sign * at.normal.dot(ray.direction) / ray.direction.length();
                assert!(sine > -1e-7, "{name} {ray:?} {span:?} {sine:e}");
            }
        }
    });
}

#[test]
fn a_range_cuts_the_spans_of_the_line() {
    let mut random = Random::new(53);
    for_rays(200, |name, solid, size, line| {
        let speed = line.direction.length();
        let mut end = || random.within(-1.0, 5.0) * size / speed;
        let (a, b) = (end(), end());
        let ray = line.with_range(a.min(b), a.max(b));
        let expected: Vec<[f64; 2]> = ends(&spans(solid, line))
            .into_iter()
            .map(|[enter, exit]| [enter.max(ray.t_min), exit.min(ray.t_max)])
            .filter(|[enter, exit]| enter < exit)
            .collect();
        let found = spans(solid, &ray);
        assert_eq!(ends(&found), expected, "{name} {ray:?}");
        for end in found.iter().flat_map(|s| [s.enter, s.exit]) {
            let cut = end.t == ray.t_min || end.t == ray.t_max;
            assert_eq!(end.wall.is_none(), cut, "{name} {ray:?} {end:?}");
        }
    });
}

#[test]
fn spans_begin_and_end_at_the_hits_by_the_even_odd_rule() {
    for_rays(300, |name, solid, size, ray| {
        if solid.fill_rule() == FillRule::EvenOdd {
            let mut hits = Vec::new();
            scalar_surface(solid.surface().profile()).all(ray, &mut hits);
            let found: Vec<f64> = ends(&spans(solid, ray)).into_iter().flatten().collect();
            // What is missing lies at the same place, two by two.
            let missing: Vec<f64> =
                hits.iter().map(|h| h.t).filter(|t| !found.contains(t)).collect();
            let (pairs, rest) = missing.as_chunks::<2>();
            let gap = |[a, b]: &[f64; 2]| (b - a) * ray.direction.length();
            assert!(
                rest.is_empty() && pairs.iter().all(|p| gap(p) < 2e-7 * size),
                "{name} {ray:?}"
            );
            assert!(found.len() + missing.len() == hits.len(), "{name} {ray:?}");
        }
    });
}

#[test]
fn fill_rules_are_those_of_svg() {
    let along = Ray::line(Vec3::new(-9.0, 0.0, 1.5), Vec3::X);
    let right = |path, rule| {
        let mut ends = ends(&spans(&solid(path, rule), &along));
        ends.retain(|e| e[0] > 9.0);
        ends.into_iter().map(|[a, b]| [a - 9.0, b - 9.0]).collect::<Vec<_>>()
    };
    let [non_zero, even_odd] = RULES;
    let same_way = "M 1 0 H 4 V 3 H 1 Z M 2 1 H 3 V 2 H 2 Z";
    assert_eq!(right(same_way, non_zero), [[1.0, 4.0]]);
    assert_eq!(right(same_way, even_odd), [[1.0, 2.0], [3.0, 4.0]]);
    let other_way = "M 1 0 H 4 V 3 H 1 Z M 2 1 V 2 H 3 V 1 Z";
    for rule in RULES {
        assert_eq!(right(other_way, rule), [[1.0, 2.0], [3.0, 4.0]]);
    }
    // Side by side, sharing a face: no gap and no boundary between them.
    let beside = "M 1 0 H 2 V 3 H 1 Z M 2 0 H 3 V 3 H 2 Z";
    for rule in RULES {
        assert_eq!(right(beside, rule), [[1.0, 3.0]]);
    }
    let twice = "M 1 0 H 3 V 3 H 1 Z M 1 0 H 3 V 3 H 1 Z";
    assert_eq!(right(twice, non_zero), [[1.0, 3.0]]);
    assert!(right(twice, even_odd).is_empty());
    let undone = "M 1 0 H 3 V 3 H 1 Z M 1 0 V 3 H 3 V 0 Z";
    for rule in RULES {
        assert!(right(undone, rule).is_empty());
    }
    // A loop in the outline is wound round twice.
    let pentagram = "M 2 0 L 3.2 3.6 L 0.1 1.4 L 3.9 1.4 L 0.8 3.6 Z";
    let middle = Vec3::new(0.0, 2.0, 1.8);
    assert!(solid(pentagram, non_zero).contains(middle));
    assert!(!solid(pentagram, even_odd).contains(middle));
}

#[test]
fn open_profiles_bound_no_solid() {
    let open = Profile::from_path_data("M 0 0 L 1 0 L 0 1 M 0 2 L 1 2").unwrap();
    let error = Solid::new(&open, FillRule::NonZero).unwrap_err();
    assert_eq!(
        error.to_string(),
        "subpath 1 bounds no solid: it runs from (r = 0, z = 2) to (r = 1, z = 2); close it, let \
         both ends lie on the axis, or cap it"
    );
}

#[test]
fn inside_is_what_the_equation_says() {
    let mut random = Random::new(54);
    for (name, equation) in SOLIDS {
        let profile = standard(name);
        let (solid, oracle) =
            (Solid::new(&profile, FillRule::NonZero).unwrap(), Oracle::new(&profile));
        let mut inside = 0;
        for _ in 0..200_000 {
            let p = oracle.center() + random.cube() * (0.6 * oracle.size());
            let rho = p.x.hypot(p.y);
            let depth = match equation {
                Equation::Sphere { radius } => radius - p.length(),
                Equation::Cylinder { radius, height } => (radius - rho).min(p.z).min(height - p.z),
                Equation::Cone { radius, height } => {
                    (radius * (1.0 - p.z / height) - rho).min(p.z).min(height - p.z)
                }
                Equation::Torus { major, minor } => minor - (rho - major).hypot(p.z),
            };
            if depth.abs() > 1e-15 {
                assert_eq!(solid.contains(p), depth > 0.0, "{name} {p:?}");
                inside += usize::from(depth > 0.0);
            }
        }
        assert!(inside > 10_000, "{name}");
    }
    let nothing = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let sphere = Solid::new(&standard("sphere"), FillRule::NonZero).unwrap();
    for x in nothing {
        assert!(
            !sphere.contains(Vec3::new(x, 0.0, 0.0)) && !sphere.contains(Vec3::new(0.0, 0.0, x))
        );
    }
}

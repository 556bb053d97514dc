//! Signed distances of solids: closed forms, dense samples, and what every distance must do.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use rondure::{FillRule, Profile, Solid, Vec3};
use rondure_oracle::{
    Oracle, Random,
    closed_form::Solid as Equation,
    profiles::{SOLIDS, STANDARD, standard},
    solids::RULES,
};

/// What the documentation promises, in units of the larger of the solid's size and the distance; the
/// closed forms below have roundings of their own.
const EXACT: f64 = 64.0 * rondure::numeric::UNIT_ROUNDOFF;

/// The signed distance from a convex polygon's inside, or from the torus' tube.
fn closed_form(equation: Equation, p: Vec3) -> f64 {
    let (rho, z) = (p.x.hypot(p.y), p.z);
    let to_edge = |[a, b]: [[f64; 2]; 2]| {
        let (along, to) = ([b[0] - a[0], b[1] - a[1]], [rho - a[0], z - a[1]]);
        let length2 = along[0] * along[0] + along[1] * along[1];
        let s = ((along[0] * to[0] + along[1] * to[1]) / length2).clamp(0.0, 1.0);
        (to[0] - s * along[0]).hypot(to[1] - s * along[1])
    };
    let (edges, inside): (Vec<[[f64; 2]; 2]>, bool) = match equation {
        Equation::Sphere { radius } => return p.length() - radius,
        Equation::Torus { major, minor } => return (rho - major).hypot(z) - minor,
        Equation::Cylinder { radius, height } => {
            let [a, b, c, d] = [[0.0, 0.0], [radius, 0.0], [radius, height], [0.0, height]];
            (vec![[a, b], [b, c], [c, d]], rho < radius && 0.0 < z && z < height)
        }
        Equation::Cone { radius, height } => {
            let [a, b, c] = [[0.0, 0.0], [radius, 0.0], [0.0, height]];
            (vec![[a, b], [b, c]], z > 0.0 && rho * height < radius * (height - z))
        }
    };
    let distance = edges.into_iter().map(to_edge).fold(f64::INFINITY, f64::min);
    if inside { -distance } else { distance }
}

#[test]
fn distances_are_those_of_the_equation() {
    let mut random = Random::new(61);
    for (name, equation) in SOLIDS {
        let profile = standard(name);
        let (solid, oracle) =
            (Solid::new(&profile, FillRule::NonZero).unwrap(), Oracle::new(&profile));
        let mut worst = 0.0_f64;
        for i in 0..60_000 {
            let reach = [0.6, 3.0, 100.0][i % 3] * oracle.size();
            let mut p = oracle.center() + random.cube() * reach;
            if i % 7 == 0 {
                (p.x, p.y) = (0.0, 0.0);
            }
            let expected = closed_form(equation, p);
            let off = (solid.distance(p) - expected).abs() / oracle.size().max(expected.abs());
            worst = worst.max(off);
        }
        println!("{name}: worst {worst:e}");
        assert!(worst < EXACT, "{name} {worst:e}");
    }
}

#[test]
fn from_the_middle_of_an_arc_all_of_it_is_equally_near() {
    let torus = Solid::new(&standard("torus"), FillRule::NonZero).unwrap();
    for angle in [0.0, 0.3, 2.0_f64] {
        let p = Vec3::new(2.0 * angle.cos(), 2.0 * angle.sin(), 0.0);
        assert!((torus.distance(p) + 1.0).abs() < EXACT);
    }
    let ball = Solid::new(&standard("sphere"), FillRule::NonZero).unwrap();
    assert!((ball.distance(Vec3::ZERO) + 1.0).abs() < EXACT);
    let tiny = Vec3::new(1e-17, 0.0, -3e-18);
    assert!((ball.distance(tiny) + 1.0).abs() < EXACT);
}

#[test]
fn nothing_is_infinitely_far_from_a_solid_without_inside() {
    let path = "M 1 0 H 3 V 3 H 1 Z M 1 0 V 3 H 3 V 0 Z";
    let solid = Solid::new(&Profile::from_path_data(path).unwrap(), FillRule::NonZero).unwrap();
    assert_eq!(solid.distance(Vec3::X), f64::INFINITY);
    assert!(solid.distance(Vec3::new(f64::NAN, 0.0, 0.0)).is_nan());
}

fn profiles() -> Vec<(String, Profile)> {
    const MORE: &[&str] = &[
        "M 0 0 C 3 1 -1 1 1 0 L 0.2 1.5 L 0 1.5",
        "M 1 0 L 3 0 L 1 2 L 3 2 Z",
        "M 1 0 C 4 3 -1.5 3 2 0 Z",
        "M 2 0 L 3.2 3.6 L 0.1 1.4 L 3.9 1.4 L 0.8 3.6 Z",
        "M 1 0 H 4 V 3 H 1 Z M 2 1 H 3 V 2 H 2 Z",
        "M 1 0 H 4 V 3 H 1 Z M 2 1 V 2 H 3 V 1 Z",
        "M 1 0 H 2 V 1 H 1 Z M 2 0 H 3 V 1 H 2 Z",
        "M 1 0 H 2 V 1 H 1 Z M 2 -1 H 3 V 2 H 2 Z",
        "M 1 0 H 3 V 2 H 1 Z M 2 1 H 4 V 3 H 2 Z",
        "M 1 0 H 3 V 2 H 1 Z M 1 0 H 3 V 2 H 1 Z",
        // Circles that share arcs, touch, and cross.
        "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z M 3 0 A 1 1 0 0 0 1 0 L 2 3 Z",
        "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z M 5 0 A 1 1 0 0 1 3 0 A 1 1 0 0 1 5 0 Z",
        "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z M 4 0 A 1 1 0 0 1 2 0 A 1 1 0 0 1 4 0 Z",
    ];
    let mut random = Random::new(62);
    let standard = STANDARD.iter().map(|&(name, text)| (name, text));
    let mut all: Vec<_> = standard
        .chain(MORE.iter().map(|text| (*text, *text)))
        .map(|(name, text)| (name.to_string(), Profile::from_path_data(text).unwrap()))
        .filter(|(_, profile)| profile.bounds_solid())
        .collect();
    while all.len() < 80 {
        let profile = random.profile();
        if profile.bounds_solid() {
            all.push((format!("{profile:?}"), profile));
        }
    }
    all
}

fn for_solids(mut check: impl FnMut(&str, &Profile, &Solid, &Oracle, &mut Random)) {
    let mut random = Random::new(63);
    for (name, profile) in profiles() {
        let oracle = Oracle::new(&profile);
        for rule in RULES {
            let solid = Solid::new(&profile, rule).unwrap();
            let label = format!("{name} {rule:?}");
            check(&label, &profile, &solid, &oracle, &mut random);
        }
    }
}

#[test]
fn no_sample_of_the_surface_is_nearer_and_one_is_nearly_as_near() {
    const STEPS: u32 = 1000;
    let mut empty = 0;
    for_solids(|name, profile, solid, oracle, random| {
        // Points of the profile with the inside on one side, by a test of four neighbours.
        let aside = 1e-7 * oracle.size();
        let mut samples: Vec<[f64; 2]> = Vec::new();
        let mut widest = 0.0_f64;
        for segment in profile.segments() {
            for i in 0..STEPS {
                let [p, next] = [i, i + 1].map(|i| segment.point(f64::from(i) / f64::from(STEPS)));
                widest = widest.max((next - p).length());
                let sides = [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dr, dz)| {
                    let (dr, dz) = (f64::from(dr) * aside, f64::from(dz) * aside);
                    solid.contains(Vec3::new((p.r + dr).max(0.0), 0.0, p.z + dz))
                });
                if sides.iter().any(|s| *s != sides[0]) {
                    samples.push([p.r, p.z]);
                }
            }
        }
        for _ in 0..100 {
            let p = oracle.center() + random.cube() * (0.8 * oracle.size());
            let rho = p.x.hypot(p.y);
            let sampled =
                samples.iter().map(|[r, z]| (r - rho).hypot(z - p.z)).fold(f64::INFINITY, f64::min);
            let found = solid.distance(p);
            assert_eq!(found < 0.0, solid.contains(p), "{name} {p:?}");
            let found = found.abs();
            if found.is_infinite() {
                // Drawn back and forth: at most points within rounding of the curve are inside.
                empty += 1;
                continue;
            }
            assert!(found <= sampled + 3.0 * aside, "{name} {p:?} {found} {sampled}");
            assert!(found >= sampled - 1.5 * widest - aside, "{name} {p:?} {found} {sampled}");
        }
    });
    // A few of the random profiles are one line, drawn back to close it.
    assert!(empty <= 1000, "{empty}");
}

#[test]
fn the_nearest_point_is_that_far_and_its_normal_points_out() {
    let (mut all, mut edges) = (0, 0);
    for_solids(|name, _, solid, oracle, random| {
        for _ in 0..200 {
            let p = oracle.center() + random.cube() * oracle.size();
            let Some(nearest) = solid.nearest(p) else { continue };
            let way = p - nearest.point;
            let off = (way.length() - nearest.distance.abs()).abs() / oracle.size();
            assert!(off < EXACT, "{name} {p:?} {off:e}");
            // Away from edges the way to the point is along the normal.
            all += 1;
            let along = way.dot(nearest.normal);
            if (along - nearest.distance).abs() > 1e-9 * oracle.size() {
                edges += 1;
            }
            assert!(along.signum() == nearest.distance.signum(), "{name} {p:?} {nearest:?}");
            let again = solid.distance(nearest.point).abs() / oracle.size();
            assert!(again < EXACT, "{name} {p:?} {again:e}");
        }
    });
    assert!(edges < all / 2, "{edges} of {all}");
}

#[test]
fn distances_grow_no_faster_than_their_points_move() {
    for_solids(|name, _, solid, oracle, random| {
        let mut last = oracle.center();
        for i in 0..400 {
            let step = [1.0, 1e-3, 1e-8][i % 3] * oracle.size();
            let next = if i % 20 == 0 {
                oracle.center() + random.cube() * oracle.size()
            } else {
                last + random.cube() * step
            };
            let grown = (solid.distance(next) - solid.distance(last)).abs();
            let moved = (next - last).length();
            let allowed = moved + 2.0 * EXACT * oracle.size().max(solid.distance(next).abs());
            let empty = solid.distance(next).is_infinite();
            assert!(empty || grown <= allowed, "{name} {last:?} {next:?} {grown} {moved}");
            last = next;
        }
    });
}

//! Walls against closed forms, and the distance of their sides from the curve.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use core::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use rondure::{
    FillRule, Point, Profile, ProfileErrorKind, Segment, Solid, Vec3,
    profile::{OFFSET_ACCURACY, Rim, Side, Thickness},
};

fn draw(path: &str) -> Profile {
    Profile::from_path_data(path).unwrap()
}

fn wall(thickness: f64, side: Side, rim: Rim) -> Thickness {
    Thickness { thickness, side, rim }
}

fn volume(profile: &Profile) -> f64 {
    profile.measure().solid.unwrap().volume
}

#[track_caller]
fn assert_volume(profile: &Profile, expected: f64) {
    let found = volume(profile);
    assert!((found / expected - 1.0).abs() < 1e-13, "{found}, not {expected}: {profile:?}");
}

const SIDES: [Side; 3] = [Side::Inward, Side::Outward, Side::Centered];

/// The distances of the faces from the curve, the inner one first.
fn faces(t: f64, side: Side) -> [f64; 2] {
    match side {
        Side::Inward => [-t, 0.0],
        Side::Outward => [0.0, t],
        Side::Centered => [-0.5 * t, 0.5 * t],
    }
}

#[test]
fn a_sphere_is_a_shell() {
    for path in ["M 0 -1 A 1 1 0 0 1 0 1", "M 0 1 A 1 1 0 0 0 0 -1"] {
        for side in SIDES {
            let [inner, outer] = faces(0.25, side).map(|d| 1.0 + d);
            let shell = draw(path).thickened(&wall(0.25, side, Rim::Flat)).unwrap();
            assert_eq!(shell.subpaths().len(), 2);
            assert_volume(&shell, 4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3)));
            let solid = Solid::new(&shell, FillRule::NonZero).unwrap();
            assert!((solid.distance(Vec3::ZERO) - inner).abs() < 1e-15);
            assert!((solid.distance(Vec3::X * 3.0) - (3.0 - outer)).abs() < 1e-15);
        }
    }
}

#[test]
fn a_bowl_ends_on_the_axis_and_in_a_rim() {
    for (side, path) in SIDES.into_iter().flat_map(|side| {
        ["M 0 -1 A 1 1 0 0 1 1 0", "M 1 0 A 1 1 0 0 0 0 -1"].map(|path| (side, path))
    }) {
        let [inner, outer] = faces(0.125, side).map(|d| 1.0 + d);
        let half = 2.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3));
        let flat = draw(path).thickened(&wall(0.125, side, Rim::Flat)).unwrap();
        let [one] = flat.subpaths() else { panic!("{flat:?}") };
        assert!(!one.is_closed() && one.bounds_solid());
        assert_volume(&flat, half);
        // Half a torus on the rim.
        let round = draw(path).thickened(&wall(0.125, side, Rim::Round)).unwrap();
        let (radius, middle) = (0.0625, 0.5 * (inner + outer));
        assert_volume(&round, half + PI * PI * radius * radius * middle);
        let solid = Solid::new(&round, FillRule::NonZero).unwrap();
        assert!((solid.bounds().max.z - radius).abs() < 1e-15);
    }
}

#[test]
fn a_line_is_a_tube() {
    for side in SIDES {
        let [inner, outer] = faces(0.5, side).map(|d| 2.0 + d);
        let tube = draw("M 2 0 V 5").thickened(&wall(0.5, side, Rim::Flat)).unwrap();
        assert!(tube.subpaths()[0].is_closed());
        assert!(tube.segments().all(|s| matches!(s, Segment::Line(_))));
        assert_volume(&tube, PI * 5.0 * (outer * outer - inner * inner));
        let round = draw("M 2 5 V 0").thickened(&wall(0.5, side, Rim::Round)).unwrap();
        let middle = 0.5 * (inner + outer);
        assert_volume(
            &round,
            PI * 5.0 * (outer * outer - inner * inner) + 2.0 * PI * PI * 0.0625 * middle,
        );
    }
}

#[test]
fn a_cone_has_a_round_tip_outside_and_a_sharp_one_inside() {
    // At 45 degrees: the inner face starts t sqrt(2) above the tip.
    let cone = draw("M 0 0 L 1 1");
    let inward = cone.thickened(&wall(0.25, Side::Inward, Rim::Flat)).unwrap();
    assert_eq!(inward.subpaths()[0].start(), Point::new(0.0, 0.0));
    assert!((inward.subpaths()[0].end().z - 0.25 * SQRT_2).abs() < 1e-15);
    // Pappus: a parallelogram from the axis, less the triangle above the rim.
    let solid = Solid::new(&inward, FillRule::NonZero).unwrap();
    assert!((solid.distance(Vec3::new(0.3, 0.0, 0.3 + 0.125 * SQRT_2)) + 0.125).abs() < 1e-15);
    let outward = cone.thickened(&wall(0.25, Side::Outward, Rim::Flat)).unwrap();
    let tip = outward.subpaths()[0].start();
    assert_eq!(tip, Point::new(0.0, -0.25));
    // A cone frustum of the sides, and the sector of 45 degrees of a ball under the tip.
    let side = |t: f64| {
        // The area t by sqrt(2), its centroid at (1 + t / sqrt(2)) / 2.
        2.0 * PI * (t * SQRT_2) * 0.5 * (1.0 + t / SQRT_2)
    };
    let ball = 2.0 / 3.0 * PI * 0.25_f64.powi(3) * (1.0 - FRAC_PI_2.mul_add(0.5, 0.0).cos());
    assert_volume(&outward, side(0.25) + ball);
}

#[test]
fn a_torus_is_a_hollow_ring() {
    let ring = draw("M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z");
    for side in SIDES {
        let [inner, outer] = faces(0.25, side).map(|d| 1.0 + d);
        let hollow = ring.thickened(&wall(0.25, side, Rim::Round)).unwrap();
        assert_volume(&hollow, 2.0 * PI * PI * 2.0 * (outer * outer - inner * inner));
    }
}

#[test]
fn corners_are_round_outside_and_sharp_inside() {
    let cup = draw("M 0 0 H 1 V 2");
    let inward = cup.thickened(&Thickness::new(0.25)).unwrap();
    assert_eq!(inward, draw("M 0 0 H 1 V 2 H 0.75 V 0.25 H 0"));
    let outward = cup.thickened(&wall(0.25, Side::Outward, Rim::Flat)).unwrap();
    assert_eq!(outward, draw("M 0 -0.25 H 1 A 0.25 0.25 0 0 1 1.25 0 V 2 H 1 V 0 H 0"));
    // Rectangles, all four corners.
    let box_ring = draw("M 1 0 H 2 V 1 H 1 Z");
    let shell = box_ring.thickened(&Thickness::new(0.25)).unwrap();
    assert_volume(&shell, PI * (3.0 - (1.75 * 1.75 - 1.25 * 1.25) * 0.5));
}

/// Both faces of a wall along a curve of every kind keep their distance.
#[test]
fn faces_keep_their_distance() {
    for path in [
        "M 0 0 C 1.4 0 0.9 1 1.2 2",
        "M 0 0 Q 1 0 1.1 1.5",
        "M 1 0 C 3 1 -0.4 1 1.2 2.3",
        "M 2 0 A 1 0.4 30 0 1 3 1",
        "M 0 0 A 2 1 0 0 1 2 1 Q 2.3 2 1.5 3 C 1 3.7 1.4 4 2 4.2",
        "M 0.5 0 L 0.9 0.1 Q 1.6 0.4 1.2 1.2 L 0.8 1.6 C 0.5 2 0.6 2.4 1.1 2.6",
    ] {
        for (t, side) in [(0.05, Side::Inward), (0.04, Side::Outward), (0.1, Side::Centered)] {
            let curve = draw(path);
            let made = curve.thickened(&wall(t, side, Rim::Round));
            let made = made.unwrap_or_else(|e| panic!("{path}, {side:?}: {e}"));
            let count = made.segments().count();
            assert!(count < 400, "{count} segments for {path}");
            println!("{path}: {count} segments");
            let [inner, outer] = faces(t, side).map(f64::abs);
            let worst = made
                .segments()
                .flat_map(|segment| (1..16).map(move |i| segment.point(f64::from(i) / 16.0)))
                .map(|p| {
                    let d = distance(&curve, p);
                    let rim = curve.subpaths()[0].start().r > 0.0 && d.1 || d.2;
                    if rim { 0.0 } else { (d.0 - inner).abs().min((d.0 - outer).abs()) }
                })
                .fold(0.0, f64::max);
            println!("{path}: {worst:e}");
            let size = made.measure();
            let size = size.r_max.max(size.z_range[1] - size.z_range[0]);
            assert!(worst <= size * OFFSET_ACCURACY, "{path}, {side:?}: {worst:e}");
        }
    }
}

/// The distance of a point from a profile, and whether the nearest point is its start or its end.
fn distance(profile: &Profile, p: Point) -> (f64, bool, bool) {
    const STEPS: u32 = 300;
    let last = profile.segments().count() - 1;
    let mut best = (f64::INFINITY, 0, 0.0);
    for (i, segment) in profile.segments().enumerate() {
        let away = |s: f64| (segment.point(s) - p).length();
        let steps = (0..=STEPS).map(|k| f64::from(k) / f64::from(STEPS));
        let s = steps.min_by(|a, b| away(*a).total_cmp(&away(*b))).unwrap();
        let width = 1.0 / f64::from(STEPS);
        let (mut low, mut high) = ((s - width).max(0.0), (s + width).min(1.0));
        for _ in 0..120 {
            let (a, b) = (low + (high - low) * 0.45, low + (high - low) * 0.55);
            if away(a) < away(b) { high = b } else { low = a }
        }
        let s = 0.5 * (low + high);
        if away(s) < best.0 {
            best = (away(s), i, s);
        }
    }
    (best.0, best.1 == 0 && best.2 < 1e-7, best.1 == last && best.2 > 1.0 - 1e-7)
}

#[track_caller]
fn error(path: &str, t: f64, side: Side) -> (ProfileErrorKind, Option<usize>) {
    let error = draw(path).thickened(&wall(t, side, Rim::Flat)).unwrap_err();
    println!("{error}");
    (error.kind, error.segment)
}

#[test]
fn folds_are_told_with_their_place() {
    // A groove of radius 0.2.
    let groove = "M 1 0 V 1 A 0.2 0.2 0 0 0 1 1.4 V 2";
    let (kind, segment) = error(groove, 0.25, Side::Outward);
    let ProfileErrorKind::WallFolds { radius, distance, .. } = kind else { panic!("{kind:?}") };
    assert!((radius - 0.2).abs() < 1e-15 && distance == 0.25 && segment == Some(1));
    assert!(draw(groove).thickened(&wall(0.25, Side::Inward, Rim::Flat)).is_ok());
    // A parabola z = (r - 1)^2 / (2 f) with its radius of curvature f = 0.5 at the bottom.
    let parabola = "M 2.2 0.64 Q 3 -0.64 3.8 0.64";
    let (kind, _) = error(parabola, 0.51, Side::Inward);
    let ProfileErrorKind::WallFolds { radius, point, .. } = kind else { panic!("{kind:?}") };
    assert!((radius - 0.5).abs() < 1e-3, "{radius}");
    assert!((point - Point::new(3.0, 0.0)).length() < 1e-3, "{point:?}");
    assert!(draw(parabola).thickened(&wall(0.49, Side::Inward, Rim::Flat)).is_ok());
    // An ellipse bends most at the ends of its long axis.
    let ellipse = "M 3 1 A 2 1 0 0 1 3 -1";
    let (kind, _) = error(ellipse, 0.51, Side::Outward);
    let ProfileErrorKind::WallFolds { radius, .. } = kind else { panic!("{kind:?}") };
    assert!((radius - 0.5).abs() < 1e-12, "{radius}");
    let (kind, segment) = error("M 1 0 H 2 V 0.1 H 3", 0.2, Side::Outward);
    assert!(matches!(kind, ProfileErrorKind::WallCorner { .. }), "{kind:?} {segment:?}");
}

#[test]
fn crossing_the_axis_and_overlapping_are_told() {
    let (kind, segment) = error("M 0 0 H 1 L 0.1 0.1 V 1 L 1 2", 0.3, Side::Inward);
    assert!(
        matches!(
            kind,
            ProfileErrorKind::WallCrossesAxis { .. } | ProfileErrorKind::WallCorner { .. }
        ),
        "{kind:?} {segment:?}"
    );
    let (kind, segment) = error("M 0.1 0 V 1", 0.3, Side::Inward);
    let ProfileErrorKind::WallCrossesAxis { point } = kind else { panic!("{kind:?}") };
    assert!((point.r + 0.2).abs() < 1e-15 && segment == Some(0));
    // A hairpin, its legs 0.2 apart, with walls of 0.15 towards each other.
    let (kind, _) = error("M 2 0 V 2 A 0.1 0.1 0 0 1 1.8 2 V 0", 0.15, Side::Inward);
    assert!(matches!(kind, ProfileErrorKind::WallFolds { .. }), "{kind:?}");
    let (kind, _) = error("M 2 0 V 2 H 1.8 V 0", 0.15, Side::Inward);
    assert!(!matches!(kind, ProfileErrorKind::WallCrossesAxis { .. }), "{kind:?}");
    let (kind, _) = error("M 1 0 C 3 0 3 1 2 1 C 1 1 1 1.05 3 1.05", 0.1, Side::Centered);
    println!("{kind:?}");
    for t in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let (kind, _) = error("M 1 0 V 1", t, Side::Inward);
        assert!(matches!(kind, ProfileErrorKind::Thickness { .. }));
    }
}

//! Lengths, areas, volumes, centroids, moments and capacities against closed forms, against an
//! independent quadrature and against random points.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use std::f64::consts::PI;

use rondure::measure::{Measure, Solid};
use rondure::profile::{PlaneMap, Profile};

fn profile(path: &str) -> Profile {
    Profile::from_path_data(path).unwrap()
}

fn measure(path: &str) -> Measure {
    profile(path).measure()
}

fn solid(path: &str) -> Solid {
    measure(path).solid.unwrap()
}

#[track_caller]
fn near(value: f64, exact: f64, relative: f64) {
    let error = (value - exact).abs();
    assert!(error <= relative * exact.abs(), "{value} for {exact}: off by {error:e}");
}

const SPHERE: &str = "M 0 -1 A 1 1 0 0 1 0 1";
const CONE: &str = "M 0 0 L 1 0 L 0 2 Z";
const CYLINDER: &str = "M 0 0 L 1 0 L 1 2 L 0 2 Z";
const TORUS: &str = "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z";

/// Path, area, volume, height of the centroid, axial and transverse moment of inertia.
fn closed_forms() -> Vec<(&'static str, [f64; 6])> {
    let root5 = 5.0_f64.sqrt();
    let cylinder = 2.0 * PI;
    vec![
        (SPHERE, [PI, 4.0 * PI, 4.0 / 3.0 * PI, 0.0, 8.0 / 15.0 * PI, 8.0 / 15.0 * PI]),
        // I_xx about the centroid: m (3 r^2 / 20 + 3 h^2 / 80).
        (CONE, {
            let v = 2.0 / 3.0 * PI;
            [3.0 + root5, PI + root5 * PI, v, 0.5, 0.3 * v, v * (0.15 + 0.15)]
        }),
        (CYLINDER, {
            [6.0, 6.0 * PI, cylinder, 1.0, 0.5 * cylinder, cylinder * (0.25 + 4.0 / 12.0)]
        }),
        // R = 2, a = 1: I_zz = m (R^2 + 3/4 a^2), I_xx = m (R^2 / 2 + 5/8 a^2).
        (TORUS, {
            let v = 4.0 * PI * PI;
            [2.0 * PI, 8.0 * PI * PI, v, 0.0, 4.75 * v, 2.625 * v]
        }),
        // z = r^2 up to r = 2: V = pi h^2 / 2, I_zz = pi/6 h^3.
        ("M 0 0 Q 1 0 2 4 L 0 4", {
            let v = 8.0 * PI;
            let arc = 17.0_f64.sqrt() + (4.0 + 17.0_f64.sqrt()).ln() / 4.0;
            let area = PI / 6.0 * (17.0_f64.powf(1.5) - 1.0) + 4.0 * PI;
            let axial = PI / 6.0 * 64.0;
            // pi ∫ z (z - 8/3)^2 dz from 0 to 4 = pi (64 - 1024/9 + 512/9).
            [arc + 2.0, area, v, 8.0 / 3.0, axial, 0.5 * axial + PI * 64.0 / 9.0]
        }),
        // A frustum from r = 2 to 1, 3 high.
        ("M 0 0 L 2 0 L 1 3 L 0 3", {
            let v = 7.0 * PI;
            let slant = 10.0_f64.sqrt();
            let centroid = 3.0 * (4.0 + 4.0 + 3.0) / (4.0 * 7.0);
            let axial = PI / 10.0 * 3.0 * 31.0;
            // pi ∫ (2 - z/3)^2 z^2 dz from 0 to 3 = pi (36 - 27 + 27/5).
            let second = PI * 14.4;
            let across = 0.5 * axial + second - v * centroid * centroid;
            [3.0 + slant, 5.0 * PI + 3.0 * PI * slant, v, centroid, axial, across]
        }),
    ]
}

#[test]
fn closed_forms_come_out_to_1e_14() {
    for (path, [length, area, volume, centroid, axial, transverse]) in closed_forms() {
        let measure = measure(path);
        let solid = measure.solid.unwrap();
        println!("{path}: volume off by {:e}", (solid.volume - volume).abs() / volume);
        near(measure.length, length, 1e-14);
        near(measure.area, area, 1e-14);
        near(solid.volume, volume, 1e-14);
        assert!((solid.centroid_z - centroid).abs() < 1e-14, "{path}: {}", solid.centroid_z);
        near(solid.inertia_axial, axial, 1e-14);
        near(solid.inertia_transverse, transverse, 2e-14);
        assert!((measure.length - length).abs() <= measure.length_error);
        assert!((measure.area - area).abs() <= measure.area_error);
        assert!((solid.volume - volume).abs() <= solid.volume_error);
        assert!((solid.centroid_z - centroid).abs() <= solid.centroid_error);
        assert!((solid.inertia_axial - axial).abs() <= solid.inertia_error);
        assert!((solid.inertia_transverse - transverse).abs() <= solid.inertia_error);
        assert!(solid.volume_error < 1e-12 * volume, "{:e}", solid.volume_error);
    }
}

#[test]
fn ellipsoids_and_elliptic_rings() {
    // Semi-axes 3 and 0.5.
    for (path, [a, c]) in [
        ("M 0 -0.5 A 3 0.5 0 0 1 0 0.5", [3.0, 0.5]),
        ("M 0 -3 A 0.5 3 0 0 1 0 3", [0.5, 3.0]),
        ("M 0 -3 A 3 0.5 90 0 1 0 3", [0.5, 3.0]),
    ] {
        let measure = measure(path);
        let solid = measure.solid.unwrap();
        let v = 4.0 / 3.0 * PI * a * a * c;
        near(solid.volume, v, 1e-14);
        near(solid.inertia_axial, 0.4 * v * a * a, 1e-14);
        near(solid.inertia_transverse, 0.2 * v * (a * a + c * c), 2e-14);
        let area = if a > c {
            let e = (1.0_f64 - c * c / (a * a)).sqrt();
            2.0 * PI * a * a * (1.0 + (1.0 - e * e) / e * e.atanh())
        } else {
            let e = (1.0_f64 - a * a / (c * c)).sqrt();
            2.0 * PI * a * a * (1.0 + c / (a * e) * e.asin())
        };
        near(measure.area, area, 1e-14);
    }
    // Pappus: area of the ellipse times the way of its center.
    let ring = solid("M 5 0 A 1.5 0.25 0 0 1 2 0 A 1.5 0.25 0 0 1 5 0 Z");
    near(ring.volume, PI * 1.5 * 0.25 * 2.0 * PI * 3.5, 1e-14);
    let tilted = PlaneMap::translate(3.5, 0.0)
        .after(&PlaneMap::rotate_degrees(33.0))
        .after(&PlaneMap::translate(-3.5, 0.0));
    let ring = Profile::builder()
        .move_to(5.0, 0.0)
        .arc_to([1.5, 0.25], 0.0, false, true, 2.0, 0.0)
        .arc_to([1.5, 0.25], 0.0, false, true, 5.0, 0.0)
        .close()
        .map(&tilted)
        .build()
        .unwrap();
    near(ring.measure().solid.unwrap().volume, PI * 1.5 * 0.25 * 2.0 * PI * 3.5, 1e-14);
}

#[test]
fn the_direction_of_drawing_does_not_matter() {
    for (path, back) in [
        (SPHERE, "M 0 1 A 1 1 0 0 0 0 -1"),
        (CONE, "M 0 2 L 1 0 L 0 0 Z"),
        (TORUS, "M 3 0 A 1 1 0 0 0 1 0 A 1 1 0 0 0 3 0 Z"),
    ] {
        near(solid(back).volume, solid(path).volume, 1e-15);
        near(measure(back).area, measure(path).area, 1e-15);
    }
}

#[test]
fn hollows_are_subtracted_whichever_way_they_are_drawn() {
    let exact = 4.0 / 3.0 * PI * (8.0 - 1.0);
    for inner in ["M 0 -1 A 1 1 0 0 1 0 1", "M 0 1 A 1 1 0 0 0 0 -1"] {
        let ball = solid(&format!("M 0 -2 A 2 2 0 0 1 0 2 {inner}"));
        near(ball.volume, exact, 1e-14);
    }
    // A ball in the hollow, and a ring beside it all.
    let nested = solid(
        "M 0 -2 A 2 2 0 0 1 0 2 M 0 -1 A 1 1 0 0 1 0 1 M 0 -0.5 A 0.5 0.5 0 0 1 0 0.5 \
         M 4 0 A 1 1 0 0 0 6 0 A 1 1 0 0 0 4 0 Z",
    );
    near(nested.volume, exact + PI / 6.0 + 2.0 * PI * PI * 5.0, 1e-14);
}

#[test]
fn thin_shells_have_the_volume_of_their_walls() {
    for exponent in [3, 10, 20, 40] {
        // A power of two, so that 1 + t is exact.
        let t = 0.5_f64.powi(exponent);
        let (r, z) = (1.0 + t, 2.0);
        // A tube: pi ((1 + t)^2 - 1) 2.
        let tube = solid(&format!("M 1 0 L {r} 0 L {r} {z} L 1 {z} Z"));
        near(tube.volume, PI * t * (2.0 + t) * 2.0, 1e-14);
        assert!(tube.volume_error < tube.volume, "{exponent}: {tube:?}");
        // A hollow ball: 4/3 pi (3 t + 3 t^2 + t^3), with the conditioning of its thickness.
        let ball = solid(&format!("M 0 -{r} A {r} {r} 0 0 1 0 {r} M 0 -1 A 1 1 0 0 1 0 1"));
        let exact = 4.0 / 3.0 * PI * t * (3.0 + t * (3.0 + t));
        assert!((ball.volume - exact).abs() <= ball.volume_error);
        near(ball.volume, exact, 1e-14 + 4e-16 / t);
    }
}

#[test]
fn a_ring_far_from_the_axis_keeps_its_accuracy() {
    // Radii of power of two, so that the coordinates are exact.
    let (far, a) = (65536.0, 0.25);
    let ring =
        solid(&format!("M {0} 0 A {a} {a} 0 0 1 {1} 0 A {a} {a} 0 0 1 {0} 0 Z", far + a, far - a));
    near(ring.volume, 2.0 * PI * PI * far * a * a, 1e-14);
    near(ring.inertia_axial, ring.volume * (far * far + 0.75 * a * a), 1e-14);
}

#[test]
fn places_and_sizes_do_not_matter() {
    let path = include_str!("../../../profiles/goblet.path");
    let here = profile(path).measure();
    let solid = here.solid.unwrap();
    let cavity = here.cavity.unwrap();
    for factor in [1e-60, 1e-6, 0.5, 3.0, 1e6, 1e60] {
        let map = PlaneMap::scale(factor, factor);
        let there = profile(path).mapped(&map).unwrap().measure();
        let other = there.solid.unwrap();
        near(there.length, factor * here.length, 1e-13);
        near(there.area, factor.powi(2) * here.area, 1e-13);
        near(other.volume, factor.powi(3) * solid.volume, 1e-13);
        near(other.centroid_z, factor * solid.centroid_z, 1e-13);
        near(other.inertia_axial, factor.powi(5) * solid.inertia_axial, 1e-13);
        near(there.cavity.unwrap().capacity(), factor.powi(3) * cavity.capacity(), 1e-13);
    }
}

#[test]
fn far_up_the_axis_nothing_is_lost() {
    for up in [0.0, 1024.0, 1_048_576.0, -68_719_476_736.0] {
        let [a, b, c] = [up, up + 1.0, up + 3.0];
        // A cone on a cylinder; every coordinate is exact.
        let solid = solid(&format!("M 0 {a} L 2 {a} L 2 {b} L 0 {c}"));
        let volume = 4.0 * PI + 8.0 / 3.0 * PI;
        near(solid.volume, volume, 1e-14);
        let centroid = (4.0 * PI * 0.5 + 8.0 / 3.0 * PI * 1.5) / volume;
        assert!((solid.centroid_z - up - centroid).abs() <= 1e-15 * up.abs() + 1e-14);
        let across = 4.0 * PI * (1.0 + 1.0 / 12.0 + (0.5 - centroid).powi(2))
            + 8.0 / 3.0 * PI * (0.6 + 0.15 + (1.5 - centroid).powi(2));
        near(solid.inertia_transverse, across, 2e-14);
    }
}

#[test]
fn parts_add_up() {
    // A curved body cut at z = 1, where its profile stands at r = 1.5.
    let whole = solid("M 0 0 L 1 0 Q 1.5 0.3 1.5 1 C 1.5 1.6 0.7 2 0.4 3 L 0 3");
    let below = solid("M 0 0 L 1 0 Q 1.5 0.3 1.5 1 L 0 1");
    let above = solid("M 0 1 L 1.5 1 C 1.5 1.6 0.7 2 0.4 3 L 0 3");
    near(whole.volume, below.volume + above.volume, 1e-14);
    near(whole.inertia_axial, below.inertia_axial + above.inertia_axial, 1e-14);
    let moment = below.volume * below.centroid_z + above.volume * above.centroid_z;
    near(whole.centroid_z, moment / whole.volume, 1e-14);
    let shifted = |part: &Solid| {
        part.inertia_transverse + part.volume * (part.centroid_z - whole.centroid_z).powi(2)
    };
    near(whole.inertia_transverse, shifted(&below) + shifted(&above), 1e-14);
}

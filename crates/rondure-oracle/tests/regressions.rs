//! Rays that an engine once got wrong, each named after its cause.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use rondure::{Profile, Ray, Surface, Vec3};
use rondure_oracle::{Oracle, Tally};

#[track_caller]
fn check(path: &str, ray: Ray) {
    let profile = Profile::from_path_data(path).unwrap();
    let mut tally = Tally::default();
    tally.compare(&Surface::new(&profile), &Oracle::new(&profile), &ray, profile.bounds_solid());
    tally.assert_clean();
    assert_eq!(tally.tangent, 0);
}

/// 1/dz is minus infinity although dz >= 0, and near and far planes change places.
#[test]
fn direction_with_a_negative_zero() {
    let level = Vec3::new(0.125, 0.0, -0.0);
    check("M 1.5 0 L 0 -1", Ray::line(Vec3::new(0.0, 0.25, -0.5), level));
}

/// Halving leaves errors in X of the size of X itself, and made three hits out of one.
#[test]
fn all_but_level_through_the_widest_place() {
    let d = Vec3::new(1.0, 0.0, -1e-17);
    check("M 0 0 C 0.7 0 1 0.5 1 1 C 1 1.6 0.6 2 0 2", Ray::line(Vec3::new(-3.0, 0.1, 1.0), d));
}

/// F is rounding noise beside the corner that the ray passes through: the search for the other root must
/// not settle there.
#[test]
fn root_beside_a_corner_on_the_ray() {
    let origin = Vec3::new(2.4103727820860845, 0.7684288213418137, -1.1917909892602767);
    let direction = Vec3::new(-0.7051863910430423, -0.38421441067090684, 0.5958954946301384);
    check("M 0 0 C 2 1 -0.2 1 1 0 L 1 -1 L 0 -1", Ray::line(origin, direction));
}

/// Where the ray is all but level and grazes, t is neither a quotient by dz nor a root of noise.
#[test]
fn all_but_level_and_grazing() {
    let path = "M 0 -1.4464530577120776 L 1.0000000000000007 0.25 Q 0.5 0.5 0 0.25";
    let ray = Ray::line(
        Vec3::new(1.0, -0.705768414751985, 0.25),
        Vec3::new(0.0, -2.0, -8.881784197001252e-16),
    );
    let profile = Profile::from_path_data(path).unwrap();
    let surface = Surface::new(&profile);
    let mut hits = Vec::new();
    surface.all(&ray, &mut hits);
    assert!(hits.len().is_multiple_of(2));
    for hit in hits {
        // The surface is met within 1e-7 of the closest approach to the axis, or missed.
        assert!((hit.t + 0.3528842).abs() < 1e-6, "{hit:?}");
    }
}

/// Both roots on a needle are nearly one in s, not in t.
#[test]
fn across_a_needle() {
    check("M 0 1 L 1e-8 -1", Ray::line(Vec3::ZERO, Vec3::new(0.0, 0.25, 0.25)));
}

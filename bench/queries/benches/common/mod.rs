//! The shapes and the rays of both benchmarks.

use rondure::{Profile, Ray, Surface, Vec3};

/// The standard shapes, of 4, 12, 32 and 128 segments.
pub(crate) const SHAPES: [(&str, &str); 4] = [
    ("vase", include_str!("../../../../profiles/vase.path")),
    ("goblet", include_str!("../../../../profiles/goblet.path")),
    ("pawn", include_str!("../../../../profiles/pawn.path")),
    ("column", include_str!("../../../../profiles/column.path")),
];

/// The profile of a standard shape.
pub(crate) fn profile(shape: &str) -> Profile {
    let (_, path) = SHAPES.into_iter().find(|(name, _)| *name == shape).expect("a standard shape");
    Profile::from_path_data(path).expect("a good profile")
}

/// Rays of a pinhole camera that sees a standard shape, row by row, about `count` of them.
pub(crate) fn camera_rays(count: u32) -> Vec<Ray> {
    let eye = Vec3::new(1.30, 0.45, 0.95);
    let forward = (Vec3::new(0.0, 0.0, 0.48) - eye).normalized();
    let right = forward.cross(Vec3::Z).normalized();
    let up = right.cross(forward);
    let edge = count.isqrt();
    let half = 23.0_f64.to_radians().tan();
    let at = |i: u32| half * (2.0 * (f64::from(i) + 0.5) / f64::from(edge) - 1.0);
    let ray = |i: u32| Ray::new(eye, forward + right * at(i % edge) - up * at(i / edge));
    (0..edge * edge).map(ray).collect()
}

/// Rays from the sphere round the surface to points in its box.
pub(crate) fn random_rays(surface: &Surface, count: u32) -> Vec<Ray> {
    let mut state = 1_u64;
    let mut number = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut vector = || Vec3::new(number(), number(), number());
    let bounds = surface.bounds();
    let (center, extent) = (bounds.center(), bounds.extent());
    let ray = |_| {
        let origin = center + (vector() - Vec3::splat(0.5)).normalized() * (0.5 * extent.length());
        let v = vector();
        let target = bounds.min + Vec3::new(extent.x * v.x, extent.y * v.y, extent.z * v.z);
        Ray::new(origin, target - origin)
    };
    (0..count).map(ray).collect()
}

//! The rays that the examples shoot.

use rondure::{Bounds, Ray, Vec3};

/// Those of a pinhole in scanline order.
#[allow(dead_code, reason = "not every example looks")]
pub(crate) fn camera_rays() -> Vec<Ray> {
    let (width, height) = (1024, 768);
    let eye = Vec3::new(1.30, 0.45, 0.95);
    let forward = (Vec3::new(0.0, 0.0, 0.48) - eye).normalized();
    let right = forward.cross(Vec3::Z).normalized();
    let up = right.cross(forward);
    let scale = 23.0_f64.to_radians().tan() / (0.5 * f64::from(height));
    let ray = |i: i32| {
        let x = f64::from(i % width) + 0.5 - 0.5 * f64::from(width);
        let y = 0.5 * f64::from(height) - f64::from(i / width) - 0.5;
        Ray::new(eye, forward + right * (x * scale) + up * (y * scale))
    };
    (0..width * height).map(ray).collect()
}

/// From the sphere round a box to a point in the box.
pub(crate) fn random_rays(bounds: &Bounds, count: usize) -> Vec<Ray> {
    let mut state = 1_u64;
    let mut number = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut vector = || Vec3::new(number(), number(), number());
    let (center, extent) = (bounds.center(), bounds.extent());
    let radius = 0.5 * extent.length();
    let ray = |_| {
        let origin = center + (vector() - Vec3::splat(0.5)).normalized() * radius;
        let v = vector();
        let target = bounds.min + Vec3::new(extent.x * v.x, extent.y * v.y, extent.z * v.z);
        Ray::new(origin, target - origin)
    };
    (0..count).map(ray).collect()
}

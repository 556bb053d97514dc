//! The rays that examples and benchmarks shoot, the same at every run.
#![allow(dead_code, reason = "not everybody shoots all of them")]

use rondure::{Bounds, Ray, Vec3};

/// Those of a pinhole camera that sees a standard shape, in scanline order.
pub(crate) fn camera_rays(size: [u32; 2]) -> Vec<Ray> {
    pinhole([Vec3::new(1.30, 0.45, 0.95), Vec3::new(0.0, 0.0, 0.48)], 23.0, size)
}

/// Those of a pinhole at the first point that looks at the second one, in scanline order. From the middle to the upper edge it sees so
/// many degrees.
pub(crate) fn pinhole(
    [eye, target]: [Vec3; 2],
    degrees: f64,
    [width, height]: [u32; 2],
) -> Vec<Ray> {
    let forward = (target - eye).normalized();
    let right = forward.cross(Vec3::Z).normalized();
    let up = right.cross(forward);
    let scale = degrees.to_radians().tan() / (0.5 * f64::from(height));
    let ray = |i: u32| {
        let x = f64::from(i % width) + 0.5 - 0.5 * f64::from(width);
        let y = 0.5 * f64::from(height) - f64::from(i / width) - 0.5;
        Ray::new(eye, forward + right * (x * scale) + up * (y * scale))
    };
    (0..width * height).map(ray).collect()
}

/// From the sphere round a box to a point in the box.
pub(crate) fn random_rays(bounds: &Bounds, count: usize) -> Vec<Ray> {
    let mut random = Random(1);
    let (center, extent) = (bounds.center(), bounds.extent());
    let radius = 0.5 * extent.length();
    let ray = |_| {
        let origin = center + (random.vector() - Vec3::splat(0.5)).normalized() * radius;
        let v = random.vector();
        let target = bounds.min + Vec3::new(extent.x * v.x, extent.y * v.y, extent.z * v.z);
        Ray::new(origin, target - origin)
    };
    (0..count).map(ray).collect()
}

/// Numbers from 0 to 1, the same at every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn number(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}

//! Maps from the unit square to disks, caps and hemispheres, and the frame they stand in.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use rondure::Vec3;

/// A right-handed orthonormal frame round a unit normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    #[inline]
    pub(crate) fn new(normal: Vec3) -> Self {
        let (x, y) = normal.orthonormal_basis();
        Self { x, y, z: normal }
    }

    #[inline]
    pub(crate) fn to_world(self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    #[inline]
    pub(crate) fn to_local(self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

/// A point of the unit disk, areas kept in proportion (Shirley and Chiu 1997, "A Low Distortion Map
/// Between Disk and Square").
#[inline]
pub(crate) fn disk((u, v): (f64, f64)) -> (f64, f64) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    let (radius, angle) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    };
    let (sin, cos) = angle.sin_cos();
    (radius * cos, radius * sin)
}

/// A direction of the upper hemisphere with density cos / pi.
#[inline]
pub(crate) fn cosine_hemisphere(u: (f64, f64)) -> Vec3 {
    let (x, y) = disk(u);
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// A direction of the cap of all directions whose cosine with the z axis is at least
/// 1 - `height`, evenly by solid angle; the cap's solid angle is 2 pi `height`.
///
/// The height and not the cosine, so that a cap as small as a star's loses nothing.
#[inline]
pub(crate) fn cap(u: (f64, f64), height: f64) -> Vec3 {
    let h = u.0 * height;
    let radius = (h * (2.0 - h)).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.1).sin_cos();
    Vec3::new(radius * cos, radius * sin, 1.0 - h)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> impl Iterator<Item = (f64, f64)> {
        let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n * n).map(move |i| (at(i % n), at(i / n)))
    }

    #[test]
    fn disk_keeps_areas() {
        let n = 256;
        let inside = grid(n).map(disk).filter(|(x, y)| x.hypot(*y) < 0.5).count();
        assert!((inside as f64 / f64::from(n * n) - 0.25).abs() < 2e-3);
    }

    #[test]
    fn means_of_directions_are_the_closed_forms() {
        let n = 128;
        let mean = |f: &dyn Fn((f64, f64)) -> Vec3| {
            grid(n).map(f).fold(Vec3::ZERO, |a, b| a + b) / f64::from(n * n)
        };
        let cosine = mean(&cosine_hemisphere);
        assert!((cosine - Vec3::new(0.0, 0.0, 2.0 / 3.0)).max_abs() < 1e-3, "{cosine:?}");
        let half = mean(&|u| cap(u, 0.5));
        assert!((half - Vec3::new(0.0, 0.0, 0.75)).max_abs() < 1e-4, "{half:?}");
    }

    #[test]
    fn frames_are_orthonormal_and_invert() {
        let frame = Frame::new(Vec3::new(-0.6, 0.0, -0.8));
        let v = Vec3::new(0.2, -0.5, 0.7);
        assert!((frame.to_local(frame.to_world(v)) - v).max_abs() < 1e-15);
    }
}

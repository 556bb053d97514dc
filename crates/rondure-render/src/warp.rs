//! Maps from the unit square to disks, caps and hemispheres, and the frame they stand in.

use core::f64::consts::{FRAC_PI_4, TAU};

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

    /// The vector (x, y, 0).
    #[inline]
    pub(crate) fn across(&self, x: f64, y: f64) -> Vec3 {
        self.x * x + self.y * y
    }

    #[inline]
    pub(crate) fn normal(&self) -> Vec3 {
        self.z
    }

    #[inline]
    pub(crate) fn to_local(self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

/// A point of the unit disk, areas kept in proportion (Shirley and Chiu 1997, "A Low Distortion Map
/// Between Disk and Square").
#[inline(always)]
pub(crate) fn disk((u, v): (f64, f64)) -> (f64, f64) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    // Choices between numbers, no branches: half of them would be guessed wrong.
    let steep = a.abs() <= b.abs();
    let (radius, other) = if steep { (b, a) } else { (a, b) };
    let part = if radius == 0.0 { 0.0 } else { other / radius };
    let (sin, cos) = sin_cos_small(FRAC_PI_4 * part);
    let (along, across) = (radius * cos, radius * sin);
    if steep { (across, along) } else { (along, across) }
}

/// Sine and cosine of `u` turns, `u` from 0 to 1.
#[inline(always)]
pub(crate) fn sin_cos_turn(u: f64) -> (f64, f64) {
    let quarters = (4.0 * u + 0.5) as u32;
    let (sin, cos) = sin_cos_small(TAU * (u - 0.25 * f64::from(quarters)));
    // No branches: most of them would be guessed wrong.
    let (s, c) = if quarters & 1 == 1 { (cos, sin) } else { (sin, cos) };
    let signed = |x: f64, bit: u32| f64::from_bits(x.to_bits() ^ u64::from(bit & 2) << 62);
    (signed(s, quarters), signed(c, quarters + 1))
}

/// The coefficients of sin x / x and cos x in x^2, to within 2^-58 between -pi/4 and pi/4 (Sun's fdlibm, `k_sin.c` and `k_cos.c`).
const SINE: [f64; 8] = [
    1.0,
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
    0.0,
];
const COSINE: [f64; 8] = [
    1.0,
    -0.5,
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sine and cosine of an angle between -pi/4 and pi/4, within 3e-16: the functions of the library are called from afar and
/// take longer.
#[inline(always)]
fn sin_cos_small(x: f64) -> (f64, f64) {
    (x * series(&SINE, x * x), series(&COSINE, x * x))
}

/// The even and the odd powers of x^2 side by side.
#[inline(always)]
fn series(c: &[f64; 8], x2: f64) -> f64 {
    let x4 = x2 * x2;
    let even = c[0] + x4 * (c[2] + x4 * (c[4] + x4 * c[6]));
    let odd = c[1] + x4 * (c[3] + x4 * (c[5] + x4 * c[7]));
    even + x2 * odd
}

/// A direction of the upper hemisphere with density cos / pi.
#[inline]
pub(crate) fn cosine_hemisphere(u: (f64, f64)) -> Vec3 {
    above_disk(disk(u))
}

/// The same from a point of the unit disk, which it lies above.
#[inline]
pub(crate) fn above_disk((x, y): (f64, f64)) -> Vec3 {
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
    let (sin, cos) = sin_cos_turn(u.1);
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
    fn sines_are_those_of_the_library() {
        for i in 0..=10_000 {
            let u = f64::from(i) / 10_000.0;
            let (found, expected) = (sin_cos_turn(u), (TAU * u).sin_cos());
            // TAU u is rounded, by up to 4e-16 each.
            let off = (found.0 - expected.0).abs().max((found.1 - expected.1).abs());
            assert!(off < 1.5e-15, "{u} {off}");
            let (found, expected) = (sin_cos_small(0.78 * u), (0.78 * u).sin_cos());
            let off = (found.0 - expected.0).abs().max((found.1 - expected.1).abs());
            assert!(off < 3e-16, "{u} {off}");
        }
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

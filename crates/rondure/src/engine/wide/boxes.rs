//! Sixteen boxes in (z, w) at once, w = rho^2: where a ray enters them, in f32.
//!
//! A box is what lies between two coaxial cylinders and two planes, the paper's cylinder shell. The ray is
//! between the planes and within the outer cylinder on one stretch of tau; as w is convex in tau, that
//! stretch lies within the inner cylinder if both its ends do.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::course::{Course, NEAR};

/// How many boxes belong together.
pub(super) const WIDTH: usize = 16;
/// How many are tested at once.
const HALF: usize = 8;

/// Padding of z, and of w: neither origins nor boxes are farther away than NEAR, and the roundings of the
/// tests below are fewer than 16, of numbers no larger than that, or than its square.
pub(super) const PADDING: [f64; 2] = {
    let roundoff = 0.5 * f32::EPSILON as f64;
    [16.0 * roundoff * NEAR, 16.0 * roundoff * NEAR * NEAR * 2.0]
};

/// A direction's part along the axis, and the square of that across it, in units of its length, below
/// which they are raised to it: that moves the ray by less than the padding.
const LEAST: f32 = 1.0 / (1_u32 << 24) as f32;

/// Sixteen boxes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Boxes {
    halves: [Half; 2],
    /// How many of them there are.
    len: usize,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Half {
    z: [[f32; HALF]; 2],
    w: [[f32; HALF]; 2],
}

/// Ranges of z and w.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) z: [f64; 2],
    pub(super) w: [f64; 2],
}

impl Extent {
    pub(super) const NONE: Self =
        Self { z: [f64::INFINITY, f64::NEG_INFINITY], w: [f64::INFINITY, f64::NEG_INFINITY] };

    /// The box round two.
    pub(super) fn union(&self, other: &Self) -> Self {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { z: both(self.z, other.z), w: both(self.w, other.w) }
    }
}

/// A ray for these tests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    a: f32,
    b: f32,
    c: f32,
    oz: f32,
    per_a: f32,
    per_dz: f32,
    start: f32,
}

impl Slabs {
    pub(super) const NONE: Self =
        Self { a: 1.0, b: 0.0, c: 0.0, oz: 0.0, per_a: 1.0, per_dz: 1.0, start: 0.0 };

    #[inline(always)]
    pub(super) fn new(ray: &Course) -> Self {
        let (own_a, own_dz) = (ray.a as f32, ray.direction.z as f32);
        let length2 = ray.length2 as f32;
        let least_a = LEAST * LEAST * length2;
        let a = if own_a < least_a { least_a } else { own_a };
        // No more than the length, for a length no less than 2^-20.
        let least_dz = if length2 < 1.0 { LEAST * length2 } else { LEAST };
        let dz = if own_dz.abs() < least_dz { least_dz.copysign(own_dz) } else { own_dz };
        Self {
            a,
            b: ray.b as f32,
            c: ray.c as f32,
            oz: ray.origin.z as f32,
            per_a: 1.0 / a,
            per_dz: 1.0 / dz,
            start: ray.range[0] as f32,
        }
    }
}

impl Boxes {
    /// Boxes round these.
    pub(super) fn new(extents: &[Extent]) -> Self {
        let mut boxes = Self { halves: [Half::EMPTY; 2], len: extents.len().min(WIDTH) };
        for (i, extent) in extents.iter().enumerate().take(WIDTH) {
            boxes.halves[i / HALF].set(i % HALF, extent);
        }
        boxes
    }

    /// Which boxes the ray meets before `end`, as a set of bits; where it enters each goes to `enter`.
    #[inline(always)]
    pub(super) fn test<S: Simd>(
        &self,
        simd: S,
        ray: &Slabs,
        end: f32,
        enter: &mut [f32; WIDTH],
    ) -> u32 {
        let (first, second) = enter.split_at_mut(HALF);
        let mut mask = self.halves[0].test(simd, ray, end, first);
        if self.len > HALF {
            mask |= self.halves[1].test(simd, ray, end, second) << HALF;
        }
        mask
    }
}

impl Half {
    const EMPTY: Self = Self {
        // Nowhere.
        z: [[f32::INFINITY; HALF], [f32::NEG_INFINITY; HALF]],
        w: [[f32::INFINITY; HALF], [-1.0; HALF]],
    };

    fn set(&mut self, lane: usize, extent: &Extent) {
        for i in 0..2 {
            let out = if i == 0 { -1.0 } else { 1.0 };
            self.z[i][lane] = (extent.z[i] + out * PADDING[0]) as f32;
            self.w[i][lane] = (extent.w[i] + out * PADDING[1]) as f32;
        }
    }

    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, ray: &Slabs, end: f32, enters: &mut [f32]) -> u32 {
        let (oz, per_dz) = (splat(simd, ray.oz), splat(simd, ray.per_dz));
        let t0 = (load(simd, &self.z[0]) - oz) * per_dz;
        let t1 = (load(simd, &self.z[1]) - oz) * per_dz;
        let (a, b, c) = (splat(simd, ray.a), splat(simd, ray.b), splat(simd, ray.c));
        let outer = load(simd, &self.w[1]);
        let discriminant = b.mul_add(b, a * (outer - c));
        let root = discriminant.max(splat(simd, 0.0)).sqrt();
        let per_a = splat(simd, ray.per_a);
        let (into, out) = ((-b - root) * per_a, (root - b) * per_a);
        let enter = t0.min(t1).max(into).max(splat(simd, ray.start));
        let leave = t0.max(t1).min(out).min(splat(simd, end));
        let slope = b + b;
        let w_enter = a.mul_add(enter, slope).mul_add(enter, c);
        let w_leave = a.mul_add(leave, slope).mul_add(leave, c);
        let mask = enter.simd_le(leave)
            & discriminant.simd_ge(splat(simd, 0.0))
            & w_enter.max(w_leave).simd_ge(load(simd, &self.w[0]));
        enter.store_slice(enters);
        mask.to_bitmask() as u32
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[f32; HALF]) -> f32x8<S> {
    f32x8::from_slice(simd, lanes)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::Vec3;

    #[test]
    fn points_of_rays_lie_in_boxes_that_they_enter_before() {
        let mut state = 7_u64;
        let mut number = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for i in 0..20_000 {
            let point = Vec3::new(number() - 0.5, number() - 0.5, 2.0 * number() - 1.0);
            // Some along the axis, some across it, or nearly so.
            let tiny = if i % 3 == 0 { 1e-9 } else { 1.0 };
            let (across, up) = if i % 2 == 0 { (tiny, 1.0) } else { (1.0, tiny) };
            let direction = Vec3::new(
                across * (number() - 0.5),
                across * (number() - 0.5),
                up * (number() - 0.5),
            );
            let tau = 3.0 * number() / direction.length();
            let origin = point - direction * tau;
            let w = point.x * point.x + point.y * point.y;
            let extents: Vec<_> = (0..16)
                .map(|k| Extent {
                    z: [point.z - number() * f64::from(k), point.z + number() * f64::from(k % 4)],
                    w: [(w - number() * f64::from(k % 4)).max(0.0), w + number() * f64::from(k)],
                })
                .collect();
            let a = direction.x * direction.x + direction.y * direction.y;
            let course = Course {
                origin,
                direction,
                a,
                b: origin.x * direction.x + origin.y * direction.y,
                c: origin.x * origin.x + origin.y * origin.y,
                length2: direction.length_squared(),
                far: origin.max_abs(),
                turn: 0.0,
                range: [0.0, f64::INFINITY],
                shift: 0.0,
            };
            let mut enter = [0.0; WIDTH];
            let boxes = Boxes::new(&extents);
            let slabs = Slabs::new(&course);
            let mask = dispatch!(Level::new(), simd => {
                boxes.test(simd, &slabs, f32::INFINITY, &mut enter)
            });
            assert_eq!(mask, 0xffff, "{course:?} {extents:?}");
            assert!(
                enter.iter().all(|&e| f64::from(e) <= tau * (1.0 + 1e-6) + 1e-6),
                "{enter:?} {tau}"
            );
        }
    }
}

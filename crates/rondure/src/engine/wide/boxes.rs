//! Sixteen boxes in (z, w) at once, w = rho^2: where a ray enters them, in f32.
//!
//! A box is what lies between two coaxial cylinders and two planes, the paper's cylinder shell. The ray is
//! between the planes and within the outer cylinder on one stretch of tau; as w is convex in tau, that
//! stretch lies within the inner cylinder if both its ends do.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::block::{LANES, Probe};

/// Padding of z and of w: the radius is at most 2, so z and sqrt(w) are, and the roundings of the tests below
/// are fewer than 32.
const PADDING: f64 = 2.0 * 32.0 * (0.5 * f32::EPSILON as f64);

/// A direction's part along the axis, and the square of that across it, below which they are raised
/// to it: that moves the ray by less than the padding.
const LEAST: f32 = 1.0 / (1_u32 << 24) as f32;

/// Sixteen boxes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Boxes {
    z: [[f32; LANES]; 2],
    w: [[f32; LANES]; 2],
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
    #[inline(always)]
    pub(super) fn new(ray: &Probe) -> Self {
        let a = if ray.a < LEAST * LEAST { LEAST * LEAST } else { ray.a };
        let dz = if ray.dz.abs() < LEAST { LEAST.copysign(ray.dz) } else { ray.dz };
        let (b, c, oz, start) = (ray.b, ray.c, ray.oz, ray.start);
        Self { a, b, c, oz, per_a: 1.0 / a, per_dz: 1.0 / dz, start }
    }
}

impl Boxes {
    pub(super) const EMPTY: Self = Self {
        // Nowhere.
        z: [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]],
        w: [[f32::INFINITY; LANES], [-1.0; LANES]],
    };

    pub(super) fn set(&mut self, lane: usize, extent: &Extent) {
        for i in 0..2 {
            let out = if i == 0 { -PADDING } else { PADDING };
            self.z[i][lane] = (extent.z[i] + out) as f32;
            self.w[i][lane] = (extent.w[i] + 2.0 * out) as f32;
        }
    }

    /// Which boxes the ray meets before `end`, as a set of bits, and where it enters each.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, ray: &Slabs, end: f32) -> (u32, f32x16<S>) {
        let load = |lanes: &[f32; LANES]| f32x16::from_slice(simd, lanes);
        let splat = |value: f32| f32x16::splat(simd, value);
        let (oz, per_dz) = (splat(ray.oz), splat(ray.per_dz));
        let (t0, t1) = ((load(&self.z[0]) - oz) * per_dz, (load(&self.z[1]) - oz) * per_dz);
        let (a, b, c) = (splat(ray.a), splat(ray.b), splat(ray.c));
        let outer = load(&self.w[1]);
        let discriminant = b.mul_add(b, a * (outer - c));
        let root = discriminant.max(splat(0.0)).sqrt();
        let per_a = splat(ray.per_a);
        let (into, out) = ((-b - root) * per_a, (root - b) * per_a);
        let enter = t0.min(t1).max(into).max(splat(ray.start));
        let leave = t0.max(t1).min(out).min(splat(end));
        let w = |tau: f32x16<S>| a.mul_add(tau, b + b).mul_add(tau, c);
        let mask = enter.simd_le(leave)
            & discriminant.simd_ge(splat(0.0))
            & w(enter).max(w(leave)).simd_ge(load(&self.w[0]));
        (mask.to_bitmask() as u32, enter)
    }
}

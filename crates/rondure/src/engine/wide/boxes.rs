//! Boxes in (z, w), w = rho^2, eight at once: where a ray enters them, in f32.
//!
//! A box is what lies between two coaxial cylinders and two planes, the paper's cylinder shell. The ray is
//! between the planes and within the outer cylinder on one stretch of tau; as w is convex in tau, that
//! stretch lies within the inner cylinder if both its ends do.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, SimdFloat, f32x8};

use super::block::Block;
use super::course::{Course, NEAR};
use super::order;

/// As many boxes are on the last level at the most. All of them are tested before one is chosen, which takes less time than to
/// choose twice.
pub(super) const WIDTH: usize = 32;
/// As many belong together on the levels below.
pub(super) const BELOW: usize = 16;
/// How many are tested at once.
pub(super) const EIGHT: usize = 8;

/// Padding of z, and of w: neither origins nor boxes are farther away than NEAR, and the roundings of the
/// tests below are fewer than 16, of numbers no larger than that, or than its square.
pub(super) const PADDING: [f64; 2] = {
    let roundoff = 0.5 * f32::EPSILON as f64;
    [16.0 * roundoff * NEAR, 16.0 * roundoff * NEAR * NEAR * 2.0]
};

/// A direction's part along the axis, and the square of that across it, in units of its length, below
/// which they are raised to it: that moves the ray by less than the padding.
const LEAST: f32 = 1.0 / (1_u32 << 24) as f32;

/// The boxes of a level. On the last one all belong together, on those below [`BELOW`] after [`BELOW`].
#[derive(Clone, Debug)]
pub(super) struct Boxes {
    eights: Vec<Eight>,
    /// As many eights belong together.
    together: usize,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Eight {
    z: [[f32; EIGHT]; 2],
    w: [[f32; EIGHT]; 2],
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

/// A ray for these tests, or one in each lane of a vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs<T = f32> {
    a: T,
    b: T,
    c: T,
    oz: T,
    per_a: T,
    per_dz: T,
    start: T,
}

impl Slabs {
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

    /// The same from another parameter on.
    #[inline(always)]
    pub(super) fn starting(self, start: f32) -> Self {
        Self { start, ..self }
    }

    /// The same in all lanes.
    #[inline(always)]
    fn splat<S: Simd, V: SimdFloat<S, Element = f32>>(&self, simd: S) -> Slabs<V> {
        Slabs {
            a: V::splat(simd, self.a),
            b: V::splat(simd, self.b),
            c: V::splat(simd, self.c),
            oz: V::splat(simd, self.oz),
            per_a: V::splat(simd, self.per_a),
            per_dz: V::splat(simd, self.per_dz),
            start: V::splat(simd, self.start),
        }
    }
}

/// What [`Slabs`] are made of, for many rays.
pub(super) struct Rods<V> {
    pub(super) a: V,
    pub(super) b: V,
    pub(super) c: V,
    pub(super) oz: V,
    pub(super) dz: V,
    pub(super) length2: V,
    pub(super) start: V,
}

impl<V> Slabs<V> {
    /// As [`new`](Slabs::new), lane by lane.
    #[inline(always)]
    pub(super) fn of_many<S: Simd>(simd: S, rays: &Rods<V>) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let &Rods { a, b, c, oz, dz, length2, start } = rays;
        let (one, least) = (V::splat(simd, 1.0), V::splat(simd, LEAST));
        let a = a.max(least * least * length2);
        let least_dz = least * length2.min(one);
        let dz = dz.abs().simd_lt(least_dz).select(least_dz.copysign(dz), dz);
        Self { a, b, c, oz, per_a: one / a, per_dz: one / dz, start }
    }
}

/// Boxes, one in each lane or the same in all.
pub(super) struct Walls<V> {
    z: [V; 2],
    w: [V; 2],
}

/// Where a ray enters boxes, and in which lanes it meets one before `end`.
#[inline(always)]
pub(super) fn enter<S: Simd, V: SimdFloat<S, Element = f32>>(
    simd: S,
    walls: &Walls<V>,
    ray: &Slabs<V>,
    end: V,
) -> (V, V::Mask) {
    let &Slabs { a, b, c, oz, per_a, per_dz, start } = ray;
    let t0 = (walls.z[0] - oz) * per_dz;
    let t1 = (walls.z[1] - oz) * per_dz;
    let zero = V::splat(simd, 0.0);
    let discriminant = b.mul_add(b, a * (walls.w[1] - c));
    let root = discriminant.max(zero).sqrt();
    let (into, out) = ((-b - root) * per_a, (root - b) * per_a);
    let enter = t0.min(t1).max(into).max(start);
    let leave = t0.max(t1).min(out).min(end);
    let slope = b + b;
    let w_enter = a.mul_add(enter, slope).mul_add(enter, c);
    let w_leave = a.mul_add(leave, slope).mul_add(leave, c);
    let mask = enter.simd_le(leave)
        & discriminant.simd_ge(zero)
        & w_enter.max(w_leave).simd_ge(walls.w[0]);
    (enter, mask)
}

/// As [`Boxes::test_unordered`].
#[inline(always)]
fn test_each<S: Simd, const N: usize>(
    simd: S,
    eights: [&Eight; N],
    ray: &Slabs<f32x8<S>>,
    end: f32x8<S>,
    enters: &mut [f32; WIDTH],
) -> u32 {
    let mut set = 0;
    for i in 0..N {
        let (near, mask) = enter(simd, &eights[i].walls(simd), ray, end);
        near.store_slice(&mut enters[i * EIGHT..][..EIGHT]);
        set |= (mask.to_bitmask() as u32) << (i * EIGHT);
    }
    set
}

/// A bundle of rays: the points of each are no farther than `across`, seen along the axis, and `along` it from the point
/// of one of them, `ray`, at the same parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundle {
    pub(super) ray: Slabs,
    pub(super) across: f32,
    pub(super) along: f32,
    pub(super) end: f32,
}

impl Boxes {
    /// Boxes round these; more than [`WIDTH`] are not the last level.
    pub(super) fn new(extents: &[Extent]) -> Self {
        let eights = extents.chunks(EIGHT).map(|own| Eight::new(own.iter())).collect();
        let together = if extents.len() <= WIDTH { WIDTH } else { BELOW };
        Self { eights, together: together / EIGHT }
    }

    /// How many eights there are.
    pub(super) fn eights(&self) -> usize {
        self.eights.len()
    }

    /// Those that belong together.
    #[inline(always)]
    fn together(&self, index: usize) -> &[Eight] {
        let rest = &self.eights[index * self.together..];
        &rest[..rest.len().min(self.together)]
    }

    /// Which of the `index`-th boxes that belong together the ray meets before `end`, as a set of bits; where it enters each goes to `enter`. The
    /// number of one that it enters first, or nearly so, comes with it, if there is any.
    #[inline(always)]
    pub(super) fn test<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &Slabs,
        end: f32,
        enter: &mut [f32; WIDTH],
    ) -> (u32, usize) {
        let (ray, end) = (ray.splat::<S, f32x8<S>>(simd), f32x8::splat(simd, end));
        let (mut set, mut keys) = (0, order::none(simd));
        for (i, eight) in self.together(index).iter().enumerate() {
            let (near, mask) = self::enter(simd, &eight.walls(simd), &ray, end);
            near.store_slice(&mut enter[i * EIGHT..][..EIGHT]);
            set |= (mask.to_bitmask() as u32) << (i * EIGHT);
            keys = keys.min(order::keys(simd, near, mask, i));
        }
        (set, order::number(keys))
    }

    /// The same without the number of the first one, which takes no loop then where there are few.
    #[inline(always)]
    pub(super) fn test_unordered<S: Simd>(
        &self,
        simd: S,
        index: usize,
        ray: &Slabs,
        end: f32,
        enter: &mut [f32; WIDTH],
    ) -> u32 {
        let (ray, end) = (ray.splat(simd), f32x8::splat(simd, end));
        match self.together(index) {
            [] => 0,
            [a] => test_each(simd, [a], &ray, end, enter),
            [a, b] => test_each(simd, [a, b], &ray, end, enter),
            [a, b, c] => test_each(simd, [a, b, c], &ray, end, enter),
            [a, b, c, d, ..] => test_each(simd, [a, b, c, d], &ray, end, enter),
        }
    }

    /// The same for a bundle of rays: where the ray in its middle would enter the boxes as they grow by its width.
    #[inline(always)]
    pub(super) fn test_bundle<S: Simd>(
        &self,
        simd: S,
        index: usize,
        bundle: &Bundle,
        enter: &mut [f32; WIDTH],
    ) -> u32 {
        let mut set = 0;
        for (i, eight) in self.together(index).iter().enumerate() {
            let enters = &mut enter[i * EIGHT..][..EIGHT];
            set |= eight.walls(simd).test_bundle(simd, bundle, enters) << (i * EIGHT);
        }
        set
    }

    /// One of the boxes, for many rays.
    #[inline(always)]
    pub(super) fn walls<S: Simd, V: SimdFloat<S, Element = f32>>(
        &self,
        simd: S,
        number: usize,
    ) -> Walls<V> {
        let eight = &self.eights[number / EIGHT];
        let lane = number % EIGHT;
        Walls {
            z: [V::splat(simd, eight.z[0][lane]), V::splat(simd, eight.z[1][lane])],
            w: [V::splat(simd, eight.w[0][lane]), V::splat(simd, eight.w[1][lane])],
        }
    }
}

impl Eight {
    const EMPTY: Self = Self {
        // Nowhere.
        z: [[f32::INFINITY; EIGHT], [f32::NEG_INFINITY; EIGHT]],
        w: [[f32::INFINITY; EIGHT], [-1.0; EIGHT]],
    };

    /// No more than eight.
    fn new<'a>(extents: impl Iterator<Item = &'a Extent>) -> Self {
        let mut eight = Self::EMPTY;
        for (lane, extent) in extents.enumerate().take(EIGHT) {
            for i in 0..2 {
                let out = if i == 0 { -1.0 } else { 1.0 };
                eight.z[i][lane] = (extent.z[i] + out * PADDING[0]) as f32;
                eight.w[i][lane] = (extent.w[i] + out * PADDING[1]) as f32;
            }
        }
        eight
    }

    #[inline(always)]
    fn walls<S: Simd>(&self, simd: S) -> Walls<f32x8<S>> {
        let ([z0, z1], [w0, w1]) = (&self.z, &self.w);
        Walls { z: [load(simd, z0), load(simd, z1)], w: [load(simd, w0), load(simd, w1)] }
    }
}

impl<S: Simd> Walls<f32x8<S>> {
    /// Which boxes some ray of a bundle may meet, and where `ray` would enter what they grow to.
    #[inline(always)]
    fn test_bundle(&self, simd: S, bundle: &Bundle, enters: &mut [f32]) -> u32 {
        let Walls { z, w } = self;
        let (along, across) = (f32x8::splat(simd, bundle.along), f32x8::splat(simd, bundle.across));
        // (rho + across)^2 - rho^2
        let root = w[1].sqrt();
        let more = across * (root + root + across);
        let walls = Walls { z: [z[0] - along, z[1] + along], w: [w[0] - more, w[1] + more] };
        let end = f32x8::splat(simd, bundle.end);
        let (enter, mask) = enter::<S, f32x8<S>>(simd, &walls, &bundle.ray.splat(simd), end);
        enter.store_slice(enters);
        mask.to_bitmask() as u32
    }
}

/// The squared radii of the boxes round the leaves of a block, which has their heights.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBoxes([[f32; EIGHT]; 2]);

impl LeafBoxes {
    /// Boxes round no more than eight leaves.
    pub(super) fn new<'a>(extents: impl Iterator<Item = &'a Extent>) -> Self {
        Self(Eight::new(extents).w)
    }

    /// Which leaves of the block some ray of a bundle may meet; no ray enters the box round one before `enters`.
    #[inline(always)]
    pub(super) fn test<S: Simd>(
        &self,
        simd: S,
        block: &Block,
        bundle: &Bundle,
        enters: &mut [f32; EIGHT],
    ) -> u32 {
        let [w0, w1] = &self.0;
        let [z, height] = block.heights(simd);
        let height = height + f32x8::splat(simd, PADDING[0] as f32);
        let z = [z - height, z + height];
        let walls = Walls { z, w: [load(simd, w0), load(simd, w1)] };
        walls.test_bundle(simd, bundle, enters)
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[f32; EIGHT]) -> f32x8<S> {
    f32x8::from_slice(simd, lanes)
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
            let extents: Vec<_> = (0..WIDTH)
                .map(|k| Extent {
                    z: [
                        point.z - number() * f64::from(k as u32),
                        point.z + number() * f64::from(k as u32 % 4),
                    ],
                    w: [
                        (w - number() * f64::from(k as u32 % 4)).max(0.0),
                        w + number() * f64::from(k as u32),
                    ],
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
            let (mask, first) = dispatch!(Level::new(), simd => {
                boxes.test(simd, 0, &slabs, f32::INFINITY, &mut enter)
            });
            assert_eq!(mask, u32::MAX, "{course:?} {extents:?}");
            let least = enter.iter().fold(f32::INFINITY, |least, &e| least.min(e)).max(0.0);
            assert!(enter[first] <= least * (1.0 + 1e-5), "{enter:?} {first}");
            assert!(
                enter.iter().all(|&e| f64::from(e) <= tau * (1.0 + 1e-6) + 1e-6),
                "{enter:?} {tau}"
            );
        }
    }
}

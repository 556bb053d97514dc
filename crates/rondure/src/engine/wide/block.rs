//! Eight leaves, with what one needs to know of them to say where a ray may hit them ([`meet`](super::meet)), in
//! f32.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, SimdFloat, f32x8, f64x8, mask32x8, u8x32};

use super::arithmetic::{Best, Fused, greater};
use super::boxes::{Extent, PADDING};
use super::course::Course;
use super::meet::{Beam, Meeting, Shells, meet};
use super::quadric::Quadric;
use crate::numeric::UNIT_ROUNDOFF;

/// How many leaves are tested at once.
pub(super) const LANES: usize = 8;

/// The unit roundoff of f32.
const ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;

/// What f32 holds the products of.
const LARGEST: f64 = 1e12;
/// Bounds are raised by this: more than their own roundings, and than the error of an approximate reciprocal,
/// which is good to 2^-11 at least.
const SLACK: f64 = 1.01;
/// The same of bounds that are multiplied by no reciprocal.
const ROUNDED: f64 = 1.0 + 1.0 / 65_536.0;
/// More than any discriminant, and than any error that matters.
const UNKNOWN: f32 = 1e30;

/// How far off rounding may put a hit of the exact engine, of a radius of at most 2.
const EXACT: f64 = 128.0 * UNIT_ROUNDOFF;

type Lanes = [f32; LANES];

/// What [`meet`] finds of one ray and eight leaves.
pub(super) type Met<S> = Meeting<f32x8<S>, mask32x8<S>>;

/// Eight leaves.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    z: Lanes,
    alpha: Lanes,
    half_beta: Lanes,
    gamma: Lanes,
    p: Lanes,
    lambda: [Lanes; 3],
    /// The largest |zeta|.
    height: Lanes,
    /// The tangency for a direction of length 1, which grows with the square of the length; and the
    /// bend, by which it grows with |U|, too.
    tangency_bend: Pairs,
    /// By how much lambda may be off, times sqrt(V^2 - U W), for a direction of length 1; and the same for tau, for any length.
    room_blur: Pairs,
    /// The parameter on the piece by powers of lambda; see [`Guess`](super::quadric::Guess).
    guess: [Lanes; 4],
    /// From where z and w count.
    corner: [f64; 2],
    /// In which lanes that is the square of the distance from an end on the axis: the start, or the end.
    poles: [u32; 2],
}

impl Block {
    pub(super) const EMPTY: Self = Self {
        z: [0.0; LANES],
        alpha: [0.0; LANES],
        half_beta: [0.0; LANES],
        gamma: [0.0; LANES],
        p: [0.0; LANES],
        lambda: [[0.0; LANES]; 3],
        height: [0.0; LANES],
        // Q vanishes everywhere: the discriminant is never more, nor less, than nothing.
        tangency_bend: Pairs::filled(-1.0, 1.0),
        room_blur: Pairs::filled(1.0, 1.0),
        guess: [[0.0; LANES]; 4],
        corner: [0.0; 2],
        poles: [0; 2],
    };

    /// A block of leaves within `extent`.
    pub(super) fn new<'a>(fits: impl Iterator<Item = &'a Quadric>, extent: &Extent) -> Self {
        let mut block = Self { corner: [extent.z[0], extent.w[0]], ..Self::EMPTY };
        for (lane, fit) in fits.enumerate().take(LANES) {
            block.set(lane, fit, extent);
        }
        block
    }

    fn set(&mut self, lane: usize, q: &Quadric, extent: &Extent) {
        let [z, w] = self.corner;
        let gamma = q.gamma + q.alpha * w;
        let (a, b, c, p) = (q.alpha.abs(), q.beta.abs(), gamma.abs(), q.p.abs());
        // The ray's origin and all hits lie in the box, which is padded.
        let height = (extent.z[1] - extent.z[0]) + 2.0 * PADDING[0];
        let depth = (extent.w[1] - extent.w[0]) + 2.0 * PADDING[1];
        let width = extent.w[1] + PADDING[1];
        let diameter = (4.0 * width + height * height).sqrt();
        // No terms of U tau^2 + 2 V tau + W are larger than these, with |zeta| <= height and
        // |b tau| <= 2 width, and fewer than 12 roundings go into each, those of the ray among them.
        let largest =
            a * (8.0 * width + depth) + 3.0 * (b * height) + 6.0 * (p * height * height) + c;
        // The exact engine may find hits that lie by its own roundings beside the ray.
        let error = ROUNDED * q.error + 12.0 * ROUNDOFF * largest + EXACT;
        let growth = q.growth();
        let all = [a, b, c, p, growth, q.lambda[0], q.lambda[1], q.lambda[2], q.slope, q.error];
        if !all.iter().all(|v| v.abs() < LARGEST) {
            // So short, or so curved, that f32 says nothing of it: it may always be hit.
            self.tangency_bend.set(lane, UNKNOWN, 1.0);
            self.height[lane] = UNKNOWN;
            return;
        }
        let steepest = 0.5 * q.slope * growth;
        let v_most = a * width.sqrt() + b + 2.0 * (p * height);
        let w_most = a * depth + 2.0 * (b * height) + p * height * height + c;
        // The roundings of the discriminant, which may be larger than it.
        let tangency =
            SLACK * steepest * steepest + 16.0 * ROUNDOFF * (v_most * v_most + (a + p) * w_most);
        // No root of the discriminant is larger, and tau is off by its roundings, too.
        let most = v_most + ((a + p) * w_most).sqrt();
        let blur = error + 8.0 * ROUNDOFF * (diameter * most);
        let [lz, lw, l0] = q.lambda;
        let l0 = l0 + lw * w;
        let lambda_size = (lz * height).abs() + 8.0 * (lw * width).abs() + l0.abs();
        let room = blur * growth + 12.0 * ROUNDOFF * (lambda_size * most);
        let finite = |v: f64| if v < f64::from(UNKNOWN) { v as f32 } else { UNKNOWN };
        self.z[lane] = (q.z - z) as f32;
        self.alpha[lane] = q.alpha as f32;
        self.half_beta[lane] = (0.5 * q.beta) as f32;
        self.gamma[lane] = gamma as f32;
        self.p[lane] = q.p as f32;
        for (lanes, own) in self.lambda.iter_mut().zip([lz, lw, l0]) {
            lanes[lane] = own as f32;
        }
        for (lanes, own) in self.guess.iter_mut().zip(q.guess.by_powers) {
            lanes[lane] = own as f32;
        }
        if let Some(pole) = q.guess.pole {
            self.poles[usize::from(pole != 0)] |= 1 << lane;
        }
        self.height[lane] = (q.height + 8.0 * ROUNDOFF * height + EXACT) as f32;
        let [tangency, bend] = [tangency, 2.0 * error].map(|bound| finite(ROUNDED * bound));
        let [room, blur] = [room, blur].map(|bound| finite(SLACK * bound));
        self.tangency_bend.set(lane, tangency, bend);
        self.room_blur.set(lane, room, blur);
    }

    /// Which of the leaves the ray may hit before `end`, and about where, if it enters the block's box at
    /// `origin`.
    #[inline(always)]
    pub(super) fn test<S: Simd, const SURE: bool>(
        &self,
        simd: S,
        ray: &Course,
        origin: f32,
        end: f64,
    ) -> Met<S> {
        let (origin, fma) = (f64::from(origin), Best(simd));
        let own_b = fma.fused(ray.a, origin, ray.b);
        let slope = fma.fused(ray.a, origin, ray.b + ray.b);
        let own_c = fma.fused(slope, origin, ray.c - self.corner[1]);
        let own_z = fma.fused(ray.direction.z, origin, ray.origin.z - self.corner[0]);
        let (dz, length2) = (ray.direction.z as f32, ray.length2 as f32);
        let beam = Beam {
            a: splat(simd, ray.a as f32),
            b: splat(simd, own_b as f32),
            c: splat(simd, own_c as f32),
            z: splat(simd, own_z as f32),
            dz: splat(simd, dz),
            dz2: splat(simd, dz * dz),
            length: splat(simd, length2.sqrt()),
            length2: splat(simd, length2),
            range: [
                splat(simd, (ray.range[0] - origin) as f32),
                splat(simd, (end - origin) as f32),
            ],
        };
        let [l0, l1, l2] = &self.lambda;
        let ([tangency, bend], [room, blur]) =
            (self.tangency_bend.load(simd), self.room_blur.load(simd));
        let shells = Shells {
            z: load(simd, &self.z),
            alpha: load(simd, &self.alpha),
            half_beta: load(simd, &self.half_beta),
            gamma: load(simd, &self.gamma),
            p: load(simd, &self.p),
            lambda: [load(simd, l0), load(simd, l1), load(simd, l2)],
            height: load(simd, &self.height),
            tangency,
            bend,
            room,
            blur,
        };
        meet::<S, _, SURE>(simd, &shells, &beam)
    }

    /// One of the leaves, for many rays.
    #[inline(always)]
    pub(super) fn shell<S: Simd, V: SimdFloat<S, Element = f32>>(
        &self,
        simd: S,
        lane: usize,
    ) -> Shells<V> {
        let lane = lane % LANES;
        let [l0, l1, l2] = &self.lambda;
        let ([tangency, bend], [room, blur]) =
            (self.tangency_bend.of(lane), self.room_blur.of(lane));
        Shells {
            z: V::splat(simd, self.z[lane]),
            alpha: V::splat(simd, self.alpha[lane]),
            half_beta: V::splat(simd, self.half_beta[lane]),
            gamma: V::splat(simd, self.gamma[lane]),
            p: V::splat(simd, self.p[lane]),
            lambda: [V::splat(simd, l0[lane]), V::splat(simd, l1[lane]), V::splat(simd, l2[lane])],
            height: V::splat(simd, self.height[lane]),
            tangency: V::splat(simd, tangency),
            bend: V::splat(simd, bend),
            room: V::splat(simd, room),
            blur: V::splat(simd, blur),
        }
    }

    /// The parameters on the pieces about where lambda is this in each lane.
    #[inline(always)]
    pub(super) fn guess<S: Simd>(&self, simd: S, lambda: f32x8<S>) -> f32x8<S> {
        let [g0, g1, g2, g3] = &self.guess;
        let value = load(simd, g3).mul_add(lambda, load(simd, g2));
        let value = value.mul_add(lambda, load(simd, g1)).mul_add(lambda, load(simd, g0));
        let [start, end] = self.poles;
        if start | end == 0 {
            return value;
        }
        let distance = value.max(splat(simd, 0.0)).sqrt();
        let start = mask32x8::from_bitmask(simd, u64::from(start));
        let end = mask32x8::from_bitmask(simd, u64::from(end));
        let value = start.select(distance, value);
        end.select(splat(simd, 1.0) - distance, value)
    }

    /// The same in one of the lanes.
    #[inline(always)]
    pub(super) fn guess_in(&self, fma: impl Fused, lane: usize, lambda: f32) -> f64 {
        let lane = lane % LANES;
        let [g0, g1, g2, g3] = &self.guess;
        let at = |powers: &Lanes| f64::from(powers[lane]);
        let (g0, g1, g2, g3) = (at(g0), at(g1), at(g2), at(g3));
        let lambda = f64::from(lambda);
        let value = fma.fused(fma.fused(fma.fused(g3, lambda, g2), lambda, g1), lambda, g0);
        let [start, end] = self.poles;
        if start | end == 0 {
            return value;
        }
        let distance = greater(value, 0.0).sqrt();
        match [start >> lane & 1, end >> lane & 1] {
            [1, _] => distance,
            [_, 1] => 1.0 - distance,
            _ => value,
        }
    }

    /// The same for eight rays.
    #[inline(always)]
    pub(super) fn guesses<S: Simd>(&self, simd: S, lane: usize, lambda: f64x8<S>) -> f64x8<S> {
        let lane = lane % LANES;
        let [g0, g1, g2, g3] = &self.guess;
        let value = wide(simd, g3[lane]).mul_add(lambda, wide(simd, g2[lane]));
        let value = value.mul_add(lambda, wide(simd, g1[lane]));
        let value = value.mul_add(lambda, wide(simd, g0[lane]));
        let [start, end] = self.poles;
        if (start | end) >> lane & 1 == 0 {
            return value;
        }
        let distance = value.max(wide(simd, 0.0)).sqrt();
        if start >> lane & 1 != 0 { distance } else { wide(simd, 1.0) - distance }
    }

    /// The middles of the leaves' heights, and half of what lies between their ends, or more.
    #[inline(always)]
    pub(super) fn heights<S: Simd>(&self, simd: S) -> [f32x8<S>; 2] {
        let corner = splat(simd, self.corner[0] as f32);
        [load(simd, &self.z) + corner, load(simd, &self.height)]
    }

    /// From where z and w count.
    #[inline(always)]
    pub(super) fn corner(&self) -> [f64; 2] {
        self.corner
    }
}

/// Two bounds in each lane, each by the first half of the bits of an f32: for its other half what happens to lie beside it does,
/// which raises it, as rounding has done, by less than 2^-7. The last byte of a number comes first.
#[derive(Clone, Debug)]
struct Pairs([u8; PAIRS]);

const PAIRS: usize = 4 * LANES + 2;

impl Pairs {
    /// The same in all lanes; of negative numbers such as may be lowered. None should be so small that processors take long over it.
    const fn filled(first: f32, second: f32) -> Self {
        let ([_, _, a, b], [_, _, c, d]) = (second.to_le_bytes(), first.to_le_bytes());
        let mut pairs = [0; PAIRS];
        let mut i = 2;
        while i < PAIRS {
            pairs[i] = [c, d, a, b][i % 4];
            i += 1;
        }
        Self(pairs)
    }

    /// Neither may be negative; lanes are to be set in their order.
    fn set(&mut self, lane: usize, first: f32, second: f32) {
        for (start, bound) in [(4 * lane, second), (4 * lane + 2, first)] {
            let [_, _, low, high] = bound.to_le_bytes();
            let place = start + 2..start + 4;
            self.0[place.clone()].copy_from_slice(&[low, high]);
            if self.number(start) < bound {
                let next = u16::from_le_bytes([low, high]) + 1;
                self.0[place].copy_from_slice(&next.to_le_bytes());
            }
        }
    }

    #[inline(always)]
    fn number(&self, start: usize) -> f32 {
        let b = &self.0;
        f32::from_le_bytes([b[start], b[start + 1], b[start + 2], b[start + 3]])
    }

    /// The first ones and the second ones.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> [f32x8<S>; 2] {
        let from = |start: usize| u8x32::from_slice(simd, &self.0[start..start + 4 * LANES]);
        [from(2).bitcast(), from(0).bitcast()]
    }

    /// Those of one lane.
    #[inline(always)]
    fn of(&self, lane: usize) -> [f32; 2] {
        [self.number(4 * lane + 2), self.number(4 * lane)]
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &Lanes) -> f32x8<S> {
    f32x8::from_slice(simd, lanes)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

#[inline(always)]
fn wide<S: Simd>(simd: S, value: f32) -> f64x8<S> {
    f64x8::splat(simd, f64::from(value))
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn pairs_are_bounds() {
        let bounds = [0.0, f32::MIN_POSITIVE, 1.0, 1.0 / 3.0, 1.999_999, 7.3e-11, 0.01, UNKNOWN];
        let mut pairs = Pairs::filled(-1.0, 1.0);
        for turn in 0..LANES {
            let second = |lane: usize| bounds[(lane + turn) % LANES];
            for (lane, first) in bounds.iter().enumerate() {
                pairs.set(lane, *first, second(lane));
            }
            let loaded = dispatch!(Level::new(), simd => {
                pairs.load(simd).map(|own| core::array::from_fn::<f32, LANES, _>(|i| own[i]))
            });
            for (lane, first) in bounds.into_iter().enumerate() {
                let own = pairs.of(lane);
                assert_eq!([loaded[0][lane], loaded[1][lane]], own);
                for (bound, wanted) in own.into_iter().zip([first, second(lane)]) {
                    let raised = (wanted * (1.0 + 1.0 / 64.0)).max(f32::MIN_POSITIVE);
                    assert!(wanted <= bound && bound <= raised, "{wanted} {bound}");
                }
            }
        }
        let [first, second] = Pairs::filled(-1.0, 1.0).of(3);
        assert!((1.0..1.01).contains(&-first) && (1.0..1.01).contains(&second));
    }
}

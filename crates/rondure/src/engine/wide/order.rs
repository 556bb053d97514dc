//! Which of up to 32 parameters comes first.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8, u32x8};

/// A number from 0 to 31 takes the place of the last bits.
const NUMBER: u32 = 31;

/// The key of what is not there: infinity, with the last place.
const NONE: u32 = f32::INFINITY.to_bits() | NUMBER;

const NUMBERS: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Eight values, the `eight`-th of up to four times eight: for each in the mask a number that is in their order, with
/// its place among all in its last bits. Values that differ by less than 2^-18 of themselves, and those that are
/// negative, count as equal. The bits of positive floats are in order as they are.
#[inline(always)]
pub(super) fn keys<S: Simd>(
    simd: S,
    values: f32x8<S>,
    mask: mask32x8<S>,
    eight: usize,
) -> u32x8<S> {
    let bits: u32x8<S> = values.max(f32x8::splat(simd, 0.0)).bitcast();
    let numbers = u32x8::from_slice(simd, &NUMBERS) + u32x8::splat(simd, 8 * eight as u32);
    let keys = (bits & u32x8::splat(simd, !NUMBER)) | numbers;
    mask.select(keys, u32x8::splat(simd, NONE))
}

/// The keys of nothing.
#[inline(always)]
pub(super) fn none<S: Simd>(simd: S) -> u32x8<S> {
    u32x8::splat(simd, NONE)
}

/// The place of the least key.
#[inline(always)]
pub(super) fn number<S: Simd>(keys: u32x8<S>) -> usize {
    (keys.reduce_min() & NUMBER) as usize
}

/// The least key of sixteen values in a mask.
#[inline(always)]
fn least_key<S: Simd>(simd: S, values: [f32x8<S>; 2], mask: u32) -> u32 {
    let first = mask32x8::from_bitmask(simd, u64::from(mask & 0xff));
    let second = mask32x8::from_bitmask(simd, u64::from(mask >> 8));
    keys(simd, values[0], first, 0).min(keys(simd, values[1], second, 1)).reduce_min()
}

/// The number of the least of sixteen values in the mask, or nearly the least.
#[inline(always)]
pub(super) fn first<S: Simd>(simd: S, values: [f32x8<S>; 2], mask: u32) -> usize {
    (least_key(simd, values, mask) & NUMBER) as usize
}

/// The place of the least value in the masks, or nearly the least. No more than the least of the others, and not much less,
/// comes with it: minus infinity if that is negative, infinity if there is none.
#[inline(always)]
pub(super) fn first_and_next<S: Simd>(
    simd: S,
    values: [f32x8<S>; 2],
    masks: [mask32x8<S>; 2],
) -> (usize, f32) {
    let (near, far) = (keys(simd, values[0], masks[0], 0), keys(simd, values[1], masks[1], 1));
    let first = near.min(far).reduce_min();
    let (is_first, none) = (u32x8::splat(simd, first), u32x8::splat(simd, NONE));
    let near = near.simd_eq(is_first).select(none, near);
    let far = far.simd_eq(is_first).select(none, far);
    ((first & NUMBER) as usize, value(near.min(far).reduce_min()))
}

/// The value of a key, or minus infinity: negative values have no keys of their own.
#[inline(always)]
fn value(key: u32) -> f32 {
    let value = f32::from_bits(key & !NUMBER);
    if value > 0.0 { value } else { f32::NEG_INFINITY }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn the_least_in_the_mask_comes_first() {
        let values =
            [5.0, 2.0, 9.0, 0.5, 4.0, 3.0, 7.0, 8.0, 1.0, 0.25, 6.0, 5.5, 2.5, 3.5, 4.5, -1.0];
        let cases = [
            (0xffff, 15, 0.25),
            (0x7fff, 9, 0.5),
            (0x00f7, 1, 3.0),
            (0x8008, 15, 0.5),
            (0x8, 3, f32::INFINITY),
        ];
        for (mask, number, value) in cases {
            let (alone, both) = dispatch!(Level::new(), simd => {
                let halves = [&values[..8], &values[8..]].map(|half| f32x8::from_slice(simd, half));
                let of = |mask: u32| mask32x8::from_bitmask(simd, u64::from(mask));
                let masks = [of(mask & 0xff), of(mask >> 8)];
                (first(simd, halves, mask), first_and_next(simd, halves, masks))
            });
            assert_eq!([alone, both.0], [number; 2]);
            assert!(both.1 <= value && both.1 >= value * (1.0 - 2e-5), "{both:?}");
        }
    }

    #[test]
    fn what_is_negative_may_lie_anywhere_before() {
        let next = dispatch!(Level::new(), simd => {
            let values = f32x8::from_slice(simd, &[3.0, -2.0, -0.5, 1.0, 4.0, 4.0, 4.0, 4.0]);
            let (all, none) = (mask32x8::splat(simd, true), mask32x8::splat(simd, false));
            first_and_next(simd, [values; 2], [all, none]).1
        });
        assert_eq!(next, f32::NEG_INFINITY);
    }
}

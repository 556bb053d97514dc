//! Which of sixteen parameters comes first.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

/// How many are compared.
pub(super) const SIXTEEN: usize = 16;

/// The lane's own number takes the place of the last bits.
const LANE: u32 = SIXTEEN as u32 - 1;

/// The numbers of the lanes.
const NUMBERS: [u32; SIXTEEN] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The lane of the mask with the least value, or nearly the least: values that differ by less than
/// 2^-19 of themselves, and those that are negative, count as equal. The bits of positive floats are in
/// order as they are.
#[inline(always)]
pub(super) fn first<S: Simd>(simd: S, values: f32x16<S>, mask: mask32x16<S>) -> usize {
    (key(simd, values, mask) & LANE) as usize
}

/// No more than the least value in the mask, if that is not negative, and not much less; not a number if the mask
/// is empty.
#[inline(always)]
pub(super) fn least<S: Simd>(simd: S, values: f32x16<S>, mask: mask32x16<S>) -> f32 {
    f32::from_bits(key(simd, values, mask) & !LANE)
}

#[inline(always)]
fn key<S: Simd>(simd: S, values: f32x16<S>, mask: mask32x16<S>) -> u32 {
    let bits: u32x16<S> = values.max(f32x16::splat(simd, 0.0)).bitcast();
    let numbers = u32x16::from_slice(simd, &NUMBERS);
    let keys = (bits & u32x16::splat(simd, !LANE)) | numbers;
    mask.select(keys, u32x16::splat(simd, u32::MAX)).reduce_min()
}

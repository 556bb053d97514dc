//! Scalar operations that compile to one instruction each.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Level;
use fearless_simd::Simd;

/// a b + c, by whatever is fastest.
pub(super) trait Fused: Copy {
    fn fused(self, a: f64, b: f64, c: f64) -> f64;
}

/// In one rounding where the instruction set has that, otherwise in two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best<S>(pub(super) S);

impl<S: Simd> Fused for Best<S> {
    #[inline(always)]
    fn fused(self, a: f64, b: f64, c: f64) -> f64 {
        match self.0.level() {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) | Level::Avx512(_) => a.mul_add(b, c),
            #[cfg(target_arch = "aarch64")]
            fearless_simd::Level::Neon(_) => a.mul_add(b, c),
            _ => a * b + c,
        }
    }
}

/// The greater of two numbers; the second if one is not a number.
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The lesser of two numbers; the second if one is not a number.
#[inline(always)]
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

//! Exact numbers: every finite f64 is an integer times a power of two.

use dashu_int::{IBig, UBig, ops::BitTest};

/// `x` as an odd integer (or zero) and the power of two that it is multiplied by.
///
/// # Panics
///
/// If `x` is not finite.
pub fn decode(x: f64) -> (i64, i64) {
    assert!(x.is_finite(), "{x} is no number");
    if x == 0.0 {
        return (0, 0);
    }
    let bits = x.to_bits();
    let biased = i64::from((bits >> 52) as u32 & 0x7ff);
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (mantissa, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
    let zeros = mantissa.trailing_zeros();
    let odd = mantissa >> zeros;
    (if x < 0.0 { -odd } else { odd }, exponent + i64::from(zeros))
}

/// Numbers as integers over one shared power of two: `xs[i] = result.0[i] * 2^result.1`.
pub fn align(xs: &[f64]) -> (Vec<IBig>, i64) {
    let parts: Vec<_> = xs.iter().map(|&x| decode(x)).collect();
    let shared = parts.iter().filter(|p| p.0 != 0).map(|p| p.1).min().unwrap_or(0);
    let integers = parts
        .iter()
        .map(|&(m, e)| if m == 0 { IBig::ZERO } else { IBig::from(m) << (e - shared) as usize })
        .collect();
    (integers, shared)
}

/// `x * 2^by` for `by >= 0`.
pub fn shl(x: &IBig, by: i64) -> IBig {
    assert!(by >= 0, "a shift to the left by {by}");
    x << by as usize
}

/// The number of bits of |x|.
pub fn bits(x: &IBig) -> i64 {
    x.bit_len() as i64
}

/// `x * 2^exponent`, rounded; over- and underflow become infinity and zero.
pub fn ldexp(x: f64, exponent: i64) -> f64 {
    let power = |e: i64| f64::from_bits(((e + 1023) as u64) << 52);
    let mut rest = exponent.clamp(-2400, 2400);
    let mut x = x;
    while rest != 0 {
        let step = rest.clamp(-1000, 1000);
        x *= power(step);
        rest -= step;
    }
    x
}

/// A number as the unevaluated sum `hi + lo` of two f64, good to about 100 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double {
    /// The number rounded to an f64.
    pub hi: f64,
    /// What was rounded off, rounded.
    pub lo: f64,
}

impl Double {
    /// `x - self` for an f64 near it, with one rounding.
    pub fn distance(self, x: f64) -> f64 {
        (x - self.hi) - self.lo
    }
}

fn top_bits(x: &IBig) -> (f64, i64) {
    let excess = (bits(x) - 53).max(0);
    let magnitude: IBig = if excess > 0 { x >> excess as usize } else { x.clone() };
    let integer = i64::try_from(magnitude).unwrap_or(0);
    (integer as f64, excess)
}

/// `x * 2^exponent` as an f64 with a relative error of at most 2^-52.
pub fn to_f64(x: &IBig, exponent: i64) -> f64 {
    let (top, excess) = top_bits(x);
    ldexp(top, exponent + excess)
}

/// `x * 2^exponent` as a [`Double`].
pub fn to_double(x: &IBig, exponent: i64) -> Double {
    let (top, excess) = top_bits(x);
    let rest = x - (IBig::from(top as i64) << excess as usize);
    let (next, next_excess) = top_bits(&rest);
    let (hi, lo) = (ldexp(top, exponent + excess), ldexp(next, exponent + next_excess));
    let sum = hi + lo;
    Double { hi: sum, lo: lo - (sum - hi) }
}

/// `numerator / denominator * 2^exponent` to about 100 bits.
pub fn ratio(numerator: &IBig, denominator: &IBig, exponent: i64) -> Double {
    let shift = (128 - bits(numerator) + bits(denominator)).max(0);
    let quotient = shl(numerator, shift) / denominator;
    to_double(&quotient, exponent - shift)
}

/// `numerator / denominator * 2^exponent` as an f64 with a relative error of at most 2^-51.
pub fn ratio_f64(numerator: &IBig, denominator: &IBig, exponent: i64) -> f64 {
    let double = ratio(numerator, denominator, exponent);
    double.hi
}

/// The integer part of the square root of `x >= 0`.
pub fn sqrt(x: &IBig) -> IBig {
    use dashu_int::ops::SquareRoot;
    let magnitude = UBig::try_from(x.clone()).unwrap_or(UBig::ZERO);
    IBig::from(magnitude.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_decoded_exactly() {
        for x in [0.0, 1.0, -0.3, 5e-324, f64::MIN_POSITIVE, -f64::MAX, 6.25e-17] {
            let (m, e) = decode(x);
            assert_eq!(to_f64(&IBig::from(m), e), x);
        }
    }

    #[test]
    fn ratio_keeps_a_hundred_bits() {
        let third = ratio(&IBig::from(1), &IBig::from(3), 0);
        assert_eq!(third.hi, 1.0 / 3.0);
        // 1/3 - fl(1/3) = 2^-54 / 3
        assert!((third.lo * 3.0 / 2f64.powi(-54) - 1.0).abs() < 1e-10);
        assert_eq!(ratio(&IBig::from(-7), &IBig::from(2), -3).hi, -0.4375);
        assert_eq!(ratio(&IBig::from(1), &IBig::from(1), -1070).hi, 2f64.powi(-1070));
    }
}

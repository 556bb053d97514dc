//! Rounding: the few facts about f64 arithmetic that the rest relies on, in one place.
//!
//! Every tolerance in this crate is a multiple of [`UNIT_ROUNDOFF`] times the size of the numbers
//! that were rounded, and is a function with its derivation; `docs/numerics.md` tells the story.
//! Notation and results: Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., ch. 3.

/// u: the largest relative error of one rounded operation, 2^-53.
pub const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;

/// gamma(n) = n u / (1 - n u): the largest relative error that n rounded operations in a row can
/// leave behind (Higham, lemma 3.1).
#[inline]
pub const fn gamma(n: u32) -> f64 {
    let nu = n as f64 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// a - b without error, as the rounded difference and what was rounded off (Knuth's TwoSum).
#[inline]
pub fn two_diff(a: f64, b: f64) -> (f64, f64) {
    let difference = a - b;
    let b_virtual = a - difference;
    let a_virtual = difference + b_virtual;
    (difference, (a - a_virtual) + (b_virtual - b))
}

/// a b - c d with an error of at most 1.5 ulp of the result (Kahan; Jeannerod, Louvet, Muller 2013).
#[inline]
pub fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let error = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + error
}

/// The power of two 2^-e that brings `x` into [1, 2); multiplying by it rounds nothing.
///
/// Zero and subnormal numbers, and numbers near the largest, are brought as near as an f64 can.
#[inline]
pub fn reciprocal_power_of_two(x: f64) -> f64 {
    const EXPONENT_MASK: u64 = 0x7ff;
    let exponent = ((x.to_bits() >> 52) & EXPONENT_MASK).clamp(1, 2045);
    f64::from_bits((2046 - exponent) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_diff_is_exact() {
        let two_53 = 9_007_199_254_740_992.0;
        assert_eq!(two_diff(two_53, 0.5), (two_53, -0.5));
        assert_eq!(two_diff(0.5, two_53), (-two_53, 0.5));
        assert_eq!(two_diff(0.75, 0.5), (0.25, 0.0));
    }

    #[test]
    fn reciprocal_power_of_two_normalises() {
        for x in [1e-300, 0.3, 1.0, 1.999, 2.0, 7e250, 1e307] {
            let y = x * reciprocal_power_of_two(x);
            assert!((1.0..2.0).contains(&y), "{x} became {y}");
        }
        assert!((5e-324 * reciprocal_power_of_two(5e-324)).is_finite());
        assert!(f64::MAX * reciprocal_power_of_two(f64::MAX) >= 1.0);
    }

    #[test]
    fn difference_of_products_keeps_what_cancels() {
        let a = 1.0 + f64::EPSILON;
        // (1 + e)^2 - (1 + 2 e) * 1 = e^2, which plain arithmetic loses.
        assert_eq!(
            difference_of_products(a, a, 1.0 + 2.0 * f64::EPSILON, 1.0),
            f64::EPSILON.powi(2)
        );
    }
}

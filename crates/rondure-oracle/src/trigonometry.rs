//! Sine and cosine to as many bits as wanted, for arcs and nothing else.
//!
//! The angle is halved `HALVINGS` times, the Taylor series is summed in fixed point, and
//! the halvings are undone by (c, s) -> (c^2 - s^2, 2 c s). Each doubling at most quadruples the error,
//! so 2 `HALVINGS` + 20 guard bits leave an error below one unit of the result.

use dashu_int::IBig;

const HALVINGS: usize = 12;
const GUARD: usize = 2 * HALVINGS + 20;

/// (cos, sin) of `numerator / 2^exponent`, as integers over 2^`precision`.
pub fn cos_sin(numerator: &IBig, exponent: i64, precision: usize) -> (IBig, IBig) {
    let work = precision + GUARD;
    let shift = work as i64 - exponent - HALVINGS as i64;
    let x: IBig =
        if shift >= 0 { numerator << shift as usize } else { numerator >> (-shift) as usize };
    let one = IBig::from(1) << work;
    let (mut cos, mut sin) = (IBig::ZERO, IBig::ZERO);
    let mut term = one;
    let mut n = 0_u32;
    while term != IBig::ZERO && term != IBig::from(-1) {
        match n % 4 {
            0 => cos += &term,
            1 => sin += &term,
            2 => cos -= &term,
            _ => sin -= &term,
        }
        n += 1;
        term = ((&term * &x) >> work) / IBig::from(n);
    }
    for _ in 0..HALVINGS {
        let doubled: IBig = (&cos * &cos - &sin * &sin) >> work;
        sin = (&cos * &sin) >> (work - 1);
        cos = doubled;
    }
    (cos >> GUARD, sin >> GUARD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::{decode, to_f64};

    #[test]
    fn agrees_with_the_library_and_with_pythagoras() {
        for angle in [0.0, 1.0, -0.7, 3.0, 6.2, -9.4, 1e-30] {
            let (m, e) = decode(angle);
            let (c, s) = cos_sin(&IBig::from(m), -e, 200);
            assert!((to_f64(&c, -200) - f64::cos(angle)).abs() < 1e-15, "{angle}");
            assert!((to_f64(&s, -200) - f64::sin(angle)).abs() < 1e-15, "{angle}");
            let defect = &c * &c + &s * &s - (IBig::from(1) << 400);
            assert!(to_f64(&defect, -200).abs() < 8.0, "{angle}");
        }
    }
}

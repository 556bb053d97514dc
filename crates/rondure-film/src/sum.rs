//! Sums of floating-point numbers that do not depend on the order of adding.
//!
//! A sum is a whole number of steps of 2^-`FRACTION`, in two's complement over 64 `LIMBS` bits (Kulisch 1971; cut to the range that a film
//! needs). Each number is rounded to that grid by itself, and whole numbers add up the same in any order, in any grouping:
//! what tiles, passes and machines bring together has the same bits however the work was dealt out.
//!
//! The range is ±2^(64 LIMBS - 1 - FRACTION); beyond it a sum wraps round, so who adds must keep count: the film refuses samples and numbers of
//! samples that could get there.

/// A sum of `f64`, exact but for the rounding of each number to the grid of 2^-`FRACTION`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sum<const LIMBS: usize, const FRACTION: u32>([u64; LIMBS]);

impl<const LIMBS: usize, const FRACTION: u32> Default for Sum<LIMBS, FRACTION> {
    fn default() -> Self {
        Self([0; LIMBS])
    }
}

impl<const LIMBS: usize, const FRACTION: u32> Sum<LIMBS, FRACTION> {
    /// The sum whose two's complement this is, least significant limb first.
    pub const fn from_limbs(limbs: [u64; LIMBS]) -> Self {
        Self(limbs)
    }

    /// The two's complement, least significant limb first.
    pub const fn limbs(&self) -> [u64; LIMBS] {
        self.0
    }

    /// Adds a finite number, rounded to the grid, halves away from zero.
    #[inline]
    pub fn add(&mut self, value: f64) {
        const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
        let bits = value.to_bits();
        let exponent = (bits >> MANTISSA & 0x7ff) as i32;
        let fraction = bits & ((1 << MANTISSA) - 1);
        // |value| = mantissa 2^(shift - FRACTION)
        let mantissa = if exponent == 0 { fraction } else { fraction | 1 << MANTISSA };
        let shift = exponent.max(1) - 1075 + FRACTION as i32;
        let (steps, shift) = match shift {
            0.. => (mantissa, shift as u32),
            // Less than half a step.
            ..-53 => return,
            _ => ((mantissa >> (-shift - 1)).wrapping_add(1) >> 1, 0),
        };
        let limb = (shift / 64) as usize;
        debug_assert!(limb < LIMBS, "{value} is beyond the range of the sum");
        let low = steps << (shift % 64);
        let high = steps >> 1 >> (63 - shift % 64);
        // All limbs in one run without branches: in two's complement -x is !x + 1.
        let negative = (bits as i64 >> 63) as u64;
        let mut carry = negative & 1 == 1;
        for (i, to) in self.0.iter_mut().enumerate() {
            let part = if i == limb { low } else { 0 } | if i == limb + 1 { high } else { 0 };
            let (sum, a) = to.overflowing_add(part ^ negative);
            let (sum, b) = sum.overflowing_add(u64::from(carry));
            (*to, carry) = (sum, a | b);
        }
    }

    /// Adds another sum.
    #[inline]
    pub fn merge(&mut self, other: &Self) {
        let mut carry = false;
        for (to, part) in self.0.iter_mut().zip(other.0) {
            let (sum, a) = to.overflowing_add(part);
            let (sum, b) = sum.overflowing_add(u64::from(carry));
            (*to, carry) = (sum, a | b);
        }
    }

    /// The `f64` nearest to the sum, halves to even.
    pub fn to_f64(&self) -> f64 {
        let negative = self.0.last().is_some_and(|top| top >> 63 == 1);
        let mut size = self.0;
        if negative {
            let mut carry = true;
            for limb in &mut size {
                (*limb, carry) = (!*limb).overflowing_add(u64::from(carry));
            }
        }
        let Some(top) = size.iter().rposition(|&limb| limb != 0) else { return 0.0 };
        let below = if top > 0 { size[top - 1] } else { 0 };
        let wide = u128::from(size[top]) << 64 | u128::from(below);
        let zeros = wide.leading_zeros();
        let wide = wide << zeros;
        // 64 bits; the last one also stands for all that follow, which is enough to round by.
        let rest = wide as u64 != 0 || size[..top.saturating_sub(1)].iter().any(|&limb| limb != 0);
        let head = (wide >> 64) as u64 | u64::from(rest);
        let exponent = 64 * top as i32 - zeros as i32 - FRACTION as i32;
        let value = head as f64 * power_of_two(exponent);
        if negative { -value } else { value }
    }
}

/// 2^`exponent`, for exponents of normal numbers.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    type Light = Sum<2, 64>;
    type Square = Sum<3, 80>;
    type Small = Sum<1, 40>;

    fn of<const L: usize, const F: u32>(values: &[f64]) -> Sum<L, F> {
        let mut sum = Sum::default();
        values.iter().for_each(|&v| sum.add(v));
        sum
    }

    #[test]
    fn single_numbers_come_back() {
        for value in [0.0, 1.0, -1.0, 0.1, -1e12, 3.25e-9, 1.0 - f64::EPSILON, -7e-15] {
            // From 2^-12 on every f64 lies on the grid; below, half a step may be lost.
            assert!((of::<2, 64>(&[value]).to_f64() - value).abs() <= power_of_two(-65), "{value}");
        }
        assert_eq!(of::<2, 64>(&[0.1]).to_f64(), 0.1);
        assert_eq!(of::<3, 80>(&[1e24]).to_f64(), 1e24);
        assert_eq!(of::<1, 40>(&[-0.625]).to_f64(), -0.625);
    }

    #[test]
    fn numbers_are_rounded_to_the_grid() {
        let step = power_of_two(-40);
        for (value, steps) in
            [(0.49, 0.0), (0.5, 1.0), (-0.5, -1.0), (1.49, 1.0), (1.5, 2.0), (-2.6, -3.0)]
        {
            assert_eq!(of::<1, 40>(&[value * step]).to_f64(), steps * step, "{value}");
        }
        for tiny in [f64::MIN_POSITIVE, 5e-324, -1e-300, 1e-40] {
            assert_eq!(of::<1, 40>(&[tiny]), Small::default());
        }
    }

    #[test]
    fn nothing_is_lost_beside_large_numbers() {
        let large = power_of_two(40);
        let sum = of::<2, 64>(&[large, 1e-12, -large, large, -large]);
        assert!((sum.to_f64() - 1e-12).abs() <= power_of_two(-65));
        let sum = of::<3, 80>(&[power_of_two(80), 1e-20, -power_of_two(80)]);
        assert!((sum.to_f64() - 1e-20).abs() <= power_of_two(-81));
    }

    #[test]
    fn results_are_rounded_to_nearest_even() {
        let large = power_of_two(20);
        let half = large * f64::EPSILON / 2.0;
        assert_eq!(of::<2, 64>(&[large, half]).to_f64(), large);
        assert_eq!(of::<2, 64>(&[large, half, power_of_two(-64)]).to_f64(), large.next_up());
        assert_eq!(of::<2, 64>(&[large, 3.0 * half]).to_f64(), large.next_up().next_up());
        assert_eq!(of::<3, 80>(&[large, half, power_of_two(-80)]).to_f64(), large.next_up());
    }

    fn sample() -> impl Strategy<Value = f64> {
        (-1.0_f64..1.0, -40..40_i32).prop_map(|(m, e)| m * power_of_two(e))
    }

    proptest! {
        #[test]
        fn order_and_grouping_change_no_bit(
            values in proptest::collection::vec(sample(), 1..60), at in 0..60_usize, turn in 0..60_usize,
        ) {
            let light = of::<2, 64>(&values);
            let mut turned = values.clone();
            turned.rotate_left(turn % values.len());
            turned.reverse();
            let (a, b) = turned.split_at(at % values.len());
            let mut parts: Light = of(b);
            parts.merge(&of(a));
            prop_assert_eq!(light, parts);
            let squares: Vec<_> = values.iter().map(|v| v * v).collect();
            let turned: Vec<_> = turned.iter().map(|v| v * v).collect();
            let (a, b) = turned.split_at(at % values.len());
            let mut parts: Square = of(b);
            parts.merge(&of(a));
            prop_assert_eq!(of::<3, 80>(&squares), parts);
        }

        #[test]
        fn sums_of_whole_numbers_are_right(values in proptest::collection::vec(-1_000_000_i64..1_000_000, 0..50)) {
            let sum = of::<2, 64>(&values.iter().map(|&v| v as f64).collect::<Vec<_>>());
            prop_assert_eq!(sum.to_f64(), values.iter().sum::<i64>() as f64);
            prop_assert_eq!(Light::from_limbs(sum.limbs()), sum);
        }
    }
}

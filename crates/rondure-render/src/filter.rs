//! Pixel filters, sampled in proportion to their size.
//!
//! A sample is placed by the filter and then counts fully for its pixel and for no other (Ernst et
//! al. 2006, "Filter Importance Sampling"): tiles need no borders. Where the filter is negative the sample counts as negative, and the film
//! divides by the number of positive samples less that of negative ones: the mean is that of light over the filter, and what is the same
//! everywhere comes out as itself.
//!
//! All filters are products of a function of x and the same of y.

use core::f64::consts::TAU;

use rondure_scene::{FilterKind, PixelFilter};

const STEPS: usize = 1024;
/// Parts of a step over which the function is integrated; a polynomial of the fourth degree to rounding.
const PARTS: usize = 16;

/// The inverse of the distribution function of a filter's absolute value, tabulated.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    kind: FilterKind,
    radius: f64,
    inverse: Vec<f64>,
}

/// The filter over [-1, 1], up to a factor.
fn value(kind: FilterKind, x: f64) -> f64 {
    match kind {
        FilterKind::Box => 1.0,
        // The standard deviation is a third of the radius; lowered so that it ends at 0.
        FilterKind::Gaussian => (-4.5 * x * x).exp() - (-4.5_f64).exp(),
        // Harris 1978, the 4-term window of least side lobes.
        FilterKind::BlackmanHarris => {
            let cos = |k: f64| (0.5 * TAU * k * x).cos();
            0.35875 + 0.48829 * cos(1.0) + 0.14128 * cos(2.0) + 0.01168 * cos(3.0)
        }
        // Mitchell and Netravali 1988, B = C = 1/3.
        FilterKind::Mitchell => {
            let x = 2.0 * x.abs();
            if x < 1.0 {
                (7.0 * x - 12.0) * x * x + 16.0 / 3.0
            } else {
                ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0
            }
        }
    }
}

impl Filter {
    pub(crate) fn new(filter: PixelFilter) -> Self {
        let PixelFilter { kind, radius } = filter;
        let size = |x: f64| value(kind, x).abs();
        let width = 2.0 / (STEPS * PARTS) as f64;
        let edge = |i: usize| i as f64 * width - 1.0;
        // Simpson's rule.
        let part = |i: usize| {
            let (a, b) = (edge(i), edge(i + 1));
            (size(a) + 4.0 * size(0.5 * (a + b)) + size(b)) * (width / 6.0)
        };
        let mut sums = vec![0.0];
        for i in 0..STEPS * PARTS {
            sums.push(sums[i] + part(i));
        }
        let whole = sums[STEPS * PARTS];
        let invert = |target: f64| {
            let after = sums.partition_point(|&sum| sum < target).clamp(1, STEPS * PARTS);
            let (low, high) = (sums[after - 1], sums[after]);
            (edge(after - 1) + width * ((target - low) / (high - low)).clamp(0.0, 1.0)) * radius
        };
        let inverse = (0..=STEPS).map(|i| invert(i as f64 / STEPS as f64 * whole)).collect();
        Self { kind, radius, inverse }
    }

    /// The offset from the middle of the pixel, in pixels, for a number between 0 and 1, and whether the filter is negative there.
    #[inline]
    pub(crate) fn offset(&self, u: f64) -> (f64, bool) {
        if self.kind == FilterKind::Box {
            return ((2.0 * u - 1.0) * self.radius, false);
        }
        let place = u * STEPS as f64;
        let i = (place as usize).min(STEPS - 1);
        let (a, b) = (self.inverse[i], self.inverse[i + 1]);
        let offset = a + (b - a) * (place - i as f64);
        let negative =
            self.kind == FilterKind::Mitchell && value(self.kind, offset / self.radius) < 0.0;
        (offset, negative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [PixelFilter; 5] = [
        PixelFilter { kind: FilterKind::Box, radius: 0.5 },
        PixelFilter { kind: FilterKind::Gaussian, radius: 1.5 },
        PixelFilter { kind: FilterKind::BlackmanHarris, radius: 1.5 },
        PixelFilter { kind: FilterKind::Mitchell, radius: 2.0 },
        PixelFilter { kind: FilterKind::Mitchell, radius: 3.0 },
    ];

    #[test]
    fn offsets_are_symmetric_and_bounded() {
        for all in ALL {
            let filter = Filter::new(all);
            for i in 0..1000 {
                let u = (f64::from(i) + 0.5) / 1000.0;
                let (offset, negative) = filter.offset(u);
                let (other, too) = filter.offset(1.0 - u);
                assert!(offset.abs() <= all.radius && negative == too);
                assert!((offset + other).abs() < 1e-9, "{all:?} {offset} {other}");
            }
        }
    }

    /// The mean of a function over the filter, by its samples and by its values.
    #[test]
    fn signed_samples_have_the_moments_of_the_filter() {
        for all in ALL {
            let filter = Filter::new(all);
            let n = 20_000;
            let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
            for power in [1, 2, 4, 6] {
                let g = |x: f64| x.powi(power);
                let (mut sum, mut weight) = (0.0, 0.0);
                let (mut exact, mut whole) = (0.0, 0.0);
                for i in 0..n {
                    let (offset, negative) = filter.offset(middle(i));
                    let sign = if negative { -1.0 } else { 1.0 };
                    sum += sign * g(offset / all.radius);
                    weight += sign;
                    let x = 2.0 * middle(i) - 1.0;
                    exact += value(all.kind, x) * g(x);
                    whole += value(all.kind, x);
                }
                let (found, expected) = (sum / weight, exact / whole);
                // Straight lines in the last step of the table, where a bell is flat.
                assert!((found - expected).abs() < 5e-4, "{all:?} {power}: {found} {expected}");
            }
        }
    }

    #[test]
    fn few_samples_are_negative() {
        let filter = Filter::new(ALL[3]);
        let n = 10_000;
        let negative = (0..n).filter(|&i| filter.offset((f64::from(i) + 0.5) / f64::from(n)).1);
        let share = negative.count() as f64 / f64::from(n);
        // Of two dimensions the one or the other: what `Count::divisor` of the film relies on.
        assert!(2.0 * share * (1.0 - share) < 0.125, "{share}");
        assert!(share > 0.01);
    }
}

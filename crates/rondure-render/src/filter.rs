//! The pixel filter: a Blackman-Harris window, sampled in proportion to its value.
//!
//! A sample is placed by the filter and then counts fully for its pixel and for no other (Ernst et
//! al. 2006, "Filter Importance Sampling"): the film needs no weights, and tiles no borders.

use core::f64::consts::TAU;

/// Half the width of the window, in pixels. Its half-value width is then 1.1 pixels: edges are
/// smooth and still crisp.
const RADIUS: f64 = 1.5;
const STEPS: usize = 1024;

/// The inverse of the filter's distribution function, tabulated.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    inverse: Vec<f64>,
}

/// The integral of the window over [0, x], x from 0 to 1; the whole is A0 (Harris 1978, the
/// 4-term window of least side lobes).
fn cumulative(x: f64) -> f64 {
    const A: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];
    let wave = |k: f64| (TAU * k * x).sin() / (TAU * k);
    (A[0] * x - A[1] * wave(1.0) + A[2] * wave(2.0) - A[3] * wave(3.0)) / A[0]
}

impl Filter {
    pub(crate) fn new() -> Self {
        let invert = |target: f64| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (low + high);
                if cumulative(middle) < target { low = middle } else { high = middle }
            }
            (0.5 * (low + high) * 2.0 - 1.0) * RADIUS
        };
        Self { inverse: (0..=STEPS).map(|i| invert(i as f64 / STEPS as f64)).collect() }
    }

    /// The offset from the middle of the pixel, in pixels, for a number between 0 and 1.
    #[inline]
    pub(crate) fn offset(&self, u: f64) -> f64 {
        let place = u * STEPS as f64;
        let i = (place as usize).min(STEPS - 1);
        let (a, b) = (self.inverse[i], self.inverse[i + 1]);
        a + (b - a) * (place - i as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_symmetric_and_bounded() {
        let filter = Filter::new();
        for i in 0..1000 {
            let u = (f64::from(i) + 0.5) / 1000.0;
            let offset = filter.offset(u);
            assert!(offset.abs() <= RADIUS);
            assert!((offset + filter.offset(1.0 - u)).abs() < 1e-9);
        }
    }

    #[test]
    fn variance_is_that_of_the_window() {
        let window = |x: f64| {
            let cos = |k: f64| (TAU * k * x).cos();
            0.35875 - 0.48829 * cos(1.0) + 0.14128 * cos(2.0) - 0.01168 * cos(3.0)
        };
        let n = 10_000;
        let mut expected = 0.0;
        for i in 0..n {
            let x = (f64::from(i) + 0.5) / f64::from(n);
            expected += ((2.0 * x - 1.0) * RADIUS).powi(2) * window(x) / 0.35875 / f64::from(n);
        }
        let filter = Filter::new();
        let m = 10_000;
        let measured =
            (0..m).map(|i| filter.offset((f64::from(i) + 0.5) / f64::from(m)).powi(2)).sum::<f64>()
                / f64::from(m);
        assert!((measured - expected).abs() < 5e-3 * expected, "{measured} {expected}");
    }
}

//! Weighted least squares: light as a linear function of features.
//!
//! With features x as differences from the pixel in the middle, light y and weights w, the slopes b solve
//!
//! ```text
//! (sum w (x - X)(x - X)^T + RIDGE v / Y^2) b = sum w (x - X)(y - Y),
//! ```
//!
//! X and Y being the weighted means; the light in the middle is Y - b X. What is added to the diagonal is the belief, in the sense of Bayes, that slopes are not
//! much larger than the light Y itself, against noise of variance v: where features hardly vary and can tell nothing, they are left out of account.

/// How many features there are.
pub(super) const FEATURES: usize = 8;

/// The squared share of the light that slopes are believed not to exceed, inverted: a third.
const RIDGE: f64 = 10.0;
/// The square of the least light that slopes are compared with, where it is all but black.
const DARK: f64 = 1e-6;

type Features = [f32; FEATURES];

/// Sums over the pixels that count.
#[derive(Clone, Debug, Default)]
pub(super) struct Fit {
    weight: f32,
    variance: f32,
    light: [f32; 3],
    features: Features,
    squares: [Features; FEATURES],
    products: [Features; 3],
}

impl Fit {
    /// Another pixel.
    #[inline]
    pub(super) fn add(&mut self, w: f32, x: &Features, light: &[f32; 3], variance: &[f32; 3]) {
        self.weight += w;
        self.variance += w * (variance[0] + variance[1] + variance[2]);
        add(&mut self.features, w, x);
        for (row, v) in self.squares.iter_mut().zip(x) {
            add(row, w * v, x);
        }
        for ((sum, products), v) in self.light.iter_mut().zip(&mut self.products).zip(light) {
            *sum += w * v;
            add(products, w * v, x);
        }
    }

    /// The light in the middle; black if nothing counts.
    pub(super) fn center(&self) -> [f32; 3] {
        if !(self.weight > 0.0) {
            return [0.0; 3];
        }
        let weight = f64::from(self.weight);
        let mean = self.features.map(|v| f64::from(v) / weight);
        let light = self.light.map(|v| f64::from(v) / weight);
        let brightness = (light[0] + light[1] + light[2]) / 3.0;
        let variance = f64::from(self.variance) / (3.0 * weight);
        let ridge = RIDGE * variance / (brightness * brightness + DARK);
        // Rounding of the sums, of numbers up to 1, in f32.
        let least = weight * f64::from(f32::EPSILON) * 16.0;
        let mut matrix = [[0.0; FEATURES]; FEATURES];
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, v) in row.iter_mut().enumerate() {
                *v = f64::from(self.squares[i][j]) - weight * mean[i] * mean[j];
            }
            row[i] += ridge + least;
        }
        let root = cholesky(&matrix);
        core::array::from_fn(|c| {
            let product = |i: usize| f64::from(self.products[c][i]) - weight * mean[i] * light[c];
            let slopes = solve(&root, core::array::from_fn(product));
            let shift: f64 = slopes.iter().zip(mean).map(|(b, x)| b * x).sum();
            (light[c] - shift).max(0.0) as f32
        })
    }
}

#[inline]
fn add(sums: &mut Features, factor: f32, x: &Features) {
    for (sum, v) in sums.iter_mut().zip(x) {
        *sum += factor * v;
    }
}

type Square = [[f64; FEATURES]; FEATURES];

/// The lower triangular L with L L^T = `a`, which is symmetric and positive definite.
fn cholesky(a: &Square) -> Square {
    let mut l = [[0.0; FEATURES]; FEATURES];
    for i in 0..FEATURES {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = a[i][j] - sum;
            // Rounding may leave less than nothing on the diagonal.
            l[i][j] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / l[j][j] };
        }
    }
    l
}

/// The solution x of L L^T x = b.
fn solve(l: &Square, mut b: [f64; FEATURES]) -> [f64; FEATURES] {
    for i in 0..FEATURES {
        let sum: f64 = (0..i).map(|k| l[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i][i];
    }
    for i in (0..FEATURES).rev() {
        let sum: f64 = (i + 1..FEATURES).map(|k| l[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i][i];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The features of the `i`-th of many pixels, none a combination of the others.
    fn features(i: u32) -> Features {
        core::array::from_fn(|k| {
            let step = [7, 13, 29, 37, 53, 61, 83, 101][k];
            (i * step % 97) as f32 / 97.0 - 0.3
        })
    }

    #[test]
    fn linear_functions_are_found() {
        let slopes = [0.3, -0.2, 0.5, 0.1, -0.4, 0.2, 0.05, -0.1];
        let mut fit = Fit::default();
        for i in 0..300 {
            let x = features(i);
            let y = 2.0 + x.iter().zip(slopes).map(|(x, b)| x * b).sum::<f32>();
            fit.add(0.2 + (i % 5) as f32, &x, &[y, 2.0 * y, 0.5], &[0.0; 3]);
        }
        let center = fit.center();
        for (found, expected) in center.iter().zip([2.0, 4.0, 0.5]) {
            assert!((found - expected).abs() < 1e-3, "{center:?}");
        }
    }

    #[test]
    fn features_that_do_not_vary_say_nothing() {
        let mut fit = Fit::default();
        for i in 0..100 {
            let noise = if i % 2 == 0 { 0.5 } else { -0.5 };
            fit.add(1.0, &[1e-4 * (i % 3) as f32; 8], &[1.0 + noise; 3], &[0.25; 3]);
        }
        assert!(fit.center().iter().all(|v| (v - 1.0).abs() < 0.02), "{:?}", fit.center());
        assert_eq!(Fit::default().center(), [0.0; 3]);
    }
}

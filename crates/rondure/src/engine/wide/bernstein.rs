//! Polynomials in Bernstein form on [0, 1], for bounds: a polynomial lies between the least and the
//! greatest of its coefficients.

use arrayvec::ArrayVec;

/// The highest degree: the square of a cubic.
const DEGREE: usize = 6;

/// Coefficients, one more than the degree.
pub(super) type Polynomial = ArrayVec<f64, { DEGREE + 1 }>;

/// Binomial coefficients up to the highest degree.
const BINOMIALS: [[f64; DEGREE + 1]; DEGREE + 1] = {
    let mut rows = [[0.0; DEGREE + 1]; DEGREE + 1];
    let mut n = 0;
    while n <= DEGREE {
        rows[n][0] = 1.0;
        let mut k = 1;
        while k <= n {
            rows[n][k] = rows[n - 1][k - 1] + rows[n - 1][k];
            k += 1;
        }
        n += 1;
    }
    rows
};

/// c_k = sum over i + j = k of C(m, i) C(n, j) / C(m + n, k) a_i b_j.
pub(super) fn product(a: &[f64], b: &[f64]) -> Polynomial {
    let (m, n) = (a.len() - 1, b.len() - 1);
    let mut c: Polynomial = core::iter::repeat_n(0.0, m + n + 1).collect();
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            c[i + j] += BINOMIALS[m][i] * BINOMIALS[n][j] * (a * b);
        }
    }
    for (c, binomial) in c.iter_mut().zip(BINOMIALS[m + n]) {
        *c /= binomial;
    }
    c
}

/// The derivative.
pub(super) fn derivative(a: &[f64]) -> Polynomial {
    let degree = (a.len() - 1) as f64;
    a.windows(2).map(|pair| degree * (pair[1] - pair[0])).collect()
}

/// The value of a polynomial at arguments of its polar form, one for each degree: its coefficients on
/// [u, v] are those with more and more of them v instead of u.
pub(super) fn polar(a: &[f64], arguments: impl IntoIterator<Item = f64>) -> f64 {
    let mut b: Polynomial = a.iter().copied().collect();
    for u in arguments.into_iter().take(a.len() - 1) {
        for i in 0..b.len() - 1 {
            b[i] = (1.0 - u) * b[i] + u * b[i + 1];
        }
        b.pop();
    }
    b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(a: &[f64], u: f64) -> f64 {
        polar(a, core::iter::repeat(u))
    }

    #[test]
    fn products_and_derivatives_are_those_of_the_values() {
        let (a, b) = ([1.0, -2.0, 0.5, 3.0], [0.25, 4.0, -1.0, 2.0]);
        let (ab, slope) = (product(&a, &b), derivative(&a));
        for i in -4..=20 {
            let u = f64::from(i) / 16.0;
            assert!((value(&ab, u) - value(&a, u) * value(&b, u)).abs() < 1e-12);
            let h = 1.0 / 1024.0;
            let difference = (value(&a, u + h) - value(&a, u - h)) / (2.0 * h);
            assert!((value(&slope, u) - difference).abs() < 1e-4);
        }
        assert_eq!(derivative(&[3.0]).len(), 0);
    }
}

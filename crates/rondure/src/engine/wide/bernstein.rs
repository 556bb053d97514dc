//! Polynomials in Bernstein form on [0, 1], for bounds: a polynomial lies between the least and the
//! greatest of its coefficients.
//!
//! The number of coefficients, one more than the degree, is known to the compiler, which leaves no loop.

/// The highest degree: the square of a cubic.
const DEGREE: usize = 6;

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

/// c_k = sum over i + j = k of C(m, i) C(n, j) / C(m + n, k) a_i b_j, for a polynomial of degree m and one of degree n.
#[inline(always)]
pub(super) fn product<const C: usize>(
    (m, a): (usize, impl Fn(usize) -> f64),
    (n, b): (usize, impl Fn(usize) -> f64),
) -> [f64; C] {
    debug_assert_eq!(C, m + n + 1);
    let mut c = [0.0; C];
    for i in 0..=m {
        for j in 0..=n {
            c[i + j] += BINOMIALS[m][i] * BINOMIALS[n][j] * (a(i) * b(j));
        }
    }
    for (c, binomial) in c.iter_mut().zip(BINOMIALS[C - 1]) {
        *c /= binomial;
    }
    c
}

/// The degree of a polynomial, and its coefficients.
#[inline(always)]
pub(super) fn whole<const A: usize>(a: &[f64; A]) -> (usize, impl Fn(usize) -> f64 + '_) {
    (A - 1, |i| a[i])
}

/// The degree and the coefficients of the derivative of a polynomial that is no constant.
#[inline(always)]
pub(super) fn derivative<const A: usize>(a: &[f64; A]) -> (usize, impl Fn(usize) -> f64 + '_) {
    (A - 2, |i| (A - 1) as f64 * (a[i + 1] - a[i]))
}

/// The value of a polynomial at arguments of its polar form, one for each degree: its coefficients on
/// [u, v] are those with more and more of them v instead of u.
#[inline(always)]
pub(super) fn polar<const A: usize>(a: &[f64; A], arguments: impl Fn(usize) -> f64) -> f64 {
    let mut b = *a;
    for k in 1..A {
        let u = arguments(k - 1);
        for i in 0..A - k {
            b[i] = (1.0 - u) * b[i] + u * b[i + 1];
        }
    }
    b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value<const A: usize>(a: &[f64; A], u: f64) -> f64 {
        polar(a, |_| u)
    }

    #[test]
    fn products_and_derivatives_are_those_of_the_values() {
        let (a, b) = ([1.0, -2.0, 0.5, 3.0], [0.25, 4.0, -1.0, 2.0]);
        let ab: [f64; 7] = product(whole(&a), whole(&b));
        let (degree, slope) = derivative(&a);
        let slope: [f64; 3] = core::array::from_fn(slope);
        assert_eq!(degree, 2);
        for i in -4..=20 {
            let u = f64::from(i) / 16.0;
            assert!((value(&ab, u) - value(&a, u) * value(&b, u)).abs() < 1e-12);
            let h = 1.0 / 1024.0;
            let difference = (value(&a, u + h) - value(&a, u - h)) / (2.0 * h);
            assert!((value(&slope, u) - difference).abs() < 1e-4);
        }
    }
}

//! The root of a rising function, by Newton's method within a bracket.

use crate::numeric::UNIT_ROUNDOFF;

/// Halvings alone would end long before: an f64 bracket can be halved some 1100 times, but one of
/// ordinary numbers 64 times, and Newton's steps waste few.
const MOST_STEPS: u32 = 128;

/// Where a function that rises all through the bracket is zero, to rounding. `f` gives its value and
/// its derivative; `guess` lies in the bracket.
pub(super) fn bracketed_newton(
    f: impl Fn(f64) -> (f64, f64),
    [mut low, mut high]: [f64; 2],
    guess: f64,
) -> f64 {
    let mut x = guess;
    for _ in 0..MOST_STEPS {
        let (value, slope) = f(x);
        if value == 0.0 {
            return x;
        }
        if value < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= UNIT_ROUNDOFF * low.abs().max(high.abs()) {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_where_newton_alone_goes_astray() {
        let cube = bracketed_newton(|x| (x * x * x - 2.0, 3.0 * x * x), [0.0, 2.0], 0.01);
        assert!((cube - 2.0_f64.cbrt()).abs() < 1e-15);
        // Flat at the root, and everywhere but there.
        let flat = bracketed_newton(|x| (x.powi(3), 3.0 * x * x), [-1.0, 1.5], 1.0);
        assert!(flat.abs() < 1e-15, "{flat}");
        let steep = bracketed_newton(
            |x| ((1e6 * (x - 0.7)).tanh(), 1e6 / (1e6 * (x - 0.7)).cosh().powi(2)),
            [0.0, 1.0],
            0.1,
        );
        assert!((steep - 0.7).abs() < 1e-15, "{steep}");
    }
}

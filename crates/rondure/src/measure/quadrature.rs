//! Integrals along segments by Gauss-Legendre quadrature.
//!
//! Sixteen nodes integrate polynomials up to degree 31 exactly; the moments of a solid have degree
//! 14 at most on a cubic. On an arc of half-width h they are trigonometric polynomials of degree 5 in
//! the angle, for which the remainder (Davis and Rabinowitz, "Methods of Numerical Integration",
//! 2nd ed., formula 2.7.12)
//!
//! ```text
//! h^33 2^33 (16!)^4 / (33 (32!)^3) max|f^(32)|,   |f^(32)| <= 5^32 max|f|
//! ```
//!
//! is below 1e-24 of the integrand at h = 0.8. On a rational quadratic piece of such an arc, weight w >=
//! cos 0.8, the poles lie 1.18 beside the middle of [0, 1]: the rule converges as 4.9^-32. So all of
//! these are exact but for rounding. Speeds are not polynomials; they are integrated by bisection
//! until the two halves agree with the whole.

use crate::numeric::gamma;
use crate::piece::Jet;
use crate::profile::{Segment, monotone};

/// The positive nodes, and the weights, of the rule with 16 points on [-1, 1].
const NODES: [[f64; 2]; 8] = [
    [0.095_012_509_837_637_44, 0.189_450_610_455_068_5],
    [0.281_603_550_779_258_9, 0.182_603_415_044_923_58],
    [0.458_016_777_657_227_37, 0.169_156_519_395_002_54],
    [0.617_876_244_402_643_8, 0.149_595_988_816_576_74],
    [0.755_404_408_355_003, 0.124_628_971_255_533_88],
    [0.865_631_202_387_831_8, 0.095_158_511_682_492_79],
    [0.944_575_023_073_232_6, 0.062_253_523_938_647_894],
    [0.989_400_934_991_649_9, 0.027_152_459_411_754_096],
];

/// The longest stretch of an arc, in radians on its ellipse, for one application of the rule.
const LONGEST_STEP: f64 = 1.6;

/// How often a stretch is halved at most: its length is then below the rounding of the whole.
const DEEPEST: u32 = 50;

/// The rounding of one application of the rule: sixteen terms, and what goes into each.
const ROUNDING: f64 = gamma(32);

/// The integrals of N functions over a range, by 16 nodes.
pub(crate) fn gauss<const N: usize>(f: impl Fn(f64) -> [f64; N], range: [f64; 2]) -> [f64; N] {
    let (middle, half) = (0.5 * (range[0] + range[1]), 0.5 * (range[1] - range[0]));
    let mut sums = [0.0; N];
    for [x, weight] in NODES.iter().rev() {
        let (left, right) = (f(middle - half * x), f(middle + half * x));
        for i in 0..N {
            sums[i] += weight * (left[i] + right[i]);
        }
    }
    sums.map(|sum| half * sum)
}

/// The integrals of two functions that are nowhere negative, and bounds for their errors.
///
/// A stretch is halved until the halves differ from it by no more than rounding, in relation to the
/// integral over the whole range; what they differ by bounds the error of the halves amply, because
/// the rule converges geometrically on what is smooth and gains at least half on what is not.
pub(super) fn adaptive(f: impl Fn(f64) -> [f64; 2], range: [f64; 2]) -> [[f64; 2]; 2] {
    let whole = gauss(&f, range);
    let (mut sums, mut errors) = ([Sum::default(); 2], [0.0; 2]);
    let mut stack = vec![(range, whole, 0)];
    while let Some(([from, to], coarse, depth)) = stack.pop() {
        let middle = 0.5 * (from + to);
        let halves = [[from, middle], [middle, to]];
        let [left, right] = halves.map(|half| gauss(&f, half));
        let fine = [left[0] + right[0], left[1] + right[1]];
        let differences = [0, 1].map(|i| (fine[i] - coarse[i]).abs());
        if depth == DEEPEST || (0..2).all(|i| differences[i] <= ROUNDING * whole[i]) {
            for i in 0..2 {
                sums[i].add(fine[i]);
                errors[i] += differences[i];
            }
        } else {
            stack.extend([(halves[1], right, depth + 1), (halves[0], left, depth + 1)]);
        }
    }
    [sums.map(|sum| sum.value()), [0, 1].map(|i| errors[i] + ROUNDING * sums[i].value())]
}

/// A sum with its rounding carried along (Neumaier 1974): good to about one unit in the last place
/// of the sum of the terms' absolute values times u.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    pub(super) fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - sum) + term
        } else {
            (term - sum) + self.sum
        };
        self.sum = sum;
    }

    pub(super) fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// The point at s and the derivative by s, from differences of the control points.
pub(super) fn jet(segment: &Segment, s: f64) -> Jet {
    let u = 1.0 - s;
    let tangent = match segment {
        Segment::Line([a, b]) => *b - *a,
        Segment::Quadratic([a, b, c]) => ((*b - *a) * u + (*c - *b) * s) * 2.0,
        Segment::Cubic([a, b, c, d]) => {
            ((*b - *a) * (u * u) + (*c - *b) * (2.0 * u * s) + (*d - *c) * (s * s)) * 3.0
        }
        Segment::Arc(arc) => {
            let (sin, cos) = (arc.start_angle + s * arc.sweep_angle).sin_cos();
            arc.conjugate(-sin, cos) * arc.sweep_angle
        }
    };
    Jet { point: segment.point(s), tangent }
}

/// The ranges of s on which one application of the rule integrates moments exactly.
pub(super) fn steps(segment: &Segment) -> Vec<[f64; 2]> {
    split(segment, &[0.0, 1.0])
}

/// Such ranges on which neither r nor z turns, so that a cusp is an end.
pub(super) fn smooth_steps(segment: &Segment) -> Vec<[f64; 2]> {
    let mut knots = vec![0.0];
    knots.extend(monotone::turning_parameters_of_r(segment));
    knots.extend(monotone::turning_parameters_of_z(segment));
    knots.push(1.0);
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    split(segment, &knots)
}

fn split(segment: &Segment, knots: &[f64]) -> Vec<[f64; 2]> {
    let Segment::Arc(arc) = segment else {
        return knots.windows(2).map(|w| [w[0], w[1]]).collect();
    };
    let mut ranges = Vec::new();
    for w in knots.windows(2) {
        let width = w[1] - w[0];
        let count = (width * arc.sweep_angle.abs() / LONGEST_STEP).ceil().max(1.0) as u32;
        let knot = |i: u32| {
            if i == count { w[1] } else { w[0] + width * (f64::from(i) / f64::from(count)) }
        };
        ranges.extend((0..count).map(|i| [knot(i), knot(i + 1)]));
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::UNIT_ROUNDOFF;

    #[test]
    fn polynomials_to_degree_31_are_exact() {
        for degree in 0..32 {
            let [value] = gauss(|s| [s.powi(degree)], [0.0, 1.0]);
            let exact = 1.0 / f64::from(degree + 1);
            assert!((value - exact).abs() < 2.0 * UNIT_ROUNDOFF, "{degree}: {value}");
        }
        let [beyond] = gauss(|s| [s.powi(80)], [-1.0, 1.0]);
        assert!((beyond - 2.0 / 81.0).abs() > 1e-9);
    }

    #[test]
    fn trigonometric_polynomials_of_degree_5_are_exact_on_a_step() {
        for k in 1..=5 {
            let k = f64::from(k);
            let [value] = gauss(|a| [1.0 + (k * a).cos()], [0.3, 0.3 + LONGEST_STEP]);
            let exact = LONGEST_STEP
                + 2.0 / k * (k * (0.3 + 0.5 * LONGEST_STEP)).cos() * (0.5 * k * LONGEST_STEP).sin();
            assert!((value - exact).abs() < 1e-15, "{k}: {value} {exact}");
        }
    }

    #[test]
    fn kinks_are_integrated_within_the_bound_told() {
        let [value, error] = adaptive(|s| [(s - 0.3).abs(), s.sqrt()], [0.0, 1.0]);
        for (i, exact) in [0.29, 2.0 / 3.0].into_iter().enumerate() {
            assert!((value[i] - exact).abs() <= error[i], "{value:?} {error:?}");
            assert!(error[i] < 1e-14, "{error:?}");
        }
    }

    #[test]
    fn sums_keep_what_cancels() {
        let mut sum = Sum::default();
        for term in [1.0, 1e100, 1.0, -1e100] {
            sum.add(term);
        }
        assert_eq!(sum.value(), 2.0);
    }
}

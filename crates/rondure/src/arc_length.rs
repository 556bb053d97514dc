//! Arc length along the profile, from which the surface parameter v is made.
//!
//! A piece is cut into 1, 2, 4 or 8 stretches of equal length in s, as few as the quadrature of each needs to be exact but
//! for rounding. The length of the profile before every stretch is tabulated; what is left up to s is integrated when it is
//! asked for.

use arrayvec::ArrayVec;

use crate::measure::quadrature::gauss;
use crate::numeric::gamma;
use crate::piece::{Kind, Piece};

/// A piece has no more stretches than two to the power of this: on those of one that ends in a cusp the error is up to
/// some 1e-5 of its length.
const MOST_HALVINGS: u32 = 3;
/// The rounding of two integrals by sixteen nodes each, as a part of the length.
const ROUNDING: f64 = gamma(64);

/// The arc length of a profile, tabulated.
#[derive(Clone, Debug)]
pub(crate) struct ArcLengths {
    /// Before each stretch, and of all of them at the end.
    before: Vec<f64>,
}

/// The stretches of a piece: the number of the first one times four, and how often the piece was halved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretches(u32);

impl ArcLengths {
    pub(crate) fn new() -> Self {
        Self { before: vec![0.0] }
    }

    /// Tabulates the next piece of the profile.
    pub(crate) fn push(&mut self, piece: &Piece) -> Stretches {
        let first = self.before.len() as u32 - 1;
        let start = self.whole();
        let mut halvings = 0;
        let mut coarse = integral(piece, [0.0, 1.0]);
        self.before.push(start + coarse);
        while piece.kind != Kind::Line && halvings < MOST_HALVINGS {
            let count = 2 << halvings;
            let knot = |i: u32| f64::from(i) / f64::from(count);
            let mut fine = 0.0;
            let lengths = (0..count).map(|i| {
                fine += integral(piece, [knot(i), knot(i + 1)]);
                start + fine
            });
            let lengths: ArrayVec<f64, { 1 << MOST_HALVINGS }> = lengths.collect();
            let apart = (fine - coarse).abs();
            if apart <= ROUNDING * fine || !apart.is_finite() {
                break;
            }
            self.before.truncate(first as usize + 1);
            self.before.extend(lengths);
            (halvings, coarse) = (halvings + 1, fine);
        }
        Stretches(first << 2 | halvings)
    }

    /// The length of all that was tabulated.
    pub(crate) fn whole(&self) -> f64 {
        self.before.last().copied().unwrap_or_default()
    }

    /// The length of the profile from its beginning to s on a piece, which must be the one that was tabulated there.
    #[inline]
    pub(crate) fn until(&self, stretches: Stretches, piece: &Piece, s: f64) -> f64 {
        let (first, count) = (stretches.0 >> 2, 1_u32 << (stretches.0 & 3));
        let number = ((s * f64::from(count)) as u32).min(count);
        let from = f64::from(number) / f64::from(count);
        let length = self.before[(first + number) as usize] + integral(piece, [from, s]);
        length.min(self.before[(first + count) as usize])
    }

    pub(crate) fn shrink_to_fit(&mut self) {
        self.before.shrink_to_fit();
    }
}

/// The length of a piece.
pub(crate) fn length(piece: &Piece) -> f64 {
    let mut lengths = ArcLengths::new();
    lengths.push(piece);
    lengths.whole()
}

/// The length of a piece between two parameters, by one application of the rule.
#[inline]
fn integral(piece: &Piece, [from, to]: [f64; 2]) -> f64 {
    let (r, z) = (&piece.r, &piece.z);
    let steps = |i: usize, j: usize| [r[j] - r[i], z[j] - z[i]];
    // The derivative by s is that by powers of s over a square, or over 1.
    let times = |[r, z]: [f64; 2], by: f64| [r * by, z * by];
    let ([a, b, c], q) = match piece.kind {
        Kind::Line => {
            let [r, z] = steps(0, 3);
            return (to - from) * r.hypot(z);
        }
        Kind::Quadratic => {
            let (a, b) = (steps(0, 1), steps(1, 3));
            ([times(a, 2.0), times([b[0] - a[0], b[1] - a[1]], 2.0), [0.0; 2]], 0.0)
        }
        Kind::Cubic => {
            let (a, b, c) = (steps(0, 1), steps(1, 2), steps(2, 3));
            let bend = [b[0] - a[0], b[1] - a[1]];
            let turn = [(c[0] - b[0]) - bend[0], (c[1] - b[1]) - bend[1]];
            ([times(a, 3.0), times(bend, 6.0), times(turn, 3.0)], 0.0)
        }
        Kind::Conic(w) => {
            let (a, b, c) = (times(steps(0, 1), w), steps(0, 3), times(steps(1, 3), w));
            let bend = [b[0] - 2.0 * a[0], b[1] - 2.0 * a[1]];
            let turn = [(a[0] - b[0]) + c[0], (a[1] - b[1]) + c[1]];
            ([times(a, 2.0), times(bend, 2.0), times(turn, 2.0)], 2.0 * (w - 1.0))
        }
    };
    let tangent = |s: f64, i: usize| (c[i] * s + b[i]) * s + a[i];
    let speed = |s: f64| {
        let (r, z) = (tangent(s, 0), tangent(s, 1));
        (r * r + z * z).sqrt()
    };
    let [length] = if q == 0.0 {
        gauss(|s| [speed(s)], [from, to])
    } else {
        gauss(
            |s| {
                let below = 1.0 + q * (s * (1.0 - s));
                [speed(s) / (below * below)]
            },
            [from, to],
        )
    };
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Profile, piece};

    fn pieces(path: &str) -> Vec<Piece> {
        Profile::from_path_data(path).unwrap().segments().flat_map(piece::cut).collect()
    }

    #[test]
    fn arcs_have_their_length() {
        for p in pieces("M 0 -1 A 1 1 0 0 1 0 1") {
            let mut lengths = ArcLengths::new();
            let own = lengths.push(&p);
            for i in 0..=100 {
                let s = f64::from(i) / 100.0;
                let point = p.jet(s).point - p.start();
                let angle = 2.0 * (0.5 * point.length()).asin();
                assert!((lengths.until(own, &p, s) - angle).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_parabola_has_its_length() {
        let pieces = pieces("M 0 0 Q 0.5 0 1 1");
        let whole: f64 = pieces.iter().map(length).sum();
        let root = 5.0_f64.sqrt();
        assert!((whole - (root / 2.0 + (2.0 + root).ln() / 4.0)).abs() < 1e-14);
    }

    #[test]
    fn a_cusp_costs_little() {
        // r = s^2, z = s^3: the length is ((4 + 9 s^2)^(3/2) - 8) / 27.
        let [p] = pieces("M 0 0 C 0 0 0.333333333333333333 0 1 1")[..] else { panic!("one piece") };
        let exact = (13.0_f64.powf(1.5) - 8.0) / 27.0;
        assert!((length(&p) - exact).abs() < 1e-5 * exact);
    }
}

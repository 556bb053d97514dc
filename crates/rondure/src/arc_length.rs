//! Arc length along the profile, from which the surface parameter v is made.

use crate::piece::{Kind, Piece};

/// Nodes (the positive half) and weights of the Gauss-Legendre rule with 6 points on [-1, 1].
const NODES: [[f64; 2]; 3] = [
    [0.238_619_186_083_196_9, 0.467_913_934_572_691_04],
    [0.661_209_386_466_264_5, 0.360_761_573_048_138_6],
    [0.932_469_514_203_152, 0.171_324_492_379_170_36],
];

/// Into how many stretches, of equal length in s, a piece is divided.
const STRETCHES: usize = 8;

/// The arc length of a piece, tabulated.
///
/// On each eighth of a piece the length is integrated by six points: the error is about 1e-13 of a
/// smooth piece, and up to 1e-4 of one that ends in a cusp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArcLength {
    /// The arc length before each stretch, and that of the whole piece.
    before: [f64; STRETCHES + 1],
}

impl ArcLength {
    pub(crate) fn new(piece: &Piece) -> Self {
        let mut before = [0.0; STRETCHES + 1];
        for i in 0..STRETCHES {
            let knot = |i: usize| i as f64 / STRETCHES as f64;
            before[i + 1] = before[i] + integral(piece, knot(i), knot(i + 1));
        }
        Self { before }
    }

    /// The length of the piece.
    pub(crate) fn whole(&self) -> f64 {
        self.before[STRETCHES]
    }

    /// The length of the piece, which must be the one that was tabulated, from its start to s.
    pub(crate) fn until(&self, piece: &Piece, s: f64) -> f64 {
        let stretch = (s * STRETCHES as f64) as usize;
        let length = self.before[stretch.min(STRETCHES)]
            + integral(piece, stretch as f64 / STRETCHES as f64, s);
        length.min(self.whole())
    }
}

fn integral(piece: &Piece, from: f64, to: f64) -> f64 {
    if piece.kind == Kind::Line {
        return (to - from) * (piece.end() - piece.start()).length();
    }
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let speed = |x: f64| {
        let tangent = piece.jet(middle + half * x).tangent;
        (tangent.r * tangent.r + tangent.z * tangent.z).sqrt()
    };
    half * NODES.iter().map(|[x, weight]| weight * (speed(*x) + speed(-x))).sum::<f64>()
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
            let length = ArcLength::new(&p);
            for i in 0..=100 {
                let s = f64::from(i) / 100.0;
                let point = p.jet(s).point - p.start();
                let angle = 2.0 * (0.5 * point.length()).asin();
                assert!((length.until(&p, s) - angle).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_parabola_has_its_length() {
        let pieces = pieces("M 0 0 Q 0.5 0 1 1");
        let length: f64 = pieces.iter().map(|p| ArcLength::new(p).whole()).sum();
        let root = 5.0_f64.sqrt();
        assert!((length - (root / 2.0 + (2.0 + root).ln() / 4.0)).abs() < 1e-14);
    }

    #[test]
    fn a_cusp_costs_little() {
        // r = s^2, z = s^3: the length is ((4 + 9 s^2)^(3/2) - 8) / 27.
        let [p] = pieces("M 0 0 C 0 0 0.333333333333333333 0 1 1")[..] else { panic!("one piece") };
        let exact = (13.0_f64.powf(1.5) - 8.0) / 27.0;
        assert!((ArcLength::new(&p).whole() - exact).abs() < 1e-4 * exact);
    }
}

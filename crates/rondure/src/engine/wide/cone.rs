//! The range of a piece's slope in the plane (z, rho^2 / 2).
//!
//! Up to a positive factor the tangent (z', r r') is a polynomial in Bernstein form; with its
//! coefficients D_i it is a convex combination of them, so that all tangents lie in the cone that the
//! D_i span. As neither z nor r turns on a piece, they also lie in one quadrant.

use arrayvec::ArrayVec;

use crate::piece::{Kind, Piece};

/// The product of two cubics or less, by Bernstein coefficients.
type Product = ArrayVec<f64, 6>;

/// The least and the greatest slope r r' / z' of a piece's tangents, which has one sign or vanishes, or is
/// infinite where z stands still; coordinates are in units of `unit`.
pub(super) fn slope_range(piece: &Piece, unit: f64) -> [f64; 2] {
    let (z, r) = (piece.z.map(|z| z * unit), piece.r.map(|r| r * unit));
    let [dz, dr] = [&z, &r].map(|c| derivative(piece.kind, c));
    // One more factor on the side of z brings both to the same denominator and degree.
    let (radii, ones) = homogeneous(piece.kind, &r);
    let (along, outward) = (product(&dz, &ones), product(&dr, &radii));
    let (rising, growing) = (z[3] >= z[0], r[3] >= r[0]);
    let into = |v: f64, positive: bool| if positive { v.max(0.0) } else { (-v).max(0.0) };
    let steepness = |(&a, &b): (&f64, &f64)| {
        let (a, b) = (into(a, rising), into(b, growing));
        // A coefficient that vanishes has no direction.
        (a > 0.0 || b > 0.0).then_some(b / a)
    };
    let (least, greatest) = along
        .iter()
        .zip(&outward)
        .filter_map(steepness)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), m| (low.min(m), high.max(m)));
    if rising == growing { [least, greatest] } else { [-greatest, -least] }
}

/// The Bernstein coefficients of the derivative's numerator, up to a positive factor.
fn derivative(kind: Kind, c: &[f64; 4]) -> ArrayVec<f64, 3> {
    match kind {
        Kind::Line => [c[3] - c[0]].into_iter().collect(),
        Kind::Quadratic => [c[1] - c[0], c[3] - c[1]].into_iter().collect(),
        Kind::Cubic => [c[1] - c[0], c[2] - c[1], c[3] - c[2]].into(),
        Kind::Conic(w) => [w * (c[1] - c[0]), 0.5 * (c[3] - c[0]), w * (c[3] - c[1])].into(),
    }
}

/// The Bernstein coefficients of a coordinate's numerator and of its denominator.
fn homogeneous(kind: Kind, c: &[f64; 4]) -> (ArrayVec<f64, 4>, ArrayVec<f64, 4>) {
    let plain = |c: &[f64]| {
        (c.iter().copied().collect::<ArrayVec<f64, 4>>(), c.iter().map(|_| 1.0).collect())
    };
    match kind {
        Kind::Line => plain(&[c[0], c[3]]),
        Kind::Quadratic => plain(&[c[0], c[1], c[3]]),
        Kind::Cubic => plain(c),
        Kind::Conic(w) => {
            ([c[0], w * c[1], c[3]].into_iter().collect(), [1.0, w, 1.0].into_iter().collect())
        }
    }
}

/// c_k = sum over i + j = k of C(m, i) C(n, j) / C(m + n, k) a_i b_j.
fn product(a: &[f64], b: &[f64]) -> Product {
    let (m, n) = (a.len() - 1, b.len() - 1);
    let mut c: Product = core::iter::repeat_n(0.0, m + n + 1).collect();
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            c[i + j] += binomial(m, i) * binomial(n, j) / binomial(m + n, i + j) * (a * b);
        }
    }
    c
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Profile, piece};

    #[test]
    fn slopes_stay_in_their_range() {
        for path in [
            "M 0 0 Q 1.5 0.2 1.6 1 C 1.5 2 1.2 2.5 1 4 A 1 2 10 0 0 0.5 5 L 0.2 6",
            "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z",
            include_str!("../../../../../profiles/goblet.path"),
            include_str!("../../../../../profiles/column.path"),
        ] {
            let pieces: Vec<_> =
                Profile::from_path_data(path).unwrap().segments().flat_map(piece::cut).collect();
            for piece in pieces {
                let [low, high] = slope_range(&piece, 1.0);
                for i in 0..=100 {
                    let jet = piece.jet(f64::from(i) / 100.0);
                    // Cuts are rounded, so that a derivative may end beyond its zero.
                    let (a, b) = (jet.tangent.z.abs(), jet.point.r * jet.tangent.r.abs());
                    let (low, high) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
                    let room = |m: f64| 1e-14 * (1.0 + m);
                    assert!(low == f64::INFINITY || b >= low * a - room(low), "{piece:?} {i}");
                    assert!(high == f64::INFINITY || b <= high * a + room(high), "{piece:?} {i}");
                }
            }
        }
    }
}

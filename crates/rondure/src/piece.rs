//! A piece: a stretch of a segment on which neither r nor z turns, with a parameter s from 0 to 1.
//!
//! Every piece is a Bézier curve with at most four control points; an arc of an ellipse is a
//! rational quadratic one with the weights 1, w, 1. Pieces that meet share the coordinates of their
//! joint bit for bit: all decisions about which piece a ray crosses rest on that.

use crate::profile::{Arc, Point, Segment, monotone};

/// The degree of a piece and the kind of its parametrisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Line,
    Quadratic,
    Cubic,
    /// A rational quadratic whose middle control point has this weight.
    Conic(f64),
}

/// A stretch of a segment on which neither r nor z turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) kind: Kind,
    /// The control radii; those beyond the degree repeat the last one.
    pub(crate) r: [f64; 4],
    /// The control heights, likewise.
    pub(crate) z: [f64; 4],
}

/// A point of a piece and the derivative by its parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet {
    pub(crate) point: Point,
    pub(crate) tangent: Point,
}

impl Piece {
    fn new(kind: Kind, controls: [Point; 4]) -> Self {
        Self { kind, r: controls.map(|p| p.r), z: controls.map(|p| p.z) }
    }

    pub(crate) fn start(&self) -> Point {
        Point::new(self.r[0], self.z[0])
    }

    pub(crate) fn end(&self) -> Point {
        Point::new(self.r[3], self.z[3])
    }

    /// The point at s and the derivative by s, exact at s = 0 and s = 1.
    #[inline]
    pub(crate) fn jet(&self, s: f64) -> Jet {
        let (r, dr) = self.coordinate(&self.r, s);
        let (z, dz) = self.coordinate(&self.z, s);
        Jet { point: Point::new(r, z), tangent: Point::new(dr, dz) }
    }

    /// The value and the derivative at s of the coordinate (or any affine function of the
    /// coordinates) that has the given control values.
    #[inline(always)]
    pub(crate) fn coordinate(&self, c: &[f64; 4], s: f64) -> (f64, f64) {
        let u = 1.0 - s;
        match self.kind {
            Kind::Line => (u * c[0] + s * c[3], c[3] - c[0]),
            Kind::Quadratic => {
                let (left, right) = (u * c[0] + s * c[1], u * c[1] + s * c[3]);
                (u * left + s * right, 2.0 * (right - left))
            }
            Kind::Cubic => {
                let middle = u * c[1] + s * c[2];
                let left = u * (u * c[0] + s * c[1]) + s * middle;
                let right = u * middle + s * (u * c[2] + s * c[3]);
                (u * left + s * right, 3.0 * (right - left))
            }
            Kind::Conic(w) => {
                // Numerator and denominator of the quotient, and their halved derivatives.
                let (left, right) = (u * c[0] + s * w * c[1], u * w * c[1] + s * c[3]);
                let (left_q, right_q) = (u + s * w, u * w + s);
                let (p, q) = (u * left + s * right, u * left_q + s * right_q);
                let value = p / q;
                (value, 2.0 * ((right - left) - value * (right_q - left_q)) / q)
            }
        }
    }

    /// The smallest and the largest value on the piece of the affine function of the coordinates
    /// that has the given control values.
    pub(crate) fn range(&self, c: &[f64; 4]) -> (f64, f64) {
        // The coefficients of the derivative, as a quadratic A u^2 + B u s + C s^2.
        let [qa, qb, qc] = match self.kind {
            Kind::Line => [0.0; 3],
            Kind::Quadratic => {
                let (a, c) = (c[1] - c[0], c[3] - c[1]);
                [a, a + c, c]
            }
            Kind::Cubic => [c[1] - c[0], 2.0 * (c[2] - c[1]), c[3] - c[2]],
            Kind::Conic(w) => [w * (c[1] - c[0]), c[3] - c[0], w * (c[3] - c[1])],
        };
        let mut range = (c[0].min(c[3]), c[0].max(c[3]));
        for s in kurbo::common::solve_quadratic(qa, qb - 2.0 * qa, (qa - qb) + qc) {
            if 0.0 < s && s < 1.0 {
                let value = self.coordinate(c, s).0;
                range = (range.0.min(value), range.1.max(value));
            }
        }
        range
    }

    /// The two halves of the piece, split at s = 1/2.
    pub(crate) fn halves(&self) -> [Self; 2] {
        let mean = |a: Point, b: Point| a.lerp(b, 0.5);
        let [a, b, c, d] = core::array::from_fn(|i| Point::new(self.r[i], self.z[i]));
        match self.kind {
            Kind::Line => {
                let m = mean(a, d);
                [Self::new(Kind::Line, [a, m, m, m]), Self::new(Kind::Line, [m, d, d, d])]
            }
            Kind::Quadratic => {
                let (left, right) = (mean(a, b), mean(b, d));
                let m = mean(left, right);
                [
                    Self::new(Kind::Quadratic, [a, left, m, m]),
                    Self::new(Kind::Quadratic, [m, right, d, d]),
                ]
            }
            Kind::Cubic => {
                let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
                let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
                let m = mean(abc, bcd);
                [Self::new(Kind::Cubic, [a, ab, abc, m]), Self::new(Kind::Cubic, [m, bcd, cd, d])]
            }
            Kind::Conic(w) => {
                // De Casteljau in homogeneous coordinates, brought back to end weights 1.
                let shrink = 1.0 / (1.0 + w);
                let (left, right) = ((a + b * w) * shrink, (b * w + d) * shrink);
                let m = mean(left, right);
                let half = Kind::Conic((0.5 * (1.0 + w)).sqrt());
                [Self::new(half, [a, left, m, m]), Self::new(half, [m, right, d, d])]
            }
        }
    }
}

/// Cuts a segment where r or z turns; its two ends stay as they are, bit for bit.
///
/// A segment without extent has no pieces.
pub(crate) fn cut(segment: &Segment) -> Vec<Piece> {
    if segment.is_point() {
        return Vec::new();
    }
    let mut parameters = monotone::turning_parameters_of_r(segment);
    parameters.extend(monotone::turning_parameters_of_z(segment));
    parameters.sort_by(f64::total_cmp);
    parameters.dedup();
    if let Segment::Arc(arc) = segment {
        parameters = with_short_steps(arc, &parameters);
    }
    parameters.push(1.0);
    let mut pieces = Vec::with_capacity(parameters.len());
    let (mut s0, mut start) = (0.0, segment.start());
    for s1 in parameters {
        let mut end = if s1 == 1.0 { segment.end() } else { segment.point(s1) };
        // Rounding may carry a point of contact with the axis beyond it (see the builder's checks).
        end.r = end.r.max(0.0);
        // Neither r nor z turns between the ends: what ends where it began is a point, however its control points are
        // rounded.
        if end != start {
            pieces.push(stretch(segment, [s0, s1], [start, end]));
            start = end;
        }
        s0 = s1;
    }
    pieces
}

/// Adds cuts so that no stretch of an arc is much longer than a quarter of its ellipse, which keeps
/// the weight cos(half the angle) of its middle control point well away from zero.
fn with_short_steps(arc: &Arc, parameters: &[f64]) -> Vec<f64> {
    const LONGEST: f64 = 1.6;
    let mut cuts = Vec::new();
    let mut s0 = 0.0;
    for &s1 in parameters.iter().chain([&1.0]) {
        let steps = ((s1 - s0) * arc.sweep_angle.abs() / LONGEST).ceil().max(1.0);
        let inner = (1..steps as u32).map(|i| s0 + (s1 - s0) * f64::from(i) / steps);
        cuts.extend(inner);
        cuts.push(s1);
        s0 = s1;
    }
    cuts.pop();
    cuts
}

/// The stretch of a segment between two parameters, with its ends given.
fn stretch(segment: &Segment, [s0, s1]: [f64; 2], [start, end]: [Point; 2]) -> Piece {
    if s0 == 0.0 && s1 == 1.0 {
        match segment {
            Segment::Line([a, b]) => return Piece::new(Kind::Line, [*a, *b, *b, *b]),
            Segment::Quadratic([a, b, c]) => return Piece::new(Kind::Quadratic, [*a, *b, *c, *c]),
            Segment::Cubic(controls) => return Piece::new(Kind::Cubic, *controls),
            Segment::Arc(_) => {}
        }
    }
    match segment {
        Segment::Line(_) => Piece::new(Kind::Line, [start, end, end, end]),
        Segment::Quadratic([a, b, c]) => {
            let middle = a.lerp(*b, s0).lerp(b.lerp(*c, s0), s1);
            Piece::new(Kind::Quadratic, [start, middle, end, end])
        }
        Segment::Cubic([a, b, c, d]) => {
            // The blossom at (s0, s0, s1) and (s0, s1, s1).
            let (ab, bc, cd) = (a.lerp(*b, s0), b.lerp(*c, s0), c.lerp(*d, s0));
            let first = ab.lerp(bc, s0).lerp(bc.lerp(cd, s0), s1);
            let (ab1, bc1) = (ab.lerp(bc, s1), bc.lerp(cd, s1));
            let second = ab1.lerp(bc1, s1);
            Piece::new(Kind::Cubic, [start, first, second, end])
        }
        Segment::Arc(arc) => {
            // The tangents at both ends meet beyond the middle of the chord, along the radius.
            let half = 0.5 * (s1 - s0) * arc.sweep_angle;
            let (sin, cos) = (arc.start_angle + 0.5 * (s0 + s1) * arc.sweep_angle).sin_cos();
            let (beyond, weight) = (half.sin() * half.tan(), half.cos());
            let middle = start.lerp(end, 0.5) + arc.conjugate(beyond * cos, beyond * sin);
            Piece::new(Kind::Conic(weight), [start, middle, end, end])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    fn pieces(path: &str) -> Vec<Piece> {
        Profile::from_path_data(path).unwrap().segments().flat_map(cut).collect()
    }

    #[test]
    fn pieces_are_monotone_and_joined() {
        for path in [
            "M 0 -1 A 1 1 0 0 1 0 1",
            "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z",
            "M 3 0 A 1 0.4 33 1 0 3.2 0.7 Z",
            "M 0 0 C 0.24 0.1 0.34 0.25 0.32 0.42 C 3 -0.59 -0.13 3.64 0.12 0.78 Q 2 1 0.1 1.2",
        ] {
            let pieces = pieces(path);
            for pair in pieces.windows(2) {
                assert_eq!(pair[0].end(), pair[1].start());
            }
            for piece in &pieces {
                let mut last = piece.start();
                let rising = (piece.end().r >= last.r, piece.end().z >= last.z);
                for i in 1..=1000 {
                    let p = piece.jet(f64::from(i) / 1000.0).point;
                    let step = p - last;
                    assert!(if rising.0 { step.r >= -1e-15 } else { step.r <= 1e-15 }, "{path}");
                    assert!(if rising.1 { step.z >= -1e-15 } else { step.z <= 1e-15 }, "{path}");
                    last = p;
                }
            }
        }
    }

    #[test]
    fn conics_lie_on_their_circle() {
        for piece in pieces("M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z") {
            for half in piece.halves() {
                for i in 0..=100 {
                    let p = half.jet(f64::from(i) / 100.0).point;
                    assert!(((p.r - 2.0).hypot(p.z) - 1.0).abs() < 2e-15);
                }
            }
        }
    }

    #[test]
    fn jets_agree_with_differences_and_halves_with_the_whole() {
        for piece in pieces("M 0 0 L 1 0 Q 1.5 0.2 1.6 1 C 1.5 2 1.2 2.5 1 4 A 1 2 10 0 0 0.5 5") {
            for s in [0.1, 0.37, 0.8] {
                let h = 1e-6;
                let difference = (piece.jet(s + h).point - piece.jet(s - h).point) * (0.5 / h);
                assert!((difference - piece.jet(s).tangent).length() < 1e-8);
            }
            let [left, right] = piece.halves();
            assert_eq!(left.end(), right.start());
            let middle = piece.jet(0.5).point;
            assert!((left.end() - middle).length() < 1e-15);
            if !matches!(piece.kind, Kind::Conic(_)) {
                assert!((left.jet(0.5).point - piece.jet(0.25).point).length() < 1e-15);
                assert!((right.jet(0.5).point - piece.jet(0.75).point).length() < 1e-15);
            }
        }
    }

    #[test]
    fn ranges_hold_every_point() {
        for piece in pieces("M 0 0 Q 1.5 0.2 1.6 1 C 1.5 2 1.2 2.5 1 4 A 1 2 10 0 0 0.5 5") {
            let values = core::array::from_fn(|i| piece.r[i] - 0.7 * piece.z[i]);
            let (low, high) = piece.range(&values);
            let mut reached = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..=1000 {
                let v = piece.coordinate(&values, f64::from(i) / 1000.0).0;
                assert!(low - 1e-15 <= v && v <= high + 1e-15);
                reached = (reached.0.min(v), reached.1.max(v));
            }
            assert!(reached.0 - low < 1e-5 && high - reached.1 < 1e-5);
        }
    }
}

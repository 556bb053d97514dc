//! Affine maps of the half plane, which bring a drawing to its place, with a bound for their
//! rounding.
//!
//! Beside the matrix runs the same product with every term's absolute value, the magnitude: what
//! cancels in the matrix does not cancel there, and rounding is a multiple of it (Higham, sections
//! 3.1 and 3.5: |fl(AB) - AB| <= gamma(n) |A| |B|).

use super::{Arc, Point, Segment};
use crate::numeric::gamma;

/// An affine map of the plane: r' = a r + c z + e, z' = b r + d z + f, as in SVG's `matrix(a b c d e
/// f)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneMap {
    matrix: [f64; 6],
    magnitude: [f64; 6],
    /// The rounded operations that an entry has gone through.
    operations: u32,
}

impl PlaneMap {
    /// The map that leaves everything where it is.
    pub const IDENTITY: Self = Self::new([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

    /// The map with the matrix [a, b, c, d, e, f].
    pub const fn new(matrix: [f64; 6]) -> Self {
        let mut magnitude = matrix;
        let mut i = 0;
        while i < 6 {
            magnitude[i] = matrix[i].abs();
            i += 1;
        }
        // One for reading each entry from decimals.
        Self { matrix, magnitude, operations: 1 }
    }

    /// A shift.
    pub const fn translate(r: f64, z: f64) -> Self {
        Self::new([1.0, 0.0, 0.0, 1.0, r, z])
    }

    /// A stretch along both axes.
    pub const fn scale(r: f64, z: f64) -> Self {
        Self::new([r, 0.0, 0.0, z, 0.0, 0.0])
    }

    /// A turn from r towards z, in degrees; quarter turns are exact.
    pub fn rotate_degrees(angle: f64) -> Self {
        // Both steps are exact: fmod is, and so is the difference to the nearest quarter.
        let angle = angle % 360.0;
        let quarters = (angle / 90.0).round();
        let (sin, cos) = (angle - 90.0 * quarters).to_radians().sin_cos();
        let (sin, cos) = match quarters.rem_euclid(4.0) {
            1.0 => (cos, -sin),
            2.0 => (-sin, -cos),
            3.0 => (-cos, sin),
            _ => (sin, cos),
        };
        // Reading, conversion to radians (two), sine or cosine of at most 45 degrees.
        Self { operations: 5, ..Self::new([cos, sin, -sin, cos, 0.0, 0.0]) }
    }

    /// SVG's `skewX`: r' = r + z tan(angle), in degrees.
    pub fn skew_r_degrees(angle: f64) -> Self {
        let (tangent, magnitude) = tangent(angle);
        let mut map = Self::new([1.0, 0.0, tangent, 1.0, 0.0, 0.0]);
        map.magnitude[2] = magnitude;
        Self { operations: 5, ..map }
    }

    /// SVG's `skewY`: z' = z + r tan(angle), in degrees.
    pub fn skew_z_degrees(angle: f64) -> Self {
        let (tangent, magnitude) = tangent(angle);
        let mut map = Self::new([1.0, tangent, 0.0, 1.0, 0.0, 0.0]);
        map.magnitude[1] = magnitude;
        Self { operations: 5, ..map }
    }

    /// The map "first `inner`, then this one".
    #[must_use]
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            matrix: product(&self.matrix, &inner.matrix),
            magnitude: product(&self.magnitude, &inner.magnitude),
            operations: self.operations.saturating_add(inner.operations).saturating_add(3),
        }
    }

    /// The matrix [a, b, c, d, e, f].
    pub fn matrix(&self) -> [f64; 6] {
        self.matrix
    }

    /// The determinant: the factor by which areas grow, negative if the map mirrors.
    pub fn determinant(&self) -> f64 {
        let [a, b, c, d, ..] = self.matrix;
        crate::numeric::difference_of_products(a, d, b, c)
    }

    /// The image of a point.
    #[inline]
    pub fn point(&self, p: Point) -> Point {
        let [a, b, c, d, e, f] = self.matrix;
        Point::new(a * p.r + c * p.z + e, b * p.r + d * p.z + f)
    }

    /// A bound for the rounding error of the image's r, for points with coordinates up to those of
    /// `reach` in absolute value that have themselves gone through `operations` roundings.
    pub fn rounding_of_r(&self, reach: Point, operations: u32) -> f64 {
        let [a, _, c, _, e, _] = self.magnitude;
        let operations = self.operations.saturating_add(operations).saturating_add(3);
        gamma(operations) * (a * reach.r + c * reach.z + e)
    }

    /// The image of a segment: of the same kind, with the same parameter.
    pub fn segment(&self, segment: &Segment) -> Segment {
        match segment {
            Segment::Line(p) => Segment::Line(p.map(|p| self.point(p))),
            Segment::Quadratic(p) => Segment::Quadratic(p.map(|p| self.point(p))),
            Segment::Cubic(p) => Segment::Cubic(p.map(|p| self.point(p))),
            Segment::Arc(arc) => self.arc(arc),
        }
    }

    /// The image of an arc. With L the linear part and T the arc's own map from the unit circle,
    /// the singular value decomposition L T = U S V gives the image's axes S, their rotation U, and
    /// V, by which the angles on the ellipse move. A map that flattens the plane makes a line of it.
    fn arc(&self, arc: &Arc) -> Segment {
        let [a, b, c, d, ..] = self.matrix;
        let [x, y] = arc.radii;
        let (start, end) = (self.point(arc.start), self.point(arc.end));
        let center = self.point(arc.center);
        let linear = |p: Point| Point::new(a * p.r + c * p.z, b * p.r + d * p.z);
        let mirrored = self.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let similar = a.abs() == d.abs() && b.abs() == c.abs() && a * c + b * d == 0.0;
        let circle = similar && x == y;
        let (radii, rotation, turn) = if circle {
            let size = a.hypot(b);
            ([x * size, x * size], 0.0, b.atan2(a))
        } else if b == 0.0 && c == 0.0 && arc.rotation == 0.0 {
            // Exact where the axes stay the axes: V is a turn by nothing or by half a circle.
            let turn = if a < 0.0 { core::f64::consts::PI } else { 0.0 };
            ([x * a.abs(), y * d.abs()], 0.0, turn)
        } else {
            let (u, v) = (linear(arc.conjugate(1.0, 0.0)), linear(arc.conjugate(0.0, 1.0)));
            singular_values(u, v)
        };
        if radii.contains(&0.0) {
            return Segment::Line([start, end]);
        }
        Segment::Arc(Arc {
            start,
            end,
            center,
            radii,
            rotation,
            start_angle: turn + sign * arc.start_angle,
            sweep_angle: sign * arc.sweep_angle,
        })
    }
}

/// The matrix with the columns u and v as a turn by `rotation` after a stretch by `radii` after a
/// turn by `turn` (of the mirrored plane, if the determinant is negative): (radii, rotation, turn).
fn singular_values(u: Point, v: Point) -> ([f64; 2], f64, f64) {
    // The matrix is the sum of a turn and stretch (p) and a mirrored one (q), as complex numbers.
    let p = Point::new(u.r + v.z, u.z - v.r) * 0.5;
    let q = Point::new(u.r - v.z, u.z + v.r) * 0.5;
    let (p_length, q_length) = (p.length(), q.length());
    let (p_angle, q_angle) = (p.z.atan2(p.r), q.z.atan2(q.r));
    let rotation = 0.5 * (q_angle + p_angle);
    let turn = 0.5 * (p_angle - q_angle);
    let mirrored = q_length > p_length;
    let turn = if mirrored { -turn } else { turn };
    // |det| / the larger one is the smaller one, without the cancellation of p - q.
    let large = p_length + q_length;
    let small = crate::numeric::difference_of_products(u.r, v.z, u.z, v.r).abs() / large;
    ([large, if large == 0.0 { 0.0 } else { small }], rotation, turn)
}

/// tan(angle) in degrees, and its magnitude: an error of a relative size x in the angle t moves it
/// by x t / cos(t)^2.
fn tangent(angle: f64) -> (f64, f64) {
    let angle = angle.to_radians();
    let tangent = angle.tan();
    (tangent, tangent.abs() + angle.abs() * (1.0 + tangent * tangent))
}

/// The 2 x 3 matrix of "first n, then m".
fn product(m: &[f64; 6], n: &[f64; 6]) -> [f64; 6] {
    [
        m[0] * n[0] + m[2] * n[1],
        m[1] * n[0] + m[3] * n[1],
        m[0] * n[2] + m[2] * n[3],
        m[1] * n[2] + m[3] * n[3],
        m[0] * n[4] + m[2] * n[5] + m[4],
        m[1] * n[4] + m[3] * n[5] + m[5],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn same_curve(map: &PlaneMap, arc: &Arc, tolerance: f64) -> Result<(), TestCaseError> {
        let image = map.segment(&Segment::Arc(*arc));
        for i in 0..=16 {
            let s = f64::from(i) / 16.0;
            let (expected, found) = (map.point(arc.point(s)), image.point(s));
            prop_assert!(
                (expected - found).length() <= tolerance,
                "{expected:?} {found:?} at {s}: {image:?}"
            );
        }
        Ok(())
    }

    #[test]
    fn quarter_turns_are_exact() {
        for (angle, expected) in [
            (90.0, [0.0, 1.0, -1.0, 0.0]),
            (-90.0, [0.0, -1.0, 1.0, 0.0]),
            (180.0, [-1.0, 0.0, 0.0, -1.0]),
            (450.0, [0.0, 1.0, -1.0, 0.0]),
            (-720.0, [1.0, 0.0, 0.0, 1.0]),
        ] {
            assert_eq!(PlaneMap::rotate_degrees(angle).matrix()[..4], expected, "{angle}");
        }
    }

    #[test]
    fn circles_stay_circles_under_similarities() {
        let arc = Arc::from_endpoints(
            Point::new(0.0, -1.0),
            Point::new(0.0, 1.0),
            [1.0; 2],
            0.0,
            true,
            true,
        )
        .unwrap();
        for map in [
            PlaneMap::scale(2.0, -2.0),
            PlaneMap::scale(-2.0, 2.0),
            PlaneMap::rotate_degrees(90.0).after(&PlaneMap::scale(2.0, 2.0)),
        ] {
            let Segment::Arc(image) = map.segment(&Segment::Arc(arc)) else { panic!("no arc") };
            assert_eq!((image.radii, image.rotation), ([2.0, 2.0], 0.0));
            same_curve(&map, &arc, 1e-15 * 4.0).unwrap();
        }
    }

    #[test]
    fn flattened_arcs_are_lines() {
        let arc = Arc::from_endpoints(
            Point::new(1.0, -1.0),
            Point::new(1.0, 1.0),
            [3.0, 2.0],
            0.4,
            true,
            true,
        )
        .unwrap();
        let line = PlaneMap::scale(0.0, 1.0).segment(&Segment::Arc(arc));
        assert!(matches!(line, Segment::Line(_)), "{line:?}");
    }

    proptest! {
        #[test]
        fn arcs_under_any_map(
            matrix in prop::array::uniform6(-3.0..3.0_f64),
            ends in prop::array::uniform4(-5.0..5.0_f64),
            radii in prop::array::uniform2(0.1..9.0_f64),
            rotation in -3.0..3.0_f64,
            (large, sweep) in (any::<bool>(), any::<bool>()),
        ) {
            let [r, z, end_r, end_z] = ends;
            let (start, end) = (Point::new(r, z), Point::new(end_r, end_z));
            let arc = Arc::from_endpoints(start, end, radii, rotation, large, sweep).unwrap();
            let map = PlaneMap::new(matrix);
            prop_assume!(map.determinant().abs() > 1e-3);
            // The centre and the radii of a shallow arc are ill-conditioned; both curves share them.
            let size = arc.center.length() + arc.radii[0] + arc.radii[1];
            same_curve(&map, &arc, 1e-13 * size * 10.0)?;
        }

        #[test]
        fn products_and_points_agree_with_kurbo(
            outer in prop::array::uniform6(-3.0..3.0_f64),
            inner in prop::array::uniform6(-3.0..3.0_f64),
            angle in -720.0..720.0_f64,
            (r, z) in (-9.0..9.0_f64, -9.0..9.0_f64),
        ) {
            let turned = PlaneMap::rotate_degrees(angle).after(&PlaneMap::new(inner));
            let found = PlaneMap::new(outer).after(&turned).point(Point::new(r, z));
            let expected = kurbo::Affine::new(outer)
                * kurbo::Affine::rotate(angle.to_radians())
                * kurbo::Affine::new(inner)
                * kurbo::Point::new(r, z);
            prop_assert!((found.r - expected.x).abs() < 1e-12 && (found.z - expected.y).abs() < 1e-12);
        }

        #[test]
        fn points_on_the_axis_land_there_within_the_bound(
            angles in prop::collection::vec(-360.0..360.0_f64, 1..6),
            shift in -1e6..1e6_f64,
            z in -1e3..1e3_f64,
        ) {
            // There and back again: the exact map is the identity.
            let mut map = PlaneMap::IDENTITY;
            for angle in &angles {
                map = map.after(&PlaneMap::rotate_degrees(*angle)).after(&PlaneMap::translate(shift, 1.0));
            }
            for angle in angles.iter().rev() {
                map = map.after(&PlaneMap::translate(-shift, -1.0)).after(&PlaneMap::rotate_degrees(-*angle));
            }
            let image = map.point(Point::new(0.0, z));
            let bound = map.rounding_of_r(Point::new(0.0, z.abs()), 0);
            prop_assert!(image.r.abs() <= bound, "{} > {bound}", image.r.abs());
            prop_assert!(bound < 1e-3, "{bound} is useless");
        }
    }
}

//! One curve of the profile as it was drawn: line, quadratic or cubic Bézier, or elliptical arc.

use core::f64::consts::TAU;
use core::ops::{Add, Mul, Sub};

use crate::numeric::gamma;

/// A point (or vector) of the half plane of the profile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// The distance from the axis.
    pub r: f64,
    /// The height along the axis.
    pub z: f64,
}

impl Point {
    /// The point (r, z).
    #[inline]
    pub const fn new(r: f64, z: f64) -> Self {
        Self { r, z }
    }

    /// Whether neither coordinate is infinite or NaN.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.z.is_finite()
    }

    /// The length of the vector.
    #[inline]
    pub fn length(self) -> f64 {
        self.r.hypot(self.z)
    }

    /// The point a fraction `s` of the way to `other`; exact at s = 0 and s = 1.
    #[inline]
    pub fn lerp(self, other: Self, s: f64) -> Self {
        self * (1.0 - s) + other * s
    }
}

impl Add for Point {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.r + other.r, self.z + other.z)
    }
}

impl Sub for Point {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.r - other.r, self.z - other.z)
    }
}

impl Mul<f64> for Point {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.r * factor, self.z * factor)
    }
}

/// One curve of the profile, with a parameter s from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// A straight line between two points.
    Line([Point; 2]),
    /// A quadratic Bézier curve with its three control points.
    Quadratic([Point; 3]),
    /// A cubic Bézier curve with its four control points.
    Cubic([Point; 4]),
    /// A circular or elliptical arc.
    Arc(Arc),
}

impl Segment {
    /// The first point.
    #[inline]
    pub fn start(&self) -> Point {
        match self {
            Self::Line(p) => p[0],
            Self::Quadratic(p) => p[0],
            Self::Cubic(p) => p[0],
            Self::Arc(arc) => arc.start,
        }
    }

    /// The last point.
    #[inline]
    pub fn end(&self) -> Point {
        match self {
            Self::Line(p) => p[1],
            Self::Quadratic(p) => p[2],
            Self::Cubic(p) => p[3],
            Self::Arc(arc) => arc.end,
        }
    }

    /// The point at the parameter s, 0 <= s <= 1.
    pub fn point(&self, s: f64) -> Point {
        let u = 1.0 - s;
        match self {
            Self::Line([a, b]) => a.lerp(*b, s),
            Self::Quadratic([a, b, c]) => *a * (u * u) + *b * (2.0 * u * s) + *c * (s * s),
            Self::Cubic([a, b, c, d]) => {
                *a * (u * u * u)
                    + *b * (3.0 * u * u * s)
                    + *c * (3.0 * u * s * s)
                    + *d * (s * s * s)
            }
            Self::Arc(arc) => arc.point(s),
        }
    }

    /// The segment moved, with one rounding of each coordinate.
    pub(crate) fn moved(&self, by: Point) -> Self {
        match self {
            Self::Line(p) => Self::Line(p.map(|p| p + by)),
            Self::Quadratic(p) => Self::Quadratic(p.map(|p| p + by)),
            Self::Cubic(p) => Self::Cubic(p.map(|p| p + by)),
            Self::Arc(arc) => Self::Arc(Arc {
                start: arc.start + by,
                end: arc.end + by,
                center: arc.center + by,
                ..*arc
            }),
        }
    }

    /// Whether the segment is one point: all its control points coincide.
    pub(crate) fn is_point(&self) -> bool {
        let all = |p: &[Point]| p.iter().all(|q| *q == p[0]);
        match self {
            Self::Line(p) => all(p),
            Self::Quadratic(p) => all(p),
            Self::Cubic(p) => all(p),
            Self::Arc(arc) => arc.sweep_angle == 0.0,
        }
    }
}

/// An arc of a circle or an ellipse.
///
/// Its points are `center + T (cos a, sin a)`, where T stretches by `radii` and then turns by
/// `rotation`, from r towards z, and a runs from `start_angle` over `sweep_angle`; both ends are
/// kept as they were given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The first point.
    pub start: Point,
    /// The last point.
    pub end: Point,
    /// The centre of the ellipse.
    pub center: Point,
    /// The two semi-axes, both positive.
    pub radii: [f64; 2],
    /// The angle of the first semi-axis against the r axis, in radians.
    pub rotation: f64,
    /// The angle on the ellipse at which the arc begins, in radians.
    pub start_angle: f64,
    /// The angle over which the arc runs, in radians; positive from r towards z.
    pub sweep_angle: f64,
}

impl Arc {
    /// The arc between two points as SVG gives it (SVG 1.1, appendix F.6): radii, rotation of the
    /// ellipse in radians, whether the longer arc is meant, and whether it turns from r towards z.
    ///
    /// Radii too small to reach both points are enlarged until they do, as SVG demands; radii that
    /// are too large by no more than rounding give exactly half an ellipse. `None` where a straight
    /// line or nothing is to be drawn: a radius is zero, the points coincide, or the radii are so
    /// large that the arc does not differ from its chord by more than their rounding.
    pub fn from_endpoints(
        start: Point,
        end: Point,
        radii: [f64; 2],
        rotation: f64,
        large: bool,
        sweep: bool,
    ) -> Option<Self> {
        let [mut a, mut b] = radii.map(f64::abs);
        if start == end || a == 0.0 || b == 0.0 {
            return None;
        }
        let (sin, cos) = if a == b { (0.0, 1.0) } else { rotation.sin_cos() };
        // Half the chord on the unit circle, to which the inverse of T carries the ellipse.
        let half = (start - end) * 0.5;
        let chord =
            Point::new((cos * half.r + sin * half.z) / a, (cos * half.z - sin * half.r) / b);
        let half_length = chord.length();
        // The arc bulges from its chord by half_length^2 / 2 of the radius. Where rounding of the
        // radius is more than that, the chord is nearer to the arc than any point computed on it.
        if !large && half_length * half_length <= 2.0 * gamma(8) {
            return None;
        }
        // Decimal coordinates make 1 - half_length wrong by a few units in the last place; the
        // centre would then move by the square root of that.
        let is_half = half_length >= 1.0 - gamma(8);
        if is_half {
            a *= half_length;
            b *= half_length;
        }
        let side = if large == sweep { -1.0 } else { 1.0 };
        let height = if is_half { 0.0 } else { ((1.0 - half_length) * (1.0 + half_length)).sqrt() };
        let middle = start.lerp(end, 0.5);
        // From the middle of the chord to the centre, across the chord, on the unit circle.
        let (across_r, across_z) =
            (side * height * chord.z / half_length, -side * height * chord.r / half_length);
        let center = Point::new(
            middle.r + (cos * (a * across_r) - sin * (b * across_z)),
            middle.z + (sin * (a * across_r) + cos * (b * across_z)),
        );
        let unit = if is_half { chord * half_length.recip() } else { chord };
        let start_angle = (unit.z - across_z).atan2(unit.r - across_r);
        // A difference of two angles would not know that of a flat arc as well as its chord does.
        let half_sweep = half_length.atan2(height);
        let mut sweep_angle = if large { TAU - 2.0 * half_sweep } else { 2.0 * half_sweep };
        if !sweep {
            sweep_angle = -sweep_angle;
        }
        let rotation = if a == b { 0.0 } else { rotation };
        Some(Self { start, end, center, radii: [a, b], rotation, start_angle, sweep_angle })
    }

    /// The point at the fraction s of the sweep; exactly `start` and `end` at 0 and 1.
    ///
    /// Near an end it is reckoned from there, so that a flat arc of a huge circle has the accuracy of
    /// its ends and not of its centre.
    pub fn point(&self, s: f64) -> Point {
        const NEAR: f64 = 0.5;
        let (before, after) = (s * self.sweep_angle, (1.0 - s) * self.sweep_angle);
        if before.abs() <= NEAR {
            self.start + self.chord(self.start_angle, before)
        } else if after.abs() <= NEAR {
            self.end + self.chord(self.start_angle + self.sweep_angle, -after)
        } else {
            self.point_at_angle(self.start_angle + before)
        }
    }

    /// From the point of the ellipse at `angle` to the one at `angle + turn`.
    fn chord(&self, angle: f64, turn: f64) -> Point {
        let (sin, cos) = (angle + 0.5 * turn).sin_cos();
        let length = 2.0 * (0.5 * turn).sin();
        self.conjugate(-length * sin, length * cos)
    }

    /// The point of the whole ellipse at an angle.
    pub(crate) fn point_at_angle(&self, angle: f64) -> Point {
        let (sin, cos) = angle.sin_cos();
        self.center + self.conjugate(cos, sin)
    }

    /// T (x, y).
    pub(crate) fn conjugate(&self, x: f64, y: f64) -> Point {
        let (sin, cos) = if self.rotation == 0.0 { (0.0, 1.0) } else { self.rotation.sin_cos() };
        let (x, y) = (self.radii[0] * x, self.radii[1] * y);
        Point::new(cos * x - sin * y, sin * x + cos * y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};

    fn p(r: f64, z: f64) -> Point {
        Point::new(r, z)
    }

    #[test]
    fn half_circle_is_centred_exactly() {
        let arc = Arc::from_endpoints(p(0.0, -1.0), p(0.0, 1.0), [1.0, 1.0], 0.3, false, true);
        let arc = arc.unwrap();
        assert_eq!((arc.center, arc.radii), (p(0.0, 0.0), [1.0, 1.0]));
        assert_eq!((arc.start_angle, arc.sweep_angle), (-FRAC_PI_2, PI));
        assert!((arc.point(0.5) - p(1.0, 0.0)).length() < 1e-15);
    }

    #[test]
    fn the_four_arcs_of_a_pair_of_points() {
        for (large, sweep, center, sweep_angle) in [
            (false, true, p(0.0, 0.0), FRAC_PI_2),
            (true, true, p(1.0, 1.0), 3.0 * FRAC_PI_2),
            (false, false, p(1.0, 1.0), -FRAC_PI_2),
            (true, false, p(0.0, 0.0), -3.0 * FRAC_PI_2),
        ] {
            let arc = Arc::from_endpoints(p(1.0, 0.0), p(0.0, 1.0), [1.0, 1.0], 0.0, large, sweep);
            let arc = arc.unwrap();
            assert!((arc.center - center).length() < 1e-15, "{large} {sweep} {arc:?}");
            assert!((arc.sweep_angle - sweep_angle).abs() < 1e-15, "{large} {sweep} {arc:?}");
            assert!((arc.point(1e-9) - arc.start).length() < 1e-8);
            assert!((arc.point(1.0 - 1e-9) - arc.end).length() < 1e-8);
        }
    }

    #[test]
    fn rotated_ellipse_meets_its_ends() {
        let (start, end) = (p(2.0, 1.0), p(1.5, 3.0));
        let arc = Arc::from_endpoints(start, end, [2.0, 0.9], 0.6, true, false).unwrap();
        assert!((arc.point_at_angle(arc.start_angle) - start).length() < 1e-14);
        assert!((arc.point_at_angle(arc.start_angle + arc.sweep_angle) - end).length() < 1e-14);
    }

    #[test]
    fn arcs_of_huge_radii_are_their_chords() {
        let (start, end) = (p(1.0, 0.0), p(2.0, 1.0));
        let arc = |radius, large| Arc::from_endpoints(start, end, [radius; 2], 0.0, large, true);
        for radius in [1e9, 1e16, 1e99, 1e300] {
            assert_eq!(arc(radius, false), None);
            assert!(arc(radius, true).is_some());
        }
        for radius in [1.0, 1e3, 1e6] {
            let middle = arc(radius, false).unwrap().point(0.5);
            let bulge = (middle - start.lerp(end, 0.5)).length();
            // radius (1 - cos), with half the chord sqrt(1/2) as the sine.
            let sin2 = 0.5 / (radius * radius);
            let expected = radius * sin2 / (1.0 + (1.0 - sin2).sqrt());
            assert!((bulge - expected).abs() <= gamma(32) * radius, "{radius}: {bulge}");
        }
    }

    #[test]
    fn flat_arcs_have_the_accuracy_of_their_ends() {
        // The circle of radius 1e6 through the ends; its sagitta is 0.25e-6 + O(1e-18).
        let arc = Arc::from_endpoints(p(1.0, 0.0), p(2.0, 1.0), [1e6; 2], 0.0, false, true);
        let middle = arc.unwrap().point(0.5);
        let off = 0.25e-6 / core::f64::consts::SQRT_2;
        assert!((middle - p(1.5 + off, 0.5 - off)).length() < 1e-15, "{middle:?}");
    }

    #[test]
    fn short_radii_are_enlarged_at_every_size() {
        for size in [1e-8, 1.0, 1e8] {
            let arc = Arc::from_endpoints(
                p(0.0, 0.0),
                p(0.0, 2.0 * size),
                [size * 0.1; 2],
                0.0,
                false,
                true,
            );
            let arc = arc.unwrap();
            assert!((arc.radii[0] / size - 1.0).abs() < 1e-15);
            assert!((arc.center - p(0.0, size)).length() < 1e-15 * size);
        }
    }
}

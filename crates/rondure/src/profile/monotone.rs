//! Monotone intervals: where r or z of a segment turns (paper, section 3.3).
//!
//! A Bézier coordinate turns at the roots of its derivative, which has degree two at most; an
//! ellipse at the angles where the derivative of A cos a + B sin a vanishes.

use core::f64::consts::PI;

use kurbo::common::solve_quadratic;

use super::{Arc, Point, Segment};
use crate::numeric::gamma;

/// The parameters strictly between 0 and 1 at which r turns, or may turn, in increasing order.
pub(crate) fn turning_parameters_of_r(segment: &Segment) -> Vec<f64> {
    turning_parameters(segment, |p| p.r)
}

/// The parameters strictly between 0 and 1 at which z turns, or may turn, in increasing order.
pub(crate) fn turning_parameters_of_z(segment: &Segment) -> Vec<f64> {
    turning_parameters(segment, |p| p.z)
}

fn turning_parameters(segment: &Segment, coordinate: impl Fn(Point) -> f64) -> Vec<f64> {
    let mut parameters = match segment {
        Segment::Line(_) => Vec::new(),
        Segment::Quadratic(p) => {
            let [a, b, c] = p.map(&coordinate);
            // The derivative is the straight line from b - a to c - b.
            solve_quadratic(b - a, (c - b) - (b - a), 0.0).to_vec()
        }
        Segment::Cubic(p) => {
            let [a, b, c, d] = p.map(&coordinate);
            let (d0, d1, d2) = (b - a, c - b, d - c);
            // In the power basis, scaled so that no coefficient overflows or vanishes.
            let scale = d0.abs().max(d1.abs()).max(d2.abs());
            if scale == 0.0 {
                return Vec::new();
            }
            let (d0, d1, d2) = (d0 / scale, d1 / scale, d2 / scale);
            solve_quadratic(d0, 2.0 * (d1 - d0), (d0 - d1) + (d2 - d1)).to_vec()
        }
        Segment::Arc(arc) => turning_angles(arc, coordinate),
    };
    // Nearer to an end than the rounding of s itself, the end is the turning point.
    let rounding = gamma(8);
    parameters.retain(|s| rounding < *s && *s < 1.0 - rounding);
    parameters.sort_by(f64::total_cmp);
    parameters
}

/// The fractions of an arc's sweep at which a coordinate turns.
fn turning_angles(arc: &Arc, coordinate: impl Fn(Point) -> f64) -> Vec<f64> {
    let along_first = coordinate(arc.conjugate(1.0, 0.0));
    let along_second = coordinate(arc.conjugate(0.0, 1.0));
    let highest = along_second.atan2(along_first);
    let turns = arc.sweep_angle.signum();
    // Half turns from the start to the first extremum at or after it.
    let first = ((highest - arc.start_angle) * turns).rem_euclid(PI);
    let count = (arc.sweep_angle.abs() / PI) as u32 + 2;
    (0..count).map(|n| (first + f64::from(n) * PI) / arc.sweep_angle.abs()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_turns_where_its_derivative_vanishes() {
        let p = |r, z| Point::new(r, z);
        let s = Segment::Cubic([p(1.0, 0.0), p(2.0, 1.0), p(0.0, 2.0), p(1.0, 3.0)]);
        let turns = turning_parameters_of_r(&s);
        assert_eq!(turns.len(), 2);
        for t in turns {
            let h = 1e-6;
            let slope = (s.point(t + h).r - s.point(t - h).r) / (2.0 * h);
            assert!(slope.abs() < 1e-9);
        }
        assert!(turning_parameters_of_z(&s).is_empty());
    }

    #[test]
    fn a_full_circle_turns_twice_each_way() {
        let arc = Arc::from_endpoints(
            Point::new(2.9, 0.3),
            Point::new(2.9, -0.3),
            [1.0, 1.0],
            0.0,
            true,
            true,
        );
        let arc = Segment::Arc(arc.unwrap());
        assert_eq!(turning_parameters_of_r(&arc).len(), 1);
        assert_eq!(turning_parameters_of_z(&arc).len(), 2);
    }

    #[test]
    fn a_quarter_circle_does_not_turn() {
        let (a, b) = (Point::new(1.0, 0.0), Point::new(0.0, 1.0));
        let arc = Segment::Arc(Arc::from_endpoints(a, b, [1.0; 2], 0.0, false, true).unwrap());
        assert!(turning_parameters_of_r(&arc).is_empty());
        assert!(turning_parameters_of_z(&arc).is_empty());
    }
}

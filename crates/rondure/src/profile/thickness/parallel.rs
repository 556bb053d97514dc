//! The parallel c + d n of one segment: points, folds, and the segments that draw it.
//!
//! Its derivative is (1 + d kappa) c', where kappa = (c' x c'') / |c'|^3 is positive where the curve turns to
//! the left. It folds where that is not positive.

use core::f64::consts::FRAC_PI_2;

use super::{Point, Segment};
use crate::profile::Arc;

/// The curve itself at one parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) point: Point,
    /// c'
    pub(super) first: Point,
    /// c''
    pub(super) second: Point,
}

pub(super) fn cross(a: Point, b: Point) -> f64 {
    a.r * b.z - a.z * b.r
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a.r * b.r + a.z * b.z
}

pub(super) fn jet(segment: &Segment, s: f64) -> Jet {
    let zero = Point::default();
    let (first, second) = match segment {
        Segment::Line([a, b]) => (*b - *a, zero),
        Segment::Quadratic([a, b, c]) => {
            let (d, e) = (*b - *a, *c - *b);
            (d.lerp(e, s) * 2.0, (e - d) * 2.0)
        }
        Segment::Cubic([a, b, c, d]) => {
            let (e, f, g) = (*b - *a, *c - *b, *d - *c);
            let (h, i) = (e.lerp(f, s), f.lerp(g, s));
            (h.lerp(i, s) * 3.0, (f - e).lerp(g - f, s) * 6.0)
        }
        Segment::Arc(arc) => {
            let (sin, cos) = (arc.start_angle + s * arc.sweep_angle).sin_cos();
            let turn = arc.sweep_angle;
            (arc.conjugate(-sin, cos) * turn, arc.conjugate(-cos, -sin) * (turn * turn))
        }
    };
    Jet { point: segment.point(s), first, second }
}

/// The unit tangent, also at an end where the derivative vanishes; `None` at a cusp inside, or if the
/// segment is a point.
pub(super) fn tangent(segment: &Segment, s: f64) -> Option<Point> {
    let unit = |p: Point| {
        let length = p.length();
        (length > 0.0).then(|| p * length.recip())
    };
    let controls: &[Point] = match segment {
        Segment::Line(p) => p,
        Segment::Quadratic(p) => p,
        Segment::Cubic(p) => p,
        Segment::Arc(_) => &[],
    };
    if s == 0.0 && !controls.is_empty() {
        controls.iter().find_map(|p| unit(*p - controls[0]))
    } else if s == 1.0 && !controls.is_empty() {
        let end = controls[controls.len() - 1];
        controls.iter().rev().find_map(|p| unit(end - *p))
    } else {
        unit(jet(segment, s).first)
    }
}

/// The right normal of a unit tangent.
pub(super) fn right(tangent: Point) -> Point {
    Point::new(tangent.z, -tangent.r)
}

/// The parallel of a segment at the signed distance d, to the right if positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parallel<'a> {
    pub(super) segment: &'a Segment,
    pub(super) d: f64,
}

/// Where a parallel folds: the parameter, and the radius of curvature there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fold {
    pub(super) s: f64,
    pub(super) radius: f64,
}

impl Parallel<'_> {
    /// The point at s; `None` where there is no normal.
    pub(super) fn point(&self, s: f64) -> Option<Point> {
        Some(self.segment.point(s) + right(tangent(self.segment, s)?) * self.d)
    }

    /// The point and the derivative.
    pub(super) fn jet(&self, s: f64) -> Option<(Point, Point)> {
        let at = jet(self.segment, s);
        let stretch = 1.0 + self.d * curvature(&at);
        Some((self.point(s)?, at.first * if stretch.is_finite() { stretch } else { 1.0 }))
    }

    /// Where the parallel folds between two parameters, if it does: at the place where the curve bends most
    /// tightly to that side.
    pub(super) fn fold(&self, [from, to]: [f64; 2]) -> Option<Fold> {
        if self.d == 0.0 {
            return None;
        }
        let worst = match self.segment {
            Segment::Line(_) => return None,
            Segment::Quadratic([a, b, c]) => {
                let velocity = vec![(*b - *a) * 2.0, (*c - *b) * 2.0];
                self.may_fold(&velocity, [from, to])
            }
            Segment::Cubic([a, b, c, d]) => {
                let velocity = vec![(*b - *a) * 3.0, (*c - *b) * 3.0, (*d - *c) * 3.0];
                self.may_fold(&velocity, [from, to])
            }
            Segment::Arc(arc) => self.tightest_of_arc(arc, [from, to]),
        }?;
        Some(Fold { s: worst, radius: 1.0 / curvature(&jet(self.segment, worst)).abs() })
    }

    /// 1 + d kappa
    fn stretch(&self, s: f64) -> f64 {
        1.0 + self.d * curvature(&jet(self.segment, s))
    }

    /// An ellipse bends most and least at its axes.
    fn tightest_of_arc(&self, arc: &Arc, [from, to]: [f64; 2]) -> Option<f64> {
        let quarters = |s: f64| (arc.start_angle + s * arc.sweep_angle) / FRAC_PI_2;
        let (low, high) = (quarters(from).min(quarters(to)), quarters(from).max(quarters(to)));
        let mut candidates = vec![from, to];
        let mut quarter = low.ceil();
        while quarter < high {
            candidates.push((quarter * FRAC_PI_2 - arc.start_angle) / arc.sweep_angle);
            quarter += 1.0;
        }
        candidates.retain(|s| self.stretch(*s) <= 0.0);
        candidates.into_iter().min_by(|a, b| self.stretch(*a).total_cmp(&self.stretch(*b)))
    }

    /// A parameter at which |c'|^3 + d (c' x c'') <= 0, if there is one; found by bounds for both
    /// terms on ever smaller intervals. `velocity` has the control points of c'.
    fn may_fold(&self, velocity: &[Point], range: [f64; 2]) -> Option<f64> {
        /// Intervals of 2^-DEEPEST that no bound decides are decided by their middle.
        const DEEPEST: u32 = 40;
        let mut waiting = vec![(range, 0)];
        let mut found = None;
        while let Some(([from, to], depth)) = waiting.pop() {
            let middle = 0.5 * (from + to);
            let at = jet(self.segment, middle);
            if excess(&at, self.d) <= 0.0 {
                found = Some(middle);
                break;
            }
            let part = restrict(velocity, [from, to]);
            let speed = at.first.length();
            let along = at.first * speed.recip();
            let slowest = part.iter().map(|v| dot(*v, along)).fold(f64::INFINITY, f64::min);
            // c'' by the parameter of the whole curve.
            let bend = 1.0 / (to - from);
            let count = part.len() - 1;
            let turns = part.iter().flat_map(|v| {
                let part = &part;
                (0..count).map(move |i| cross(*v, (part[i + 1] - part[i]) * (count as f64 * bend)))
            });
            let least = turns.map(|turn| self.d * turn).fold(f64::INFINITY, f64::min);
            if slowest > 0.0 && slowest.powi(3) + least > 0.0 {
                continue;
            }
            if depth == DEEPEST {
                continue;
            }
            waiting.push(([middle, to], depth + 1));
            waiting.push(([from, middle], depth + 1));
        }
        found.map(|s| self.tightest_near(s, range))
    }

    /// The place with the least 1 + d kappa among so many, and s.
    fn tightest_near(&self, s: f64, [from, to]: [f64; 2]) -> f64 {
        const PLACES: u32 = 1000;
        let places = (0..=PLACES).map(|i| from + (to - from) * f64::from(i) / f64::from(PLACES));
        let places = places.filter(|s| self.stretch(*s).is_finite());
        places.chain([s]).min_by(|a, b| self.stretch(*a).total_cmp(&self.stretch(*b))).unwrap_or(s)
    }
}

/// kappa
pub(super) fn curvature(at: &Jet) -> f64 {
    cross(at.first, at.second) / at.first.length().powi(3)
}

/// |c'|^3 + d (c' x c'')
fn excess(at: &Jet, d: f64) -> f64 {
    at.first.length().powi(3) + d * cross(at.first, at.second)
}

/// The control points of a Bézier curve on part of its range (de Casteljau, twice).
fn restrict(controls: &[Point], [from, to]: [f64; 2]) -> Vec<Point> {
    let left = split(controls, to).0;
    split(&left, if to > 0.0 { from / to } else { 0.0 }).1
}

fn split(controls: &[Point], s: f64) -> (Vec<Point>, Vec<Point>) {
    let mut rest = controls.to_vec();
    let (mut left, mut right) = (vec![rest[0]], vec![rest[rest.len() - 1]]);
    while rest.len() > 1 {
        rest = rest.windows(2).map(|pair| pair[0].lerp(pair[1], s)).collect();
        left.push(rest[0]);
        right.push(rest[rest.len() - 1]);
    }
    right.reverse();
    (left, right)
}

//! The oriented rectangle, KJ: Kajiya 1983, "New Techniques for Ray Tracing Procedurally Defined
//! Objects", with the strip tree of Ballard 1981.
//!
//! In the plane (z, w = rho^2) a ray is a parabola, and the surface a curve that is the same for all
//! rays. A node encloses its part of that curve by a rectangle along the chord. w is measured in
//! units of the surface's radius, so that both coordinates are lengths. A frustum is no straight line
//! in this plane but an arc of a parabola; the rectangle encloses that arc.

use super::interval::{Intervals, sublevel};
use super::strip::range_over;
use super::{Shell, padding};
use crate::meridian::Meridian;
use crate::piece::Piece;
use crate::profile::Point;

/// A rectangle in the plane (z, rho^2): `low <= q rho^2 + p z <= high` along and across the chord.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    pub(crate) along: Band,
    pub(crate) across: Band,
}

/// `low <= q rho^2 + p z <= high`, with q >= 0: a convex function along any ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    pub(crate) q: f64,
    pub(crate) p: f64,
    pub(crate) range: [f64; 2],
}

impl Rectangle {
    /// The rectangle round some frusta.
    pub(crate) fn around(frusta: &[Piece], radius: f64) -> Self {
        let (cos, sin) = chord(frusta, radius);
        let band = |q: f64, p: f64| {
            // The sense in which a coordinate grows is free; q >= 0 makes it convex.
            let (q, p) = if q < 0.0 { (-q, -p) } else { (q, p) };
            let q = q / radius;
            let [low, high] = range_over(frusta, q, p);
            // Both coordinates are lengths, and |q| radius, |p| <= 1.
            let pad = 2.0 * padding(radius);
            Band { q, p, range: [low - pad, high + pad] }
        };
        Self { along: band(sin, cos), across: band(cos, -sin) }
    }

    /// The width across the chord.
    #[cfg(test)]
    pub(crate) fn width(&self) -> f64 {
        self.across.range[1] - self.across.range[0]
    }
}

/// The image of a point in the plane (z, rho^2 / radius).
pub(crate) fn image(point: Point, radius: f64) -> [f64; 2] {
    [point.z, point.r * point.r / radius]
}

/// The unit direction in that plane from the first to the last point of some frusta.
pub(crate) fn chord(frusta: &[Piece], radius: f64) -> (f64, f64) {
    let (Some(first), Some(last)) = (frusta.first(), frusta.last()) else { return (1.0, 0.0) };
    let ([z0, w0], [z1, w1]) = (image(first.start(), radius), image(last.end(), radius));
    let length = (z1 - z0).hypot(w1 - w0);
    if length > 0.0 { ((z1 - z0) / length, (w1 - w0) / length) } else { (1.0, 0.0) }
}

impl Band {
    /// The coefficients of the coordinate along the ray, a t^2 + 2 b t + c.
    #[inline]
    fn along_ray(&self, ray: &Meridian) -> (f64, f64, f64) {
        let (a, b, c) = ray.squared_distance();
        (self.q * a, self.q * b + 0.5 * self.p * ray.dz, self.q * c + self.p * ray.oz)
    }

    /// The smallest and the largest value of the coordinate on a stretch of the ray.
    #[inline]
    fn extremes((a, b, c): (f64, f64, f64), [lo, hi]: [f64; 2]) -> [f64; 2] {
        let value = |t: f64| (a * t + 2.0 * b) * t + c;
        let (first, last) = (value(lo), value(hi));
        let turns = a * lo + b < 0.0 && a * hi + b > 0.0;
        let lowest = if turns { c - b * b / a } else { first.min(last) };
        [lowest, first.max(last)]
    }

    /// Whether values between two extremes, all of which are taken, reach into the band.
    #[inline]
    fn reached(&self, [lowest, highest]: [f64; 2]) -> bool {
        highest >= self.range[0] && lowest <= self.range[1]
    }

    /// Where a stretch of the ray lies in the band.
    #[inline]
    fn intervals(&self, (a, b, c): (f64, f64, f64), stretch: [f64; 2]) -> Intervals {
        let [inner, outer] = self.range.map(|bound| sublevel(a, b, c - bound));
        Intervals::between(stretch, outer, inner)
    }
}

impl Shell for Rectangle {
    #[inline]
    fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
        let across = self.across.along_ray(ray);
        if !self.across.reached(Band::extremes(across, range)) {
            return None;
        }
        let along = self.along.along_ray(ray);
        let extremes = Band::extremes(along, range);
        if !self.along.reached(extremes) {
            return None;
        }
        // The parts of the parabola between the rectangle's ends; roots only where it passes them.
        let inside = |bound: f64| sublevel(along.0, along.1, along.2 - bound);
        let outer = if extremes[1] > self.along.range[1] {
            inside(self.along.range[1])
        } else {
            Some([f64::NEG_INFINITY, f64::INFINITY])
        };
        let inner =
            if extremes[0] < self.along.range[0] { inside(self.along.range[0]) } else { None };
        // Of those, the ones that meet its sides.
        let mut met: Option<[f64; 2]> = None;
        for part in Intervals::between(range, outer, inner).iter() {
            if self.across.reached(Band::extremes(across, *part)) {
                met = Some([met.map_or(part[0], |m| m[0]), part[1]]);
            }
        }
        met
    }

    fn intervals(&self, ray: &Meridian, stretch: [f64; 2]) -> Intervals {
        self.across.intervals(self.across.along_ray(ray), stretch)
    }
}

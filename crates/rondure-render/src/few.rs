//! Few things in a list, which is faster than a tree of boxes: a ray looks at all of them, at what is solved in place first,
//! and asks a turned one only if it passes through the ball round it.

use rondure::{Bounds, Ray, Vec3, numeric::gamma};

use crate::{shape::Flats, things::Things};

/// The most things in a list.
const MOST: usize = 16;

/// A list of few things.
#[derive(Clone, Debug)]
pub(crate) struct Few {
    flats: Flats,
    /// What else is solved in place.
    simple: Vec<u32>,
    turned: Vec<Ball>,
}

/// The ball round a thing.
#[derive(Clone, Copy, Debug)]
struct Ball {
    thing: u32,
    center: Vec3,
    /// Twice the square of the radius, which leaves room for rounding.
    reach2: f64,
}

impl Few {
    /// `None` if there are too many.
    pub(crate) fn new(things: &Things) -> Option<Self> {
        if things.len() > MOST {
            return None;
        }
        let (turned, all) = (things.turned.len() as u32, things.len() as u32);
        let (flats, simple) = Flats::of((turned..all).zip(&things.simple));
        Some(Self {
            flats,
            simple,
            turned: (0..turned).map(|thing| Ball::new(thing, &things.bounds(thing))).collect(),
        })
    }

    /// The rectangles and planes, which [`walk`](Self::walk) leaves out.
    #[inline(always)]
    pub(crate) fn flats(&self) -> &Flats {
        &self.flats
    }

    /// What is solved in place beside those.
    #[inline]
    pub(crate) fn simple(&self) -> &[u32] {
        &self.simple
    }

    /// The turned things.
    #[inline]
    pub(crate) fn turned(&self) -> impl Iterator<Item = u32> + '_ {
        self.turned.iter().map(|ball| ball.thing)
    }

    /// Visits what else the ray may meet in its range. `visit` returns up to which t the search goes on; minus infinity
    /// stops.
    #[inline(always)]
    pub(crate) fn walk(&self, ray: &Ray, mut visit: impl FnMut(u32) -> f64) {
        let mut end = ray.t_max;
        for &thing in &self.simple {
            end = visit(thing);
            if end == f64::NEG_INFINITY {
                return;
            }
        }
        for ball in &self.turned {
            if !ball.misses(ray, end) {
                end = visit(ball.thing);
                if end == f64::NEG_INFINITY {
                    return;
                }
            }
        }
    }
}

impl Ball {
    fn new(thing: u32, bounds: &Bounds) -> Self {
        let half = (bounds.max - bounds.min) * 0.5;
        let center = bounds.min + half;
        Self { thing, center, reach2: 2.0 * half.length_squared() }
    }

    /// Whether the ray surely has nothing of the ball up to `end`. What is not a number is not sure.
    #[inline(always)]
    fn misses(&self, ray: &Ray, end: f64) -> bool {
        let (to, d) = (self.center - ray.origin, ray.direction);
        let (to2, d2, along) = (to.length_squared(), d.length_squared(), to.dot(d));
        let reach2 = self.reach2 * d2;
        // The squares of lengths, each times d^2, and what they may be off.
        let aside = to2 * d2 - along * along;
        let before = along - ray.t_min * d2;
        let beyond = along - end * d2;
        let slack = reach2 + gamma(64) * (to2 * d2);
        aside > slack
            || (before < 0.0 && before * before > slack)
            || (beyond > 0.0 && beyond * beyond > slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_missed_only_from_beside_them_behind_and_before() {
        let center = Vec3::new(3.0, 4.0, 5.0);
        let half = Vec3::splat(1.0);
        let ball = Ball::new(0, &Bounds { min: center - half, max: center + half });
        let towards = |aside: f64| {
            let origin = Vec3::new(3.0 + aside, -10.0, 5.0);
            Ray::new(origin, Vec3::new(0.0, 2.0, 0.0))
        };
        for aside in [0.0, 1.0, 3.0_f64.sqrt()] {
            let ray = towards(aside);
            assert!(!ball.misses(&ray, f64::INFINITY), "{aside}");
            // The corner of the box that is nearest, and farthest.
            assert!(!ball.misses(&ray, 6.5), "{aside}");
            assert!(!ball.misses(&ray.with_range(7.5, f64::INFINITY), f64::INFINITY), "{aside}");
        }
        assert!(ball.misses(&towards(2.5), f64::INFINITY));
        assert!(ball.misses(&towards(0.0), 5.0));
        assert!(ball.misses(&towards(0.0).with_range(9.0, f64::INFINITY), f64::INFINITY));
        let line = towards(0.0).with_range(f64::NEG_INFINITY, f64::INFINITY);
        assert!(!ball.misses(&line, f64::INFINITY));
        let back = Ray { direction: Vec3::new(0.0, -1.0, 0.0), ..line };
        assert!(!ball.misses(&back, f64::INFINITY));
        assert!(ball.misses(&back.with_range(0.0, f64::INFINITY), f64::INFINITY));
    }

    #[test]
    fn what_is_not_a_number_is_not_missed() {
        let ball = Ball::new(0, &Bounds { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) });
        let ray = Ray::new(Vec3::splat(f64::NAN), Vec3::X);
        assert!(!ball.misses(&ray, f64::INFINITY));
        let endless = Vec3::splat(f64::INFINITY);
        let space = Ball::new(0, &Bounds { min: -endless, max: endless });
        assert!(!space.misses(&Ray::new(Vec3::splat(9.0), Vec3::X), 1.0));
    }
}

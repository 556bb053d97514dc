//! The tree's own coordinates, and rays in them.
//!
//! All boxes together are moved about their common center and divided by a power of two, so that
//! coordinates lie in [-1, 1]; then they fit f32. A ray that begins near them, as most do, keeps its origin. Any other is first
//! moved to where it enters the sphere round the boxes: its parameter then runs from 0 to at most 2 sqrt(3), from however far it came.
//!
//! What f32 rounds is made up for once, when the boxes are built, by [`PAD`] on all sides. With
//! u = 2^-24 the unit roundoff, and every displacement measured along the axis of a slab,
//!
//! ```text
//! the rounded origin, |o| <= 8                                       8 u
//! the rounded direction, over the way from o to the plane           10 u
//! t = fl(plane * r) - fl(o * r), r = fl(1 / d)                       3 u |plane| + 3 u |o| < 28 u
//! the rounded plane                                                    u
//! ```
//!
//! together less than 48 u. A direction's coordinate below [`FLATTEST`] is raised to it, which moves
//! the ray by less than 5 u: no reciprocal is infinite, and no product is NaN.
//! The f64 arithmetic that leads here errs by some 2^-50, which the rest of the padding covers.

use crate::numeric::{gamma, reciprocal_power_of_two, two_diff};
use crate::{Bounds, Ray, Vec3};

/// How much larger the boxes are on all sides: 64 u.
const PAD: f64 = 1.0 / (1 << 18) as f64;

/// Rays keep origins whose coordinates are no larger.
const NEAR: f64 = 8.0;

/// The parameter at which such a ray is surely beyond the sphere round the boxes: its direction is no shorter than 1.
const BEYOND: f64 = 2.0 * NEAR + 2.0;

/// The smallest coordinate of a direction, u / 4.
const FLATTEST: f32 = 1.0 / (1 << 26) as f32;

/// Beyond this, sums of coordinates could overflow.
const LARGEST: f64 = 1e300;

/// A box in the tree's coordinates. The fourth lane of each corner is of no meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    pub(super) min: [f32; 4],
    pub(super) max: [f32; 4],
}

impl Slabs {
    pub(super) const EMPTY: Self = Self { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        // Not `f32::min`, whose rules for NaN cost more: there are none here.
        let smaller = |a: f32, b: f32| if a < b { a } else { b };
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        Self {
            min: core::array::from_fn(|i| smaller(self.min[i], other.min[i])),
            max: core::array::from_fn(|i| larger(self.max[i], other.max[i])),
        }
    }

    /// How wide the box is along its longest axis.
    pub(super) fn width(&self) -> f32 {
        let along = |i: usize| self.max[i] - self.min[i];
        along(0).max(along(1)).max(along(2))
    }

    /// Half the area of the box's faces; not positive for the empty box.
    #[inline]
    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|i| (self.max[i] - self.min[i]).max(0.0));
        x * y + y * z + z * x
    }
}

/// Where the tree stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    center: Vec3,
    /// A power of two.
    scale: f64,
    /// The radius of the sphere round all boxes, in the tree's coordinates.
    radius: f64,
}

/// A direction, made between 1 and 2 long along its longest axis.
pub(super) struct Direction {
    pub(super) own: Vec3,
    /// The power of two by which that was done.
    pub(super) unit: f64,
}

/// A ray in the tree's coordinates: its parameter runs from `begin`, which is not negative, to `end`.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRay {
    /// 1 / d and o / d.
    pub(super) reciprocal: [f32; 3],
    pub(super) shifted: [f32; 3],
    /// Whether the ray runs towards smaller coordinates.
    pub(super) falling: [bool; 3],
    pub(super) begin: f32,
    pub(super) end: f32,
    /// The local parameter is `t * scale * inverse_unit - shift - start`.
    scale: f64,
    inverse_unit: f64,
    shift: f64,
    start: f64,
    reach: f64,
}

/// Whether a box has room in the tree.
pub(super) fn is_bounded(bounds: &Bounds) -> bool {
    bounds.min.max_abs() <= LARGEST && bounds.max.max_abs() <= LARGEST
}

impl Space {
    /// The space of the boxes whose union this is.
    pub(super) fn new(all: &Bounds) -> Self {
        let center = all.min * 0.5 + all.max * 0.5;
        let half = (all.max * 0.5 - all.min * 0.5).max_abs();
        // A point has no size; a small part of its distance from the origin does as well as any.
        let size = half.max(center.max_abs() * PAD * PAD).max(f64::MIN_POSITIVE);
        let scale = 0.5 * reciprocal_power_of_two(size);
        let corner = (all.max * 0.5 - all.min * 0.5) * scale + Vec3::splat(2.0 * PAD);
        Self { center, scale, radius: corner.length() * (1.0 + gamma(8)) }
    }

    /// The padded box.
    #[inline]
    pub(super) fn slabs(&self, bounds: &Bounds) -> Slabs {
        let min = (bounds.min - self.center) * self.scale - Vec3::splat(PAD);
        let max = (bounds.max - self.center) * self.scale + Vec3::splat(PAD);
        Slabs {
            min: [min.x as f32, min.y as f32, min.z as f32, 0.0],
            max: [max.x as f32, max.y as f32, max.z as f32, 0.0],
        }
    }

    /// The radius of the sphere round all boxes.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// A difference of places.
    pub(super) fn scaled(&self, difference: Vec3) -> Vec3 {
        difference * self.scale
    }

    /// Where a ray begins, and its direction; `None` if it is no ray.
    #[inline(always)]
    pub(super) fn measured(&self, ray: &Ray) -> Option<(Vec3, Direction)> {
        let largest = ray.direction.max_abs();
        if !(ray.direction.is_finite() && ray.origin.is_finite() && largest > 0.0) {
            return None;
        }
        let unit = reciprocal_power_of_two(largest);
        let direction = Direction { own: ray.direction * unit, unit };
        Some((self.scaled(ray.origin - self.center), direction))
    }

    /// The ray in this space; `None` if it passes all boxes at a distance, runs away from them, or is
    /// no ray. See [`crate::frame`], which does the same for a surface.
    #[inline(always)]
    pub(super) fn enter(&self, ray: &Ray) -> Option<LocalRay> {
        self.enter_within(ray, 0.0)
    }

    /// The same with boxes that reach so much farther, which must be less than 1/8.
    #[inline(always)]
    pub(super) fn enter_within(&self, ray: &Ray, farther: f64) -> Option<LocalRay> {
        let (from, Direction { own: direction, unit }) = self.measured(ray)?;
        if from.max_abs() <= NEAR && ray.t_min >= 0.0 {
            return self.enter_near(ray, from, direction, unit);
        }
        let radius = self.radius + farther;
        let radius2 = radius * radius;
        // The largest coordinate is at least 1, so is this; all that it is for bears its rounding.
        let inverse2 = 1.0 / direction.length_squared();
        let along = |t: f64, from: Vec3| {
            Vec3::new(
                t.mul_add(direction.x, from.x),
                t.mul_add(direction.y, from.y),
                t.mul_add(direction.z, from.z),
            )
        };
        let (x, x_low) = two_diff(ray.origin.x, self.center.x);
        let (y, y_low) = two_diff(ray.origin.y, self.center.y);
        let (z, z_low) = two_diff(ray.origin.z, self.center.z);
        let from = Vec3::new(x, y, z) * self.scale;
        let mut shift = -from.dot(direction) * inverse2;
        let mut nearest = along(shift, from) + Vec3::new(x_low, y_low, z_low) * self.scale;
        let rest = -nearest.dot(direction) * inverse2;
        if rest * rest > radius2 * inverse2 {
            shift += rest;
            nearest = along(rest, nearest);
        }
        let distance2 = nearest.length_squared();
        if distance2 > radius2 || distance2.is_nan() {
            return None;
        }
        // The move went to the nearest point only up to rounding; this much farther is enough.
        let reach = (radius2 * inverse2).sqrt() * (1.0 + PAD);
        let local = LocalRay::new(self.scale, unit, shift, reach);
        let start = local.bound(ray.t_min, -1.0).max(-reach);
        let end = local.bound(ray.t_max, 1.0).min(reach);
        if start > end {
            return None;
        }
        let origin = along(start, nearest);
        Some(LocalRay { end: rounded_up(end - start), start, ..local.facing(origin, direction) })
    }

    /// A ray that begins near the boxes, at t = 0.
    #[inline(always)]
    fn enter_near(&self, ray: &Ray, origin: Vec3, direction: Vec3, unit: f64) -> Option<LocalRay> {
        let local = LocalRay::new(self.scale, unit, 0.0, BEYOND);
        let begin = local.bound(ray.t_min, -1.0).max(0.0);
        let end = local.bound(ray.t_max, 1.0).min(BEYOND);
        // False where one is not a number.
        (begin <= end).then(|| LocalRay {
            begin: rounded_down(begin),
            end: rounded_up(end),
            ..local.facing(origin, direction)
        })
    }
}

impl LocalRay {
    /// A ray that as yet begins nowhere and goes nowhere.
    #[inline(always)]
    fn new(scale: f64, unit: f64, shift: f64, reach: f64) -> Self {
        // A power of two between 2^-1022 and 2^1022, as its inverse is.
        let inverse_unit = 1.0 / unit;
        Self {
            reciprocal: [0.0; 3],
            shifted: [0.0; 3],
            falling: [false; 3],
            begin: 0.0,
            end: 0.0,
            scale,
            inverse_unit,
            shift,
            start: 0.0,
            reach,
        }
    }

    /// The same from an origin in a direction.
    #[inline(always)]
    fn facing(self, origin: Vec3, direction: Vec3) -> Self {
        // Not by `map`, which is not always inlined.
        let [x, y, z] = [
            reciprocal(direction.x as f32),
            reciprocal(direction.y as f32),
            reciprocal(direction.z as f32),
        ];
        Self {
            reciprocal: [x, y, z],
            shifted: [origin.x as f32 * x, origin.y as f32 * y, origin.z as f32 * z],
            falling: [x < 0.0, y < 0.0, z < 0.0],
            ..self
        }
    }

    /// The parameter at which the ray's own parameter is t, from the nearest point, moved to the
    /// side of `sign` by as much as it, or a hit's own t, can be off.
    #[inline(always)]
    fn bound(&self, t: f64, sign: f64) -> f64 {
        let t = t * self.scale * self.inverse_unit;
        (t - self.shift) + sign * gamma(64) * (t.abs() + self.shift.abs() + self.reach)
    }

    /// The end of a ray that is cut at t.
    #[inline(always)]
    pub(super) fn end_at(&self, t: f64) -> f32 {
        rounded_up(self.bound(t, 1.0).min(self.reach) - self.start).min(self.end)
    }
}

#[inline(always)]
fn reciprocal(d: f32) -> f32 {
    1.0 / if d.abs() < FLATTEST { FLATTEST.copysign(d) } else { d }
}

/// Of a number that is not negative; nor is that.
#[inline(always)]
fn rounded_down(x: f64) -> f32 {
    x as f32 * (1.0 - f32::EPSILON)
}

#[inline(always)]
fn rounded_up(x: f64) -> f32 {
    (x as f32).next_up()
}

//! From the world to a surface's own frame and back, without losing what the ray's origin cancels.
//!
//! Before anything else the ray's origin moves along the ray to the point closest to the surface's
//! centre: all that follows is then of the surface's size, and so are its rounding errors, from
//! however far the ray comes. Any parameter will do for that move, so its own rounding does not
//! matter; what it cancels is kept by an exact difference and a fused multiply-add.

use crate::numeric::{gamma, reciprocal_power_of_two, two_diff};
use crate::{Affine, Ray, Vec3};

/// Where a surface stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// The world coordinates of the surface's centre.
    center: Vec3,
    /// A bound on the squared distance of the surface's points from there.
    radius2: f64,
    /// Twice the square root of that.
    reach: f64,
    turn: Turn,
}

/// The linear map from the world to a surface.
#[derive(Clone, Copy, Debug)]
enum Turn {
    /// None: the surface stands where it was built.
    Unplaced,
    /// None, but the surface was moved.
    Moved,
    /// By its rows.
    Rows([Vec3; 3]),
}

/// A ray as the surface sees it: relative to its centre, from nearby, and with a direction whose
/// largest coordinate is between 1 and 2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Between which parameters hits may lie; hits in the ray's own range never lie outside.
    pub(crate) range: [f64; 2],
    /// The ray's own parameter is `(shift + unit * local) * scale`.
    shift: f64,
    unit: f64,
    scale: f64,
}

impl LocalRay {
    /// The parameter in units of the ray's own direction.
    #[inline]
    pub(crate) fn world_t(&self, local: f64) -> f64 {
        (self.shift + self.unit * local) * self.scale
    }

    /// The inverse of [`world_t`](Self::world_t).
    #[inline]
    pub(crate) fn local_t(&self, t: f64) -> f64 {
        (t / self.scale - self.shift) / self.unit
    }
}

impl Frame {
    /// A surface that stands where it was built: its centre is on the axis at the height `center_z`,
    /// and no point is farther from there than `radius`.
    pub(crate) fn unplaced(center_z: f64, radius: f64) -> Self {
        let center = Vec3::new(0.0, 0.0, center_z);
        Self {
            center,
            radius2: grown(radius * radius),
            reach: 2.0 * grown(radius),
            turn: Turn::Unplaced,
        }
    }

    /// The same surface placed in the world; `None` if the placement has no finite inverse.
    pub(crate) fn placed(center_z: f64, radius: f64, placement: &Affine) -> Option<Self> {
        let inverse = placement.inverse_rows()?;
        let center = placement.point(Vec3::new(0.0, 0.0, center_z));
        let stretch = largest_stretch(placement);
        let radius2 = grown(stretch * stretch * (radius * radius));
        (radius2.is_finite() && center.is_finite()).then_some(Self {
            center,
            radius2,
            reach: 2.0 * grown(stretch * radius),
            turn: if inverse == Affine::IDENTITY.columns {
                Turn::Moved
            } else {
                Turn::Rows(inverse)
            },
        })
    }

    /// The rows of the linear map from the world to the surface; `None` if that was not placed.
    #[inline]
    pub(crate) fn inverse(&self) -> Option<&[Vec3; 3]> {
        match &self.turn {
            Turn::Unplaced => None,
            Turn::Moved => Some(&Affine::IDENTITY.columns),
            Turn::Rows(rows) => Some(rows),
        }
    }

    /// A unit normal of the surface, in the world.
    #[inline]
    pub(crate) fn normal(&self, own: Vec3) -> Vec3 {
        match &self.turn {
            Turn::Unplaced | Turn::Moved => own,
            Turn::Rows(rows) => turned_back(rows, own),
        }
    }

    /// A point of the surface in the world, where `placement` put it.
    #[inline]
    pub(crate) fn point(&self, placement: &Affine, own: Vec3) -> Vec3 {
        match &self.turn {
            Turn::Unplaced => own,
            Turn::Moved => own + placement.translation,
            Turn::Rows(_) => placement.point(own),
        }
    }

    /// The rows of the linear map from the world to the surface, unless that is the identity.
    #[inline(always)]
    pub(crate) fn rows(&self) -> Option<&[Vec3; 3]> {
        match &self.turn {
            Turn::Unplaced | Turn::Moved => None,
            Turn::Rows(rows) => Some(rows),
        }
    }

    /// The surface's centre, in the world.
    #[inline(always)]
    pub(crate) fn center(&self) -> Vec3 {
        self.center
    }

    /// A bound on the squared distance of the surface's points from there, in the world.
    #[inline(always)]
    pub(crate) fn radius2(&self) -> f64 {
        self.radius2
    }

    /// The height of the surface's centre, in the world.
    #[inline(always)]
    pub(crate) fn center_z(&self) -> f64 {
        self.center.z
    }

    /// The ray's origin, relative to the surface's centre, and direction as the surface sees them,
    /// neither moved nor scaled: the ray's parameter stays as it is.
    #[inline(always)]
    pub(crate) fn turn(&self, ray: &Ray) -> [Vec3; 2] {
        [self.turned(ray.origin - self.center), self.turned(ray.direction)]
    }

    /// A direction as the surface sees it.
    #[inline(always)]
    pub(crate) fn turned(&self, v: Vec3) -> Vec3 {
        match &self.turn {
            Turn::Unplaced | Turn::Moved => v,
            Turn::Rows(rows) => Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v)),
        }
    }

    /// Bounds on the terms that [`turn`](Self::turn) adds up, for the origin and for the direction.
    #[inline(always)]
    pub(crate) fn turned_size(&self, ray: &Ray) -> [f64; 2] {
        let (o, d) = ((ray.origin - self.center).abs(), ray.direction.abs());
        let Turn::Rows(rows) = &self.turn else { return [o.max_abs(), d.max_abs()] };
        let [x, y, z] = rows.map(Vec3::abs);
        let most = |v: Vec3| x.dot(v).max(y.dot(v)).max(z.dot(v));
        [most(o), most(d)]
    }

    /// A point relative to the surface's centre, in the directions of the world: each coordinate as a sum.
    #[inline(always)]
    pub(crate) fn relative(&self, point: Vec3) -> [(f64, f64); 3] {
        let (p, c) = (point, self.center);
        [two_diff(p.x, c.x), two_diff(p.y, c.y), two_diff(p.z, c.z)]
    }

    /// The ray in the surface's frame; `None` if it passes the surface at a distance, runs away from
    /// it, or is no ray.
    #[inline(always)]
    pub(crate) fn enter(&self, ray: &Ray) -> Option<LocalRay> {
        let largest = ray.direction.max_abs();
        let scale = reciprocal_power_of_two(largest);
        let direction = ray.direction * scale;
        // Not a number from here on, up to the comparison with the reach, if a coordinate is not
        // finite or the direction is zero.
        let per_length2 = 1.0 / direction.length_squared();

        let (x, x_low) = two_diff(ray.origin.x, self.center.x);
        let (y, y_low) = two_diff(ray.origin.y, self.center.y);
        let (z, z_low) = two_diff(ray.origin.z, self.center.z);
        let mut shift = -Vec3::new(x, y, z).dot(direction) * per_length2;
        let along = |t: f64, from: Vec3| {
            Vec3::new(
                t.mul_add(direction.x, from.x),
                t.mul_add(direction.y, from.y),
                t.mul_add(direction.z, from.z),
            )
        };
        let mut origin = along(shift, Vec3::new(x, y, z)) + Vec3::new(x_low, y_low, z_low);
        let rest = -origin.dot(direction);
        if rest * rest * per_length2 > self.radius2 {
            // From so far away that the parameter's own rounding is longer than the surface.
            let rest = rest * per_length2;
            shift += rest;
            origin = along(rest, origin);
        }

        let reach2 = self.radius2 - origin.length_squared();
        if reach2.is_nan() || reach2 < 0.0 {
            return None;
        }
        // The move went to the closest point only up to rounding, hence twice the radius. The
        // direction is no shorter than 1, unless it was subnormal.
        let mut reach = self.reach;
        if largest < f64::MIN_POSITIVE {
            reach *= per_length2.sqrt();
        }
        let rounding = |t: f64| gamma(16) * (t.abs() + shift.abs() + reach);
        let per_scale = 1.0 / scale;
        let (t_min, t_max) = (ray.t_min * per_scale, ray.t_max * per_scale);
        let lo = (t_min - shift - rounding(t_min)).max(-reach);
        let hi = (t_max - shift + rounding(t_max)).min(reach);
        if lo > hi {
            return None;
        }

        let mut unit = 1.0;
        let mut local = (origin, direction);
        if let Some(rows) = self.inverse() {
            let apply = |v: Vec3| Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
            let own = apply(direction);
            unit = reciprocal_power_of_two(own.max_abs());
            local = (apply(origin), own * unit);
        }
        let (origin, direction) = local;
        Some(LocalRay { origin, direction, range: [lo / unit, hi / unit], shift, unit, scale })
    }
}

/// A unit normal turned by the transpose of the inverse, whose rows these are.
#[inline]
pub(crate) fn turned_back(rows: &[Vec3; 3], own: Vec3) -> Vec3 {
    (rows[0] * own.x + rows[1] * own.y + rows[2] * own.z).normalized()
}

/// A squared radius with room for rounding on both sides of the comparison.
fn grown(radius2: f64) -> f64 {
    radius2 * (1.0 + gamma(64))
}

/// A bound on the factor by which a map stretches lengths: the square root of the largest row sum of
/// L^T L, exact for similarities.
pub(crate) fn largest_stretch(map: &Affine) -> f64 {
    let c = &map.columns;
    let row = |i: usize| (0..3).map(|j| c[i].dot(c[j]).abs()).sum::<f64>();
    row(0).max(row(1)).max(row(2)).sqrt()
}

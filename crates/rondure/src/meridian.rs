//! The ray seen in the half plane of the profile (algorithm of the paper, section 2, in ray
//! parameters).
//!
//! With rho the distance from the axis, a ray o + t d has
//!
//! ```text
//! rho(t)^2 = X(t)^2 + delta^2,   X = offset + speed t,   speed^2 = dx^2 + dy^2,
//! z(t)     = oz + t dz,          delta = (ox dy - oy dx) / speed,
//! ```
//!
//! that is, one branch of a hyperbola. A point (r, z) of the profile lies on it where
//!
//! ```text
//! F = X^2 + kappa - eta r^2 = 0,    X = x0 + slope (z - z0).
//! ```
//!
//! Steep rays (|dz| >= speed) have t = (z - oz) / dz, hence slope = speed / dz, eta = 1. For shallow
//! rays that would divide by the small dz; times dz^2 / speed^2 and centred where the ray passes the
//! axis, F = (z - z*)^2 - h^2 (r^2 - delta^2) with h = dz / speed stays sound down to dz = 0.

use crate::Vec3;
use crate::numeric::UNIT_ROUNDOFF;

/// A ray in the frame of a surface, with its origin next to the surface's centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meridian {
    /// dx^2 + dy^2, as a length.
    pub(crate) speed: f64,
    /// 1 / speed; 0 for a ray parallel to the axis.
    pub(crate) inverse_speed: f64,
    /// X at t = 0.
    pub(crate) offset: f64,
    /// The squared distance at which the ray passes the axis.
    pub(crate) delta2: f64,
    pub(crate) oz: f64,
    pub(crate) dz: f64,
    pub(crate) inverse_dz: f64,
    /// Whether |dz| >= speed.
    pub(crate) steep: bool,
    z0: f64,
    x0: f64,
    slope: f64,
    kappa: f64,
    /// The slope of a shallow ray against the plane z = 0, or 1 for a steep one.
    pub(crate) h: f64,
    /// h^2.
    pub(crate) eta: f64,
}

/// Below this squared speed (the direction's largest coordinate is between 1 and 2) a ray moves less
/// than 1e-100 of the surface's size sideways while it passes, and squares begin to vanish: it is
/// parallel to the axis.
const PARALLEL: f64 = 1e-200;

/// Below this eta a ray moves less than 1e-100 of the surface's size along the axis while it passes:
/// it is perpendicular to the axis.
const PERPENDICULAR: f64 = 1e-200;

impl Meridian {
    /// `origin` is relative to the surface's centre and no farther from it than a few of the
    /// surface's sizes; the largest coordinate of `direction` lies between 1 and 2.
    #[inline(always)]
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        // Adding zero takes the sign off -0: dz and 1 / dz then agree on which way the ray goes.
        let (o, d) = (origin, Vec3 { z: direction.z + 0.0, ..direction });
        let a = d.x * d.x + d.y * d.y;
        let (speed, inverse_speed, offset, delta2) = if a < PARALLEL {
            (0.0, 0.0, o.x.hypot(o.y), 0.0)
        } else {
            let speed = a.sqrt();
            let inverse_speed = 1.0 / speed;
            let delta = (o.x * d.y - o.y * d.x) * inverse_speed;
            (speed, inverse_speed, (o.x * d.x + o.y * d.y) * inverse_speed, delta * delta)
        };
        let inverse_dz = 1.0 / d.z;
        let steep = d.z.abs() >= speed;
        let (z0, x0, slope, kappa, h, eta) = if steep {
            (o.z, offset, speed * inverse_dz, delta2, 1.0, 1.0)
        } else {
            let h = d.z * inverse_speed;
            let eta = if h * h < PERPENDICULAR { 0.0 } else { h * h };
            (o.z - h * offset, 0.0, 1.0, eta * delta2, h.abs(), eta)
        };
        Self {
            speed,
            inverse_speed,
            offset,
            delta2,
            oz: o.z,
            dz: d.z,
            inverse_dz,
            steep,
            z0,
            x0,
            slope,
            kappa,
            h,
            eta,
        }
    }

    /// X at a height. It grows, or falls, linearly with the height.
    #[inline(always)]
    pub(crate) fn x(&self, z: f64) -> f64 {
        self.x0 + self.slope * (z - self.z0)
    }

    /// The factor between a difference of heights and the difference of X.
    #[inline(always)]
    pub(crate) fn slope(&self) -> f64 {
        self.slope
    }

    /// F for two points of the profile, as a symmetric bilinear form: with both points the same it
    /// is F itself, which is negative where the point is farther from the axis than the ray is at
    /// its height.
    #[inline(always)]
    pub(crate) fn form(&self, [x_a, x_b]: [f64; 2], [r_a, r_b]: [f64; 2]) -> f64 {
        (x_a * x_b - self.eta * (r_a * r_b)) + self.kappa
    }

    /// A bound on the error of [`form`](Self::form) where |X| <= `x` and r <= `r`, not counting that
    /// of X and r themselves, per unit of relative rounding.
    #[inline]
    pub(crate) fn magnitude(&self, x: f64, r: f64) -> f64 {
        x * x + self.eta * (r * r) + self.kappa
    }

    /// The coefficients of rho^2 = a t^2 + 2 b t + c.
    #[inline]
    pub(crate) fn squared_distance(&self) -> (f64, f64, f64) {
        let (speed, offset) = (self.speed, self.offset);
        (speed * speed, speed * offset, offset * offset + self.delta2)
    }

    /// delta^2, to the scale of F.
    #[inline]
    pub(crate) fn kappa(&self) -> f64 {
        self.kappa
    }

    /// The ray parameter at a point of the profile that lies on the meridian; `above` tells on which
    /// side of the axis' closest point a shallow ray is: X >= 0, or X < 0.
    ///
    /// Of z = oz + t dz and r^2 = X(t)^2 + delta^2 the better conditioned one is solved for t. A
    /// rounding error of u in r^2 moves X by u r^2 / |X|, one in z moves it by u r / h; and where X
    /// itself is below the rounding sqrt(u) r of its square, the latter is larger for h^2 < u.
    #[inline(always)]
    pub(crate) fn t(&self, r: f64, z: f64, above: bool) -> f64 {
        if self.steep {
            return (z - self.oz) * self.inverse_dz;
        }
        let reach2 = self.reach2(r);
        if reach2 >= self.eta * (r * r) || self.eta <= UNIT_ROUNDOFF {
            let outward = above == (self.dz >= 0.0);
            let reach = reach2.max(0.0).sqrt();
            let x = if outward { reach } else { -reach };
            (x - self.offset) * self.inverse_speed
        } else {
            (z - self.oz) * self.inverse_dz
        }
    }

    /// The squared distance, along the ray's shadow on the plane z = 0, from the point closest to
    /// the axis to the circle of radius r; not positive where the ray stays outside the circle.
    #[inline(always)]
    pub(crate) fn reach2(&self, r: f64) -> f64 {
        r * r - self.delta2
    }

    /// The two ray parameters at which a ray perpendicular to the axis meets a circle of radius r,
    /// in order; `None` if it passes outside.
    #[inline]
    pub(crate) fn chord(&self, r: f64) -> Option<[f64; 2]> {
        let reach2 = self.reach2(r);
        (reach2 > 0.0).then(|| {
            let reach = reach2.sqrt();
            [-reach, reach].map(|x| (x - self.offset) * self.inverse_speed)
        })
    }
}

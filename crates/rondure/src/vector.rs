//! Points and directions in space, and the ray.

use core::ops::{Add, AddAssign, Div, Index, Mul, Neg, Sub};

/// A point or a direction in space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate; in an object's own frame, the axis of revolution.
    pub z: f64,
}

impl Vec3 {
    /// The origin.
    pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);
    /// The direction of the first axis.
    pub const X: Self = Self::new(1.0, 0.0, 0.0);
    /// The direction of the second axis.
    pub const Y: Self = Self::new(0.0, 1.0, 0.0);
    /// The direction of the third axis, the axis of revolution.
    pub const Z: Self = Self::new(0.0, 0.0, 1.0);

    /// The vector (x, y, z).
    #[inline]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// The vector whose three coordinates are `v`.
    #[inline]
    pub const fn splat(v: f64) -> Self {
        Self::new(v, v, v)
    }

    /// The dot product.
    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The cross product, right-handed.
    #[inline]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// The squared length.
    #[inline]
    pub fn length_squared(self) -> f64 {
        self.dot(self)
    }

    /// The length.
    #[inline]
    pub fn length(self) -> f64 {
        self.length_squared().sqrt()
    }

    /// The vector of length 1 in the same direction. The zero vector has none: the result is NaN.
    #[inline]
    pub fn normalized(self) -> Self {
        self / self.length()
    }

    /// The largest absolute value of a coordinate.
    #[inline]
    pub fn max_abs(self) -> f64 {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// The smaller of the two, coordinate by coordinate.
    #[inline]
    pub fn min(self, other: Self) -> Self {
        Self::new(self.x.min(other.x), self.y.min(other.y), self.z.min(other.z))
    }

    /// The larger of the two, coordinate by coordinate.
    #[inline]
    pub fn max(self, other: Self) -> Self {
        Self::new(self.x.max(other.x), self.y.max(other.y), self.z.max(other.z))
    }

    /// The absolute values of the coordinates.
    #[inline]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// Whether no coordinate is infinite or NaN.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }

    /// Two directions that, with this unit vector as the third, form a right-handed orthonormal
    /// frame (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    #[inline]
    pub fn orthonormal_basis(self) -> (Self, Self) {
        let sign = 1.0_f64.copysign(self.z);
        let a = -1.0 / (sign + self.z);
        let b = self.x * self.y * a;
        (
            Self::new(1.0 + sign * self.x * self.x * a, sign * b, -sign * self.x),
            Self::new(b, sign + self.y * self.y * a, -self.y),
        )
    }
}

impl Add for Vec3 {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl AddAssign for Vec3 {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Vec3 {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Mul<Vec3> for f64 {
    type Output = Vec3;
    #[inline]
    fn mul(self, v: Vec3) -> Vec3 {
        v * self
    }
}

impl Div<f64> for Vec3 {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self::new(self.x / divisor, self.y / divisor, self.z / divisor)
    }
}

impl Index<usize> for Vec3 {
    type Output = f64;
    #[inline]
    fn index(&self, axis: usize) -> &f64 {
        match axis {
            0 => &self.x,
            1 => &self.y,
            _ => &self.z,
        }
    }
}

/// A half line, or a stretch of one: the points `origin + t direction` with `t_min <= t <= t_max`.
///
/// The direction need not have unit length; `t` counts in units of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at t = 0.
    pub origin: Vec3,
    /// The direction; not zero.
    pub direction: Vec3,
    /// The smallest t at which a hit counts.
    pub t_min: f64,
    /// The largest t at which a hit counts; may be infinite.
    pub t_max: f64,
}

impl Ray {
    /// The half line from `origin`: t from 0 to infinity.
    #[inline]
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    /// The whole line: t from minus infinity to infinity.
    #[inline]
    pub const fn line(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: f64::NEG_INFINITY, t_max: f64::INFINITY }
    }

    /// The same ray, cut to `t_min <= t <= t_max`.
    #[inline]
    pub const fn with_range(self, t_min: f64, t_max: f64) -> Self {
        Self { t_min, t_max, ..self }
    }

    /// The whole line that the ray is part of.
    #[inline]
    pub const fn whole(self) -> Self {
        Self::line(self.origin, self.direction)
    }

    /// The point `origin + t direction`.
    #[inline]
    pub fn at(&self, t: f64) -> Vec3 {
        self.origin + self.direction * t
    }
}

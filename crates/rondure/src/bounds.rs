//! The axis-aligned box round something.

use crate::Vec3;

/// An axis-aligned box, corners included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box with nothing in it: what a union starts from.
    pub const EMPTY: Self =
        Self { min: Vec3::splat(f64::INFINITY), max: Vec3::splat(f64::NEG_INFINITY) };

    /// The box that holds the origin alone.
    pub(crate) const ORIGIN: Self = Self { min: Vec3::ZERO, max: Vec3::ZERO };

    /// The smallest box round both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box grown to hold `point`.
    #[inline]
    pub fn with_point(&self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The middle of the box.
    #[inline]
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// The lengths of the box's edges.
    #[inline]
    pub fn extent(&self) -> Vec3 {
        self.max - self.min
    }

    /// The area of the box's six faces; zero for the empty box.
    #[inline]
    pub fn area(&self) -> f64 {
        let e = self.extent().max(Vec3::ZERO);
        2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
    }

    /// Whether the point lies in the box or on its boundary.
    #[inline]
    pub fn contains(&self, p: Vec3) -> bool {
        (0..3).all(|i| self.min[i] <= p[i] && p[i] <= self.max[i])
    }
}

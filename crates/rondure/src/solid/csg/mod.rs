//! Constructive solid geometry: union, intersection and difference of placed solids, on spans.
//!
//! ```text
//! Csg (an expression) -> Compound: leaves + formula -> per ray: toggles of all leaves, in order
//!                                                   -> where the formula's value changes: spans
//! ```
//!
//! All leaves of an expression are looked at together, whatever its shape: what is inside is a formula
//! in the leaves, read between their boundaries. So the laws of sets hold exactly: two expressions in
//! the same primitives that are equal as sets have the same spans. Boundaries that rounding cannot tell
//! apart change together; `docs/solids.md` has the rules.

mod compound;
mod formula;
mod leaf;

pub use compound::{Compound, Face};
pub use leaf::Primitive;

use core::fmt;
use std::sync::Arc;

use super::Solid;
use crate::{Affine, Bounds, Vec3};

/// An expression in solids, to be [built](Csg::build).
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use rondure::{Profile, Ray, Solid, Vec3, solid::{Csg, FillRule}};
/// use std::sync::Arc;
///
/// let rod = Profile::from_path_data("M 0 -3 L 1 -3 L 1 3 L 0 3")?;
/// let rod = Csg::turned(Arc::new(Solid::new(&rod, FillRule::NonZero)?));
/// let cut = rod.intersection(Csg::half_space(Vec3::ZERO, Vec3::Z)).build()?;
///
/// let mut spans = Vec::new();
/// cut.spans(&Ray::new(Vec3::new(0.0, 0.0, 9.0), -Vec3::Z), &mut spans);
/// assert_eq!([spans[0].enter.t, spans[0].exit.t], [9.0, 12.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub enum Csg {
    /// A primitive solid, placed in the world.
    Primitive(Primitive, Affine),
    /// What is in any of the operands.
    Union(Vec<Csg>),
    /// What is in all of the operands.
    Intersection(Vec<Csg>),
    /// What is in the first operand and in none of the others.
    Difference(Vec<Csg>),
}

impl Csg {
    /// A turned solid, where it was built.
    pub fn turned(solid: Arc<Solid>) -> Self {
        Self::Primitive(Primitive::Turned(solid), Affine::IDENTITY)
    }

    /// All points on one side of the plane through `point`: those to which the normal does not point.
    pub fn half_space(point: Vec3, normal: Vec3) -> Self {
        Self::Primitive(Primitive::HalfSpace { point, normal }, Affine::IDENTITY)
    }

    /// A box along the axes.
    pub fn cuboid(bounds: Bounds) -> Self {
        Self::Primitive(Primitive::Cuboid(bounds), Affine::IDENTITY)
    }

    /// A ball: the turned half circle.
    pub fn sphere(center: Vec3, radius: f64) -> Self {
        let placement = Affine::translate(center).after(&Affine::scale(Vec3::splat(radius)));
        Self::Primitive(Primitive::Turned(Solid::unit_ball()), placement)
    }

    /// The union with another.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self::Union(vec![self, other])
    }

    /// The intersection with another.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        Self::Intersection(vec![self, other])
    }

    /// What is left when another is taken away.
    #[must_use]
    pub fn difference(self, other: Self) -> Self {
        Self::Difference(vec![self, other])
    }

    /// The whole expression, mapped.
    #[must_use]
    pub fn placed(self, map: &Affine) -> Self {
        let all = |operands: Vec<Self>| operands.into_iter().map(|o| o.placed(map)).collect();
        match self {
            Self::Primitive(primitive, placement) => {
                Self::Primitive(primitive, map.after(&placement))
            }
            Self::Union(operands) => Self::Union(all(operands)),
            Self::Intersection(operands) => Self::Intersection(all(operands)),
            Self::Difference(operands) => Self::Difference(all(operands)),
        }
    }

    /// Makes the expression ready for rays.
    ///
    /// # Errors
    ///
    /// [`CsgError`] for the first primitive or operation that makes no sense.
    pub fn build(&self) -> Result<Compound, CsgError> {
        Compound::new(self)
    }
}

/// Why an expression was refused. Primitives are counted from 0, from left to right.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CsgError {
    /// A union, intersection or difference has no operands.
    NoOperands,
    /// A placement flattens space, or is not finite.
    Placement {
        /// The index of the primitive.
        leaf: usize,
    },
    /// The normal of a half space is zero or not finite, or its point is not finite.
    HalfSpace {
        /// The index of the primitive.
        leaf: usize,
        /// The normal.
        normal: Vec3,
    },
    /// A box has no volume, or is not finite.
    Cuboid {
        /// The index of the primitive.
        leaf: usize,
        /// The box.
        bounds: Bounds,
    },
}

impl fmt::Display for CsgError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoOperands => {
                write!(f, "a union, an intersection or a difference needs at least one operand")
            }
            Self::Placement { leaf } => write!(
                f,
                "primitive {leaf}: the placement has no finite inverse; it must not flatten space"
            ),
            Self::HalfSpace { leaf, normal: Vec3 { x, y, z } } => write!(
                f,
                "primitive {leaf}: the half space has the normal ({x}, {y}, {z}); the normal must be \
                 finite and not zero, its point finite"
            ),
            Self::Cuboid { leaf, bounds: Bounds { min, max } } => write!(
                f,
                "primitive {leaf}: the box from ({}, {}, {}) to ({}, {}, {}) has no volume; each \
                 coordinate must be finite and grow from the first corner to the second",
                min.x, min.y, min.z, max.x, max.y, max.z
            ),
        }
    }
}

impl core::error::Error for CsgError {}

//! Sweeps over a part of the turn: a wedge between two half planes that end on the axis.
//!
//! A solid swept from one angle to another is the whole one within the wedge, closed by the two plane
//! faces; a surface left open is the part of it within the wedge. The wedge is the intersection of two
//! half spaces, or from half a turn on their union, so that all that holds of CSG holds of it.

use super::{Csg, SolidError, Span};
use crate::solid::{Compound, Face};
use crate::{Hit, Instance, Ray, Vec3};

/// A part of the turn round the z axis, counterclockwise seen from above; the x axis is at angle 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// The cosines and sines of the first and the last angle.
    ends: [[f64; 2]; 2],
    extent: Extent,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Extent {
    /// Up to half a turn.
    Narrow,
    Wide,
    Whole,
}

impl Sweep {
    /// From one angle to a larger one, in radians, by no more than a whole turn.
    ///
    /// # Errors
    ///
    /// [`SolidError::Sweep`] if the angles are not finite, or not in order, or more than a turn apart.
    pub fn radians(from: f64, to: f64) -> Result<Self, SolidError> {
        let end = |angle: f64| [angle.cos(), angle.sin()];
        Self::new([from, to], core::f64::consts::TAU, end)
    }

    /// From one angle to a larger one, in degrees, by no more than a whole turn. Multiples of 90 are
    /// exact.
    ///
    /// # Errors
    ///
    /// As for [`radians`](Self::radians).
    pub fn degrees(from: f64, to: f64) -> Result<Self, SolidError> {
        let end = |angle: f64| {
            let quarters = (angle / 90.0).round();
            let (sin, cos) = (angle - 90.0 * quarters).to_radians().sin_cos();
            match quarters.rem_euclid(4.0) as u32 {
                0 => [cos, sin],
                1 => [-sin, cos],
                2 => [-cos, -sin],
                _ => [sin, -cos],
            }
        };
        Self::new([from, to], 360.0, end)
    }

    fn new(
        [from, to]: [f64; 2],
        turn: f64,
        end: impl Fn(f64) -> [f64; 2],
    ) -> Result<Self, SolidError> {
        let sweep = to - from;
        if !(from.is_finite() && to.is_finite() && 0.0 < sweep && sweep <= turn) {
            return Err(SolidError::Sweep { from, to, turn });
        }
        let extent = if sweep == turn {
            Extent::Whole
        } else if sweep > 0.5 * turn {
            Extent::Wide
        } else {
            Extent::Narrow
        };
        Ok(Self { ends: [end(from), end(to)], extent })
    }

    /// All points whose angle is in the sweep, as two half spaces: the one beyond the first angle and
    /// the one before the last. `None` if it is a whole turn.
    pub fn wedge(&self) -> Option<Csg> {
        let [[c0, s0], [c1, s1]] = self.ends;
        let faces = [Vec3::new(s0, -c0, 0.0), Vec3::new(-s1, c1, 0.0)]
            .map(|normal| Csg::half_space(Vec3::ZERO, normal))
            .to_vec();
        match self.extent {
            Extent::Narrow => Some(Csg::Intersection(faces)),
            Extent::Wide => Some(Csg::Union(faces)),
            Extent::Whole => None,
        }
    }
}

impl Csg {
    /// The part of a solid within a sweep round the z axis, closed by its two plane faces: two more
    /// primitives behind those of the solid, first the face at the first angle.
    #[must_use]
    pub fn swept(self, sweep: &Sweep) -> Self {
        match sweep.wedge() {
            Some(wedge) => self.intersection(wedge),
            None => self,
        }
    }
}

/// A placed surface swept over a part of the turn and left open: no faces close it.
#[derive(Clone, Debug)]
pub struct OpenSweep {
    instance: Instance,
    /// `None` for a whole turn.
    wedge: Option<Compound>,
}

impl OpenSweep {
    /// The part of a surface within a sweep round its own axis.
    ///
    /// # Errors
    ///
    /// [`CsgError`](super::CsgError) if the placement has no finite inverse; an instance's has.
    pub fn new(instance: Instance, sweep: &Sweep) -> Result<Self, super::CsgError> {
        let wedge = sweep.wedge().map(|w| w.placed(instance.placement()).build()).transpose()?;
        Ok(Self { instance, wedge })
    }

    /// The whole surface, of which this is a part: it answers for the hits.
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    /// All hits in the range of a ray in the world, in order of t. `hits` is cleared first.
    ///
    /// A hit within rounding of an edge may count or not.
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.instance.all(ray, hits);
        let Some(wedge) = &self.wedge else { return };
        if hits.is_empty() {
            return;
        }
        let mut within: Vec<Span<Face>> = Vec::new();
        wedge.spans(&ray.whole(), &mut within);
        hits.retain(|hit| within.iter().any(|s| s.enter.t <= hit.t && hit.t <= s.exit.t));
    }

    /// The hit with the smallest t in the range, if there is one.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hits = Vec::new();
        self.all(ray, &mut hits);
        hits.first().copied()
    }

    /// Whether there is any hit in the range.
    pub fn any(&self, ray: &Ray) -> bool {
        self.closest(ray).is_some()
    }
}

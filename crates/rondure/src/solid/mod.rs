//! Solids: what a profile bounds, as stretches of rays, inside tests and distances.
//!
//! ```text
//! Ray -> crossings (hit, step) -> winding number -> fill rule -> spans       span.rs
//! point -> half plane -> winding number -> fill rule -> inside               outline.rs
//!                     -> nearest piece -> nearest point -> signed distance   nearest.rs
//! ```
//!
//! The rules that decide what is inside stand in `docs/solids.md`.

mod outline;
mod span;

pub use span::{Boundary, Span, Wall};

use core::fmt;
use std::sync::Arc;

use crate::frame::Frame;
use crate::interaction::{Interaction, interaction, normal};
use crate::{Affine, Bounds, Point, Profile, Ray, Surface, Vec3};
use outline::Outline;
use span::{Coincidence, Crossing, append_spans};

/// What is inside where a profile crosses itself or has several subpaths, as SVG's `fill-rule` has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillRule {
    /// A point is inside if the profile winds round it, all subpaths counted together.
    #[default]
    NonZero,
    /// A point is inside if it is enclosed an odd number of times.
    EvenOdd,
}

impl FillRule {
    /// Whether a point with this winding number is inside.
    #[inline]
    pub fn is_inside(self, winding: i32) -> bool {
        match self {
            Self::NonZero => winding != 0,
            Self::EvenOdd => winding % 2 != 0,
        }
    }
}

/// Why a profile bounds no solid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolidError {
    /// A subpath is neither closed nor has both ends on the axis.
    Open {
        /// The index of the subpath.
        subpath: usize,
        /// Its two ends.
        ends: [Point; 2],
    },
}

impl fmt::Display for SolidError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open { subpath, ends: [a, b] } => write!(
                f,
                "subpath {subpath} bounds no solid: it runs from (r = {}, z = {}) to (r = {}, z = {}); \
                 close it, let both ends lie on the axis, or cap it",
                a.r, a.z, b.r, b.z
            ),
        }
    }
}

impl core::error::Error for SolidError {}

/// The solid that a profile bounds when it is swept round the z axis: every subpath closed, or with
/// both ends on the axis.
///
/// Made once, then immutable; the [`Surface`] is shared.
#[derive(Clone, Debug)]
pub struct Solid {
    surface: Arc<Surface>,
    rule: FillRule,
    outline: Outline,
}

impl Solid {
    /// The solid of a profile.
    ///
    /// # Errors
    ///
    /// [`SolidError::Open`] if a subpath bounds no solid.
    pub fn new(profile: &Profile, rule: FillRule) -> Result<Self, SolidError> {
        Self::from_surface(Arc::new(Surface::new(profile)), rule)
    }

    /// The solid that a surface bounds; on the paper's engines, that of its frusta.
    ///
    /// # Errors
    ///
    /// [`SolidError::Open`] if a subpath of its profile bounds no solid.
    pub fn from_surface(surface: Arc<Surface>, rule: FillRule) -> Result<Self, SolidError> {
        let mut subpaths = surface.profile().subpaths().iter().enumerate();
        if let Some((subpath, open)) = subpaths.find(|(_, s)| !s.bounds_solid()) {
            return Err(SolidError::Open { subpath, ends: [open.start(), open.end()] });
        }
        let outline = Outline::new(&surface.pieces);
        Ok(Self { surface, rule, outline })
    }

    /// The surface that bounds the solid.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// The fill rule.
    pub fn fill_rule(&self) -> FillRule {
        self.rule
    }

    /// The box round the solid.
    pub fn bounds(&self) -> Bounds {
        self.surface.bounds()
    }

    /// The stretches of a ray inside the solid: in order, disjoint, none of length zero, between
    /// `t_min` and `t_max`. `spans` is cleared first.
    ///
    /// By construction there is no ray, through whatever joint, pole or tangency, along which the
    /// inside leaks out: beyond the last crossing the ray is outside. Spans and gaps that are no longer
    /// than rounding can make them are none: a few 1e-14 of the solid's size across the surface, up to
    /// about 1e-7 along it at a tangency.
    pub fn spans(&self, ray: &Ray, spans: &mut Vec<Span>) {
        spans.clear();
        let off = self.surface.rounding(&Affine::IDENTITY);
        self.append_spans_from(&self.surface.frame, off, ray, spans);
    }

    /// `off` bounds the rounding of the surface where it stands.
    pub(crate) fn append_spans_from(
        &self,
        frame: &Frame,
        off: f64,
        ray: &Ray,
        spans: &mut Vec<Span>,
    ) {
        let mut crossings = Vec::new();
        self.surface.crossings_from(frame, ray, |hit, step| crossings.push(Crossing { hit, step }));
        let coincidence = Coincidence::new(off, ray.direction);
        let sine = |c: &Crossing| {
            coincidence.sine(normal(&self.surface, frame, ray, &c.hit), ray.direction)
        };
        let coincide =
            |a: &Crossing, b: &Crossing| coincidence.holds(a.hit.t, b.hit.t, || [sine(a), sine(b)]);
        append_spans(&mut crossings, self.rule, coincide, [ray.t_min, ray.t_max], spans);
    }

    /// The full answer for a wall that this solid reported for this ray; the normal points out of
    /// the solid.
    pub fn interaction(&self, ray: &Ray, wall: &Wall) -> Interaction {
        let placement = Affine::IDENTITY;
        let rounding = self.surface.rounding(&placement);
        self.interaction_from(&self.surface.frame, &placement, rounding, ray, wall)
    }

    pub(crate) fn interaction_from(
        &self,
        frame: &Frame,
        placement: &Affine,
        rounding: f64,
        ray: &Ray,
        wall: &Wall,
    ) -> Interaction {
        let at = interaction(&self.surface, frame, placement, rounding, ray, &wall.hit);
        let sense = self.surface.curve_at(&wall.hit).1.sense;
        Interaction { normal: at.normal * (sense * f64::from(wall.outside)), ..at }
    }

    /// Whether a point lies inside the solid. Points within rounding of the surface, a few units in
    /// the last place of the solid's size, may go either way; points that are not finite are outside.
    pub fn contains(&self, point: Vec3) -> bool {
        self.contains_own(self.own(point))
    }

    /// The point relative to the surface's centre.
    fn own(&self, point: Vec3) -> Vec3 {
        Vec3 { z: point.z - self.surface.center_z, ..point }
    }

    pub(crate) fn contains_own(&self, p: Vec3) -> bool {
        let at = Point::new(p.x.hypot(p.y), p.z);
        self.rule.is_inside(self.outline.winding(&self.surface.pieces, at))
    }
}

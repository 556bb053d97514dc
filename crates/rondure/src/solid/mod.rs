//! Solids: what a profile bounds, as stretches of rays, inside tests and distances.
//!
//! ```text
//! Ray -> crossings (hit, step) -> winding number -> fill rule -> spans       span.rs
//! point -> half plane -> winding number -> fill rule -> inside               outline.rs
//!                     -> nearest piece -> nearest point -> signed distance   nearest.rs
//! many solids, a formula -> their boundaries together -> spans              csg/
//! ```
//!
//! The rules that decide what is inside stand in `docs/solids.md`.

mod csg;
mod nearest;
mod outline;
mod skin;
mod span;
mod stretch;
mod sweep;

pub use csg::{Compound, Csg, CsgError, Face, Primitive};
pub use span::{Boundary, Span, Wall};
pub use sweep::{OpenSweep, Sweep};

use core::cell::Cell;
use core::fmt;
use std::sync::{Arc, OnceLock};

use crate::frame::Frame;
use crate::interaction::{Interaction, interaction, normal};
use crate::{Affine, Bounds, Hit, Point, Profile, Ray, Surface, Vec3};
use nearest::Best;
use outline::Outline;
use skin::Skin;
use span::{Coincidence, Crossing, append_spans};

thread_local! {
    /// The room that the crossings of a ray take, kept for the next one.
    static CROSSINGS: Cell<Vec<Crossing>> = const { Cell::new(Vec::new()) };
}

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

/// Why a profile bounds no solid, or a sweep is none.
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
    /// A sweep that runs backwards, nowhere, or more than a whole turn.
    Sweep {
        /// The first angle.
        from: f64,
        /// The last angle.
        to: f64,
        /// A whole turn, in the unit of the angles.
        turn: f64,
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
            Self::Sweep { from, to, turn } => write!(
                f,
                "the sweep runs from {from} to {to}; the second angle must be larger than the first, by \
                 at most a whole turn, {turn}"
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
    /// Made when a distance is first asked for.
    skin: OnceLock<Skin>,
}

/// The point of a solid's surface nearest to some point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The distance, negative inside.
    pub distance: f64,
    /// The nearest point. Seen from the axis all points of a circle are equally near; it is the one in
    /// the direction of x. Of several others it is any.
    pub point: Vec3,
    /// The unit normal there, out of the solid; at an edge of the solid, that of one of its sides.
    pub normal: Vec3,
    /// The segment of the profile, counted over all subpaths.
    pub segment: usize,
    /// The piece of the profile and the parameter on it, from 0 to 1.
    pub piece: u32,
    /// See `piece`.
    pub s: f64,
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
        if let Some((subpath, ends)) = surface.pieces.open_subpath() {
            return Err(SolidError::Open { subpath, ends });
        }
        Ok(Self::bounded_by(surface, rule))
    }

    /// The ball of radius 1 about the origin, made once.
    pub(crate) fn unit_ball() -> Arc<Self> {
        static BALL: OnceLock<Arc<Solid>> = OnceLock::new();
        let make = || {
            let surface = Surface::new(&Profile::half_circle());
            Arc::new(Self::bounded_by(Arc::new(surface), FillRule::NonZero))
        };
        Arc::clone(BALL.get_or_init(make))
    }

    fn bounded_by(surface: Arc<Surface>, rule: FillRule) -> Self {
        let ends: Vec<_> = surface.pieces.iter().map(|p| [p.start(), p.end()]).collect();
        let outline = Outline::new(&ends);
        Self { surface, rule, outline, skin: OnceLock::new() }
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
        let mut crossings = CROSSINGS.take();
        crossings.clear();
        self.surface.crossings_from(frame, ray, |hit, step| crossings.push(Crossing { hit, step }));
        let coincidence = Coincidence::new(ray.direction);
        let sine = |c: &Crossing| {
            coincidence.sine(normal(&self.surface, frame, ray, &c.hit), ray.direction)
        };
        let coincide = |a: &Crossing, b: &Crossing| {
            coincidence.holds(a.hit.t, b.hit.t, off, || [sine(a), sine(b)])
        };
        append_spans(&mut crossings, self.rule, coincide, [ray.t_min, ray.t_max], spans);
        CROSSINGS.set(crossings);
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
        Interaction { normal: at.normal * self.outward(wall), ..at }
    }

    /// 1 if the surface's normal points out of the solid at a wall, otherwise -1.
    pub(crate) fn outward(&self, wall: &Wall) -> f64 {
        self.surface.detail_at(&wall.hit).sense() * f64::from(wall.outside)
    }

    /// Whether a point lies inside the solid. Points within rounding of the surface, a few units in
    /// the last place of the solid's size, may go either way; points that are not finite are outside.
    pub fn contains(&self, point: Vec3) -> bool {
        self.contains_own(self.own(point))
    }

    /// The signed distance from a point to the surface of the solid, negative inside: what
    /// [`nearest`](Self::nearest) finds. Infinite if the solid is empty, NaN if the point is.
    pub fn distance(&self, point: Vec3) -> f64 {
        match self.nearest(point) {
            Some(nearest) => nearest.distance,
            None if point.is_finite() => f64::INFINITY,
            None => f64::NAN,
        }
    }

    /// The nearest point of the solid's surface; `None` if the solid is empty, as a face drawn back and
    /// forth is, or the point is not finite.
    ///
    /// The distance is exact to rounding: within 64 u of the larger of the solid's size and the
    /// distance itself. Parts of the profile that lie within the solid, where it crosses itself, are no
    /// surface. The first call looks for them.
    pub fn nearest(&self, point: Vec3) -> Option<Nearest> {
        let (surface, pieces) = (&*self.surface, &self.surface.pieces);
        let own = self.own(point);
        if !own.is_finite() {
            return None;
        }
        let inside = |p: Point| self.rule.is_inside(self.outline.winding(pieces, p));
        let skin = self.skin.get_or_init(|| {
            Skin::new(&pieces.iter().collect::<Vec<_>>(), &self.outline, surface.radius, inside)
        });
        let tree = skin.tree.as_ref()?;
        let q = Point::new(own.x.hypot(own.y), own.z);
        let Best { distance, piece, s } =
            nearest::nearest(pieces, |edge| skin.edges[edge], tree, q, surface.radius);
        let hit = Hit { t: 0.0, piece, s };
        let at = pieces.jet(piece as usize, s);
        let (at, mut tangent) = (at.point, at.tangent);
        if tangent == Point::default() {
            let [start, end] = pieces.ends(piece as usize);
            tangent = end - start;
        }
        let speed = tangent.length();
        let right = Point::new(tangent.z / speed, -tangent.r / speed);
        let is_inside = inside(q);
        // The way to the point tells the side, unless it is nothing but rounding.
        let aside = 16.0 * nearest::rounding(surface.radius, 0.0);
        let to_right = (q.r - at.r) * right.r + (q.z - at.z) * right.z;
        let outside_right = if to_right.abs() > aside {
            (to_right > 0.0) != is_inside
        } else {
            let beside = at + right * aside;
            !inside(Point { r: beside.r.max(0.0), ..beside })
        };
        let normal = if outside_right { right } else { right * -1.0 };
        let [cos, sin] = if q.r > 0.0 { [own.x / q.r, own.y / q.r] } else { [1.0, 0.0] };
        Some(Nearest {
            distance: if is_inside { -distance } else { distance },
            point: Vec3::new(at.r * cos, at.r * sin, at.z + surface.center_z),
            normal: Vec3::new(normal.r * cos, normal.r * sin, normal.z),
            segment: surface.segment(&hit),
            piece,
            s,
        })
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

//! The primitives of an expression, placed: where a line passes their boundaries.

use std::sync::Arc;

use super::CsgError;
use crate::frame::{Frame, LocalRay};
use crate::interaction::{Interaction, normal};
use crate::numeric::{gamma, two_diff};
use crate::solid::span::Coincidence;
use crate::solid::{Boundary, Solid, Span, Wall};
use crate::surface::placed_rounding;
use crate::{Affine, Bounds, Ray, Vec3};

/// A solid that expressions are made of, in its own frame.
#[derive(Clone, Debug)]
pub enum Primitive {
    /// What a profile bounds.
    Turned(Arc<Solid>),
    /// All points on one side of a plane.
    HalfSpace {
        /// A point of the plane.
        point: Vec3,
        /// A normal of the plane, of any length; it points out of the half space.
        normal: Vec3,
    },
    /// A box along the axes of its frame.
    Cuboid(Bounds),
}

/// A placed primitive.
#[derive(Clone, Debug)]
pub(super) struct Leaf {
    shape: Shape,
    frame: Frame,
    placement: Affine,
    /// How far off rounding can move a point of its surface, or a ray in its frame.
    pub(super) rounding: f64,
    /// A box that holds all that is found inside, rounding included.
    pub(super) bounds: Bounds,
}

#[derive(Clone, Debug)]
enum Shape {
    Turned(Arc<Solid>),
    /// The plane through the frame's centre with this unit normal in the world.
    HalfSpace(Vec3),
    /// The box with these half edges about the frame's centre.
    Cuboid(Vec3),
}

/// Where a line passes the boundary of a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Toggle {
    pub(super) t: f64,
    pub(super) leaf: u32,
    /// Whether the line comes in.
    pub(super) enters: bool,
    pub(super) place: Place,
}

impl Place {
    /// How far off the surface is there beside the leaf's rounding.
    pub(super) fn rounding(&self) -> f64 {
        match self {
            Self::Plane(away) => gamma(16) * away,
            _ => 0.0,
        }
    }
}

/// What belongs to the boundary there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    Turned(Wall),
    /// A plane, at this distance from its point: so far the rounding of its normal turns it.
    Plane(f64),
    /// The face of a box across an axis, at its smaller or larger coordinate.
    Side(usize, bool),
}

/// So far from the centre of a half space's frame nothing else can be: profiles end at 1e100.
const EVERYWHERE: f64 = 1e150;

impl Leaf {
    /// The leaf with this index; its rounding is that of the primitive alone.
    pub(super) fn new(
        primitive: &Primitive,
        placement: &Affine,
        leaf: usize,
    ) -> Result<Self, CsgError> {
        let flat = CsgError::Placement { leaf };
        match primitive {
            Primitive::Turned(solid) => {
                let surface = solid.surface();
                let frame =
                    Frame::placed(surface.center_z, surface.radius, placement).ok_or(flat)?;
                Ok(Self {
                    shape: Shape::Turned(Arc::clone(solid)),
                    frame,
                    placement: *placement,
                    rounding: surface.rounding(placement),
                    bounds: surface.placed_bounds(placement, surface.rounding(placement)),
                })
            }
            &Primitive::HalfSpace { point, normal } => {
                let rows = placement.inverse_rows().ok_or(flat.clone())?;
                let bad = CsgError::HalfSpace { leaf, normal };
                if !(normal.is_finite() && point.is_finite() && normal.max_abs() > 0.0) {
                    return Err(bad);
                }
                let own = normal / normal.max_abs();
                let normal = (rows[0] * own.x + rows[1] * own.y + rows[2] * own.z).normalized();
                let there = Affine::translate(placement.point(point));
                let frame = Frame::placed(0.0, EVERYWHERE, &there).ok_or(bad)?;
                let rounding = gamma(16) * there.translation.max_abs();
                Ok(Self {
                    shape: Shape::HalfSpace(normal),
                    frame,
                    placement: there,
                    rounding,
                    bounds: padded(half_space_bounds(there.translation, normal), rounding),
                })
            }
            Primitive::Cuboid(bounds) => {
                let (half, center) = (bounds.extent() * 0.5, bounds.center());
                if !(half.is_finite() && half.x > 0.0 && half.y > 0.0 && half.z > 0.0) {
                    return Err(CsgError::Cuboid { leaf, bounds: *bounds });
                }
                let there = placement.after(&Affine::translate(center));
                let radius = half.length() * (1.0 + gamma(8));
                let frame = Frame::placed(0.0, radius, &there).ok_or(flat)?;
                let corner = |i: usize| {
                    let side = |bit: usize, h: f64| if i & bit == 0 { -h } else { h };
                    there.point(Vec3::new(side(1, half.x), side(2, half.y), side(4, half.z)))
                };
                let rounding =
                    placed_rounding(&there, there.inverse_rows().as_ref(), Vec3::ZERO, radius)
                        + gamma(4) * bounds.min.abs().max(bounds.max.abs()).max_abs();
                let bounds = (0..8).fold(Bounds::EMPTY, |b, i| b.with_point(corner(i)));
                Ok(Self {
                    shape: Shape::Cuboid(half),
                    frame,
                    placement: there,
                    rounding,
                    bounds: padded(bounds, rounding),
                })
            }
        }
    }

    /// Appends where the whole line passes the boundary, alternating, and tells whether it is inside
    /// before all that. `spans` is for its use.
    pub(super) fn toggles(
        &self,
        leaf: u32,
        ray: &Ray,
        toggles: &mut Vec<Toggle>,
        spans: &mut Vec<Span>,
    ) -> bool {
        let mut add = |t, enters, place| toggles.push(Toggle { t, leaf, enters, place });
        match &self.shape {
            Shape::Turned(solid) => {
                spans.clear();
                solid.append_spans_from(&self.frame, self.rounding, &ray.whole(), spans);
                for Span { enter, exit } in spans {
                    for (Boundary { t, wall }, enters) in [(enter, true), (exit, false)] {
                        if let Some(wall) = wall {
                            add(*t, enters, Place::Turned(*wall));
                        }
                    }
                }
                false
            }
            _ => self.flat_toggles(ray, add),
        }
    }

    /// The same on what has plane faces alone: at most two.
    fn flat_toggles(&self, ray: &Ray, mut add: impl FnMut(f64, bool, Place)) -> bool {
        let Some(local) = self.frame.enter(&ray.whole()) else { return false };
        match &self.shape {
            Shape::Turned(_) => false,
            Shape::HalfSpace(normal) => {
                let rise = normal.dot(local.direction);
                let height = normal.dot(local.origin);
                let own_t = -height / rise;
                let t = local.world_t(own_t);
                // Parallel to the plane up to rounding, it passes it nowhere.
                if t.is_finite() {
                    let away = (local.origin + local.direction * own_t).length();
                    add(t, rise < 0.0, Place::Plane(away));
                    rise > 0.0
                } else {
                    height <= 0.0
                }
            }
            Shape::Cuboid(half) => {
                if let Some([enter, exit]) = through_box(&local, *half) {
                    add(local.world_t(enter.0), true, Place::Side(enter.1, enter.2));
                    add(local.world_t(exit.0), false, Place::Side(exit.1, exit.2));
                }
                false
            }
        }
    }

    /// Whether the line may pass the boundary within the ray's range, and within a box where the rest of the
    /// solid is; when in doubt, yes.
    pub(super) fn may_pass(&self, ray: &Ray, within: &Bounds) -> bool {
        let speed = Coincidence::new(ray.direction).speed();
        let Shape::Turned(solid) = &self.shape else {
            let (mut toggles, mut count) = ([None; 2], 0);
            self.flat_toggles(ray, |t, _, place| {
                toggles[count] = Some((t, place));
                count += 1;
            });
            return toggles.into_iter().flatten().any(|(t, place)| {
                let at = ray.at(t);
                let off =
                    self.rounding + place.rounding() + gamma(8) * (at.max_abs() + t.abs() * speed);
                let pad = off / speed;
                ray.t_min - pad <= t && t <= ray.t_max + pad && padded(*within, off).contains(at)
            });
        };
        // Two ways to the same hit differ by rounding.
        let pad = self.rounding / speed;
        let range = [ray.t_min - pad, ray.t_max + pad];
        solid.surface().any_from(&self.frame, &ray.with_range(range[0], range[1]))
    }

    /// Whether the primitive contains a point of the world.
    pub(super) fn contains(&self, p: Vec3) -> bool {
        let center = match &self.shape {
            Shape::Turned(solid) => {
                self.placement.point(Vec3::new(0.0, 0.0, solid.surface().center_z))
            }
            _ => self.placement.translation,
        };
        let (x, y, z) = (two_diff(p.x, center.x), two_diff(p.y, center.y), two_diff(p.z, center.z));
        let from = Vec3::new(x.0, y.0, z.0) + Vec3::new(x.1, y.1, z.1);
        let own = |v: Vec3| {
            self.frame
                .inverse()
                .map_or(v, |rows| Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v)))
        };
        match &self.shape {
            Shape::Turned(solid) => solid.contains_own(own(from)),
            Shape::HalfSpace(normal) => normal.dot(from) <= 0.0,
            Shape::Cuboid(half) => {
                let p = own(from);
                (0..3).all(|i| -half[i] <= p[i] && p[i] < half[i])
            }
        }
    }

    /// The unit normal, out of the primitive, at a place on it.
    pub(super) fn normal(&self, ray: &Ray, place: &Place) -> Vec3 {
        match (&self.shape, place) {
            (Shape::Turned(solid), Place::Turned(wall)) => {
                let surface = solid.surface();
                normal(surface, &self.frame, ray, &wall.hit) * solid.outward(wall)
            }
            (Shape::HalfSpace(normal), _) => *normal,
            (_, Place::Side(axis, larger)) => {
                let row = self.frame.inverse().map_or(Vec3::ZERO, |rows| rows[*axis]).normalized();
                if *larger { row } else { -row }
            }
            _ => Vec3::ZERO,
        }
    }

    /// The full answer at a place on the primitive; the normal points out of it.
    ///
    /// u and v are those of the surface on a turned solid; lengths along the plane on a half space, from
    /// its point; and fractions of the edges on a box, in the order of the axes.
    pub(super) fn interaction(&self, ray: &Ray, toggle: &Toggle) -> Interaction {
        if let (Shape::Turned(solid), Place::Turned(wall)) = (&self.shape, &toggle.place) {
            return solid.interaction_from(&self.frame, &self.placement, self.rounding, ray, wall);
        }
        let normal = self.normal(ray, &toggle.place);
        // Where the ray is in the leaf's own frame, brought back onto the surface.
        let own = self
            .frame
            .enter(&ray.whole())
            .map_or(Vec3::ZERO, |local| local.origin + local.direction * local.local_t(toggle.t));
        let (own, uv, [du, dv]) = match (&self.shape, toggle.place) {
            (Shape::Cuboid(half), Place::Side(axis, larger)) => {
                let mut p = [own.x, own.y, own.z];
                p[axis] = if larger { half[axis] } else { -half[axis] };
                let [a, b] = [[1, 2], [0, 2], [0, 1]][axis];
                let fraction = |i: usize| (0.5 + 0.5 * p[i] / half[i]).clamp(0.0, 1.0);
                let edge = |i: usize| self.placement.columns[i] * (2.0 * half[i]);
                (Vec3::new(p[0], p[1], p[2]), [fraction(a), fraction(b)], [edge(a), edge(b)])
            }
            _ => {
                let (u, v) = normal.orthonormal_basis();
                let own = own - normal * normal.dot(own);
                (own, [u.dot(own), v.dot(own)], [u, v])
            }
        };
        let point = self.placement.point(own);
        Interaction {
            point,
            normal,
            uv,
            dp_du: du,
            dp_dv: dv,
            error: self.rounding + gamma(16) * (own.max_abs() + point.max_abs()),
        }
    }
}

/// Where a line enters and leaves a box about the origin: the parameter, the axis, and whether it is
/// the face at the larger coordinate. A line within a face is inside at the smaller coordinate.
fn through_box(ray: &LocalRay, half: Vec3) -> Option<[(f64, usize, bool); 2]> {
    let mut enter = (f64::NEG_INFINITY, 0, false);
    let mut exit = (f64::INFINITY, 0, false);
    for axis in 0..3 {
        let (o, d, h) = (ray.origin[axis], ray.direction[axis], half[axis]);
        if d == 0.0 {
            if !(-h <= o && o < h) {
                return None;
            }
            continue;
        }
        let side = h.copysign(d);
        let (near, far) = ((-side - o) / d, (side - o) / d);
        if near > enter.0 {
            enter = (near, axis, d < 0.0);
        }
        if far < exit.0 {
            exit = (far, axis, d > 0.0);
        }
    }
    (enter.0 < exit.0).then_some([enter, exit])
}

fn padded(bounds: Bounds, by: f64) -> Bounds {
    let by = Vec3::splat(by);
    Bounds { min: bounds.min - by, max: bounds.max + by }
}

/// The box round a half space: not all of space if the plane lies across an axis.
fn half_space_bounds(point: Vec3, normal: Vec3) -> Bounds {
    let side = |n: f64, others: [f64; 2], p: f64| match (others == [0.0; 2], n > 0.0) {
        (false, _) => [f64::NEG_INFINITY, f64::INFINITY],
        (true, true) => [f64::NEG_INFINITY, p],
        (true, false) => [p, f64::INFINITY],
    };
    let x = side(normal.x, [normal.y, normal.z], point.x);
    let y = side(normal.y, [normal.x, normal.z], point.y);
    let z = side(normal.z, [normal.x, normal.y], point.z);
    Bounds { min: Vec3::new(x[0], y[0], z[0]), max: Vec3::new(x[1], y[1], z[1]) }
}

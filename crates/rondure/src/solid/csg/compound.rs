//! An expression made ready: its leaves in a row, and the formula that says what is inside.

use core::cell::Cell;

use super::formula::{Formula, Needs, State};
use super::leaf::{Leaf, Toggle};
use super::{Csg, CsgError};
use crate::frame::Frame;
use crate::interaction::Interaction;
use crate::solid::span::{Clip, Coincidence};
use crate::solid::{Boundary, Span};
use crate::{Affine, Bounds, Ray, Vec3};

/// A solid made of others by union, intersection and difference; see [`Csg`].
#[derive(Clone, Debug)]
pub struct Compound {
    leaves: Vec<Leaf>,
    formula: Formula,
    bounds: Bounds,
    /// The sphere round the bounds; `None` if they are infinite.
    sphere: Option<Frame>,
}

/// What a ray takes room for, kept for the next one.
#[derive(Default)]
struct Room {
    state: State,
    toggles: Vec<Toggle>,
    /// Those of a leaf.
    leaf_spans: Vec<Span>,
}

thread_local! {
    static ROOM: Cell<Room> = Cell::default();
    static SPANS: Cell<Vec<Span<Face>>> = const { Cell::new(Vec::new()) };
}

/// Where a ray passes the surface of a compound solid: a place on one of its primitives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Whether the compound lies outside the primitive there, as where it was taken away.
    pub flipped: bool,
    toggle: Toggle,
}

impl Face {
    /// The index of the primitive, counted from 0 in the order in which the expression has them.
    pub fn leaf(&self) -> usize {
        self.toggle.leaf as usize
    }

    /// The hit on the surface of a turned solid; `None` on a half space or a box.
    pub fn hit(&self) -> Option<crate::Hit> {
        match self.toggle.place {
            super::leaf::Place::Turned(wall) => Some(wall.hit),
            _ => None,
        }
    }
}

impl Compound {
    pub(super) fn new(csg: &Csg) -> Result<Self, CsgError> {
        let mut leaves = Vec::new();
        collect(csg, &mut leaves)?;
        let mut formula = Formula::new(leaves.len());
        let mut next = 0;
        join(csg, &mut next, &mut formula)?;
        let bounds = bounds(csg, &mut leaves.iter());
        // Rays are dropped only where no leaf could see them inside.
        let rounding = leaves.iter().map(|l| l.rounding).fold(0.0, f64::max);
        let center = bounds.center();
        let radius = 0.5 * bounds.extent().length() + rounding;
        let sphere = (bounds.min.is_finite() && bounds.max.is_finite() && radius.is_finite())
            .then(|| Frame::placed(0.0, radius, &Affine::translate(center)))
            .flatten();
        Ok(Self { leaves, formula, bounds, sphere })
    }

    /// A box round the solid; infinite if a half space leaves it open. It may be larger than needed.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// How many primitives there are.
    pub fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// The stretches of a ray inside the solid, as of [`Solid::spans`](crate::Solid::spans). `spans` is
    /// cleared first.
    pub fn spans(&self, ray: &Ray, spans: &mut Vec<Span<Face>>) {
        self.walk(ray, spans, |_| false);
    }

    /// The spans up to the first that is enough. `spans` is cleared first.
    fn walk(
        &self,
        ray: &Ray,
        spans: &mut Vec<Span<Face>>,
        mut is_enough: impl FnMut(&Span<Face>) -> bool,
    ) {
        spans.clear();
        let is_ray =
            ray.direction.is_finite() && ray.origin.is_finite() && ray.direction.max_abs() > 0.0;
        let missed = self.sphere.as_ref().is_some_and(|s| s.enter(&ray.whole()).is_none());
        if !is_ray || missed || self.is_empty() {
            return;
        }
        let Room { state, mut toggles, mut leaf_spans } = ROOM.take();
        toggles.clear();
        let mut state = self.formula.outside(state);
        for (i, leaf) in self.leaves.iter().enumerate() {
            if leaf.toggles(i as u32, ray, &mut toggles, &mut leaf_spans) {
                self.formula.toggle(&mut state, i);
            }
        }
        toggles.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.leaf.cmp(&b.leaf)));

        let mut clip = Clip { range: [ray.t_min, ray.t_max], enter: None };
        if self.formula.value(&state) {
            clip.enter = Some(Boundary { t: f64::NEG_INFINITY, wall: None });
        }
        let mut rest = &toggles[..];
        while !rest.is_empty() {
            let (group, others) = rest.split_at(self.together(ray, rest));
            rest = others;
            if let Some((toggle, enters)) = self.change(&mut state, group) {
                let face = Face { flipped: toggle.enters != enters, toggle };
                let known = spans.len();
                clip.boundary(Boundary { t: toggle.t, wall: Some(face) }, enters, spans);
                if spans.get(known).is_some_and(&mut is_enough) {
                    clip.enter = None;
                    break;
                }
            }
        }
        clip.finish(spans);
        ROOM.set(Room { state, toggles, leaf_spans });
    }

    /// The first boundary in the range of a ray, where it comes in or, if it begins inside, goes out.
    pub fn closest(&self, ray: &Ray) -> Option<Boundary<Face>> {
        // Mostly no primitive's boundary lies in the range, which takes much less to find out.
        if !self.leaves.iter().any(|leaf| leaf.may_pass(ray, &self.bounds)) {
            return None;
        }
        let wall =
            |span: &Span<Face>| [span.enter, span.exit].into_iter().find(|end| end.wall.is_some());
        let mut spans = SPANS.take();
        self.walk(ray, &mut spans, |span| wall(span).is_some());
        let first = spans.iter().find_map(wall);
        SPANS.set(spans);
        first
    }

    /// Whether there is any boundary in the range of a ray.
    pub fn any(&self, ray: &Ray) -> bool {
        self.closest(ray).is_some()
    }

    /// How many of the first toggles come together: those at the same t, and those at the next t as
    /// long as any two, one of either, may lie at the same place.
    fn together(&self, ray: &Ray, toggles: &[Toggle]) -> usize {
        let coincidence = Coincidence::new(ray.direction);
        let sine = |a: &Toggle| {
            let normal = self.leaves[a.leaf as usize].normal(ray, &a.place);
            coincidence.sine(normal, ray.direction)
        };
        let off = |a: &Toggle| self.leaves[a.leaf as usize].rounding + a.place.rounding();
        let meet = |a: &Toggle, b: &Toggle| {
            coincidence.holds(a.t, b.t, off(a).max(off(b)), || [sine(a), sine(b)])
        };
        let mut ties = toggles.chunk_by(|a, b| a.t == b.t).peekable();
        let mut count = 0;
        while let Some(here) = ties.next() {
            count += here.len();
            let goes_on = ties
                .peek()
                .is_some_and(|next| here.iter().any(|a| next.iter().any(|b| meet(a, b))));
            if !goes_on {
                break;
            }
        }
        count
    }

    /// Makes changes that come together. If the whole solid changes with them: the one that its
    /// boundary belongs to, and whether the line comes in.
    fn change(&self, state: &mut State, group: &[Toggle]) -> Option<(Toggle, bool)> {
        let before = self.formula.value(state);
        for toggle in group {
            self.formula.toggle(state, toggle.leaf as usize);
        }
        let after = self.formula.value(state);
        if before == after {
            return None;
        }
        if let [only] = group {
            return Some((*only, after));
        }
        // Leaves that come and go within the group do not change.
        let times = |leaf: u32| group.iter().filter(|t| t.leaf == leaf).count();
        let mut changed: Vec<Toggle> =
            group.iter().filter(|t| times(t.leaf) % 2 == 1).copied().collect();
        changed.sort_by_key(|t| t.leaf);
        changed.dedup_by_key(|t| t.leaf);
        let mut there = state.clone();
        for toggle in &changed {
            self.formula.toggle(&mut there, toggle.leaf as usize);
        }
        let matters =
            |t: &&Toggle, state: &mut State| self.formula.depends_on(state, t.leaf as usize);
        let alone = changed.iter().find(|t| matters(t, state) || matters(t, &mut there));
        // Where no leaf decides alone, the first one with which the change is complete.
        let last = || {
            changed.iter().find(|t| {
                self.formula.toggle(&mut there, t.leaf as usize);
                self.formula.value(&there) == after
            })
        };
        alone.or_else(last).map(|t| (*t, after))
    }

    /// Whether a point lies inside. Points within rounding of the surface may go either way.
    pub fn contains(&self, point: Vec3) -> bool {
        let mut room = ROOM.take();
        let mut state = self.formula.outside(room.state);
        for (i, leaf) in self.leaves.iter().enumerate() {
            if leaf.contains(point) {
                self.formula.toggle(&mut state, i);
            }
        }
        let inside = self.formula.value(&state);
        room.state = state;
        ROOM.set(room);
        point.is_finite() && inside
    }

    /// Whether a point lies inside the primitive of this index, counted as [`Face::leaf`] does.
    ///
    /// # Panics
    ///
    /// If there is no such primitive.
    pub fn leaf_contains(&self, leaf: usize, point: Vec3) -> bool {
        point.is_finite() && self.leaves[leaf].contains(point)
    }

    /// The full answer for a face that this solid reported for this ray; the normal points out of the
    /// solid. Its u and v are those of the surface on a turned solid, lengths along the plane from its
    /// point on a half space, and fractions of the two edges on a box.
    pub fn interaction(&self, ray: &Ray, face: &Face) -> Interaction {
        let at = self.leaves[face.leaf()].interaction(ray, &face.toggle);
        Interaction { normal: if face.flipped { -at.normal } else { at.normal }, ..at }
    }

    /// Whether nothing can be inside, because boxes do not meet.
    fn is_empty(&self) -> bool {
        let Bounds { min, max } = self.bounds;
        min.x > max.x || min.y > max.y || min.z > max.z
    }
}

fn collect(csg: &Csg, leaves: &mut Vec<Leaf>) -> Result<(), CsgError> {
    match csg {
        Csg::Primitive(primitive, placement) => {
            let leaf = Leaf::new(primitive, placement, leaves.len())?;
            leaves.push(leaf);
            Ok(())
        }
        Csg::Union(operands) | Csg::Intersection(operands) | Csg::Difference(operands) => {
            operands.iter().try_for_each(|operand| collect(operand, leaves))
        }
    }
}

/// Adds an expression to the formula and returns its node; `next` counts the leaves.
fn join(csg: &Csg, next: &mut usize, formula: &mut Formula) -> Result<usize, CsgError> {
    let (operands, needs) = match csg {
        Csg::Primitive(..) => {
            *next += 1;
            return Ok(*next - 1);
        }
        Csg::Union(operands) => (operands, Needs::Any),
        Csg::Intersection(operands) | Csg::Difference(operands) => (operands, Needs::All),
    };
    let difference = matches!(csg, Csg::Difference(_));
    let nodes = operands
        .iter()
        .enumerate()
        .map(|(i, operand)| Ok((join(operand, next, formula)?, difference && i > 0)))
        .collect::<Result<Vec<_>, CsgError>>()?;
    if nodes.is_empty() {
        return Err(CsgError::NoOperands);
    }
    Ok(formula.join(needs, &nodes))
}

/// A box round an expression, whose leaves come from the iterator.
fn bounds<'a>(csg: &Csg, leaves: &mut impl Iterator<Item = &'a Leaf>) -> Bounds {
    let all = |operands: &[Csg], leaves: &mut _| -> Vec<Bounds> {
        operands.iter().map(|operand| bounds(operand, leaves)).collect()
    };
    match csg {
        Csg::Primitive(..) => leaves.next().map_or(Bounds::EMPTY, |leaf| leaf.bounds),
        Csg::Union(operands) => all(operands, leaves).iter().fold(Bounds::EMPTY, |a, b| a.union(b)),
        Csg::Intersection(operands) => {
            let both =
                |a: Bounds, b: &Bounds| Bounds { min: a.min.max(b.min), max: a.max.min(b.max) };
            let everywhere = Bounds { min: Bounds::EMPTY.max, max: Bounds::EMPTY.min };
            all(operands, leaves).iter().fold(everywhere, both)
        }
        Csg::Difference(operands) => {
            all(operands, leaves).first().copied().unwrap_or(Bounds::EMPTY)
        }
    }
}

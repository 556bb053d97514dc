//! A wide tree of boxes over numbered items: which of them may a ray meet?
//!
//! Nodes have eight children whose boxes lie side by side in f32, for one SIMD instruction each; the
//! tree takes some 50 bytes an item. `space` says why no f64 hit is lost by that, `build` how
//! the tree is made, `crowd` what is left out of it, `node` and `walk` how a ray goes through it, `bundle` how many do that
//! are alike.

mod build;
mod bundle;
mod crowd;
mod node;
mod space;
mod walk;

use fearless_simd::{Level, Simd, dispatch};

use self::build::Item;
use self::bundle::Together;
use self::crowd::Crowd;
use self::node::{Node, Probe};
use self::space::{LocalRay, Space};
use crate::{Bounds, Ray, Rays};

/// A bounding volume hierarchy over items numbered from 0.
///
/// It knows nothing of the items but their boxes. Built once, then immutable; with the feature
/// `parallel` on all threads of rayon's pool, and always the same for the same boxes.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    space: Space,
    /// How wide the items in the tree are along their longest axis, on average, in its coordinates.
    width: f64,
    /// Items without a finite box, and those that stand aside: every ray meets them.
    aside: Vec<u32>,
    bounds: Bounds,
    level: Level,
}

/// The most items that a [`Bvh`] can have.
pub const MOST_ITEMS: usize = build::MOST_ITEMS;

impl Bvh {
    /// Builds the tree over the items 0 to `count` - 1. `bounds` tells their boxes; it is asked two
    /// or three times for each.
    ///
    /// An item whose box is not finite, or larger than 1e300, is met by every ray; so are up to 16
    /// items that reach more than 32 times as far as all others, wherever the ray goes. One whose
    /// box is empty (a lower corner above the upper one) is met by none.
    ///
    /// # Errors
    /// If there are more than [`MOST_ITEMS`] items.
    pub fn new(count: usize, bounds: impl Fn(u32) -> Bounds + Sync) -> Result<Self, TooManyItems> {
        if count > MOST_ITEMS {
            return Err(TooManyItems { count });
        }
        let count = count as u32;
        let bounded = |i| Some(bounds(i)).filter(|b| !is_empty(b) && space::is_bounded(b));
        let nobody = Crowd::round_middle(count, bounded);
        let crowds = over(count, |range| {
            let mut crowd = nobody.clone();
            range.filter_map(bounded).for_each(|b| crowd.add(&b));
            crowd
        });
        let crowd = crowds.into_iter().fold(nobody, Crowd::union).decided();
        let [all, inner] = crowd.bounds();
        let space = Space::new(if is_empty(&inner) { &Bounds::ORIGIN } else { &inner });
        let parts = over(count, |range| {
            let (mut items, mut aside) = (Vec::with_capacity(range.len()), Vec::new());
            for i in range {
                let bounds = bounds(i);
                if is_empty(&bounds) {
                    continue;
                }
                if space::is_bounded(&bounds) && !crowd.stands_aside(&bounds) {
                    items.push(Item::new(i, space.slabs(&bounds)));
                } else {
                    aside.push(i);
                }
            }
            (items, aside)
        });
        let mut items = Vec::with_capacity(parts.iter().map(|(items, _)| items.len()).sum());
        let mut aside = Vec::new();
        for (part, others) in parts {
            items.extend(part);
            aside.extend(others);
        }
        let width = items.iter().map(|item| f64::from(item.width())).sum::<f64>();
        let width = width / items.len().max(1) as f64;
        let nodes = build::build(&mut items);
        Ok(Self { nodes, space, width, aside, bounds: all, level: Level::new() })
    }

    /// What of the machine's SIMD is used.
    pub(crate) fn level(&self) -> Level {
        self.level
    }

    /// The box round all items that have a finite one.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The bytes that the tree takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.aside)
    }

    /// Whether there is nothing that a ray could meet.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.aside.is_empty()
    }

    /// Visits the items whose boxes the ray may meet in its range, each once, near ones first by and
    /// large.
    ///
    /// `visit` returns up to which t the search goes on: the t of the nearest hit so far, say, or
    /// minus infinity to stop. Items that are entered just beyond it may still be visited; one whose
    /// box has a point of the ray up to there is never left out.
    #[inline]
    pub fn walk(&self, ray: &Ray, visit: impl FnMut(u32) -> f64) {
        dispatch!(self.level, simd => self.walk_with(simd, ray, visit));
    }

    /// [`walk`](Self::walk) inside of a dispatch.
    #[inline(always)]
    pub(crate) fn walk_with<S: Simd>(&self, simd: S, ray: &Ray, mut visit: impl FnMut(u32) -> f64) {
        if self.is_empty() {
            return;
        }
        let mut end = ray.t_max;
        for &item in &self.aside {
            end = end.min(visit(item));
            if end == f64::NEG_INFINITY {
                return;
            }
        }
        let Some(local) = self.space.enter(&Ray { t_max: end, ..*ray }) else { return };
        self.walk_on(simd, &Probe::new(simd, &local), &local, (end, local.end), visit);
    }

    /// As [`walk`](Self::walk), for many rays at once that are alike, such as those from a camera through neighbouring pixels:
    /// visits the items whose boxes at least one of them may meet. `visit` returns up to which t the search goes on for any of them.
    ///
    /// Returns false, and visits none, if the rays are not alike enough for that: if they are farther apart anywhere near the items
    /// than a part of what these are wide, on average.
    pub fn walk_together(&self, rays: &Rays<'_>, mut visit: impl FnMut(u32) -> f64) -> bool {
        if self.is_empty() || rays.is_empty() {
            return true;
        }
        let together = Together::new(&self.space, self.width, rays);
        if matches!(together, Together::Apart) {
            return false;
        }
        let mut end = f64::INFINITY;
        for &item in &self.aside {
            end = end.min(visit(item));
            if end == f64::NEG_INFINITY {
                return true;
            }
        }
        if let Together::Bundle(bundle) = together {
            dispatch!(self.level, simd => {
                let probe = Probe::padded(simd, &bundle.ray, bundle.pad);
                self.walk_on(simd, &probe, &bundle.ray, (end, bundle.ray.end_at(end)), visit);
            });
        }
        true
    }

    /// The way of a ray through the nodes, up to `end`, which it also has as its own parameter.
    #[inline(always)]
    fn walk_on<S: Simd>(
        &self,
        simd: S,
        probe: &Probe<S>,
        local: &LocalRay,
        (mut end, local_end): (f64, f32),
        mut visit: impl FnMut(u32) -> f64,
    ) {
        walk::walk(simd, &self.nodes, probe, local_end, |item| {
            let nearer = visit(item);
            (nearer < end).then(|| {
                end = nearer;
                if nearer == f64::NEG_INFINITY { -1.0 } else { local.end_at(nearer) }
            })
        });
    }
}

/// More items than a [`Bvh`] can number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyItems {
    /// How many there are.
    pub count: usize,
}

impl core::fmt::Display for TooManyItems {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} items; a tree of boxes can have at most {MOST_ITEMS}", self.count)
    }
}

impl core::error::Error for TooManyItems {}

fn is_empty(b: &Bounds) -> bool {
    b.min.x > b.max.x || b.min.y > b.max.y || b.min.z > b.max.z
}

/// `of` the stretches into which 0 to `count` - 1 is cut, in order.
fn over<T: Send>(count: u32, of: impl Fn(core::ops::Range<u32>) -> T + Sync + Send) -> Vec<T> {
    const STRETCH: u32 = 1 << 16;
    let stretch = |i: u32| i * STRETCH..count.min(i.saturating_add(1).saturating_mul(STRETCH));
    let stretches = 0..count.div_ceil(STRETCH);
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        stretches.into_par_iter().map(|i| of(stretch(i))).collect()
    }
    #[cfg(not(feature = "parallel"))]
    stretches.map(|i| of(stretch(i))).collect()
}

#[cfg(test)]
mod tests;

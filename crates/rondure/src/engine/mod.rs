//! Engines: how the pieces that a ray may hit are found among all of them.
//!
//! [`EngineOptions`] chooses one. The default is exact: it works on the profile's curves. The others
//! are the methods of the paper (Wang, Zhu, Gu 2008, "Quick Ray Tracing Algorithm Based on Surfaces of
//! Revolution"), side by side: on the same polyline of sampled points, with the same leaves, order of
//! descent and early exit; only the shells, and for KJ the tree, differ. They give the same hits, bit
//! for bit.

mod counters;
mod frusta;
mod options;
mod polyline;
mod shell_tree;
mod strip_tree;
mod tree;
mod view;
pub(crate) mod wide;

pub use counters::Statistics;
pub use options::{Criterion, EngineOptions, Instructions, Method};
pub use view::{Region, TreeNode};

pub(crate) use polyline::Polyline;

use std::sync::Arc;

use fearless_simd::Level;

use self::counters::{Count, Counters};
use self::frusta::Frusta;
use self::tree::Tree;
use self::wide::Wide;
use crate::frame::LocalRay;
use crate::meridian::Meridian;
use crate::piece::Piece;
use crate::shell::Cone;

/// The part of an engine that searches.
#[derive(Clone, Debug)]
pub(crate) enum Engine {
    /// Eight parts of pieces at once.
    Wide(Box<Wide>),
    /// A tree with one piece in each leaf.
    Exact(Tree<Cone>),
    /// The paper's methods, over frusta.
    Frusta(Box<Frusta>),
    /// Any engine, with its work counted.
    Counted(Box<Engine>, Arc<Counters>),
}

impl Engine {
    /// Builds an engine over the pieces of a profile, which must not be empty. For every method that
    /// is not [exact](Method::is_exact) the pieces must be straight. `radius` is that of the sphere round them.
    pub(crate) fn new(pieces: &[Piece], radius: f64, options: &EngineOptions) -> Self {
        let engine = match options.method {
            Method::Wide => {
                let level = options.instructions.level().unwrap_or_else(Level::new);
                Self::Wide(Box::new(Wide::new(pieces, radius, level)))
            }
            Method::Exact => Self::Exact(shell_tree::exact(pieces, radius)),
            _ => Self::Frusta(Box::new(Frusta::new(pieces, radius, options))),
        };
        if options.counted {
            Self::Counted(Box::new(engine), Arc::new(Counters::default()))
        } else {
            engine
        }
    }

    /// Calls `visit` for every piece that the ray may hit in its range, near ones first by and large;
    /// `ray` is the same ray as `local`. `visit` returns up to which parameter the search goes on: the nearest hit
    /// so far, say, or minus infinity to stop.
    #[inline]
    pub(crate) fn walk(&self, local: &LocalRay, ray: &Meridian, visit: impl FnMut(u32) -> f64) {
        match self {
            Self::Wide(wide) => wide.candidates(local, &mut (), visit),
            Self::Exact(tree) => walk_exact(tree, ray, local.range, &mut (), visit),
            Self::Frusta(frusta) => frusta.walk(ray, local.range, &mut (), visit),
            Self::Counted(engine, counters) => engine.walk_counted(local, ray, counters, visit),
        }
    }

    /// The wide engine, if that is what it is, and does not count.
    #[inline(always)]
    pub(crate) fn wide(&self) -> Option<&Wide> {
        match self {
            Self::Wide(wide) => Some(wide),
            _ => None,
        }
    }

    fn walk_counted(
        &self,
        local: &LocalRay,
        ray: &Meridian,
        counters: &Counters,
        visit: impl FnMut(u32) -> f64,
    ) {
        let mut work = Statistics { rays: 1, ..Statistics::default() };
        match self {
            Self::Wide(wide) => wide.candidates(local, &mut work, visit),
            Self::Exact(tree) => walk_exact(tree, ray, local.range, &mut work, visit),
            Self::Frusta(frusta) => frusta.walk(ray, local.range, &mut work, visit),
            Self::Counted(..) => {}
        }
        work.nodes_there = self.node_count() as u64;
        counters.add(&work);
    }

    /// The number of nodes in the tree.
    pub(crate) fn node_count(&self) -> usize {
        match self {
            Self::Wide(wide) => wide.node_count(),
            Self::Exact(tree) => tree.nodes.len(),
            Self::Frusta(frusta) => frusta.node_count(),
            Self::Counted(engine, _) => engine.node_count(),
        }
    }

    /// The work since the engine was built; `None` if it is not counted.
    pub(crate) fn statistics(&self) -> Option<Statistics> {
        match self {
            Self::Counted(_, counters) => Some(counters.read()),
            _ => None,
        }
    }
}

#[inline]
fn walk_exact<C: Count>(
    tree: &Tree<Cone>,
    ray: &Meridian,
    range: [f64; 2],
    count: &mut C,
    mut visit: impl FnMut(u32) -> f64,
) {
    tree.walk(ray, range, count, |leaf, _, _, count| {
        count.solve();
        visit(leaf.first)
    });
}

#[cfg(test)]
mod tests;

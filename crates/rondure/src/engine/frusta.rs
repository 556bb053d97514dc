//! The paper's methods: leaves of consecutive frusta under a tree of one kind of shells.
//!
//! A leaf takes the ray's intersection interval with its shell and picks by binary search the frusta
//! that the ray can reach there: those whose range of heights it meets, or of radii where the leaf is
//! wider than it is high. All methods share this file.

use core::ops::Range;

use super::counters::Count;
use super::options::{Criterion, EngineOptions, Method};
use super::shell_tree::{self, Role};
use super::strip_tree;
use super::tree::{Leaf, Order, Tree};
use crate::meridian::Meridian;
use crate::piece::Piece;
use crate::shell::{Cone, Cylinder, Intervals, Rectangle, Shell, Strip, hybrid};

/// By how much an intersection interval is widened, per unit of the surface's radius (the paper's
/// delta in section 4.2): far more than the rounding of its ends, which the padding of the shells
/// bounds already, and far less than a frustum.
const DELTA: f64 = 1e-9;

/// An engine over frusta.
#[derive(Clone, Debug)]
pub(crate) struct Frusta {
    pub(crate) culling: Culling,
    points: Points,
}

/// The tree, by the kind of its shells.
#[derive(Clone, Debug)]
pub(crate) enum Culling {
    Kj(Tree<Rectangle>),
    Cy(Tree<Cylinder>),
    Co(Tree<Cone>),
    Hy(Tree<Cone>),
    Bs(Tree<Strip>),
}

/// The heights and the squared radii of the ends of the frusta.
#[derive(Clone, Debug)]
struct Points {
    z: Vec<f64>,
    w: Vec<f64>,
    radius: f64,
}

impl Frusta {
    /// Builds the engine; `frusta` must not be empty, and all straight. `radius` is that of the
    /// sphere round the surface.
    pub(crate) fn new(frusta: &[Piece], radius: f64, options: &EngineOptions) -> Self {
        let k = options.subdivide;
        let culling = match options.method {
            Method::Kj => Culling::Kj(strip_tree::build(frusta, radius, k)),
            Method::Cy => {
                Culling::Cy(shell_tree::build(frusta, k, |part, _| Cylinder::around(part, radius)))
            }
            Method::Co => {
                Culling::Co(shell_tree::build(frusta, k, |part, _| Cone::or_upright(part, radius)))
            }
            Method::Wide | Method::Exact | Method::Hy => {
                let inner = |part: &[Piece]| match options.criterion {
                    Criterion::Area { cone_weight } => {
                        hybrid::least_area(part, radius, cone_weight)
                    }
                    Criterion::Interval => hybrid::least_interval(part, radius),
                };
                Culling::Hy(shell_tree::build(frusta, k, |part, role| match role {
                    Role::Leaf => Cone::or_upright(part, radius),
                    Role::Inner => inner(part),
                }))
            }
            Method::Bs => {
                Culling::Bs(shell_tree::build(frusta, k, |part, _| Strip::around(part, radius)))
            }
        };
        let z = frusta.iter().map(|f| f.end().z).collect();
        let w = frusta.iter().map(|f| f.end().r * f.end().r).collect();
        Self { culling, points: Points { z, w, radius } }
    }

    /// See [`Engine::walk`](super::Engine::walk).
    pub(crate) fn walk<C: Count>(
        &self,
        ray: &Meridian,
        range: [f64; 2],
        count: &mut C,
        visit: impl FnMut(u32) -> f64,
    ) {
        match &self.culling {
            Culling::Kj(tree) => self.points.walk(tree, ray, range, count, visit),
            Culling::Cy(tree) => self.points.walk(tree, ray, range, count, visit),
            Culling::Co(tree) => self.points.walk(tree, ray, range, count, visit),
            Culling::Hy(tree) => self.points.walk(tree, ray, range, count, visit),
            Culling::Bs(tree) => self.points.walk(tree, ray, range, count, visit),
        }
    }

    pub(crate) fn node_count(&self) -> usize {
        match &self.culling {
            Culling::Kj(tree) => tree.nodes.len(),
            Culling::Cy(tree) => tree.nodes.len(),
            Culling::Co(tree) => tree.nodes.len(),
            Culling::Hy(tree) => tree.nodes.len(),
            Culling::Bs(tree) => tree.nodes.len(),
        }
    }
}

impl Points {
    fn walk<S: Shell, C: Count>(
        &self,
        tree: &Tree<S>,
        ray: &Meridian,
        range: [f64; 2],
        count: &mut C,
        mut visit: impl FnMut(u32) -> f64,
    ) {
        tree.walk(ray, range, count, |leaf, shell, stretch, count| {
            let mut end = f64::INFINITY;
            let mut solve = |part: Range<usize>| {
                for i in part {
                    if end == f64::NEG_INFINITY {
                        return;
                    }
                    count.solve();
                    end = end.min(visit(leaf.first + i as u32));
                }
            };
            if leaf.count == 1 {
                solve(0..1);
                return end;
            }
            let intervals = shell.intervals(ray, stretch);
            match *self.picked(leaf, ray, &intervals) {
                [] => {}
                [ref only] => solve(only.clone()),
                [ref a, ref b, ..] => {
                    // The same frustum on both sides of the axis must not be hit twice.
                    if a.start < b.end && b.start < a.end {
                        solve(a.start.min(b.start)..a.end.max(b.end));
                    } else {
                        solve(a.clone());
                        solve(b.clone());
                    }
                }
            }
            end
        });
    }

    /// For each interval the frusta of a leaf that the ray may reach in it, counted from its first.
    #[inline]
    fn picked(
        &self,
        leaf: &Leaf,
        ray: &Meridian,
        intervals: &Intervals,
    ) -> arrayvec::ArrayVec<Range<usize>, 2> {
        let part = leaf.first as usize..(leaf.first + leaf.count) as usize;
        let pad = DELTA * self.radius;
        intervals
            .iter()
            .map(|&[lo, hi]| match leaf.order {
                Order::ZRising | Order::ZFalling => {
                    let (a, b) = (ray.oz + lo * ray.dz, ray.oz + hi * ray.dz);
                    let range = [a.min(b) - pad, a.max(b) + pad];
                    pick(&self.z[part.clone()], range, leaf.order == Order::ZRising)
                }
                Order::RRising | Order::RFalling => {
                    let [a, b] = [lo, hi].map(|t| ray.offset + ray.speed * t);
                    let nearest = if a < 0.0 && b > 0.0 { 0.0 } else { (a * a).min(b * b) };
                    let pad = pad * self.radius;
                    let range = [nearest + ray.delta2 - pad, (a * a).max(b * b) + ray.delta2 + pad];
                    pick(&self.w[part.clone()], range, leaf.order == Order::RRising)
                }
            })
            .collect()
    }
}

/// The frusta that meet a range of heights (or squared radii), by binary search; `ends` are those of
/// their ends, in order.
#[inline]
fn pick(ends: &[f64], [low, high]: [f64; 2], rising: bool) -> Range<usize> {
    let (begin, last) = if rising {
        (ends.partition_point(|e| *e < low), ends.partition_point(|e| *e <= high))
    } else {
        (ends.partition_point(|e| *e > high), ends.partition_point(|e| *e >= low))
    };
    begin..ends.len().min(last + 1)
}

//! An engine's tree as it is, for pictures and tests.

use super::shell_tree::direction;
use super::tree::{Link, Tree};
use super::{Engine, frusta::Culling};
use crate::meridian::Meridian;
use crate::piece::Piece;
use crate::shell::rectangle::Band;
use crate::shell::{Cone, Cylinder, Rectangle, Shell, Strip};

/// A node of an engine's tree, in depth-first order.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeNode {
    /// How many nodes are above it.
    pub depth: usize,
    /// Whether it holds pieces itself.
    pub leaf: bool,
    /// The index of the first piece below it.
    pub first: usize,
    /// How many pieces are below it.
    pub count: usize,
    /// Whether r rises (or falls, or does neither) along its pieces, and z; `None` if one of them
    /// turns: then it is a grouping node.
    pub rising: Option<[Option<bool>; 2]>,
    /// The region that encloses what its pieces sweep.
    pub region: Region,
}

/// The region of a node. Heights are relative to the profile's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// Between two planes and two cylinders.
    Cylinder {
        /// The heights of the planes.
        z: [f64; 2],
        /// The squared radii.
        w: [f64; 2],
    },
    /// Between two planes and two cones: `offsets[0] <= rho - slope z <= offsets[1]`.
    Cone {
        /// The heights of the planes.
        z: [f64; 2],
        /// The slope of both cones.
        slope: f64,
        /// The offsets of the inner and of the outer cone.
        offsets: [f64; 2],
    },
    /// A cylinder region cut with `range[0] <= rho^2 - p z <= range[1]`.
    Strip {
        /// The heights of the planes.
        z: [f64; 2],
        /// The squared radii.
        w: [f64; 2],
        /// The slope in the plane (z, rho^2).
        p: f64,
        /// The bounds of the strip.
        range: [f64; 2],
    },
    /// Two bands `range[0] <= q rho^2 + p z <= range[1]`, at right angles where rho^2 is measured
    /// in units of the surface's radius.
    Rectangle {
        /// The q of the bands along and across the chord.
        q: [f64; 2],
        /// The p.
        p: [f64; 2],
        /// The ranges.
        ranges: [[f64; 2]; 2],
    },
}

/// A shell that can show itself, raised by `z`.
trait Show: Shell {
    fn region(&self, raised: f64) -> Region;
}

impl Show for Cylinder {
    fn region(&self, raised: f64) -> Region {
        Region::Cylinder { z: self.z.map(|z| z + raised), w: self.w.map(|w| w.max(0.0)) }
    }
}

impl Show for Cone {
    fn region(&self, raised: f64) -> Region {
        let z = self.z.map(|z| z + raised);
        if self.slope == 0.0 {
            return Region::Cylinder { z, w: self.offsets.map(|r| r.max(0.0).powi(2)) };
        }
        let offsets = self.offsets.map(|offset| offset - self.slope * raised);
        Region::Cone { z, slope: self.slope, offsets }
    }
}

impl Show for Strip {
    fn region(&self, raised: f64) -> Region {
        Region::Strip {
            z: self.cylinder.z.map(|z| z + raised),
            w: self.cylinder.w.map(|w| w.max(0.0)),
            p: self.p,
            range: self.range.map(|bound| bound - self.p * raised),
        }
    }
}

impl Show for Rectangle {
    fn region(&self, raised: f64) -> Region {
        let bands = [self.along, self.across];
        Region::Rectangle {
            q: bands.map(|b| b.q),
            p: bands.map(|b| b.p),
            ranges: bands.map(|Band { p, range, .. }| range.map(|bound| bound + p * raised)),
        }
    }
}

impl Engine {
    /// All nodes of the tree, in depth-first order. `raised` is the height of the pieces' origin.
    pub(crate) fn view(&self, pieces: &[Piece], raised: f64) -> Vec<TreeNode> {
        match self {
            Self::Wide(_) => Vec::new(),
            Self::Exact(tree) => view(tree, pieces, raised),
            Self::Frusta(frusta) => match &frusta.culling {
                Culling::Kj(tree) => view(tree, pieces, raised),
                Culling::Cy(tree) => view(tree, pieces, raised),
                Culling::Co(tree) => view(tree, pieces, raised),
                Culling::Hy(tree) => view(tree, pieces, raised),
                Culling::Bs(tree) => view(tree, pieces, raised),
            },
            Self::Counted(engine, _) => engine.view(pieces, raised),
        }
    }

    /// The intersection interval of a ray with the shell of a node.
    pub(crate) fn intervals(&self, node: usize, ray: &Meridian, range: [f64; 2]) -> Vec<[f64; 2]> {
        fn of<S: Shell>(
            tree: &Tree<S>,
            n: usize,
            ray: &Meridian,
            range: [f64; 2],
        ) -> Vec<[f64; 2]> {
            let Some(node) = tree.nodes.get(n) else { return Vec::new() };
            let met = node.shell.meet(ray, range);
            met.map(|m| node.shell.intervals(ray, m).iter().copied().collect()).unwrap_or_default()
        }
        match self {
            Self::Wide(_) => Vec::new(),
            Self::Exact(tree) => of(tree, node, ray, range),
            Self::Frusta(frusta) => match &frusta.culling {
                Culling::Kj(tree) => of(tree, node, ray, range),
                Culling::Cy(tree) => of(tree, node, ray, range),
                Culling::Co(tree) => of(tree, node, ray, range),
                Culling::Hy(tree) => of(tree, node, ray, range),
                Culling::Bs(tree) => of(tree, node, ray, range),
            },
            Self::Counted(engine, _) => engine.intervals(node, ray, range),
        }
    }
}

fn view<S: Show>(tree: &Tree<S>, pieces: &[Piece], raised: f64) -> Vec<TreeNode> {
    let mut nodes: Vec<TreeNode> = Vec::with_capacity(tree.nodes.len());
    // The depths of the second children that are still to come.
    let mut depths = vec![0];
    for node in &tree.nodes {
        let depth = depths.pop().unwrap_or(0);
        let (leaf, first, count) = match node.link {
            Link::Leaf(leaf) => (true, leaf.first as usize, leaf.count as usize),
            Link::Children { .. } => {
                depths.extend([depth + 1, depth + 1]);
                (false, 0, 0)
            }
        };
        let region = node.shell.region(raised);
        nodes.push(TreeNode { depth, leaf, first, count, rising: None, region });
    }
    // Children follow their parents: from the end on, they are known before them.
    for i in (0..nodes.len()).rev() {
        if let Link::Children { second } = tree.nodes[i].link {
            let (a, b) = (&nodes[i + 1], &nodes[second as usize]);
            let (first, count) = (a.first, a.count + b.count);
            (nodes[i].first, nodes[i].count) = (first, count);
        }
        let own = &mut nodes[i];
        own.rising = direction(&pieces[own.first..own.first + own.count]).map(|d| [d.r, d.z]);
    }
    nodes
}

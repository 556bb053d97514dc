//! Kajiya's strip tree: rectangles in the plane (z, rho^2), split at the point farthest from the chord
//! (Kajiya 1983, section 5; Ballard 1981, "Strip Trees: A Hierarchical Representation for Curves").
//!
//! A node is split until it holds a part of one monotone interval that is no larger than the leaves of
//! the paper's tree. As the latter are halved k times, both are refined alike; with k so large that
//! one frustum is left, the tree is Kajiya's own.

use core::ops::Range;

use super::shell_tree::{leaf, monotone_intervals};
use super::tree::{DEEPEST, Tree};
use crate::piece::Piece;
use crate::shell::Rectangle;
use crate::shell::rectangle::{chord, image};

/// Below this depth nodes are halved: splits at the farthest point can be lopsided, and the search
/// keeps one waiting node for every level.
const LOPSIDED: usize = DEEPEST / 2;

/// Builds the tree over frusta, of which there must be some.
pub(crate) fn build(frusta: &[Piece], radius: f64, halvings: u32) -> Tree<Rectangle> {
    let mut largest = vec![(1, 0); frusta.len()];
    for interval in monotone_intervals(frusta) {
        let size = (interval.len() as u64).div_ceil(1_u64 << halvings.min(63)) as u32;
        largest[interval.clone()].fill((size, interval.end as u32));
    }
    let mut builder = Builder { tree: Tree { nodes: Vec::new() }, frusta, radius, largest };
    builder.split(0..frusta.len(), 0);
    builder.tree
}

struct Builder<'a> {
    tree: Tree<Rectangle>,
    frusta: &'a [Piece],
    radius: f64,
    /// For each frustum the size of a leaf in its monotone interval, and where that interval ends.
    largest: Vec<(u32, u32)>,
}

impl Builder<'_> {
    fn split(&mut self, part: Range<usize>, depth: usize) {
        let shell = Rectangle::around(&self.frusta[part.clone()], self.radius);
        let (size, end) = self.largest[part.start];
        if part.end <= end as usize && part.len() <= size as usize {
            return self.tree.leaf(shell, leaf(self.frusta, part));
        }
        let half = part.start + part.len() / 2;
        let middle = if depth < LOPSIDED { self.farthest(&part).unwrap_or(half) } else { half };
        let node = self.tree.begin(shell);
        self.split(part.start..middle, depth + 1);
        self.tree.begin_second(node);
        self.split(middle..part.end, depth + 1);
    }

    /// The inner point of a part that is farthest from its chord, as the index of the frustum that
    /// begins there; `None` where all lie on the chord.
    fn farthest(&self, part: &Range<usize>) -> Option<usize> {
        let frusta = &self.frusta[part.clone()];
        let (cos, sin) = chord(frusta, self.radius);
        let [z0, w0] = image(frusta[0].start(), self.radius);
        let distance = |i: usize| {
            let [z, w] = image(self.frusta[i].start(), self.radius);
            ((w - w0) * cos - (z - z0) * sin).abs()
        };
        let inner = part.start + 1..part.end;
        let farthest = inner.max_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
        (distance(farthest) > 0.0).then_some(farthest)
    }
}

//! The paper's tree: grouping nodes join the monotone intervals of the profile towards the root; below
//! a monotone interval, refinement nodes halve it (paper, sections 3.3, 4.1 and 4.2).

use core::ops::Range;

use super::tree::{Leaf, Order, Tree};
use crate::piece::Piece;
use crate::shell::{Cone, Shell, hybrid};

/// In which directions r and z run along a stretch; a coordinate that stays still runs in neither,
/// and fits both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Direction {
    pub(crate) r: Option<bool>,
    pub(crate) z: Option<bool>,
}

impl Direction {
    fn of(piece: &Piece) -> Self {
        let sense = |from: f64, to: f64| (from != to).then_some(to > from);
        Self { r: sense(piece.r[0], piece.r[3]), z: sense(piece.z[0], piece.z[3]) }
    }

    /// The common direction of two stretches; `None` if r or z turns between them.
    fn join(self, other: Self) -> Option<Self> {
        let join = |a: Option<bool>, b: Option<bool>| match (a, b) {
            (Some(a), Some(b)) if a != b => None,
            _ => Some(a.or(b)),
        };
        Some(Self { r: join(self.r, other.r)?, z: join(self.z, other.z)? })
    }
}

/// The common direction of connected pieces; `None` if r or z turns, or they are not connected.
pub(crate) fn direction(pieces: &[Piece]) -> Option<Direction> {
    let connected = pieces.windows(2).all(|pair| pair[0].end() == pair[1].start());
    let join = |all: Direction, piece| all.join(Direction::of(piece));
    connected.then(|| pieces.iter().try_fold(Direction::default(), join))?
}

/// The monotone intervals of consecutive pieces, as ranges of indices.
pub(crate) fn monotone_intervals(pieces: &[Piece]) -> Vec<Range<usize>> {
    let mut intervals = Vec::new();
    let mut begin = 0;
    let mut direction = Direction::default();
    for (i, piece) in pieces.iter().enumerate() {
        let own = Direction::of(piece);
        let connected = i > begin && pieces[i - 1].end() == piece.start();
        direction = match direction.join(own) {
            Some(joint) if connected => joint,
            _ => {
                if i > begin {
                    intervals.push(begin..i);
                }
                begin = i;
                own
            }
        };
    }
    intervals.push(begin..pieces.len());
    intervals
}

/// What a node of the tree is, for the choice of its shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    Inner,
    Leaf,
}

/// The tree of the exact engine: leaves of one piece each.
pub(crate) fn exact(pieces: &[Piece], radius: f64) -> Tree<Cone> {
    build(pieces, u32::MAX, |part, _| hybrid::least_area(part, radius, 1.0))
}

/// Builds the tree over pieces, of which there must be some, with up to 2^`halvings` leaves in each
/// monotone interval.
pub(crate) fn build<S: Shell>(
    pieces: &[Piece],
    halvings: u32,
    shell: impl Fn(&[Piece], Role) -> S,
) -> Tree<S> {
    let mut tree = Tree { nodes: Vec::new() };
    Builder { tree: &mut tree, pieces, halvings, shell }.group(&monotone_intervals(pieces));
    tree
}

struct Builder<'a, S, F> {
    tree: &'a mut Tree<S>,
    pieces: &'a [Piece],
    halvings: u32,
    shell: F,
}

impl<S: Shell, F: Fn(&[Piece], Role) -> S> Builder<'_, S, F> {
    /// A grouping node over consecutive monotone intervals.
    fn group(&mut self, intervals: &[Range<usize>]) {
        if let [interval] = intervals {
            return self.refine(interval.clone(), self.halvings);
        }
        let (first, second) = intervals.split_at(intervals.len() / 2);
        let covered = intervals[0].start..intervals[intervals.len() - 1].end;
        let node = self.tree.begin((self.shell)(&self.pieces[covered], Role::Inner));
        self.group(first);
        self.tree.begin_second(node);
        self.group(second);
    }

    /// A refinement node, or a leaf, over a part of one monotone interval.
    fn refine(&mut self, part: Range<usize>, halvings: u32) {
        let pieces = &self.pieces[part.clone()];
        if part.len() == 1 || halvings == 0 {
            return self.tree.leaf((self.shell)(pieces, Role::Leaf), leaf(self.pieces, part));
        }
        let middle = part.start + part.len() / 2;
        let node = self.tree.begin((self.shell)(pieces, Role::Inner));
        self.refine(part.start..middle, halvings - 1);
        self.tree.begin_second(node);
        self.refine(middle..part.end, halvings - 1);
    }
}

/// A leaf over a part of one monotone interval.
pub(crate) fn leaf(pieces: &[Piece], part: Range<usize>) -> Leaf {
    let across = pieces[part.end - 1].end() - pieces[part.start].start();
    let order = match (across.z.abs() >= across.r.abs(), across.z >= 0.0, across.r >= 0.0) {
        (true, true, _) => Order::ZRising,
        (true, false, _) => Order::ZFalling,
        (false, _, true) => Order::RRising,
        (false, _, false) => Order::RFalling,
    };
    Leaf { first: part.start as u32, count: part.len() as u32, order }
}

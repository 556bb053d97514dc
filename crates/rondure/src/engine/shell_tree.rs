//! The paper's engine: a binary tree of monotone intervals with a hybrid shell in every node.
//!
//! Grouping nodes join the monotone intervals of the profile towards the root; below a monotone
//! interval, refinement nodes halve it until one piece is left (paper, sections 3.3, 4.1 and 4.2).
//! Nodes lie in one array in depth-first order: the first child of a node is the next node.

use arrayvec::ArrayVec;

use crate::meridian::Meridian;
use crate::piece::Piece;
use crate::shell::Shell;

/// The tree over the pieces of a profile.
#[derive(Clone, Debug)]
pub(crate) struct ShellTree {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    shell: Shell,
    link: Link,
}

/// What hangs below a node.
#[derive(Clone, Copy, Debug)]
enum Link {
    /// The second child; the first is the next node.
    Children { second: u32 },
    /// The piece of a leaf.
    Piece(u32),
}

/// In which directions r and z run along a stretch; a coordinate that stays still runs in neither,
/// and fits both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Direction {
    r: Option<bool>,
    z: Option<bool>,
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

/// The monotone intervals of consecutive pieces, as ranges of indices.
fn monotone_intervals(pieces: &[Piece]) -> Vec<core::ops::Range<usize>> {
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

/// Deep enough for a tree over 2^32 intervals of 2^32 pieces.
const DEEPEST: usize = 64;

impl ShellTree {
    /// Builds the tree. `pieces` must not be empty; `radius` is that of the sphere round the surface.
    pub(crate) fn new(pieces: &[Piece], radius: f64) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * pieces.len()) };
        tree.group(pieces, &monotone_intervals(pieces), radius);
        tree
    }

    /// A grouping node over consecutive monotone intervals.
    fn group(&mut self, pieces: &[Piece], intervals: &[core::ops::Range<usize>], radius: f64) {
        if let [interval] = intervals {
            return self.refine(pieces, interval.clone(), radius);
        }
        let (first, second) = intervals.split_at(intervals.len() / 2);
        let covered = intervals[0].start..intervals[intervals.len() - 1].end;
        let node = self.inner(Shell::hybrid(&pieces[covered], radius));
        self.group(pieces, first, radius);
        self.begin_second(node);
        self.group(pieces, second, radius);
    }

    /// A refinement node, or a leaf, over a part of one monotone interval.
    fn refine(&mut self, pieces: &[Piece], part: core::ops::Range<usize>, radius: f64) {
        let shell = Shell::hybrid(&pieces[part.clone()], radius);
        if part.len() == 1 {
            self.nodes.push(Node { shell, link: Link::Piece(part.start as u32) });
            return;
        }
        let middle = part.start + part.len() / 2;
        let node = self.inner(shell);
        self.refine(pieces, part.start..middle, radius);
        self.begin_second(node);
        self.refine(pieces, middle..part.end, radius);
    }

    fn inner(&mut self, shell: Shell) -> usize {
        self.nodes.push(Node { shell, link: Link::Children { second: 0 } });
        self.nodes.len() - 1
    }

    fn begin_second(&mut self, node: usize) {
        self.nodes[node].link = Link::Children { second: self.nodes.len() as u32 };
    }

    /// Visits the leaves whose shells the ray meets between the parameters `range`, near ones first.
    ///
    /// `visit` is given the piece and returns up to which parameter the search goes on: the nearest
    /// hit so far, say, or minus infinity to stop.
    #[inline]
    pub(crate) fn walk(&self, ray: &Meridian, range: [f64; 2], mut visit: impl FnMut(u32) -> f64) {
        let [_, mut end] = range;
        let mut waiting = ArrayVec::<(u32, [f64; 2]), DEEPEST>::new();
        let Some(mut stretch) = self.nodes[0].shell.meet(ray, range) else { return };
        let mut node = 0_u32;
        loop {
            match self.nodes[node as usize].link {
                Link::Piece(piece) => end = end.min(visit(piece)),
                Link::Children { second } => {
                    let first = node + 1;
                    let meet = |n: u32| {
                        self.nodes[n as usize].shell.meet(ray, [stretch[0], stretch[1].min(end)])
                    };
                    match (meet(first), meet(second)) {
                        (Some(a), Some(b)) => {
                            let (near, far) = if b[0] < a[0] {
                                ((second, b), (first, a))
                            } else {
                                ((first, a), (second, b))
                            };
                            waiting.push(far);
                            (node, stretch) = near;
                            continue;
                        }
                        (Some(a), None) => {
                            (node, stretch) = (first, a);
                            continue;
                        }
                        (None, Some(b)) => {
                            (node, stretch) = (second, b);
                            continue;
                        }
                        (None, None) => {}
                    }
                }
            }
            loop {
                let Some(next) = waiting.pop() else { return };
                (node, stretch) = next;
                if stretch[0] <= end {
                    break;
                }
            }
        }
    }
}

//! The profile as an outline in its half plane: a tree of boxes round runs of pieces, and the winding
//! number round a point.
//!
//! The winding number is counted along the half line from the point towards larger r: a piece that
//! crosses it upwards adds 1, one that crosses it downwards takes 1 off, and a piece crosses if its ends
//! lie on different sides, with ends on the half line counted below. The axis closes what ends on it,
//! and is never crossed.
//!
//! A run of joined pieces that lies wholly to the right of the point crosses by the sides of its two
//! ends alone, whatever it does between them. So the search goes down only to the pieces whose box
//! holds the point, or lies about its height with the run not joined.

use arrayvec::ArrayVec;

use crate::piece::{Kind, Piece};
use crate::pieces::Pieces;
use crate::profile::Point;
use crate::root::bracketed_root;

/// More than the nodes that wait while a tree over 2^32 curves is searched.
pub(super) const DEEPEST: usize = 64;

/// The tree, in depth-first order: the first child of a node is the next node.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub(super) nodes: Vec<Node>,
}

/// A run of pieces, one after the other in drawing order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) low: Point,
    pub(super) high: Point,
    pub(super) first: u32,
    pub(super) count: u32,
    /// The second child; not used on leaves, which hold one piece.
    pub(super) second: u32,
    /// Whether each piece begins where the one before it ends.
    joined: bool,
}

impl Outline {
    /// The tree over curves that are given by their ends and turn neither in r nor in z; there must
    /// be one at least.
    pub(super) fn new(curves: &[[Point; 2]]) -> Self {
        let mut nodes = Vec::with_capacity(2 * curves.len());
        build(curves, 0, curves.len(), &mut nodes);
        Self { nodes }
    }

    /// How often the outline winds round a point, from r towards z. `pieces` must be those that the
    /// outline was built from.
    pub(super) fn winding(&self, pieces: &Pieces, p: Point) -> i32 {
        let mut winding = 0;
        let mut waiting = ArrayVec::<u32, DEEPEST>::new();
        waiting.push(0);
        while let Some(i) = waiting.pop() {
            let node = &self.nodes[i as usize];
            let beside = node.low.z <= p.z && p.z < node.high.z && p.r < node.high.r;
            if !beside {
                continue;
            }
            let (first, last) = (node.first as usize, (node.first + node.count - 1) as usize);
            if node.joined && p.r < node.low.r {
                winding += step(pieces.ends(first)[0].z, pieces.ends(last)[1].z, p.z);
            } else if node.count == 1 {
                let mut room = None;
                let piece = pieces.at(first, &mut room);
                if is_right_of(piece, p) {
                    winding += step(piece.z[0], piece.z[3], p.z);
                }
            } else {
                waiting.extend([node.second, i + 1]);
            }
        }
        winding
    }
}

fn build(curves: &[[Point; 2]], first: usize, end: usize, nodes: &mut Vec<Node>) {
    let run = &curves[first..end];
    let ends = || run.iter().flatten().copied();
    let fold =
        |init: f64, f: fn(f64, f64) -> f64, of: fn(Point) -> f64| ends().map(of).fold(init, f);
    let node = nodes.len();
    nodes.push(Node {
        low: Point::new(
            fold(f64::INFINITY, f64::min, |p| p.r),
            fold(f64::INFINITY, f64::min, |p| p.z),
        ),
        high: Point::new(
            fold(f64::NEG_INFINITY, f64::max, |p| p.r),
            fold(f64::NEG_INFINITY, f64::max, |p| p.z),
        ),
        first: first as u32,
        count: (end - first) as u32,
        second: 0,
        joined: run.windows(2).all(|pair| pair[0][1] == pair[1][0]),
    });
    if run.len() > 1 {
        let middle = first + run.len() / 2;
        build(curves, first, middle, nodes);
        nodes[node].second = nodes.len() as u32;
        build(curves, middle, end, nodes);
    }
}

/// By how much a run from the height `from` to `to` winds if it crosses to the right.
fn step(from: f64, to: f64, z: f64) -> i32 {
    i32::from(to > z) - i32::from(from > z)
}

/// Whether a piece that crosses the height of p does so at a larger r than p has, by the sign of a
/// determinant for a straight one and by solving for the height on a curve. Either errs as if the
/// point were moved by a few units in the last place.
fn is_right_of(piece: &Piece, p: Point) -> bool {
    let (a, b) = (piece.start(), piece.end());
    if p.r < a.r.min(b.r) {
        return true;
    }
    if p.r >= a.r.max(b.r) || (a.z > p.z) == (b.z > p.z) {
        return false;
    }
    let rises = b.z > a.z;
    if piece.kind == Kind::Line {
        // Positive if p is to the left of the way from a to b.
        let (along, to) = (b - a, p - a);
        let left = crate::numeric::difference_of_products(along.r, to.z, along.z, to.r);
        return (left > 0.0) == rises;
    }
    let heights = piece.z.map(|z| z - p.z);
    let guess = heights[0] / (heights[0] - heights[3]);
    let s = bracketed_root(|s| piece.coordinate(&heights, s), [0.0, 1.0], !rises, guess);
    piece.coordinate(&piece.r, s).0 > p.r
}

//! The point of a profile nearest to a point of its half plane.
//!
//! On a piece the squared distance has its minima at an end or where (c - q) . c' changes from - to +:
//! at roots of a polynomial of degree 1, 3, 4 (arcs) or 5. Its Bernstein coefficients count them; a
//! stretch with one is solved by bracketed Newton steps, one with more is halved, and one whose squared
//! distance cannot come below the best so far, by the coefficients of that, is left out. Where all of a
//! curve is equally far, as an arc is from its centre, that ends the search at once.

use arrayvec::ArrayVec;

use super::outline::{DEEPEST, Outline};
use super::stretch::Stretch;
use crate::numeric::UNIT_ROUNDOFF;
use crate::piece::Piece;
use crate::pieces::Pieces;
use crate::profile::Point;
use crate::root::bracketed_root;

/// A part of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) piece: u32,
    /// The parameters of its ends on the piece.
    pub(super) s: [f64; 2],
}

/// The nearest point so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) distance: f64,
    pub(super) piece: u32,
    pub(super) s: f64,
}

impl Best {
    pub(super) const NONE: Self = Self { distance: f64::INFINITY, piece: 0, s: 0.0 };

    fn offer(&mut self, piece: &Piece, index: u32, s: f64, q: Point) {
        let distance = (piece.jet(s).point - q).length();
        if distance < self.distance {
            *self = Self { distance, piece: index, s };
        }
    }
}

/// Each halving halves the stretch; after so many it is no longer than rounding.
const MOST_HALVINGS: u32 = 54;

/// The nearest point of all edges, `outline` being the tree over them; NaN coordinates have none.
pub(super) fn nearest(
    pieces: &Pieces,
    edges: impl Fn(usize) -> Edge,
    outline: &Outline,
    q: Point,
    radius: f64,
) -> Best {
    let mut best = Best::NONE;
    let distance = |node: u32| {
        let node = &outline.nodes[node as usize];
        let beyond = |low: f64, x: f64, high: f64| (low - x).max(x - high).max(0.0);
        Point::new(beyond(node.low.r, q.r, node.high.r), beyond(node.low.z, q.z, node.high.z))
            .length()
    };
    let mut waiting = ArrayVec::<(u32, f64), DEEPEST>::new();
    waiting.push((0, distance(0)));
    while let Some((i, away)) = waiting.pop() {
        if away >= best.distance {
            continue;
        }
        let node = &outline.nodes[i as usize];
        if node.count == 1 {
            let edge = edges(node.first as usize);
            let mut room = None;
            let piece = pieces.at(edge.piece as usize, &mut room);
            on_edge(piece, edge, q, radius, &mut best);
            continue;
        }
        let [a, b] = [i + 1, node.second].map(|child| (child, distance(child)));
        waiting.extend(if a.1 <= b.1 { [b, a] } else { [a, b] });
    }
    best
}

/// Improves the best point by those of one edge.
pub(super) fn on_edge(piece: &Piece, edge: Edge, q: Point, radius: f64, best: &mut Best) {
    for s in edge.s {
        best.offer(piece, edge.piece, s, q);
    }
    let stretch = Stretch::new(piece, q).between(edge.s);
    search(piece, edge.piece, &stretch, q, radius, best, MOST_HALVINGS);
}

fn search(
    piece: &Piece,
    index: u32,
    stretch: &Stretch,
    q: Point,
    radius: f64,
    best: &mut Best,
    halvings: u32,
) {
    // Nothing is gained that rounding would not take away.
    let better = best.distance - rounding(radius, best.distance);
    if better <= 0.0 {
        return;
    }
    let (beyond, noise) = stretch.beyond(better);
    if beyond.coefficients().iter().all(|&c| c >= noise) {
        return;
    }
    let motion = stretch.outward_motion();
    let approaches = motion.coefficients()[0] < 0.0;
    match motion.sign_changes() {
        0 => {}
        1 if approaches => {
            let c = motion.coefficients();
            let (first, last) = (c[0], c[c.len() - 1]);
            let u = bracketed_root(|u| motion.jet(u), [0.0, 1.0], false, first / (first - last));
            let [s0, s1] = stretch.s;
            best.offer(piece, index, s0 + (s1 - s0) * u, q);
        }
        1 => {}
        _ if halvings == 0 => {}
        _ => {
            let [mut near, mut far] = stretch.split(0.5);
            best.offer(piece, index, near.s[1], q);
            if far.end().length() < near.start().length() {
                (near, far) = (far, near);
            }
            search(piece, index, &near, q, radius, best, halvings - 1);
            search(piece, index, &far, q, radius, best, halvings - 1);
        }
    }
}

/// How far a distance may be off: by rounding of coordinates up to `radius` and of itself, in fewer than
/// 32 operations.
pub(super) fn rounding(radius: f64, distance: f64) -> f64 {
    64.0 * UNIT_ROUNDOFF * radius.max(distance)
}

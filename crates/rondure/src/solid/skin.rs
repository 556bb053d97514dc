//! The skin of a solid: the parts of the pieces that have the inside on one side only.
//!
//! Where an outline crosses itself, parts of it lie within the solid and bound nothing. The pieces are
//! cut where they cross or touch each other, and of each part the fill rule is asked on either side of
//! its middle. On a profile that does not cross itself the skin is all of it.
//!
//! Two curves cross where both are so flat that they are straight up to rounding and the two straight
//! lines do; stretches are halved until then, and left out where one lies beside a strip along the
//! other's chord (the fat lines of Sederberg and Nishita 1990).

use arrayvec::ArrayVec;

use super::nearest::{Best, Edge, on_edge, rounding};
use super::outline::{DEEPEST, Outline};
use super::stretch::Stretch;
use crate::piece::Piece;
use crate::profile::Point;

/// The parts that bound the solid, and the tree over them.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    pub(super) edges: Vec<Edge>,
    /// `None` if there are no edges.
    pub(super) tree: Option<Outline>,
}

impl Skin {
    /// The skin of what `inside` says is inside.
    pub(super) fn new(
        pieces: &[Piece],
        outline: &Outline,
        radius: f64,
        inside: impl Fn(Point) -> bool,
    ) -> Self {
        let cuts = cuts(pieces, outline, radius);
        // Farther than any rounding of a crossing or of `inside`.
        let aside = 16.0 * rounding(radius, 0.0);
        let mut edges = Vec::with_capacity(pieces.len());
        let mut ends = Vec::with_capacity(pieces.len());
        for (index, (piece, mut cuts)) in pieces.iter().zip(cuts).enumerate() {
            cuts.push(1.0);
            cuts.sort_by(f64::total_cmp);
            cuts.dedup();
            let mut from = 0.0;
            for to in cuts {
                let (s, middle) = ([from, to], piece.jet(0.5 * (from + to)));
                let [a, b] = s.map(|s| piece.jet(s).point);
                let tangent =
                    if middle.tangent == Point::default() { b - a } else { middle.tangent };
                let across = Point::new(tangent.z, -tangent.r) * (aside / tangent.length());
                let right = middle.point + across;
                let left = middle.point - across;
                let [right, left] = [right, left].map(|p| inside(Point { r: p.r.max(0.0), ..p }));
                if right != left {
                    edges.push(Edge { piece: index as u32, s });
                    ends.push([a, b]);
                }
                from = to;
            }
        }
        let tree = (!edges.is_empty()).then(|| Outline::new(&ends));
        Self { edges, tree }
    }
}

/// For each piece the parameters strictly inside at which it crosses another or touches an end of it.
fn cuts(pieces: &[Piece], outline: &Outline, radius: f64) -> Vec<Vec<f64>> {
    let mut cuts = vec![Vec::new(); pieces.len()];
    let near = rounding(radius, 0.0);
    for (i, piece) in pieces.iter().enumerate() {
        let (a, b) = (piece.start(), piece.end());
        let low = Point::new(a.r.min(b.r) - near, a.z.min(b.z) - near);
        let high = Point::new(a.r.max(b.r) + near, a.z.max(b.z) + near);
        let mut waiting = ArrayVec::<u32, DEEPEST>::new();
        waiting.push(0);
        while let Some(n) = waiting.pop() {
            let node = &outline.nodes[n as usize];
            // Each pair once.
            let later = node.first + node.count > i as u32 + 1;
            let meets = low.r <= node.high.r
                && node.low.r <= high.r
                && low.z <= node.high.z
                && node.low.z <= high.z;
            if !(later && meets) {
                continue;
            }
            if node.count > 1 {
                waiting.extend([node.second, n + 1]);
                continue;
            }
            let j = node.first as usize;
            for (own, other) in [(i, j), (j, i)] {
                for end in [pieces[other].start(), pieces[other].end()] {
                    let mut best = Best::NONE;
                    on_edge(
                        &pieces[own],
                        Edge { piece: own as u32, s: [0.0, 1.0] },
                        end,
                        radius,
                        &mut best,
                    );
                    if best.distance <= near && 0.0 < best.s && best.s < 1.0 {
                        cuts[own].push(best.s);
                    }
                }
            }
            if same_curve(piece, &pieces[j]) {
                continue;
            }
            let whole = |piece| Stretch::new(piece, Point::default());
            let mut budget = MOST_PAIRS;
            crossings(&whole(piece), &whole(&pieces[j]), near, &mut budget, &mut |s, t| {
                for (piece, s) in [(i, s), (j, t)] {
                    if 0.0 < s && s < 1.0 {
                        cuts[piece].push(s);
                    }
                }
            });
        }
    }
    cuts
}

fn same_curve(a: &Piece, b: &Piece) -> bool {
    let reversed = |c: [f64; 4]| match a.kind {
        crate::piece::Kind::Line => [c[3], c[0], c[0], c[0]],
        crate::piece::Kind::Cubic => [c[3], c[2], c[1], c[0]],
        _ => [c[3], c[1], c[0], c[0]],
    };
    a.kind == b.kind
        && ((a.r == b.r && a.z == b.z) || (a.r == reversed(b.r) && a.z == reversed(b.z)))
}

/// Curves that cross do so in a few places, and tangents take a few pairs at each halving. Curves that
/// run together take any number: they do not cross, and where they part they touch ends.
const MOST_PAIRS: u32 = 4096;

/// Reports the parameters on both of every crossing.
fn crossings(
    a: &Stretch,
    b: &Stretch,
    flat: f64,
    budget: &mut u32,
    report: &mut impl FnMut(f64, f64),
) {
    if *budget == 0 {
        return;
    }
    *budget -= 1;
    if !boxes_meet(a, b) {
        return;
    }
    let (Some(a_width), Some(b_width)) = (strip_meets(a, b), strip_meets(b, a)) else { return };
    if a_width.max(b_width) <= flat {
        let (along, other) = (a.end() - a.start(), b.end() - b.start());
        let cross = along.r * other.z - along.z * other.r;
        let between = b.start() - a.start();
        let s = (between.r * other.z - between.z * other.r) / cross;
        let t = (between.r * along.z - between.z * along.r) / cross;
        // Halves share their middle only up to rounding. For parallels these are NaN or infinite.
        let within = |s: f64, chord: Point| {
            -flat <= s * chord.length() && (s - 1.0) * chord.length() <= flat
        };
        if within(s, along) && within(t, other) {
            let at = |[from, to]: [f64; 2], u: f64| from + (to - from) * u.clamp(0.0, 1.0);
            report(at(a.s, s), at(b.s, t));
        }
    } else if a_width >= b_width {
        for half in a.split(0.5) {
            crossings(&half, b, flat, budget, report);
        }
    } else {
        for half in b.split(0.5) {
            crossings(a, &half, flat, budget, report);
        }
    }
}

fn boxes_meet(a: &Stretch, b: &Stretch) -> bool {
    let bounds = |stretch: &Stretch| {
        stretch.controls().fold(
            [
                Point::new(f64::INFINITY, f64::INFINITY),
                Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
            ],
            |[low, high], p| {
                [
                    Point::new(low.r.min(p.r), low.z.min(p.z)),
                    Point::new(high.r.max(p.r), high.z.max(p.z)),
                ]
            },
        )
    };
    let ([a_low, a_high], [b_low, b_high]) = (bounds(a), bounds(b));
    a_low.r <= b_high.r && b_low.r <= a_high.r && a_low.z <= b_high.z && b_low.z <= a_high.z
}

/// The width of the strip along a's chord that holds a; `None` if b lies beside it.
fn strip_meets(a: &Stretch, b: &Stretch) -> Option<f64> {
    let chord = a.end() - a.start();
    let length = chord.length();
    let normal = if length > 0.0 {
        Point::new(chord.z, -chord.r) * length.recip()
    } else {
        Point::new(1.0, 0.0)
    };
    let range = |stretch: &Stretch| {
        stretch.controls().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            let away = normal.r * (p.r - a.start().r) + normal.z * (p.z - a.start().z);
            [low.min(away), high.max(away)]
        })
    };
    let ([a_low, a_high], [b_low, b_high]) = (range(a), range(b));
    (a_low <= b_high && b_low <= a_high).then_some(a_high - a_low)
}

//! From pieces to leaves, and from leaves to blocks and boxes.

use arrayvec::ArrayVec;

use super::block::{Block, LANES};
use super::boxes::{BELOW, Boxes, Extent, LeafBoxes, WIDTH};
use super::group;
use super::leaf::{Curve, Leaf};
use super::quadric::Quadric;
use crate::piece::Piece;

/// A leaf before it is numbered.
struct Part {
    fit: Quadric,
    leaf: Leaf,
    extent: Extent,
}

/// Leaves in blocks of eight, with boxes round blocks and round boxes.
pub(super) struct Built {
    pub(super) blocks: Vec<Block>,
    /// Boxes round the leaves of each block.
    pub(super) leaf_boxes: Vec<LeafBoxes>,
    /// In the order of the blocks' lanes.
    pub(super) leaves: Vec<Leaf>,
    /// The lowest level first: each box of a level stands for a block, or for those of the level
    /// below.
    pub(super) levels: Vec<Boxes>,
}

/// Into how many parts a piece is cut at the most.
const MOST_PARTS: u32 = 32;
/// Part of the radius that a quadric may be off the curve; a first guess is as far off.
const FINE: f64 = 5e-5;
/// By how much longer than expected a stretch may be tried.
const LONGER: f64 = 0.1;
/// The most of the error times the curvature. A ray may be tangent to a leaf where Q' is less than some
/// sqrt(8) times the square root of that, if it runs along the axis, and less otherwise.
const GRAZING: f64 = 1e-2;
/// How far its tangent may be off, as an angle.
const SLOPE: f64 = 0.05;
/// How far the first guess of the parameter may be off, as a part of the leaf.
const GUESS: f64 = 1.0 / 256.0;

/// How many times as far as it may be a quadric is from a stretch.
fn excess(fit: &Quadric, [s0, s1]: [f64; 2]) -> f64 {
    let excesses = [
        fit.error / FINE,
        fit.error * (fit.alpha.abs() + fit.p.abs()) / GRAZING,
        // The slope grows with the second power of the length.
        (0.5 * fit.slope * fit.growth() / SLOPE).powf(1.5),
        fit.guess.error / (GUESS * (s1 - s0)),
    ];
    excesses.into_iter().fold(0.0, |most, excess| if excess <= most { most } else { excess })
}

/// Cuts a piece into stretches as long as quadrics beside them are near enough.
fn parts(index: u32, piece: &Piece, unit: f64, parts: &mut Vec<Part>) {
    let curve = Curve::new(piece, unit);
    let least = 1.0 / f64::from(MOST_PARTS);
    let mut start = 0.0_f64;
    let mut length = 1.0_f64;
    while start < 1.0 {
        // What is left in equal parts, if they need not be much longer than expected.
        let left = 1.0 - start;
        let mut count = (left / length - LONGER).ceil().max(1.0);
        let (fit, end) = loop {
            let tried = left / count;
            let end = if count == 1.0 { 1.0 } else { start + tried };
            let fit = Quadric::new(piece, [start, end], unit);
            let excess = excess(&fit, [start, end]);
            // The error grows with the third power of the length.
            let longer = tried * (0.9 / excess.cbrt()).clamp(0.3, 1.5);
            if excess <= 1.0 || tried <= least {
                length = longer.max(least);
                break (fit, end);
            }
            // More parts each time.
            count = (left / longer.max(least)).ceil().max(count + 1.0);
        };
        let leaf = Leaf::new(piece.kind, index, &curve, &fit);
        parts.push(Part { fit, leaf, extent: extent(piece, [start, end], unit) });
        start = end;
    }
}

/// The box round a stretch of a piece, which is monotone.
fn extent(piece: &Piece, ends: [f64; 2], unit: f64) -> Extent {
    let [a, b] = ends.map(|s| {
        let point = piece.jet(s).point;
        [point.z * unit, (point.r * unit).powi(2)]
    });
    let range = |i: usize| [a[i].min(b[i]), a[i].max(b[i])];
    Extent { z: range(0), w: range(1) }
}

/// Builds all of it; the pieces must not be empty.
pub(super) fn build(pieces: &[Piece], unit: f64) -> Built {
    let mut row = Vec::new();
    for (index, piece) in (0..).zip(pieces) {
        parts(index, piece, unit, &mut row);
    }
    let extents: Vec<_> = row.iter().map(|part| part.extent).collect();
    let mut blocks = Vec::new();
    let mut leaf_boxes = Vec::new();
    let mut leaves = Vec::new();
    let mut boxes = Vec::new();
    for group in group::groups(&extents) {
        let parts: ArrayVec<&Part, LANES> = group.iter().map(|&leaf| &row[leaf]).collect();
        let around = parts.iter().fold(Extent::NONE, |all, part| all.union(&part.extent));
        blocks.push(Block::new(parts.iter().map(|part| &part.fit), &around));
        leaf_boxes.push(LeafBoxes::new(parts.iter().map(|part| &part.extent)));
        boxes.push(around);
        leaves.extend(parts.iter().map(|part| part.leaf));
        // So that a lane has the number of its leaf.
        leaves.extend(parts.last().into_iter().cycle().take(LANES - parts.len()).map(|p| p.leaf));
    }
    blocks.shrink_to_fit();
    leaves.shrink_to_fit();
    leaf_boxes.shrink_to_fit();
    Built { blocks, leaf_boxes, leaves, levels: levels(boxes) }
}

/// Boxes round boxes, up to a level whose boxes all belong together.
fn levels(mut extents: Vec<Extent>) -> Vec<Boxes> {
    let mut levels = Vec::new();
    loop {
        levels.push(Boxes::new(&extents));
        if extents.len() <= WIDTH {
            return levels;
        }
        let around = |own: &[Extent]| own.iter().fold(Extent::NONE, |all, own| all.union(own));
        extents = extents.chunks(BELOW).map(around).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Profile, piece};

    /// The pieces of a profile, in units of which the radius is between 1 and 2.
    fn pieces(text: &str) -> (Vec<Piece>, f64) {
        let profile = Profile::from_path_data(text).unwrap();
        let pieces: Vec<_> = profile.segments().flat_map(piece::cut).collect();
        let size = |p: &Piece| p.start().length().max(p.end().length());
        let unit =
            crate::numeric::reciprocal_power_of_two(pieces.iter().map(size).fold(0.0, f64::max));
        (pieces.into_iter().filter(|p| p.r != [0.0; 4]).collect(), unit)
    }

    const SHAPES: [&str; 6] = [
        include_str!("../../../../../profiles/vase.path"),
        include_str!("../../../../../profiles/goblet.path"),
        include_str!("../../../../../profiles/column.path"),
        "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z",
        "M 0 -1 A 1 1 0 0 1 0 1",
        "M 0 0 Q 1.5 0.2 1.6 1 C 1.5 2 1.2 2.5 1 4 A 1 2 10 0 0 0.5 5 L 0.2 6 L 0 6",
    ];

    #[test]
    fn curves_keep_to_their_quadrics() {
        for shape in SHAPES {
            let (pieces, unit) = pieces(shape);
            let mut row = Vec::new();
            for (index, piece) in (0..).zip(&pieces) {
                parts(index, piece, unit, &mut row);
            }
            for Part { fit, leaf, .. } in &row {
                let piece = &pieces[leaf.piece() as usize];
                let [low, high] = fit.valid;
                let at = |u: f64| {
                    let point = piece.jet(low + u * (high - low)).point;
                    let (w, zeta) = ((point.r * unit).powi(2), point.z * unit - fit.z);
                    let q = fit.alpha * w + fit.gamma + zeta * (fit.beta + fit.p * zeta);
                    (fit.lambda[0] * zeta + fit.lambda[1] * w + fit.lambda[2], q)
                };
                let mut last = at(0.0);
                for i in 1..=64 {
                    let (lambda, q) = at(f64::from(i) / 64.0);
                    assert!(q.abs() <= fit.error + 1e-14, "{q} beyond {}", fit.error);
                    let steps = (lambda - last.0, q - last.1);
                    assert!(steps.0 > 0.0 && lambda.abs() < 1.5, "{lambda} after {}", last.0);
                    assert!(
                        steps.1.abs() <= fit.slope * steps.0 + 1e-14,
                        "{steps:?} {}",
                        fit.slope
                    );
                    last = (lambda, q);
                }
            }
        }
    }

    #[test]
    fn leaves_cover_their_pieces_and_blocks_are_full() {
        for shape in SHAPES {
            let (pieces, unit) = pieces(shape);
            let built = build(&pieces, unit);
            assert_eq!(built.leaves.len(), built.blocks.len() * LANES);
            let mut row = Vec::new();
            for (index, piece) in (0..).zip(&pieces) {
                parts(index, piece, unit, &mut row);
            }
            let inner = |part: &&Part| part.fit.valid[0] > 0.0;
            for pair in row.windows(2).filter(|pair| inner(&&pair[1])) {
                assert!(pair[0].fit.valid[1] > pair[1].fit.valid[0], "a gap between leaves");
            }
            // Boxes must not be cut where that makes more of them than it saves.
            assert!(built.blocks.len() <= 2 * row.len().div_ceil(LANES), "{}", built.blocks.len());
        }
    }
}

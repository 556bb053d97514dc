//! The wide engine: eight leaves of the profile tested at once.
//!
//! ```text
//! Ray -> Course (f64) -> Way: boxes (f32 x 8) -> blocks of quadrics (f32 x 8) -> Spot -> leaf (f64) -> Hit
//! ```
//!
//! A *leaf* is a part of a piece with a quadric of revolution close beside it ([`quadric`]). [`block`] solves
//! the quadratic equations of eight of them at once, in f32, with bounds for all that this leaves out: it
//! says where the ray may hit each leaf, that it does so once at the most there, and how far off that may be.
//! [`leaf`] goes on from the nearest such spot to the hit itself, by Newton's method in f64. What is not certain (tangents,
//! joints within rounding, hits that rounding could put in another order or out of the range) is left to the
//! exact engine's [`root`]. Both engines therefore find the same hits on the same pieces, t apart by rounding.
//!
//! All data is flat: one array for each kind of thing, no pointers. The instruction set is chosen at run time.

mod arithmetic;
mod batch;
mod bernstein;
mod bits;
mod block;
mod boxes;
mod build;
mod course;
mod eight;
mod every;
mod exactly;
mod group;
mod leaf;
mod lot;
mod meet;
mod near;
mod order;
mod packet;
mod quadric;
mod search;
mod walk;

use fearless_simd::{Level, Simd, dispatch};

use self::arithmetic::Best;
use self::block::Block;
use self::boxes::{Boxes, LeafBoxes};
use self::course::{Astray, Course, FAR, LONGEST, NEAR, Outline, SHORTEST, passes};
use self::leaf::{Curve, Leaf};
use self::search::Question;
use super::counters::Count;
use crate::Ray;
use crate::frame::{Frame, LocalRay};
use crate::numeric::{UNIT_ROUNDOFF, gamma, reciprocal_power_of_two};
use crate::piece::Piece;
use crate::pieces::Pieces;
use crate::surface::Hit;

/// The pieces of a profile, ready to be tested eight leaves at a time.
#[derive(Clone, Debug)]
pub(crate) struct Wide {
    level: Level,
    outline: Outline,
    blocks: Vec<Block>,
    /// Boxes round the leaves of each block.
    leaf_boxes: Vec<LeafBoxes>,
    /// In the order of the blocks' lanes.
    leaves: Vec<Leaf>,
    /// One for each piece.
    curves: Vec<Curve>,
    /// Boxes round the blocks, and round boxes that belong together: on the last level all of them do.
    levels: Vec<Boxes>,
}

impl Wide {
    /// Builds the engine over the pieces of a profile, none of whose points is farther from the
    /// origin than `radius`.
    pub(crate) fn new(pieces: &[Piece], radius: f64, level: Level) -> Self {
        let unit = reciprocal_power_of_two(radius);
        let r_max = pieces.iter().fold(0.0_f64, |m, p| m.max(p.r[0]).max(p.r[3]));
        let size = radius * unit;
        let reach = r_max * unit + gamma(64) * size + 8.0 * FAR * UNIT_ROUNDOFF;
        let built = build::build(pieces, unit);
        Self {
            level,
            outline: Outline {
                unit,
                radius2: size * size * (1.0 + gamma(256)),
                reach2: reach * reach,
                far: FAR / unit,
            },
            blocks: built.blocks,
            leaf_boxes: built.leaf_boxes,
            leaves: built.leaves,
            curves: pieces.iter().map(|piece| Curve::new(piece, unit)).collect(),
            levels: built.levels,
        }
    }

    /// The number of blocks and of vectors of boxes.
    pub(crate) fn node_count(&self) -> usize {
        self.blocks.len() + self.levels.iter().map(Boxes::eights).sum::<usize>()
    }

    #[inline]
    pub(crate) fn closest(&self, pieces: &Pieces, frame: &Frame, ray: &Ray) -> Option<Hit> {
        let question = Question { pieces, frame, ray };
        if frame.inverse().is_some() {
            return self.closest_placed(&question);
        }
        if passes(ray, &self.outline) {
            return None;
        }
        self.closest_unplaced(&question)
    }

    // Compiled once, for all instruction sets, and not wherever they are called.
    #[inline(never)]
    fn closest_placed(&self, question: &Question<'_>) -> Option<Hit> {
        dispatch!(self.level, simd => self.closest_with::<_, true>(simd, question))
    }

    #[inline(never)]
    fn closest_unplaced(&self, question: &Question<'_>) -> Option<Hit> {
        dispatch!(self.level, simd => self.closest_with::<_, false>(simd, question))
    }

    #[inline(never)]
    fn any_placed(&self, question: &Question<'_>) -> bool {
        dispatch!(self.level, simd => self.any_with::<_, true>(simd, question))
    }

    #[inline(never)]
    fn any_unplaced(&self, question: &Question<'_>) -> bool {
        dispatch!(self.level, simd => self.any_with::<_, false>(simd, question))
    }

    #[inline]
    pub(crate) fn any(&self, pieces: &Pieces, frame: &Frame, ray: &Ray) -> bool {
        let question = Question { pieces, frame, ray };
        if frame.inverse().is_some() {
            return self.any_placed(&question);
        }
        if passes(ray, &self.outline) {
            return false;
        }
        self.any_unplaced(&question)
    }

    pub(crate) fn all(&self, pieces: &Pieces, frame: &Frame, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        let question = Question { pieces, frame, ray };
        dispatch!(self.level, simd => self.all_with(simd, &question, hits));
    }

    /// Calls `visit` once for every piece that the ray may hit, as
    /// [`Engine::walk`](super::Engine::walk).
    pub(crate) fn candidates<C: Count>(
        &self,
        ray: &LocalRay,
        count: &mut C,
        visit: impl FnMut(u32) -> f64,
    ) {
        let course = Course::of(ray, &self.outline);
        // In a placement that is all but flat the point closest to the centre need not be near. Also
        // where something is not a number.
        let near = course.far <= NEAR && (SHORTEST..=LONGEST).contains(&course.length2);
        if !near {
            let all = 0..self.curves.len() as u32;
            all.map(visit).find(|end| *end == f64::NEG_INFINITY);
            return;
        }
        dispatch!(self.level, simd => self.candidates_with(simd, &course, count, visit));
    }

    #[inline(always)]
    fn closest_with<S: Simd, const PLACED: bool>(
        &self,
        simd: S,
        question: &Question<'_>,
    ) -> Option<Hit> {
        match Course::new::<PLACED>(Best(simd), question.frame, question.ray, &self.outline) {
            Ok(course) => self.closest_on(simd, question, &course),
            Err(Astray::Misses) => None,
            Err(Astray::Strange) => self.closest_exactly(question),
        }
    }

    #[inline(always)]
    fn any_with<S: Simd, const PLACED: bool>(&self, simd: S, question: &Question<'_>) -> bool {
        match Course::new::<PLACED>(Best(simd), question.frame, question.ray, &self.outline) {
            Ok(course) => self.any_on(simd, question, &course),
            Err(Astray::Misses) => false,
            Err(Astray::Strange) => self.closest_exactly(question).is_some(),
        }
    }

    #[inline(always)]
    fn all_with<S: Simd>(&self, simd: S, question: &Question<'_>, hits: &mut Vec<Hit>) {
        match Course::new::<true>(Best(simd), question.frame, question.ray, &self.outline) {
            Ok(course) => self.all_on(simd, question, &course, hits),
            Err(Astray::Misses) => {}
            Err(Astray::Strange) => self.all_exactly(question, hits),
        }
    }
}

//! The queries of one ray that comes near the surface: blocks, near ones first, and the spots in each.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};

use super::Wide;
use super::arithmetic::{Best, lesser};
use super::block::{Block, LANES, Met};
use super::course::Course;
use super::exactly::sort;
use super::leaf::{Finding, Spot};
use super::order::{first, first_and_next};
use super::walk::Way;
use crate::Ray;
use crate::engine::counters::Count;
use crate::frame::Frame;
use crate::numeric::{UNIT_ROUNDOFF, gamma};
use crate::pieces::Pieces;
use crate::surface::Hit;

/// What a query is about.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    pub(super) pieces: &'a Pieces,
    pub(super) frame: &'a Frame,
    pub(super) ray: &'a Ray,
}

/// How far off the exact engine's hits count as being when they are compared with those of other
/// pieces, in units of the radius: they may graze, and rounding by 2^-51 moves a hit at an incidence of
/// 2^-21 by as much. Where two pieces are nearer to each other than that, it decides itself.
const EXACT_MARGIN: f64 = gamma(1 << 23);

/// The nearest hit so far.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    tau: f64,
    s: f64,
    piece: u32,
    margin: f64,
    /// Rounding could choose between two pieces.
    doubt: bool,
}

impl Nearest {
    const NONE: Self =
        Self { tau: f64::INFINITY, s: 0.0, piece: u32::MAX, margin: 0.0, doubt: false };

    #[inline(always)]
    fn consider(&mut self, tau: f64, s: f64, piece: u32, margin: f64) {
        let ahead = tau - self.tau;
        self.doubt |= ahead.abs() < margin + self.margin && piece != self.piece;
        if ahead < 0.0 {
            *self = Self { tau, s, piece, margin, doubt: self.doubt };
        }
    }

    #[inline(always)]
    fn hit(&self, course: &Course) -> Option<Hit> {
        let t = self.tau + course.shift;
        (t < f64::INFINITY).then_some(Hit { t, piece: self.piece, s: self.s })
    }
}

/// The spots of a block: the first roots of its leaves, then the second ones.
pub(super) struct Spots<S: Simd> {
    /// Where tau counts from.
    origin: f64,
    /// The least that they may be.
    low: [f32x8<S>; 2],
    /// Which of them wait.
    waiting: u32,
    /// Their numbers.
    tau: [f32; 2 * LANES],
    s: [f32; 2 * LANES],
    blur: [f32; LANES],
}

impl<S: Simd> Spots<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, block: &Block, meeting: &Met<S>, origin: f32) -> Self {
        let (mut tau, mut s) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        let mut blur = [0.0; LANES];
        meeting.tau[0].store_slice(&mut tau[..LANES]);
        meeting.tau[1].store_slice(&mut tau[LANES..]);
        block.guess(simd, meeting.lambda[0]).store_slice(&mut s[..LANES]);
        block.guess(simd, meeting.lambda[1]).store_slice(&mut s[LANES..]);
        meeting.blur.store_array(&mut blur);
        let waiting = meeting.may[0] | meeting.may[1] << LANES;
        Self { origin: f64::from(origin), low: meeting.low, waiting, tau, s, blur }
    }

    /// Of those in the masks the one that comes first, or nearly so, with its number, and where the others begin, at the earliest;
    /// of no meaning if there is none.
    #[inline(always)]
    pub(super) fn nearest(
        simd: S,
        block: &Block,
        meeting: &Met<S>,
        masks: [mask32x8<S>; 2],
        origin: f64,
    ) -> (usize, Spot, f64) {
        let (number, next) = first_and_next(simd, meeting.low, masks);
        let (mut tau, mut lambda) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        let mut blur = [0.0; LANES];
        for root in 0..2 {
            meeting.tau[root].store_slice(&mut tau[root * LANES..][..LANES]);
            meeting.lambda[root].store_slice(&mut lambda[root * LANES..][..LANES]);
        }
        meeting.blur.store_array(&mut blur);
        let (number, lane) = (number % (2 * LANES), number % LANES);
        let spot = Spot {
            tau: origin + f64::from(tau[number]),
            s: block.guess_in(Best(simd), lane, lambda[number]),
            blur: f64::from(blur[lane]),
        };
        (number, spot, origin + f64::from(next))
    }

    /// Takes out the one that comes first, or nearly so, with its leaf's lane.
    #[inline(always)]
    fn first(&mut self, simd: S) -> (usize, Spot) {
        let number = first(simd, self.low, self.waiting);
        self.waiting &= !(1 << number);
        (number % LANES, self.spot(number))
    }

    /// Takes out any.
    #[inline(always)]
    fn take(&mut self) -> Option<(usize, Spot)> {
        let number = take(&mut self.waiting)?;
        Some((number % LANES, self.spot(number)))
    }

    #[inline(always)]
    pub(super) fn spot(&self, number: usize) -> Spot {
        let number = number % (2 * LANES);
        Spot {
            tau: self.origin + f64::from(self.tau[number]),
            s: f64::from(self.s[number]),
            blur: f64::from(self.blur[number % LANES]),
        }
    }

    /// Leaves out what lies beyond `end`.
    #[inline(always)]
    fn cut(&mut self, simd: S, end: f64) {
        let end = (end - self.origin) as f32;
        let end = f32x8::splat(simd, end + end.abs() * f32::EPSILON);
        let [near, far] = self.low;
        let before = near.simd_le(end).to_bitmask() | far.simd_le(end).to_bitmask() << LANES;
        self.waiting &= before as u32;
    }
}

impl Wide {
    #[inline(always)]
    pub(super) fn closest_on<S: Simd>(
        &self,
        simd: S,
        question: &Question<'_>,
        course: &Course,
    ) -> Option<Hit> {
        let mut way = Way::new::<_, true>(simd, self, course);
        let mut end = course.range[1];
        let mut nearest = Nearest::NONE;
        let mut stop = way.first::<_, true>(simd, self, end)?;
        // Most rays end at the first spot in the first block that has any: no loop that keeps everything at hand.
        loop {
            let (block, enter) = stop;
            let meeting = self.blocks[block].test::<S, false>(simd, course, enter, end);
            if meeting.misses() {
                stop = way.next::<_, true>(simd, self, end)?;
                continue;
            }
            if meeting.tangent != 0 {
                break;
            }
            let enter = f64::from(enter);
            let (mut number, mut spot, mut other) =
                Spots::nearest(simd, &self.blocks[block], &meeting, meeting.masks, enter);
            let mut leaf = &self.leaves[block * LANES + number % LANES];
            let mut left = meeting.may[0] | meeting.may[1] << LANES;
            // It may be where the ray begins: few rays begin on a surface, or nearly all of them do.
            while spot.tau - spot.blur <= course.range[0]
                && leaf.misses(Best(simd), &self.curves, course, spot)
            {
                left &= !(1 << number);
                if left == 0 {
                    break;
                }
                let masks = [left & 0xff, left >> LANES]
                    .map(|half| mask32x8::from_bitmask(simd, u64::from(half)));
                (number, spot, other) =
                    Spots::nearest(simd, &self.blocks[block], &meeting, masks, enter);
                leaf = &self.leaves[block * LANES + number % LANES];
            }
            if left == 0 {
                stop = way.next::<_, true>(simd, self, end)?;
                continue;
            }
            if let Some(hit) = leaf.quick(Best(simd), &self.curves, course, spot)
                && hit.tau < other
            {
                let piece = leaf.piece();
                if way.is_over(simd, hit.tau) {
                    return Some(Hit { t: hit.tau + course.shift, piece, s: hit.s });
                }
                end = lesser(end, hit.tau);
                nearest.consider(hit.tau, hit.s, piece, hit.margin);
                stop = match way.next::<_, true>(simd, self, end) {
                    Some(stop) => stop,
                    None => return nearest.hit(course),
                };
            }
            break;
        }
        simd.vectorize(
            #[inline(always)]
            || self.closest_along(simd, question, course, way, stop, nearest),
        )
    }

    /// The same from a block on.
    #[inline(always)]
    fn closest_along<S: Simd>(
        &self,
        simd: S,
        question: &Question<'_>,
        course: &Course,
        mut way: Way,
        (mut block, mut enter): (usize, f32),
        mut nearest: Nearest,
    ) -> Option<Hit> {
        let mut end = lesser(course.range[1], nearest.tau);
        loop {
            let meeting = self.blocks[block].test::<S, false>(simd, course, enter, end);
            let mut lanes = meeting.tangent;
            while let Some(piece) = self.take_piece(block, &mut lanes) {
                self.consider_exactly(piece, question, course, &mut nearest);
                end = end.min(nearest.tau);
            }
            if meeting.may_hit() {
                let mut spots = Spots::new(simd, &self.blocks[block], &meeting, enter);
                spots.cut(simd, end);
                while spots.waiting != 0 {
                    let (lane, spot) = spots.first(simd);
                    let leaf = &self.leaves[block * LANES + lane];
                    let piece = leaf.piece();
                    match leaf.hit(Best(simd), &self.curves, course, spot) {
                        Finding::None => continue,
                        Finding::Hit { tau, s, margin } => nearest.consider(tau, s, piece, margin),
                        Finding::Unknown => {
                            self.consider_exactly(piece, question, course, &mut nearest);
                        }
                    }
                    end = end.min(nearest.tau);
                    spots.cut(simd, end);
                }
            }
            let Some(next) = way.next::<_, true>(simd, self, end) else { break };
            (block, enter) = next;
        }
        if nearest.doubt {
            return self.closest_exactly(question);
        }
        nearest.hit(course)
    }

    /// Takes the lanes of a piece out of a set.
    #[inline(always)]
    fn take_piece(&self, block: usize, lanes: &mut u32) -> Option<u32> {
        let piece_of = |lane: usize| self.leaves[block * LANES + lane].piece();
        let piece = piece_of(take(lanes)?);
        // Leaves of one piece follow each other.
        while *lanes != 0 && piece_of(lanes.trailing_zeros() as usize) == piece {
            take(lanes);
        }
        Some(piece)
    }

    /// Takes account of the hits on a piece as the exact engine finds them.
    #[cold]
    #[inline(never)]
    fn consider_exactly(
        &self,
        piece: u32,
        question: &Question<'_>,
        course: &Course,
        nearest: &mut Nearest,
    ) {
        let margin =
            EXACT_MARGIN / course.length2.sqrt() + 4.0 * UNIT_ROUNDOFF * course.shift.abs();
        for hit in self.hits_exactly(question, piece) {
            nearest.consider(hit.t - course.shift, hit.s, piece, margin);
        }
    }

    #[inline(always)]
    pub(super) fn any_on<S: Simd>(
        &self,
        simd: S,
        question: &Question<'_>,
        course: &Course,
    ) -> bool {
        let mut way = Way::new::<_, false>(simd, self, course);
        let end = course.range[1];
        let Some(mut stop) = way.first::<_, false>(simd, self, end) else { return false };
        // Most rays meet only blocks that have a hit for certain, or none.
        loop {
            let (block, enter) = stop;
            let meeting = self.blocks[block].test::<S, true>(simd, course, enter, end);
            if meeting.sure != 0 {
                return true;
            }
            if meeting.tangent != 0 {
                break;
            }
            if meeting.may_hit() {
                let mut spots = Spots::new(simd, &self.blocks[block], &meeting, enter);
                let Some((lane, spot)) = spots.take() else { break };
                let leaf = &self.leaves[block * LANES + lane];
                match leaf.hit(Best(simd), &self.curves, course, spot) {
                    Finding::None if spots.waiting == 0 => {}
                    Finding::Hit { .. } => return true,
                    _ => break,
                }
            }
            stop = match way.next::<_, false>(simd, self, end) {
                Some(stop) => stop,
                None => return false,
            };
        }
        simd.vectorize(
            #[inline(always)]
            || self.any_along(simd, question, course, way, stop),
        )
    }

    #[inline(always)]
    fn any_along<S: Simd>(
        &self,
        simd: S,
        question: &Question<'_>,
        course: &Course,
        mut way: Way,
        (mut block, mut enter): (usize, f32),
    ) -> bool {
        let end = course.range[1];
        // Blocks that may have a hit wait until it is known that no other has one for certain.
        let mut unsure = ArrayVec::<(usize, f32), 16>::new();
        loop {
            let meeting = self.blocks[block].test::<S, true>(simd, course, enter, end);
            if meeting.sure != 0 {
                return true;
            }
            if !meeting.misses()
                && unsure.try_push((block, enter)).is_err()
                && self.any_in(simd, question, course, (block, enter))
            {
                return true;
            }
            let Some(next) = way.next::<_, false>(simd, self, end) else { break };
            (block, enter) = next;
        }
        for block in unsure {
            if self.any_in(simd, question, course, block) {
                return true;
            }
        }
        false
    }

    /// Whether there is a hit in a block.
    #[inline(always)]
    fn any_in<S: Simd>(
        &self,
        simd: S,
        question: &Question<'_>,
        course: &Course,
        (block, enter): (usize, f32),
    ) -> bool {
        let end = course.range[1];
        let meeting = self.blocks[block].test::<S, false>(simd, course, enter, end);
        let mut unknown = meeting.tangent;
        let mut spots = Spots::new(simd, &self.blocks[block], &meeting, enter);
        while let Some((lane, spot)) = spots.take() {
            let leaf = &self.leaves[block * LANES + lane];
            match leaf.hit(Best(simd), &self.curves, course, spot) {
                Finding::None => {}
                Finding::Hit { .. } => return true,
                Finding::Unknown => unknown |= 1 << lane,
            }
        }
        while let Some(piece) = self.take_piece(block, &mut unknown) {
            if !self.hits_exactly(question, piece).is_empty() {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    pub(super) fn all_on<S: Simd>(
        &self,
        simd: S,
        question: &Question<'_>,
        course: &Course,
        hits: &mut Vec<Hit>,
    ) {
        let mut widest = 0.0_f64;
        let end = course.range[1];
        let mut way = Way::new::<_, false>(simd, self, course);
        while let Some((block, enter)) = way.next::<_, false>(simd, self, end) {
            let meeting = self.blocks[block].test::<S, false>(simd, course, enter, end);
            if meeting.tangent != 0 {
                return self.all_exactly(question, hits);
            }
            if !meeting.may_hit() {
                continue;
            }
            let mut spots = Spots::new(simd, &self.blocks[block], &meeting, enter);
            while let Some((lane, spot)) = spots.take() {
                let leaf = &self.leaves[block * LANES + lane];
                match leaf.hit(Best(simd), &self.curves, course, spot) {
                    Finding::None => {}
                    Finding::Hit { tau, s, margin } => {
                        hits.push(Hit { t: tau + course.shift, piece: leaf.piece(), s });
                        widest = widest.max(margin);
                    }
                    Finding::Unknown => return self.all_exactly(question, hits),
                }
            }
        }
        sort(hits);
        // Hits of two leaves at one place are one hit, or two in an order that rounding must not choose.
        let close = 2.0 * widest;
        if hits.windows(2).any(|pair| pair[1].t - pair[0].t <= close) {
            self.all_exactly(question, hits);
        }
    }

    #[inline(always)]
    pub(super) fn candidates_with<S: Simd, C: Count>(
        &self,
        simd: S,
        course: &Course,
        count: &mut C,
        mut visit: impl FnMut(u32) -> f64,
    ) {
        let mut end = course.range[1];
        let mut seen = Vec::new();
        let mut way = Way::new::<_, true>(simd, self, course);
        count.test();
        while let Some((block, enter)) = way.next::<_, true>(simd, self, end) {
            count.enter();
            count.test();
            let meeting = self.blocks[block].test::<S, false>(simd, course, enter, end);
            let mut lanes = meeting.tangent;
            let mut spots = Spots::new(simd, &self.blocks[block], &meeting, enter);
            loop {
                let lane = match take(&mut lanes) {
                    Some(lane) => lane,
                    None if spots.waiting != 0 => spots.first(simd).0,
                    None => break,
                };
                let piece = self.leaves[block * LANES + lane].piece();
                if seen.contains(&piece) {
                    continue;
                }
                seen.push(piece);
                count.positive();
                count.solve();
                let found = visit(piece);
                if found == f64::NEG_INFINITY {
                    return;
                }
                end = end.min(found * self.outline.unit);
            }
        }
    }
}

/// Takes the lowest bit of a set.
#[inline(always)]
fn take(mask: &mut u32) -> Option<usize> {
    if *mask == 0 {
        return None;
    }
    let bit = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    Some(bit)
}

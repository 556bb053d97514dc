//! The queries of one ray that meets the surface's sphere: blocks, near ones first, and the spots in each.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};

use super::Wide;
use super::arithmetic::Best;
use super::block::{LANES, Meeting};
use super::course::Course;
use super::exactly::sort;
use super::leaf::{Finding, Spot};
use crate::engine::counters::Count;
use crate::frame::Frame;
use crate::numeric::gamma;
use crate::piece::Piece;
use crate::surface::Hit;
use crate::{Ray, numeric::UNIT_ROUNDOFF};

/// How far off the exact engine's hits count as being when they are compared with those of other
/// pieces, in units of the radius.
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
}

/// The spots of a block, kept for as long as they wait.
struct Spots<S: Simd> {
    meeting: Meeting<S>,
    /// Where each may be at the least.
    low: [f64x8<S>; 2],
    /// Which of the first and of the second roots wait.
    waiting: [u32; 2],
}

impl<S: Simd> Spots<S> {
    #[inline(always)]
    fn new(meeting: Meeting<S>) -> Self {
        let [near, far] = meeting.tau;
        let low = [near - meeting.blur, far - meeting.blur];
        let waiting = [meeting.may[0].to_bitmask() as u32, meeting.may[1].to_bitmask() as u32];
        Self { meeting, low, waiting }
    }

    /// Takes out the one that may be the nearest, with its leaf's lane.
    #[inline(always)]
    fn nearest(&mut self, simd: S) -> (usize, Spot) {
        let near = mask64x8::from_bitmask(simd, u64::from(self.waiting[0]));
        let far = mask64x8::from_bitmask(simd, u64::from(self.waiting[1]));
        let none = f64x8::splat(simd, f64::INFINITY);
        let low = near.select(self.low[0], far.select(self.low[1], none));
        let least = low.reduce_min();
        let bits = low.simd_le(f64x8::splat(simd, least)).to_bitmask() as u32;
        let lane = bits.trailing_zeros() as usize % LANES;
        let second = usize::from(self.waiting[0] & 1 << lane == 0);
        self.waiting[second] &= !(1 << lane);
        (lane, self.spot(lane, second))
    }

    #[inline(always)]
    fn spot(&self, lane: usize, second: usize) -> Spot {
        let mut values = [[0.0; LANES]; 3];
        self.meeting.tau[second].store_array(&mut values[0]);
        self.meeting.lambda[second].store_array(&mut values[1]);
        self.meeting.blur.store_array(&mut values[2]);
        Spot { tau: values[0][lane], lambda: values[1][lane], blur: values[2][lane] }
    }

    /// Leaves out what lies beyond `end`.
    #[inline(always)]
    fn cut(&mut self, simd: S, end: f64) {
        let end = f64x8::splat(simd, end);
        for (waiting, low) in self.waiting.iter_mut().zip(self.low) {
            *waiting &= low.simd_le(end).to_bitmask() as u32;
        }
    }

    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.waiting[0] | self.waiting[1] == 0
    }
}

impl Wide {
    #[inline(always)]
    pub(super) fn closest_on<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        course: &Course,
    ) -> Option<Hit> {
        let mut nearest = Nearest::NONE;
        self.walk(
            simd,
            course,
            &mut (),
            #[inline(always)]
            |end, block, ()| {
                let meeting = self.blocks[block].test::<S, false>(simd, course, *end);
                let tangent = meeting.tangent;
                let mut spots = Spots::new(meeting);
                if tangent != 0 {
                    self.consider_tangents(block, tangent, pieces, frame, ray, course, &mut nearest);
                    *end = end.min(nearest.tau);
                }
                while !spots.is_empty() {
                    let (lane, spot) = spots.nearest(simd);
                    let leaf = &self.leaves[block * LANES + lane];
                    match leaf.hit(Best(simd), &self.curves, course, spot) {
                        Finding::None => continue,
                        Finding::Hit { tau, s, margin } => {
                            nearest.consider(tau, s, leaf.piece(), margin);
                        }
                        Finding::Unknown => {
                            self.consider_exactly(
                                leaf.piece(),
                                pieces,
                                frame,
                                ray,
                                course,
                                &mut nearest,
                            );
                        }
                    }
                    *end = end.min(nearest.tau);
                    spots.cut(simd, *end);
                }
                true
            },
        );
        if nearest.doubt {
            return self.closest_exactly(pieces, frame, ray);
        }
        (nearest.tau < f64::INFINITY).then(|| Hit {
            t: nearest.tau + course.shift,
            piece: nearest.piece,
            s: nearest.s,
        })
    }

    /// Takes account of the hits on a piece as the exact engine finds them.
    #[cold]
    #[inline(never)]
    fn consider_exactly(
        &self,
        piece: u32,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        course: &Course,
        nearest: &mut Nearest,
    ) {
        let margin = EXACT_MARGIN / course.length2.sqrt() + 4.0 * UNIT_ROUNDOFF * course.shift.abs();
        for hit in self.hits_exactly(pieces, frame, ray, piece) {
            nearest.consider(hit.t - course.shift, hit.s, piece, margin);
        }
    }

    #[cold]
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what the query is about, and what was found")]
    fn consider_tangents(
        &self,
        block: usize,
        mut lanes: u32,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        course: &Course,
        nearest: &mut Nearest,
    ) {
        let mut last = u32::MAX;
        while let Some(lane) = take(&mut lanes) {
            let piece = self.leaves[block * LANES + lane].piece();
            if piece != last {
                self.consider_exactly(piece, pieces, frame, ray, course, nearest);
                last = piece;
            }
        }
    }

    #[inline(always)]
    pub(super) fn any_on<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        course: &Course,
    ) -> bool {
        let mut found = false;
        // Blocks that may have a hit wait until it is known that no other has one for certain.
        let mut unsure = ArrayVec::<u32, LANES>::new();
        self.walk(
            simd,
            course,
            &mut (),
            #[inline(always)]
            |end, block, ()| {
                let meeting = self.blocks[block].test::<S, true>(simd, course, *end);
                if meeting.sure != 0 {
                    found = true;
                    return false;
                }
                let may = (meeting.may[0] | meeting.may[1]).to_bitmask() as u32;
                if may | meeting.tangent != 0 && unsure.try_push(block as u32).is_err() {
                    found = self.any_in(simd, pieces, frame, ray, course, block);
                }
                !found
            },
        );
        for block in unsure {
            found = found || self.any_in(simd, pieces, frame, ray, course, block as usize);
        }
        found
    }

    /// Whether there is a hit in a block.
    #[expect(clippy::too_many_arguments, reason = "what the query is about, and where to look")]
    #[inline(always)]
    fn any_in<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        course: &Course,
        block: usize,
    ) -> bool {
        let meeting = self.blocks[block].test::<S, false>(simd, course, course.range[1]);
        let mut unknown = meeting.tangent;
        let spots = Spots::new(meeting);
        for second in [0, 1] {
            let mut lanes = spots.waiting[second];
            while let Some(lane) = take(&mut lanes) {
                let leaf = &self.leaves[block * LANES + lane];
                match leaf.hit(Best(simd), &self.curves, course, spots.spot(lane, second)) {
                    Finding::None => {}
                    Finding::Hit { .. } => return true,
                    Finding::Unknown => unknown |= 1 << lane,
                }
            }
        }
        while let Some(lane) = take(&mut unknown) {
            let piece = self.leaves[block * LANES + lane].piece();
            if !self.hits_exactly(pieces, frame, ray, piece).is_empty() {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    pub(super) fn all_on<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        course: &Course,
        hits: &mut Vec<Hit>,
    ) {
        let mut doubt = false;
        let mut widest = 0.0_f64;
        self.walk(
            simd,
            course,
            &mut (),
            #[inline(always)]
            |end, block, ()| {
                let meeting = self.blocks[block].test::<S, false>(simd, course, *end);
                doubt = meeting.tangent != 0;
                let spots = Spots::new(meeting);
                for second in [0, 1] {
                    let mut lanes = spots.waiting[second];
                    while let Some(lane) = take(&mut lanes) {
                        let leaf = &self.leaves[block * LANES + lane];
                        let spot = spots.spot(lane, second);
                        match leaf.hit(Best(simd), &self.curves, course, spot) {
                            Finding::None => {}
                            Finding::Hit { tau, s, margin } => {
                                let t = tau + course.shift;
                                hits.push(Hit { t, piece: leaf.piece(), s });
                                widest = widest.max(margin);
                            }
                            Finding::Unknown => doubt = true,
                        }
                    }
                }
                !doubt
            },
        );
        sort(hits);
        // Hits of two leaves at one place are one hit, or two in an order that rounding must not choose.
        let close = 2.0 * widest;
        if doubt || hits.windows(2).any(|pair| pair[1].t - pair[0].t <= close) {
            self.all_exactly(pieces, frame, ray, hits);
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
        let mut seen = Vec::new();
        self.walk(
            simd,
            course,
            count,
            #[inline(always)]
            |end, block, count| {
                count.test();
                let meeting = self.blocks[block].test::<S, false>(simd, course, *end);
                let tangent = meeting.tangent;
                let mut spots = Spots::new(meeting);
                let mut order = ArrayVec::<usize, { 3 * LANES }>::new();
                let mut tangents = tangent;
                while let Some(lane) = take(&mut tangents) {
                    order.push(lane);
                }
                while !spots.is_empty() {
                    order.push(spots.nearest(simd).0);
                }
                for lane in order {
                    let piece = self.leaves[block * LANES + lane].piece();
                    if seen.contains(&piece) {
                        continue;
                    }
                    seen.push(piece);
                    count.positive();
                    count.solve();
                    let found = visit(piece);
                    if found == f64::NEG_INFINITY {
                        return false;
                    }
                    *end = end.min(found);
                }
                true
            },
        );
    }
}

/// Takes the lowest bit of a set.
#[inline(always)]
fn take(mask: &mut u32) -> Option<usize> {
    if *mask == 0 {
        return None;
    }
    let bit = mask.trailing_zeros() as usize % LANES;
    *mask &= *mask - 1;
    Some(bit)
}

//! A ray's way from boxes to blocks, near ones first.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::Wide;
use super::boxes::{Slabs, WIDTH};
use super::course::Course;
use super::order::{first, least};
use super::search::begin;

/// Levels of boxes above the lowest: 2^20 blocks.
const LEVELS: usize = 4;

/// Where a ray is on its way.
pub(super) struct Way {
    slabs: Slabs,
    level: usize,
    current: Vector,
    above: ArrayVec<Vector, LEVELS>,
}

/// Sixteen boxes of which some wait.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Vector {
    enter: [f32; WIDTH],
    waiting: u32,
    /// The number of the first box on its level.
    start: usize,
}

impl Way {
    /// The way of a ray through the blocks.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, wide: &Wide, ray: &Course) -> Self {
        let slabs = Slabs::new(ray);
        let above = ArrayVec::new();
        let Some(top) = wide.levels.len().checked_sub(1) else {
            // A single block.
            let current = Vector { enter: [f32::NEG_INFINITY; WIDTH], waiting: 1, start: 0 };
            return Self { slabs, level: 0, current, above };
        };
        let current = Vector::new(simd, wide, &slabs, top, 0, ray.range[1]);
        Self { slabs, level: top, current, above }
    }

    /// The next block that the ray may meet before `end`.
    #[inline(always)]
    pub(super) fn next<S: Simd>(&mut self, simd: S, wide: &Wide, end: f64) -> Option<usize> {
        loop {
            let Some(box_) = self.current.next(simd, end) else {
                self.current = self.above.pop()?;
                self.level += 1;
                continue;
            };
            if self.level == 0 {
                return Some(box_);
            }
            self.level -= 1;
            let below = Vector::new(simd, wide, &self.slabs, self.level, box_, end);
            // There are no more levels than there is room for.
            let _ = self.above.try_push(core::mem::replace(&mut self.current, below));
        }
    }

    /// Where the ray enters what is left, at the earliest; if that is negative, minus infinity.
    #[inline(always)]
    pub(super) fn least<S: Simd>(&self, simd: S) -> f64 {
        let mut least = self.current.least(simd);
        for vector in &self.above {
            least = least.min(vector.least(simd));
        }
        least
    }

    /// Whether no block is left before `end`.
    #[inline(always)]
    pub(super) fn is_over<S: Simd>(&self, simd: S, end: f64) -> bool {
        let mut waiting = self.current.waiting_before(simd, end).0;
        for vector in &self.above {
            waiting |= vector.waiting_before(simd, end).0;
        }
        waiting == 0
    }
}

impl Vector {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        wide: &Wide,
        slabs: &Slabs,
        level: usize,
        index: usize,
        end: f64,
    ) -> Self {
        let (waiting, enter) = wide.levels[level][index].test(simd, slabs, beyond(end));
        let mut vector = Self { enter: [0.0; WIDTH], waiting, start: index * WIDTH };
        enter.store_array(&mut vector.enter);
        vector
    }

    /// Which boxes wait, and where the ray enters them.
    #[inline(always)]
    fn waiting_before<S: Simd>(&self, simd: S, end: f64) -> (u32, f32x16<S>) {
        let enter = f32x16::from_slice(simd, &self.enter);
        let before = enter.simd_le(f32x16::splat(simd, beyond(end)));
        (self.waiting & before.to_bitmask() as u32, enter)
    }

    #[inline(always)]
    fn least<S: Simd>(&self, simd: S) -> f64 {
        let enter = f32x16::from_slice(simd, &self.enter);
        begin(least(simd, enter, mask32x16::from_bitmask(simd, u64::from(self.waiting))))
    }

    /// The nearest box that waits.
    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, end: f64) -> Option<usize> {
        let (waiting, enter) = self.waiting_before(simd, end);
        self.waiting = waiting;
        if waiting == 0 {
            return None;
        }
        let lane = first(simd, enter, mask32x16::from_bitmask(simd, u64::from(waiting)));
        self.waiting &= !(1 << lane);
        Some(self.start + lane)
    }
}

/// A parameter as an f32, or somewhat more.
#[inline(always)]
fn beyond(end: f64) -> f32 {
    let end = end as f32;
    end + end.abs() * (4.0 * f32::EPSILON)
}

//! A ray's way from boxes to blocks, near ones first; or in any order, as they come, where no choice has to be waited for.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};

use super::Wide;
use super::boxes::{BELOW, EIGHT, Slabs, WIDTH};
use super::course::Course;
use super::order;

/// Levels of boxes above the lowest: as many as 2^32 leaves need, and leaves are numbered in a u32.
const LEVELS: usize = 7;

/// Where a ray is on its way.
pub(super) struct Way {
    slabs: Slabs,
    level: usize,
    current: Vector,
    above: ArrayVec<Vector, LEVELS>,
}

/// Boxes that belong together, of which some wait.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Vector {
    enter: [f32; WIDTH],
    waiting: u32,
    /// The one that the ray enters first, or nearly so, if it meets any.
    first: usize,
    /// The number of the first box on its level.
    start: usize,
}

impl Way {
    /// The way of a ray through the blocks.
    #[inline(always)]
    pub(super) fn new<S: Simd, const NEAREST: bool>(simd: S, wide: &Wide, ray: &Course) -> Self {
        let slabs = Slabs::new(ray);
        let level = wide.levels.len() - 1;
        let current = Vector::new::<_, NEAREST>(simd, wide, &slabs, level, 0, ray.range[1]);
        Self { slabs, level, current, above: ArrayVec::new() }
    }

    /// What [`next`](Self::next) would say on a way that begins, sooner.
    #[inline(always)]
    pub(super) fn first<S: Simd, const NEAREST: bool>(
        &mut self,
        simd: S,
        wide: &Wide,
        end: f64,
    ) -> Option<(usize, f32)> {
        let found = self.current.first::<NEAREST>();
        self.down::<_, NEAREST>(simd, wide, found, end)
    }

    /// The next block that the ray may meet before `end`, and where it enters the box round it.
    #[inline(always)]
    pub(super) fn next<S: Simd, const NEAREST: bool>(
        &mut self,
        simd: S,
        wide: &Wide,
        end: f64,
    ) -> Option<(usize, f32)> {
        let found = self.current.next::<_, NEAREST>(simd, end);
        self.down::<_, NEAREST>(simd, wide, found, end)
    }

    /// From a box that was found to the first block in it, or in the next one that has any.
    #[inline(always)]
    fn down<S: Simd, const NEAREST: bool>(
        &mut self,
        simd: S,
        wide: &Wide,
        mut found: Option<(usize, f32)>,
        end: f64,
    ) -> Option<(usize, f32)> {
        loop {
            let Some((number, enter)) = found else {
                self.current = self.above.pop()?;
                self.level += 1;
                found = self.current.next::<_, NEAREST>(simd, end);
                continue;
            };
            if self.level == 0 {
                return Some((number, enter));
            }
            self.level -= 1;
            let below = Vector::new::<_, NEAREST>(simd, wide, &self.slabs, self.level, number, end);
            // There are no more levels than there is room for.
            let _ = self.above.try_push(core::mem::replace(&mut self.current, below));
            found = self.current.first::<NEAREST>();
        }
    }

    /// Whether nothing is left before `end`.
    #[inline(always)]
    pub(super) fn is_over<S: Simd>(&self, simd: S, end: f64) -> bool {
        let mut waiting = self.current.waiting_before(simd, end);
        for vector in &self.above {
            waiting |= vector.waiting_before(simd, end);
        }
        waiting == 0
    }
}

impl Vector {
    const NONE: Self = Self { enter: [0.0; WIDTH], waiting: 0, first: 0, start: 0 };

    /// Boxes of one level.
    #[inline(always)]
    fn new<S: Simd, const NEAREST: bool>(
        simd: S,
        wide: &Wide,
        slabs: &Slabs,
        level: usize,
        index: usize,
        end: f64,
    ) -> Self {
        let mut vector = Self { start: index * BELOW, ..Self::NONE };
        let boxes = &wide.levels[level];
        (vector.waiting, vector.first) = if NEAREST {
            boxes.test(simd, index, slabs, beyond(end), &mut vector.enter)
        } else {
            (boxes.test_unordered(simd, index, slabs, beyond(end), &mut vector.enter), 0)
        };
        vector
    }

    /// The nearest box, if none has been taken out yet.
    #[inline(always)]
    fn first<const NEAREST: bool>(&mut self) -> Option<(usize, f32)> {
        self.take(if NEAREST { self.first } else { self.waiting.trailing_zeros() as usize })
    }

    /// Which boxes wait that begin before `end`.
    #[inline(always)]
    fn waiting_before<S: Simd>(&self, simd: S, end: f64) -> u32 {
        let end = f32x8::splat(simd, beyond(end));
        let mut before = 0;
        for (i, enter) in self.eights_that_wait() {
            let enter = f32x8::from_slice(simd, enter);
            before |= (enter.simd_le(end).to_bitmask() as u32) << (i * EIGHT);
        }
        self.waiting & before
    }

    /// Eights of boxes up to the last one that waits.
    #[inline(always)]
    fn eights_that_wait(&self) -> impl Iterator<Item = (usize, &[f32])> {
        let count = (u32::BITS - self.waiting.leading_zeros()).div_ceil(EIGHT as u32) as usize;
        self.enter.chunks_exact(EIGHT).take(count).enumerate()
    }

    /// The nearest box that waits.
    #[inline(always)]
    fn next<S: Simd, const NEAREST: bool>(&mut self, simd: S, end: f64) -> Option<(usize, f32)> {
        if !NEAREST {
            return self.take(self.waiting.trailing_zeros() as usize);
        }
        self.waiting = self.waiting_before(simd, end);
        if self.waiting == 0 {
            return None;
        }
        let mut keys = order::none(simd);
        for (i, enter) in self.eights_that_wait() {
            let waiting =
                mask32x8::from_bitmask(simd, u64::from(self.waiting >> (i * EIGHT) & 0xff));
            keys = keys.min(order::keys(simd, f32x8::from_slice(simd, enter), waiting, i));
        }
        self.take(order::number(keys))
    }

    /// Takes out a box, if any waits: the one with this number in the vector.
    #[inline(always)]
    fn take(&mut self, number: usize) -> Option<(usize, f32)> {
        if self.waiting == 0 {
            return None;
        }
        let number = number % WIDTH;
        self.waiting &= !(1 << number);
        Some((self.start + number, self.enter[number]))
    }
}

/// A parameter as an f32, or somewhat more.
#[inline(always)]
fn beyond(end: f64) -> f32 {
    let end = end as f32;
    end + end.abs() * (4.0 * f32::EPSILON)
}

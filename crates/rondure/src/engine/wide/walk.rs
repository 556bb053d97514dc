//! A ray's way from boxes to blocks, near ones first.

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::Wide;
use super::boxes::{Slabs, WIDTH};
use super::course::Course;
use crate::engine::counters::Count;

/// Levels of boxes: 2^20 blocks.
pub(super) const LEVELS: usize = 5;

/// Sixteen boxes of which some wait.
#[repr(C, align(64))]
struct Vector {
    enter: [f32; WIDTH],
    waiting: u32,
    /// The number of the first box on its level.
    first: usize,
}

impl Wide {
    /// Visits the blocks that a ray may meet, near ones first by and large, as long as `visit` says so;
    /// it may bring the ray's end nearer.
    #[inline(always)]
    pub(super) fn walk<S: Simd, C: Count>(
        &self,
        simd: S,
        ray: &Course,
        count: &mut C,
        mut visit: impl FnMut(&mut f64, usize, &mut C) -> bool,
    ) {
        let mut end = ray.range[1];
        if self.levels.is_empty() {
            count.enter();
            visit(&mut end, 0, count);
            return;
        }
        let slabs = Slabs::new(ray);
        let mut stack = ArrayVec::<Vector, LEVELS>::new();
        let mut level = self.levels.len() - 1;
        let mut index = 0;
        loop {
            count.test();
            let (waiting, enter) = self.levels[level][index].test(simd, &slabs, beyond(end));
            let mut vector = Vector { enter: [0.0; WIDTH], waiting, first: index * WIDTH };
            enter.store_array(&mut vector.enter);
            // Down to the next vector of boxes.
            loop {
                let Some(box_) = vector.next(beyond(end)) else {
                    let Some(above) = stack.pop() else { return };
                    vector = above;
                    level += 1;
                    continue;
                };
                count.enter();
                if level == 0 {
                    if !visit(&mut end, box_, count) {
                        return;
                    }
                    continue;
                }
                // There are no more levels than there is room for.
                let _ = stack.try_push(vector);
                level -= 1;
                index = box_;
                break;
            }
        }
    }
}

impl Vector {
    /// The nearest box that waits, if the ray does not end before it.
    #[inline(always)]
    fn next(&mut self, end: f32) -> Option<usize> {
        let mut bits = self.waiting;
        if bits == 0 {
            return None;
        }
        let mut lane = bits.trailing_zeros() as usize % WIDTH;
        bits &= bits - 1;
        while bits != 0 {
            let other = bits.trailing_zeros() as usize % WIDTH;
            bits &= bits - 1;
            if self.enter[other] < self.enter[lane] {
                lane = other;
            }
        }
        self.waiting &= !(1 << lane);
        // The others are no nearer.
        (self.enter[lane] <= end).then_some(self.first + lane)
    }
}

/// A parameter as an f32, or somewhat more.
#[inline(always)]
fn beyond(end: f64) -> f32 {
    end as f32 + end.abs() as f32 * (4.0 * f32::EPSILON)
}

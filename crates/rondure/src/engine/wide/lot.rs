//! Rays of a batch that go each their own way: what single rays do one after the other is done here stage by stage
//! for a lot of rays, so that the processor never waits for the one ray at hand.
//!
//! ```text
//! boxes, each ray -> blocks, each ray -> Newton's steps, 8 spots at a time
//! ```
//!
//! Rays whose nearest block has no spot go another round. The few that need more than the nearest spot of
//! a block are left to be answered one by one.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};

use super::Wide;
use super::arithmetic::Best;
use super::bits::bits;
use super::block::LANES;
use super::course::Course;
use super::eight::{Eight, WIDTH};
use super::leaf::{Finding, Spot};
use super::near::Near;
use super::search::Spots;
use super::walk::Way;
use crate::Vec3;
use crate::batch::Hits;

/// How many rays are under way: few enough for their data to stay in the first cache.
const LOT: usize = 32;

/// A column of numbers, with room for a whole vector behind the last.
type Column = [f64; LOT + WIDTH];

/// The rays under way, by columns.
pub(super) struct Lot {
    len: usize,
    /// Which rays they are.
    ray: [usize; LOT + WIDTH],
    origin: [Column; 3],
    direction: [Column; 3],
    abc: [Column; 3],
    length2: Column,
    range: [Column; 2],
    far: Column,
    ways: Vec<Way>,
    /// Those that are still looking for a block, as numbered in the lot.
    seeking: Vec<u32>,
    /// Whether something of them is not certain.
    unsure: [bool; LOT + WIDTH],
    entries: Vec<Entry>,
    tasks: Vec<Task>,
    /// Those that have to be answered one by one.
    pub(super) single: Vec<usize>,
}

/// Where a ray enters its nearest block, and the one after that.
#[derive(Clone, Copy)]
struct Entry {
    /// The ray, as numbered in the lot.
    ray: u32,
    block: u32,
    enter: f32,
    next: f32,
}

/// A place to look for a hit.
#[derive(Clone, Copy)]
struct Task {
    /// The ray, as numbered in the lot.
    ray: u32,
    leaf: u32,
    spot: Spot,
    /// No other spot of the ray comes before that.
    next: f64,
}

impl Wide {
    /// The closest hits of the rays in a lot, which then is empty.
    #[inline(always)]
    pub(super) fn closest_apart<S: Simd>(&self, simd: S, lot: &mut Lot, hits: &mut Hits) {
        lot.set_out(simd, self);
        while !lot.seeking.is_empty() {
            self.enter_blocks(simd, lot);
            self.find_spots(simd, lot);
        }
        self.find_hits(simd, lot, hits);
        lot.len = 0;
    }

    /// Whether the rays in a lot, which then is empty, have any hit.
    #[inline(always)]
    pub(super) fn any_apart<S: Simd>(&self, simd: S, lot: &mut Lot, hits: &mut [bool]) {
        lot.set_out(simd, self);
        while !lot.seeking.is_empty() {
            self.enter_blocks(simd, lot);
            self.find_any(simd, lot, hits);
        }
        lot.len = 0;
    }

    /// Finds the next block of each ray.
    #[inline(always)]
    fn enter_blocks<S: Simd>(&self, simd: S, lot: &mut Lot) {
        lot.entries.clear();
        for &ray in &lot.seeking {
            let way = &mut lot.ways[ray as usize];
            let end = lot.range[1][ray as usize];
            let Some((block, enter)) = way.next::<_, true>(simd, self, end) else {
                if lot.unsure[ray as usize] {
                    lot.single.push(lot.ray[ray as usize]);
                }
                continue;
            };
            let next = way.least(simd);
            lot.entries.push(Entry { ray, block: block as u32, enter, next });
        }
        lot.seeking.clear();
    }

    /// Finds rays that have a hit for certain in their block; others go on seeking.
    #[inline(always)]
    fn find_any<S: Simd>(&self, simd: S, lot: &mut Lot, hits: &mut [bool]) {
        for &Entry { ray, block, enter, next } in &lot.entries {
            let number = ray as usize;
            let course = lot.course(number);
            let end = course.range[1];
            let block = &self.blocks[block as usize];
            let meeting = block.test::<S, true>(simd, &course, enter, end);
            let index = lot.ray[number];
            if meeting.sure != 0 {
                if let Some(hit) = hits.get_mut(index) {
                    *hit = true;
                }
                continue;
            }
            lot.unsure[number] |= !meeting.misses();
            if f64::from(next) <= end {
                lot.seeking.push(ray);
            } else if lot.unsure[number] {
                lot.single.push(index);
            }
        }
    }

    /// Finds the nearest spot in the block of each ray; those that have none go on seeking.
    #[inline(always)]
    fn find_spots<S: Simd>(&self, simd: S, lot: &mut Lot) {
        for k in 0..lot.entries.len() {
            let Entry { ray, block, enter, next } = lot.entries[k];
            let course = lot.course(ray as usize);
            let end = course.range[1];
            let block = block as usize;
            let meeting = self.blocks[block].test::<S, false>(simd, &course, enter, end);
            if meeting.tangent != 0 {
                lot.single.push(lot.ray[ray as usize]);
                continue;
            }
            if !meeting.may_hit() {
                if f64::from(next) <= end {
                    lot.seeking.push(ray);
                }
                continue;
            }
            let mut spots = Spots::new(simd, &self.blocks[block], &meeting, enter);
            let (lane, spot) = spots.first(simd);
            let next = spots.least(simd).min(f64::from(next));
            lot.tasks.push(Task { ray, leaf: (block * LANES + lane) as u32, spot, next });
        }
    }

    /// Finds the hits at all spots.
    #[inline(always)]
    fn find_hits<S: Simd>(&self, simd: S, lot: &mut Lot, hits: &mut Hits) {
        for tasks in lot.tasks.chunks(WIDTH) {
            let mut eight = Eight::EMPTY;
            let mut all = tasks.len() == WIDTH;
            for (i, task) in tasks.iter().enumerate() {
                let leaf = &self.leaves[task.leaf as usize];
                all &= !leaf.is_conic();
                let ray = task.ray as usize;
                eight.curves[i] = self.curves[leaf.piece() as usize].powers();
                eight.rays[i] = [
                    lot.origin[0][ray],
                    lot.origin[1][ray],
                    lot.origin[2][ray],
                    lot.direction[0][ray],
                    lot.direction[1][ray],
                    lot.direction[2][ray],
                    lot.length2[ray],
                    lot.far[ray],
                ];
                let [low, high] = leaf.valid();
                eight.spots[i] = [
                    task.spot.s,
                    task.spot.tau,
                    task.spot.blur,
                    lot.range[0][ray],
                    lot.range[1][ray].min(task.next),
                    low,
                    high,
                    leaf.last2(),
                ];
            }
            // Conics, and the last few, one by one.
            let found = if all { eight.hits(simd) } else { 0 };
            for (i, task) in tasks.iter().enumerate() {
                let ray = task.ray as usize;
                let leaf = &self.leaves[task.leaf as usize];
                let index = lot.ray[ray];
                if found & 1 << i != 0 {
                    hits.t[index] = eight.found[1][i];
                    hits.piece[index] = leaf.piece();
                    hits.s[index] = eight.found[0][i];
                    continue;
                }
                if !all {
                    let course = lot.course(ray);
                    let finding = leaf.hit(Best(simd), &self.curves, &course, task.spot);
                    if let Finding::Hit { tau, s, .. } = finding
                        && tau < task.next
                    {
                        hits.t[index] = tau;
                        hits.piece[index] = leaf.piece();
                        hits.s[index] = s;
                        continue;
                    }
                }
                lot.single.push(lot.ray[ray]);
            }
        }
    }
}

impl Lot {
    pub(super) fn new() -> Self {
        let column = [0.0; LOT + WIDTH];
        Self {
            len: 0,
            ray: [0; LOT + WIDTH],
            origin: [column; 3],
            direction: [column; 3],
            abc: [column; 3],
            length2: column,
            range: [column; 2],
            far: column,
            ways: (0..LOT).map(|_| Way::NONE).collect(),
            seeking: Vec::with_capacity(LOT),
            unsure: [false; LOT + WIDTH],
            entries: Vec::with_capacity(LOT),
            tasks: Vec::with_capacity(LOT),
            single: Vec::with_capacity(LOT),
        }
    }

    /// Whether there is no room for sixteen more.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.len + 2 * WIDTH > LOT
    }

    /// Lets those that were taken in seek.
    #[inline(always)]
    fn set_out<S: Simd>(&mut self, simd: S, wide: &Wide) {
        self.seeking.clear();
        self.tasks.clear();
        for i in 0..self.len.min(LOT) {
            let course = self.course(i);
            let way = &mut self.ways[i];
            way.restart(simd, wide, &course);
            self.unsure[i] = false;
            if !way.is_over(simd, course.range[1]) {
                self.seeking.push(i as u32);
            }
        }
    }

    #[inline(always)]
    fn course(&self, i: usize) -> Course {
        let at = |c: &[Column; 3]| Vec3::new(c[0][i], c[1][i], c[2][i]);
        Course {
            origin: at(&self.origin),
            direction: at(&self.direction),
            a: self.abc[0][i],
            b: self.abc[1][i],
            c: self.abc[2][i],
            length2: self.length2[i],
            far: self.far[i],
            turn: 0.0,
            range: [self.range[0][i], self.range[1][i]],
            shift: 0.0,
        }
    }

    /// Leaves rays that are not for batches, of sixteen from the one numbered `start` on, to be answered one by one.
    #[inline(always)]
    pub(super) fn refuse<S: Simd>(&mut self, near: &[Near<S>; 2], start: usize) {
        let strange = near[0].strange | near[1].strange << WIDTH;
        if strange != 0 {
            self.single.extend(bits(strange).map(|lane| start + lane));
        }
    }

    /// Takes in those of eight rays, from the one numbered `start` on, that do not pass the surface.
    #[inline(always)]
    pub(super) fn take<S: Simd>(&mut self, simd: S, near: &Near<S>, start: usize) {
        if near.meets == 0 {
            return;
        }
        let at = self.len;
        let mask = mask64x8::from_bitmask(simd, u64::from(near.meets));
        for i in 0..3 {
            put(near.origin[i], mask, &mut self.origin[i], at);
            put(near.direction[i], mask, &mut self.direction[i], at);
            put(near.abc[i], mask, &mut self.abc[i], at);
        }
        put(near.length2, mask, &mut self.length2, at);
        put(near.far, mask, &mut self.far, at);
        put(near.range[0], mask, &mut self.range[0], at);
        put(near.range[1], mask, &mut self.range[1], at);
        for lane in bits(near.meets) {
            self.ray[self.len] = start + lane;
            self.len += 1;
        }
    }
}

/// Puts what is in a mask into a column, one after the other.
#[inline(always)]
fn put<S: Simd>(from: f64x8<S>, mask: mask64x8<S>, column: &mut Column, at: usize) {
    from.compress(mask).store_slice(&mut column[at..at + WIDTH]);
}

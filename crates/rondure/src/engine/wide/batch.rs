//! Many rays at once: what single rays do one after the other is done here stage by stage for a lot of
//! rays, so that the processor never waits for the one ray at hand.
//!
//! ```text
//! approach, 8 rays at a time -> boxes, each ray -> blocks, each ray -> Newton's steps, 8 spots at a time
//! ```
//!
//! Rays whose nearest block has no spot go another round. The few that need more than the nearest spot of
//! a block are answered one by one.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x8, mask64x8};

use super::Wide;
use super::arithmetic::Best;
use super::block::LANES;
use super::course::{Course, LONGEST, NEAR, SHORTEST, VANISHING};
use super::eight::{Eight, WIDTH};
use super::leaf::{Finding, Spot};
use super::search::{Question, Spots};
use super::walk::Way;
use crate::Vec3;
use crate::batch::{Hits, Rays};
use crate::frame::Frame;
use crate::piece::Piece;

/// How many rays are under way: few enough for their data to stay in the first cache.
const LOT: usize = 32;

/// A column of numbers, with room for a whole vector behind the last.
type Column = [f64; LOT + WIDTH];

/// The rays under way, by columns.
struct Lot {
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
    single: Vec<usize>,
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
    pub(crate) fn closest_of_many(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Hits,
    ) {
        hits.clear(rays.len());
        dispatch!(self.level, simd => self.closest_many(simd, pieces, frame, rays, hits));
    }

    pub(crate) fn any_of_many(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut [bool],
    ) {
        dispatch!(self.level, simd => self.any_many(simd, pieces, frame, rays, hits));
    }

    #[inline(always)]
    fn closest_many<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Hits,
    ) {
        let mut lot = Lot::new();
        let mut next = 0;
        while next < rays.len() {
            lot.fill(simd, self, frame, rays, &mut next);
            while !lot.seeking.is_empty() {
                self.enter_blocks(simd, &mut lot);
                self.find_spots(simd, &mut lot);
            }
            self.find_hits(simd, &mut lot, hits);
            for &index in &lot.single {
                let question = Question { pieces, frame, ray: &rays.get(index) };
                hits.set(index, self.closest_with::<_, true>(simd, &question));
            }
        }
    }

    #[inline(always)]
    fn any_many<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut [bool],
    ) {
        let count = rays.len().min(hits.len());
        hits[..count].fill(false);
        let mut lot = Lot::new();
        let mut next = 0;
        while next < count {
            lot.fill(simd, self, frame, rays, &mut next);
            while !lot.seeking.is_empty() {
                self.enter_blocks(simd, &mut lot);
                self.find_any(simd, &mut lot, hits);
            }
            for &index in lot.single.iter().filter(|&&index| index < count) {
                let question = Question { pieces, frame, ray: &rays.get(index) };
                hits[index] = self.any_with::<_, true>(simd, &question);
            }
        }
    }

    /// Finds the next block of each ray.
    #[inline(always)]
    fn enter_blocks<S: Simd>(&self, simd: S, lot: &mut Lot) {
        lot.entries.clear();
        for &ray in &lot.seeking {
            let way = &mut lot.ways[ray as usize];
            let end = lot.range[1][ray as usize];
            let Some((block, enter)) = way.next(simd, self, end) else {
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
            if meeting.may == 0 {
                if f64::from(next) <= end {
                    lot.seeking.push(ray);
                }
                continue;
            }
            let mut spots = Spots::new(meeting);
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
                    leaf.guess(Best(simd), task.spot.lambda),
                    task.spot.tau,
                    task.spot.blur,
                    lot.range[0][ray],
                    lot.range[1][ray].min(task.next),
                    low,
                    high,
                    0.0,
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
    fn new() -> Self {
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

    /// Takes in rays from the one numbered `next` on, as many as there is room for, and lets them seek.
    #[inline(always)]
    fn fill<S: Simd>(
        &mut self,
        simd: S,
        wide: &Wide,
        frame: &Frame,
        rays: &Rays<'_>,
        next: &mut usize,
    ) {
        self.len = 0;
        self.seeking.clear();
        self.tasks.clear();
        self.single.clear();
        while *next < rays.len() && self.len + WIDTH <= LOT {
            self.approach(simd, wide, frame, rays, *next);
            *next += WIDTH;
        }
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

    /// Takes in those of eight rays that do not pass the surface.
    #[inline(always)]
    fn approach<S: Simd>(
        &mut self,
        simd: S,
        wide: &Wide,
        frame: &Frame,
        rays: &Rays<'_>,
        start: usize,
    ) {
        if start + WIDTH > rays.len() || frame.inverse().is_some() {
            // The last few, and those that have to be turned.
            self.single.extend(start..(start + WIDTH).min(rays.len()));
            return;
        }
        let outline = &wide.outline;
        let unit = f64x8::splat(simd, outline.unit);
        let [ox, oy, oz] = rays.origin;
        let [dx, dy, dz] = rays.direction;
        let ox = load(simd, ox, start) * unit;
        let oy = load(simd, oy, start) * unit;
        let oz = (load(simd, oz, start) - f64x8::splat(simd, frame.center_z())) * unit;
        let dx = load(simd, dx, start) * unit;
        let dy = load(simd, dy, start) * unit;
        let dz = load(simd, dz, start) * unit;
        let t_min = load(simd, rays.range[0], start);
        let t_max = load(simd, rays.range[1], start);
        let a = dx * dx + dy * dy;
        let k = ox * dy - oy * dx;
        let far = ox.abs().max(oy.abs()).max(oz.abs());
        let length2 = dz.mul_add(dz, a);
        let ordinary = far.simd_le(f64x8::splat(simd, NEAR))
            & length2.simd_ge(f64x8::splat(simd, SHORTEST))
            & length2.simd_le(f64x8::splat(simd, LONGEST));
        let b = ox * dx + oy * dy;
        let c = ox * ox + oy * oy;
        let along = oz.mul_add(dz, b);
        let outside = oz.mul_add(oz, c) - f64x8::splat(simd, outline.radius2);
        let reach2 = a * f64x8::splat(simd, outline.reach2) + f64x8::splat(simd, VANISHING);
        let meets = t_min.simd_le(t_max)
            & (k * k).simd_le(reach2)
            & (along * along).simd_ge(outside * length2);
        let ordinary = ordinary.to_bitmask() as u32;
        let mut strange = !ordinary & 0xff;
        while strange != 0 {
            self.single.push(start + strange.trailing_zeros() as usize);
            strange &= strange - 1;
        }
        let meets = meets.to_bitmask() as u32 & ordinary;
        if meets == 0 {
            return;
        }
        let at = self.len;
        let mask = mask64x8::from_bitmask(simd, u64::from(meets));
        ox.compress(mask).store_slice(&mut self.origin[0][at..at + WIDTH]);
        oy.compress(mask).store_slice(&mut self.origin[1][at..at + WIDTH]);
        oz.compress(mask).store_slice(&mut self.origin[2][at..at + WIDTH]);
        dx.compress(mask).store_slice(&mut self.direction[0][at..at + WIDTH]);
        dy.compress(mask).store_slice(&mut self.direction[1][at..at + WIDTH]);
        dz.compress(mask).store_slice(&mut self.direction[2][at..at + WIDTH]);
        a.compress(mask).store_slice(&mut self.abc[0][at..at + WIDTH]);
        b.compress(mask).store_slice(&mut self.abc[1][at..at + WIDTH]);
        c.compress(mask).store_slice(&mut self.abc[2][at..at + WIDTH]);
        length2.compress(mask).store_slice(&mut self.length2[at..at + WIDTH]);
        t_min.compress(mask).store_slice(&mut self.range[0][at..at + WIDTH]);
        t_max.compress(mask).store_slice(&mut self.range[1][at..at + WIDTH]);
        far.compress(mask).store_slice(&mut self.far[at..at + WIDTH]);
        let mut bits = meets;
        while bits != 0 {
            self.ray[self.len] = start + bits.trailing_zeros() as usize;
            self.len += 1;
            bits &= bits - 1;
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, column: &[f64], start: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &column[start..start + WIDTH])
}

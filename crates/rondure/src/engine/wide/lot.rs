//! Rays of a batch that go each their own way: what single rays do one after the other is done here stage by stage
//! for a lot of rays, so that the processor never waits for the one ray at hand.
//!
//! ```text
//! boxes, 16 rays at a time -> blocks, each ray -> Newton's steps, 8 spots at a time
//! ```
//!
//! Rays whose nearest block has no spot go another round. The few that need more than the nearest spot of
//! a block are left to be answered one by one. No stage has a branch for what one ray finds and the next one does
//! not, but for rare cases: half of such branches would be foreseen wrongly, and what comes after them thrown away.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask64x8, u32x16};

use super::Wide;
use super::arithmetic::lesser;
use super::bits::bits;
use super::block::LANES;
use super::boxes::{Rods, Slabs, enter};
use super::course::Course;
use super::eight::{Aim, columns};
use super::leaf::Spot;
use super::near::{Near, WIDTH};
use super::packet::{ROUNDED, SIXTEEN};
use super::search::Spots;
use crate::Vec3;
use crate::batch::Hits;

/// How many rays are under way: few enough for their data to stay in the first cache.
pub(super) const LOT: usize = 64;

/// The most blocks of a surface whose rays go together; all are looked at for each ray.
const MOST_BLOCKS: usize = 64;

/// A column of numbers, with room for a whole vector behind the last.
type Column = [f64; LOT + WIDTH];

/// A number for each ray.
type Row<T> = [T; LOT];

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
    shift: Column,
    /// For each block where the rays enter its box; infinity if they don't, or have been there.
    enters: Vec<Row<f32>>,
    /// For each ray the nearest block, where the ray enters that, and where the one after it.
    block: Row<u32>,
    enter: Row<f32>,
    next: Row<f32>,
    /// Those that are still looking for a spot.
    seeking: Seeking,
    /// Whether something of them is not certain.
    unsure: Row<bool>,
    /// The places to look for hits, one for each ray that has any.
    spots: Places,
}

/// Some of the rays, as numbered in the lot.
struct Seeking {
    len: usize,
    rays: Row<u32>,
}

impl Seeking {
    /// Puts a ray behind the others if a condition holds, without a branch.
    #[inline(always)]
    fn push_if(&mut self, ray: u32, condition: bool) {
        self.rays[self.len % LOT] = ray;
        self.len += usize::from(condition);
    }
}

/// For each ray where to look for a hit.
struct Places {
    /// Which rays have such a place, as a set of bits.
    there: u64,
    leaf: [u32; LOT + 1],
    s: Column,
    tau: Column,
    blur: Column,
    /// Another spot of the ray comes after that.
    end: Column,
}

impl Places {
    const NONE: Self = Self {
        there: 0,
        leaf: [0; LOT + 1],
        s: [0.0; LOT + WIDTH],
        tau: [f64::INFINITY; LOT + WIDTH],
        blur: [0.0; LOT + WIDTH],
        end: [f64::INFINITY; LOT + WIDTH],
    };

    /// No hit at the spot of a ray lies beyond that.
    #[inline(always)]
    fn latest(&self, ray: usize) -> f64 {
        self.tau[ray] + 2.0 * self.blur[ray]
    }

    /// Keeps a spot, if it is `there`, for a ray that has none or a later one; `other` is where the ray comes upon another in the
    /// same block, at the earliest. Says where the hit is at the latest.
    #[inline(always)]
    fn consider(&mut self, ray: usize, leaf: usize, spot: Spot, there: bool, other: f64) -> f64 {
        let nearer = there & (spot.tau < self.tau[ray]);
        let [before, now] = [self.tau[ray] - self.blur[ray], spot.tau - spot.blur];
        let later = if nearer { before } else { now };
        self.end_before(ray, if there { lesser(later, other) } else { f64::INFINITY });
        self.there |= u64::from(there) << ray;
        // Behind the last ray nobody looks.
        let place = if nearer { ray } else { LOT };
        self.leaf[place] = leaf as u32;
        self.s[place] = spot.s;
        self.tau[place] = spot.tau;
        self.blur[place] = spot.blur;
        self.latest(ray)
    }

    #[inline(always)]
    fn end_before(&mut self, ray: usize, end: f64) {
        self.end[ray] = lesser(end, self.end[ray]);
    }
}

impl Wide {
    /// Whether rays that go each their own way are answered as lots.
    #[inline(always)]
    pub(super) fn takes_lots(&self) -> bool {
        self.blocks.len() <= MOST_BLOCKS
    }

    /// The closest hits of the rays in a lot, which then is empty; the numbers of those that are not certain go to `single`.
    #[inline(always)]
    pub(super) fn closest_apart<S: Simd>(
        &self,
        simd: S,
        lot: &mut Lot,
        hits: &mut Hits,
        single: &mut Vec<usize>,
    ) {
        lot.set_out(simd, self);
        while lot.seeking.len != 0 {
            self.find_spots(simd, lot, single);
            lot.look_again(simd);
        }
        self.find_hits(simd, lot, hits, single);
        lot.len = 0;
    }

    /// Whether the rays in a lot, which then is empty, have any hit.
    #[inline(always)]
    pub(super) fn any_apart<S: Simd>(
        &self,
        simd: S,
        lot: &mut Lot,
        hits: &mut [bool],
        single: &mut Vec<usize>,
    ) {
        lot.set_out(simd, self);
        while lot.seeking.len != 0 {
            self.find_any(simd, lot, hits);
            lot.look_again(simd);
        }
        for i in 0..lot.len.min(LOT) {
            if lot.unsure[i] && !hits[lot.ray[i]] {
                single.push(lot.ray[i]);
            }
        }
        lot.len = 0;
    }

    /// Finds rays that have a hit for certain in their block; others go on seeking.
    #[inline(always)]
    fn find_any<S: Simd>(&self, simd: S, lot: &mut Lot, hits: &mut [bool]) {
        let seeking = core::mem::take(&mut lot.seeking.len);
        for k in 0..seeking.min(LOT) {
            let ray = lot.seeking.rays[k];
            let number = ray as usize % LOT;
            let course = lot.course(number);
            let end = course.range[1];
            let block = lot.leave(number);
            let meeting = self.blocks[block].test::<S, true>(simd, &course, lot.enter[number], end);
            let sure = meeting.sure != 0;
            hits[lot.ray[number]] |= sure;
            lot.unsure[number] |= !meeting.misses();
            lot.seeking.push_if(ray, !sure & lot.goes_on(number));
        }
    }

    /// Finds the nearest spot in the block of each ray; those that have none go on seeking, and those whose next block
    /// begins before it.
    #[inline(always)]
    fn find_spots<S: Simd>(&self, simd: S, lot: &mut Lot, single: &mut Vec<usize>) {
        let seeking = core::mem::take(&mut lot.seeking.len);
        for k in 0..seeking.min(LOT) {
            let ray = lot.seeking.rays[k];
            let number = ray as usize % LOT;
            let course = lot.course(number);
            let block = lot.leave(number);
            let (enter, next) = (lot.enter[number], f64::from(lot.next[number]));
            let end = lesser(course.range[1], lot.spots.latest(number));
            let block_of = &self.blocks[block];
            let meeting = block_of.test::<S, false>(simd, &course, enter, end);
            // Few are.
            if meeting.tangent != 0 {
                lot.spots.there &= !(1 << number);
                single.push(lot.ray[number]);
                continue;
            }
            let enter = f64::from(enter);
            let (number_of, spot, other) =
                Spots::nearest(simd, block_of, &meeting, meeting.masks, enter);
            let (leaf, there) = (block * LANES + number_of % LANES, meeting.may_hit());
            let latest = lot.spots.consider(number, leaf, spot, there, other);
            let goes_on = (next < f64::INFINITY) & (next <= latest);
            lot.spots.end_before(number, if goes_on { f64::INFINITY } else { next });
            lot.seeking.push_if(ray, goes_on);
        }
    }

    /// Finds the hits at all spots.
    #[inline(always)]
    fn find_hits<S: Simd>(&self, simd: S, lot: &mut Lot, hits: &mut Hits, single: &mut Vec<usize>) {
        for start in (0..lot.len.min(LOT)).step_by(WIDTH) {
            let there = (lot.spots.there >> start) as u32 & 0xff;
            if there == 0 {
                continue;
            }
            let mut targets =
                Targets::new(self, lot.spots.leaf[start..start + WIDTH].iter().copied());
            let f64s = |column: &Column| f64x8::from_slice(simd, &column[start..start + WIDTH]);
            let ([ox, oy, oz], [dx, dy, dz]) = (&lot.origin, &lot.direction);
            let aim = Aim {
                curve: columns(simd, targets.curves),
                origin: [f64s(ox), f64s(oy), f64s(oz)],
                direction: [f64s(dx), f64s(dy), f64s(dz)],
                length2: f64s(&lot.length2),
                far: f64s(&lot.far),
                shift: f64s(&lot.shift),
                s: f64s(&lot.spots.s),
                tau: f64s(&lot.spots.tau),
                blur: f64s(&lot.spots.blur),
                range: [f64s(&lot.range[0]), f64s(&lot.range[1]).min(f64s(&lot.spots.end))],
                valid: targets.valid(simd),
                last2: targets.last2(simd),
            };
            targets.conic &= there;
            let mut found = 0;
            for (conic, lanes) in [(false, there & !targets.conic), (true, targets.conic)] {
                if lanes == 0 {
                    continue;
                }
                let landing = aim.hit(simd, conic, lanes);
                for lane in bits(landing.certain) {
                    let index = lot.ray[start + lane];
                    hits.t[index] = landing.t[lane % WIDTH];
                    hits.piece[index] = targets.pieces[lane % WIDTH];
                    hits.s[index] = landing.s[lane % WIDTH];
                }
                found |= landing.certain;
            }
            for lane in bits(there & !found) {
                single.push(lot.ray[start + lane]);
            }
        }
        lot.spots = Places::NONE;
    }
}

/// What [`Aim`] has to know of eight leaves.
pub(super) struct Targets<'a> {
    pub(super) pieces: [u32; WIDTH],
    pub(super) curves: [&'a [f64; WIDTH]; WIDTH],
    valid: [[f64; WIDTH]; 2],
    last2: [f64; WIDTH],
    /// Which are conics.
    pub(super) conic: u32,
}

impl<'a> Targets<'a> {
    #[inline(always)]
    pub(super) fn new(wide: &'a Wide, leaves: impl Iterator<Item = u32>) -> Self {
        let mut targets = Self {
            pieces: [0; WIDTH],
            curves: [&[0.0; WIDTH]; WIDTH],
            valid: [[0.0; WIDTH]; 2],
            last2: [0.0; WIDTH],
            conic: 0,
        };
        for (i, leaf) in leaves.enumerate().take(WIDTH) {
            let leaf = &wide.leaves[leaf as usize];
            targets.pieces[i] = leaf.piece();
            targets.curves[i] = wide.curves[leaf.piece() as usize].powers();
            [targets.valid[0][i], targets.valid[1][i]] = leaf.valid();
            targets.last2[i] = leaf.last2();
            targets.conic |= u32::from(leaf.is_conic()) << i;
        }
        targets
    }

    /// As [`Aim::valid`].
    #[inline(always)]
    pub(super) fn valid<S: Simd>(&self, simd: S) -> [f64x8<S>; 2] {
        [f64x8::from_slice(simd, &self.valid[0]), f64x8::from_slice(simd, &self.valid[1])]
    }

    /// As [`Aim::last2`].
    #[inline(always)]
    pub(super) fn last2<S: Simd>(&self, simd: S) -> f64x8<S> {
        f64x8::from_slice(simd, &self.last2)
    }
}

impl Lot {
    /// An empty one, for a surface of so many blocks.
    pub(super) fn new(blocks: usize) -> Self {
        let column = [0.0; LOT + WIDTH];
        let rows = if blocks <= MOST_BLOCKS { blocks } else { 0 };
        Self {
            len: 0,
            ray: [0; LOT + WIDTH],
            origin: [column; 3],
            direction: [column; 3],
            abc: [column; 3],
            length2: column,
            range: [column; 2],
            far: column,
            shift: column,
            enters: vec![[f32::INFINITY; LOT]; rows],
            block: [0; LOT],
            enter: [0.0; LOT],
            next: [0.0; LOT],
            seeking: Seeking { len: 0, rays: [0; LOT] },
            unsure: [false; LOT],
            spots: Places::NONE,
        }
    }

    /// How many rays there are.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len.min(LOT)
    }

    /// Which ray of the batch one of them is.
    #[inline(always)]
    pub(super) fn number(&self, ray: usize) -> usize {
        self.ray[ray]
    }

    /// Where a ray enters a block's box; infinity if it does not.
    #[inline(always)]
    pub(super) fn enters(&self, block: usize, ray: usize) -> f32 {
        self.enters[block][ray]
    }

    /// Eight of the rays.
    #[inline(always)]
    pub(super) fn rays<S: Simd>(
        &self,
        simd: S,
        [a, b, c, d, e, f, g, h]: [usize; WIDTH],
    ) -> Chosen<S> {
        let pick = |of: &Column| {
            let of = |ray: usize| of[ray % LOT];
            f64x8::from_slice(simd, &[of(a), of(b), of(c), of(d), of(e), of(f), of(g), of(h)])
        };
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.origin, &self.direction);
        Chosen {
            origin: [pick(ox), pick(oy), pick(oz)],
            direction: [pick(dx), pick(dy), pick(dz)],
            length2: pick(&self.length2),
            far: pick(&self.far),
            shift: pick(&self.shift),
            range: [pick(&self.range[0]), pick(&self.range[1])],
        }
    }

    /// Leaves none.
    #[inline(always)]
    pub(super) fn empty(&mut self) {
        self.len = 0;
        self.seeking.len = 0;
    }

    /// Whether there is no room for sixteen more.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.len + SIXTEEN > LOT
    }

    /// Lets those that were taken in seek: finds where they enter all boxes round blocks, and the nearest one.
    #[inline(always)]
    pub(super) fn set_out<S: Simd>(&mut self, simd: S, wide: &Wide) {
        let len = self.len.min(LOT);
        for start in (0..len).step_by(SIXTEEN) {
            let f32s = |column: &Column| {
                let first = f64x8::from_slice(simd, &column[start..start + WIDTH]);
                let second = f64x8::from_slice(simd, &column[start + WIDTH..start + SIXTEEN]);
                first.narrow(second)
            };
            let slabs = Slabs::of_many(
                simd,
                &Rods {
                    a: f32s(&self.abc[0]),
                    b: f32s(&self.abc[1]),
                    c: f32s(&self.abc[2]),
                    oz: f32s(&self.origin[2]),
                    dz: f32s(&self.direction[2]),
                    length2: f32s(&self.length2),
                    start: f32s(&self.range[0]),
                },
            );
            let end = f32s(&self.range[1]);
            let end = end + end.abs() * f32x16::splat(simd, ROUNDED);
            let infinity = f32x16::splat(simd, f32::INFINITY);
            let mut nearest = Nearest::none(simd);
            for (number, row) in self.enters.iter_mut().enumerate() {
                let walls = wide.levels[0].walls(simd, number);
                let (enter, meets) = enter::<S, f32x16<S>>(simd, &walls, &slabs, end);
                let enter = meets.select(enter, infinity);
                enter.store_slice(&mut row[start..start + SIXTEEN]);
                nearest.consider(simd, enter, number as u32);
            }
            nearest.store(self, start);
        }
        self.unsure = [false; LOT];
        for i in 0..len {
            self.seeking.push_if(i as u32, self.enter[i] < f32::INFINITY);
        }
    }

    /// Finds the next block of those that go on seeking.
    #[inline(always)]
    fn look_again<S: Simd>(&mut self, simd: S) {
        let mut seeking = 0_u64;
        for &ray in &self.seeking.rays[..self.seeking.len.min(LOT)] {
            seeking |= 1 << (ray as usize % LOT);
        }
        for start in (0..LOT).step_by(SIXTEEN) {
            if seeking >> start & 0xffff == 0 {
                continue;
            }
            let mut nearest = Nearest::none(simd);
            for (number, row) in self.enters.iter().enumerate() {
                let enter = f32x16::from_slice(simd, &row[start..start + SIXTEEN]);
                nearest.consider(simd, enter, number as u32);
            }
            nearest.store(self, start);
        }
    }

    /// The block that a ray is at, which it then has seen.
    #[inline(always)]
    fn leave(&mut self, ray: usize) -> usize {
        let block = self.block[ray] as usize;
        self.enters[block][ray] = f32::INFINITY;
        block
    }

    /// Whether there is another block for a ray to look at.
    #[inline(always)]
    fn goes_on(&self, ray: usize) -> bool {
        self.next[ray] < f32::INFINITY
    }

    #[inline(always)]
    pub(super) fn course(&self, i: usize) -> Course {
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
            shift: self.shift[i],
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
        put(near.shift, mask, &mut self.shift, at);
        put(near.range[0], mask, &mut self.range[0], at);
        put(near.range[1], mask, &mut self.range[1], at);
        for lane in bits(near.meets) {
            self.ray[self.len] = start + lane;
            self.len += 1;
        }
    }
}

/// Eight rays of a lot, as [`Aim`] has them.
pub(super) struct Chosen<S: Simd> {
    pub(super) origin: [f64x8<S>; 3],
    pub(super) direction: [f64x8<S>; 3],
    pub(super) length2: f64x8<S>,
    pub(super) far: f64x8<S>,
    pub(super) shift: f64x8<S>,
    pub(super) range: [f64x8<S>; 2],
}

/// The two boxes that sixteen rays enter first.
struct Nearest<S: Simd> {
    enter: f32x16<S>,
    next: f32x16<S>,
    number: u32x16<S>,
}

impl<S: Simd> Nearest<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let infinity = f32x16::splat(simd, f32::INFINITY);
        Self { enter: infinity, next: infinity, number: u32x16::splat(simd, 0) }
    }

    #[inline(always)]
    fn consider(&mut self, simd: S, enter: f32x16<S>, number: u32) {
        let nearer = enter.simd_lt(self.enter);
        self.next = self.next.min(self.enter.max(enter));
        self.enter = self.enter.min(enter);
        self.number = nearer.select(u32x16::splat(simd, number), self.number);
    }

    /// Writes it down for sixteen rays.
    #[inline(always)]
    fn store(&self, lot: &mut Lot, start: usize) {
        self.enter.store_slice(&mut lot.enter[start..start + SIXTEEN]);
        self.next.store_slice(&mut lot.next[start..start + SIXTEEN]);
        self.number.store_slice(&mut lot.block[start..start + SIXTEEN]);
    }
}

/// Puts what is in a mask into a column, one after the other.
#[inline(always)]
fn put<S: Simd>(from: f64x8<S>, mask: mask64x8<S>, column: &mut Column, at: usize) {
    from.compress(mask).store_slice(&mut column[at..at + WIDTH]);
}

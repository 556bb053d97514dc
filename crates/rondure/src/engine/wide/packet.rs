//! Sixteen rays of a batch that go together: each ray in a lane of its own, and one leaf at a time.
//!
//! ```text
//! bundle -> boxes round blocks, round leaves (8 at once) -> each leaf, 16 rays -> Newton's steps, 8 rays
//! ```
//!
//! Rays that are alike meet the same few leaves. Which these are is asked once for all, of one of the rays and of boxes that
//! are larger by as much as the others may be away from it. What [`meet`](super::meet) does with one ray and eight
//! leaves it then does with sixteen rays and one leaf, and nothing has to be gathered or sorted: each lane keeps its nearest spot.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, u32x16};

use super::Wide;
use super::bits::bits;
use super::block::{Block, LANES};
use super::boxes::{self, BELOW, Bundle, Rods, Slabs, WIDTH as BOXES};
use super::eight::Aim;
use super::meet::{Beam, Meeting, meet};
use super::near::{Near, WIDTH};
use crate::batch::Hits;

/// How many rays go together.
pub(super) const SIXTEEN: usize = 2 * WIDTH;

/// How far apart rays that go together may be near the surface, whose radius is between 1 and 2.
const WIDEST: f32 = 1.0 / 6.0;
/// As many blocks may lie on their way.
const MOST_BLOCKS: usize = 32;
/// More than the rounding of a sum of two numbers, as a part of it.
pub(super) const ROUNDED: f32 = 2.0 * f32::EPSILON;
/// More than the diagonal of a square of side 1.
const DIAGONAL: f32 = 1.5;
/// A direction that is farther from another than this part of its length is not alike.
const TURNED: f32 = 0.25;
/// No point of the surface is farther from its centre.
const RADIUS: f32 = 2.0;
/// More than the roundings of a width.
const WIDER: f32 = 1.001;

/// Rays that are alike.
pub(super) struct Packet<'a, S: Simd> {
    near: &'a [Near<S>; 2],
    meets: u32,
    slabs: Slabs<f32x16<S>>,
    a: f32x16<S>,
    dz: f32x16<S>,
    length2: f32x16<S>,
    end: f32x16<S>,
    bundle: Bundle,
}

/// A block on the way, and where the bundle enters it.
type Stop = (f32, usize);

impl<'a, S: Simd> Packet<'a, S> {
    /// The sixteen rays, of which some must meet the surface, if those are alike.
    #[inline(always)]
    pub(super) fn new(simd: S, near: &'a [Near<S>; 2]) -> Option<Self> {
        let meets = near[0].meets | near[1].meets << WIDTH;
        let mask = mask32x16::from_bitmask(simd, u64::from(meets));
        let zero = f32x16::splat(simd, 0.0);
        let first = meets.trailing_zeros() as usize;
        let one = near[first / WIDTH % 2].course(first % WIDTH);
        let [n, m] = near;
        let (o, d) = (one.origin, one.direction);
        let o_x = apart(simd, n.origin[0], m.origin[0], o.x);
        let o_y = apart(simd, n.origin[1], m.origin[1], o.y);
        let o_z = apart(simd, n.origin[2], m.origin[2], o.z);
        let d_x = apart(simd, n.direction[0], m.direction[0], d.x);
        let d_y = apart(simd, n.direction[1], m.direction[1], d.y);
        let d_z = apart(simd, n.direction[2], m.direction[2], d.z);
        let o_across = mask.select(o_x.max(o_y), zero).reduce_max();
        let d_across = mask.select(d_x.max(d_y), zero).reduce_max();
        let o_along = mask.select(o_z, zero).reduce_max();
        let d_along = mask.select(d_z, zero).reduce_max();
        let length = (one.length2 as f32).sqrt();
        // Lengths of differences, or more.
        let [o_apart, d_apart] = [DIAGONAL * o_across + o_along, DIAGONAL * d_across + d_along];
        // False where one is not a number.
        let turned_little = d_apart <= TURNED * length;
        if !turned_little {
            return None;
        }
        // No ray is still near the surface after that.
        let latest = (o.length() as f32 + o_apart + RADIUS * WIDER) / (length - d_apart) * WIDER;
        let across = DIAGONAL * (o_across + latest * d_across) * WIDER;
        let along = (o_along + latest * d_along) * WIDER;
        if !(across <= WIDEST && along <= WIDEST) {
            return None;
        }
        let (a, dz, length2) = (
            n.abc[0].narrow(m.abc[0]),
            n.direction[2].narrow(m.direction[2]),
            n.length2.narrow(m.length2),
        );
        let (start, end) = (n.range[0].narrow(m.range[0]), n.range[1].narrow(m.range[1]));
        let rods = Rods {
            a,
            b: n.abc[1].narrow(m.abc[1]),
            c: n.abc[2].narrow(m.abc[2]),
            oz: n.origin[2].narrow(m.origin[2]),
            dz,
            length2,
            start,
        };
        let infinity = f32x16::splat(simd, f32::INFINITY);
        let least = mask.select(start, infinity).reduce_min();
        let most = mask.select(end, -infinity).reduce_max();
        let ray = Slabs::new(&one).starting(least - ROUNDED * least.abs());
        Some(Self {
            near,
            meets,
            slabs: Slabs::of_many(simd, &rods),
            a,
            dz,
            length2,
            end: end + end.abs() * f32x16::splat(simd, ROUNDED),
            bundle: Bundle { ray, across, along, end: most + ROUNDED * most.abs() },
        })
    }

    /// The rays as a block sees them, which they enter at `enter`.
    #[inline(always)]
    fn beam(&self, simd: S, block: &Block, enter: f32x16<S>) -> Beam<f32x16<S>> {
        let [corner_z, corner_w] = block.corner();
        let (first, second) = enter.widen();
        let n = Seen::new(simd, &self.near[0], first, corner_z, corner_w);
        let m = Seen::new(simd, &self.near[1], second, corner_z, corner_w);
        Beam {
            a: self.a,
            b: n.b.narrow(m.b),
            c: n.c.narrow(m.c),
            z: n.z.narrow(m.z),
            dz: self.dz,
            dz2: self.dz * self.dz,
            length: self.length2.sqrt(),
            length2: self.length2,
            range: [n.start.narrow(m.start), n.end.narrow(m.end)],
        }
    }
}

/// Eight of the rays as a block sees them.
struct Seen<S: Simd> {
    b: f64x8<S>,
    c: f64x8<S>,
    z: f64x8<S>,
    start: f64x8<S>,
    end: f64x8<S>,
}

impl<S: Simd> Seen<S> {
    #[inline(always)]
    fn new(simd: S, near: &Near<S>, origin: f64x8<S>, corner_z: f64, corner_w: f64) -> Self {
        let [a, b, c] = near.abc;
        let own_b = a.mul_add(origin, b);
        let height = near.origin[2] - f64x8::splat(simd, corner_z);
        Self {
            b: own_b,
            c: (own_b + b).mul_add(origin, c - f64x8::splat(simd, corner_w)),
            z: near.direction[2].mul_add(origin, height),
            start: near.range[0] - origin,
            end: near.range[1] - origin,
        }
    }
}

/// How far the lanes are from a number.
#[inline(always)]
fn apart<S: Simd>(simd: S, first: f64x8<S>, second: f64x8<S>, from: f64) -> f32x16<S> {
    let from = f64x8::splat(simd, from);
    (first - from).abs().narrow((second - from).abs())
}

/// The nearest spot of each ray.
struct Nearest<S: Simd> {
    /// Where it lies at the earliest, and at the latest.
    low: f32x16<S>,
    high: f32x16<S>,
    /// No other spot comes before that, and no place where the ray may touch.
    next: f32x16<S>,
    origin: f32x16<S>,
    tau: f32x16<S>,
    lambda: f32x16<S>,
    blur: f32x16<S>,
    leaf: u32x16<S>,
}

impl<S: Simd> Nearest<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let (zero, infinity) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, f32::INFINITY));
        Self {
            low: infinity,
            high: infinity,
            next: infinity,
            origin: zero,
            tau: zero,
            lambda: zero,
            blur: zero,
            leaf: u32x16::splat(simd, 0),
        }
    }

    /// Takes account of the spots at one of the two roots, in some lanes.
    #[inline(always)]
    fn consider(
        &mut self,
        simd: S,
        meeting: &Meeting<f32x16<S>, mask32x16<S>>,
        root: usize,
        lanes: u32,
        origin: f32x16<S>,
        leaf: u32,
    ) {
        let rounded = f32x16::splat(simd, ROUNDED);
        let infinity = f32x16::splat(simd, f32::INFINITY);
        let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
        let low = origin + meeting.low[root];
        let low = lanes.select(low - low.abs() * rounded, infinity);
        let high = origin + (meeting.tau[root] + meeting.blur);
        let high = high + high.abs() * rounded;
        let nearer = low.simd_lt(self.low);
        self.next = self.next.min(nearer.select(self.low, low));
        self.low = nearer.select(low, self.low);
        self.high = nearer.select(high, self.high);
        self.origin = nearer.select(origin, self.origin);
        self.tau = nearer.select(meeting.tau[root], self.tau);
        self.lambda = nearer.select(meeting.lambda[root], self.lambda);
        self.blur = nearer.select(meeting.blur, self.blur);
        self.leaf = nearer.select(u32x16::splat(simd, leaf), self.leaf);
    }

    /// Takes account of places where rays may touch, in some lanes.
    #[inline(always)]
    fn doubt(
        &mut self,
        simd: S,
        meeting: &Meeting<f32x16<S>, mask32x16<S>>,
        lanes: u32,
        origin: f32x16<S>,
    ) {
        let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
        let touch = origin + meeting.touch;
        let touch = touch - touch.abs() * f32x16::splat(simd, ROUNDED);
        // What is not a number could be anywhere.
        let anywhere = f32x16::splat(simd, f32::NEG_INFINITY);
        let touch = touch.simd_eq(touch).select(touch, anywhere);
        self.next = lanes.select(self.next.min(touch), self.next);
    }
}

#[inline(always)]
fn halves<S: Simd>(v: f32x16<S>) -> [f64x8<S>; 2] {
    let (first, second) = v.widen();
    [first, second]
}

impl Wide {
    /// The blocks on the way of a bundle, near ones first; `None` if there are too many.
    #[inline(always)]
    fn stops<S: Simd>(&self, simd: S, bundle: &Bundle) -> Option<ArrayVec<Stop, MOST_BLOCKS>> {
        let mut stops = ArrayVec::new();
        let mut ahead = ArrayVec::<(usize, usize), MOST_BLOCKS>::new();
        ahead.push((self.levels.len() - 1, 0));
        while let Some((level, index)) = ahead.pop() {
            let mut enter = [0.0; BOXES];
            let met = self.levels[level].test_bundle(simd, index, bundle, &mut enter);
            for number in bits(met) {
                let place = index * BELOW + number;
                if level == 0 {
                    stops.try_push((enter[number % BOXES], place)).ok()?;
                } else {
                    ahead.try_push((level - 1, place)).ok()?;
                }
            }
        }
        stops.sort_unstable_by(|a: &Stop, b: &Stop| a.0.total_cmp(&b.0));
        Some(stops)
    }

    /// The closest hits of a packet whose first ray is numbered `start`; the numbers of those that are not certain go to
    /// `single`.
    #[inline(always)]
    pub(super) fn closest_together<S: Simd>(
        &self,
        simd: S,
        packet: &Packet<'_, S>,
        start: usize,
        hits: &mut Hits,
        single: &mut Vec<usize>,
    ) {
        let Some(stops) = self.stops(simd, &packet.bundle) else {
            single.extend(bits(packet.meets).map(|lane| start + lane));
            return;
        };
        let mut nearest = Nearest::none(simd);
        for (first, block) in stops {
            // Rays whose nearest spot lies before all that is left are done.
            let over = nearest.high.simd_lt(f32x16::splat(simd, first)).to_bitmask() as u32;
            if packet.meets & !over == 0 {
                break;
            }
            let walls = self.levels[0].walls::<S, f32x16<S>>(simd, block);
            let end = packet.end.min(nearest.high);
            let (enter, mask) = boxes::enter(simd, &walls, &packet.slabs, end);
            let met = mask.to_bitmask() as u32;
            let met = met & packet.meets;
            if met == 0 {
                continue;
            }
            let block_of = &self.blocks[block];
            let beam = packet.beam(simd, block_of, enter);
            let mut enters = [0.0; LANES];
            let bundle = &packet.bundle;
            for lane in bits(self.leaf_boxes[block].test(simd, block_of, bundle, &mut enters)) {
                let first = f32x16::splat(simd, enters[lane % LANES]);
                let met = met & !(nearest.high.simd_lt(first).to_bitmask() as u32);
                if met == 0 {
                    continue;
                }
                let shells = block_of.shell(simd, lane);
                let meeting = meet::<S, f32x16<S>, false>(simd, &shells, &beam);
                if meeting.tangent & met != 0 {
                    nearest.doubt(simd, &meeting, meeting.tangent & met, enter);
                }
                let leaf = (block * LANES + lane) as u32;
                for root in 0..2 {
                    let lanes = meeting.may[root] & met;
                    if lanes != 0 {
                        nearest.consider(simd, &meeting, root, lanes, enter, leaf);
                    }
                }
            }
        }
        let found = nearest.low.simd_lt(f32x16::splat(simd, f32::INFINITY)).to_bitmask() as u32;
        let hit = self.hits_of(simd, packet, &nearest, found, start, hits);
        let doubt = nearest.next.simd_lt(f32x16::splat(simd, f32::INFINITY)).to_bitmask() as u32;
        let unsure = (found | doubt) & !hit;
        if unsure != 0 {
            single.extend(bits(unsure).map(|lane| start + lane));
        }
    }

    /// Goes on from the nearest spots of some rays to their hits, leaf by leaf; says of which rays these are certain.
    #[inline(always)]
    fn hits_of<S: Simd>(
        &self,
        simd: S,
        packet: &Packet<'_, S>,
        nearest: &Nearest<S>,
        rays: u32,
        start: usize,
        hits: &mut Hits,
    ) -> u32 {
        let (origin, tau) = (halves(nearest.origin), halves(nearest.tau));
        let (lambda, blur) = (halves(nearest.lambda), halves(nearest.blur));
        let next = halves(nearest.next);
        let mut left = rays;
        let mut hit = 0;
        while left != 0 {
            let number = nearest.leaf[left.trailing_zeros() as usize % SIXTEEN];
            let same = nearest.leaf.simd_eq(u32x16::splat(simd, number)).to_bitmask() as u32 & left;
            left &= !same;
            let (block, lane) = (number as usize / LANES, number as usize % LANES);
            let (block, leaf) = (&self.blocks[block], &self.leaves[number as usize]);
            let mut curve = [f64x8::splat(simd, 0.0); WIDTH];
            for (column, c) in curve.iter_mut().zip(self.curves[leaf.piece() as usize].powers()) {
                *column = f64x8::splat(simd, *c);
            }
            let [low, high] = leaf.valid();
            let valid = [f64x8::splat(simd, low), f64x8::splat(simd, high)];
            for half in 0..2 {
                let lanes = same >> (half * WIDTH) & 0xff;
                if lanes == 0 {
                    continue;
                }
                let near = &packet.near[half];
                let aim = Aim {
                    curve,
                    origin: near.origin,
                    direction: near.direction,
                    length2: near.length2,
                    far: near.far,
                    shift: near.shift,
                    s: block.guesses(simd, lane, lambda[half]),
                    tau: origin[half] + tau[half],
                    blur: blur[half],
                    range: [near.range[0], near.range[1].min(next[half])],
                    valid,
                    last2: f64x8::splat(simd, leaf.last2()),
                };
                let landing = aim.hit(simd, leaf.is_conic(), lanes);
                for lane in bits(landing.certain) {
                    let index = start + half * WIDTH + lane;
                    hits.t[index] = landing.t[lane % WIDTH];
                    hits.piece[index] = leaf.piece();
                    hits.s[index] = landing.s[lane % WIDTH];
                }
                hit |= landing.certain << (half * WIDTH);
            }
        }
        hit
    }

    /// Whether the rays of a packet whose first ray is numbered `start` have any hit; the numbers of those of which that
    /// is not certain go to `single`.
    #[inline(always)]
    pub(super) fn any_together<S: Simd>(
        &self,
        simd: S,
        packet: &Packet<'_, S>,
        start: usize,
        hits: &mut [bool],
        single: &mut Vec<usize>,
    ) {
        let Some(stops) = self.stops(simd, &packet.bundle) else {
            single.extend(bits(packet.meets).map(|lane| start + lane));
            return;
        };
        let (mut waiting, mut unsure) = (packet.meets, 0);
        for (_, block) in stops {
            let walls = self.levels[0].walls::<S, f32x16<S>>(simd, block);
            let (enter, mask) = boxes::enter(simd, &walls, &packet.slabs, packet.end);
            let met = mask.to_bitmask() as u32;
            let met = met & waiting;
            if met == 0 {
                continue;
            }
            let block_of = &self.blocks[block];
            let beam = packet.beam(simd, block_of, enter);
            let bundle = &packet.bundle;
            let leaves = self.leaf_boxes[block].test(simd, block_of, bundle, &mut [0.0; LANES]);
            for lane in bits(leaves) {
                let shells = block_of.shell(simd, lane);
                let meeting = meet::<S, f32x16<S>, true>(simd, &shells, &beam);
                unsure |= (meeting.may[0] | meeting.may[1] | meeting.tangent) & met;
                waiting &= !(meeting.sure & met);
                if waiting & met == 0 {
                    break;
                }
            }
            if waiting == 0 {
                break;
            }
        }
        for lane in bits(packet.meets & !waiting) {
            hits[start + lane] = true;
        }
        let unsure = unsure & waiting;
        if unsure != 0 {
            single.extend(bits(unsure).map(|lane| start + lane));
        }
    }
}

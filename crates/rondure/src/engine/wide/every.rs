//! All hits of the rays of a lot.
//!
//! ```text
//! boxes, 16 rays at a time -> blocks, each ray -> Newton's steps, 8 spots at a time -> hits, ray by ray
//! ```
//!
//! Nothing ends a ray's way early, so that each stage runs once. Rays that may touch somewhere, or of which rounding could put two hits
//! in another order, are answered one by one.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::Wide;
use super::arithmetic::greater;
use super::bits::bits;
use super::block::LANES;
use super::eight::{Aim, WIDTH, columns};
use super::exactly::sort;
use super::leaf::Spot;
use super::lot::{LOT, Lot, Targets};
use super::search::Spots;
use crate::batch::Gathered;
use crate::surface::Hit;

/// What is known of the hits of the rays of a lot.
pub(super) struct Every {
    tasks: Vec<Task>,
    found: Vec<(u32, Hit)>,
    /// The same, ray by ray.
    sorted: Vec<Hit>,
    /// One for each ray.
    rays: [State; LOT],
}

/// A place to look for a hit.
#[derive(Clone, Copy)]
struct Task {
    /// The ray, as numbered in the lot.
    ray: u32,
    leaf: u32,
    spot: Spot,
}

/// How far a ray has come.
#[derive(Clone, Copy)]
struct State {
    /// Whether something of it is not certain.
    unsure: bool,
    /// Hits that are no farther apart than that could be one, or come in another order.
    close: f64,
    /// How many hits it has, and where the next one goes.
    count: usize,
    next: usize,
}

impl State {
    const NONE: Self = Self { unsure: false, close: 0.0, count: 0, next: 0 };
}

/// What is overwritten.
const NOWHERE: Hit = Hit { t: 0.0, piece: 0, s: 0.0 };

impl Every {
    pub(super) fn new() -> Self {
        Self { tasks: Vec::new(), found: Vec::new(), sorted: Vec::new(), rays: [State::NONE; LOT] }
    }
}

impl Wide {
    /// All hits of the rays in a lot, which then is empty.
    #[inline(always)]
    pub(super) fn all_apart<S: Simd>(
        &self,
        simd: S,
        lot: &mut Lot,
        every: &mut Every,
        hits: &mut Gathered,
        single: &mut Vec<usize>,
    ) {
        every.tasks.clear();
        every.found.clear();
        every.rays = [State::NONE; LOT];
        lot.set_out(simd, self);
        self.find_all_spots(simd, lot, every);
        self.find_all_hits(simd, lot, every);
        let mut start = 0;
        for state in &mut every.rays {
            state.next = start;
            start += state.count;
        }
        every.sorted.resize(every.found.len(), NOWHERE);
        for (ray, hit) in &every.found {
            let state = &mut every.rays[*ray as usize % LOT];
            every.sorted[state.next] = *hit;
            state.next += 1;
        }
        for (number, state) in every.rays.iter().enumerate().take(lot.len()) {
            let own = &mut every.sorted[state.next - state.count..state.next];
            sort(own);
            let close = own.windows(2).any(|pair| pair[1].t - pair[0].t <= state.close);
            if state.unsure | close {
                single.push(lot.number(number));
            } else {
                hits.add(lot.number(number), own);
            }
        }
        lot.empty();
    }

    /// Finds the spots in all blocks on the way of each ray.
    #[inline(always)]
    fn find_all_spots<S: Simd>(&self, simd: S, lot: &Lot, every: &mut Every) {
        for (number, block) in self.blocks.iter().enumerate() {
            let (mut meets, mut count) = ([0; LOT], 0);
            for ray in 0..lot.len() {
                meets[count % LOT] = ray;
                count += usize::from(lot.enters(number, ray) < f32::INFINITY);
            }
            for &ray in &meets[..count] {
                let enter = lot.enters(number, ray);
                let course = lot.course(ray);
                let meeting = block.test::<S, false>(simd, &course, enter, course.range[1]);
                every.rays[ray].unsure |= meeting.tangent != 0;
                let found = meeting.may[0] | meeting.may[1] << LANES;
                if found == 0 {
                    continue;
                }
                let spots = Spots::new(simd, block, &meeting, enter);
                for spot in bits(found) {
                    let leaf = (number * LANES + spot % LANES) as u32;
                    every.tasks.push(Task { ray: ray as u32, leaf, spot: spots.spot(spot) });
                }
            }
        }
    }

    /// Finds the hits at all spots.
    #[inline(always)]
    fn find_all_hits<S: Simd>(&self, simd: S, lot: &Lot, every: &mut Every) {
        for tasks in every.tasks.chunks(WIDTH) {
            // Where there are fewer the last one stands for the others.
            let mut eight = [tasks[tasks.len() - 1]; WIDTH];
            eight[..tasks.len()].copy_from_slice(tasks);
            let there = 0xff >> (WIDTH - tasks.len());
            let targets = Targets::new(self, eight.iter().map(|task| task.leaf));
            let rays = lot.rays(simd, eight.map(|task| task.ray as usize));
            let column = |of: fn(&Spot) -> f64| {
                let [a, b, c, d, e, f, g, h] = &eight;
                let at = |task: &Task| of(&task.spot);
                let values = [at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)];
                f64x8::from_slice(simd, &values)
            };
            let aim = Aim {
                curve: columns(simd, targets.curves),
                origin: rays.origin,
                direction: rays.direction,
                length2: rays.length2,
                far: rays.far,
                shift: rays.shift,
                s: column(|spot| spot.s),
                tau: column(|spot| spot.tau),
                blur: column(|spot| spot.blur),
                range: rays.range,
                valid: targets.valid(simd),
                last2: targets.last2(simd),
            };
            let mut found = 0;
            for (conic, lanes) in [(false, there & !targets.conic), (true, there & targets.conic)] {
                if lanes == 0 {
                    continue;
                }
                let landing = aim.hit(simd, conic, lanes);
                for lane in bits(landing.certain) {
                    let lane = lane % WIDTH;
                    let ray = eight[lane].ray;
                    let (t, s) = (landing.t[lane], landing.s[lane]);
                    every.found.push((ray, Hit { t, piece: targets.pieces[lane], s }));
                    let state = &mut every.rays[ray as usize % LOT];
                    state.count += 1;
                    state.close = greater(state.close, 2.0 * landing.margin[lane]);
                }
                found |= landing.certain;
            }
            for lane in bits(there & !found) {
                every.rays[eight[lane % WIDTH].ray as usize % LOT].unsure = true;
            }
        }
    }
}

//! Many rays at once: what single rays do one after the other is done here stage by stage, so that the
//! processor never waits for the one ray at hand.
//!
//! ```text
//! approach, 8 rays at a time (f64 x 8) -> blocks, each ray (f32 x 16) -> roots, 8 at a time (f64 x 8)
//! ```
//!
//! Nearer leaves go first: what a ray may hit beyond its first hit is left out of the next round.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x8};

use super::course::{Approach, Course};
use super::cull::Line;
use super::leaf::{Leaf, solve};
use super::{Range, Wide};
use crate::batch::{Hits, Rays};
use crate::frame::Frame;
use crate::piece::Piece;
use crate::surface::Hit;

/// How many rays are under way: few enough for their data to stay in the first cache.
const RAYS: usize = 64;
/// How many numbers an f64 vector has.
const WIDTH: usize = 8;

/// A root to be found.
#[derive(Clone, Copy)]
struct Task {
    ray: u32,
    leaf: u32,
    guess: f32,
    above: bool,
}

/// What is known of a ray under way.
#[derive(Clone, Copy)]
struct State {
    course: Course,
    line: Line,
    range: Range,
    closest: Option<Hit>,
    /// Something of it is for the exact engine to say.
    doubt: bool,
    /// Its tasks: the next, and the end.
    tasks: [u32; 2],
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
        dispatch!(self.level, simd => {
            for (i, hit) in hits.iter_mut().enumerate().take(rays.len()) {
                *hit = self.any_with(simd, pieces, frame, &rays.get(i));
            }
        });
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
        let mut tasks = Vec::with_capacity(4 * RAYS);
        let mut states = Vec::with_capacity(RAYS);
        let mut indices = Vec::with_capacity(RAYS);
        for first in (0..rays.len()).step_by(RAYS) {
            let end = (first + RAYS).min(rays.len());
            states.clear();
            indices.clear();
            tasks.clear();
            for group in (first..end).step_by(WIDTH) {
                let meets = self.approach_many(simd, frame, rays, group, end);
                for index in group..(group + WIDTH).min(end) {
                    if meets & 1 << (index - group) == 0 {
                        continue;
                    }
                    let ray = rays.get(index);
                    let (approach, course) = self.approach(frame, &ray);
                    match approach {
                        Approach::Misses => {}
                        Approach::Strange => {
                            hits.set(index, self.closest_exactly(pieces, frame, &ray));
                        }
                        Approach::Meets => {
                            let range = Range::new(self, &course, &ray);
                            let line = Line::along(&course, range.of_course, self.unit);
                            let (closest, doubt) = (None, false);
                            let state =
                                State { course, line, range, closest, doubt, tasks: [0; 2] };
                            states.push(state);
                            indices.push(index);
                        }
                    }
                }
            }
            for (ray, state) in states.iter_mut().enumerate() {
                self.collect(simd, ray as u32, state, &mut tasks);
            }
            self.solve_all(simd, &mut states, &tasks);
            for (state, &index) in states.iter().zip(&indices) {
                let hit = if state.doubt {
                    self.closest_with(simd, pieces, frame, &rays.get(index))
                } else {
                    state.closest
                };
                hits.set(index, hit);
            }
        }
    }

    /// Which of eight rays pass the axis near enough, as a set of bits; others surely miss.
    #[inline(always)]
    fn approach_many<S: Simd>(
        &self,
        simd: S,
        frame: &Frame,
        rays: &Rays<'_>,
        first: usize,
        end: usize,
    ) -> u32 {
        if first + WIDTH > end || frame.inverse().is_some() {
            return u32::MAX;
        }
        let load = |c: &[f64]| f64x8::from_slice(simd, &c[first..first + WIDTH]);
        let [ox, oy] = [load(rays.origin[0]), load(rays.origin[1])];
        let [dx, dy] = [load(rays.direction[0]), load(rays.direction[1])];
        let a = dx * dx + dy * dy;
        let k = ox * dy - oy * dx;
        // What rounding can do to k from any distance.
        let error = (ox * dy).abs() + (oy * dx).abs();
        let error = error * f64x8::splat(simd, 4.0 * f64::EPSILON);
        let least = (k.abs() - error).max(f64x8::splat(simd, 0.0));
        let misses = (least * least).simd_gt(a * f64x8::splat(simd, self.reach2));
        !(misses.to_bitmask() as u32)
    }

    /// Collects the roots that a ray may have, near ones first.
    #[inline(always)]
    fn collect<S: Simd>(&self, simd: S, ray: u32, state: &mut State, tasks: &mut Vec<Task>) {
        let first = tasks.len() as u32;
        let mut line = state.line;
        let doubt = &mut state.doubt;
        self.walk(
            simd,
            &mut line,
            false,
            &mut (),
            #[inline(always)]
            |line, leaf, known| {
                let Some(roots) = known else {
                    *doubt = true;
                    return false;
                };
                let index = leaf as u32;
                tasks.push(Task { ray, leaf: index, guess: roots.guess, above: roots.above });
                if let Some(guess) = roots.other {
                    tasks.push(Task { ray, leaf: index, guess, above: !roots.above });
                }
                if roots.inside {
                    // What comes after the leaf comes after its hit.
                    line.end_after(self.leaves[leaf].heights());
                }
                true
            },
        );
        state.tasks = [first, tasks.len() as u32];
    }

    /// Finds the roots, a ray's nearest leaves first.
    #[inline(always)]
    fn solve_all<S: Simd>(&self, simd: S, states: &mut [State], tasks: &[Task]) {
        let mut round = [Task { ray: 0, leaf: 0, guess: 0.0, above: false }; WIDTH];
        let mut waiting: Vec<u32> = (0..states.len() as u32).collect();
        while !waiting.is_empty() {
            let mut filled = 0;
            let mut still = 0;
            for i in 0..waiting.len() {
                let state = &mut states[waiting[i] as usize];
                let mut task = None;
                while task.is_none() && state.tasks[0] < state.tasks[1] && !state.doubt {
                    let next = tasks[state.tasks[0] as usize];
                    state.tasks[0] += 1;
                    let heights = self.leaves[next.leaf as usize].heights();
                    task = (!state.line.ends_before(heights)).then_some(next);
                }
                if let Some(task) = task {
                    waiting[still] = waiting[i];
                    still += 1;
                    round[filled] = task;
                    filled += 1;
                }
                if filled == WIDTH {
                    self.solve_some(simd, states, &round);
                    filled = 0;
                }
            }
            if filled > 0 {
                self.solve_some(simd, states, &round[..filled]);
            }
            waiting.truncate(still);
        }
    }

    #[inline(always)]
    fn solve_some<S: Simd>(&self, simd: S, states: &mut [State], tasks: &[Task]) {
        let mut parts = ArrayVec::<_, WIDTH>::new();
        for task in tasks {
            let course = &states[task.ray as usize].course;
            parts.push((&self.leaves[task.leaf as usize], course, task.guess, task.above));
        }
        let mut solved = [(f64::NAN, f64::NAN); WIDTH];
        solve(simd, &parts, &mut solved);
        drop(parts);
        for (task, (s, t)) in tasks.iter().zip(solved) {
            let leaf = &self.leaves[task.leaf as usize];
            let state = &mut states[task.ray as usize];
            state.found(leaf, s, t);
        }
    }
}

impl State {
    /// Takes account of a hit on a leaf; what is not a number was not found.
    #[inline(always)]
    fn found(&mut self, leaf: &Leaf, s: f64, t: f64) {
        let [start, end] = self.range.of_course;
        let (after, before, near) = (t - start, end - t, self.range.near);
        if !(after > near && before > near) {
            // Surely outside, or for the exact engine to say.
            self.doubt |= !(after < -near || before < -near);
            return;
        }
        let world = t + self.range.shift;
        if let Some(best) = self.closest {
            self.doubt |= (world - best.t).abs() < near && best.piece != leaf.piece();
            if world >= best.t {
                return;
            }
        }
        self.closest = Some(Hit { t: world, piece: leaf.piece(), s });
        self.line.end_at(t);
    }
}

//! The half plane cut into slabs between the heights at which something happens.
//!
//! Every height at which a piece ends is a *level*. Between two neighbouring levels, in a *slab*, the
//! pieces are functions r(z) that stand side by side: the *walls*. If none crosses another, their
//! order is the same all through the slab, and inside and outside of the solid alternate from the
//! outermost wall inwards (the even-odd rule). Pieces within one level are *flats*.
//!
//! ```text
//! level 2  ---------+       slab 1: walls at r = 2 and 3, the solid between them
//!            slab 1 | |
//! level 1  ------+--+-+     a flat from r = 0 to 2
//!            slab 0    \    slab 0: one wall, the solid from the axis to it
//! level 0  -------------+
//! ```

use super::solve::bracketed_newton;
use crate::numeric::gamma;
use crate::piece::{self, Kind, Piece};
use crate::profile::{Point, Profile};

/// A piece that spans at least one slab.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) piece: Piece,
    subpath: usize,
    /// Whether its subpath bounds a solid; the others are sheets.
    pub(super) solid: bool,
    /// Whether it is drawn upwards.
    pub(super) rising: bool,
    /// The levels of its lower and its upper end.
    levels: [usize; 2],
}

impl Wall {
    /// The parameter at which the wall has the height z; that of the nearer end beyond its ends.
    pub(super) fn parameter(&self, z: f64) -> f64 {
        let controls = self.piece.z.map(|c| c - z);
        let sign = if self.rising { 1.0 } else { -1.0 };
        let (start, end) = (sign * controls[0], sign * controls[3]);
        if start >= 0.0 {
            return 0.0;
        }
        if end <= 0.0 {
            return 1.0;
        }
        let guess = start / (start - end);
        if self.piece.kind == Kind::Line {
            return guess;
        }
        let height = |s| {
            let (value, slope) = self.piece.coordinate(&controls, s);
            (sign * value, sign * slope)
        };
        bracketed_newton(height, [0.0, 1.0], guess)
    }

    /// The distance from the axis at the height z.
    pub(super) fn r(&self, z: f64) -> f64 {
        self.piece.jet(self.parameter(z)).point.r
    }

    /// The distances from the axis at heights that differ from z by the tolerance at most.
    fn r_range(&self, z: f64, tolerance: f64) -> [f64; 2] {
        let (a, b) = (self.r(z - tolerance), self.r(z + tolerance));
        [a.min(b), a.max(b)]
    }
}

/// Why walls have no order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Disorder {
    /// The profile crosses itself near this point.
    Crossing(Point),
    /// There are more pairs of a wall and a slab than [`MOST`].
    TooMany,
}

/// The walls, slab by slab, of a profile moved down by a height.
#[derive(Clone, Debug)]
pub(super) struct Slabs {
    pub(super) levels: Vec<f64>,
    /// The heights of the levels in the profile as it was given.
    pub(super) given: Vec<f64>,
    pub(super) walls: Vec<Wall>,
    /// For the slab between the levels k and k + 1 its walls, from the axis outwards.
    pub(super) order: Vec<Vec<u32>>,
    /// For each level the ranges of r that its flats cover.
    pub(super) flats: Vec<Vec<[f64; 2]>>,
    /// For each subpath 1 if the solid is to the left of the drawing direction (r to the right, z
    /// up), and -1 if it is to the right.
    pub(super) senses: Vec<f64>,
    /// Nearer than this, positions cannot be told apart.
    pub(super) tolerance: f64,
}

/// The most pairs of a wall and a slab that are worked on: some hundred megabytes.
const MOST: usize = 1 << 24;

/// How often a slab is halved in search of a crossing. Two walls that overlap over less than
/// 2^-HALVINGS of the slab's height, in its middle, may go unnoticed.
const HALVINGS: u32 = 10;

impl Slabs {
    /// Cuts a profile that is moved down by `z`; `reach` bounds its coordinates then.
    pub(super) fn new(profile: &Profile, z: f64, reach: f64) -> Result<Self, Disorder> {
        // The roundings of moving, cutting and evaluating a point, with room to spare.
        let tolerance = gamma(64) * reach;
        let down = Point::new(0.0, -z);
        let mut pieces = Vec::new();
        let mut heights = Vec::new();
        for (i, subpath) in profile.subpaths().iter().enumerate() {
            for segment in subpath.segments() {
                let cut = piece::cut(&segment.moved(down));
                let cut = cut.into_iter().filter(|piece| piece.r != [0.0; 4]);
                for piece in cut {
                    heights.extend([piece.z[0], piece.z[3]].map(|own| {
                        let ends = [segment.start().z, segment.end().z];
                        (own, ends.into_iter().find(|end| end - z == own).unwrap_or(own + z))
                    }));
                    pieces.push((i, subpath.bounds_solid(), piece));
                }
            }
        }
        heights.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let (mut levels, mut given): (Vec<f64>, Vec<f64>) = Default::default();
        for (height, was) in heights {
            if levels.last().is_none_or(|last| height - last > tolerance) {
                levels.push(height);
                given.push(was);
            }
        }
        let level = |z: f64| levels.partition_point(|l| *l <= z).saturating_sub(1);

        let mut flats = vec![Vec::new(); levels.len()];
        let mut walls = Vec::new();
        let mut pairs = 0_usize;
        for (subpath, solid, piece) in pieces {
            let (start, end) = (piece.start(), piece.end());
            let levels = [level(start.z.min(end.z)), level(start.z.max(end.z))];
            pairs = pairs.saturating_add(levels[1] - levels[0]);
            if levels[0] == levels[1] {
                flats[levels[0]].push([start.r.min(end.r), start.r.max(end.r)]);
            } else {
                walls.push(Wall { piece, subpath, solid, rising: start.z < end.z, levels });
            }
        }
        if pairs > MOST {
            return Err(Disorder::TooMany);
        }
        for flats in &mut flats {
            flats.sort_by(|a, b| a[0].total_cmp(&b[0]));
        }

        let senses = vec![1.0; profile.subpaths().len()];
        let order = Vec::with_capacity(levels.len());
        let mut slabs = Self { levels, given, walls, order, flats, senses, tolerance };
        slabs.sort_walls()?;
        Ok(slabs)
    }

    /// Sorts the walls of each slab, and looks for crossings.
    fn sort_walls(&mut self) -> Result<(), Disorder> {
        let mut starting: Vec<Vec<u32>> = vec![Vec::new(); self.levels.len()];
        for (i, wall) in self.walls.iter().enumerate() {
            starting[wall.levels[0]].push(i as u32);
        }
        let mut votes = vec![None; self.senses.len()];
        let mut active: Vec<u32> = Vec::new();
        for (slab, (ends, starting)) in self.levels.windows(2).zip(&mut starting).enumerate() {
            let [bottom, top] = [ends[0], ends[1]];
            active.retain(|&i| self.walls[i as usize].levels[1] > slab);
            active.append(starting);
            let middle = 0.5 * (bottom + top);
            let mut row: Vec<_> = active
                .iter()
                .map(|&i| (i, self.walls[i as usize].r_range(middle, self.tolerance)))
                .collect();
            row.sort_by(|(i, a), (j, b)| (a[0] + a[1]).total_cmp(&(b[0] + b[1])).then(i.cmp(j)));
            for pair in row.windows(2) {
                let [a, b] = [0, 1].map(|i| &self.walls[pair[i].0 as usize]);
                if let Some(z) = self.swap(a, b, [bottom, top]) {
                    return Err(Disorder::Crossing(crossing(a, b, middle, z)));
                }
            }
            self.vote(&row, middle, &mut votes)?;
            active.clear();
            active.extend(row.iter().map(|(i, _)| i));
            self.order.push(active.clone());
        }
        for (sense, vote) in self.senses.iter_mut().zip(votes) {
            *sense = vote.map_or(1.0, |(sense, _)| sense);
        }
        Ok(())
    }

    /// On which side of each subpath the solid is, by one slab. What is clear in two slabs must be
    /// the same in both, or else the profile has crossed itself between them.
    fn vote(
        &self,
        row: &[(u32, [f64; 2])],
        z: f64,
        votes: &mut [Option<(f64, bool)>],
    ) -> Result<(), Disorder> {
        let solid: Vec<_> = row.iter().filter(|(i, _)| self.walls[*i as usize].solid).collect();
        let apart = |i: usize| solid[i].1[1] + self.tolerance < solid[i + 1].1[0];
        for (place, &&(i, [r, _])) in solid.iter().enumerate() {
            let wall = &self.walls[i as usize];
            let inwards = (solid.len() - 1 - place) % 2 == 0;
            let sense = if inwards == wall.rising { 1.0 } else { -1.0 };
            let clear =
                (place == 0 || apart(place - 1)) && (place + 1 == solid.len() || apart(place));
            match &mut votes[wall.subpath] {
                Some((known, true)) if clear && *known != sense => {
                    return Err(Disorder::Crossing(Point::new(r, z)));
                }
                Some((_, known_clear)) if *known_clear || !clear => {}
                vote => *vote = Some((sense, clear)),
            }
        }
        Ok(())
    }

    /// A height in the slab at which the wall `a`, which is the inner one, is outside of `b`.
    fn swap(&self, a: &Wall, b: &Wall, [bottom, top]: [f64; 2]) -> Option<f64> {
        let swapped = |z: f64, [ra, rb]: [f64; 2]| {
            ra > rb + self.tolerance && {
                let [a, b] = [a, b].map(|wall| wall.r_range(z, self.tolerance));
                a[0] > b[1] + self.tolerance
            }
        };
        let at = |z: f64| [a.r(z), b.r(z)];
        let (low, high) = (at(bottom), at(top));
        if let Some(z) = [(bottom, low), (top, high)].into_iter().find(|(z, r)| swapped(*z, *r)) {
            return Some(z.0);
        }
        if a.piece.kind == Kind::Line && b.piece.kind == Kind::Line {
            return None;
        }
        let mut stack = vec![([bottom, top], [low, high], 0)];
        while let Some(([bottom, top], [low, high], depth)) = stack.pop() {
            // Neither r turns, so that the ends bound all between them.
            if depth == HALVINGS || low[0].max(high[0]) <= low[1].min(high[1]) {
                continue;
            }
            let middle = 0.5 * (bottom + top);
            let r = at(middle);
            if swapped(middle, r) {
                return Some(middle);
            }
            stack.push(([bottom, middle], [low, r], depth + 1));
            stack.push(([middle, top], [r, high], depth + 1));
        }
        None
    }
}

/// The crossing between a height at which `a` is within `b` and one at which it is not.
fn crossing(a: &Wall, b: &Wall, mut ordered: f64, mut swapped: f64) -> Point {
    const HALVINGS: u32 = 60;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (ordered + swapped);
        if a.r(middle) > b.r(middle) { swapped = middle } else { ordered = middle }
    }
    Point::new(b.r(swapped), swapped)
}

//! What a vessel holds.
//!
//! The empty half plane falls into *rooms*: in each slab the gaps between neighbouring walls. Rooms
//! above and below a level are joined where both are open at it and no flat lies between. Liquid
//! falls along the axis until it lands; from there it rises over the lowest of all ways out, whose
//! highest level is the brim (a path of least greatest height, found as Dijkstra finds shortest
//! ones). The rooms that are reached below the brim are the cavity.
//!
//! Air leaves as long as a way to the open air is left above the liquid. When the liquid, rising at
//! one level everywhere in the cavity, closes the last way out of a pocket, the pocket keeps its air
//! and stays empty.

use core::cmp::Reverse;
use core::f64::consts::PI;
use std::collections::BinaryHeap;

use super::NoCavity;
use super::quadrature::{Sum, gauss};
use super::slabs::{Slabs, Wall};
use super::solve::bracketed_newton;
use crate::profile::Point;

/// The room that liquid takes in a vessel which stands upright, z pointing up: poured in from above
/// along the axis, standing at one level.
///
/// Where several hollows in the bottom are not yet joined below a level, all count as filled to it.
#[derive(Clone, Debug)]
pub struct Cavity {
    /// From the bottom upwards.
    layers: Vec<Layer>,
    /// The height that the layers' own is measured from.
    z: f64,
    bottom: f64,
    brim: f64,
    capacity: f64,
    error: f64,
    trapped: f64,
}

/// The part of the cavity in one slab.
#[derive(Clone, Debug)]
struct Layer {
    heights: [f64; 2],
    rooms: Vec<Room>,
    /// The volume of the layers below.
    below: f64,
}

/// A gap between two walls, or between the axis and a wall.
#[derive(Clone, Copy, Debug)]
struct Room {
    inner: Option<Wall>,
    outer: Wall,
}

impl Cavity {
    /// The height of the lowest liquid.
    pub fn bottom(&self) -> f64 {
        self.bottom
    }

    /// The height at which the vessel is full: one drop more would run out.
    pub fn brim(&self) -> f64 {
        self.brim
    }

    /// The volume of liquid up to the brim.
    pub fn capacity(&self) -> f64 {
        self.capacity
    }

    /// A bound for the error of the capacity, and of every volume.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// The volume of the pockets below the brim that keep their air.
    pub fn trapped(&self) -> f64 {
        self.trapped
    }

    /// Whether a place of the half plane, between the bottom and the brim, is taken by liquid when the vessel is
    /// full.
    pub fn contains(&self, at: Point) -> bool {
        let z = at.z - self.z;
        let layer = self.layers.iter().find(|l| l.heights[0] <= z && z < l.heights[1]);
        layer.is_some_and(|layer| {
            layer.rooms.iter().any(|room| {
                room.inner.as_ref().is_none_or(|inner| inner.r(z) <= at.r)
                    && at.r <= room.outer.r(z)
            })
        })
    }

    /// The volume of liquid that stands at the height z, or `None` above the brim.
    pub fn volume(&self, z: f64) -> Option<f64> {
        if z.is_nan() || z > self.brim {
            return None;
        }
        if z == self.brim {
            return Some(self.capacity);
        }
        let z = z - self.z;
        let layer = self.layers.iter().rfind(|layer| layer.heights[0] <= z);
        // By rounding alone the sum may come out above the capacity.
        Some(layer.map_or(0.0, |layer| (layer.below + layer.volume(z)).min(self.capacity)))
    }

    /// The height at which a volume of liquid stands, or `None` if that is negative or more than the
    /// capacity.
    pub fn level(&self, volume: f64) -> Option<f64> {
        if !(0.0..=self.capacity).contains(&volume) {
            return None;
        }
        if volume == 0.0 {
            return Some(self.bottom);
        }
        if volume == self.capacity {
            return Some(self.brim);
        }
        let layer = self.layers.iter().rfind(|layer| layer.below <= volume)?;
        let [low, high] = layer.heights;
        let excess = |z| (layer.below + layer.volume(z) - volume, layer.area(z));
        let z = if excess(low).0 >= 0.0 {
            low
        } else {
            bracketed_newton(excess, [low, high], 0.5 * (low + high))
        };
        Some((self.z + z).clamp(self.bottom, self.brim))
    }

    /// Pours into a profile that has been taken apart; `z` is what it was moved down by, `error` the
    /// bound for the error of a volume.
    pub(super) fn new(slabs: &Slabs, z: f64, error: f64) -> Result<Self, NoCavity> {
        let rooms = Rooms::new(slabs);
        let landing = rooms.landing(slabs).ok_or_else(|| {
            let ends = slabs.walls.iter().flat_map(|w| [w.piece.r[0], w.piece.r[3]]);
            let flats = slabs.flats.iter().flatten().map(|flat| flat[0]);
            NoCavity::Drains { bore: ends.chain(flats).fold(f64::INFINITY, f64::min) }
        })?;
        let Flood { brim, reached } = rooms.flood(landing);
        if brim == landing {
            return Err(NoCavity::RunsOff { z: slabs.given[landing] });
        }
        let vented = rooms.vented(&reached);
        let mut layers = Vec::new();
        let (mut below, mut trapped) = (Sum::default(), Sum::default());
        for slab in 0..brim {
            let heights = [slabs.levels[slab], slabs.levels[slab + 1]];
            let (mut filled, mut empty) = (Vec::new(), Vec::new());
            for (i, walls) in slabs.order[slab].iter().enumerate() {
                let wall = |i: u32| slabs.walls[i as usize];
                let inner = i.checked_sub(1).map(|i| wall(slabs.order[slab][i]));
                let room = rooms.first[slab + 1] + i;
                let list = if vented[room] { &mut filled } else { &mut empty };
                if reached[room] {
                    list.push(Room { inner, outer: wall(*walls) });
                }
            }
            let empty = Layer { heights, rooms: empty, below: 0.0 };
            trapped.add(empty.volume(heights[1]));
            if !filled.is_empty() || !layers.is_empty() {
                let layer = Layer { heights, rooms: filled, below: below.value() };
                below.add(layer.volume(heights[1]));
                layers.push(layer);
            }
        }
        let bottom = slabs.given[brim - layers.len()];
        let brim = slabs.given[brim];
        let (capacity, trapped) = (below.value(), trapped.value());
        Ok(Self { layers, z, bottom, brim, capacity, error, trapped })
    }
}

impl Layer {
    /// The volume between the layer's bottom and a height.
    fn volume(&self, z: f64) -> f64 {
        let within = |wall: &Wall| {
            let [a, b] = [wall.parameter(self.heights[0]), wall.parameter(z)];
            let square = |s| {
                let jet = wall.piece.jet(s);
                [jet.point.r * jet.point.r * jet.tangent.z]
            };
            let [integral] = gauss(square, [a, b]);
            PI * integral
        };
        let mut sum = Sum::default();
        for room in &self.rooms {
            sum.add(within(&room.outer));
            sum.add(room.inner.map_or(0.0, |inner| -within(&inner)));
        }
        sum.value().max(0.0)
    }

    /// The area of the liquid's surface at a height.
    fn area(&self, z: f64) -> f64 {
        let square = |wall: &Wall| wall.r(z).powi(2);
        let rooms = self.rooms.iter();
        PI * rooms
            .map(|room| square(&room.outer) - room.inner.as_ref().map_or(0.0, square))
            .sum::<f64>()
    }
}

/// All rooms, numbered slab by slab from below and from the axis outwards. The first slab lies below
/// all levels, the last above; between levels k - 1 and k lies slab k.
struct Rooms {
    /// The number of the first room of each slab, and the number of all rooms.
    first: Vec<usize>,
    /// Whether a room is inside the solid.
    solid: Vec<bool>,
    /// For each level the pairs of rooms, below and above, that are joined there.
    joints: Vec<Vec<[usize; 2]>>,
    /// For each level whether the axis is free there.
    free_axis: Vec<bool>,
}

struct Flood {
    /// The level at which the liquid runs out.
    brim: usize,
    /// The rooms reached below it.
    reached: Vec<bool>,
}

impl Rooms {
    fn new(slabs: &Slabs) -> Self {
        let count = slabs.levels.len();
        let row = |slab: usize| -> &[u32] {
            match slab.checked_sub(1) {
                Some(k) if k + 1 < count => &slabs.order[k],
                _ => &[],
            }
        };
        let mut first = vec![0];
        let mut solid: Vec<bool> = Vec::new();
        for slab in 0..=count {
            let walls = row(slab);
            let mut inside = false;
            let mut states: Vec<bool> = vec![inside];
            for wall in walls.iter().rev() {
                inside ^= slabs.walls[*wall as usize].solid;
                states.push(inside);
            }
            solid.extend(states.iter().rev());
            first.push(solid.len());
        }

        let mut joints = Vec::with_capacity(count);
        let mut free_axis = Vec::with_capacity(count);
        for (level, flats) in slabs.flats.iter().enumerate() {
            let bounds = |slab: usize| -> Vec<f64> {
                let walls = row(slab).iter();
                let r = walls.map(|w| slabs.walls[*w as usize].r(slabs.levels[level]));
                [0.0].into_iter().chain(r).chain([f64::INFINITY]).collect()
            };
            let (below, above) = (bounds(level), bounds(level + 1));
            let mut pairs = Vec::new();
            let (mut i, mut j) = (0, 0);
            while i + 1 < below.len() && j + 1 < above.len() {
                let rooms = [first[level] + i, first[level + 1] + j];
                let gap = [below[i].max(above[j]), below[i + 1].min(above[j + 1])];
                if !solid[rooms[0]] && !solid[rooms[1]] && open(gap, flats, slabs.tolerance) {
                    pairs.push(rooms);
                }
                if below[i + 1] < above[j + 1] { i += 1 } else { j += 1 }
            }
            let bore = below[1].min(above[1]);
            let flat = flats.first().map_or(f64::INFINITY, |flat| flat[0]);
            let empty = !solid[first[level]] && !solid[first[level + 1]];
            free_axis.push(empty && bore.min(flat) > slabs.tolerance);
            joints.push(pairs);
        }
        Self { first, solid, joints, free_axis }
    }

    /// The level at which something that falls along the axis lands.
    fn landing(&self, slabs: &Slabs) -> Option<usize> {
        (0..slabs.levels.len()).rev().find(|level| !self.free_axis[*level])
    }

    /// Whether a room reaches to infinity.
    fn outside(&self, room: usize) -> bool {
        self.first.binary_search(&(room + 1)).is_ok()
    }

    /// For each room the rooms that it is joined with, and the levels.
    fn neighbors(&self) -> Vec<Vec<(usize, usize)>> {
        let mut neighbors = vec![Vec::new(); self.solid.len()];
        for (level, pairs) in self.joints.iter().enumerate() {
            for &[below, above] in pairs {
                neighbors[below].push((above, level));
                neighbors[above].push((below, level));
            }
        }
        neighbors
    }

    /// Fills up from the room above the axis at a level until it runs out.
    fn flood(&self, landing: usize) -> Flood {
        let neighbors = self.neighbors();
        let mut reached = vec![false; self.solid.len()];
        let mut seen = vec![false; self.solid.len()];
        let start = self.first[landing + 1];
        let mut at_brim = Vec::new();
        let mut heap = BinaryHeap::from([Reverse((landing, start))]);
        let mut last = landing;
        while let Some(Reverse((height, room))) = heap.pop() {
            if std::mem::replace(&mut seen[room], true) {
                continue;
            }
            if height > last {
                at_brim.clear();
                last = height;
            }
            if self.outside(room) {
                break;
            }
            at_brim.push(room);
            reached[room] = true;
            heap.extend(
                neighbors[room].iter().map(|&(next, level)| Reverse((height.max(level), next))),
            );
        }
        for room in at_brim {
            reached[room] = false;
        }
        Flood { brim: last, reached }
    }

    /// Whether the air of each room of the cavity can leave when the liquid comes: whether the room is
    /// joined with the open air through what lies above its own bottom.
    fn vented(&self, cavity: &[bool]) -> Vec<bool> {
        let air = self.solid.len();
        let mut groups = Groups::new(air + 1);
        // The open air: everything that is joined with the outside without passing the cavity.
        for room in (0..air).filter(|room| self.outside(*room) && !cavity[*room]) {
            groups.join(room, air);
        }
        for &[below, above] in self.joints.iter().flatten() {
            if !cavity[below] && !cavity[above] {
                groups.join(below, above);
            }
        }
        let mut vented = vec![false; air];
        for slab in (0..self.joints.len()).rev() {
            for &[below, above] in &self.joints[slab] {
                if cavity[below] || cavity[above] {
                    groups.join(below, above);
                }
            }
            for room in self.first[slab]..self.first[slab + 1] {
                vented[room] = cavity[room] && groups.find(room) == groups.find(air);
            }
        }
        vented
    }
}

/// Whether some of the gap is left open by the flats, which are sorted by their inner ends.
fn open([mut from, to]: [f64; 2], flats: &[[f64; 2]], tolerance: f64) -> bool {
    for [inner, outer] in flats {
        if inner.min(to) - from > tolerance {
            return true;
        }
        from = from.max(*outer);
    }
    to - from > tolerance
}

/// Disjoint sets of rooms, with path halving (Tarjan and van Leeuwen 1984).
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn find(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.find(i), self.find(j));
        self.0[i] = j;
    }
}

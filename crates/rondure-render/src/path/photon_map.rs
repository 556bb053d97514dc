//! Photons where they came to rest, for looking up: cells of a grid, each with all photons that count somewhere in it. So a
//! place asks one cell, and no photon that is far away.
//!
//! The kernel is Epanechnikov's, 2 (1 - d^2 / r^2) / (pi r^2), within the radius r and near the plane of the surface.

use core::{
    f64::consts::FRAC_1_PI,
    hash::{BuildHasherDefault, Hash, Hasher},
    ops::Range,
};
use std::collections::HashMap;

use rondure::Vec3;

use super::{
    merging::{self, Chance},
    vertex::Vertex,
};
use crate::color::Rgb;

/// The greatest of the powers of four by which the radius of photons grows that come from far or lie far apart.
pub(super) const HIGHEST_LEVEL: u32 = 3;
/// The photons that a cell two radii wide must hold for them to keep their radius.
const ENOUGH: u32 = 8;
/// How far from the plane of the surface a photon may lie, as part of the radius.
const FLATNESS: f32 = 0.2;
/// The edge of a cell, in radii.
const EDGE: f64 = 1.0;

/// How many photons a place looks at, at most, of those in a cell.
const LOOKED_AT: u32 = 5;

/// Light that came to rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photon {
    pub(super) point: Vec3,
    /// Where it came from.
    pub(super) direction: Vec3,
    pub(super) power: Rgb,
    /// How many photons go where it went, by area across and solid angle; see `merging`.
    pub(super) density: f64,
    pub(super) thing: u32,
    /// How often it was scattered.
    pub(super) bounces: u32,
    /// The radius in which it counts, as a power of four times that of the pass.
    pub(super) level: u32,
}

/// A cell of the grid of one thing and level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cell {
    at: [i64; 3],
    thing: u32,
    level: u32,
}

impl Hash for Cell {
    #[inline]
    fn hash<H: Hasher>(&self, state: &mut H) {
        // Odd numbers with bits of no pattern; the products do not wait for each other.
        let [x, y, z] = self.at.map(|x| x as u64);
        let whose = u64::from(self.thing) << 32 | u64::from(self.level);
        let sum = x
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add(z.wrapping_mul(0x1656_67b1_9e37_79f9))
            .wrapping_add(whose.wrapping_mul(0xff51_afd7_ed55_8ccd));
        state.write_u64(sum);
    }
}

/// A photon in a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// From the cell's corner, in radii.
    at: [f32; 3],
    light: u32,
}

/// What a photon brings, in single precision: its power as part of the greatest.
#[derive(Clone, Copy, Debug)]
struct Light {
    power: [f32; 3],
    direction: [f32; 3],
    density: f32,
    bounces: u32,
}

/// The photons of one pass.
#[derive(Debug)]
pub(super) struct PhotonMap {
    radius: f64,
    /// For each thing the levels of the photons on it, as bits.
    levels: Vec<u8>,
    lights: Vec<Light>,
    /// The greatest power.
    greatest: f64,
    entries: Vec<Entry>,
    cells: Map<Cell, Range<u32>>,
}

impl PhotonMap {
    /// Of photons on `things` things.
    pub(super) fn new(radius: f64, things: usize, mut photons: Vec<Photon>) -> Self {
        widen(radius, &mut photons);
        let mut levels = vec![0; things];
        let mut cells: Map<Cell, Range<u32>> = Map::default();
        for photon in &photons {
            levels[photon.thing as usize] |= 1 << photon.level;
            for cell in reached(radius, photon) {
                cells.entry(cell).or_default().end += 1;
            }
        }
        let mut count = 0;
        for range in cells.values_mut() {
            let own = range.end;
            *range = count..count;
            count += own;
        }
        let mut entries = vec![Entry::default(); count as usize];
        for (photon, light) in photons.iter().zip(0..) {
            for cell in reached(radius, photon) {
                if let Some(range) = cells.get_mut(&cell) {
                    let at = within(cell.at, photon.point, radius_of(radius, photon.level));
                    entries[range.end as usize] = Entry { at, light };
                    range.end += 1;
                }
            }
        }
        let greatest = photons.iter().map(|photon| photon.power.max_channel()).fold(0.0, f64::max);
        let light = |photon: &Photon| {
            let (power, direction) = (photon.power / greatest, photon.direction);
            Light {
                power: [power.r, power.g, power.b].map(|x| x as f32),
                direction: [direction.x, direction.y, direction.z].map(|x| x as f32),
                density: photon.density as f32,
                bounces: photon.bounces,
            }
        };
        let lights = photons.iter().map(light).collect();
        Self { radius, levels, lights, greatest, entries, cells }
    }

    /// The radius in which those count that are not widened.
    #[inline]
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// The light of the photons round a place on the same thing, as it is seen from there; each scattered at most
    /// `left` times before. So many `samples` share the light of glossy lobes with them (`merging`).
    ///
    /// Of many in a cell it looks at every k-th, beginning at the one that `turn` chooses, any number: samples with
    /// numbers in a row see all of them. The photons of a pass are the same for many samples, so that theirs is the noise
    /// that lasts.
    pub(super) fn gather(
        &self,
        vertex: &Vertex<'_>,
        thing: u32,
        left: u32,
        turn: u32,
        samples: f64,
    ) -> Rgb {
        let used = self.levels[thing as usize];
        let levels = (0..=HIGHEST_LEVEL).filter(|level| used >> level & 1 == 1);
        let of_level = |level| self.gather_level(vertex, (thing, level), left, turn, samples);
        levels.fold(Rgb::BLACK, |sum, level| sum + of_level(level))
    }

    fn gather_level(
        &self,
        vertex: &Vertex<'_>,
        (thing, level): (u32, u32),
        left: u32,
        turn: u32,
        samples: f64,
    ) -> Rgb {
        let surface = &vertex.surface;
        let radius = radius_of(self.radius, level);
        let at = cell(surface.point, EDGE * radius);
        let Some(range) = self.cells.get(&Cell { at, thing, level }) else { return Rgb::BLACK };
        let from = within(at, surface.point, radius);
        let step = (range.end - range.start).div_ceil(LOOKED_AT);
        let near = &self.entries[(range.start + turn % step) as usize..range.end as usize];
        let near = near.iter().step_by(step as usize);
        // Seen from the viewer's side.
        let up = [vertex.normal().x, vertex.normal().y, vertex.normal().z].map(|x| x as f32);
        let found = near.filter_map(|entry| {
            let off = [0, 1, 2].map(|i| entry.at[i] - from[i]);
            let kernel = 1.0 - dot(off, off);
            if !(kernel > 0.0 && dot(off, up).abs() <= FLATNESS) {
                return None;
            }
            let light = &self.lights[entry.light as usize];
            let cos = dot(light.direction, up);
            (light.bounces <= left && cos > 0.0).then_some((light, kernel, cos))
        });
        let mut sum = Rgb::BLACK;
        if let Some(color) = vertex.even_color() {
            for (light, kernel, _) in found {
                sum += color_of(light.power) * f64::from(kernel);
            }
            sum = sum * color * FRAC_1_PI;
        } else {
            for (light, kernel, cos) in found {
                let [x, y, z] = light.direction.map(f64::from);
                let wide = vertex.evaluate(Vec3::new(x, y, z)).wide;
                let chance = Chance::new(wide.pdf, samples, f64::from(cos), self.radius);
                let share = merging::of_photon(light.density.into(), chance);
                sum += color_of(light.power) * wide.value * (share * f64::from(kernel / cos));
            }
        }
        sum * (2.0 * FRAC_1_PI / (radius * radius) * self.greatest * f64::from(step))
    }
}

/// Gives photons that lie far apart a larger radius, until some share a cell: one alone would be seen as a spot.
fn widen(radius: f64, photons: &mut [Photon]) {
    for level in 0..HIGHEST_LEVEL {
        let edge = 2.0 * radius_of(radius, level);
        let place =
            |photon: &Photon| Cell { at: cell(photon.point, edge), thing: photon.thing, level };
        let mut counts: Map<_, u32> = Map::default();
        for photon in &*photons {
            *counts.entry(place(photon)).or_default() += 1;
        }
        for photon in photons.iter_mut().filter(|photon| photon.level == level) {
            if counts[&place(photon)] < ENOUGH {
                photon.level += 1;
            }
        }
    }
}

#[inline]
fn radius_of(radius: f64, level: u32) -> f64 {
    radius * f64::from(1_u32 << (2 * level))
}

#[inline]
fn cell(point: Vec3, edge: f64) -> [i64; 3] {
    // `f64::floor` is a call of the library where SSE 4.1 is not a matter of course.
    let floor = |x: f64| {
        let whole = x as i64;
        whole - i64::from(whole as f64 > x)
    };
    [point.x, point.y, point.z].map(|x| floor(x / edge))
}

/// A place as seen from the corner of a cell, in radii.
#[inline]
fn within(cell: [i64; 3], point: Vec3, radius: f64) -> [f32; 3] {
    let at = [point.x, point.y, point.z];
    [0, 1, 2].map(|i| (at[i] / radius - EDGE * cell[i] as f64) as f32)
}

#[inline]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn color_of([r, g, b]: [f32; 3]) -> Rgb {
    Rgb { r: r.into(), g: g.into(), b: b.into() }
}

/// The cells that the ball of a photon reaches into.
fn reached(radius: f64, photon: &Photon) -> impl Iterator<Item = Cell> {
    let &Photon { point, thing, level, .. } = photon;
    let radius = radius_of(radius, level);
    let edge = EDGE * radius;
    let (low, high) =
        (cell(point - Vec3::splat(radius), edge), cell(point + Vec3::splat(radius), edge));
    let at = [point.x, point.y, point.z].map(|x| x / radius);
    // How far a row of cells is from the photon, in radii, and that squared.
    let off = move |axis: usize, i: i64| {
        let (from, to) = (EDGE * i as f64, EDGE * (i as f64 + 1.0));
        (from - at[axis]).max(at[axis] - to).max(0.0).powi(2)
    };
    (low[0]..=high[0]).flat_map(move |x| {
        (low[1]..=high[1]).flat_map(move |y| {
            let (flat, z) = (off(0, x) + off(1, y), low[2]..=high[2]);
            z.filter(move |&z| flat + off(2, z) < 1.0).map(move |z| Cell {
                at: [x, y, z],
                thing,
                level,
            })
        })
    })
}

type Map<K, V> = HashMap<K, V, BuildHasherDefault<Quick>>;

/// A hash of one number that nobody chooses to collide.
#[derive(Clone, Copy, Debug, Default)]
struct Quick(u64);

impl Hasher for Quick {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(byte.into());
        }
    }

    #[inline]
    fn write_u64(&mut self, i: u64) {
        let i = (self.0 ^ i ^ i >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = i ^ i >> 32;
    }

    #[inline]
    fn finish(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use core::f64::consts::PI;

    use rondure::Ray;
    use rondure_scene::{Material, Paint, Sky};

    use super::*;
    use crate::{
        numbers::Numbers,
        path::{media::Media, tests::world_of, vertex::Draw},
        sampler::{Key, Sample},
        world::Role,
    };

    const SAMPLES: f64 = 4.0;

    /// All photons, one by one.
    fn one_by_one(first: f64, photons: &[Photon], vertex: &Vertex<'_>, left: u32) -> Rgb {
        let mut sum = Rgb::BLACK;
        for photon in photons.iter().filter(|photon| photon.bounces <= left) {
            let radius = radius_of(first, photon.level);
            let off = photon.point - vertex.surface.point;
            let kernel = 1.0 - off.length_squared() / (radius * radius);
            let cos = photon.direction.dot(vertex.normal());
            let flat = off.dot(vertex.normal()).abs() <= f64::from(FLATNESS) * radius;
            if kernel > 0.0 && flat && cos > 0.0 {
                let wide = vertex.evaluate(photon.direction).wide;
                let by_chance =
                    SAMPLES * (wide.pdf - FRAC_1_PI).max(0.0) / (PI * first * first * cos);
                let share = 1.0 / (1.0 + (by_chance / photon.density).powi(2));
                let kernel = share * kernel * 2.0 * FRAC_1_PI / (radius * radius);
                sum += photon.power * wide.value * (kernel / cos);
            }
        }
        sum
    }

    #[test]
    fn cells_have_all_photons_and_all_turns_see_each() {
        const RADIUS: f64 = 0.1;
        // The least common multiple of all steps up to ten.
        const TURNS: u32 = 2520;
        for material in [
            Material::Matte { color: Paint::Solid([0.3, 0.6, 0.9]) },
            Material::Metal { eta: [1.6; 3], k: [9.0; 3], roughness: 0.6 },
        ] {
            let world = world_of(material, 0.1, Sky::Constant { color: [0.0; 3] });
            let mut photons: Vec<_> = (0..120)
                .map(|i| {
                    let sample = Sample::new(3, i, 0, 0);
                    let (x, y) = sample.pair(Key::LENS);
                    let (height, turn) = sample.pair(Key::FILTER);
                    // Dense round the middle of a cell, sparse far from it; some too high above the floor, some from below it.
                    let point = Vec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, 0.0);
                    let point = point * point.length_squared() + Vec3::new(0.1, 0.1, 0.03 * turn);
                    let (sin, cos) = (6.0 * turn).sin_cos();
                    let z = 1.2 * height - 0.2;
                    let flat = (1.0 - z * z).sqrt();
                    Photon {
                        point,
                        direction: Vec3::new(flat * cos, flat * sin, z),
                        power: Rgb { r: x, g: y, b: turn } * 1e-3,
                        density: if i % 5 == 0 { f64::INFINITY } else { 100.0 * x },
                        thing: 0,
                        bounces: i % 4,
                        level: 0,
                    }
                })
                .collect();
            let map = PhotonMap::new(RADIUS, world.count(), photons.clone());
            let fullest = map.cells.values().map(|range| range.end - range.start).max().unwrap();
            assert!((LOOKED_AT + 1..=10 * LOOKED_AT).contains(&fullest), "{fullest}");
            widen(RADIUS, &mut photons);
            let levels = [0, 1, 2].map(|l| photons.iter().filter(|p| p.level == l).count());
            assert!(levels.iter().all(|&count| count > 0), "{levels:?}");
            for (x, y) in [(0.1, 0.1), (0.15, 0.08), (-0.2, 0.3), (0.6, 0.7)] {
                let ray =
                    Ray::new(Vec3::new(x, y - 1.0, 1.0), Vec3::new(0.0, 1.0, -1.0).normalized());
                let contact = world.closest(&ray).unwrap();
                let Role::Surface { finish, solid } = world.met(&ray, &contact) else { panic!() };
                let mut numbers = Numbers::new();
                let (draw, media) = (&mut Draw::new(&mut numbers, Key::ROOT), Media::default());
                let met = (finish, solid);
                let vertex = Vertex::new(&world, &ray, &contact, met, &media, None, draw);
                let expected = one_by_one(RADIUS, &photons, &vertex, 2);
                let sum = (0..TURNS).fold(Rgb::BLACK, |sum, turn| {
                    sum + map.gather(&vertex, contact.thing, 2, turn, SAMPLES)
                });
                let found = sum / f64::from(TURNS);
                assert!(!expected.is_black());
                for (found, expected) in
                    [(found.r, expected.r), (found.g, expected.g), (found.b, expected.b)]
                {
                    assert!((found - expected).abs() < 1e-4 * expected, "{found} {expected}");
                }
            }
        }
    }
}

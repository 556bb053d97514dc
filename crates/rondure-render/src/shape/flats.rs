//! Rectangles and planes side by side, four to a vector.
//!
//! Each is met where [`Rectangle::closest`](super::Rectangle::closest) and [`Plane::closest`](super::Plane::closest) say, to the
//! last bit. A plane is a rectangle whose dual vectors are zero: everything is within it. The instruction set is chosen at run
//! time.

use fearless_simd::{Level, Simd, dispatch, f64x4, f64x8, prelude::*};
use rondure::{Ray, Rays, Vec3};

use super::Shape;

const LANES: usize = 4;
/// As many rays are looked at together.
const EIGHT: usize = 8;
type Lanes = [f64; LANES];

/// Flat shapes, by the numbers of the things that they are.
#[derive(Clone, Debug)]
pub(crate) struct Flats {
    level: Level,
    fours: Vec<Four>,
    things: Vec<u32>,
}

/// Up to four of them.
#[derive(Clone, Debug, Default)]
struct Four {
    point: [Lanes; 3],
    /// Zero where there is none: t is not a number there.
    normal: [Lanes; 3],
    dual: [[Lanes; 3]; 2],
}

impl Default for Flats {
    /// None.
    fn default() -> Self {
        Self { level: Level::new(), fours: Vec::new(), things: Vec::new() }
    }
}

impl Flats {
    /// Those of some things that are rectangles or planes, and the numbers of the others.
    pub(crate) fn of<'a>(shapes: impl Iterator<Item = (u32, &'a Shape)>) -> (Self, Vec<u32>) {
        let (mut fours, mut things, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for (thing, shape) in shapes {
            let Some([point, normal, u, v]) = shape.flat() else {
                others.push(thing);
                continue;
            };
            let lane = things.len() % LANES;
            if lane == 0 {
                fours.push(Four::default());
            }
            if let Some(four) = fours.last_mut() {
                let [du, dv] = &mut four.dual;
                for (rows, v) in
                    [(&mut four.point, point), (&mut four.normal, normal), (du, u), (dv, v)]
                {
                    for (axis, row) in rows.iter_mut().enumerate() {
                        row[lane] = v[axis];
                    }
                }
            }
            things.push(thing);
        }
        (Self { level: Level::new(), fours, things }, others)
    }

    /// The nearest hit in the ray's range, with the number of the thing; of several at the same place the one that came
    /// first.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<(u32, f64)> {
        if self.fours.is_empty() {
            return None;
        }
        let (lane, t) = dispatch!(self.level, simd => closest(simd, &self.fours, ray));
        (t < f64::INFINITY).then(|| (self.things[lane], t))
    }

    /// What [`closest`](Self::closest) says of each of many rays, to the last bit.
    pub(crate) fn closest_of_many(&self, rays: &Rays<'_>, found: &mut Vec<Option<(u32, f64)>>) {
        found.clear();
        let whole = if self.fours.is_empty() { 0 } else { rays.len() / EIGHT * EIGHT };
        dispatch!(self.level, simd => closest_of_eights(simd, self, rays, whole, found));
        found.extend((whole..rays.len()).map(|i| self.closest(&rays.get(i))));
    }

    /// Whether the ray meets any in its range.
    #[inline]
    pub(crate) fn any(&self, ray: &Ray) -> bool {
        !self.fours.is_empty() && dispatch!(self.level, simd => any(simd, &self.fours, ray))
    }
}

#[inline(always)]
fn closest<S: Simd>(simd: S, fours: &[Four], ray: &Ray) -> (usize, f64) {
    let (mut nearest, mut end) = (0, f64::INFINITY);
    for (i, four) in fours.iter().enumerate() {
        let (t, hits) = four.meet(simd, ray);
        let mut times = [0.0; LANES];
        t.store_slice(&mut times);
        for (lane, &t) in times.iter().enumerate() {
            let nearer = (hits >> lane & 1 == 1) & (t < end);
            (nearest, end) = if nearer { (LANES * i + lane, t) } else { (nearest, end) };
        }
    }
    (nearest, end)
}

/// The nearest hits of the first `whole` rays, eight rays and one shape at a time.
#[inline(always)]
fn closest_of_eights<S: Simd>(
    simd: S,
    flats: &Flats,
    rays: &Rays<'_>,
    whole: usize,
    found: &mut Vec<Option<(u32, f64)>>,
) {
    let ([ox, oy, oz], [dx, dy, dz]) = (rays.origins(), rays.directions());
    let [t_min, t_max] = rays.ranges();
    for start in (0..whole).step_by(EIGHT) {
        let origin = [eight(simd, ox, start), eight(simd, oy, start), eight(simd, oz, start)];
        let direction = [eight(simd, dx, start), eight(simd, dy, start), eight(simd, dz, start)];
        let range = [eight(simd, t_min, start), eight(simd, t_max, start)];
        let mut end = f64x8::splat(simd, f64::INFINITY);
        let mut nearest = [0; EIGHT];
        for (number, thing) in flats.things.iter().enumerate() {
            let (four, lane) = (&flats.fours[number / LANES], number % LANES);
            let [point, normal] =
                [eights(simd, &four.point, lane), eights(simd, &four.normal, lane)];
            let [du, dv] = [eights(simd, &four.dual[0], lane), eights(simd, &four.dual[1], lane)];
            let from = [point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]];
            let t = dot8(normal, from) / dot8(normal, direction);
            let local = [
                origin[0] - point[0] + direction[0] * t,
                origin[1] - point[1] + direction[1] * t,
                origin[2] - point[2] + direction[2] * t,
            ];
            let half = f64x8::splat(simd, 0.5);
            let hit = t.simd_ge(range[0])
                & t.simd_le(range[1])
                & t.simd_lt(end)
                & dot8(du, local).abs().simd_le(half)
                & dot8(dv, local).abs().simd_le(half);
            end = hit.select(t, end);
            let hits = hit.to_bitmask();
            for (i, nearest) in nearest.iter_mut().enumerate() {
                *nearest = if hits >> i & 1 == 1 { *thing } else { *nearest };
            }
        }
        let mut times = [0.0; EIGHT];
        end.store_slice(&mut times);
        for (thing, t) in nearest.into_iter().zip(times) {
            found.push((t < f64::INFINITY).then_some((thing, t)));
        }
    }
}

#[inline(always)]
fn eight<S: Simd>(simd: S, column: &[f64], start: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &column[start..start + EIGHT])
}

/// A vector of one of four shapes, for eight rays.
#[inline(always)]
fn eights<S: Simd>(simd: S, rows: &[Lanes; 3], lane: usize) -> [f64x8<S>; 3] {
    [
        f64x8::splat(simd, rows[0][lane]),
        f64x8::splat(simd, rows[1][lane]),
        f64x8::splat(simd, rows[2][lane]),
    ]
}

#[inline(always)]
fn dot8<S: Simd>(a: [f64x8<S>; 3], b: [f64x8<S>; 3]) -> f64x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn any<S: Simd>(simd: S, fours: &[Four], ray: &Ray) -> bool {
    for four in fours {
        if four.meet(simd, ray).1 != 0 {
            return true;
        }
    }
    false
}

impl Four {
    /// Where the ray meets the planes, and which of the shapes in its range, as bits.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, ray: &Ray) -> (f64x4<S>, u64) {
        let (origin, direction) = (splat(simd, ray.origin), splat(simd, ray.direction));
        let [point, normal] = [load(simd, &self.point), load(simd, &self.normal)];
        let from = [point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]];
        let t = dot(normal, from) / dot(normal, direction);
        let local = [
            origin[0] - point[0] + direction[0] * t,
            origin[1] - point[1] + direction[1] * t,
            origin[2] - point[2] + direction[2] * t,
        ];
        let u = dot(load(simd, &self.dual[0]), local).abs();
        let v = dot(load(simd, &self.dual[1]), local).abs();
        let half = f64x4::splat(simd, 0.5);
        // False for what is not a number.
        let hit = t.simd_ge(f64x4::splat(simd, ray.t_min))
            & t.simd_le(f64x4::splat(simd, ray.t_max))
            & t.simd_lt(f64x4::splat(simd, f64::INFINITY))
            & u.simd_le(half)
            & v.simd_le(half);
        (t, hit.to_bitmask())
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, rows: &[Lanes; 3]) -> [f64x4<S>; 3] {
    [
        f64x4::from_slice(simd, &rows[0]),
        f64x4::from_slice(simd, &rows[1]),
        f64x4::from_slice(simd, &rows[2]),
    ]
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: Vec3) -> [f64x4<S>; 3] {
    [f64x4::splat(simd, v.x), f64x4::splat(simd, v.y), f64x4::splat(simd, v.z)]
}

#[inline(always)]
fn dot<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> f64x4<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use rondure::RayColumns;

    use super::*;
    use crate::{
        sampler::{Key, Sample},
        shape::{Disk, Plane, Rectangle},
        warp,
    };

    #[test]
    fn hits_are_those_of_the_shapes() {
        let direction = |sample: &Sample, key| warp::cap(sample.pair(key), 2.0);
        let shapes: Vec<_> = (0..7)
            .map(|i| {
                let sample = Sample::new(1, i, 0, 0);
                let [a, b, c] = [Key::FILTER, Key::LENS, Key::ROOT].map(|k| direction(&sample, k));
                match i {
                    2 => Shape::Plane(Plane::new(a, b)),
                    4 => Shape::Disk(Disk::new(a, b, 0.5)),
                    _ => Shape::Rectangle(Rectangle::new(a, [b * 2.0, c])),
                }
            })
            .collect();
        let (flats, others) = Flats::of((10..).zip(&shapes));
        assert_eq!((flats.fours.len(), others), (2, vec![14]));
        let mut met = 0;
        let (mut rays, mut answers) = (Vec::new(), Vec::new());
        for i in 0..2005 {
            let sample = Sample::new(2, i, 0, 0);
            let end = if i % 3 == 0 { 1.0 } else { f64::INFINITY };
            let ray = Ray::new(direction(&sample, Key::LENS), direction(&sample, Key::ROOT))
                .with_range(0.0, end);
            let mut expected: Option<(u32, f64)> = None;
            for (thing, shape) in (10..).zip(&shapes).filter(|(thing, _)| *thing != 14) {
                if let Some(hit) = shape.closest(&ray)
                    && expected.is_none_or(|(_, t)| hit.t < t)
                {
                    expected = Some((thing, hit.t));
                }
            }
            met += u32::from(expected.is_some());
            assert_eq!(flats.closest(&ray), expected);
            assert_eq!(flats.any(&ray), expected.is_some());
            rays.push(ray);
            answers.push(expected);
        }
        assert!(met > 500, "{met}");
        let mut found = vec![None; 3];
        flats.closest_of_many(&RayColumns::from_iter(&rays).rays(), &mut found);
        assert_eq!(found, answers);
    }

    #[test]
    fn rays_along_flat_shapes_meet_none() {
        let plane = Shape::Plane(Plane::new(Vec3::ZERO, Vec3::Z));
        let (flats, _) = Flats::of([(0, &plane)].into_iter());
        for origin in [Vec3::ZERO, Vec3::Z] {
            assert_eq!(flats.closest(&Ray::new(origin, Vec3::X)), None);
        }
    }
}

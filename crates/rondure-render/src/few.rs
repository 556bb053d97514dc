//! Few things in a list, which is faster than a tree of boxes: a ray looks at what is solved in place first, then at the boxes round
//! all others, eight at a time, and asks those things whose boxes it meets, near ones first.
//!
//! Where a ray meets the plane of a box, t = (plane - o) / d is good to three roundings of itself, which [`ROOM`] makes up for. That hits
//! are rounded, too, is made up for by [`PAD`]: by far more than rounding moves a hit, and far less than a box is large.

use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use rondure::{Bounds, Ray, Vec3, numeric::gamma};

use crate::{shape::Flats, things::Things};

/// The most things in a list.
pub(crate) const MOST: usize = 16;

/// So many boxes lie side by side.
const WIDTH: usize = 8;

/// How much t may be off, as a part of it, or more.
const ROOM: f64 = gamma(8);

/// How much larger boxes are, as a part of the largest of their coordinates.
const PAD: f64 = 1.0 / (1_u64 << 40) as f64;

/// A list of few things.
#[derive(Clone, Debug)]
pub(crate) struct Few {
    flats: Flats,
    /// What else there is, in the order of the numbers.
    things: Vec<u32>,
    boxes: Vec<Eight>,
    level: Level,
}

/// Boxes of eight things: the smallest and the largest x, then y, then z. Free places have boxes that no ray meets.
#[derive(Clone, Copy, Debug)]
struct Eight([[f64; WIDTH]; 6]);

/// Which of the boxes a ray meets, as bits, and where it enters them.
struct Met {
    boxes: u32,
    enter: [f64; MOST],
}

impl Few {
    /// Those of all things that are `listed`; `None` if there are too many things.
    pub(crate) fn new(things: &Things, listed: impl Fn(u32) -> bool) -> Option<Self> {
        if things.len() > MOST {
            return None;
        }
        let (turned, all) = (things.turned.len() as u32, things.len() as u32);
        let simple = (turned..all).zip(&things.simple).filter(|(thing, _)| listed(*thing));
        let (flats, others) = Flats::of(simple);
        let others = (0..turned).filter(|thing| listed(*thing)).chain(others);
        Some(Self { flats, ..Self::of_boxes(others, |thing| things.bounds(thing)) })
    }

    /// The same, but flat shapes are in boxes as well, and [`walk`](Self::walk) leaves out nothing.
    pub(crate) fn boxed(things: &Things, listed: impl Fn(u32) -> bool) -> Option<Self> {
        let all = 0..things.len() as u32;
        let listed = all.filter(|thing| listed(*thing));
        (things.len() <= MOST).then(|| Self::of_boxes(listed, |thing| things.bounds(thing)))
    }

    fn of_boxes(things: impl Iterator<Item = u32>, bounds: impl Fn(u32) -> Bounds) -> Self {
        let things: Vec<_> = things.collect();
        let mut boxes = vec![Eight::FREE; things.len().div_ceil(WIDTH)];
        for (i, &thing) in things.iter().enumerate() {
            boxes[i / WIDTH].set(i % WIDTH, &bounds(thing));
        }
        Self { flats: Flats::default(), things, boxes, level: Level::new() }
    }

    /// The rectangles and planes, which [`walk`](Self::walk) leaves out.
    #[inline(always)]
    pub(crate) fn flats(&self) -> &Flats {
        &self.flats
    }

    /// Visits what else the ray may meet in its range, near things first. `visit` returns up to which t the search goes on; minus infinity
    /// stops.
    #[inline(always)]
    pub(crate) fn walk(&self, ray: &Ray, mut visit: impl FnMut(u32) -> f64) {
        let Met { mut boxes, enter } = self.meet(ray);
        let mut end = ray.t_max;
        while boxes != 0 {
            let first = bits(boxes).fold(boxes.trailing_zeros() as usize % MOST, |first, i| {
                if enter[i] < enter[first] { i } else { first }
            });
            if enter[first] > end || end == f64::NEG_INFINITY {
                return;
            }
            boxes &= !(1 << first);
            end = visit(self.things[first]);
        }
    }

    /// What of that any of some rays may meet in its range, in the order in which things are listed: turned ones by their numbers, then others.
    #[inline]
    pub(crate) fn candidates(&self, rays: impl Iterator<Item = Ray>) -> Candidates<'_> {
        let boxes = rays.fold(0, |boxes, ray| boxes | self.meet(&ray).boxes);
        Candidates { few: self, boxes }
    }

    #[inline(always)]
    fn meet(&self, ray: &Ray) -> Met {
        dispatch!(self.level, simd => meet(simd, &self.boxes, ray))
    }
}

/// Things that rays may meet.
pub(crate) struct Candidates<'a> {
    few: &'a Few,
    boxes: u32,
}

impl Iterator for Candidates<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        let place = bits(self.boxes).next()?;
        self.boxes &= self.boxes - 1;
        Some(self.few.things[place])
    }
}

/// The places of the bits that are set.
#[inline(always)]
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let place = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (place < MOST).then_some(place)
    })
}

impl Eight {
    const FREE: Self = {
        let (low, high) = ([f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]);
        Self([low, high, low, high, low, high])
    };

    fn set(&mut self, place: usize, bounds: &Bounds) {
        let largest = bounds.min.max_abs().max(bounds.max.max_abs());
        let pad = Vec3::splat(if largest.is_finite() { PAD * largest } else { 0.0 });
        let (min, max) = (bounds.min - pad, bounds.max + pad);
        for axis in 0..3 {
            self.0[2 * axis][place] = min[axis];
            self.0[2 * axis + 1][place] = max[axis];
        }
    }
}

#[inline(always)]
fn meet<S: Simd>(simd: S, boxes: &[Eight], ray: &Ray) -> Met {
    let splat = |x: f64| f64x8::splat(simd, x);
    let [o, d] = [ray.origin, ray.direction];
    let [ox, oy, oz] = [splat(o.x), splat(o.y), splat(o.z)];
    let [x, y, z] = [reciprocal(d.x), reciprocal(d.y), reciprocal(d.z)];
    // The planes that the ray meets first.
    let [near_x, near_y, near_z] =
        [usize::from(x < 0.0), 2 + usize::from(y < 0.0), 4 + usize::from(z < 0.0)];
    let [x, y, z] = [splat(x), splat(y), splat(z)];
    let (start, end, room) = (splat(ray.t_min), splat(ray.t_max), splat(ROOM));
    let mut met = Met { boxes: 0, enter: [0.0; MOST] };
    for (i, (Eight(planes), enters)) in
        boxes.iter().zip(met.enter.chunks_exact_mut(WIDTH)).enumerate()
    {
        let plane = |number: usize| f64x8::from_slice(simd, &planes[number]);
        let enter =
            ((plane(near_x) - ox) * x).max((plane(near_y) - oy) * y).max((plane(near_z) - oz) * z);
        let leave = ((plane(near_x ^ 1) - ox) * x)
            .min((plane(near_y ^ 1) - oy) * y)
            .min((plane(near_z ^ 1) - oz) * z);
        let (enter, leave) = (enter - enter.abs() * room, leave + leave.abs() * room);
        // False where there is no box: what is infinite is no number any more.
        let meets = enter.simd_le(leave) & leave.simd_ge(start) & enter.simd_le(end);
        enter.store_slice(enters);
        met.boxes |= (meets.to_bitmask() as u32) << (WIDTH * i);
    }
    met
}

/// 1 / d, but no more than 2^1022: what is parallel to a plane, or nearly so, is inside of it from end to end or never.
#[inline(always)]
fn reciprocal(d: f64) -> f64 {
    1.0 / if d.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE.copysign(d) } else { d }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        sampler::{Key, Sample},
        warp,
    };

    fn visited(few: &Few, ray: &Ray) -> Vec<u32> {
        let mut visited = Vec::new();
        few.walk(ray, |thing| {
            visited.push(thing);
            ray.t_max
        });
        visited
    }

    #[test]
    fn boxes_are_met_from_any_side_and_near_ones_first() {
        let unit = |at: f64| Bounds { min: Vec3::splat(at), max: Vec3::splat(at + 1.0) };
        let few = Few::of_boxes(0..11, |thing| unit(2.0 * f64::from(thing)));
        let along = Ray::new(Vec3::splat(-5.0), Vec3::splat(1.0));
        assert_eq!(visited(&few, &along), (0..11).collect::<Vec<_>>());
        let back = Ray::new(Vec3::splat(25.0), Vec3::splat(-1.0));
        assert_eq!(visited(&few, &back), (0..11).rev().collect::<Vec<_>>());
        assert_eq!(visited(&few, &along.with_range(7.5, 12.0)), [1, 2, 3]);
        assert_eq!(
            few.candidates([back].into_iter()).collect::<Vec<_>>(),
            (0..11).collect::<Vec<_>>()
        );
        // From inside, and along an edge.
        let inside = Ray::new(Vec3::new(4.5, 4.5, 4.5), Vec3::X);
        assert_eq!(visited(&few, &inside), [2]);
        let edge = Ray::new(Vec3::new(-9.0, 4.0, 5.0), Vec3::X);
        assert_eq!(visited(&few, &edge), [2]);
        assert_eq!(visited(&few, &edge.with_range(f64::NEG_INFINITY, 12.0)), []);
        let mut first = Vec::new();
        few.walk(&along, |thing| {
            first.push(thing);
            if thing == 3 { f64::NEG_INFINITY } else { f64::INFINITY }
        });
        assert_eq!(first, [0, 1, 2, 3]);
    }

    #[test]
    fn a_ray_to_a_point_of_a_box_meets_it() {
        for size in [1e-6, 1.0, 1e6] {
            for i in 0..4000 {
                let sample = Sample::new(5, i, 0, 0);
                let at = |key: Key| warp::cap(sample.pair(key), 2.0);
                let (center, half) = (at(Key::FILTER) * size, at(Key::LENS).abs() * (0.3 * size));
                let bounds = Bounds { min: center - half, max: center + half };
                let few = Few::of_boxes(7..8, |_| bounds);
                // A corner, or the middle of an edge or a face.
                let side = |n: u32| f64::from(i / n % 3) - 1.0;
                let sides = Vec3::new(side(1), side(3), side(9));
                let point =
                    center + Vec3::new(half.x * sides.x, half.y * sides.y, half.z * sides.z);
                let mut to = at(Key::ROOT);
                if i % 5 == 0 {
                    to.y = 0.0;
                }
                for distance in [0.0, 1.0, 1e7] {
                    let origin = point - to * (distance * size);
                    let t = distance * size;
                    let ray = Ray::new(origin, to).with_range(t * (1.0 - 1e-12), t);
                    assert_eq!(visited(&few, &ray), [7], "{bounds:?} {ray:?}");
                }
            }
        }
    }

    #[test]
    fn planes_are_met_and_nothing_is_not() {
        let endless = Vec3::splat(f64::INFINITY);
        let few = Few::of_boxes(0..2, |thing| match thing {
            0 => Bounds { min: -endless, max: endless },
            _ => Bounds::EMPTY,
        });
        for direction in [Vec3::X, -Vec3::Z, Vec3::new(-1.0, 1e-300, 0.0)] {
            assert_eq!(visited(&few, &Ray::new(Vec3::splat(9.0), direction)), [0]);
        }
        assert_eq!(visited(&few, &Ray::new(Vec3::splat(f64::NAN), Vec3::X)), []);
    }
}

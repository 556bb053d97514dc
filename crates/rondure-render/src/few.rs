//! Few things in a list, which is faster than a tree of boxes: a ray looks at what is solved in place first, then at the boxes round
//! all others, eight at a time, and asks those things whose boxes it meets, near ones first.
//!
//! Where a ray meets the plane of a box, t = (plane - o) / d is good to three roundings of itself, which [`ROOM`] makes up for. That hits
//! are rounded, too, is made up for by [`PAD`]: by far more than rounding moves a hit, and far less than a box is large.

use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use rondure::{Bounds, Ray, Vec3, numeric::gamma};

use crate::{shape::Flats, things::Things};

/// The most things in a list.
pub(crate) const MOST: usize = 32;

/// So many boxes lie side by side.
const WIDTH: usize = 8;

/// So few are looked at one by one, turned ones by the balls round them: to choose the instruction set takes as long.
const ONE_BY_ONE: usize = 4;

/// How much t may be off, as a part of it, or more.
const ROOM: f64 = gamma(8);

/// How much larger boxes are, as a part of the largest of their coordinates.
const PAD: f64 = 1.0 / (1_u64 << 40) as f64;

/// A list of few things.
#[derive(Clone, Debug)]
pub(crate) struct Few {
    flats: Flats,
    /// What else there is, in the order of the numbers, and the boxes round that.
    things: Vec<u32>,
    boxes: Vec<Eight>,
    /// The balls round those that are turned, the first ones, if there are only few.
    balls: Vec<Ball>,
    level: Level,
}

/// Boxes of eight things: the smallest and the largest x, then y, then z. Free places have boxes that no ray meets.
#[derive(Clone, Copy, Debug)]
struct Eight([[f64; WIDTH]; 6]);

/// The ball round a thing.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: Vec3,
    /// The square of the radius, with room for rounding.
    reach2: f64,
}

impl Few {
    /// All things; `None` if there are too many. Rectangles and planes stand in boxes like others, unless they are `flat`.
    pub(crate) fn new(things: &Things, flat: impl Fn(u32) -> bool) -> Option<Self> {
        if things.len() > MOST {
            return None;
        }
        let (turned, all) = (things.turned.len() as u32, things.len() as u32);
        let (flats, mut others) =
            Flats::of((turned..all).zip(&things.simple).filter(|(thing, _)| flat(*thing)));
        others.extend((turned..all).filter(|thing| !flat(*thing)));
        others.sort_unstable();
        let balls = (0..turned).take(ONE_BY_ONE).map(|thing| Ball::new(&things.bounds(thing)));
        let balls = balls.collect();
        let boxes = Self::of_boxes((0..turned).chain(others), |thing| things.bounds(thing));
        Some(Self { flats, balls, ..boxes })
    }

    fn of_boxes(things: impl Iterator<Item = u32>, bounds: impl Fn(u32) -> Bounds) -> Self {
        let things: Vec<_> = things.collect();
        let mut boxes = vec![Eight::FREE; things.len().div_ceil(WIDTH)];
        for (i, &thing) in things.iter().enumerate() {
            boxes[i / WIDTH].set(i % WIDTH, &bounds(thing));
        }
        let balls = Vec::new();
        Self { flats: Flats::default(), things, boxes, balls, level: Level::new() }
    }

    /// The rectangles and planes.
    #[inline(always)]
    pub(crate) fn flats(&self) -> &Flats {
        &self.flats
    }

    /// Visits what else the ray may meet in its range, near things first. `visit` returns up to which t the search goes on; minus infinity
    /// stops.
    #[inline(always)]
    pub(crate) fn walk(&self, ray: &Ray, mut visit: impl FnMut(u32) -> f64) {
        let mut end = ray.t_max;
        if self.things.len() <= ONE_BY_ONE {
            for &thing in &self.things[self.balls.len()..] {
                end = visit(thing);
                if end == f64::NEG_INFINITY {
                    return;
                }
            }
            for (ball, &thing) in self.balls.iter().zip(&self.things) {
                if !ball.misses(ray, end) {
                    end = visit(thing);
                    if end == f64::NEG_INFINITY {
                        return;
                    }
                }
            }
            return;
        }
        let mut enter = [0.0; MOST];
        let mut left = dispatch!(self.level, simd => meet(simd, &self.boxes, ray, &mut enter));
        while left != 0 {
            let mut places = bits(left);
            let mut first = places.next().unwrap_or_default();
            for place in places {
                first = if enter[place] < enter[first] { place } else { first };
            }
            if enter[first] > end || end == f64::NEG_INFINITY {
                return;
            }
            left &= !(1 << first);
            end = visit(self.things[first]);
        }
    }

    /// Whether anything else that the ray may meet in its range is what it `is` asked for.
    #[inline(always)]
    pub(crate) fn any(&self, ray: &Ray, mut is: impl FnMut(u32) -> bool) -> bool {
        if self.things.len() > ONE_BY_ONE {
            return self.things(self.met(ray)).any(is);
        }
        let mut found = false;
        self.walk(ray, |thing| {
            found = is(thing);
            if found { f64::NEG_INFINITY } else { ray.t_max }
        });
        found
    }

    /// Which boxes the ray meets in its range, as bits.
    #[inline(always)]
    pub(crate) fn met(&self, ray: &Ray) -> u32 {
        if self.things.len() > ONE_BY_ONE {
            return dispatch!(self.level, simd => meet(simd, &self.boxes, ray, &mut [0.0; MOST]));
        }
        let of_others = (1 << self.things.len()) - (1 << self.balls.len());
        let met = |(place, ball): (usize, &Ball)| u32::from(!ball.misses(ray, ray.t_max)) << place;
        self.balls.iter().enumerate().map(met).fold(of_others, |all, one| all | one)
    }

    /// The things in the boxes of these bits: turned ones by their numbers, then others by theirs.
    #[inline(always)]
    pub(crate) fn things(&self, boxes: u32) -> impl Iterator<Item = u32> + '_ {
        bits(boxes).map(|place| self.things[place])
    }

    /// The bits of the boxes of some things.
    pub(crate) fn boxes(&self, of: impl Fn(u32) -> bool) -> u32 {
        let boxes = self.things.iter().enumerate();
        boxes.fold(0, |boxes, (place, &thing)| boxes | u32::from(of(thing)) << place)
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

impl Ball {
    fn new(bounds: &Bounds) -> Self {
        let half = (bounds.max - bounds.min) * 0.5;
        let center = bounds.min + half;
        Self { center, reach2: (1.0 + 2.0 * PAD) * half.length_squared() }
    }

    /// Whether the ray surely has nothing of the ball up to `end`. What is not a number is not sure.
    #[inline(always)]
    fn misses(&self, ray: &Ray, end: f64) -> bool {
        let (to, d) = (self.center - ray.origin, ray.direction);
        let (to2, d2, along) = (to.length_squared(), d.length_squared(), to.dot(d));
        let reach2 = self.reach2 * d2;
        // The squares of lengths, each times d^2, and what they may be off.
        let aside = to2 * d2 - along * along;
        let before = along - ray.t_min * d2;
        let beyond = along - end * d2;
        let slack = reach2 + gamma(64) * (to2 * d2);
        aside > slack
            || (before < 0.0 && before * before > slack)
            || (beyond > 0.0 && beyond * beyond > slack)
    }
}

#[inline(always)]
fn meet<S: Simd>(simd: S, boxes: &[Eight], ray: &Ray, enters: &mut [f64; MOST]) -> u32 {
    let splat = |x: f64| f64x8::splat(simd, x);
    let [ox, oy, oz] = [splat(ray.origin.x), splat(ray.origin.y), splat(ray.origin.z)];
    let Vec3 { x, y, z } = ray.direction;
    let [x, y, z] = [reciprocal(x), reciprocal(y), reciprocal(z)];
    // The planes that the ray meets first.
    let [near_x, near_y, near_z] =
        [usize::from(x < 0.0), 2 + usize::from(y < 0.0), 4 + usize::from(z < 0.0)];
    let [x, y, z] = [splat(x), splat(y), splat(z)];
    let (start, end, room) = (splat(ray.t_min), splat(ray.t_max), splat(ROOM));
    let mut met = 0;
    for (i, (Eight(planes), enters)) in boxes.iter().zip(enters.chunks_exact_mut(WIDTH)).enumerate()
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
        met |= (meets.to_bitmask() as u32) << (WIDTH * i);
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
        assert_eq!(few.things(few.met(&back)).collect::<Vec<_>>(), (0..11).collect::<Vec<_>>());
        // From inside, and along an edge.
        let inside = Ray::new(Vec3::new(4.5, 4.5, 4.5), Vec3::X);
        assert_eq!(visited(&few, &inside), [2]);
        let edge = Ray::new(Vec3::new(-9.0, 4.0, 5.0), Vec3::X);
        assert_eq!(visited(&few, &edge), [2]);
        assert_eq!(visited(&few, &edge.with_range(f64::NEG_INFINITY, 12.0)), []);
        let mut first = Vec::new();
        few.walk(&along, |thing| {
            first.push(thing);
            if thing == 3 { 11.5 } else { 20.0 }
        });
        assert_eq!(first, [0, 1, 2, 3]);
    }

    #[test]
    fn balls_are_missed_only_from_beside_them_behind_and_before() {
        let center = Vec3::new(3.0, 4.0, 5.0);
        let half = Vec3::splat(1.0);
        let ball = Ball::new(&Bounds { min: center - half, max: center + half });
        let towards = |aside: f64| {
            let origin = Vec3::new(3.0 + aside, -10.0, 5.0);
            Ray::new(origin, Vec3::new(0.0, 2.0, 0.0))
        };
        for aside in [0.0, 1.0, 3.0_f64.sqrt()] {
            let ray = towards(aside);
            assert!(!ball.misses(&ray, f64::INFINITY), "{aside}");
            // The corner of the box that is nearest, and farthest.
            assert!(!ball.misses(&ray, 6.5), "{aside}");
            assert!(!ball.misses(&ray.with_range(7.5, f64::INFINITY), f64::INFINITY), "{aside}");
        }
        assert!(ball.misses(&towards(2.5), f64::INFINITY));
        assert!(ball.misses(&towards(0.0), 5.0));
        assert!(ball.misses(&towards(0.0).with_range(9.0, f64::INFINITY), f64::INFINITY));
        let line = towards(0.0).with_range(f64::NEG_INFINITY, f64::INFINITY);
        assert!(!ball.misses(&line, f64::INFINITY));
        let back = Ray { direction: Vec3::new(0.0, -1.0, 0.0), ..line };
        assert!(!ball.misses(&back, f64::INFINITY));
        assert!(ball.misses(&back.with_range(0.0, f64::INFINITY), f64::INFINITY));
    }

    #[test]
    fn what_is_not_a_number_does_not_miss_a_ball() {
        let ball = Ball::new(&Bounds { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) });
        let ray = Ray::new(Vec3::splat(f64::NAN), Vec3::X);
        assert!(!ball.misses(&ray, f64::INFINITY));
        let endless = Vec3::splat(f64::INFINITY);
        let space = Ball::new(&Bounds { min: -endless, max: endless });
        assert!(!space.misses(&Ray::new(Vec3::splat(9.0), Vec3::X), 1.0));
    }

    #[test]
    fn a_ray_to_a_point_of_a_box_meets_it() {
        for size in [1e-6, 1.0, 1e6] {
            for i in 0..4000 {
                let sample = Sample::new(5, i, 0, 0);
                let at = |key: Key| warp::cap(sample.pair(key), 2.0);
                let (center, half) = (at(Key::FILTER) * size, at(Key::LENS).abs() * (0.3 * size));
                let bounds = Bounds { min: center - half, max: center + half };
                let few = Few::of_boxes(7..12, |_| bounds);
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
                    assert_eq!(visited(&few, &ray).len(), 5, "{bounds:?} {ray:?}");
                    assert!(!Ball::new(&bounds).misses(&ray, t), "{bounds:?} {ray:?}");
                }
            }
        }
    }

    #[test]
    fn planes_are_met_and_nothing_is_not() {
        let endless = Vec3::splat(f64::INFINITY);
        let few = Few::of_boxes(0..9, |thing| match thing {
            0 => Bounds { min: -endless, max: endless },
            _ => Bounds::EMPTY,
        });
        for direction in [Vec3::X, -Vec3::Z, Vec3::new(-1.0, 1e-300, 0.0)] {
            assert_eq!(visited(&few, &Ray::new(Vec3::splat(9.0), direction)), [0]);
        }
        assert_eq!(visited(&few, &Ray::new(Vec3::splat(f64::NAN), Vec3::X)), []);
    }
}

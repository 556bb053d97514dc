//! The copies of an object: rows, rings, scatterings and random variations.
//!
//! They stay described until someone asks for one: ten million copies take as little memory as one.
//! What is random is a function of a seed and the copy's number alone, so that any copy can be asked
//! for on its own, in any order, on any machine.

use rondure::{Affine, Vec3};

/// Where the copies of an object stand, seen from the object itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Copies {
    /// The shifts to the positions listed one by one; empty if there are none listed.
    pub at: Vec<Vec3>,
    /// Series of series: all of the first are repeated as the second tells, and so on.
    pub series: Vec<Series>,
    /// How each copy differs from the object, at random.
    pub variation: Option<Variation>,
}

/// Many copies, described at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// How many; at least one.
    pub count: u32,
    /// How one differs from the others.
    pub pattern: Pattern,
}

/// How the copies of a series lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// In a row: each a step from the one before.
    Row {
        /// The step.
        step: Vec3,
    },
    /// On a circle: each a turn from the one before.
    Ring {
        /// A point on the axis.
        center: Vec3,
        /// The direction of the axis.
        axis: Vec3,
        /// The turn, in radians.
        turn: f64,
    },
    /// Anywhere in an area round the object's position, evenly at random.
    Scatter {
        /// Where.
        area: Area,
        /// Chooses the places.
        seed: u64,
    },
}

/// What copies are scattered over; in its middle is the object's position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Area {
    /// A box of this size.
    Box(Vec3),
    /// A level disk of this radius.
    Disk(f64),
}

/// How each copy differs from the object, evenly at random. Turns and sizes are about the object's
/// position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// Moved by at most this along each axis, to either side.
    pub shift: Vec3,
    /// Turned about the upright line through its position by at most this, either way, in radians.
    pub turn: f64,
    /// Leaning by at most this, to any side, in radians.
    pub tilt: f64,
    /// Larger by a factor between these two.
    pub scale: [f64; 2],
    /// Chooses the numbers.
    pub seed: u64,
}

/// What carries an object to one of its copies: a motion, after a change of size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The whole map.
    pub map: Affine,
    /// The factor on lengths in it; positive.
    pub scale: f64,
}

impl Copies {
    /// How many there are; 1 if the object stands alone.
    pub fn count(&self) -> u64 {
        let listed = self.at.len().max(1) as u64;
        let counts = self.series.iter().map(|series| u64::from(series.count));
        counts.fold(listed, u64::saturating_mul)
    }

    /// The motion to the copy of this number, for an object at `position`. Copies are counted from 0,
    /// the last series fastest.
    pub fn motion(&self, number: u64, position: Vec3) -> Motion {
        // Of the number's digits the series after this one have the lower ones.
        let counts = self.series.iter().map(|series| u64::from(series.count));
        let mut below = counts.fold(1, u64::saturating_mul);
        let listed = self.at.get((number / below.max(1)) as usize);
        let mut steps = listed.map_or(Affine::IDENTITY, |&shift| Affine::translate(shift));
        for series in &self.series {
            let count = u64::from(series.count);
            below /= count.max(1);
            let digits = number / below.max(1);
            let i = match series.pattern {
                // Others for each turn of what stands above it.
                Pattern::Scatter { .. } => digits,
                _ => digits % count.max(1),
            };
            steps = series.pattern.step(i).after(&steps);
        }
        match &self.variation {
            None => Motion { map: steps, scale: 1.0 },
            Some(variation) => {
                let own = variation.motion(number, position);
                Motion { map: steps.after(&own.map), scale: own.scale }
            }
        }
    }
}

impl Pattern {
    fn step(&self, i: u64) -> Affine {
        match *self {
            Self::Row { step } => Affine::translate(step * i as f64),
            Self::Ring { center, axis, turn } => {
                about(center, &Affine::rotate(axis, i as f64 * turn))
            }
            Self::Scatter { area, seed } => {
                let mut random = Random::new(seed, i);
                Affine::translate(match area {
                    Area::Box(size) => random.between(size * -0.5, size * 0.5),
                    Area::Disk(radius) => {
                        let (distance, angle) = (random.number().sqrt(), random.angle());
                        Vec3::new(angle.cos(), angle.sin(), 0.0) * (radius * distance)
                    }
                })
            }
        }
    }
}

impl Variation {
    fn motion(&self, number: u64, position: Vec3) -> Motion {
        let mut random = Random::new(self.seed, number);
        let shift = random.between(self.shift * -1.0, self.shift);
        let turn = self.turn * (2.0 * random.number() - 1.0);
        let (towards, tilt) = (random.angle(), self.tilt * random.number());
        let [least, most] = self.scale;
        let scale = least + (most - least) * random.number();
        let mut own = Affine::scale(Vec3::splat(scale));
        if turn != 0.0 {
            own = Affine::rotate(Vec3::Z, turn).after(&own);
        }
        if tilt != 0.0 {
            let level = Vec3::new(towards.cos(), towards.sin(), 0.0);
            own = Affine::rotate(level, tilt).after(&own);
        }
        Motion { map: Affine::translate(shift).after(&about(position, &own)), scale }
    }
}

fn about(center: Vec3, map: &Affine) -> Affine {
    let back = Affine::translate(Vec3::ZERO - center);
    Affine::translate(center).after(&map.after(&back))
}

/// Numbers that depend on a seed and the number of a copy: SplitMix64 (Steele, Lea, Flood 2014,
/// "Fast Splittable Pseudorandom Number Generators"), started where both have been mixed.
struct Random(u64);

impl Random {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

    fn new(seed: u64, number: u64) -> Self {
        Self(mixed(mixed(seed.wrapping_add(Self::STEP)) ^ number.wrapping_mul(Self::STEP)))
    }

    /// From 0 to 1.
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(Self::STEP);
        (mixed(self.0) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn angle(&mut self) -> f64 {
        core::f64::consts::TAU * self.number()
    }

    fn between(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        let mut along = |i: usize| low[i] + (high[i] - low[i]) * self.number();
        let (x, y, z) = (along(0), along(1), along(2));
        Vec3::new(x, y, z)
    }
}

fn mixed(x: u64) -> u64 {
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_counted_as_an_odometer_counts() {
        let row = |count, step| Series { count, pattern: Pattern::Row { step } };
        let copies = Copies {
            at: vec![Vec3::ZERO, Vec3::Z],
            series: vec![row(2, Vec3::Y), row(3, Vec3::X)],
            variation: None,
        };
        assert_eq!(copies.count(), 12);
        let places: Vec<_> =
            (0..12).map(|i| copies.motion(i, Vec3::ZERO).map.translation).collect();
        let expected =
            (0..12).map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3 % 2), f64::from(i / 6)));
        assert_eq!(places, expected.collect::<Vec<_>>());
        assert_eq!(Copies::default().motion(0, Vec3::X).map, Affine::IDENTITY);
    }

    #[test]
    fn scattered_copies_fill_their_area_evenly() {
        let scatter = |area, seed| Copies {
            series: vec![Series { count: 40_000, pattern: Pattern::Scatter { area, seed } }],
            ..Copies::default()
        };
        let places = |copies: Copies| -> Vec<Vec3> {
            (0..40_000).map(|i| copies.motion(i, Vec3::ZERO).map.translation).collect()
        };
        let size = Vec3::new(2.0, 4.0, 0.0);
        let in_box = places(scatter(Area::Box(size), 1));
        let mut quarters = [0_i32; 4];
        for p in &in_box {
            assert!(p.x.abs() <= 1.0 && p.y.abs() <= 2.0 && p.z == 0.0);
            quarters[usize::from(p.x > 0.0) + 2 * usize::from(p.y > 1.0)] += 1;
        }
        // Binomial: one part in a hundred is more than five standard deviations.
        for (found, expected) in quarters.into_iter().zip([15_000, 15_000, 5_000, 5_000]) {
            assert!((found - expected).abs() < 500, "{quarters:?}");
        }
        let on_disk = places(scatter(Area::Disk(3.0), 1));
        assert!(on_disk.iter().all(|p| p.length() <= 3.0 && p.z == 0.0));
        let inner = on_disk.iter().filter(|p| p.length() < 1.5).count();
        assert!(inner.abs_diff(10_000) < 500, "{inner}");
        assert_ne!(places(scatter(Area::Disk(3.0), 2)), on_disk);
    }

    #[test]
    fn variations_keep_to_their_limits_and_turn_about_the_object() {
        let variation = Variation {
            shift: Vec3::new(0.1, 0.0, 0.0),
            turn: 0.3,
            tilt: 0.2,
            scale: [0.5, 2.0],
            seed: 7,
        };
        let copies = Copies { variation: Some(variation), ..Copies::default() };
        let place = Vec3::new(5.0, -3.0, 1.0);
        let [mut smallest, mut largest, mut steepest] = [f64::INFINITY, 0.0, 0.0_f64];
        for i in 0..2000 {
            let motion = copies.motion(i, place);
            let moved = motion.map.point(place) - place;
            assert!(moved.x.abs() <= 0.1 + 1e-14 && moved.y.abs() < 1e-14 && moved.z.abs() < 1e-14);
            let up = motion.map.vector(Vec3::Z);
            assert!((up.length() - motion.scale).abs() < 1e-14);
            assert!((motion.map.determinant() - motion.scale.powi(3)).abs() < 1e-13);
            steepest = steepest.max((up.z / motion.scale).min(1.0).acos());
            smallest = motion.scale.min(smallest);
            largest = motion.scale.max(largest);
        }
        assert!((0.5..0.51).contains(&smallest) && (1.99..=2.0).contains(&largest));
        assert!((0.19..0.2 + 1e-12).contains(&steepest), "{steepest}");
    }
}

//! Reproducible random numbers, lines and profiles.

use rondure::{Profile, Ray, Vec3};

/// Less than the last place of any number near 1: beside such a number it vanishes, beside 0 it is all
/// there is.
const TINY: f64 = 1e-17;

/// SplitMix64 (Steele, Lea, Flood 2014): small, and good enough to scatter test rays.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator; equal seeds give equal numbers.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2f64.powi(-53)
    }

    /// A number in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A whole number below n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A point of the cube [-1, 1)^3.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0))
    }

    /// A direction, uniform on the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if (0.01..=1.0).contains(&v.length_squared()) {
                return v.normalized();
            }
        }
    }

    /// A line that passes an object of this centre and size, and hits it more often than not.
    pub fn line(&mut self, center: Vec3, size: f64) -> Ray {
        let target = center + self.cube() * (0.6 * size);
        let direction = self.direction();
        let origin = target + direction * (-size * self.within(0.0, 4.0));
        Ray::line(origin, direction * self.within(0.5, 2.0))
    }

    /// A number that breaks things: zero, a power of two, a neighbour of one of `near` by a few units
    /// in the last place, or tiny.
    pub fn awkward(&mut self, near: &[f64]) -> f64 {
        let base = near[self.below(near.len())];
        match self.below(6) {
            0 => 0.0,
            1 => 2f64.powi(self.below(12) as i32 - 8),
            2 | 3 => {
                let steps = (self.below(9) as u64).wrapping_sub(4);
                let moved = f64::from_bits(base.to_bits().wrapping_add(steps));
                if base == 0.0 || !moved.is_finite() { base } else { moved }
            }
            4 => base,
            _ => base + TINY * self.within(-1.0, 1.0),
        }
    }

    /// A random profile of lines, quadratics, cubics and arcs at r >= 0: open, closed or touching the
    /// axis, folding back and crossing itself as it likes. Now and then a radius or height is awkward.
    pub fn profile(&mut self) -> Profile {
        loop {
            if let Ok(profile) = self.attempt() {
                return profile;
            }
        }
    }

    fn attempt(&mut self) -> Result<Profile, rondure::ProfileError> {
        let mut heights = vec![0.0, 1.0];
        let mut radii = vec![0.5, 1.0];
        let awkwardness = if self.below(3) == 0 { 3 } else { 1000 };
        let mut point = |this: &mut Self| {
            let odd = this.below(awkwardness) == 0;
            let r = if odd { this.awkward(&radii).abs() } else { this.within(0.0, 1.0) };
            let z = if odd { this.awkward(&heights) } else { this.within(-1.0, 1.0) };
            radii.push(r);
            heights.push(z);
            [r, z]
        };
        let [r, z] = point(self);
        let on_axis = self.below(2) == 0;
        let mut path = Profile::builder().move_to(if on_axis { 0.0 } else { r }, z);
        let count = 1 + self.below(5);
        for i in 0..count {
            let [mut r, z] = point(self);
            if i + 1 == count && on_axis && self.below(2) == 0 {
                r = 0.0;
            }
            path = match self.below(4) {
                0 => path.line_to(r, z),
                1 => path.quad_to(point(self), r, z),
                2 => path.cubic_to(point(self), point(self), r, z),
                _ => {
                    let radii = [self.within(0.2, 1.5), self.within(0.2, 1.5)];
                    let radii = if self.below(2) == 0 { [radii[0]; 2] } else { radii };
                    let (large, sweep) = (self.below(2) == 0, self.below(2) == 0);
                    path.arc_to(radii, self.within(-1.0, 1.0), large, sweep, r, z)
                }
            };
        }
        if self.below(2) == 0 { path.close() } else { path }.build()
    }
}

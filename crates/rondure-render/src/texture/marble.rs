//! Marble: veins along sheets that turbulence has folded (Perlin 1985, "An Image Synthesizer").

use rondure::Vec3;
use rondure_scene::Marble as Described;

use super::{
    Spot,
    noise::{random, turbulence},
};
use crate::color::Rgb;

/// Marble, ready to be looked up.
#[derive(Clone, Debug)]
pub(crate) struct Marble {
    ground: Rgb,
    vein: Rgb,
    per_size: f64,
    across: Vec3,
    turbulence: f64,
    sharpness: f64,
    seed: Option<u32>,
}

/// The octaves of the folds: the finest are a hundredth of the distance of veins.
const OCTAVES: u32 = 7;

impl Marble {
    pub(super) fn new(marble: &Described) -> Self {
        let [ground, vein] = marble.colors.map(Rgb::from);
        Self {
            ground,
            vein,
            per_size: 1.0 / marble.size,
            across: marble.across,
            turbulence: marble.turbulence,
            sharpness: marble.sharpness,
            seed: marble.seed,
        }
    }

    pub(super) fn at(&self, spot: &Spot) -> Rgb {
        let mut p = spot.point * self.per_size;
        let mut seed = 0;
        if let Some(own) = self.seed {
            seed = spot.seed(own);
            p += Vec3::new(random(1, seed), random(2, seed), random(3, seed)) * 1000.0;
        }
        let fold = self.turbulence * turbulence(p * 0.8, OCTAVES, seed);
        let main = self.vein_at(p.dot(self.across) + fold);
        // Fine ones between them, at a slant and half as dark.
        let slant = Vec3::new(self.across.y, self.across.z, -self.across.x);
        let fine = self.vein_at(2.3 * p.dot(slant) + 1.7 * fold).powi(2);
        // Clouds in the ground.
        let cloud = 0.5 + 0.25 * turbulence(p * 0.5, 3, seed.wrapping_add(31));
        let ground = self.ground.mix(self.vein, 0.16 * cloud.clamp(0.0, 1.0));
        ground.mix(self.vein, (main + 0.35 * fine * (1.0 - main)).clamp(0.0, 1.0))
    }

    /// 1 in the middle of a vein, 0 half way to the next: a triangle, to the power of the sharpness.
    fn vein_at(&self, x: f64) -> f64 {
        (2.0 * (x - x.floor()) - 1.0).abs().powf(self.sharpness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn veins_are_dark_sheets_a_size_apart() {
        let marble = Marble::new(&Described {
            colors: [[1.0; 3], [0.0; 3]],
            size: 0.5,
            across: Vec3::Z,
            turbulence: 0.0,
            sharpness: 8.0,
            seed: None,
        });
        let at = |x, z| marble.at(&Spot { point: Vec3::new(x, 0.0, z), ..Spot::default() }).g;
        for i in 0..5 {
            assert_eq!(at(0.1, 0.5 * f64::from(i)), 0.0, "a vein");
            assert!(at(0.11, 0.5 * f64::from(i) + 0.25) > 0.5, "the ground");
        }
    }
}

//! What photons and chance count where both find the same light: from a lamp by mirrors and glass to a glossy place
//! (Georgiev et al. 2012, "Light Transport Simulation with Vertex Connection and Merging"; Hachisuka et al. 2012, "A
//! Path Space Extension for Robust Light Transport Simulation").
//!
//! A path from the eye goes on from the place with the density p by solid angle, and the pixel takes n samples; of the
//! photons of the pass, D by area across their way and solid angle, those within the radius r are seen. Of the two,
//! `n p` and `pi r^2 cos D`,
//! each counts by its square (Veach's power heuristic). Mirrors and glass leave D as it is at the lamp (etendue is kept),
//! and what chooses between reflection and refraction is the same both ways; where that does not hold, by rough metal,
//! weights are less good, but still add up to one: so the mean is right in any case.
//!
//! Of p only what is above even scattering counts. Matte places are left to the photons: chance would find small
//! lamps rarely there, and show them as sparks.

use core::f64::consts::{FRAC_1_PI, PI};

use crate::coat::power_heuristic;

/// What chance counts: n p / (pi r^2 cos), to be compared with D.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chance(f64);

impl Chance {
    /// Where there are no photons.
    pub(crate) const NONE: Self = Self(0.0);

    #[inline]
    pub(crate) fn is_none(self) -> bool {
        self.0 == 0.0
    }

    /// For a place from which paths go on with a density by solid angle, and so many samples.
    #[inline]
    pub(crate) fn new(pdf: f64, samples: f64, cos: f64, radius: f64) -> Self {
        let peak = (pdf - FRAC_1_PI).max(0.0);
        Self(if peak > 0.0 { samples * peak / (PI * radius * radius * cos) } else { 0.0 })
    }

    /// The weight of what chance finds where photons are so dense: none of what it can't find, all where none go.
    #[inline]
    pub(crate) fn weight(self, density: f64) -> f64 {
        if density > 0.0 { 1.0 - of_photon(density, self) } else { 1.0 }
    }
}

/// The weight of a photon.
#[inline]
pub(crate) fn of_photon(density: f64, chance: Chance) -> f64 {
    if chance.is_none() { 1.0 } else { power_heuristic(density, chance.0) }
}

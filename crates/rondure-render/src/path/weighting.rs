//! What the two ways to find light count: looking for the light, and chance, the path itself meeting it.

use crate::coat::power_heuristic;

/// The weights of both ways. In the tests each can be left alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Weighting {
    /// Veach's power heuristic.
    #[default]
    Both,
    #[cfg(test)]
    LookedFor,
    #[cfg(test)]
    Chance,
}

impl Weighting {
    /// The weight of light that was looked for with one density, and that chance finds with another.
    #[inline]
    pub(crate) fn of_looking(self, looking: f64, chance: f64) -> f64 {
        match self {
            Self::Both => power_heuristic(looking, chance),
            #[cfg(test)]
            Self::LookedFor => 1.0,
            // What cannot be met must be looked for.
            #[cfg(test)]
            Self::Chance => f64::from(u8::from(looking == f64::INFINITY)),
        }
    }

    /// The weight of light that was met by chance.
    #[inline]
    pub(crate) fn of_chance(self, chance: f64, looking: f64) -> f64 {
        match self {
            Self::Both => power_heuristic(chance, looking),
            #[cfg(test)]
            Self::LookedFor => f64::from(u8::from(chance == f64::INFINITY)),
            #[cfg(test)]
            Self::Chance => 1.0,
        }
    }
}

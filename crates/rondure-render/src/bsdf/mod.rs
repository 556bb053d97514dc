//! What surfaces do with light, for the path tracer: how much goes from one direction into another
//! (the bidirectional scattering distribution function), and directions chosen in proportion to it.
//!
//! `ggx` has the microfacets, `albedo` the tables of what lobes reflect in all, `layered` opaque things
//! under coats and fuzz, `boundary` the surfaces of glass, `metal` reflectances, `spectrum` dispersion.
//!
//! Lobes are of two [`Kind`]s. Light that went through narrow ones alone, after it left a lamp and before
//! it meets a wide one, makes caustics; those are found from the lamps ([`crate::path::photons`]),
//! all other light from the eye. For that the two kinds are chosen between first, and never mixed.
//!
//! Directions are in the frame of the surface: z is the normal, on the viewer's side. Radiance is divided
//! by the square of the index of the medium it is in (basic radiance), which boundaries leave as it is.

mod albedo;
mod boundary;
mod ggx;
mod layered;
mod metal;
mod spectrum;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use rondure::Vec3;

pub(crate) use boundary::{Boundary, Roughness, Smooth};
pub(crate) use ggx::Ggx;
pub(crate) use layered::{Facing, Fuzz, Gloss, Layered, Layers};
pub(crate) use metal::Metal;
pub(crate) use spectrum::{Dispersion, Wavelength};

use crate::color::Rgb;

/// The widest microfacet distribution that counts as narrow: its lobe is some five degrees wide. In wider ones
/// light that glass has gathered would be found too rarely.
const NARROW_ALPHA: f64 = 0.05;

/// Whether a lobe can be lit by the lamps' photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Wide,
    Narrow,
}

/// What comes from one direction by the lobes of one kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Part {
    /// The value of the lobes times the cosine.
    pub(crate) value: Rgb,
    /// The density by solid angle with which [`Facing::sample`] or [`Boundary::sample`] chooses this
    /// direction by a lobe of this kind.
    pub(crate) pdf: f64,
}

/// The parts of both kinds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Parts {
    pub(crate) wide: Part,
    pub(crate) narrow: Part,
}

impl Parts {
    fn of(&self, kind: Kind) -> &Part {
        match kind {
            Kind::Wide => &self.wide,
            Kind::Narrow => &self.narrow,
        }
    }

    fn add(&mut self, kind: Kind, value: Rgb, pdf: f64) {
        let part = match kind {
            Kind::Wide => &mut self.wide,
            Kind::Narrow => &mut self.narrow,
        };
        part.value += value;
        part.pdf += pdf;
    }
}

/// A direction that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scatter {
    pub(crate) direction: Vec3,
    /// The value of the lobes of its kind times the cosine, over the density.
    pub(crate) weight: Rgb,
    /// The density by solid angle; infinite for a perfect mirror or clear glass.
    pub(crate) pdf: f64,
    pub(crate) kind: Kind,
}

/// A lobe of microfacets, or a perfect one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lobe {
    Smooth,
    Rough(Ggx),
}

impl Lobe {
    /// Below this width alpha a lobe is narrower than a pixel of a picture 1000 pixels wide at 60 degrees.
    const SMOOTH_ALPHA: f64 = 1e-3;

    /// `roughness` is the root of the width alpha.
    pub(crate) fn new(roughness: f64) -> Self {
        let alpha = roughness.clamp(0.0, 1.0).powi(2);
        if alpha < Self::SMOOTH_ALPHA { Self::Smooth } else { Self::Rough(Ggx { alpha }) }
    }

    pub(crate) fn kind(self) -> Kind {
        match self {
            Self::Rough(Ggx { alpha }) if alpha > NARROW_ALPHA => Kind::Wide,
            _ => Kind::Narrow,
        }
    }
}

//! Materials made ready: colours looked up fast, the coat's tables built.

use rondure_scene::{Glass, Material};

use crate::{bsdf::Metal, coat::Coat, color::Rgb, texture::Pattern};

/// What a surface does with light.
#[derive(Clone, Debug)]
pub(crate) enum Finish {
    Matte {
        color: Pattern,
    },
    Glossy {
        color: Pattern,
        coat: Coat,
    },
    Mirror {
        color: Pattern,
    },
    Glass {
        /// The absorption coefficient by channel, per scene unit.
        absorption: Rgb,
        ior: f64,
    },
}

impl Finish {
    pub(crate) fn new(material: &Material) -> Self {
        match material {
            Material::Matte { color } => Self::Matte { color: Pattern::new(color) },
            Material::Glossy { color, specular, roughness } => {
                Self::Glossy { color: Pattern::new(color), coat: Coat::new(*specular, *roughness) }
            }
            Material::Mirror { color } => Self::Mirror { color: Pattern::new(color) },
            Material::Glass(glass) => Self::glass(glass),
            Material::Metal { eta, k, .. } => {
                let metal = Metal::Measured { eta: (*eta).into(), k: (*k).into() };
                Self::Mirror { color: Pattern::Solid(metal.reflectance(1.0, Rgb::WHITE)) }
            }
            // The nearest of the others: this is for quick looks.
            Material::Principled(p) if p.transmission_weight * (1.0 - p.base_metalness) >= 0.5 => {
                Self::glass(&p.transmission)
            }
            Material::Principled(p) if p.base_metalness >= 0.5 => {
                Self::Mirror { color: Pattern::new(&p.base_color) }
            }
            Material::Principled(p) => {
                let (specular, roughness) = if p.coat_weight > 0.5 {
                    (p.coat_weight, p.coat_roughness)
                } else {
                    (p.specular_weight, p.specular_roughness)
                };
                Self::Glossy {
                    color: Pattern::new(&p.base_color),
                    coat: Coat::new(specular, roughness),
                }
            }
        }
    }

    fn glass(glass: &Glass) -> Self {
        Self::Glass {
            // A channel of 0 lets nothing through; its logarithm must stay finite, so that
            // nothing is absorbed on a way of length 0.
            absorption: Rgb::from(glass.color).map(|c| -c.clamp(f64::MIN_POSITIVE, 1.0).ln()),
            ior: glass.ior,
        }
    }

    /// The pattern that it is coloured by.
    #[inline]
    pub(crate) fn color(&self) -> &Pattern {
        match self {
            Self::Matte { color } | Self::Glossy { color, .. } | Self::Mirror { color } => color,
            Self::Glass { .. } => &Pattern::Solid(Rgb::WHITE),
        }
    }

    pub(crate) fn is_clear(&self) -> bool {
        matches!(self, Self::Glass { .. })
    }
}

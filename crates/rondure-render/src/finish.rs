//! Materials made ready: colours looked up fast, the coat's tables built.

use rondure_scene::Material;

use crate::{coat::Coat, color::Rgb, texture::Pattern};

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
            Material::Glass { color, ior } => Self::Glass {
                // A channel of 0 lets nothing through; its logarithm must stay finite, so that
                // nothing is absorbed on a way of length 0.
                absorption: Rgb::from(*color).map(|c| -c.clamp(f64::MIN_POSITIVE, 1.0).ln()),
                ior: *ior,
            },
        }
    }

    pub(crate) fn is_clear(&self) -> bool {
        matches!(self, Self::Glass { .. })
    }
}

//! Materials made ready: colours looked up fast, the coat's tables built.

use rondure_scene::{Material, Paint};

use crate::{coat::Coat, color::Rgb};

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

/// A colour over a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pattern {
    Solid(Rgb),
    Checker { colors: [Rgb; 2], per_unit: [f64; 2] },
}

impl Pattern {
    fn new(paint: &Paint) -> Self {
        match *paint {
            Paint::Solid(color) => Self::Solid(color.into()),
            Paint::Checker { colors, size } => {
                Self::Checker { colors: colors.map(Rgb::from), per_unit: size.map(|s| 1.0 / s) }
            }
        }
    }

    #[inline]
    pub(crate) fn at(&self, uv: [f64; 2]) -> Rgb {
        match *self {
            Self::Solid(color) => color,
            Self::Checker { colors, per_unit } => {
                let square = (uv[0] * per_unit[0]).floor() + (uv[1] * per_unit[1]).floor();
                let odd = square.rem_euclid(2.0) == 1.0;
                colors[usize::from(odd)]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_alternate_across_zero() {
        let paint = Paint::Checker { colors: [[0.0; 3], [1.0; 3]], size: [0.5, 2.0] };
        let pattern = Pattern::new(&paint);
        for (uv, expected) in [
            ([0.1, 0.1], 0.0),
            ([-0.1, 0.1], 1.0),
            ([-0.1, -0.1], 0.0),
            ([0.6, 1.9], 1.0),
            ([0.6, 2.1], 0.0),
        ] {
            assert_eq!(pattern.at(uv).r, expected, "{uv:?}");
        }
    }
}

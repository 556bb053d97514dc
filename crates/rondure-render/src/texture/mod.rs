//! Colours over surfaces.

use rondure_scene::Paint;

use crate::color::Rgb;

/// A colour over a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pattern {
    Solid(Rgb),
    Checker { colors: [Rgb; 2], per_unit: [f64; 2] },
}

impl Pattern {
    pub(crate) fn new(paint: &Paint) -> Self {
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

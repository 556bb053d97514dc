//! White balance: the light of which colour shall look white.
//!
//! The colour is given as for cameras: a temperature on the locus of daylight (CIE 15, from 4000 K up) or of black bodies (Krystek 1985,
//! below), and a tint across it. It is brought to D65 by von Kries' scaling of the cone responses of CAT16 (Li et al. 2017).

use crate::matrix::{self, Matrix};

/// A colour of light that shall look white, adapted to fully.
#[derive(Clone, Debug, PartialEq)]
pub struct White {
    adaptation: Matrix,
}

/// Why a colour of light cannot be adapted to.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WhiteError {
    /// Outside the range that the loci are known for.
    #[error("a white balance is from {COLDEST} to {HOTTEST} kelvin, not {0}")]
    Temperature(f64),
    /// Too far from the loci.
    #[error("a tint is from -{TINTS} to {TINTS}, not {0}")]
    Tint(f64),
    /// The tint leads out of what is a colour, which happens to warm light.
    #[error("no light of {temperature} kelvin has a tint of {tint}")]
    NoLight {
        /// In kelvin.
        temperature: f64,
        /// In steps of 1/3000.
        tint: f64,
    },
}

const COLDEST: f64 = 1000.0;
const HOTTEST: f64 = 25_000.0;
const TINTS: f64 = 150.0;
/// Where daylight begins.
const DAYLIGHT: f64 = 4000.0;
/// One step of tint in the (u, v) of CIE 1960, as in Adobe's DNG.
const TINT: f64 = 1.0 / 3000.0;

const CAT16: Matrix = [
    [0.401_288, 0.650_173, -0.051_461],
    [-0.250_268, 1.204_414, 0.045_854],
    [-0.002_079, 0.048_952, 0.953_127],
];
/// Linear Rec. 709 to CIE XYZ (IEC 61966-2-1 in f64).
const TO_XYZ: Matrix = [
    [0.412_390_799_265_959_5, 0.357_584_339_383_877_96, 0.180_480_788_401_834_3],
    [0.212_639_005_871_510_36, 0.715_168_678_767_755_9, 0.072_192_315_360_733_71],
    [0.019_330_818_715_591_85, 0.119_194_779_794_625_99, 0.950_532_152_249_660_6],
];

impl White {
    /// The smallest and the largest temperature, in kelvin.
    pub const TEMPERATURES: [f64; 2] = [COLDEST, HOTTEST];
    /// The largest tint, either way.
    pub const TINTS: f64 = TINTS;

    /// Light of this colour temperature in kelvin (6504 is the white of sRGB, lamps have 2700 to 3000, shade 7500). A
    /// `tint` above 0 says that it is greener than its temperature has it, so that the picture becomes more magenta, in steps of
    /// 1/3000 in the (u, v) of CIE 1960.
    ///
    /// # Errors
    /// If the temperature is not from 1000 to 25000, or the tint not from -150 to 150.
    pub fn new(temperature: f64, tint: f64) -> Result<Self, WhiteError> {
        if !(COLDEST..=HOTTEST).contains(&temperature) {
            return Err(WhiteError::Temperature(temperature));
        }
        if !(-TINTS..=TINTS).contains(&tint) {
            return Err(WhiteError::Tint(tint));
        }
        // The tint goes along the normal of the locus, towards green: larger v.
        let (a, b) = (locus(temperature * 0.999), locus(temperature * 1.001));
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0].hypot(along[1]);
        let middle = locus(temperature);
        let u = middle[0] + tint * TINT * along[1] / length;
        let v = middle[1] - tint * TINT * along[0] / length;
        let cones = |xyz| matrix::apply(&CAT16, xyz);
        let from = cones(xyz([u, v]));
        if !from.iter().all(|v| *v > 0.0) {
            return Err(WhiteError::NoLight { temperature, tint });
        }
        let to = cones(TO_XYZ.map(|row| row.iter().sum()));
        let scaling = matrix::diagonal([0, 1, 2].map(|i| to[i] / from[i]));
        let into = matrix::product(&CAT16, &TO_XYZ);
        let back = matrix::inverse(&into);
        Ok(Self { adaptation: matrix::product(&back, &matrix::product(&scaling, &into)) })
    }

    /// The matrix on linear Rec. 709 that makes this light white.
    pub(crate) fn adaptation(&self) -> &Matrix {
        &self.adaptation
    }
}

/// White is white: nothing is adapted.
impl Default for White {
    fn default() -> Self {
        Self { adaptation: matrix::diagonal([1.0; 3]) }
    }
}

/// The colour of daylight or of a black body, as (u, v) of CIE 1960.
fn locus(t: f64) -> [f64; 2] {
    if t < DAYLIGHT {
        let u = (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
            / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t);
        let v = (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
            / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t);
        return [u, v];
    }
    let r = 1000.0 / t;
    let x = if t <= 7000.0 {
        0.244_063 + r * (0.099_11 + r * (2.967_8 - r * 4.607))
    } else {
        0.237_04 + r * (0.247_48 + r * (1.901_8 - r * 2.006_4))
    };
    let y = -3.0 * x * x + 2.87 * x - 0.275;
    let d = -2.0 * x + 12.0 * y + 3.0;
    [4.0 * x / d, 6.0 * y / d]
}

/// (u, v) of CIE 1960 as XYZ with Y = 1.
fn xyz([u, v]: [f64; 2]) -> [f64; 3] {
    [1.5 * u / v, 1.0, (4.0 - u - 10.0 * v) / (2.0 * v)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xy([u, v]: [f64; 2]) -> [f64; 2] {
        let d = 2.0 * u - 8.0 * v + 4.0;
        [3.0 * u / d, 2.0 * v / d]
    }

    /// Illuminants A, D50 and D65 of CIE 15.
    #[test]
    fn known_lights() {
        for (t, x, y) in [
            (2856.0, 0.447_57, 0.407_45),
            (5003.0, 0.345_67, 0.358_50),
            (6504.0, 0.312_72, 0.329_03),
        ] {
            let place = xy(locus(t));
            assert!((place[0] - x).abs() < 4e-4 && (place[1] - y).abs() < 4e-4, "{t}: {place:?}");
        }
        let [x, y, z] = xyz(locus(2856.0));
        assert!((x - 1.098_5).abs() < 2e-3 && y == 1.0 && (z - 0.355_85).abs() < 2e-3, "{x} {z}");
    }

    /// The matrix for illuminant A of the package colour-science 0.4.7, CAT16.
    #[test]
    fn known_adaptation() {
        let known = [
            [0.950_689_405, -0.187_376_349, 0.262_790_607],
            [-0.025_665_231_1, 1.032_306_74, -0.011_559_608_9],
            [-0.002_740_638_79, 0.090_967_452_3, 2.812_626_50],
        ];
        let white = White::new(2856.0, 0.0).unwrap();
        let in_xyz = matrix::product(
            &TO_XYZ,
            &matrix::product(white.adaptation(), &matrix::inverse(&TO_XYZ)),
        );
        for (row, known) in in_xyz.iter().zip(known) {
            for (a, b) in row.iter().zip(known) {
                assert!((a - b).abs() < 5e-3 * (1.0 + b.abs()), "{in_xyz:?}");
            }
        }
    }

    #[test]
    fn that_light_becomes_white() {
        for (t, tint) in
            [(1500.0, 0.0), (2700.0, -20.0), (3999.0, 10.0), (5000.0, 5.0), (20_000.0, -50.0)]
        {
            let white = White::new(t, tint).unwrap();
            let (before, after) = (locus(t * 0.999), locus(t * 1.001));
            let (du, dv) = (after[0] - before[0], after[1] - before[1]);
            let at = locus(t);
            let shift = tint / 3000.0 / du.hypot(dv);
            let light = matrix::apply(
                &matrix::inverse(&TO_XYZ),
                xyz([at[0] + shift * dv, at[1] - shift * du]),
            );
            for v in matrix::apply(white.adaptation(), light) {
                assert!((v - 1.0).abs() < 1e-12, "{t} {tint}");
            }
        }
    }

    #[test]
    fn daylight_is_white_already() {
        let white = White::new(6504.0, 0.0).unwrap();
        for (i, row) in white.adaptation().iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                assert!((v - f64::from(u8::from(i == j))).abs() < 2e-3);
            }
        }
    }

    #[test]
    fn warm_light_is_cooled_and_tint_takes_green_out() {
        let grey = |white: White| matrix::apply(white.adaptation(), [0.5; 3]);
        let [r, _, b] = grey(White::new(3000.0, 0.0).unwrap());
        assert!(b > 0.5 && r < 0.5);
        let [r, g, b] = grey(White::new(6504.0, 30.0).unwrap());
        assert!(g < r && g < b);
    }

    #[test]
    fn what_is_no_light_is_refused() {
        for (t, tint) in
            [(999.0, 0.0), (25_001.0, 0.0), (f64::NAN, 0.0), (5000.0, 151.0), (5000.0, f64::NAN)]
        {
            assert!(White::new(t, tint).is_err(), "{t} {tint}");
        }
        assert_eq!(
            White::new(1500.0, 100.0),
            Err(WhiteError::NoLight { temperature: 1500.0, tint: 100.0 })
        );
    }
}

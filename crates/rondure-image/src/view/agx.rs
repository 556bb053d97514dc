//! AgX (Troy Sobotka 2023, "SB2383 Configuration Generation"), in the form that Blender 4 ships (Eary Chow 2023,
//! "AgX_LUT_Gen", AgX Base sRGB), without a table.
//!
//! Light goes into a narrower set of primaries (inset), each channel through a sigmoid of its logarithm, and out again (outset).
//! Bright light so goes over into white; the turn that this gives hues is taken back by three fifths. Middle grey, 0.18, stays 0.18.

use crate::matrix::{self, Matrix};

const FROM_709: Matrix = [
    [0.627_401_924_722_236_4, 0.329_291_971_755_001_7, 0.043_306_103_522_762_33],
    [0.069_095_489_739_260_87, 0.919_544_281_267_395, 0.011_360_228_993_344_3],
    [0.016_393_709_088_163_21, 0.088_028_162_397_900_6, 0.895_578_128_513_936_3],
];
const TO_709: Matrix = [
    [1.660_496_219_147_829, -0.587_656_444_131_135_4, -0.072_839_775_016_694_22],
    [-0.124_547_095_586_012, 1.132_895_109_247_296_3, -0.008_348_013_661_284_43],
    [-0.018_153_681_387_071_87, -0.100_597_371_685_742_45, 1.118_751_053_072_814],
];
/// From Rec. 2020 to its primaries turned by (2.13976149, -1.22827335, -3.05174246) degrees and drawn towards
/// white by (0.32965205, 0.28051336, 0.12475368).
const INSET: Matrix = [
    [0.856_627_156_288_779_2, 0.095_121_245_402_534_9, 0.048_251_598_308_685_8],
    [0.137_318_972_283_551_67, 0.761_241_987_009_080_6, 0.101_439_040_707_367_48],
    [0.111_898_208_045_179_53, 0.076_799_414_562_517_57, 0.811_302_377_392_303],
];
/// Back to Rec. 2020 from its primaries drawn towards white by (0.32317438, 0.28325605, 0.0374326).
const OUTSET: Matrix = [
    [1.127_100_569_630_12, -0.110_606_638_578_260_65, -0.016_493_931_051_859_02],
    [-0.141_329_754_421_353_37, 1.157_823_685_473_212_7, -0.016_493_931_051_859_02],
    [-0.141_329_754_421_353_26, -0.110_606_638_578_260_6, 1.251_936_392_999_614],
];
/// Luminance of Rec. 2020, after the colour matching functions of CIE 2015.
const LUMINANCE: [f64; 3] =
    [0.258_923_535_568_984_8, 0.610_498_534_606_652_5, 0.130_577_929_824_362_84];

const GREY: f64 = 0.18;
/// The stops below and above middle grey that the sigmoid takes in.
const STOPS: [f64; 2] = [-10.0, 6.5];
/// The power of the sigmoid's values.
const GAMMA: f64 = 2.4;
/// The share of the hue that the sigmoid gave.
const TURN: f64 = 0.4;

/// The light on the screen; some channels may lie beyond 1.
pub(super) fn form(light: [f64; 3]) -> [f64; 3] {
    let light = light.map(|v| if v.is_nan() { 0.0 } else { v.clamp(-1e30, 1e30) });
    let wide = lift(matrix::apply(&FROM_709, light), LUMINANCE, |_| 0.0);
    let inset = matrix::apply(&INSET, wide);
    let formed = inset.map(|v| sigmoid(v).powf(GAMMA));
    let turned = Hue::of(inset).mix(&Hue::of(formed), TURN).given_to(formed);
    let narrow = matrix::apply(&TO_709, matrix::apply(&OUTSET, turned));
    let luminance = [0, 1, 2].map(|j| matrix::dot(LUMINANCE, FROM_709.map(|row| row[j])));
    // As it stands, the correction would raise pure greens too much; it fades out towards light ones.
    lift(narrow, luminance, |y| y.max(0.0).powf(0.08).min(1.0))
}

/// The sigmoid over stops: slope 2.4 at middle grey, with toe and shoulder of power 1.5 that reach 0 and 1 at the ends (Jed Smith's
/// tunable sigmoid, y = s h(k (x - x0) / s) + y0 with h(u) = u / (1 + u^p)^(1/p)). What is brighter goes a little beyond 1.
fn sigmoid(light: f64) -> f64 {
    const SLOPE: f64 = 2.4;
    const POWER: f64 = 1.5;
    let span = STOPS[1] - STOPS[0];
    let x = (((light / GREY).log2() - STOPS[0]) / span).max(0.0);
    let (x0, y0) = (-STOPS[0] / span, GREY.powf(1.0 / GAMMA));
    let side = |x: f64, width: f64, height: f64| {
        let rise = SLOPE * width;
        let scale = (rise.powf(-POWER) * ((rise / height).powf(POWER) - 1.0)).powf(-1.0 / POWER);
        let u = SLOPE * x / scale;
        scale * u / (1.0 + u.powf(POWER)).powf(1.0 / POWER)
    };
    if x < x0 {
        (y0 - side(x0 - x, x0, y0)).max(0.0)
    } else {
        y0 + side(x - x0, 1.0 - x0, 1.0 - y0)
    }
}

/// Brings negative channels up to 0 by adding white, then dims the colour to what its luminance was, the missing light of the
/// opponent colour included (Sakari Kapanen's lower guard rail). `plain` is how much the luminance alone counts.
fn lift(rgb: [f64; 3], weights: [f64; 3], plain: impl Fn(f64) -> f64) -> [f64; 3] {
    let least = rgb[0].min(rgb[1]).min(rgb[2]);
    if least >= 0.0 {
        return rgb;
    }
    let measure = |rgb: [f64; 3]| {
        let y = matrix::dot(weights, rgb);
        let most = rgb[0].max(rgb[1]).max(rgb[2]);
        let opponent = rgb.map(|v| most - v);
        let depth = opponent[0].max(opponent[1]).max(opponent[2]);
        let whole = depth - matrix::dot(weights, opponent) + y;
        let w = plain(y);
        (1.0 - w) * whole + w * y
    };
    let lifted = rgb.map(|v| v - least);
    let (before, after) = (measure(rgb), measure(lifted));
    if after > before { lifted.map(|v| v * (before / after)) } else { lifted }
}

/// The place on the colour circle, as a fraction of its length, as in HSV.
#[derive(Clone, Copy, Debug)]
struct Hue(f64);

impl Hue {
    fn of([r, g, b]: [f64; 3]) -> Self {
        let (least, most) = (r.min(g).min(b), r.max(g).max(b));
        let range = most - least;
        if range <= 0.0 {
            return Self(0.0);
        }
        let sixths = if r == most {
            (g - b) / range
        } else if g == most {
            2.0 + (b - r) / range
        } else {
            4.0 + (r - g) / range
        };
        Self((sixths / 6.0).rem_euclid(1.0))
    }

    /// The shorter way round to `other`, by the share `t` of it.
    fn mix(self, other: &Self, t: f64) -> Self {
        let way = other.0 - self.0;
        Self((self.0 + t * (way - way.round())).rem_euclid(1.0))
    }

    /// A colour of this hue with the largest and the least channel of another.
    fn given_to(self, [r, g, b]: [f64; 3]) -> [f64; 3] {
        let (least, most) = (r.min(g).min(b), r.max(g).max(b));
        let ramp = |shift: f64| {
            let place = (6.0 * self.0 + shift).rem_euclid(6.0);
            least + (most - least) * ((place - 3.0).abs() - 1.0).clamp(0.0, 1.0)
        };
        [ramp(0.0), ramp(4.0), ramp(2.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What AgX_LUT_Gen at commit of June 2025 computes for these, without its table.
    #[test]
    fn known_values() {
        let cases = [
            ([0.18; 3], [0.18; 3]),
            ([1.0; 3], [0.555_999_064_535; 3]),
            ([16.0; 3], [0.998_044_994_152; 3]),
            ([0.5, 0.4, 0.3], [0.402_552_644_500, 0.344_262_674_676, 0.289_628_486_896]),
            ([1.0, 0.0, 0.0], [0.707_942_281_159, 0.041_106_540_889, 0.015_855_485_092]),
            ([0.0, 1.0, 0.0], [0.157_045_916_711, 0.559_188_978_419, 0.083_013_735_540]),
            ([0.0, 0.0, 1.0], [0.012_641_672_497, 0.088_987_970_286, 0.649_198_046_993]),
            ([4.0, 0.2, 0.05], [0.990_013_172_972, 0.366_377_670_347, 0.287_576_421_797]),
            ([0.02, 0.1, 0.5], [0.019_828_469_378, 0.128_643_881_405, 0.436_121_086_528]),
            ([30.0, 2.0, 0.5], [1.0, 0.797_188_838_966, 0.739_835_908_806]),
        ];
        for (light, expected) in cases {
            let formed = form(light).map(|v| v.min(1.0));
            for (a, b) in formed.iter().zip(expected) {
                assert!((a - b).abs() < 1e-6, "{light:?}: {formed:?} {expected:?}");
            }
        }
    }

    #[test]
    fn sigmoid_meets_its_ends_and_its_pivot() {
        assert!(sigmoid(0.0) < 1e-15);
        assert!((sigmoid(GREY * 6.5_f64.exp2()) - 1.0).abs() < 1e-14);
        assert!((sigmoid(GREY) - GREY.powf(1.0 / GAMMA)).abs() < 1e-15);
        let h = 1e-6_f64;
        let slope = (sigmoid(GREY * h.exp2()) - sigmoid(GREY * (-h).exp2())) / (2.0 * h / 16.5);
        assert!((slope - 2.4).abs() < 1e-3, "{slope}");
    }

    #[test]
    fn hues_go_the_short_way() {
        let [r, g, b] = Hue(0.95).mix(&Hue(0.05), 0.5).given_to([0.2, 0.9, 0.5]);
        assert!((r - 0.9).abs() < 1e-12 && (g - 0.2).abs() < 1e-12 && (b - 0.2).abs() < 1e-12);
        for color in [[0.3, 0.7, 0.1], [0.9, 0.2, 0.4], [0.1, 0.15, 0.8], [0.5, 0.5, 0.2]] {
            let again = Hue::of(color).given_to(color);
            for (a, b) in color.iter().zip(again) {
                assert!((a - b).abs() < 1e-14, "{color:?} {again:?}");
            }
        }
    }

    #[test]
    fn what_is_within_is_not_lifted() {
        assert_eq!(lift([0.1, 0.0, 0.3], LUMINANCE, |_| 0.0), [0.1, 0.0, 0.3]);
        let lifted = lift([0.5, -0.1, 0.3], LUMINANCE, |_| 0.0);
        assert!(lifted.iter().all(|v| *v >= 0.0) && lifted[0] > lifted[2]);
    }
}

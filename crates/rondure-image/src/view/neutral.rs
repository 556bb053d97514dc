//! The PBR Neutral tone mapper (Khronos Group 2024, "Khronos PBR Neutral Tone Mapper Specification").
//!
//! Colours up to 0.8 are what they are but for an offset that takes the Fresnel reflection of 4 % back, so that a base colour under
//! a white light of strength 1 comes out as that colour. Brighter ones are scaled to stay below 1, and go over into
//! white the more, the more was taken.

/// The reflectance at normal incidence that is taken back.
const F90: f64 = 0.04;
/// Where compression begins.
const START: f64 = 0.8 - F90;
/// How fast compressed colours lose their saturation.
const DESATURATION: f64 = 0.15;

pub(super) fn compress(light: [f64; 3]) -> [f64; 3] {
    let light = light.map(|v| v.clamp(0.0, f64::MAX));
    let least = light[0].min(light[1]).min(light[2]);
    let offset = if least < 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = light.map(|v| v - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if !(peak >= START) {
        return color;
    }
    let d = 1.0 - START;
    let lower = 1.0 - d * d / (peak + d - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - lower) + 1.0);
    color.map(|v| v * (lower / peak) * (1.0 - white) + lower * white)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3]) {
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() < 1e-12, "{a:?} {b:?}");
        }
    }

    /// What the shader in the specification gives, worked out by hand.
    #[test]
    fn known_values() {
        close(compress([0.0; 3]), [0.0; 3]);
        // Dark: x - (x - 6.25 x^2).
        close(compress([0.04; 3]), [0.01; 3]);
        close(compress([0.5, 0.3, 0.02]), [0.4825, 0.2825, 0.0025]);
        close(compress([0.5, 0.3, 0.1]), [0.46, 0.26, 0.06]);
        // The last that is not compressed, and a grey that is: 1 - 0.24^2 / (1.96 - 0.52).
        close(compress([0.8, 0.3, 0.1]), [0.76, 0.26, 0.06]);
        close(compress([2.0; 3]), [0.96; 3]);
        // Red of strength 2.04 with 0.04 in each channel added to a clear 2: peak 2, newPeak 1 - 0.0576 / 1.48.
        let lower = 1.0 - 0.0576 / 1.48;
        let white = 1.0 - 1.0 / (0.15 * (2.0 - lower) + 1.0);
        close(compress([2.0, 0.0, 0.0]), [lower, lower * white, lower * white]);
    }

    #[test]
    fn hue_stays() {
        // The middle channel keeps its place between the least and the largest.
        for light in [[0.9, 0.5, 0.2], [3.0, 1.5, 0.3], [40.0, 13.0, 0.5]] {
            let [a, b, c] = compress(light);
            let place = |a: f64, b: f64, c: f64| (b - c) / (a - c);
            let (before, after) = (place(light[0], light[1], light[2]), place(a, b, c));
            assert!((before - after).abs() < 1e-12, "{light:?}");
        }
    }

    #[test]
    fn it_goes_on_without_a_step() {
        for x in [0.08, 0.8] {
            let (below, above) = (compress([x - 1e-9; 3]), compress([x + 1e-9; 3]));
            assert!(above[0] >= below[0] && above[0] - below[0] < 1e-8);
        }
    }
}

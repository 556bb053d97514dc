//! From linear light to the numbers in a file and back: the sRGB curve, rounding with a dither.

/// The sRGB transfer curve (IEC 61966-2-1), from linear light to a signal, both 0 to 1.
pub fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The way back: from a signal to linear light, both 0 to 1.
pub fn linear(signal: f64) -> f64 {
    if signal <= 0.040_45 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) }
}

/// A threshold between 0 and 1 for each pixel, neighbours as different as can be: the additive
/// recurrence of the plastic number in two dimensions, folded to a triangle so that it has no edge
/// (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
pub fn threshold(x: u32, y: u32) -> f64 {
    let place = 0.754_877_666_246_692_8 * f64::from(x) + 0.569_840_290_998_053_2 * f64::from(y);
    let wave = place.fract();
    let folded = if wave < 0.5 { 2.0 * wave } else { 2.0 - 2.0 * wave };
    // The fold reaches 1, at which an exact value would be raised.
    folded.min(1.0 - f64::EPSILON)
}

/// The signal as a whole number up to `max`, rounded up where its fraction exceeds 1 - `threshold`:
/// right on average over an area, where plain rounding would leave bands. Values that are whole
/// already stay what they are.
pub fn quantize(linear: f64, max: f64, threshold: f64) -> f64 {
    (srgb(linear.clamp(0.0, 1.0)) * max + threshold).floor().min(max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_has_its_known_values() {
        assert_eq!(srgb(0.0), 0.0);
        assert!((srgb(1.0) - 1.0).abs() < 1e-15);
        // Middle grey: 18 % is 46 % of the signal.
        assert!((srgb(0.18) - 0.461_356).abs() < 1e-6);
        let (below, above) = (srgb(0.003_130_8), srgb(0.003_130_9));
        assert!((below - above).abs() < 1e-5);
    }

    #[test]
    fn curve_goes_back() {
        for i in 0..=255 {
            let signal = f64::from(i) / 255.0;
            assert!((srgb(linear(signal)) - signal).abs() < 1e-7, "{signal}");
        }
    }

    #[test]
    fn dither_is_right_on_average() {
        for level in [0.001, 0.2, 0.5, 0.93] {
            let mut sum = 0.0;
            for y in 0..64 {
                for x in 0..64 {
                    sum += quantize(level, 255.0, threshold(x, y));
                }
            }
            assert!((sum / 4096.0 - 255.0 * srgb(level)).abs() < 0.02, "{level}");
        }
    }

    #[test]
    fn black_and_white_are_not_dithered() {
        for x in 0..1000 {
            assert_eq!(quantize(0.0, 255.0, threshold(x, 3)), 0.0);
            assert_eq!(quantize(1.0, 255.0, threshold(x, 3)), 255.0);
            assert_eq!(quantize(7.0, 65535.0, threshold(x, 3)), 65535.0);
        }
    }
}

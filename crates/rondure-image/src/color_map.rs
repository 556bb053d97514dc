//! The colour map "magma" (van der Walt and Smith 2015), for pictures of one number a pixel: from black over violet and orange to
//! pale yellow, lighter evenly. Through the polynomial that Matt Zucker fitted to it (2019, public domain).

/// The signals in sRGB for a number from 0 to 1.
pub fn magma(t: f64) -> [u8; 3] {
    const C: [[f64; 3]; 7] = [
        [-0.002_136_485, -0.000_749_655, -0.005_386_128],
        [0.251_660_541, 0.677_523_244, 2.494_026_599],
        [8.353_717_279, -3.577_719_515, 0.314_467_903],
        [-27.668_733_086, 14.264_730_781, -13.649_213_188],
        [52.176_139_812, -27.943_606_072, 12.944_169_442],
        [-50.768_525_365, 29.046_582_821, 4.234_152_994],
        [18.655_705_066, -11.489_773_520, -5.601_961_509],
    ];
    let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
    [0, 1, 2].map(|i| {
        let value = C.iter().rev().fold(0.0, |sum, c| sum * t + c[i]);
        (255.0 * value).round().clamp(0.0, 255.0) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of the map's own table of 256.
    #[test]
    fn near_the_table() {
        let table = [
            (1, [0.002_258, 0.001_295, 0.018_331]),
            (64, [0.316_654, 0.071_690, 0.485_380]),
            (128, [0.716_387, 0.214_982, 0.475_290]),
            (192, [0.986_700, 0.535_582, 0.382_210]),
            (255, [0.987_053, 0.991_438, 0.749_504]),
        ];
        for (i, color) in table {
            let mapped = magma(f64::from(i) / 255.0);
            for (a, b) in mapped.iter().zip(color) {
                assert!((f64::from(*a) / 255.0 - b).abs() < 0.03, "{i}: {mapped:?}");
            }
        }
        assert_eq!(magma(f64::NAN), magma(0.0));
        assert_eq!(magma(7.0), magma(1.0));
    }
}

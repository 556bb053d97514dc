//! Figures for how far a picture is from a reference.

use crate::{Image, Look, flip, tone};

/// What is added to the square of the reference, so that black pixels do not count without bound (Rousselle, Knaus and Zwicker
/// 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization").
const RELATIVE_FLOOR: f64 = 0.01;

/// How far a picture is from its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The pixels that are not the same, bit for bit.
    pub different: u64,
    /// The largest difference of a channel, in linear light.
    pub largest: f64,
    /// The mean square of the differences of all channels, in linear light.
    pub mse: f64,
    /// The mean over all channels of (picture - reference)^2 / (reference^2 + 0.01), in linear light.
    pub relative_mse: f64,
    /// The peak signal-to-noise ratio in decibels of what the screen shows, in sRGB; infinite if that is the same.
    pub psnr: f64,
    /// The mean of FLIP, of what the screen shows: 0 if no difference is seen, at most 1.
    pub flip: f64,
    /// FLIP of each pixel.
    pub flip_map: Vec<f64>,
    /// The channels that are no numbers, or infinite, in one of the pictures; they are left out of all means.
    pub not_finite: u64,
}

/// The pictures have different sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the pictures have different sizes: {}x{} and {}x{}", .0[0], .0[1], .1[0], .1[1])]
pub struct DifferentSizes([u32; 2], [u32; 2]);

/// Compares a picture with a reference, as `look` shows them at so many pixels in a degree of the field of view.
///
/// # Errors
/// If they have different sizes.
pub fn compare(
    picture: &Image,
    reference: &Image,
    look: &Look,
    pixels_per_degree: f64,
) -> Result<Comparison, DifferentSizes> {
    let size = |image: &Image| [image.width(), image.height()];
    if size(picture) != size(reference) {
        return Err(DifferentSizes(size(picture), size(reference)));
    }
    let pairs = || picture.pixels().iter().zip(reference.pixels());
    let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
    let different = pairs().filter(|(a, b)| bits(a) != bits(b)).count() as u64;
    let (mut largest, mut square, mut relative) = (0.0_f64, 0.0, 0.0);
    let (mut count, mut not_finite) = (0_u64, 0);
    for (a, b) in pairs().flat_map(|(a, b)| a.iter().zip(b)) {
        if !(a.is_finite() && b.is_finite()) {
            not_finite += 1;
            continue;
        }
        let (a, b) = (f64::from(*a), f64::from(*b));
        let d = a - b;
        largest = largest.max(d.abs());
        square += d * d;
        relative += d * d / (b * b + RELATIVE_FLOOR);
        count += 1;
    }
    let shown = |image: &Image| image.pixels().iter().map(|p| look.show(*p)).collect::<Vec<_>>();
    let (a, b) = (shown(picture), shown(reference));
    let signals = a.iter().flatten().zip(b.iter().flatten());
    let noise: f64 = signals.map(|(a, b)| (tone::srgb(*a) - tone::srgb(*b)).powi(2)).sum();
    let noise = noise / (3 * a.len().max(1)) as f64;
    let flip_map = flip::flip(&a, &b, size(picture), pixels_per_degree);
    let count = count.max(1) as f64;
    Ok(Comparison {
        different,
        largest,
        mse: square / count,
        relative_mse: relative / count,
        psnr: -10.0 * noise.log10(),
        flip: flip_map.iter().sum::<f64>() / flip_map.len().max(1) as f64,
        flip_map,
        not_finite,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(value: f32) -> Image {
        Image::new(8, 4, vec![[value; 3]; 32]).unwrap()
    }

    fn all(a: &Image, b: &Image) -> Comparison {
        compare(a, b, &Look::default(), flip::PIXELS_PER_DEGREE).unwrap()
    }

    #[test]
    fn known_figures() {
        let c = all(&plain(0.75), &plain(0.5));
        assert_eq!((c.different, c.largest, c.mse, c.not_finite), (32, 0.25, 0.0625, 0));
        assert!((c.relative_mse - 0.0625 / 0.26).abs() < 1e-15);
        let psnr = -20.0 * (tone::srgb(0.75) - tone::srgb(0.5)).log10();
        assert!((c.psnr - psnr).abs() < 1e-9);
        assert!(c.flip > 0.05 && c.flip < 0.5);
        // One pixel out of 32.
        let mut pixels = vec![[0.5; 3]; 32];
        pixels[9] = [0.75, 0.5, 0.5];
        let one = all(&Image::new(8, 4, pixels).unwrap(), &plain(0.5));
        assert_eq!((one.different, one.mse), (1, 0.0625 / 96.0));
        let same = all(&plain(0.5), &plain(0.5));
        assert_eq!((same.different, same.mse, same.flip), (0, 0.0, 0.0));
        assert_eq!(same.psnr, f64::INFINITY);
    }

    #[test]
    fn what_is_no_number_is_counted_and_left_out() {
        let mut pixels = vec![[0.5; 3]; 32];
        pixels[3] = [f32::NAN, f32::INFINITY, 0.5];
        let c = all(&Image::new(8, 4, pixels).unwrap(), &plain(0.5));
        assert_eq!((c.different, c.not_finite, c.mse), (1, 2, 0.0));
        assert!(c.flip.is_finite() && c.psnr.is_finite());
    }

    #[test]
    fn sizes_must_be_the_same() {
        let other = Image::new(4, 8, vec![[0.5; 3]; 32]).unwrap();
        let error = compare(&plain(0.5), &other, &Look::default(), 67.0).unwrap_err();
        assert_eq!(error.to_string(), "the pictures have different sizes: 8x4 and 4x8");
    }
}

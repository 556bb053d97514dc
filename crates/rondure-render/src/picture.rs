//! The finished picture, and how it gets into a file.

use std::path::Path;

use rondure_film::Film;
use rondure_image::{
    Look,
    png::{self, Signals},
    tone,
};

use crate::Statistics;

/// A picture in linear light, Rec. 709 primaries, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) look: Look,
    pub(crate) pixels: Vec<[f32; 3]>,
    pub(crate) statistics: Statistics,
    /// Names and texts for the file.
    pub(crate) texts: Vec<(String, String)>,
}

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Only 8 and 16 bits are possible.
    #[error("a PNG picture has 8 or 16 bits in each channel, not {0}")]
    Bits(u8),
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] png::WriteError),
}

impl Picture {
    /// The light on a film, to be shown so; black where the picture goes beyond its window.
    pub fn new(film: &Film, look: Look, statistics: Statistics) -> Self {
        let [width, height] = film.size();
        let pixel = |x, y| film.light(x, y).map(|v| v as f32);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
        Self { width, height, look, pixels, statistics, texts: Vec::new() }
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The radiance of each pixel, before exposure.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// What was done to make it.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Adds what a file is to say of the picture: names of up to 79 characters of ASCII, and texts.
    pub fn describe(&mut self, texts: impl IntoIterator<Item = (String, String)>) {
        self.texts.extend(texts);
    }

    /// The channels of all pixels as signals from 0 to `max`: as the look shows them, through the sRGB
    /// curve, dithered.
    fn signals(&self, max: f64) -> impl Iterator<Item = f64> + '_ {
        let width = self.width.max(1) as usize;
        self.pixels.iter().enumerate().flat_map(move |(i, pixel)| {
            let threshold = tone::threshold((i % width) as u32, (i / width) as u32);
            self.look.show(*pixel).map(|v| tone::quantize(v, max, threshold))
        })
    }

    /// Red, green and blue of each pixel in sRGB, 8 bits each.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.signals(255.0).map(|v| v as u8).collect()
    }

    /// Red, green and blue of each pixel in sRGB, 16 bits each.
    pub fn to_srgb16(&self) -> Vec<u16> {
        self.signals(65535.0).map(|v| v as u16).collect()
    }

    /// Writes a PNG file with `bits` (8 or 16) in each channel, marked as sRGB.
    ///
    /// The file appears under its name only when it is whole: it is written beside it and renamed.
    ///
    /// # Errors
    /// If `bits` is neither 8 nor 16, or the file cannot be written; nothing is left behind then,
    /// and a file that was there before stays as it was.
    pub fn write_png(&self, path: impl AsRef<Path>, bits: u8) -> Result<(), WriteError> {
        let signals = match bits {
            8 => Signals::Eight(self.to_srgb8()),
            16 => Signals::Sixteen(self.to_srgb16()),
            _ => return Err(WriteError::Bits(bits)),
        };
        Ok(png::write(path, [self.width, self.height], &signals, &self.texts)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_the_picture() {
        let (width, height) = (33, 7);
        let pixels: Vec<_> =
            (0..width * height).map(|i| [i as f32 / 400.0, 1.5 - i as f32 / 150.0, 0.25]).collect();
        let look = Look::default();
        let statistics = Statistics::default();
        let picture = Picture { width, height, look, pixels, statistics, texts: Vec::new() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for (bits, step) in [(8, 1.0 / 255.0), (16, 1.0 / 65535.0)] {
            picture.write_png(&path, bits).unwrap();
            let read = png::read(&path).unwrap().image;
            for (a, b) in read.pixels().iter().flatten().zip(picture.pixels().iter().flatten()) {
                let difference =
                    tone::srgb(f64::from(*a)) - tone::srgb(f64::from(b.clamp(0.0, 1.0)));
                assert!(difference.abs() <= step, "{a} {b}");
            }
        }
        assert!(matches!(picture.write_png(&path, 12), Err(WriteError::Bits(12))));
    }
}

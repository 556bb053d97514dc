//! The finished picture, and how it gets into a file.

use std::path::Path;

use rondure_film::{Film, Spool, SpoolError, Window};
use rondure_image::{
    Depth, Image, Look,
    png::{self, Texts},
};

use crate::Statistics;

/// A picture in linear light, and how it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    image: Image,
    look: Look,
    statistics: Statistics,
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
    /// The sums of the picture cannot be read.
    #[error(transparent)]
    Sums(#[from] SpoolError),
}

impl Picture {
    /// The light on a film, to be shown so; black where the picture goes beyond its window.
    pub fn new(film: &Film, look: Look, statistics: Statistics) -> Self {
        let [width, height] = film.size();
        let image = Image::from_pixels(width, height, |x, y| pixel(film, x, y));
        Self { image, look, statistics }
    }

    /// The radiance of each pixel, before exposure.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// How it is shown.
    pub fn look(&self) -> &Look {
        &self.look
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.image.width()
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.image.height()
    }

    /// The radiance of each pixel, before exposure, rows from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        self.image.pixels()
    }

    /// What was done to make it.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Writes a PNG file with `bits` (8 or 16) in each channel, marked as sRGB.
    ///
    /// The file appears under its name only when it is whole: it is written beside it and renamed.
    ///
    /// # Errors
    /// If `bits` is neither 8 nor 16, or the file cannot be written; nothing is left behind then,
    /// and a file that was there before stays as it was.
    pub fn write_png(&self, path: impl AsRef<Path>, bits: u8) -> Result<(), WriteError> {
        let signals = self.image.signals(&self.look, depth(bits)?);
        Ok(png::write(path, [self.width(), self.height()], &signals, &[])?)
    }
}

fn pixel(film: &Film, x: u32, y: u32) -> [f32; 3] {
    film.light(x, y).map(|v| v as f32)
}

fn depth(bits: u8) -> Result<Depth, WriteError> {
    Depth::of_bits(bits).ok_or(WriteError::Bits(bits))
}

/// Writes the light of sums into a PNG file as `look` shows it, with `bits` (8 or 16) in each channel; black where the picture goes beyond their window. No
/// more than a row is in memory.
///
/// # Errors
/// As [`Picture::write_png`], or if the sums cannot be read.
pub fn write_png(
    path: impl AsRef<Path>,
    sums: &Spool,
    look: &Look,
    bits: u8,
    texts: &Texts,
) -> Result<(), WriteError> {
    let [width, height] = sums.size();
    png::write_light(path, [width, height], (look, depth(bits)?), texts, |y| {
        let film = sums.view(Window { x: 0, y, width, height: 1 })?;
        Ok((0..width).map(|x| pixel(&film, x, y)).collect())
    })
}

#[cfg(test)]
mod tests {
    use rondure_film::{Guide, Layers, PixelSample, Room};
    use rondure_image::tone;

    use super::*;

    #[test]
    fn files_hold_the_picture() {
        let (width, height) = (33, 7);
        let window = Window { x: 0, y: 1, width, height: height - 1 };
        let mut film = Film::new([width, height], window, Layers::default()).unwrap();
        for i in width..width * height {
            let v = f64::from(i);
            let light = [v / 400.0, 1.5 - v / 150.0, 0.25];
            let sample = PixelSample { light, negative: false, guide: Guide::default() };
            assert!(film.add(i % width, i / width, &sample));
        }
        let picture = Picture::new(&film, Look::default(), Statistics::default());
        assert_eq!(picture.pixels()[..33], [[0.0; 3]; 33]);
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("a.png"), folder.path().join("b.png"));
        let room = Room { memory: 0, folder: folder.path().to_owned() };
        let mut spool = Spool::new([width, height], window, Layers::default(), &room).unwrap();
        spool.merge(&film).unwrap();
        for (bits, step) in [(8, 1.0 / 255.0), (16, 1.0 / 65535.0)] {
            picture.write_png(&path, bits).unwrap();
            let read = png::read(&path).unwrap().image;
            for (a, b) in read.pixels().iter().flatten().zip(picture.pixels().iter().flatten()) {
                let difference =
                    tone::srgb(f64::from(*a)) - tone::srgb(f64::from(b.clamp(0.0, 1.0)));
                assert!(difference.abs() <= step, "{a} {b}");
            }
            write_png(&other, &spool, picture.look(), bits, &[]).unwrap();
            assert!(std::fs::read(&path).unwrap() == std::fs::read(&other).unwrap());
        }
        assert!(matches!(picture.write_png(&path, 12), Err(WriteError::Bits(12))));
    }
}

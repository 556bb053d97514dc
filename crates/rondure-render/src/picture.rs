//! The finished picture, and how it gets into a file.

use std::{
    fs,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use rondure_film::Film;

use crate::{Statistics, tone};

/// A picture in linear light, Rec. 709 primaries, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) exposure: f64,
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
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file that was to be written.
        path: PathBuf,
        /// What went wrong.
        source: io::Error,
    },
    /// The picture could not be encoded.
    #[error("cannot encode {}: {source}", path.display())]
    Encode {
        /// The file that was to be written.
        path: PathBuf,
        /// What went wrong.
        source: png::EncodingError,
    },
}

impl Picture {
    /// The light on a film; black where the picture goes beyond its window.
    pub fn new(film: &Film, exposure: f64, statistics: Statistics) -> Self {
        let [width, height] = film.size();
        let pixel = |x, y| film.light(x, y).map(|v| v as f32);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
        Self { width, height, exposure, pixels, statistics, texts: Vec::new() }
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

    /// The channels of all pixels as signals from 0 to `max`: times the exposure, cut off at white,
    /// through the sRGB curve, dithered.
    fn signals(&self, max: f64) -> impl Iterator<Item = f64> + '_ {
        let width = self.width.max(1) as usize;
        self.pixels.iter().enumerate().flat_map(move |(i, pixel)| {
            let threshold = tone::threshold((i % width) as u32, (i / width) as u32);
            pixel.map(|v| tone::quantize(f64::from(v) * self.exposure, max, threshold))
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
        let path = path.as_ref();
        let io_error = |source| WriteError::Io { path: path.to_owned(), source };
        let depth = match bits {
            8 => png::BitDepth::Eight,
            16 => png::BitDepth::Sixteen,
            _ => return Err(WriteError::Bits(bits)),
        };
        if path.is_dir() {
            return Err(io_error(io::ErrorKind::IsADirectory.into()));
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".rondure-").suffix(".png");
        #[cfg(unix)]
        {
            // As for any new file; the process' mask takes its share.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut file = builder.tempfile_in(folder).map_err(io_error)?;
        self.encode(BufWriter::new(file.as_file_mut()), depth).map_err(|source| match source {
            png::EncodingError::IoError(source) => io_error(source),
            source => WriteError::Encode { path: path.to_owned(), source },
        })?;
        file.as_file().sync_all().map_err(io_error)?;
        file.persist(path).map(drop).map_err(|error| io_error(error.error))
    }

    fn encode(&self, mut out: impl Write, depth: png::BitDepth) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(depth);
        // The values the PNG specification gives for readers that do not know the sRGB chunk.
        encoder.set_source_gamma(png::ScaledFloat::from_scaled(45_455));
        let chroma = |x, y| (png::ScaledFloat::from_scaled(x), png::ScaledFloat::from_scaled(y));
        encoder.set_source_chromaticities(png::SourceChromaticities {
            white: chroma(31_270, 32_900),
            red: chroma(64_000, 33_000),
            green: chroma(30_000, 60_000),
            blue: chroma(15_000, 6_000),
        });
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let software = concat!("Rondure ", env!("CARGO_PKG_VERSION")).to_owned();
        encoder.add_text_chunk("Software".to_owned(), software)?;
        for (name, text) in &self.texts {
            // The plain kind of text chunk knows Latin-1 only.
            if text.chars().all(|c| u32::from(c) < 0x100) {
                encoder.add_text_chunk(name.clone(), text.clone())?;
            } else {
                encoder.add_itxt_chunk(name.clone(), text.clone())?;
            }
        }
        let mut writer = encoder.write_header()?;
        // Coding-independent code points: primaries of Rec. 709, sRGB curve, RGB, full range.
        writer.write_chunk(png::chunk::ChunkType(*b"cICP"), &[1, 13, 0, 1])?;
        match depth {
            png::BitDepth::Sixteen => {
                let data: Vec<u8> =
                    self.to_srgb16().into_iter().flat_map(u16::to_be_bytes).collect();
                writer.write_image_data(&data)?;
            }
            _ => writer.write_image_data(&self.to_srgb8())?,
        }
        writer.finish()?;
        Ok(out.flush()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Picture {
        let (width, height) = (33, 7);
        let pixels =
            (0..width * height).map(|i| [i as f32 / 400.0, 1.5 - i as f32 / 150.0, 0.25]).collect();
        Picture {
            width,
            height,
            exposure: 1.0,
            pixels,
            statistics: Statistics::default(),
            texts: Vec::new(),
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn read(path: &Path) -> (png::Info<'static>, Vec<u8>) {
        let file = io::BufReader::new(fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        (reader.info().clone(), data)
    }

    #[test]
    fn files_hold_the_picture_and_say_it_is_srgb() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let picture = gradient();
        for bits in [8, 16] {
            picture.write_png(&path, bits).unwrap();
            let (info, data) = read(&path);
            assert_eq!((info.width, info.height), (33, 7));
            assert!(info.srgb.is_some());
            let code_points = info.coding_independent_code_points.unwrap();
            assert_eq!(code_points.color_primaries, 1);
            assert_eq!(code_points.transfer_function, 13);
            assert!(code_points.is_video_full_range_image);
            let bytes = fs::read(&path).unwrap();
            for chunk in [b"gAMA", b"cHRM", b"sRGB", b"cICP"] {
                assert!(bytes.windows(4).any(|w| w == chunk), "{chunk:?}");
            }
            if bits == 8 {
                assert_eq!(info.bit_depth, png::BitDepth::Eight);
                assert_eq!(data, picture.to_srgb8());
            } else {
                assert_eq!(info.bit_depth, png::BitDepth::Sixteen);
                let words: Vec<_> =
                    data.chunks(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
                assert_eq!(words, picture.to_srgb16());
            }
        }
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn errors_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        fs::write(taken.join("inside"), "x").unwrap();
        let picture = gradient();
        assert!(matches!(picture.write_png(&taken, 8), Err(WriteError::Io { .. })));
        assert!(matches!(
            picture.write_png(folder.path().join("b.png"), 12),
            Err(WriteError::Bits(12))
        ));
        let lost = folder.path().join("no/such/folder.png");
        let error = picture.write_png(&lost, 8).unwrap_err().to_string();
        assert!(error.contains("folder.png"), "{error}");
        // A picture that cannot be encoded: the old file stays.
        let path = folder.path().join("old.png");
        fs::write(&path, "old").unwrap();
        let empty = Picture { width: 0, pixels: Vec::new(), ..picture };
        assert!(empty.write_png(&path, 8).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["old.png", "taken"]);
    }

    #[cfg(unix)]
    #[test]
    fn files_can_be_read_by_others() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, usual) = (folder.path().join("a.png"), folder.path().join("usual"));
        gradient().write_png(&ours, 8).unwrap();
        fs::write(&usual, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&usual));
    }
}

//! PNG files: written with all the chunks that say sRGB, read as linear light.

use std::{
    fs::File,
    io::{self, BufReader, BufWriter, Write},
    path::{Path, PathBuf},
};

use png::{BitDepth, ColorType, Encoder, EncodingError, StreamWriter, Transformations};

use crate::{Depth, Image, Look, Signals, file::write_whole, tone};

/// Texts in a file: each with its key, of ASCII, at most 79 bytes long.
pub type Texts = [(String, String)];

/// Why a file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
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
        source: EncodingError,
    },
}

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: io::Error,
    },
    /// The file holds no picture, or not all of it.
    #[error("{} is no whole PNG picture: {source}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: png::DecodingError,
    },
    /// The picture does not fit into memory.
    #[error("{} does not fit into memory", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
}

/// A picture that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// The light. Where the picture is transparent, over black.
    pub image: Image,
    /// The texts, each with its key.
    pub texts: Vec<(String, String)>,
}

/// Writes a picture, marked as sRGB. The file appears under its name only when it is whole.
///
/// # Errors
/// If there are not as many signals as the size asks for, or the file cannot be written; nothing is left behind then, and a
/// file that was there before stays as it was.
pub fn write(
    path: impl AsRef<Path>,
    [width, height]: [u32; 2],
    signals: &Signals,
    texts: &Texts,
) -> Result<(), WriteError> {
    write_rows(path.as_ref(), [width, height], signals.depth(), texts, |writer| {
        Ok(writer.write_all(&signals.bytes())?)
    })
}

/// Writes a picture row by row, of which `row` gives the light by the number of each, as `look` shows it, marked as sRGB. The file appears under
/// its name only when it is whole, and no more than a row is in memory.
///
/// # Errors
/// As for [`write()`]; the errors of `row` are passed on.
pub fn write_light<E: From<WriteError>>(
    path: impl AsRef<Path>,
    [width, height]: [u32; 2],
    (look, depth): (&Look, Depth),
    texts: &Texts,
    mut row: impl FnMut(u32) -> Result<Vec<[f32; 3]>, E>,
) -> Result<(), E> {
    write_rows(path.as_ref(), [width, height], depth, texts, |writer| {
        for y in 0..height {
            let signals = look.signals(&row(y).map_err(Stop::Theirs)?, width, y, depth);
            writer.write_all(&signals.bytes())?;
        }
        Ok(())
    })
}

/// The length of the pieces in which compressed rows stand in a file, in bytes.
const PIECE: usize = 1 << 16;

/// Writes the rows that `fill` gives.
fn write_rows<E: From<WriteError>>(
    path: &Path,
    [width, height]: [u32; 2],
    depth: Depth,
    texts: &Texts,
    fill: impl FnOnce(&mut StreamWriter<'_, &mut BufWriter<&mut File>>) -> Result<(), Stop<E>>,
) -> Result<(), E> {
    let write = |out: &mut BufWriter<&mut File>| {
        let mut writer = header(out, width, height, depth, texts, None)?;
        let mut rows = writer.stream_writer_with_size(PIECE)?;
        fill(&mut rows)?;
        rows.finish()?;
        Ok(writer.finish()?)
    };
    write_whole(path, write).map_err(|stop: Stop<E>| stop.at(path))
}

/// What stops a file.
enum Stop<E> {
    Ours(EncodingError),
    Theirs(E),
}

impl<E> From<io::Error> for Stop<E> {
    fn from(error: io::Error) -> Self {
        Self::Ours(error.into())
    }
}

impl<E> From<EncodingError> for Stop<E> {
    fn from(error: EncodingError) -> Self {
        Self::Ours(error)
    }
}

impl<E: From<WriteError>> Stop<E> {
    fn at(self, path: &Path) -> E {
        match self {
            Self::Ours(error) => failed(path, error).into(),
            Self::Theirs(error) => error,
        }
    }
}

fn failed(path: &Path, error: EncodingError) -> WriteError {
    let path = path.to_owned();
    match error {
        EncodingError::IoError(source) => WriteError::Io { path, source },
        source => WriteError::Encode { path, source },
    }
}

/// What stands before the pixels. `film` is the number of frames and how many are shown in a second.
fn header<W: Write>(
    out: W,
    width: u32,
    height: u32,
    depth: Depth,
    texts: &Texts,
    film: Option<(u32, f64)>,
) -> Result<png::Writer<W>, EncodingError> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    });
    if let Some((frames, rate)) = film {
        encoder.set_animated(frames, 0)?;
        // A fraction of two u16, with a numerator that leaves the denominator its digits.
        let numerator = if rate < 60.0 { 1000.0 } else { 100.0 };
        encoder.set_frame_delay(numerator as u16, (numerator * rate).round() as u16)?;
    }
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
    for (key, text) in texts {
        // The plain kind of text chunk knows Latin-1 only.
        if text.chars().all(|c| u32::from(c) < 0x100) {
            encoder.add_text_chunk(key.clone(), text.clone())?;
        } else {
            encoder.add_itxt_chunk(key.clone(), text.clone())?;
        }
    }
    let mut writer = encoder.write_header()?;
    // Coding-independent code points: primaries of Rec. 709, sRGB curve, RGB, full range.
    writer.write_chunk(png::chunk::ChunkType(*b"cICP"), &[1, 13, 0, 1])?;
    Ok(writer)
}

/// Writes an animated PNG of frames of 8 bits, `rate` of them a second (from 0.02 to 650), that repeats for ever; programs that know no animation show the first frame.
/// `frames` gives the signals of one frame after the other, so that no more than one is in memory.
///
/// # Errors
/// As for [`write()`]; the errors of `frames` are passed on.
pub fn write_animation<E: From<WriteError>>(
    path: impl AsRef<Path>,
    [width, height]: [u32; 2],
    rate: f64,
    frames: impl ExactSizeIterator<Item = Result<Vec<u8>, E>>,
) -> Result<(), E> {
    let path = path.as_ref();
    write_whole(path, |out| {
        let film = Some((u32::try_from(frames.len()).unwrap_or(u32::MAX), rate));
        let mut writer = header(out, width, height, Depth::Eight, &[], film)?;
        for frame in frames {
            writer.write_image_data(&frame.map_err(Stop::Theirs)?)?;
        }
        Ok(writer.finish()?)
    })
    .map_err(|stop: Stop<E>| stop.at(path))
}

/// Reads a picture of any kind that PNG has. Its colours are taken for sRGB, whatever profile it carries; of an animation, the first
/// frame is read.
///
/// # Errors
/// If the file cannot be read, holds no whole picture, or does not fit into memory.
pub fn read(path: impl AsRef<Path>) -> Result<Decoded, ReadError> {
    let path = path.as_ref();
    let io_error = |source| ReadError::Io { path: path.to_owned(), source };
    let decode_error = |error| match error {
        // A file that ends early is a bad picture, not a bad disk.
        png::DecodingError::IoError(source) if source.kind() != io::ErrorKind::UnexpectedEof => {
            io_error(source)
        }
        source => ReadError::Decode { path: path.to_owned(), source },
    };
    let too_large = || ReadError::TooLarge { path: path.to_owned() };
    let file = File::open(path).map_err(io_error)?;
    if file.metadata().map_err(io_error)?.is_dir() {
        return Err(io_error(io::ErrorKind::IsADirectory.into()));
    }
    let mut decoder = png::Decoder::new(BufReader::new(file));
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(decode_error)?;
    let size = reader.output_buffer_size().ok_or_else(too_large)?;
    let mut data = Vec::new();
    data.try_reserve_exact(size).map_err(|_| too_large())?;
    data.resize(size, 0);
    let frame = reader.next_frame(&mut data).map_err(decode_error)?;
    reader.finish().map_err(decode_error)?;
    data.truncate(frame.buffer_size());
    let info = reader.info();
    let (plain, long) = (&info.uncompressed_latin1_text, &info.utf8_text);
    let mut texts: Vec<_> = plain.iter().map(|t| (t.keyword.clone(), t.text.clone())).collect();
    texts.extend(long.iter().filter_map(|t| Some((t.keyword.clone(), t.get_text().ok()?))));
    let signals: Vec<f64> = match frame.bit_depth {
        BitDepth::Sixteen => data
            .chunks_exact(2)
            .map(|b| f64::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0)
            .collect(),
        _ => data.iter().map(|v| f64::from(*v) / 255.0).collect(),
    };
    let linear = |v: f64| tone::linear(v) as f32;
    let pixel = |signals: &[f64]| match *signals {
        [v] => [linear(v); 3],
        [v, a] => [(tone::linear(v) * a) as f32; 3],
        [r, g, b] => [linear(r), linear(g), linear(b)],
        [r, g, b, a] => [r, g, b].map(|v| (tone::linear(v) * a) as f32),
        _ => [0.0; 3],
    };
    let pixels = signals.chunks(frame.color_type.samples()).map(pixel).collect();
    let image = Image::new(frame.width, frame.height, pixels).map_err(|_| too_large())?;
    Ok(Decoded { image, texts })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn signals(count: u32) -> Vec<u8> {
        (0..count).map(|i| (i * 37 % 251) as u8).collect()
    }

    #[test]
    fn files_hold_the_picture_and_say_it_is_srgb() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let eight = signals(33 * 7 * 3);
        let sixteen: Vec<u16> = eight.iter().map(|v| u16::from(*v) * 257).collect();
        for kind in [Signals::Eight(eight.clone()), Signals::Sixteen(sixteen)] {
            let texts = [("Scene", "Ünicode\nof two lines"), ("Path", "漢.toml")];
            let texts = texts.map(|(key, text)| (key.to_owned(), text.to_owned()));
            write(&path, [33, 7], &kind, &texts).unwrap();
            let bytes = fs::read(&path).unwrap();
            for chunk in [b"gAMA", b"cHRM", b"sRGB", b"cICP"] {
                assert!(bytes.windows(4).any(|w| w == chunk), "{chunk:?}");
            }
            let decoded = read(&path).unwrap();
            assert_eq!((decoded.image.width(), decoded.image.height()), (33, 7));
            assert_eq!(decoded.texts[0].0, "Software");
            assert_eq!(decoded.texts[1..], texts);
            let light = decoded.image.pixels().iter().flatten();
            for (light, signal) in light.zip(&eight) {
                assert_eq!(*light, tone::linear(f64::from(*signal) / 255.0) as f32);
            }
        }
    }

    #[test]
    fn every_kind_of_pixel_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let kinds = [
            (ColorType::Grayscale, &[64_u8, 255][..], [64, 64, 64], 255),
            (ColorType::GrayscaleAlpha, &[64, 128, 0, 0], [64, 64, 64], 128),
            (ColorType::Rgb, &[1, 2, 3, 4, 5, 6], [1, 2, 3], 255),
            (ColorType::Rgba, &[1, 2, 3, 128, 4, 5, 6, 7], [1, 2, 3], 128),
            (ColorType::Indexed, &[1, 0], [7, 8, 9], 255),
        ];
        for (kind, data, first, alpha) in kinds {
            let mut encoder = Encoder::new(File::create(&path).unwrap(), 2, 1);
            encoder.set_color(kind);
            if kind == ColorType::Indexed {
                encoder.set_palette(vec![0, 0, 0, 7, 8, 9]);
            }
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            let pixel = read(&path).unwrap().image.pixels()[0];
            for (light, signal) in pixel.iter().zip(first) {
                let expected = tone::linear(f64::from(signal) / 255.0) * f64::from(alpha) / 255.0;
                assert_eq!(*light, expected as f32, "{kind:?}");
            }
        }
    }

    #[test]
    fn animations_have_all_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let frames: Vec<_> = (0..3).map(|i| Ok::<_, WriteError>(vec![i * 50; 4 * 2 * 3])).collect();
        write_animation(&path, [4, 2], 12.5, frames.into_iter()).unwrap();
        let file = BufReader::new(File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        for i in 0..3 {
            let mut data = vec![0; 4 * 2 * 3];
            reader.next_frame(&mut data).unwrap();
            assert_eq!(data, vec![i * 50; 4 * 2 * 3]);
            let control = reader.info().frame_control.unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1000, 12_500));
        }
        // A frame that fails leaves no file.
        fs::remove_file(&path).unwrap();
        let lost =
            || WriteError::Io { path: "frame".into(), source: io::ErrorKind::NotFound.into() };
        let frames = vec![Ok(vec![0; 24]), Err(lost())].into_iter();
        let error = write_animation(&path, [4, 2], 12.5, frames).unwrap_err();
        assert!(error.to_string().contains("frame") && !path.exists());
    }

    #[test]
    fn bad_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write(&path, [33, 7], &Signals::Eight(signals(33 * 7 * 3)), &[]).unwrap();
        let whole = fs::read(&path).unwrap();
        for length in [0, 7, 20, 60, whole.len() / 2, whole.len() - 14] {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(matches!(read(&path), Err(ReadError::Decode { .. })), "{length}");
        }
        let mut flipped = whole.clone();
        flipped[whole.len() / 2] ^= 4;
        fs::write(&path, flipped).unwrap();
        assert!(matches!(read(&path), Err(ReadError::Decode { .. })));
        assert!(matches!(read(folder.path()), Err(ReadError::Io { .. })));
        assert!(matches!(read(folder.path().join("none")), Err(ReadError::Io { .. })));
        // Too few signals.
        let short = Signals::Eight(vec![0; 5]);
        assert!(matches!(write(&path, [2, 1], &short, &[]), Err(WriteError::Encode { .. })));
    }
}

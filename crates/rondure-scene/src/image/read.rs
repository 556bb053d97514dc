//! Picture files: PNG and JPEG of 8 or 16 bits, Radiance HDR and OpenEXR of floats. What a file is, its
//! first bytes tell, not its name.

use std::{
    io::{BufReader, Cursor},
    path::Path,
};

use exr::prelude::{MetaData, ReadChannels, ReadLayers, ReadSpecificChannel, Text, Vec2};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::{Content, Image, MOST_PIXELS, fail};
use crate::{Diagnostic, Report, color, file::read_bytes};

/// The size of the largest picture file that is read, in bytes: 1 GiB.
const LARGEST_PICTURE: u64 = 1 << 30;

/// The first bytes of an OpenEXR file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// What a file has been decoded to.
struct Raw {
    size: [u32; 2],
    channels: u32,
    samples: Vec<f32>,
    /// The number of values that an integer sample can have; `None` for floats.
    steps: Option<u32>,
}

/// Reads a picture for a purpose.
pub(super) fn read(path: &Path, content: Content) -> Result<Image, Report> {
    let bytes = read_bytes(path, LARGEST_PICTURE)?;
    let raw = if bytes.starts_with(&EXR) {
        read_exr(path, &bytes, content)
    } else {
        read_other(path, &bytes)
    };
    raw.and_then(|raw| finished(path, raw, content)).map_err(Report::only)
}

/// Makes the samples linear and checks them.
fn finished(path: &Path, raw: Raw, content: Content) -> Result<Image, Diagnostic> {
    let Raw { size: [width, height], channels, mut samples, steps } = raw;
    if let (Some(steps), Content::Color | Content::Light) = (steps, content) {
        let largest = f64::from(steps - 1);
        let table: Vec<f32> =
            (0..steps).map(|i| color::decoded(f64::from(i) / largest) as f32).collect();
        for pixel in samples.chunks_exact_mut(channels as usize) {
            for sample in pixel.iter_mut().take(3) {
                *sample =
                    table[((f64::from(*sample) * largest).round() as usize).min(table.len() - 1)];
            }
        }
    }
    let (allowed, words): (fn(f32) -> bool, _) = match content {
        Content::Color => (|x| (0.0..=1.0).contains(&x), "a colour of a material is from 0 to 1"),
        Content::Light => (|x| x >= 0.0 && x.is_finite(), "light is 0 or more, and finite"),
        Content::Data => (|x: f32| x.is_finite(), "data must be finite"),
    };
    if let Some(bad) = samples.iter().position(|x| !allowed(*x)) {
        let pixel = bad as u64 / u64::from(channels);
        let (x, y) = (pixel % u64::from(width), pixel / u64::from(width));
        let channel = match channels {
            1 => "grey",
            _ => ["red", "green", "blue", "alpha"][bad % channels as usize],
        };
        let value = samples[bad];
        let message =
            format!("{channel} is {value} in column {x}, row {y}, counted from 0 at the top left");
        return Err(fail(path, message).help(words));
    }
    Image::new(width, height, channels, samples).ok_or_else(|| fail(path, "it has no pixels"))
}

fn check_size(path: &Path, width: u64, height: u64) -> Result<[u32; 2], Diagnostic> {
    let too_large = || {
        let message = format!("it has {width} x {height} pixels; {MOST_PIXELS} can be handled");
        fail(path, message).help("make it smaller")
    };
    if width == 0 || height == 0 {
        return Err(fail(path, "it has no pixels"));
    }
    if width.checked_mul(height).is_none_or(|pixels| pixels > MOST_PIXELS) {
        return Err(too_large());
    }
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width), Ok(height)) => Ok([width, height]),
        _ => Err(too_large()),
    }
}

fn read_other(path: &Path, bytes: &[u8]) -> Result<Raw, Diagnostic> {
    let known = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Hdr];
    let format = image::guess_format(bytes).ok().filter(|format| known.contains(format));
    let Some(format) = format else {
        let error = fail(path, "it is no picture that is known here");
        return Err(error.help("pictures are PNG, JPEG, Radiance HDR or OpenEXR files"));
    };
    let broken = |error: ImageError| {
        let reason = match &error {
            ImageError::Decoding(e) => e.to_string(),
            ImageError::IoError(_) => "it ends too early".into(),
            other => other.to_string(),
        };
        fail(path, reason).help("the file seems to be damaged; export it again")
    };
    let mut reader = ImageReader::with_format(BufReader::new(Cursor::new(bytes)), format);
    // The size is checked below; what decoders need beside the pixels is small.
    reader.limits(Limits::no_limits());
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let size = check_size(path, width.into(), height.into())?;
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let kind = image.color();
    let channels = match (kind.has_color(), kind.has_alpha()) {
        (false, false) => 1,
        (true, false) => 3,
        (_, true) => 4,
    };
    let bytes_each = kind.bytes_per_pixel() / kind.channel_count();
    let steps = match bytes_each {
        1 => Some(1 << 8),
        2 => Some(1 << 16),
        _ => None,
    };
    let samples = match (channels, bytes_each) {
        (1, 1) => bytes_of(image.into_luma8().as_raw()),
        (1, _) => words_of(image.into_luma16().as_raw()),
        (3, 1) => bytes_of(image.into_rgb8().as_raw()),
        (3, 2) => words_of(image.into_rgb16().as_raw()),
        (3, _) => image.into_rgb32f().into_raw(),
        (_, 1) => bytes_of(image.into_rgba8().as_raw()),
        (_, 2) => words_of(image.into_rgba16().as_raw()),
        _ => image.into_rgba32f().into_raw(),
    };
    Ok(Raw { size, channels, samples, steps })
}

fn bytes_of(samples: &[u8]) -> Vec<f32> {
    samples.iter().map(|x| f32::from(*x) / f32::from(u8::MAX)).collect()
}

fn words_of(samples: &[u16]) -> Vec<f32> {
    samples.iter().map(|x| f32::from(*x) / f32::from(u16::MAX)).collect()
}

/// The first layer that has the channels R, G and B, and perhaps A; or the channel Y alone.
fn read_exr(path: &Path, bytes: &[u8], content: Content) -> Result<Raw, Diagnostic> {
    let broken = |error: exr::error::Error| {
        fail(path, error).help("the file seems to be damaged, or of a kind that is not read")
    };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    let has = |name: &str| {
        let name = Text::from(name);
        move |header: &exr::meta::header::Header| {
            !header.deep && header.channels.list.iter().any(|channel| channel.name == name)
        }
    };
    let is_color = |h: &exr::meta::header::Header| has("R")(h) && has("G")(h) && has("B")(h);
    let color = meta.headers.iter().find(|header| is_color(header));
    let grey = meta.headers.iter().find(|header| has("Y")(header));
    let Some(header) = color.or(grey) else {
        let error = fail(path, "it has no layer with the channels R, G and B, or Y");
        return Err(error.help("save the picture with plain channel names"));
    };
    let [width, height] =
        check_size(path, header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    let channels = match color {
        Some(header) if has("A")(header) => 4,
        Some(_) => 3,
        None => 1,
    };
    let (row, samples) = (width as usize * channels, (width * height) as usize * channels);
    let flat = || exr::prelude::read().no_deep_data().largest_resolution_level();
    // Should the layer be another one than was looked at, what lies beyond its size is dropped.
    let put = move |samples: &mut Vec<f32>, at: Vec2<usize>, values: &[f32]| {
        let start = at.y() * row + at.x() * channels;
        if let Some(pixel) = samples.get_mut(start..start + channels) {
            pixel.copy_from_slice(&values[..channels]);
        }
    };
    let samples = if color.is_some() {
        // Colours are multiplied by alpha there, which light may stay.
        let plain = content == Content::Color && channels == 4;
        let image = flat()
            .rgba_channels(
                move |_, _| vec![0.0_f32; samples],
                move |samples, at, (r, g, b, a): (f32, f32, f32, f32)| {
                    let straight = |x: f32| if plain && a > 0.0 { x / a } else { x };
                    put(samples, at, &[straight(r), straight(g), straight(b), a]);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(broken)?;
        image.layer_data.channel_data.pixels
    } else {
        let image = flat()
            .specific_channels()
            .required("Y")
            .collect_pixels(
                move |_, _| vec![0.0_f32; samples],
                move |samples, at, (y,): (f32,)| put(samples, at, &[y]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(broken)?;
        image.layer_data.channel_data.pixels
    };
    Ok(Raw { size: [width, height], channels: channels as u32, samples, steps: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(name: &str, content: Content) -> Result<Image, String> {
        read(&Path::new("tests/pictures").join(name), content).map_err(|e| e.to_string())
    }

    #[test]
    fn colours_are_decoded_and_data_are_not() {
        let color = open("square.png", Content::Color).unwrap();
        assert_eq!((color.width(), color.height(), color.channels()), (2, 2, 3));
        assert_eq!(color.pixel(1, 0), [0.0, 1.0, 0.0, 1.0]);
        let grey = color.pixel(1, 1)[0];
        assert!((f64::from(grey) - color::decoded(188.0 / 255.0)).abs() < 1e-7);
        let data = open("square.png", Content::Data).unwrap();
        assert_eq!(data.pixel(1, 1)[2], 188.0 / 255.0);
        let fine = open("grey16.png", Content::Data).unwrap();
        assert_eq!(fine.channels(), 1);
        assert_eq!(
            fine.pixel(0, 0),
            [32768.0 / 65535.0, 32768.0 / 65535.0, 32768.0 / 65535.0, 1.0]
        );
        let light = f64::from(open("grey16.png", Content::Light).unwrap().pixel(0, 0)[0]);
        assert!((light - color::decoded(32768.0 / 65535.0)).abs() < 1e-7);
    }

    #[test]
    fn alpha_stays_as_it_is() {
        let image = open("alpha.png", Content::Color).unwrap();
        assert_eq!(image.pixel(0, 0)[3], 128.0 / 255.0);
        assert_eq!(image.pixel(1, 0)[3], 1.0);
        // OpenEXR multiplies by it.
        let image = open("half-covered.exr", Content::Color).unwrap();
        assert_eq!(image.pixel(0, 0), [1.0, 0.25, 0.5, 0.5]);
        assert_eq!(open("half-covered.exr", Content::Light).unwrap().pixel(1, 0)[0], 0.5);
    }

    #[test]
    fn floats_are_linear() {
        let sky = open("sky.hdr", Content::Light).unwrap();
        assert_eq!(sky.pixel(0, 0), [1.0, 0.5, 0.25, 1.0]);
        assert_eq!(sky.pixel(1, 0)[0], 128.0);
        assert_eq!(open("bright.exr", Content::Light).unwrap().pixel(3, 1), [12.0, 2.0, 1.0, 1.0]);
        assert_eq!(open("heights.exr", Content::Data).unwrap().pixel(0, 1)[0], -0.5);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (name, content, words) in [
            ("bright.exr", Content::Color, "green is 2 in column 0, row 0"),
            ("heights.exr", Content::Color, "grey is -0.5 in column 0, row 1"),
            ("nan.exr", Content::Data, "blue is NaN in column 3, row 0"),
            ("cut.png", Content::Data, "it ends too early"),
            ("text.png", Content::Data, "no picture that is known"),
        ] {
            let error = open(name, content).expect_err(name);
            assert!(error.contains(words), "{error}");
        }
    }

    /// However a file is damaged, there is an error or a picture.
    #[test]
    fn damaged_files_do_no_harm() {
        for name in ["square.png", "sky.hdr", "bright.exr", "half-covered.exr", "heights.exr"] {
            let path = Path::new("tests/pictures").join(name);
            let whole = std::fs::read(&path).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let damaged = folder.path().join(name);
            for i in (0..whole.len()).step_by(2) {
                for bytes in [whole[..i].to_vec(), {
                    let mut bytes = whole.clone();
                    bytes[i] ^= 0x91;
                    bytes
                }] {
                    std::fs::write(&damaged, bytes).unwrap();
                    let _ = read(&damaged, Content::Data);
                }
            }
        }
    }
}

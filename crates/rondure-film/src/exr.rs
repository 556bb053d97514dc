//! OpenEXR files: all layers of a film in one part, in 32-bit floats, row by row, so that no second picture is held in memory.
//!
//! The names of channels are those that compositing programs know: `R G B` is the picture and `Z` its depth, further layers are named
//! before a point. Numbers of objects and materials are floats too, since most readers take nothing else; they are exact up to 2^24.

use std::{
    io::{BufReader, BufWriter, Read, Seek},
    path::{Path, PathBuf},
};

use exr::{
    block::{self, UncompressedBlock, writer::ChunksWriter},
    meta::{BlockDescription, header::Header},
    prelude::{
        Compression, LineOrder, SampleType, Text,
        attribute::{ChannelDescription, Chromaticities},
    },
};

use rondure_image::file::write_whole;

use crate::{Film, Recipe};

/// Why an OpenEXR file cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExrError {
    /// The disk says no.
    #[error("{source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: std::io::Error,
    },
    /// The file is damaged, or uses what is not supported.
    #[error("`{}` is not an OpenEXR picture that can be read: {reason}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// What a channel shows.
#[derive(Clone, Copy)]
enum Shows {
    Light(usize),
    Albedo(usize),
    Normal(usize),
    Depth,
    Position(usize),
    Object,
    Material,
    Samples,
    Variance(usize),
}

/// The channels of a film, in the order of their names, as the format asks.
fn channels(film: &Film) -> Vec<(&'static str, Shows)> {
    let mut all = vec![
        ("R", Shows::Light(0)),
        ("G", Shows::Light(1)),
        ("B", Shows::Light(2)),
        ("sampleCount", Shows::Samples),
    ];
    if film.layers().variance {
        all.extend([
            ("variance.R", Shows::Variance(0)),
            ("variance.G", Shows::Variance(1)),
            ("variance.B", Shows::Variance(2)),
        ]);
    }
    if film.layers().guides {
        all.extend([
            ("albedo.R", Shows::Albedo(0)),
            ("albedo.G", Shows::Albedo(1)),
            ("albedo.B", Shows::Albedo(2)),
            ("normal.X", Shows::Normal(0)),
            ("normal.Y", Shows::Normal(1)),
            ("normal.Z", Shows::Normal(2)),
            ("Z", Shows::Depth),
            ("position.X", Shows::Position(0)),
            ("position.Y", Shows::Position(1)),
            ("position.Z", Shows::Position(2)),
            ("objectId", Shows::Object),
            ("materialId", Shows::Material),
        ]);
    }
    all.sort_by_key(|(name, _)| *name);
    all
}

fn value(film: &Film, x: u32, y: u32, shows: Shows) -> f32 {
    let guide = || film.guide(x, y).unwrap_or_default();
    let center = || film.center(x, y).unwrap_or(crate::Center::SKY);
    match shows {
        Shows::Light(c) => film.light(x, y)[c] as f32,
        Shows::Variance(c) => film.variance(x, y)[c] as f32,
        Shows::Samples => film.samples(x, y) as f32,
        Shows::Albedo(c) => guide().albedo[c] as f32,
        Shows::Normal(c) => guide().normal[c] as f32,
        Shows::Depth => center().depth,
        Shows::Position(c) => center().position[c],
        Shows::Object => center().object as f32,
        Shows::Material => center().material as f32,
    }
}

/// Text as the bytes it has; readers take them for UTF-8.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Writes all layers of the whole picture of a film, black where its window does not reach. The name of the scene and the settings become the
/// comment, a line `name = value` each.
///
/// # Errors
/// If the disk says no; nothing is left behind then, and a file that was there before stays as it was.
pub fn write_exr(path: impl AsRef<Path>, film: &Film, recipe: &Recipe) -> Result<(), ExrError> {
    let channels = channels(film);
    let names: Vec<_> = channels.iter().map(|(name, _)| *name).collect();
    let value = |channel: usize, x, y| value(film, x, y, channels[channel].1);
    write_channels(path.as_ref(), film.size(), &names, &recipe.lines(), value)
}

/// Writes channels, whose names are in order, row by row.
fn write_channels(
    path: &Path,
    [width, height]: [u32; 2],
    names: &[&str],
    comments: &str,
    value: impl Fn(usize, u32, u32) -> f32,
) -> Result<(), ExrError> {
    let descriptions = names
        .iter()
        .map(|name| ChannelDescription::new(text(name), SampleType::F32, false))
        .collect();
    let size = (width as usize, height as usize);
    let mut header = Header::new(text(""), size, descriptions).with_encoding(
        Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    header.own_attributes.layer_name = None;
    header.own_attributes.software_name = Some(text(SOFTWARE));
    header.own_attributes.comments = Some(text(comments));
    header.shared_attributes.chromaticities = Some(Chromaticities {
        red: exr::math::Vec2(0.64, 0.33),
        green: exr::math::Vec2(0.3, 0.6),
        blue: exr::math::Vec2(0.15, 0.06),
        white: exr::math::Vec2(0.3127, 0.329),
    });
    let fill = |out: &mut BufWriter<&mut std::fs::File>| {
        block::write(out, [header].into_iter().collect(), true, |meta, chunks| {
            let blocks = meta.collect_ordered_blocks(|index| {
                UncompressedBlock::from_lines(&meta.headers[0].channels, index, |line| {
                    let at = line.location;
                    let (x, y) = (at.position.x() as u32, at.position.y() as u32);
                    for (i, bytes) in line.value.chunks_exact_mut(4).enumerate() {
                        let v = value(at.channel, x + i as u32, y);
                        bytes.copy_from_slice(&v.to_ne_bytes());
                    }
                })
            });
            chunks.on_progress(|_| {}).compress_all_blocks_parallel(&meta, blocks)
        })
    };
    write_whole(path, |out| fill(out).map_err(Fault)).map_err(|fault| fault.at(path))
}

/// What wrote a file.
pub(crate) const SOFTWARE: &str = concat!("Rondure ", env!("CARGO_PKG_VERSION"));

impl Recipe {
    /// Scene and settings, a line `name = value` each.
    fn lines(&self) -> String {
        self.texts().map(|(key, value)| format!("{key} = {value}\n")).collect()
    }

    /// Scene and settings as names and values, for the descriptions in picture files.
    pub fn texts(&self) -> impl Iterator<Item = (&str, String)> {
        let digest = self.scene.iter().map(|byte| format!("{byte:02x}")).collect();
        [("scene", self.name.clone()), ("sha256", digest), ("spp", self.spp.to_string())]
            .into_iter()
            .chain(self.settings.iter().map(|(key, value)| (key.as_str(), value.clone())))
    }
}

struct Fault(exr::error::Error);

impl From<std::io::Error> for Fault {
    fn from(error: std::io::Error) -> Self {
        Self(error.into())
    }
}

impl Fault {
    fn at(self, path: &Path) -> ExrError {
        let path = path.to_owned();
        match self.0 {
            exr::error::Error::Io(source) => ExrError::Io { path, source },
            other => ExrError::Invalid { path, reason: other.to_string() },
        }
    }
}

/// The channels of an OpenEXR picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPicture {
    /// Width and height.
    pub size: [u32; 2],
    /// Names and values of the channels, rows from the top.
    pub channels: Vec<(String, Vec<f32>)>,
    /// The comment, empty if there is none.
    pub comments: String,
}

impl ExrPicture {
    /// The values of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }

    /// The line `name = value` of the comment, if it has one: the settings of pictures that Rondure made.
    pub fn setting(&self, name: &str) -> Option<&str> {
        let lines = self.comments.lines().filter_map(|line| line.split_once(" = "));
        lines.clone().find(|(key, _)| *key == name).map(|(_, value)| value)
    }

    /// Writes all channels and the comment, in 32-bit floats.
    ///
    /// # Errors
    /// If the channels do not have the picture's size, or the disk says no; nothing is left behind then, and a file that was there before stays
    /// as it was.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), ExrError> {
        let path = path.as_ref();
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        if let Some((name, _)) = self.channels.iter().find(|(_, v)| v.len() as u64 != pixels) {
            let reason = format!("channel {name} has not as many values as the picture");
            return Err(ExrError::Invalid { path: path.to_owned(), reason });
        }
        let mut channels: Vec<_> = self.channels.iter().collect();
        channels.sort_by_key(|(name, _)| name);
        let names: Vec<_> = channels.iter().map(|(name, _)| name.as_str()).collect();
        let width = self.size[0] as usize;
        let value = |channel: usize, x, y| channels[channel].1[y as usize * width + x as usize];
        write_channels(path, self.size, &names, &self.comments, value)
    }

    /// Reads the first part of a file; its first level, if it has several.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, or uses what is not supported.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ExrError> {
        let path = path.as_ref();
        let file = std::fs::File::open(path)
            .map_err(|source| ExrError::Io { path: path.to_owned(), source })?;
        read_channels(BufReader::new(file)).map_err(|error| Fault(error).at(path))
    }
}

fn read_channels(file: impl Read + Seek + Send) -> exr::error::Result<ExrPicture> {
    use exr::prelude::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(file)?;
    let layer = image.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let values = match channel.sample_data {
            FlatSamples::F16(values) => values.into_iter().map(f16::to_f32).collect(),
            FlatSamples::F32(values) => values,
            FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
        };
        (channel.name.to_string(), values)
    });
    Ok(ExrPicture {
        size: [layer.size.0 as u32, layer.size.1 as u32],
        channels: channels.collect(),
        comments: String::from_utf8_lossy(
            layer.attributes.comments.as_ref().map_or(&[], |text| text.bytes()),
        )
        .into_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Center, Guide, Layers, PixelSample, Window};

    fn film(width: u32, height: u32, layers: Layers) -> Film {
        let mut film = Film::new([width, height], Window::whole(width, height), layers).unwrap();
        for y in 0..height {
            for x in 0..width {
                for s in 0..3 {
                    let v = f64::from(x + s);
                    let light = [v, 0.5 * v, 1e4 + f64::from(y)];
                    let guide = Guide { albedo: [0.25, 0.5, 0.75], normal: [0.0, -0.6, 0.8] };
                    assert!(film.add(x, y, &PixelSample { light, negative: false, guide }));
                }
                let position = [x as f32, -(y as f32), 1e-3];
                film.set_center(x, y, Center { depth: 7.5, position, object: 1 + x, material: 2 });
            }
        }
        film
    }

    fn recipe() -> Recipe {
        let settings = vec![("seed".to_owned(), "3".to_owned())];
        Recipe { name: "kännchen.toml".to_owned(), scene: [0xab; 32], spp: 3, settings }
    }

    #[test]
    fn what_was_read_can_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &film(33, 17, Layers::ALL), &recipe()).unwrap();
        let mut picture = ExrPicture::read(&path).unwrap();
        assert_eq!((picture.setting("seed"), picture.setting("sead")), (Some("3"), None));
        picture.channels[0].1[5] = f32::NAN;
        picture.channels[1].1[5] = -7.25;
        picture.write(&path).unwrap();
        let again = ExrPicture::read(&path).unwrap();
        assert!(again.channels[0].1[5].is_nan());
        picture.channels[0].1[5] = 0.0;
        let mut same = again.clone();
        same.channels[0].1[5] = 0.0;
        assert!(same == picture && same.comments.contains("kännchen"));
        picture.channels[2].1.pop();
        assert!(matches!(picture.write(&path), Err(ExrError::Invalid { .. })));
        assert_eq!(ExrPicture::read(&path).unwrap().channels.len(), again.channels.len());
    }

    #[test]
    fn all_layers_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for (width, height) in [(16, 16), (1, 10_000), (33, 17)] {
            let film = film(width, height, Layers::ALL);
            write_exr(&path, &film, &recipe()).unwrap();
            let read = ExrPicture::read(&path).unwrap();
            assert_eq!(read.size, [width, height]);
            let names: Vec<_> = read.channels.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(names, channels(&film).iter().map(|(name, _)| *name).collect::<Vec<_>>());
            assert_eq!(names.len(), 19);
            for (name, shows) in channels(&film) {
                let values = read.channel(name).unwrap();
                for y in 0..height {
                    for x in 0..width {
                        let found = values[(y * width + x) as usize];
                        assert_eq!(found, value(&film, x, y, shows), "{name} {x} {y}");
                    }
                }
            }
            let at = |name: &str, i: usize| read.channel(name).unwrap()[i];
            assert_eq!([at("R", 0), at("G", 0), at("B", 0)], [1.0, 0.5, 1e4]);
            assert_eq!([at("variance.R", 0), at("variance.B", 0)], [1.0 / 3.0, 0.0]);
            assert_eq!([at("normal.Y", 0), at("albedo.B", 0), at("Z", 0)], [-0.6, 0.75, 7.5]);
            assert_eq!(
                [at("objectId", 0), at("materialId", 0), at("sampleCount", 0)],
                [1.0, 2.0, 3.0]
            );
            assert!(read.comments.starts_with("scene = kännchen.toml\n"));
            assert!(read.comments.contains("seed = 3\n") && read.comments.contains("abab"));
        }
    }

    #[test]
    fn files_have_the_same_bytes_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        let film = film(40, 70, Layers { variance: true, guides: false });
        write_exr(&a, &film, &recipe()).unwrap();
        write_exr(&b, &film, &recipe()).unwrap();
        assert!(std::fs::read(&a).unwrap() == std::fs::read(&b).unwrap());
        assert_eq!(ExrPicture::read(&a).unwrap().channels.len(), 7);
    }

    #[test]
    fn bad_files_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &film(20, 20, Layers::ALL), &recipe()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(97) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(ExrPicture::read(&path).is_err(), "{length}");
        }
        let lost = folder.path().join("no/a.exr");
        let error = write_exr(&lost, &film(2, 2, Layers::ALL), &recipe()).unwrap_err();
        assert!(matches!(error, ExrError::Io { .. }));
        assert!(matches!(ExrPicture::read(&lost), Err(ExrError::Io { .. })));
    }
}

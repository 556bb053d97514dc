//! OpenEXR files: all layers of a film in one part, in 32-bit floats, row by row, so that no second picture is held in memory.
//!
//! The names of channels are those that compositing programs know: `R G B` is the picture and `Z` its depth, further layers are named
//! before a point. Numbers of objects and materials are floats too, since most readers take nothing else; they are exact up to 2^24.

use std::{
    io::{BufReader, BufWriter, Read, Seek},
    path::{Path, PathBuf},
};

use exr::{
    block::{self, BlockIndex, UncompressedBlock, writer::ChunksWriter},
    meta::{BlockDescription, header::Header},
    prelude::{
        Compression, LineOrder, SampleType, Text,
        attribute::{ChannelDescription, Chromaticities},
    },
};

use rondure_image::file::write_whole;

use crate::{Film, Layers, Recipe, Spool, SpoolError, Window};

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
    /// The sums of the picture cannot be read.
    #[error("cannot write `{}`: {source}", path.display())]
    Sums {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: SpoolError,
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
fn channels(layers: Layers) -> Vec<(&'static str, Shows)> {
    let mut all = vec![
        ("R", Shows::Light(0)),
        ("G", Shows::Light(1)),
        ("B", Shows::Light(2)),
        ("sampleCount", Shows::Samples),
    ];
    if layers.variance {
        all.extend([
            ("variance.R", Shows::Variance(0)),
            ("variance.G", Shows::Variance(1)),
            ("variance.B", Shows::Variance(2)),
        ]);
    }
    if layers.guides {
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

/// What channels show of a pixel, in their order. Each layer is worked out once.
fn values<'a>(
    film: &Film,
    x: u32,
    y: u32,
    channels: &'a [(&str, Shows)],
) -> impl Iterator<Item = f32> + use<'a> {
    let (light, variance, samples) = (film.light(x, y), film.variance(x, y), film.samples(x, y));
    let guide = film.guide(x, y).unwrap_or_default();
    let center = film.center(x, y).unwrap_or(crate::Center::SKY);
    channels.iter().map(move |(_, shows)| match *shows {
        Shows::Light(c) => light[c] as f32,
        Shows::Variance(c) => variance[c] as f32,
        Shows::Samples => samples as f32,
        Shows::Albedo(c) => guide.albedo[c] as f32,
        Shows::Normal(c) => guide.normal[c] as f32,
        Shows::Depth => center.depth,
        Shows::Position(c) => center.position[c],
        Shows::Object => center.object as f32,
        Shows::Material => center.material as f32,
    })
}

/// Text as the bytes it has; readers take them for UTF-8.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Writes all layers of the whole picture, black where the window of the sums does not reach. The name of the scene and the settings become the
/// comment, a line `name = value` each.
///
/// # Errors
/// If the disk says no, or the sums cannot be read; nothing is left behind then, and a file that was there before stays as it was.
pub fn write_exr(path: impl AsRef<Path>, sums: &Spool, recipe: &Recipe) -> Result<(), ExrError> {
    let channels = channels(sums.layers());
    let names: Vec<_> = channels.iter().map(|(name, _)| *name).collect();
    let [width, _] = sums.size();
    let rows = |y, height| {
        let film = sums.view(Window { x: 0, y, width, height })?;
        let mut planes = vec![Vec::new(); channels.len()];
        for (x, y) in (y..y + height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let values = values(&film, x, y, &channels);
            planes.iter_mut().zip(values).for_each(|(plane, v)| plane.push(v));
        }
        Ok(planes)
    };
    write_channels(path.as_ref(), sums.size(), &names, &recipe.lines(), rows)
}

/// Writes channels, whose names are in order, some rows at a time: `rows` takes the first of them and how many, and gives their values for each channel.
fn write_channels<P: AsRef<[f32]>>(
    path: &Path,
    [width, height]: [u32; 2],
    names: &[&str],
    comments: &str,
    mut rows: impl FnMut(u32, u32) -> Result<Vec<P>, SpoolError>,
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
        let mut unread = None;
        block::write(out, [header].into_iter().collect(), true, |meta, chunks| {
            let mut block = |index: BlockIndex| {
                let (y, height) = (index.pixel_position.y() as u32, index.pixel_size.height());
                let planes = rows(y, height as u32).map_err(|error| unread = Some(error));
                let planes = planes.unwrap_or_default();
                UncompressedBlock::from_lines(&meta.headers[0].channels, index, |line| {
                    let at = line.location;
                    let start = (at.position.y() - y as usize) * width as usize;
                    let row = planes.get(at.channel).map(|plane| &plane.as_ref()[start..]);
                    // Nothing is kept of a file of which rows are missing.
                    let row = row.unwrap_or_default();
                    for (bytes, v) in line.value.chunks_exact_mut(4).zip(row) {
                        bytes.copy_from_slice(&v.to_ne_bytes());
                    }
                })
            };
            let blocks = meta.collect_ordered_blocks(&mut block);
            chunks.on_progress(|_| {}).compress_all_blocks_parallel(&meta, blocks)
        })?;
        match unread {
            Some(error) => Err(Fault::Sums(error)),
            None => Ok(()),
        }
    };
    write_whole(path, fill).map_err(|fault| fault.at(path))
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

enum Fault {
    Exr(exr::error::Error),
    Sums(SpoolError),
}

impl From<exr::error::Error> for Fault {
    fn from(error: exr::error::Error) -> Self {
        Self::Exr(error)
    }
}

impl From<std::io::Error> for Fault {
    fn from(error: std::io::Error) -> Self {
        Self::Exr(error.into())
    }
}

impl Fault {
    fn at(self, path: &Path) -> ExrError {
        let path = path.to_owned();
        match self {
            Self::Exr(exr::error::Error::Io(source)) => ExrError::Io { path, source },
            Self::Exr(other) => ExrError::Invalid { path, reason: other.to_string() },
            Self::Sums(source) => ExrError::Sums { path, source },
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
        let rows = |y: u32, height: u32| {
            let place = y as usize * width..(y + height) as usize * width;
            Ok(channels.iter().map(|(_, values)| &values[place.clone()]).collect())
        };
        write_channels(path, self.size, &names, &self.comments, rows)
    }

    /// Reads the first part of a file; its first level, if it has several.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, or uses what is not supported.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ExrError> {
        let path = path.as_ref();
        let file = std::fs::File::open(path)
            .map_err(|source| ExrError::Io { path: path.to_owned(), source })?;
        read_channels(BufReader::new(file)).map_err(|error| Fault::from(error).at(path))
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
    use crate::{Center, Guide, PixelSample, Room};

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
        write_exr(&path, &film(33, 17, Layers::ALL).into(), &recipe()).unwrap();
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
            write_exr(&path, &film.clone().into(), &recipe()).unwrap();
            let read = ExrPicture::read(&path).unwrap();
            assert_eq!(read.size, [width, height]);
            let names: Vec<_> = read.channels.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(
                names,
                channels(film.layers()).iter().map(|(name, _)| *name).collect::<Vec<_>>()
            );
            assert_eq!(names.len(), 19);
            let all = channels(film.layers());
            for y in 0..height {
                for x in 0..width {
                    for ((name, _), v) in all.iter().zip(values(&film, x, y, &all)) {
                        let found = read.channel(name).unwrap()[(y * width + x) as usize];
                        assert_eq!(found, v, "{name} {x} {y}");
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
        let few = Layers { variance: true, guides: false };
        write_exr(&a, &film(40, 70, few).into(), &recipe()).unwrap();
        assert_eq!(ExrPicture::read(&a).unwrap().channels.len(), 7);
        // In memory and in a scratch file, the second time a part of a picture.
        let part = Window { x: 5, y: 20, width: 30, height: 41 };
        let mut cut = Film::new([40, 70], part, Layers::ALL).unwrap();
        for (x, y) in (0..30 * 41).map(|i| (5 + i % 30, 20 + i / 30)) {
            let light = [f64::from(x), f64::from(y), 0.5];
            let guide = Guide::default();
            assert!(cut.add(x, y, &PixelSample { light, negative: false, guide }));
        }
        for film in [film(40, 70, few), cut] {
            let room = Room { memory: 0, folder: folder.path().to_owned() };
            let mut scratch = Spool::new(film.size(), film.window(), film.layers(), &room).unwrap();
            scratch.merge(&film).unwrap();
            write_exr(&a, &film.into(), &recipe()).unwrap();
            write_exr(&b, &scratch, &recipe()).unwrap();
            assert!(std::fs::read(&a).unwrap() == std::fs::read(&b).unwrap());
        }
        let picture = ExrPicture::read(&b).unwrap();
        let row = &picture.channel("G").unwrap()[30 * 40..31 * 40];
        assert_eq!((row[4], row[5], row[34], row[35]), (0.0, 30.0, 30.0, 0.0));
    }

    #[test]
    fn bad_files_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &film(20, 20, Layers::ALL).into(), &recipe()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(97) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(ExrPicture::read(&path).is_err(), "{length}");
        }
        let lost = folder.path().join("no/a.exr");
        let error = write_exr(&lost, &film(2, 2, Layers::ALL).into(), &recipe()).unwrap_err();
        assert!(matches!(error, ExrError::Io { .. }));
        assert!(matches!(ExrPicture::read(&lost), Err(ExrError::Io { .. })));
    }
}

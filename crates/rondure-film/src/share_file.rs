//! Files of shares (`.rdf`), for parts of pictures and for checkpoints: docs/film.md describes the format.
//!
//! Two checksums: that of the header is proved before anything in it is believed, so that a damaged length never becomes a request
//! for memory; that of the sums stands at the end.

use std::{
    fs::File,
    io::{self, BufReader, BufWriter, Read, Write},
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use rondure_image::file::{self, write_whole};

use crate::{
    Layers, Portion, Recipe, Room, Share, Spool, SpoolError, Statistics, Window,
    record::{self, Fields, put_words},
};

const MAGIC: [u8; 8] = *b"RONDURE\x1a";
/// The version of the format.
const VERSION: u32 = 1;
const CHECKSUM: u64 = 32;
/// More than any header has: a million portions.
const LARGEST_HEADER: u64 = 64 << 20;

/// Why a file of a share cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShareError {
    /// The disk says no.
    #[error("`{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: io::Error,
    },
    /// It is another kind of file.
    #[error("`{}` is not a part of a picture or a checkpoint", .0.display())]
    NotAShare(PathBuf),
    /// It was written by another version of Rondure.
    #[error("`{}` has version {found} of the format; this program reads version {VERSION}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// The file ends too early.
    #[error("`{}` is cut off: it has {found} bytes of {expected}", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// How many bytes there are.
        found: u64,
        /// How many bytes there should be.
        expected: u64,
    },
    /// Some bytes have changed since it was written.
    #[error("`{}` is damaged: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: &'static str,
    },
    /// There is no room for its sums, or they cannot be read.
    #[error("`{}`: {source}", path.display())]
    Sums {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: SpoolError,
    },
}

/// A share to be written.
#[derive(Clone, Copy, Debug)]
pub struct ShareRef<'a> {
    /// See [`Share`].
    pub recipe: &'a Recipe,
    /// See [`Share`].
    pub part: Option<(u32, u32)>,
    /// See [`Share`].
    pub covered: &'a [Portion],
    /// See [`Share`].
    pub sums: &'a Spool,
    /// See [`Share`].
    pub statistics: &'a Statistics,
}

impl Share {
    /// The same, borrowed.
    pub fn as_ref(&self) -> ShareRef<'_> {
        let Self { recipe, part, covered, sums, statistics } = self;
        ShareRef { recipe, part: *part, covered, sums, statistics }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, is of another kind or version, ends early, or is damaged, or there is no room for it.
    pub fn read(path: impl AsRef<Path>, room: &Room) -> Result<Self, ShareError> {
        let path = path.as_ref();
        read(path, room).map_err(|fault| fault.at(path))
    }
}

impl ShareRef<'_> {
    /// Writes a file. It appears under its name only when it is whole and on the disk.
    ///
    /// # Errors
    /// If the disk says no; nothing is left behind then, and a file that was there before stays as it was.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), ShareError> {
        let path = path.as_ref();
        write_whole(path, |out| self.fill(out)).map_err(|fault: Fault| fault.at(path))
    }

    /// The same for a file that nobody else writes. A process that is killed in between leaves the old file, and beside it [`ShareRef::unfinished`].
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_alone(&self, path: impl AsRef<Path>) -> Result<(), ShareError> {
        let path = path.as_ref();
        file::write_whole_alone(path, |out| self.fill(out)).map_err(|fault: Fault| fault.at(path))
    }

    /// The name that a file has before it is whole, if nobody else writes it.
    pub fn unfinished(path: impl AsRef<Path>) -> PathBuf {
        file::new_name(path.as_ref())
    }

    fn fill(&self, out: &mut BufWriter<&mut File>) -> Result<(), Fault> {
        let header = self.header();
        out.write_all(&MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        out.write_all(&(header.len() as u64).to_le_bytes())?;
        out.write_all(&header)?;
        out.write_all(&header_checksum(&header))?;
        let mut hash = Sha256::new();
        self.sums.each_row(|row| {
            hash.update(row);
            Ok::<_, Fault>(out.write_all(row)?)
        })?;
        Ok(out.write_all(&hash.finalize())?)
    }

    fn header(&self) -> Vec<u8> {
        let mut to = Vec::new();
        let text = |to: &mut Vec<u8>, text: &str| {
            put_words(to, &[text.len() as u32]);
            to.extend_from_slice(text.as_bytes());
        };
        let Recipe { name, scene, spp, settings } = self.recipe;
        to.extend_from_slice(scene);
        text(&mut to, name);
        put_words(&mut to, &[*spp, settings.len() as u32]);
        for (key, value) in settings {
            text(&mut to, key);
            text(&mut to, value);
        }
        let window = self.sums.window();
        let layers = self.sums.layers();
        put_words(&mut to, &self.sums.size());
        put_words(&mut to, &[window.x, window.y, window.width, window.height]);
        put_words(&mut to, &[u32::from(layers.variance) | u32::from(layers.guides) << 1]);
        let (part, parts) = self.part.unwrap_or((0, 0));
        put_words(&mut to, &[part, parts]);
        let counters = self.statistics.counters();
        put_words(&mut to, &[counters.len() as u32]);
        counters.iter().for_each(|n| to.extend_from_slice(&n.to_le_bytes()));
        put_words(&mut to, &[self.covered.len() as u32]);
        for Portion { window, samples } in self.covered {
            put_words(&mut to, &[window.x, window.y, window.width, window.height]);
            put_words(&mut to, &[samples.start, samples.end]);
        }
        to
    }
}

fn header_checksum(header: &[u8]) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(MAGIC);
    hash.update(VERSION.to_le_bytes());
    hash.update((header.len() as u64).to_le_bytes());
    hash.update(header);
    hash.finalize().into()
}

/// What is wrong with a file, whose name comes later.
enum Fault {
    Io(io::Error),
    NotAShare,
    Version(u32),
    CutOff { found: u64, expected: u64 },
    Damaged(&'static str),
    Sums(SpoolError),
}

impl Fault {
    fn at(self, path: &Path) -> ShareError {
        let path = path.to_owned();
        match self {
            Self::Io(source) => ShareError::Io { path, source },
            Self::NotAShare => ShareError::NotAShare(path),
            Self::Version(found) => ShareError::Version { path, found },
            Self::CutOff { found, expected } => ShareError::CutOff { path, found, expected },
            Self::Damaged(what) => ShareError::Damaged { path, what },
            Self::Sums(source) => ShareError::Sums { path, source },
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<SpoolError> for Fault {
    fn from(error: SpoolError) -> Self {
        Self::Sums(error)
    }
}

fn read(path: &Path, room: &Room) -> Result<Share, Fault> {
    let file = File::open(path)?;
    let meta = file.metadata()?;
    if meta.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory).into());
    }
    read_from(BufReader::with_capacity(1 << 20, file), meta.len(), room)
}

/// Reads a share from its `found` bytes.
fn read_from(mut file: impl Read, found: u64, room: &Room) -> Result<Share, Fault> {
    let start = 8 + 4 + 8;
    let mut bytes = [0; 20];
    // Whatever begins as a share does and stops there is a share cut off.
    let begun = usize::try_from(found.min(8)).unwrap_or(8);
    file.read_exact(&mut bytes[..begun])?;
    if begun == 0 || bytes[..begun] != MAGIC[..begun] {
        return Err(Fault::NotAShare);
    }
    if found < start {
        return Err(Fault::CutOff { found, expected: start });
    }
    file.read_exact(&mut bytes[8..])?;
    let mut fields = Fields { rest: &bytes[8..] };
    let version = fields.word().ok_or(Fault::NotAShare)?;
    if version != VERSION {
        return Err(Fault::Version(version));
    }
    let length = fields.long().ok_or(Fault::NotAShare)?;
    if length > LARGEST_HEADER {
        return Err(Fault::Damaged("the length of its header cannot be"));
    }
    let sums_at = start + length + CHECKSUM;
    if found < sums_at {
        return Err(Fault::CutOff { found, expected: sums_at });
    }
    let mut header = vec![0; length as usize];
    file.read_exact(&mut header)?;
    let mut checksum = [0; CHECKSUM as usize];
    file.read_exact(&mut checksum)?;
    if checksum != header_checksum(&header) {
        return Err(Fault::Damaged("the checksum of its header is wrong"));
    }
    let mut fields = Fields { rest: &header };
    let share = fields.share().filter(|_| fields.rest.is_empty());
    let Header { recipe, size, window, layers, part, statistics, covered } =
        share.ok_or(Fault::Damaged("its header cannot be understood"))?;
    let expected = sums_at + window.pixels().saturating_mul(record::bytes(layers)) + CHECKSUM;
    if found < expected {
        return Err(Fault::CutOff { found, expected });
    }
    if found > expected {
        return Err(Fault::Damaged("there is something behind its end"));
    }
    let mut hash = Sha256::new();
    let sums = Spool::filled(size, window, layers, room, |row| {
        file.read_exact(row)?;
        hash.update(row);
        Ok::<_, Fault>(())
    })?;
    file.read_exact(&mut checksum)?;
    if checksum != <[u8; 32]>::from(hash.finalize()) {
        return Err(Fault::Damaged("the checksum of its sums is wrong"));
    }
    Ok(Share { recipe, part, covered, sums, statistics })
}

struct Header {
    recipe: Recipe,
    size: [u32; 2],
    window: Window,
    layers: Layers,
    part: Option<(u32, u32)>,
    statistics: Statistics,
    covered: Vec<Portion>,
}

impl Fields<'_> {
    fn text(&mut self) -> Option<String> {
        let length = self.word()? as usize;
        let (head, rest) = self.rest.split_at_checked(length)?;
        self.rest = rest;
        String::from_utf8(head.to_vec()).ok()
    }

    fn window(&mut self) -> Option<Window> {
        Some(Window { x: self.word()?, y: self.word()?, width: self.word()?, height: self.word()? })
    }

    fn share(&mut self) -> Option<Header> {
        let scene = self.array()?;
        let name = self.text()?;
        let (spp, count) = (self.word()?, self.word()?);
        let settings =
            (0..count).map(|_| Some((self.text()?, self.text()?))).collect::<Option<_>>()?;
        let recipe = Recipe { name, scene, spp, settings };
        let size = [self.word()?, self.word()?];
        let window = self.window()?;
        let flags = self.word()?;
        let layers = Layers { variance: flags & 1 != 0, guides: flags & 2 != 0 };
        let part = match (self.word()?, self.word()?) {
            (0, 0) => None,
            part => Some(part),
        };
        let count = self.word()?;
        let counters = (0..count).map(|_| self.long()).collect::<Option<Vec<_>>>()?;
        let statistics = Statistics::from_counters(&counters)?;
        let count = self.word()?;
        let covered = (0..count)
            .map(|_| Some(Portion { window: self.window()?, samples: self.word()?..self.word()? }))
            .collect::<Option<Vec<_>>>()?;
        let fits = covered.iter().all(|p| window.contains(&p.window)) && flags < 4;
        fits.then_some(Header { recipe, size, window, layers, part, statistics, covered })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::{Center, Film, Guide, PixelSample};

    fn share(layers: Layers) -> Share {
        let size = [9, 7];
        let window = Window { x: 2, y: 1, width: 5, height: 4 };
        let mut film = Film::new(size, window, layers).unwrap();
        for y in 1..5 {
            for x in 2..7 {
                for s in 0..x % 3 {
                    let light = [f64::from(x) * 1e6, -0.1 * f64::from(y), 1e-9 * f64::from(s)];
                    let guide = Guide { albedo: [0.1, 0.2, 0.3], normal: [0.0, -0.6, 0.8] };
                    assert!(film.add(x, y, &PixelSample { light, negative: s == 1, guide }));
                }
            }
        }
        film.set_center(
            4,
            2,
            Center { depth: 2.5, position: [1.0, -2.0, 3.0], object: 7, material: 3 },
        );
        let settings =
            vec![("seed".to_owned(), "3".to_owned()), ("filter".to_owned(), "é".to_owned())];
        let recipe = Recipe { name: "scene.toml".to_owned(), scene: [9; 32], spp: 2, settings };
        let statistics =
            Statistics { camera_rays: 11, shadow_rays: u64::MAX, ..Default::default() };
        let covered = vec![Portion { window, samples: 0..2 }];
        Share { recipe, part: Some((2, 3)), covered, sums: film.into(), statistics }
    }

    #[test]
    fn shares_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rdf");
        for layers in [Layers::default(), Layers { variance: true, guides: false }, Layers::ALL] {
            let share = share(layers);
            share.as_ref().write(&path).unwrap();
            for memory in [u64::MAX, 0] {
                let room = Room { memory, folder: folder.path().to_owned() };
                let read = Share::read(&path, &room).unwrap();
                assert_eq!(read, share);
                let again = folder.path().join("b.rdf");
                read.as_ref().write_alone(&again).unwrap();
                assert_eq!(fs::read(&again).unwrap(), fs::read(&path).unwrap());
            }
        }
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rdf");
        share(Layers::ALL).as_ref().write(&path).unwrap();
        let bytes = fs::read(&path).unwrap();
        let room = Room::default();
        let read = |bytes: &[u8]| {
            let fault = read_from(bytes, bytes.len() as u64, &room).unwrap_err();
            fault.at(&path)
        };
        for length in 1..bytes.len() {
            let error = read(&bytes[..length]);
            let expected = matches!(error, ShareError::CutOff { found, expected, .. }
                if found == length as u64 && expected <= bytes.len() as u64);
            assert!(expected, "{length}: {error}");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            let error = read(&damaged);
            let expected = match at {
                0..8 => matches!(error, ShareError::NotAShare(_)),
                8..12 => matches!(error, ShareError::Version { .. }),
                12..20 => !matches!(error, ShareError::Io { .. } | ShareError::Sums { .. }),
                _ => matches!(error, ShareError::Damaged { .. }),
            };
            assert!(expected, "{at}: {error}");
        }
        let error = read(&[bytes.as_slice(), b"x"].concat());
        assert!(error.to_string().contains("behind its end"));
    }

    #[test]
    fn other_files_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rdf");
        let read = |path: &Path| Share::read(path, &Room::default());
        for other in [&b""[..], b"x", b"\x89PNG\r\n\x1a\n and so on, for quite a while"] {
            fs::write(&path, other).unwrap();
            assert!(matches!(read(&path), Err(ShareError::NotAShare(_))));
        }
        assert!(matches!(read(folder.path()), Err(ShareError::Io { .. })));
        assert!(matches!(read(&folder.path().join("b")), Err(ShareError::Io { .. })));
        let lost = folder.path().join("no/a.rdf");
        assert!(matches!(share(Layers::ALL).as_ref().write(lost), Err(ShareError::Io { .. })));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

//! The sums of a picture of any size: in memory, or in a scratch file where they would take too much of it.
//!
//! A scratch file has no name and goes with the process, however that ends. It holds the window row by row, each pixel as in a file of a share, and
//! is written out in full at first, so that a disk that is too small is found before the work. What is in use is kept in memory by the operating
//! system, as far as nobody else needs it.
//!
//! A [`Film`] of a window is read, added to, and written back; its sums are exact, so that the picture is the same in both places, bit for bit.

use std::{
    borrow::Cow,
    env,
    fs::File,
    io::{self, BufWriter, Read, Seek, SeekFrom, Write},
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

use crate::{
    Film, FilmError, Layers, Window,
    film::vec_of,
    record::{self, Fields},
};

/// How much memory there is for the sums of a picture, and where they go if that is too little.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Room {
    /// The most bytes that the sums of a picture take in memory.
    pub memory: u64,
    /// The folder of scratch files.
    pub folder: PathBuf,
}

impl Default for Room {
    /// As much memory as there is.
    fn default() -> Self {
        Self { memory: u64::MAX, folder: env::temp_dir() }
    }
}

impl Room {
    /// Whether the sums of a window have room in memory.
    fn holds(&self, window: Window, layers: Layers) -> bool {
        window.pixels().saturating_mul(record::bytes(layers)) <= self.memory
    }
}

/// Why sums cannot be kept.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SpoolError {
    /// They cannot be added, or do not fit into memory.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// The scratch file cannot be written or read.
    #[error("cannot keep the sums of the picture in `{}`: {source}", folder.display())]
    Io {
        /// The folder of the scratch file.
        folder: PathBuf,
        /// What went wrong.
        source: io::Error,
    },
}

/// Sums over the samples of the pixels in a window of a picture, as a [`Film`] has them, which need not be in memory.
#[derive(Debug)]
pub struct Spool {
    size: [u32; 2],
    window: Window,
    layers: Layers,
    place: Place,
}

#[derive(Debug)]
enum Place {
    Memory(Film),
    Scratch { folder: PathBuf, file: Mutex<File> },
}

impl From<Film> for Spool {
    fn from(film: Film) -> Self {
        let (size, window, layers) = (film.size(), film.window(), film.layers());
        Self { size, window, layers, place: Place::Memory(film) }
    }
}

#[cfg(test)]
impl PartialEq for Spool {
    fn eq(&self, other: &Self) -> bool {
        self.film().unwrap() == other.film().unwrap()
    }
}

/// The pixels of a window of a file that holds those of `all`.
struct Rows<'a> {
    all: Window,
    window: Window,
    layers: Layers,
    file: &'a mut File,
}

impl Rows<'_> {
    /// Goes to each of the rows, for their bytes to be read or written.
    fn each(&mut self, mut row: impl FnMut(&mut File, u32) -> io::Result<()>) -> io::Result<()> {
        let Self { all, window, layers, .. } = *self;
        for y in window.y..window.y + window.height {
            let pixel = u64::from(y - all.y) * u64::from(all.width) + u64::from(window.x - all.x);
            self.file.seek(SeekFrom::Start(pixel * record::bytes(layers)))?;
            row(self.file, y - window.y)?;
        }
        Ok(())
    }

    fn read(&mut self, film: &mut Film) -> io::Result<()> {
        let width = self.window.width as usize;
        let mut bytes = vec![0; width * record::bytes(self.layers) as usize];
        self.each(|file, row| {
            file.read_exact(&mut bytes)?;
            let mut fields = Fields { rest: &bytes };
            let start = row as usize * width;
            let read = (start..start + width).try_for_each(|i| fields.pixel(film, i));
            read.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
        })
    }

    fn write(&mut self, film: &Film) -> io::Result<()> {
        let width = self.window.width as usize;
        let mut bytes = Vec::new();
        self.each(|file, row| {
            bytes.clear();
            let start = row as usize * width;
            (start..start + width).for_each(|i| record::put(&mut bytes, film, i));
            file.write_all(&bytes)
        })
    }
}

impl Spool {
    /// Sums without light for a `window` of a picture of `size` (width and height) pixels.
    ///
    /// # Errors
    /// If the window is empty or not within the picture, or there is not enough room.
    pub fn new(
        size: [u32; 2],
        window: Window,
        layers: Layers,
        room: &Room,
    ) -> Result<Self, SpoolError> {
        if room.holds(window, layers) {
            return Ok(Film::new(size, window, layers)?.into());
        }
        let mut empty = Vec::new();
        record::put(&mut empty, &Film::new([1, 1], Window::whole(1, 1), layers)?, 0);
        Self::filled(size, window, layers, room, |row| {
            row.chunks_exact_mut(empty.len()).for_each(|pixel| pixel.copy_from_slice(&empty));
            Ok(())
        })
    }

    /// Sums whose rows `fill` gives one after the other, as bytes.
    pub(crate) fn filled<E: From<SpoolError>>(
        size: [u32; 2],
        window: Window,
        layers: Layers,
        room: &Room,
        mut fill: impl FnMut(&mut [u8]) -> Result<(), E>,
    ) -> Result<Self, E> {
        Film::check(size, window).map_err(SpoolError::from)?;
        let too_large = || SpoolError::from(FilmError::TooLarge(window.pixels()));
        let row = u64::from(window.width) * record::bytes(layers);
        let row = usize::try_from(row).ok().and_then(|bytes| vec_of(0, bytes));
        let mut row = row.ok_or_else(too_large)?;
        let place = if room.holds(window, layers) {
            let mut film = Film::new(size, window, layers).map_err(SpoolError::from)?;
            let width = window.width as usize;
            for start in (0..window.height as usize).map(|y| y * width) {
                fill(&mut row)?;
                let mut fields = Fields { rest: &row };
                // The row is as long as its pixels.
                let _all = (start..start + width).try_for_each(|i| fields.pixel(&mut film, i));
            }
            Place::Memory(film)
        } else {
            let folder = room.folder.clone();
            let failed = |source| SpoolError::Io { folder: folder.clone(), source };
            let file = tempfile::tempfile_in(&folder).map_err(failed)?;
            let mut out = BufWriter::with_capacity(1 << 20, file);
            for _ in 0..window.height {
                fill(&mut row)?;
                out.write_all(&row).map_err(failed)?;
            }
            let file = out.into_inner().map_err(|error| failed(error.into_error()))?;
            Place::Scratch { folder, file: Mutex::new(file) }
        };
        Ok(Self { size, window, layers, place })
    }

    /// The size of the whole picture, width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The part of the picture of which there are sums.
    pub fn window(&self) -> Window {
        self.window
    }

    /// What there is beside the light.
    pub fn layers(&self) -> Layers {
        self.layers
    }

    /// A film with what there is of `window`, and perhaps with more.
    ///
    /// # Errors
    /// If it cannot be read or does not fit into memory.
    pub fn view(&self, window: Window) -> Result<Cow<'_, Film>, SpoolError> {
        match &self.place {
            Place::Memory(film) => Ok(Cow::Borrowed(film)),
            Place::Scratch { folder, file } => {
                let Some(window) = self.window.common(&window) else {
                    return Ok(Cow::Owned(Film::without_pixels(self.size, self.layers)));
                };
                let mut film = Film::new(self.size, window, self.layers)?;
                let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                let (all, layers) = (self.window, self.layers);
                Rows { all, window, layers, file: &mut file }
                    .read(&mut film)
                    .map_err(|source| SpoolError::Io { folder: folder.clone(), source })?;
                Ok(Cow::Owned(film))
            }
        }
    }

    /// All of it as a film.
    ///
    /// # Errors
    /// As [`view`](Self::view).
    pub fn film(&self) -> Result<Cow<'_, Film>, SpoolError> {
        self.view(self.window)
    }

    /// Adds the samples of a film of the same picture, whose window lies in this one's.
    ///
    /// # Errors
    /// If that is not so, or a pixel would have too many samples; nothing is added then. If a scratch file cannot be written its sums are of no more use.
    pub fn merge(&mut self, part: &Film) -> Result<(), SpoolError> {
        let (size, all, layers) = (self.size, self.window, self.layers);
        match &mut self.place {
            Place::Memory(film) => Ok(film.merge(part)?),
            Place::Scratch { folder, file } => {
                if size != part.size() || layers != part.layers() {
                    return Err(FilmError::Different.into());
                }
                let window = part.window();
                if !all.contains(&window) {
                    return Err(FilmError::Outside { window, size }.into());
                }
                let mut sum = Film::new(size, window, layers)?;
                let file = file.get_mut().unwrap_or_else(PoisonError::into_inner);
                let mut rows = Rows { all, window, layers, file };
                let failed = |source| SpoolError::Io { folder: folder.clone(), source };
                rows.read(&mut sum).map_err(failed)?;
                sum.merge(part)?;
                rows.write(&sum).map_err(failed)
            }
        }
    }

    /// Adds other sums, band by band.
    ///
    /// # Errors
    /// As [`merge`](Self::merge), but bands before the one at fault have been added.
    pub fn merge_all(&mut self, other: &Self) -> Result<(), SpoolError> {
        match &other.place {
            Place::Memory(film) => self.merge(film),
            Place::Scratch { .. } => {
                other.bands().try_for_each(|band| self.merge(&*other.view(band)?))
            }
        }
    }

    /// All rows, in bands that a film has room for.
    fn bands(&self) -> impl Iterator<Item = Window> + use<> {
        const HEIGHT: u32 = 16;
        let window = self.window;
        (0..window.height).step_by(HEIGHT as usize).map(move |row| Window {
            y: window.y + row,
            height: HEIGHT.min(window.height - row),
            ..window
        })
    }

    /// Gives all rows one after the other, as bytes.
    pub(crate) fn each_row<E: From<SpoolError>>(
        &self,
        mut row: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut bytes = Vec::new();
        for y in 0..self.window.height {
            let window = Window { y: self.window.y + y, height: 1, ..self.window };
            let film = self.view(window)?;
            let width = window.width as usize;
            let start = (window.y - film.window().y) as usize * width;
            bytes.clear();
            (start..start + width).for_each(|i| record::put(&mut bytes, &film, i));
            row(&bytes)?;
        }
        Ok(())
    }

    /// How noisy the picture is: the root of the mean variance of its pixels' luminance, as a fraction of their mean luminance. Taken over some
    /// thousands of pixels that are spread evenly, and of those that have two samples or more; `None` if it is not known.
    ///
    /// The channels' errors are taken to go the same way, and samples to be independent, so it is rather too large.
    ///
    /// # Errors
    /// If a scratch file cannot be read.
    pub fn noise(&self) -> Result<Option<f64>, SpoolError> {
        const PIXELS: u64 = 10_000;
        /// Of Rec. 709.
        const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
        let luminance = |rgb: [f64; 3]| (0..3).map(|c| LUMINANCE[c] * rgb[c]).sum::<f64>();
        let all = self.window.pixels();
        let count = all.min(PIXELS);
        let (mut variance, mut light, mut known) = (0.0, 0.0, 0.0);
        for i in 0..count {
            let at = i * all / count;
            let x = self.window.x + (at % u64::from(self.window.width)) as u32;
            let y = self.window.y + (at / u64::from(self.window.width)) as u32;
            let film = self.view(Window { x, y, width: 1, height: 1 })?;
            let error = luminance(film.variance(x, y).map(f64::sqrt));
            if self.layers.variance && error.is_finite() {
                variance += error * error;
                light += luminance(film.light(x, y));
                known += 1.0;
            }
        }
        Ok((light > 0.0).then(|| (variance / known).sqrt() / (light / known)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Center, Guide, MOST_SAMPLES, PixelSample};

    fn sample(light: [f64; 3]) -> PixelSample {
        let guide = Guide { albedo: [0.5, 0.25, 1.0], normal: [0.0, -1.0, 0.0] };
        PixelSample { light, negative: false, guide }
    }

    /// A film of a window with light that tells its place.
    fn part(size: [u32; 2], window: Window, layers: Layers, number: u32) -> Film {
        let mut film = Film::new(size, window, layers).unwrap();
        for y in window.y..window.y + window.height {
            for x in window.x..window.x + window.width {
                let light = [f64::from(x) + 1e-9 * f64::from(number), -f64::from(y), 1e8];
                assert!(film.add(x, y, &sample(light)));
                let depth = (x + 3 * y) as f32;
                film.set_center(x, y, Center { depth, object: number, ..Center::SKY });
            }
        }
        film
    }

    fn scratch(folder: &tempfile::TempDir) -> Room {
        Room { memory: 100, folder: folder.path().to_owned() }
    }

    #[test]
    fn both_places_hold_the_same_sums() {
        let folder = tempfile::tempdir().unwrap();
        let (size, window) = ([40, 90], Window { x: 3, y: 2, width: 33, height: 71 });
        for layers in [Layers::default(), Layers { variance: true, guides: false }, Layers::ALL] {
            let spool = |room: &Room| Spool::new(size, window, layers, room).unwrap();
            let (mut memory, mut file) = (spool(&Room::default()), spool(&scratch(&folder)));
            assert!(matches!(file.place, Place::Scratch { .. }));
            assert_eq!(memory.film().unwrap(), file.film().unwrap());
            for (number, tile) in (1..).zip(window.tiles(17).chain(window.tiles(64))) {
                let part = part(size, tile, layers, number);
                memory.merge(&part).unwrap();
                file.merge(&part).unwrap();
            }
            assert_eq!(memory.film().unwrap(), file.film().unwrap());
            assert_eq!(memory.noise().unwrap(), file.noise().unwrap());
            // From one place to the other, and back.
            let (mut a, mut b) = (spool(&Room::default()), spool(&scratch(&folder)));
            a.merge_all(&file).unwrap();
            b.merge_all(&memory).unwrap();
            b.merge_all(&a).unwrap();
            a.merge_all(&memory).unwrap();
            assert_eq!(a.film().unwrap(), b.film().unwrap());
            assert_eq!(a.film().unwrap().samples(4, 70), 4);
            let rows = |spool: &Spool| {
                let mut all = Vec::new();
                let row = |bytes: &[u8]| {
                    all.push(bytes.to_owned());
                    Ok::<_, SpoolError>(())
                };
                spool.each_row(row).unwrap();
                all
            };
            assert_eq!(rows(&a), rows(&b));
        }
        // The files have no names.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn views_have_what_there_is() {
        let folder = tempfile::tempdir().unwrap();
        let (size, window) = ([9, 9], Window { x: 2, y: 2, width: 5, height: 5 });
        let mut spool = Spool::new(size, window, Layers::ALL, &scratch(&folder)).unwrap();
        let film = part(size, window, Layers::ALL, 7);
        spool.merge(&film).unwrap();
        let view = spool.view(Window { x: 0, y: 5, width: 4, height: 9 }).unwrap();
        assert_eq!(view.window(), Window { x: 2, y: 5, width: 2, height: 2 });
        for (x, y) in [(2, 5), (3, 6)] {
            assert_eq!(view.light(x, y), film.light(x, y));
            assert_eq!(view.center(x, y), film.center(x, y));
        }
        let nothing = spool.view(Window { x: 0, y: 0, width: 2, height: 9 }).unwrap();
        assert_eq!((nothing.light(3, 3), nothing.samples(0, 0)), ([0.0; 3], 0));
        assert_eq!(nothing.center(3, 3), None);
    }

    #[test]
    fn what_cannot_be_added_or_kept_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (size, window) = ([4, 4], Window::whole(4, 3));
        let room = scratch(&folder);
        let mut spool = Spool::new(size, window, Layers::ALL, &room).unwrap();
        let mut refused = |part: &Film| match spool.merge(part).unwrap_err() {
            SpoolError::Film(error) => error,
            other => panic!("{other}"),
        };
        let other = |size, window, layers| Film::new(size, window, layers).unwrap();
        let few = Layers { variance: true, guides: false };
        assert_eq!(refused(&other(size, window, few)), FilmError::Different);
        assert_eq!(refused(&other([5, 4], window, Layers::ALL)), FilmError::Different);
        let whole = Window::whole(4, 4);
        let error = refused(&other(size, whole, Layers::ALL));
        assert_eq!(error, FilmError::Outside { window: whole, size });
        let mut full = part(size, window, Layers::ALL, 1);
        full.counts[11].samples = MOST_SAMPLES;
        spool.merge(&full).unwrap();
        let before = spool.film().unwrap().into_owned();
        let error = spool.merge(&part(size, window, Layers::ALL, 1)).unwrap_err();
        assert!(matches!(error, SpoolError::Film(FilmError::TooManySamples)));
        assert_eq!(*spool.film().unwrap(), before);
        let nowhere = Room { folder: folder.path().join("none"), ..room.clone() };
        let error = Spool::new(size, window, Layers::ALL, &nowhere).unwrap_err();
        assert!(error.to_string().contains("none"), "{error}");
        assert!(Spool::new(size, Window { y: 2, ..window }, Layers::ALL, &room).is_err());
        assert!(Spool::new([0, 4], Window::whole(0, 4), Layers::ALL, &room).is_err());
    }

    #[test]
    fn noise_is_the_error_over_the_light() {
        let mut film = Film::new([200, 90], Window::whole(200, 90), Layers::ALL).unwrap();
        assert_eq!(Spool::from(film.clone()).noise().unwrap(), None);
        for (x, y) in (0..200).flat_map(|x| (0..90).map(move |y| (x, y))) {
            for v in [1.0, 3.0, 1.0, 3.0] {
                assert!(film.add(x, y, &sample([v; 3])));
            }
        }
        // The samples' variance is 4/3, that of their mean 1/3, and the mean is 2.
        let noise = Spool::from(film).noise().unwrap().unwrap();
        assert!((noise - (1.0 / 3.0_f64).sqrt() / 2.0).abs() < 1e-12);
    }
}

//! Pictures that scenes refer to: linear samples in memory, each file read once.

mod read;

use std::{
    cell::RefCell,
    collections::HashMap,
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{Diagnostic, Report, decode::Value};

/// The most pixels that a picture can have: 2^27, some 11,000 by 11,000.
pub(crate) const MOST_PIXELS: u64 = 1 << 27;

/// A picture: rows of linear samples from the top down, finite all of them.
#[derive(Clone, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: u32,
    samples: Vec<f32>,
}

/// What a picture is for, which says how its numbers are read and which are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Content {
    /// Reflectances, from 0 to 1; sRGB in files of 8 or 16 bits, linear in those of floats.
    Color,
    /// Radiances, 0 or more; likewise.
    Light,
    /// Numbers as they are, the largest integer as 1.
    Data,
}

impl Image {
    /// A picture of linear samples, `channels` for each pixel: 1 (grey), 3 (red, green, blue) or 4
    /// (and how opaque it is, by which the colours are not multiplied).
    ///
    /// `None` if there are no pixels, if the samples are not as many as these need, or not finite.
    pub fn new(width: u32, height: u32, channels: u32, samples: Vec<f32>) -> Option<Self> {
        let count = u64::from(width) * u64::from(height) * u64::from(channels);
        let good = matches!(channels, 1 | 3 | 4)
            && count > 0
            && count == samples.len() as u64
            && samples.iter().all(|x| x.is_finite());
        good.then_some(Self { width, height, channels, samples })
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// 1 (grey), 3 (red, green, blue) or 4 (with alpha).
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// The samples, pixel by pixel, row by row from the top.
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// Red, green, blue and alpha of the pixel in column x and row y, counted from the top left.
    ///
    /// # Panics
    /// If there is no such pixel.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        let i = (y as usize * self.width as usize + x as usize) * self.channels as usize;
        match self.channels {
            1 => {
                let v = self.samples[i];
                [v, v, v, 1.0]
            }
            3 => [self.samples[i], self.samples[i + 1], self.samples[i + 2], 1.0],
            _ => core::array::from_fn(|c| self.samples[i + c]),
        }
    }
}

/// Without the samples, of which there are millions.
impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, channels, .. } = self;
        write!(f, "Image({width} x {height}, {channels} channels)")
    }
}

/// The pictures of a scene.
pub(crate) struct Images {
    folder: PathBuf,
    known: RefCell<HashMap<(PathBuf, Content), Arc<Image>>>,
}

impl Images {
    pub(crate) fn new(folder: &Path) -> Self {
        Self { folder: folder.into(), known: RefCell::default() }
    }

    fn find(&self, name: &str, content: Content) -> Result<Arc<Image>, Report> {
        let path = self.folder.join(name);
        let key = (path.clone(), content);
        if let Some(known) = self.known.borrow().get(&key) {
            return Ok(Arc::clone(known));
        }
        let image = Arc::new(read::read(&path, content)?);
        self.known.borrow_mut().insert(key, Arc::clone(&image));
        Ok(image)
    }
}

impl Value<'_> {
    /// The picture in the file that the value names.
    pub(crate) fn image(&self, content: Content) -> Option<Arc<Image>> {
        let name = self.string()?;
        let found = self.context().images.find(name, content);
        found.map_err(|report| self.context().absorb(report, self.span())).ok()
    }
}

/// An error about a file.
fn fail(path: &Path, what: impl fmt::Display) -> Diagnostic {
    Diagnostic::error(format!("cannot read `{}`: {what}", path.display()))
}

//! Where pictures and parts of them go: what kind of file, whether there is a place for it, and writing it there.

use std::{
    ffi::OsStr,
    fs, io,
    io::Write,
    path::{Path, PathBuf},
};

use rondure_film::{ExrError, Layers, ShareError, ShareRef, write_exr};
use rondure_image::{Look, png};
use rondure_render::{WriteError, look, write_png};
use rondure_scene::Film;

use crate::{failure::Failure, room::cannot_keep};

/// A file that a picture or a part of one goes to.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    pub(crate) path: PathBuf,
    pub(crate) kind: Kind,
    /// The option that named it.
    option: &'static str,
}

/// What kind of file it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Png,
    Exr,
    /// Sums, to be merged with others.
    Share,
}

/// How light is shown.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) look: Look,
    pub(crate) bits: u8,
}

impl Shown {
    /// As a film wants it.
    pub(crate) fn of(film: &Film) -> Result<Self, Failure> {
        let look = look(film).map_err(|error| {
            Failure::new(error, "choose another temperature, or a tint nearer to 0")
        })?;
        Ok(Self { look, bits: film.bits })
    }
}

/// The most that is written to see whether there is room, in bytes.
const LARGEST_PROBE: u64 = 256 << 20;

impl Output {
    /// A file that `option` named. The kind is told by the extension.
    pub(crate) fn new(path: PathBuf, option: &'static str) -> Result<Self, Failure> {
        let extension = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        let kind = match extension.as_deref() {
            Some("png") => Kind::Png,
            Some("exr") => Kind::Exr,
            Some("rdf") => Kind::Share,
            _ => {
                let title =
                    format!("cannot write `{}`: pictures are PNG or OpenEXR files", path.display());
                let help = "give it a name that ends in .png or .exr, or in .rdf for a part";
                return Err(Failure::new(title, help));
            }
        };
        Ok(Self { path, kind, option })
    }

    /// The layers that go into such a file.
    pub(crate) fn layers(&self) -> Layers {
        Layers { variance: true, guides: self.kind != Kind::Png }
    }

    /// Makes sure, before hours of work, that a file of about this many pixels can be written there.
    pub(crate) fn check(&self, pixels: u64) -> Result<(), Failure> {
        let bytes = match self.kind {
            Kind::Png => 3,
            Kind::Exr => 76,
            Kind::Share => 200,
        };
        check_place(self.option, &self.path, pixels.saturating_mul(bytes))
    }

    fn unwritable(&self, error: &io::Error) -> Failure {
        Failure::unwritable_by(self.option, &self.path, error)
    }

    /// Writes the file.
    pub(crate) fn write(&self, share: &ShareRef<'_>, shown: &Shown) -> Result<(), Failure> {
        match self.kind {
            Kind::Png => {
                let text = |(name, value)| (format!("rondure:{name}"), value);
                let texts: Vec<_> = share.recipe.texts().map(text).collect();
                let Shown { look, bits } = shown;
                write_png(&self.path, share.sums, look, *bits, &texts).map_err(|e| match e {
                    WriteError::File(png::WriteError::Io { source, .. }) => {
                        self.unwritable(&source)
                    }
                    WriteError::Sums(source) => cannot_keep(source),
                    other => Failure::new(other, "choose another size or place"),
                })
            }
            Kind::Exr => write_exr(&self.path, share.sums, share.recipe).map_err(|e| match e {
                ExrError::Io { source, .. } => self.unwritable(&source),
                ExrError::Sums { source, .. } => cannot_keep(source),
                other => Failure::new(other, "choose another size or place"),
            }),
            Kind::Share => share.write(&self.path).map_err(|e| unwritten(self.option, e)),
        }
    }
}

/// Why a share could not be written to a file that `option` named.
pub(crate) fn unwritten(option: &str, error: ShareError) -> Failure {
    match error {
        ShareError::Io { path, source } => Failure::unwritable_by(option, &path, &source),
        ShareError::Sums { source, .. } => cannot_keep(source),
        other => Failure::new(other, "choose another place"),
    }
}

/// Makes sure that a file that `option` named can be written, and that there is room for so many bytes, or for [`LARGEST_PROBE`].
pub(crate) fn check_place(option: &str, path: &Path, bytes: u64) -> Result<(), Failure> {
    let unwritable = |error: io::Error| Failure::unwritable_by(option, path, &error);
    if path.is_dir() {
        return Err(unwritable(io::ErrorKind::IsADirectory.into()));
    }
    let probe = || {
        let mut file = tempfile::Builder::new().prefix(".rondure-").tempfile_in(folder_of(path))?;
        let block = vec![0; 1 << 20];
        let mut left = bytes.min(LARGEST_PROBE);
        while left > 0 {
            let now = left.min(block.len() as u64);
            file.write_all(&block[..now as usize])?;
            left -= now;
        }
        file.close()
    };
    probe().map_err(unwritable)
}

/// Makes sure that files of two kinds, of which the second is named by an option, are not one.
pub(crate) fn check_apart(
    (kind, path): (&str, &Path),
    (other_kind, other, option): (&str, &Path, &str),
) -> Result<(), Failure> {
    let place = |path: &Path| {
        let folder = folder_of(path);
        (
            fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned()),
            path.file_name().map(OsStr::to_owned),
        )
    };
    if place(path) != place(other) {
        return Ok(());
    }
    let title = format!("`{}` cannot be both {kind} and {other_kind}", path.display());
    Err(Failure::new(title, &format!("give another name with {option}")))
}

/// The folder that a file lies in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Keeps what was computed, when its own place has turned out to be no place, in the next best: beside it, here, or where temporary files go.
/// Says where.
pub(crate) fn rescue(output: &Path, share: &ShareRef<'_>) -> Option<PathBuf> {
    let mut name = output.file_stem().unwrap_or(OsStr::new("picture")).to_owned();
    name.push(format!(".rescued-{}.rdf", std::process::id()));
    let folders = [folder_of(output).to_owned(), PathBuf::from("."), std::env::temp_dir()];
    folders.into_iter().map(|folder| folder.join(&name)).find(|path| {
        let written = share.write(path).is_ok();
        written && fs::metadata(path).is_ok()
    })
}

//! Picture files for the commands: read, with what is wrong with them told.

use std::path::Path;

use rondure_image::{
    Image,
    png::{self, ReadError},
};

use crate::failure::Failure;

/// The light of a picture file.
pub(crate) fn read(path: &Path) -> Result<Image, Failure> {
    let name = path.display();
    let kind = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match kind.as_deref() {
        Some("png") => png::read(path).map(|decoded| decoded.image).map_err(|error| match error {
            ReadError::Io { source, .. } => Failure::unreadable(&name.to_string(), &source),
            ReadError::TooLarge { .. } => Failure::new(error, "take a smaller picture"),
            other => Failure::new(other, "check that the file is whole"),
        }),
        _ => Err(Failure::new(
            format!("`{name}` has no name of a picture that can be read"),
            "pictures are .png files",
        )),
    }
}

/// A name for a PNG file, or what is wrong with it.
pub(crate) fn check_png_name(path: &Path) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Ok(());
    }
    let title = format!("cannot write `{}`: pictures are PNG files", path.display());
    Err(Failure::new(title, "give it a name that ends in .png"))
}

/// Why a picture could not be written.
pub(crate) fn cannot_write(path: &Path, error: png::WriteError) -> Failure {
    match error {
        png::WriteError::Io { source, .. } => Failure::unwritable(path, &source),
        other => Failure::new(other, "choose another size or place"),
    }
}

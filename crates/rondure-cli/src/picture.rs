//! Picture files for the commands: read, with what is wrong with them told.

use std::path::Path;

use rondure_film::{ExrError, ExrPicture};
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
        Some("exr") => {
            let picture = read_exr(path)?;
            let [width, height] = picture.size;
            let pixels = triples(path, &picture, ["R", "G", "B"])?;
            Image::new(width, height, pixels)
                .map_err(|error| Failure::new(error, "check that the file is whole"))
        }
        _ => Err(Failure::new(
            format!("`{name}` has no name of a picture that can be read"),
            "pictures are .png or .exr files",
        )),
    }
}

/// The channels of an OpenEXR picture.
pub(crate) fn read_exr(path: &Path) -> Result<ExrPicture, Failure> {
    ExrPicture::read(path).map_err(|error| match error {
        ExrError::Io { path, source } => Failure::unreadable(&path.display().to_string(), &source),
        other => Failure::new(other, "check that the file is whole"),
    })
}

/// Three channels of an OpenEXR picture, pixel by pixel.
pub(crate) fn triples(
    path: &Path,
    picture: &ExrPicture,
    names: [&str; 3],
) -> Result<Vec<[f32; 3]>, Failure> {
    let channel = |name: &str| {
        picture.channel(name).ok_or_else(|| {
            let all: Vec<_> = picture.channels.iter().map(|(name, _)| name.as_str()).collect();
            let help = match all.as_slice() {
                [] => "it has no channels".to_owned(),
                all => format!("it has {}", all.join(", ")),
            };
            Failure::new(format!("`{}` has no channel {name}", path.display()), &help)
        })
    };
    let [a, b, c] = [channel(names[0])?, channel(names[1])?, channel(names[2])?];
    Ok(a.iter().zip(b).zip(c).map(|((a, b), c)| [*a, *b, *c]).collect())
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

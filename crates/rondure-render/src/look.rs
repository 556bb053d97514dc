//! How a film wants its light to be shown.

use rondure_image::{Look, View, White, WhiteError};
use rondure_scene::{Film, ViewTransform, WhiteBalance};

/// The exposure, white balance and view of a film.
///
/// # Errors
/// If no light has the colour that is to look white.
pub fn look(film: &Film) -> Result<Look, WhiteError> {
    let view = match film.view {
        ViewTransform::Srgb => View::Srgb,
        ViewTransform::AgX => View::AgX,
        ViewTransform::Neutral => View::Neutral,
    };
    let white = match film.white {
        Some(WhiteBalance { temperature, tint }) => White::new(temperature, tint)?,
        None => White::default(),
    };
    Ok(Look::new(view, film.exposure, &white))
}

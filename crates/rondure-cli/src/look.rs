//! The options that say how light is shown: view, exposure, white balance.

use clap::{Args, ValueEnum};
use rondure_image::White;
use rondure_scene::{Film, ViewTransform, WhiteBalance};

#[derive(Debug, Args)]
pub(crate) struct LookArgs {
    /// How light of any strength becomes what a screen can show, instead of the scene's way
    #[arg(long, value_enum)]
    view: Option<ViewName>,

    /// Make the picture lighter by this many stops, each twice as light; less than 0 is darker
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = stops)]
    exposure: Option<f64>,

    /// The colour temperature of the light that shall look white, instead of the scene's
    #[arg(long, value_name = "KELVIN", value_parser = kelvin)]
    white_balance: Option<f64>,

    /// How much greener than its temperature that light is; more makes the picture more magenta
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = tint)]
    tint: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ViewName {
    /// What is brighter than white is cut off
    Srgb,
    /// AgX, as in Blender: bright colours go over into white, as on film
    Agx,
    /// Khronos PBR Neutral: colours stay what the materials say
    Neutral,
}

fn within(text: &str, [least, most]: [f64; 2], what: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (least..=most).contains(&x) => Ok(x),
        _ => Err(format!("expected {what} from {least} to {most}")),
    }
}

fn stops(text: &str) -> Result<f64, String> {
    within(text, [-100.0, 100.0], "a number of stops")
}

fn kelvin(text: &str) -> Result<f64, String> {
    within(text, White::TEMPERATURES, "a temperature in kelvin")
}

fn tint(text: &str) -> Result<f64, String> {
    within(text, [-White::TINTS, White::TINTS], "a number")
}

/// How light is shown, as settings in the description of a picture.
pub(crate) fn settings_of(film: &Film) -> [(&'static str, String); 4] {
    let view = match film.view {
        ViewTransform::Srgb => "srgb",
        ViewTransform::AgX => "agx",
        ViewTransform::Neutral => "neutral",
    };
    let white = film.white.unwrap_or_default();
    [
        ("exposure", film.exposure.to_string()),
        ("view", view.to_owned()),
        ("white_balance", white.temperature.to_string()),
        ("tint", white.tint.to_string()),
    ]
}

/// A film that is shown as such settings say; what they do not tell is as in a scene that does not.
pub(crate) fn film_of(settings: &[(String, String)]) -> Film {
    let value = |name: &str| settings.iter().find(|(key, _)| key == name).map(|(_, v)| v.as_str());
    let number = |name: &str| value(name).and_then(|v| v.parse::<f64>().ok());
    let mut film = Film::default();
    film.exposure = number("exposure").filter(|x| *x > 0.0).unwrap_or(film.exposure);
    film.view = match value("view") {
        Some("agx") => ViewTransform::AgX,
        Some("neutral") => ViewTransform::Neutral,
        _ => film.view,
    };
    let plain = WhiteBalance::default();
    let white = WhiteBalance {
        temperature: number("white_balance").unwrap_or(plain.temperature),
        tint: number("tint").unwrap_or(plain.tint),
    };
    film.white = (white != plain).then_some(white);
    film
}

impl LookArgs {
    /// What was asked for, in place of what the scene says.
    pub(crate) fn apply(&self, film: &mut Film) {
        if let Some(view) = self.view {
            film.view = match view {
                ViewName::Srgb => ViewTransform::Srgb,
                ViewName::Agx => ViewTransform::AgX,
                ViewName::Neutral => ViewTransform::Neutral,
            };
        }
        film.exposure *= self.exposure.unwrap_or(0.0).exp2();
        if let Some(temperature) = self.white_balance {
            film.white.get_or_insert_default().temperature = temperature;
        }
        if let Some(tint) = self.tint {
            film.white.get_or_insert_default().tint = tint;
        }
    }
}

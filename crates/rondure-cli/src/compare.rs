//! `rondure compare`: how different two pictures are, in figures and as a picture.

use std::{
    io::{self, Write},
    path::PathBuf,
};

use clap::Args;
use rondure_image::{
    Signals,
    color_map::magma,
    error::{Comparison, compare},
    flip::PIXELS_PER_DEGREE,
    png,
};

use rondure_scene::Film;

use crate::{failure::Failure, json::Json, look::LookArgs, output::Shown, picture};

/// Print how different a picture is from a reference
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct Compare {
    /// The picture
    #[arg(value_name = "PICTURE")]
    picture: PathBuf,

    /// What it should look like
    #[arg(value_name = "REFERENCE")]
    reference: PathBuf,

    /// Write a picture of the differences, by FLIP: black none, pale yellow the largest
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,

    /// How many pixels of the picture are in a degree of the field of view
    #[arg(long, value_name = "N", default_value_t = PIXELS_PER_DEGREE.round(), value_parser = density)]
    pixels_per_degree: f64,

    #[command(flatten)]
    look: LookArgs,

    /// Fail if the relative mean square error is larger
    #[arg(long, value_name = "X", value_parser = limit)]
    max_relmse: Option<f64>,

    /// Fail if the mean of FLIP is larger
    #[arg(long, value_name = "X", value_parser = limit)]
    max_flip: Option<f64>,

    /// Fail if the pictures are not the same, bit for bit
    #[arg(long)]
    exact: bool,

    /// Print JSON, with all digits
    #[arg(long)]
    json: bool,
}

const HELP: &str = "\
What is printed:
  pixels   those that are not the same, bit for bit
  largest  difference of a channel, in linear light
  MSE      mean square of the differences, in linear light
  relMSE   mean of (picture - reference)² / (reference² + 0.01), in linear light
           (of a PNG the light that its sRGB signals stand for, of an OpenEXR picture its values)
  PSNR     peak signal-to-noise ratio of what the screen shows, in sRGB
  FLIP     mean difference that is seen when one flips between the pictures, from 0 to 1
           (Andersson et al. 2020)

Exit codes: 0 compared, and within what was allowed; 1 a picture cannot be read, or they have
different sizes; 2 wrong usage; 3 more different than --max-relmse, --max-flip or --exact allow.

Examples:
  rondure compare new.png old.png -o difference.png
  rondure compare new.exr old.exr --max-flip 0.01 --json";

fn number(text: &str, good: impl Fn(f64) -> bool, what: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && good(*x)).ok_or_else(|| what.into())
}

fn limit(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "expected a number, 0 or more")
}

fn density(text: &str) -> Result<f64, String> {
    number(text, |x| (1.0..=1000.0).contains(&x), "expected a number from 1 to 1000")
}

impl Compare {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        if let Some(output) = &self.output {
            picture::check_png_name(output)?;
        }
        let (a, b) = (picture::read(&self.picture)?, picture::read(&self.reference)?);
        let mut film = Film::default();
        self.look.apply(&mut film);
        let look = Shown::of(&film)?.look;
        let compared = compare(&a, &b, &look, self.pixels_per_degree)
            .map_err(|error| Failure::new(error, "compare pictures of the same size"))?;
        if let Some(output) = &self.output {
            let colors = compared.flip_map.iter().flat_map(|v| magma(*v)).collect();
            png::write(output, [a.width(), a.height()], &Signals::Eight(colors), &[])
                .map_err(|error| picture::cannot_write(output, error))?;
        }
        let size = [a.width(), a.height()];
        let text = if self.json { self.json(&compared, size) } else { table(&compared, size) };
        writeln!(io::stdout().lock(), "{text}").map_err(|error| Failure::output(&error))?;
        if self.is_allowed(&compared) { Ok(()) } else { Err(Failure::Differ) }
    }

    fn is_allowed(&self, compared: &Comparison) -> bool {
        let within = |value: f64, most: Option<f64>| most.is_none_or(|most| value <= most);
        within(compared.relative_mse, self.max_relmse)
            && within(compared.flip, self.max_flip)
            && !(self.exact && compared.different > 0)
            // What is no number is no match, whatever is allowed.
            && !(self.has_limits() && compared.not_finite > 0)
    }

    fn has_limits(&self) -> bool {
        self.exact || self.max_relmse.is_some() || self.max_flip.is_some()
    }

    fn json(&self, compared: &Comparison, [width, height]: [u32; 2]) -> String {
        let count = |n: u64| Json::Number(n as f64);
        Json::Object(vec![
            ("picture", self.picture.display().to_string().as_str().into()),
            ("reference", self.reference.display().to_string().as_str().into()),
            ("width", f64::from(width).into()),
            ("height", f64::from(height).into()),
            ("different_pixels", count(compared.different)),
            ("not_finite", count(compared.not_finite)),
            ("largest", compared.largest.into()),
            ("mse", compared.mse.into()),
            ("relmse", compared.relative_mse.into()),
            // Infinite, and so null, for pictures that look the same.
            ("psnr", compared.psnr.into()),
            ("flip", compared.flip.into()),
        ])
        .to_string()
    }
}

fn table(compared: &Comparison, [width, height]: [u32; 2]) -> String {
    let all = u64::from(width) * u64::from(height);
    let mut text = format!(
        "pixels   {} of {all} are not the same\n\
         largest  {:.6}\n\
         MSE      {:.6e}\n\
         relMSE   {:.6e}\n\
         PSNR     {}\n\
         FLIP     {:.6}",
        compared.different,
        compared.largest,
        compared.mse,
        compared.relative_mse,
        if compared.psnr.is_finite() {
            format!("{:.2} dB", compared.psnr)
        } else {
            "infinite".into()
        },
        compared.flip,
    );
    if compared.not_finite > 0 {
        text += &format!("\n{} channels are no numbers, and were left out", compared.not_finite);
    }
    text
}

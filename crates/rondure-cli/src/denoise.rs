//! `rondure denoise`: takes the noise out of a picture with layers.

use std::{ffi::OsString, path::PathBuf, time::Instant};

use clap::Args;
use rondure_film::{ExrError, ExrPicture};
use rondure_image::{
    Depth,
    denoise::{Layers, denoise},
    png,
};

use crate::{
    failure::Failure,
    look::{LookArgs, film_of},
    output::{Kind, Output, Shown},
    picture::{self, cannot_write},
    progress::seconds,
    threads::Threads,
};

/// Take the noise out of an OpenEXR picture, guided by its albedo, normals and variance
#[derive(Debug, Args)]
#[command(after_help = "\
The picture must have the layers that `rondure render -o FILE.exr` writes: R, G, B, variance, albedo,
normal. An OpenEXR file gets them all again, with the light replaced; in a PNG file, light is shown
as the scene had it, or as --view, --exposure and --white-balance say.

Examples:
  rondure denoise still-life.exr                   make still-life-denoised.exr, here
  rondure denoise still-life.exr -o clean.png --exposure 0.5")]
pub(crate) struct Denoise {
    /// The picture
    #[arg(value_name = "FILE.exr")]
    picture: PathBuf,

    /// Where to write the clean picture, a PNG or OpenEXR file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Bits in each channel of a PNG file
    #[arg(long, value_name = "N", default_value = "8", value_parser = bits)]
    bits: u8,

    #[command(flatten)]
    look: LookArgs,

    #[command(flatten)]
    threads: Threads,

    /// Say nothing unless something is wrong
    #[arg(short, long)]
    quiet: bool,
}

fn bits(text: &str) -> Result<u8, &'static str> {
    text.parse().ok().filter(|bits| matches!(bits, 8 | 16)).ok_or("a PNG file has 8 or 16 bits")
}

impl Denoise {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let output = self.output()?;
        let mut picture = picture::read_exr(&self.picture)?;
        let shown = self.shown(&picture)?;
        let [width, height] = picture.size;
        output.check(u64::from(width) * u64::from(height))?;
        let layer = |names| picture::triples(&self.picture, &picture, names);
        let light = layer(["R", "G", "B"])?;
        let variance = layer(["variance.R", "variance.G", "variance.B"])?;
        let albedo = layer(["albedo.R", "albedo.G", "albedo.B"])?;
        let normal = layer(["normal.X", "normal.Y", "normal.Z"])?;
        let layers = Layers {
            width,
            height,
            light: &light,
            variance: &variance,
            albedo: &albedo,
            normal: &normal,
        };
        let start = Instant::now();
        let clean =
            self.threads.pool()?.install(|| denoise(&layers)).map_err(|error| {
                Failure::new(error, "render it with 2 samples in a pixel or more")
            })?;
        let time = start.elapsed().as_secs_f64();
        if output.kind == Kind::Exr {
            replace(&mut picture, &clean);
            picture.write(&output.path).map_err(|error| match error {
                ExrError::Io { source, .. } => Failure::unwritable(&output.path, &source),
                other => Failure::new(other, "choose another place"),
            })?;
        } else {
            let depth = Depth::of_bits(shown.bits).unwrap_or_default();
            let signals = shown.look.signals(&clean, width, 0, depth);
            png::write(&output.path, [width, height], &signals, &texts(&picture))
                .map_err(|error| cannot_write(&output.path, error))?;
        }
        if !self.quiet {
            let name = output.path.display();
            anstream::eprintln!("{name}: {width}x{height}, denoised in {}", seconds(time));
        }
        Ok(())
    }

    fn output(&self) -> Result<Output, Failure> {
        let path = match (&self.output, self.picture.file_stem()) {
            (Some(path), _) => path.clone(),
            (None, Some(stem)) => {
                let mut name = OsString::from(stem);
                name.push("-denoised.exr");
                PathBuf::from(name)
            }
            (None, None) => {
                return Err(Failure::new("the picture has no name", "give it one with -o FILE"));
            }
        };
        let output = Output::new(path, "-o")?;
        if output.kind == Kind::Share {
            return Err(Failure::new(
                "a part of a picture cannot be denoised",
                "give the output a name that ends in .png or .exr",
            ));
        }
        Ok(output)
    }

    /// As the scene of the picture had it, but for what was asked for.
    fn shown(&self, picture: &ExrPicture) -> Result<Shown, Failure> {
        let settings: Vec<_> = ["exposure", "view", "white_balance", "tint"]
            .into_iter()
            .filter_map(|key| Some((key.to_owned(), picture.setting(key)?.to_owned())))
            .collect();
        let mut film = film_of(&settings);
        film.bits = self.bits;
        self.look.apply(&mut film);
        Shown::of(&film)
    }
}

fn replace(picture: &mut ExrPicture, clean: &[[f32; 3]]) {
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        for (_, values) in picture.channels.iter_mut().filter(|(n, _)| n == name) {
            for (value, pixel) in values.iter_mut().zip(clean) {
                *value = pixel[c];
            }
        }
    }
    picture.comments += "denoised = true\n";
}

fn texts(picture: &ExrPicture) -> Vec<(String, String)> {
    let lines = picture.comments.lines().filter_map(|line| line.split_once(" = "));
    let text = |(key, value): (&str, &str)| (format!("rondure:{key}"), value.to_owned());
    let good = |(key, _): &(&str, &str)| key.len() < 70 && key.is_ascii();
    lines.filter(good).map(text).chain([("rondure:denoised".into(), "true".into())]).collect()
}

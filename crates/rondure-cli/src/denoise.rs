//! `rondure denoise`: takes the noise out of a picture with layers.

use std::{ffi::OsString, path::PathBuf, time::Instant};

use clap::{Args, ValueEnum};
use rondure_film::{ExrError, ExrPicture};
use rondure_image::{
    Depth,
    denoise::{Layers, denoise},
    png,
};

use crate::{
    failure::Failure,
    look::{LookArgs, film_of},
    oidn::{self, Noisy},
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
  rondure denoise still-life.exr -o clean.png --exposure 0.5
  rondure denoise still-life.exr --method oidn     by Intel's Open Image Denoise")]
pub(crate) struct Denoise {
    /// The picture
    #[arg(value_name = "FILE.exr")]
    picture: PathBuf,

    /// Where to write the clean picture, a PNG or OpenEXR file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// How to take the noise out
    #[arg(long, value_enum, default_value = "regression")]
    method: Method,

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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Light as a linear function of albedo, normal and place, fitted to pixels that look alike
    Regression,
    /// Intel's Open Image Denoise, a neural network, if its program oidnDenoise is installed; needs no variance
    Oidn,
}

fn bits(text: &str) -> Result<u8, &'static str> {
    text.parse().ok().filter(|bits| matches!(bits, 8 | 16)).ok_or("a PNG file has 8 or 16 bits")
}

impl Denoise {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let output = self.output()?;
        if self.method == Method::Oidn {
            oidn::check()?;
        }
        let mut picture = picture::read_exr(&self.picture)?;
        let shown = self.shown(&picture)?;
        let [width, height] = picture.size;
        output.check(u64::from(width) * u64::from(height))?;
        let start = Instant::now();
        let clean = self.clean(&picture, &output)?;
        let time = start.elapsed().as_secs_f64();
        if output.kind == Kind::Exr {
            self.replace(&mut picture, &clean);
            picture.write(&output.path).map_err(|error| match error {
                ExrError::Io { source, .. } => Failure::unwritable(&output.path, &source),
                other => Failure::new(other, "choose another place"),
            })?;
        } else {
            let depth = Depth::of_bits(shown.bits).unwrap_or_default();
            let signals = shown.look.signals(&clean, width, 0, depth);
            png::write(&output.path, [width, height], &signals, &self.texts(&picture))
                .map_err(|error| cannot_write(&output.path, error))?;
        }
        if !self.quiet {
            let name = output.path.display();
            let by = match self.method {
                Method::Regression => "",
                Method::Oidn => " by Open Image Denoise",
            };
            anstream::eprintln!("{name}: {width}x{height}, denoised{by} in {}", seconds(time));
        }
        Ok(())
    }

    /// The light without noise.
    fn clean(&self, picture: &ExrPicture, output: &Output) -> Result<Vec<[f32; 3]>, Failure> {
        let layer = |names| picture::triples(&self.picture, picture, names);
        let [width, height] = picture.size;
        let light = &layer(["R", "G", "B"])?;
        let albedo = &layer(["albedo.R", "albedo.G", "albedo.B"])?;
        let normal = &layer(["normal.X", "normal.Y", "normal.Z"])?;
        if self.method == Method::Oidn {
            let noisy = Noisy { size: picture.size, light, albedo, normal };
            return oidn::denoise(&noisy, &output.path, self.threads.number());
        }
        let variance = &layer(["variance.R", "variance.G", "variance.B"])?;
        let layers = Layers { width, height, light, variance, albedo, normal };
        self.threads
            .pool()?
            .install(|| denoise(&layers))
            .map_err(|error| Failure::new(error, "render it with 2 samples in a pixel or more"))
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

    /// What the picture says of having been denoised.
    fn mark(&self) -> &'static str {
        match self.method {
            Method::Regression => "true",
            Method::Oidn => "oidn",
        }
    }

    fn replace(&self, picture: &mut ExrPicture, clean: &[[f32; 3]]) {
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            for (_, values) in picture.channels.iter_mut().filter(|(n, _)| n == name) {
                for (value, pixel) in values.iter_mut().zip(clean) {
                    *value = pixel[c];
                }
            }
        }
        picture.comments += &format!("denoised = {}\n", self.mark());
    }

    fn texts(&self, picture: &ExrPicture) -> Vec<(String, String)> {
        let lines = picture.comments.lines().filter_map(|line| line.split_once(" = "));
        let text = |(key, value): (&str, &str)| (format!("rondure:{key}"), value.to_owned());
        let good = |(key, _): &(&str, &str)| key.len() < 70 && key.is_ascii();
        let mark = ("rondure:denoised".to_owned(), self.mark().to_owned());
        lines.filter(good).map(text).chain([mark]).collect()
    }
}

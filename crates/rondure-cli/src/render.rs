//! `rondure render`: from a scene to a picture.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    str::FromStr,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

use clap::Args;
use rondure_render::{Picture, RenderError, Settings, WriteError, render};

use crate::{
    failure::{Failure, INTERRUPTED},
    progress::{Watcher, seconds},
    scene,
    threads::Threads,
};

/// Render a scene into a PNG picture
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rondure render scenes/still-life.toml                       make still-life.png, here
  rondure render chess.toml -o draft.png --size 320x240 --spp 4

The picture is the same, bit for bit, for any number of threads. It appears under its name only when
it is whole; Ctrl-C leaves nothing behind.")]
pub(crate) struct Render {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,

    /// Where to write the picture; the scene's name with .png in the current folder if not given
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,

    /// The picture's size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,

    /// How many samples to take in each pixel, instead of the scene's number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    spp: Option<u32>,

    #[command(flatten)]
    threads: Threads,

    /// Chooses other random numbers: another noise in the picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Say nothing unless something is wrong
    #[arg(short, long)]
    quiet: bool,
}

/// Pixels across and down.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Size {
    width: u32,
    height: u32,
}

impl FromStr for Size {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const LARGEST: u32 = 65_535;
        let side = |text: &str| text.parse().ok().filter(|side| (1..=LARGEST).contains(side));
        text.split_once(['x', 'X', '×'])
            .and_then(|(w, h)| Some(Self { width: side(w)?, height: side(h)? }))
            .ok_or("a size is WIDTHxHEIGHT, like 800x600, with sides from 1 to 65535")
    }
}

impl Render {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mut scene = scene::read(&self.scene)?;
        if let Some(Size { width, height }) = self.size {
            (scene.film.width, scene.film.height) = (width, height);
        }
        if let Some(spp) = self.spp {
            scene.film.spp = spp;
        }
        let output = self.output()?;
        check_place(&output)?;

        let cancelled = stop_on_interrupt();
        let watcher = Watcher::new(self.quiet, &cancelled);
        let settings = Settings { threads: self.threads.number(), seed: self.seed };
        let start = Instant::now();
        let rendered = render(&scene, &settings, &watcher);
        let time = start.elapsed().as_secs_f64();
        watcher.finish();
        let picture = rendered.map_err(cannot_render)?;
        picture.write_png(&output, scene.film.bits).map_err(|e| cannot_write(&output, e))?;

        let invalid = picture.statistics().invalid_samples;
        if invalid > 0 {
            anstream::eprintln!(
                "warning: {invalid} samples came out as no light and were left out"
            );
        }
        if !self.quiet {
            let spp = scene.film.spp;
            anstream::eprintln!("{}: {}", output.display(), summary(&picture, spp, time));
        }
        Ok(())
    }

    fn output(&self) -> Result<PathBuf, Failure> {
        let path = match (&self.output, self.scene.file_stem()) {
            (Some(path), _) => path.clone(),
            (None, Some(stem)) => {
                let mut name = stem.to_owned();
                name.push(".png");
                PathBuf::from(name)
            }
            (None, None) => {
                return Err(Failure::new("the picture has no name", "give it one with -o OUT.png"));
            }
        };
        if path.extension().and_then(OsStr::to_str).is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            return Ok(path);
        }
        let title = format!("cannot write `{}`: pictures are PNG files", path.display());
        Err(Failure::new(title, "give it a name that ends in .png"))
    }
}

/// Makes sure, before hours of work, that the picture can be written where it is to go.
fn check_place(output: &Path) -> Result<(), Failure> {
    if output.is_dir() {
        return Err(Failure::unwritable(output, &std::io::ErrorKind::IsADirectory.into()));
    }
    let folder = match output.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    tempfile::Builder::new()
        .prefix(".rondure-")
        .tempfile_in(folder)
        .and_then(tempfile::NamedTempFile::close)
        .map_err(|error| Failure::unwritable(output, &error))
}

/// A flag that Ctrl-C sets. The second Ctrl-C does not wait any more.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        anstream::eprintln!("warning: Ctrl-C will stop the work at once: {error}");
    }
    cancelled
}

fn cannot_render(error: RenderError) -> Failure {
    let help = match error {
        RenderError::Cancelled => return Failure::Interrupted,
        RenderError::TooLarge { .. } => "choose a smaller --size",
        RenderError::Threads(_) => "ask for fewer with --threads",
        _ => "change the scene",
    };
    Failure::new(error, help)
}

fn cannot_write(output: &Path, error: WriteError) -> Failure {
    match error {
        WriteError::Io { source, .. } => Failure::unwritable(output, &source),
        other => Failure::new(other, "choose another size or place"),
    }
}

fn summary(picture: &Picture, spp: u32, time: f64) -> String {
    let statistics = picture.statistics();
    let rays = statistics.camera_rays + statistics.secondary_rays + statistics.shadow_rays;
    format!(
        "{}x{}, {spp} spp, {} ({}samples/s, {}rays/s)",
        picture.width(),
        picture.height(),
        seconds(time),
        rate(statistics.camera_rays, time),
        rate(rays, time)
    )
}

/// How many a second, in front of a unit.
fn rate(number: u64, time: f64) -> String {
    match number as f64 / time {
        r if r >= 1e6 => format!("{:.1} M ", r / 1e6),
        r if r >= 1e3 => format!("{:.1} k ", r / 1e3),
        r => format!("{r:.1} "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!("800x600".parse(), Ok(Size { width: 800, height: 600 }));
        for bad in ["", "800", "800x", "x600", "0x600", "800x-1", "800x600x3", "65536x1", "8 x 6"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }
}

//! Scene files for the commands, and the options that stand in place of what a scene says.

use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
    str::FromStr,
};

use clap::Args;
use rondure::EngineOptions;
use rondure_render::Settings;
use rondure_scene::{Integrator, Scene, read_scene};

use crate::{engine::EngineArgs, failure::Failure, look::LookArgs, threads::Threads};

/// The scene of which pictures are made, and how.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    pub(crate) path: PathBuf,

    /// The size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,

    /// How many samples to take in each pixel, instead of the scene's number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    spp: Option<u32>,

    /// How to follow light, instead of as the scene says: on all its ways, the same without photons and branches, or for a quick look
    #[arg(long, value_name = "path|reference|whitted", value_parser = integrator)]
    integrator: Option<Integrator>,

    #[command(flatten)]
    look: LookArgs,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    pub(crate) engine: EngineArgs,

    /// Chooses other random numbers: another noise in the picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Say nothing unless something is wrong
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

fn integrator(name: &str) -> Result<Integrator, &'static str> {
    let found = Integrator::ALL.iter().find(|(known, _)| *known == name);
    found.map(|(_, integrator)| *integrator).ok_or("there are `path`, `reference` and `whitted`")
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

impl SceneArgs {
    /// The scene, with what the options say in place of what it says.
    pub(crate) fn read(&self) -> Result<Scene, Failure> {
        let mut scene = read(&self.path)?;
        if let Some(Size { width, height }) = self.size {
            (scene.film.width, scene.film.height) = (width, height);
        }
        scene.film.spp = self.spp.unwrap_or(scene.film.spp);
        scene.film.integrator = self.integrator.unwrap_or(scene.film.integrator);
        self.look.apply(&mut scene.film);
        let engine = self.engine.options();
        if engine != EngineOptions::default() {
            scene.set_engine(&engine);
        }
        Ok(scene)
    }

    pub(crate) fn settings(&self) -> Settings {
        Settings { threads: self.threads.number(), seed: self.seed }
    }

    /// The name that was asked for, or that of the scene with another end.
    pub(crate) fn name(&self, asked: Option<&PathBuf>, end: &OsStr) -> Option<PathBuf> {
        asked.cloned().or_else(|| {
            let mut name = OsString::from(self.path.file_stem()?);
            name.push(end);
            Some(name.into())
        })
    }

    pub(crate) fn tell(&self, text: impl FnOnce() -> String) {
        if !self.quiet {
            anstream::eprintln!("{}", text());
        }
    }
}

/// Reads a scene with all that it refers to. Warnings are printed, errors are the failure.
pub(crate) fn read(path: &Path) -> Result<Scene, Failure> {
    match read_scene(path) {
        Ok((scene, warnings)) => {
            if !warnings.is_empty() {
                anstream::eprintln!("{}\n", warnings.colored());
            }
            Ok(scene)
        }
        Err(report) => Err(Failure::Report(report.colored())),
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

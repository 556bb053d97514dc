//! `rondure check`: what is wrong with scenes, and what is in them.

use std::{
    fmt,
    io::{self, Write},
    path::PathBuf,
};

use clap::Args;
use rondure_scene::{Projection, Scene, Shape, Sky};

use crate::{failure::Failure, scene};

/// Read scenes with all that they refer to, and say what is wrong with them or what is in them
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rondure check scenes/still-life.toml
  rondure check scenes/*.toml

What is wrong goes to standard error, what is in the good scenes to standard output.")]
pub(crate) struct Check {
    /// The scene files
    #[arg(required = true, value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
}

impl Check {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mut bad = 0;
        let mut out = io::stdout().lock();
        for path in &self.scenes {
            match scene::read(path) {
                Ok(scene) => {
                    let contents = Contents::of(&scene);
                    writeln!(out, "{}: good\n{contents}", path.display())
                        .map_err(|error| Failure::output(&error))?;
                }
                Err(failure) => {
                    failure.tell();
                    anstream::eprintln!();
                    bad += 1;
                }
            }
        }
        if self.scenes.len() > 1 && bad > 0 {
            anstream::eprintln!("{bad} of {} scenes cannot be rendered", self.scenes.len());
        }
        if bad > 0 { Err(Failure::Reported) } else { Ok(()) }
    }
}

/// What is in a scene.
struct Contents<'a> {
    scene: &'a Scene,
    turned: u64,
    profiles: usize,
    segments: usize,
    planes: u64,
    disks: u64,
    rectangles: u64,
    spheres: u64,
    swept: u64,
    solids: u64,
}

impl<'a> Contents<'a> {
    fn of(scene: &'a Scene) -> Self {
        let mut found = Self {
            scene,
            turned: 0,
            profiles: 0,
            segments: 0,
            planes: 0,
            disks: 0,
            rectangles: 0,
            spheres: 0,
            swept: 0,
            solids: 0,
        };
        for object in &scene.objects {
            let number = match &object.shape {
                Shape::Turned(_) => &mut found.turned,
                Shape::Plane { .. } => &mut found.planes,
                Shape::Disk { .. } => &mut found.disks,
                Shape::Rectangle { .. } => &mut found.rectangles,
                Shape::Sphere { .. } => &mut found.spheres,
                Shape::Swept { .. } => &mut found.swept,
                Shape::Body(_) => &mut found.solids,
            };
            *number += object.copies.count();
        }
        let surfaces = scene.surfaces();
        found.profiles = surfaces.len();
        found.segments = surfaces.iter().map(|s| s.profile().segments().count()).sum();
        found
    }
}

impl fmt::Display for Contents<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Scene { film, camera, keys, sky, lights, materials, objects, section, reliefs: _ } =
            self.scene;
        let projection = match camera.projection {
            Projection::Perspective { fov } => {
                format!("perspective, field of view {:.3}°", fov.to_degrees())
            }
            Projection::Orthographic { height } => format!("orthographic, {height} high"),
        };
        writeln!(
            f,
            "  film       {}x{}, {} per pixel, depth {}, {} bits",
            film.width,
            film.height,
            count(film.spp as usize, "sample"),
            film.depth,
            film.bits
        )?;
        let lens = if camera.lens.is_some() { ", with a lens" } else { "" };
        let way = match keys.len() {
            0 => String::new(),
            n => format!(", {}", count(n, "key")),
        };
        writeln!(f, "  camera     {projection}{lens}{way}")?;
        let number: u64 = objects.iter().map(|object| object.copies.count()).sum();
        writeln!(f, "  objects    {number}")?;
        if self.turned > 0 {
            writeln!(
                f,
                "    turned     {}, from {} with {}",
                self.turned,
                count(self.profiles, "profile"),
                count(self.segments, "segment")
            )?;
        }
        for (number, name) in [
            (self.planes, "planes"),
            (self.disks, "disks"),
            (self.rectangles, "rectangles"),
            (self.spheres, "spheres"),
            (self.swept, "swept"),
            (self.solids, "solids"),
        ] {
            if number > 0 {
                writeln!(f, "    {name:<10} {number}")?;
            }
        }
        if !section.is_empty() {
            writeln!(f, "  section    {}", count(section.len(), "plane"))?;
        }
        writeln!(f, "  materials  {}", materials.len())?;
        let dark = matches!(sky, Sky::Constant { color } if *color == [0.0; 3]);
        let sky = if dark { "" } else { " and the sky" };
        write!(f, "  lights     {}{sky}", lights.len())
    }
}

fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

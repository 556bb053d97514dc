//! `cargo xtask race`: Rondure against its peers, all in one run, interleaved, on one thread.
//!
//! ```text
//! install -> profile -> rays, meshes -> heats of contestants -> race.md, race.csv, race.svg
//! ```

mod abi;
mod contest;
mod embree;
mod engines;
mod field;
mod install;
mod mesh;
mod others;
mod plot;

mod rays;
mod report;
mod shape;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use clap::ValueEnum;

use self::embree::Device;
use self::report::Report;

/// Measure Rondure against Embree, POV-Ray and the paper's methods
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Writes race.md, race.csv and race.svg. Everything runs on one thread; times are \
                        CPU times of that thread, medians of interleaved rounds. The full race takes \
                        about half an hour and 3 GB of memory; run it on a quiet machine."
)]
pub(crate) struct Options {
    /// A look at it in a few minutes: two rounds, meshes of 1e-3 and 1e-4, small pictures
    #[arg(long)]
    quick: bool,

    /// Profiles to race on: names of files in profiles/
    #[arg(long, num_args = 1.., default_values = ["vase", "goblet", "pawn", "column"])]
    shapes: Vec<String>,

    /// Errors of Embree's meshes, of the height of the shape [default: 1e-3 1e-4 1e-5 1e-6]
    #[arg(long, num_args = 1.., value_parser = error)]
    errors: Vec<f64>,

    /// How often everybody answers each set of rays [default: 5]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,

    /// What to race
    #[arg(long, num_args = 1.., value_enum, default_values_t = Part::value_variants().to_vec())]
    parts: Vec<Part>,

    /// Where the report goes
    #[arg(long, default_value = "target/race")]
    out: PathBuf,

    /// The folder of libembree4.so.4 and libtbb.so.12; without it they are installed with pip into
    /// target/race/embree
    #[arg(long)]
    embree: Option<PathBuf>,
}

/// What can be raced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Rays on meshes in Embree
    Embree,
    /// Rondure's own engines, those of the paper among them
    Engines,
    /// Fields of copies
    Instances,
    /// The still life in POV-Ray 3.7
    Povray,
    /// The paper's scenes
    Paper,
}

fn error(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(error) if (1e-7..0.1).contains(&error) => Ok(error),
        _ => Err("must be a number from 1e-7 to 0.1, such as 1e-4".into()),
    }
}

impl Options {
    fn errors(&self) -> Vec<f64> {
        match (&self.errors[..], self.quick) {
            ([], true) => vec![1e-3, 1e-4],
            ([], false) => vec![1e-3, 1e-4, 1e-5, 1e-6],
            (given, _) => {
                let mut errors = given.to_vec();
                errors.sort_by(|a, b| b.total_cmp(a));
                errors
            }
        }
    }

    fn rounds(&self) -> u32 {
        self.rounds.unwrap_or(if self.quick { 2 } else { 5 })
    }

    fn races(&self, part: Part) -> bool {
        self.parts.contains(&part)
    }
}

/// Installs the peers, measures everything, and writes the report.
pub(crate) fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let folder = options.embree.clone().unwrap_or_else(|| PathBuf::from("target/race/embree"));
    let libraries = match &options.embree {
        Some(given) => install::find(given)
            .ok_or_else(|| format!("--embree: no libembree4.so in {}", given.display()))?,
        None => install::embree(&folder)?,
    };
    let device = Device::load(&libraries.embree, &libraries.needs)?;
    pin_to_one_core();
    let mut report = Report::new(device.describe(), options.rounds());
    let on_shapes = options.races(Part::Embree) || options.races(Part::Engines);
    for name in options.shapes.iter().filter(|_| on_shapes) {
        report.shapes.push(shape::race(name, &device, options)?);
    }
    if options.races(Part::Instances) {
        report.fields = field::race(&device, options)?;
    }
    if options.races(Part::Povray) {
        report.povray = Some(others::povray(options)?);
    }
    if options.races(Part::Paper) {
        report.paper = Some(others::paper(options)?);
    }
    fs::create_dir_all(&options.out)?;
    let markdown = report.markdown();
    let files = [
        ("race.md", markdown.clone()),
        ("race.csv", report.csv()),
        ("race.svg", plot::plot(&report.shapes)),
    ];
    for (name, text) in files {
        let path = options.out.join(name);
        fs::write(&path, text).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
    }
    println!("{markdown}");
    println!("race.md, race.csv and race.svg are in {}", options.out.display());
    Ok(())
}

/// Keeps this thread, and the programs it starts, on the core it is on. Where that is not allowed,
/// it does without.
fn pin_to_one_core() {
    use nix::sched::{CpuSet, sched_getcpu, sched_setaffinity};
    let pinned = sched_getcpu().and_then(|core| {
        let mut set = CpuSet::new();
        set.set(core)?;
        sched_setaffinity(nix::unistd::Pid::from_raw(0), &set)
    });
    if let Err(error) = pinned {
        eprintln!("note: the race is not pinned to one core: {error}");
    }
}

/// Says what is going on.
fn tell(text: std::fmt::Arguments<'_>) {
    eprintln!("{text}");
}

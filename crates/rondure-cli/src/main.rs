//! The command `rondure`: pictures and exact ray hits of surfaces of revolution.
//!
//! One module per subcommand; [`failure`] is how all of them fail.

mod check;
mod checkpoint;
mod compare;
mod denoise;
mod engine;
mod failure;
mod frames;
mod interrupt;
mod json;
mod look;
mod measure;
mod merge;
mod oidn;
mod output;
mod paper;
mod part;
mod picture;
mod profile;
mod progress;
mod render;
mod room;
mod scene;
mod threads;
mod trace;
mod watch;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Exact ray tracing of surfaces of revolution: vases, goblets, chess pieces, columns.
#[derive(Debug, Parser)]
#[command(name = "rondure", version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Render),
    Merge(merge::Merge),
    Check(check::Check),
    Trace(trace::Trace),
    Measure(measure::Measure),
    Turntable(frames::Turntable),
    Animate(frames::Animate),
    Compare(compare::Compare),
    Denoise(denoise::Denoise),
    Paper(paper::Paper),
}

const EXAMPLES: &str = "\
Examples:
  rondure render scenes/still-life.toml            make still-life.png
  rondure check scenes/*.toml                      read scenes, say what is wrong
  rondure trace goblet.path --rays rays.csv --all  print every hit of every ray
  rondure measure goblet.path --in cm              volume, centroid, what it holds
  rondure turntable scenes/rook.toml               frames and a film from all sides
  rondure denoise still-life.exr -o clean.png      take the noise out of a picture
  rondure compare new.png old.png                  how different two pictures are

`rondure help render`, and so on, explains each command.
Exit codes: 0 all went well, 1 something is wrong with an input or an output, 2 wrong usage,
3 what was compared differs by more than was allowed, 130 stopped by Ctrl-C.";

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(render) => render.run(),
        Command::Merge(merge) => merge.run(),
        Command::Check(check) => check.run(),
        Command::Trace(trace) => trace.run(),
        Command::Measure(measure) => measure.run(),
        Command::Turntable(turntable) => turntable.run(),
        Command::Animate(animate) => animate.run(),
        Command::Compare(compare) => compare.run(),
        Command::Denoise(denoise) => denoise.run(),
        Command::Paper(paper) => paper.run(),
    };
    failure::exit_code(outcome)
}

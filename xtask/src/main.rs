//! Tasks of the workspace that are more than a line of shell: `cargo xtask race`.

use std::{alloc::System, process::ExitCode};

use clap::Parser;
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod race;

/// Where the race cannot be run.
#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
mod race {
    /// Measure Rondure against its peers (only on Linux on x86-64)
    #[derive(Debug, clap::Args)]
    pub(crate) struct Options {}

    pub(crate) fn run(_: &Options) -> Result<(), &'static str> {
        Err("the race needs Linux on x86-64: it loads Embree's library for that")
    }
}

/// Counts bytes, for the memory that a surface takes. Answering rays allocates nothing.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Tasks of the Rondure workspace
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
enum Task {
    Race(race::Options),
}

fn main() -> ExitCode {
    let Task::Race(options) = Task::parse();
    match race::run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

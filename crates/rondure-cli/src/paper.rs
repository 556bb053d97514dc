//! `rondure paper`: the measurements of the paper, made again.

use std::{path::PathBuf, time::Instant};

use clap::Args;
use rondure_paper::{Options, PaperError, WriteError, measure};
use rondure_render::RenderError;

use crate::{
    failure::Failure,
    interrupt,
    progress::{Watcher, seconds},
    threads::Threads,
};

/// Measure the methods of the paper, side by side
#[derive(Debug, Args)]
#[command(after_help = "\
Renders two scenes of the same 24 turned objects, without and with specular reflection, by Kajiya's
strip tree (KJ) and by trees of cylinder (CY), cone (CO) and hybrid (HY) shells, after Wang, Zhu, Gu
2008, \"Quick Ray Tracing Algorithm Based on Surfaces of Revolution\". Prints the paper's tables with
its own numbers beside ours.

With --out it also writes tables.md, tables.csv, matte.png, mirror.png and fig1.svg to fig4.svg.

Examples:
  rondure paper --quick                       small pictures, one run each
  rondure paper --ablate --out paper          everything, into the folder `paper`

Times are those on the processor, summed over all threads. Leave the machine alone meanwhile: other
work still takes caches and clock rate away.")]
pub(crate) struct Paper {
    /// The folder to write to; it is made if it is not there
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Pictures of 128x128 pixels, timed once
    #[arg(long)]
    quick: bool,

    /// Also measure what single choices are worth: leaves, criteria, weights
    #[arg(long)]
    ablate: bool,

    #[command(flatten)]
    threads: Threads,

    /// Say nothing unless something is wrong
    #[arg(short, long)]
    quiet: bool,
}

impl Paper {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mut options =
            Options { threads: self.threads.number(), ablate: self.ablate, ..Options::default() };
        if self.quick {
            (options.size, options.repetitions) = (128, 1);
        }
        let cancelled = interrupt::flag();
        let watcher = Watcher::new(self.quiet, &cancelled);
        let start = Instant::now();
        let measured = measure(&options, &watcher);
        watcher.finish();
        let report = measured.map_err(cannot_measure)?;
        anstream::print!("{}", report.markdown());
        if let Some(folder) = &self.out {
            let files = report.write(folder).map_err(cannot_write)?;
            if !self.quiet {
                let names = files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>();
                anstream::eprintln!("wrote {}", names.join(", "));
            }
        }
        if !self.quiet {
            anstream::eprintln!("measured in {}", seconds(start.elapsed().as_secs_f64()));
        }
        match report.measured.iter().map(|scene| scene.different_pictures).sum::<usize>() {
            0 => Ok(()),
            n => Err(Failure::new(
                format!("{n} pictures differ from the others of their scene"),
                "they must not: please report this",
            )),
        }
    }
}

fn cannot_measure(error: PaperError) -> Failure {
    match error {
        PaperError::Render(RenderError::Cancelled) => Failure::Interrupted,
        PaperError::Render(RenderError::Threads(_)) => {
            Failure::new(error, "ask for fewer with --threads")
        }
        _ => Failure::new(error, "please report this"),
    }
}

fn cannot_write(error: WriteError) -> Failure {
    Failure::new(error, "choose another folder with --out")
}

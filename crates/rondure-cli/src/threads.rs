//! The option `--threads`, which every command that computes has.

use std::num::NonZeroUsize;

use clap::Args;

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct Threads {
    /// How many threads to use; all cores if not given
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

impl Threads {
    /// The number asked for, if one was.
    pub(crate) fn number(&self) -> Option<NonZeroUsize> {
        self.threads
    }

    /// That many threads.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        let number = self.number().map_or(0, NonZeroUsize::get);
        rayon::ThreadPoolBuilder::new().num_threads(number).build().map_err(|error| {
            Failure::new(
                format!("cannot start the threads: {error}"),
                "ask for fewer with --threads",
            )
        })
    }
}

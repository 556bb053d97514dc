//! The option `--threads`, which every command that computes has.

use clap::Args;

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct Threads {
    /// How many threads to use; all cores if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Threads {
    /// The number asked for, if one was.
    pub(crate) fn number(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    /// That many threads.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        let number = self.number().unwrap_or(0);
        rayon::ThreadPoolBuilder::new().num_threads(number).build().map_err(|error| {
            Failure::new(
                format!("cannot start the threads: {error}"),
                "ask for fewer with --threads",
            )
        })
    }
}

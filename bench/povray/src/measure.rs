//! Running a program and what it took.

use std::{
    error::Error,
    process::{Command, Stdio},
    time::Instant,
};

use nix::sys::resource::{Usage, UsageWho, getrusage};
use nix::sys::time::TimeValLike;

/// What a program took, in seconds, and what it said.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) wall: f64,
    /// In user mode, all threads together.
    pub(crate) user: f64,
    pub(crate) said: String,
}

/// Runs a program to its end.
pub(crate) fn run(command: &mut Command) -> Result<Run, Box<dyn Error>> {
    let user = |usage: Usage| usage.user_time().num_microseconds() as f64 * 1e-6;
    let before = user(getrusage(UsageWho::RUSAGE_CHILDREN)?);
    let start = Instant::now();
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|e| format!("cannot run {}: {e}", command.get_program().display()))?;
    let wall = start.elapsed().as_secs_f64();
    let user = user(getrusage(UsageWho::RUSAGE_CHILDREN)?) - before;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if !output.status.success() {
        let program = command.get_program().display();
        return Err(format!("{program} failed ({}):\n{said}", output.status).into());
    }
    Ok(Run { wall, user, said })
}

/// The middle, the least and the greatest of some numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) least: f64,
    pub(crate) greatest: f64,
}

impl Spread {
    /// Of at least one number.
    pub(crate) fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut numbers: Vec<_> = numbers.into_iter().collect();
        numbers.sort_by(f64::total_cmp);
        let n = numbers.len();
        let median = 0.5 * (numbers[(n - 1) / 2] + numbers[n / 2]);
        Self { median, least: numbers[0], greatest: numbers[n - 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_counts() {
        assert_eq!(Spread::of([3.0, 1.0, 2.0]).median, 2.0);
        assert_eq!(Spread::of([4.0, 1.0, 2.0, 3.0]).median, 2.5);
    }
}

//! The races that other tools of the workspace run: the still life against POV-Ray (`bench/povray`),
//! and the scenes of the paper (`rondure-paper`).

use std::error::Error;
use std::process::{Command, Stdio};

use rondure::{EngineOptions, Method};
use rondure_paper::{Measured, measure};

use super::contest::median;
use super::{Options, tell};

/// The still life, whole processes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Povray {
    /// CPU seconds, medians.
    pub(crate) povray: f64,
    pub(crate) rondure: f64,
    /// The ratio of the CPU times per ray followed.
    pub(crate) per_ray: Option<f64>,
}

pub(crate) fn povray(options: &Options) -> Result<Povray, Box<dyn Error>> {
    tell(format_args!("the still life in POV-Ray and in Rondure"));
    let mut command = Command::new("bench/povray/run.sh");
    if options.quick {
        command.args(["--size", "320", "240"]);
    }
    command.args(["--runs".into(), options.rounds().to_string()]);
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("cannot run bench/povray/run.sh: {e}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Err(format!("bench/povray/run.sh failed ({})", output.status).into());
    }
    read(&said).ok_or_else(|| format!("bench/povray/run.sh printed no table:\n{said}").into())
}

/// Reads the table that `bench-povray` prints.
fn read(said: &str) -> Option<Povray> {
    let row = |name: &str| said.lines().find_map(|line| line.trim().strip_prefix(name));
    // Each cell is `median (least to greatest)`.
    let cells: Vec<_> = row("whole process, CPU")?.split_whitespace().collect();
    let number = |i: usize| cells.get(i)?.parse().ok();
    let per_ray = row("CPU, per ray followed").and_then(|rest| rest.trim().parse().ok());
    Some(Povray { povray: number(0)?, rondure: number(4)?, per_ray })
}

/// One engine on one of the paper's scenes.
#[derive(Clone, Debug)]
pub(crate) struct PaperRun {
    pub(crate) engine: String,
    /// CPU seconds of a picture, the median.
    pub(crate) seconds: f64,
}

/// One of the paper's scenes: Rondure's default engine first.
#[derive(Clone, Debug)]
pub(crate) struct PaperScene {
    pub(crate) name: &'static str,
    pub(crate) runs: Vec<PaperRun>,
}

pub(crate) fn paper(options: &Options) -> Result<Vec<PaperScene>, Box<dyn Error>> {
    tell(format_args!("the paper's scenes"));
    let mut what = rondure_paper::Options {
        threads: Some(1),
        repetitions: options.rounds(),
        ..rondure_paper::Options::default()
    };
    if options.quick {
        what.size = 128;
    }
    let report = measure(&what, &())?;
    Ok(report.measured.iter().map(scene).collect())
}

fn scene(measured: &Measured) -> PaperScene {
    let name = |engine: &EngineOptions| match (engine.method, engine.subdivide) {
        (method @ Method::Exact, _) => method.name().to_owned(),
        (method, 0) => format!("{}, not subdivided", method.name()),
        (method, n) if n > 16 => format!("{}, to single frusta", method.name()),
        (method, n) => format!("{}, 2^{n} leaves", method.name()),
    };
    let mut runs: Vec<_> = measured.runs.iter().collect();
    let default = EngineOptions::default().method;
    runs.sort_by_key(|run| run.engine.method != default);
    let run = |run: &&rondure_paper::Run| PaperRun {
        engine: name(&run.engine),
        seconds: median(&run.seconds),
    };
    PaperScene { name: measured.name, runs: runs.iter().map(run).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_povray_is_read() {
        let said = "samples per pixel: 1\n  seconds    POV-Ray  Rondure ratio\n  whole process, CPU   \
                    38.126 (36.100 to 39.900)  3.660 (3.220 to 3.810)  10.42\n  CPU, per ray followed \
                    8.40\n";
        let expected = Povray { povray: 38.126, rondure: 3.66, per_ray: Some(8.4) };
        assert_eq!(read(said), Some(expected));
        assert_eq!(read("nothing"), None);
    }
}

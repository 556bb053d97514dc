//! What was measured, as Markdown, as CSV, and as pictures.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use rondure::engine::{Criterion, Statistics};
use rondure::{EngineOptions, Method};
use rondure_render::Picture;

use crate::ablation::{Ablation, Choice};
use crate::measure::{Measured, Options, Run, TO_SINGLE_FRUSTA};
use crate::published::Published as Printed;
use crate::{figures, published};

/// Everything that was measured.
#[derive(Debug)]
pub struct Report {
    /// How.
    pub options: Options,
    /// The two scenes.
    pub measured: Vec<Measured>,
    /// What single choices are worth, if that was asked for.
    pub ablation: Option<Ablation>,
}

/// Why a file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A file or folder could not be made.
    #[error("cannot write `{}`: {source}", path.display())]
    Io {
        /// Which one.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A picture could not be written.
    #[error(transparent)]
    Picture(#[from] rondure_render::WriteError),
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> WriteError + '_ {
    |source| WriteError::Io { path: path.to_owned(), source }
}

impl Report {
    /// Writes all files into a folder, which is made if it is not there: `tables.md`, `tables.csv`,
    /// a picture for each scene and `fig1.svg` to `fig4.svg`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, WriteError> {
        std::fs::create_dir_all(folder).map_err(io_error(folder))?;
        let mut written = Vec::new();
        let mut text = |name: &str, text: &[u8]| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(io_error(&path))?;
            written.push(path);
            Ok::<(), WriteError>(())
        };
        text("tables.md", self.markdown().as_bytes())?;
        let table = self.csv().map_err(|e| io::Error::other(e.to_string()));
        text("tables.csv", &table.map_err(io_error(folder))?)?;
        for (name, figure) in figures::all() {
            text(name, figure.as_bytes())?;
        }
        for scene in &self.measured {
            let path = folder.join(format!("{}.png", scene.name));
            Picture::write_png(&scene.picture, &path, 8)?;
            written.push(path);
        }
        Ok(written)
    }

    /// The tables as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        for (i, scene) in self.measured.iter().enumerate() {
            self.table(&mut text, i, scene);
        }
        if let Some(ablation) = &self.ablation {
            self.ablation_tables(&mut text, ablation);
        }
        text
    }

    fn table(&self, text: &mut String, i: usize, scene: &Measured) {
        let Options { threads, samples, subdivide, repetitions, size, .. } = self.options;
        let title = ["without specular reflection", "with specular reflection"][i.min(1)];
        let (objects, profiles) = scene.objects;
        let threads = threads.map_or("all threads".into(), |n| format!("threads: {n}"));
        let rays = scene.runs.first().map_or(0, |run| run.work.rays);
        line(text, &format!("### Table {}: {title}\n", i + 1));
        line(
            text,
            &format!(
                "{objects} objects of {profiles} profiles, {size}x{size} pixels, profiles of about \
                 {samples} points, intervals in 2^{subdivide} leaves where subdivided; best of \
                 {repetitions} interleaved runs, {threads}, time on the processor summed over all \
                 threads; {:.2} million searches for hits per \
                 picture. \"a / b\" is subdivided / not.\n",
                rays as f64 / 1e6
            ),
        );
        let Some(reference) = scene.find(Method::Kj, TO_SINGLE_FRUSTA) else { return };
        let (t, tests) = (reference.best(), reference.work.shell_tests as f64);
        line(
            text,
            "| shells | time / s | time / % | visited nodes / % | shell tests / 10^6 | positive \
             tests / 10^6 | leaf solves / 10^6 |",
        );
        line(text, &format!("|{}", " --- |".repeat(7)));
        let rows = self.rows(scene);
        for (name, runs) in &rows {
            let millions = |n: u64| format!("{:.2}", n as f64 / 1e6);
            let cells = [
                name.to_string(),
                both(runs, |r| format!("{:.2}", r.best())),
                both(runs, |r| format!("{:.0}", 100.0 * (t - r.best()) / r.best())),
                both(runs, |r| {
                    let share = r.work.nodes_visited as f64 / r.work.nodes_there as f64;
                    format!("{:.2}", 100.0 * share)
                }),
                both(runs, |r| millions(r.work.shell_tests)),
                both(runs, |r| millions(r.work.positive_tests)),
                both(runs, |r| millions(r.work.leaf_solves)),
            ];
            line(text, &format!("| {} |", cells.join(" | ")));
        }
        line(
            text,
            "\nBeside the paper:\n\n| shells | speed-up over KJ | paper | shell tests relative to KJ \
             | paper | paper: time / s | paper: time / % | paper: visited nodes / % | paper: \
             intersections / 10^6 |",
        );
        line(text, &format!("|{}", " --- |".repeat(9)));
        for (name, runs) in &rows {
            let printed = |f: &dyn Fn(Printed, Printed) -> String| {
                both(runs, |r| {
                    // The paper's KJ is Kajiya's own.
                    let own =
                        r.engine.method != Method::Kj || r.engine.subdivide == TO_SINGLE_FRUSTA;
                    let subdivided = r.engine.subdivide > 0;
                    let entry = published::entry(i, r.engine.method, subdivided).filter(|_| own);
                    let pair = entry.zip(published::entry(i, Method::Kj, true));
                    pair.map_or("-".into(), |(own, kj)| f(own, kj))
                })
            };
            let cells = [
                name.to_string(),
                both(runs, |r| format!("{:.2}", t / r.best())),
                printed(&|own, kj| format!("{:.2}", kj.seconds / own.seconds)),
                both(runs, |r| format!("{:.3}", r.work.shell_tests as f64 / tests)),
                printed(&|own, kj| format!("{:.3}", own.intersections / kj.intersections)),
                printed(&|own, _| format!("{:.2}", own.seconds)),
                printed(&|own, kj| format!("{:.2}", 100.0 * (kj.seconds / own.seconds - 1.0))),
                printed(&|own, _| format!("{:.2}", own.visited)),
                printed(&|own, _| format!("{:.2}", own.intersections)),
            ];
            line(text, &format!("| {} |", cells.join(" | ")));
        }
        let frusta = scene.runs.iter().filter(|run| run.engine.method != Method::Exact).count();
        let same = match scene.different_pictures {
            0 => format!("All {frusta} pictures on frusta are the same bit for bit"),
            n => format!("FAULT: {n} of {frusta} pictures on frusta differ"),
        };
        let noise = scene.runs.iter().map(|run| run.median() / run.best() - 1.0);
        let noise = noise.fold(0.0, f64::max);
        line(
            text,
            &format!(
                "\n{same}; their channels differ from the exact engine's by {:.1e} of their mean, on \
                 average. The median time of a row is up to {:.0} % above its best.\n",
                scene.difference_to_exact,
                100.0 * noise
            ),
        );
    }

    /// The rows of a table: a name, and the runs that share it, subdivided first.
    fn rows<'a>(&self, scene: &'a Measured) -> Vec<(&'static str, Vec<&'a Run>)> {
        let of = |method, k: &[u32]| k.iter().filter_map(|k| scene.find(method, *k)).collect();
        let both_ways = [self.options.subdivide, 0];
        vec![
            ("KJ, to single frusta", of(Method::Kj, &[TO_SINGLE_FRUSTA])),
            ("KJ, leaves as the others", of(Method::Kj, &both_ways)),
            ("CY", of(Method::Cy, &both_ways)),
            ("CO", of(Method::Co, &both_ways)),
            ("HY", of(Method::Hy, &both_ways)),
            ("BS (ours)", of(Method::Bs, &both_ways)),
            ("exact (ours)", of(Method::Exact, &[0])),
        ]
    }

    fn ablation_tables(&self, text: &mut String, ablation: &Ablation) {
        line(text, "### Leaves in each monotone interval\n");
        line(
            text,
            "Nanoseconds for a random line that meets the sphere round the object, mean over all \
             profiles; below each, shell tests and leaf solves per ray.\n",
        );
        let ks: Vec<u32> = (0..=8).chain([TO_SINGLE_FRUSTA]).collect();
        let names = ks.iter().map(|k| match *k {
            TO_SINGLE_FRUSTA => "single frusta".into(),
            k => format!("2^{k}"),
        });
        line(text, &format!("| shells | {} |", names.collect::<Vec<_>>().join(" | ")));
        line(text, &format!("|{}", " --- |".repeat(ks.len() + 1)));
        for choices in ablation.leaves.chunks(ks.len()) {
            let cells = |f: &dyn Fn(&Choice) -> String| {
                choices.iter().map(f).collect::<Vec<_>>().join(" | ")
            };
            let name = choices.first().map_or(String::new(), |c| c.engine.method.name().into());
            line(
                text,
                &format!(
                    "| {} | {} |",
                    name.to_uppercase(),
                    cells(&|c| format!("{:.0}", c.nanoseconds))
                ),
            );
            let work = cells(&|c| {
                let (tests, solves) = (c.work.shell_tests, c.work.leaf_solves);
                format!("{:.1}, {:.1}", c.per_ray(tests), c.per_ray(solves))
            });
            line(text, &format!("| | {work} |"));
        }
        line(text, &format!("\nThe exact engine: {:.0} ns.\n", ablation.exact.nanoseconds));

        line(text, "### The criterion of the hybrid shell\n");
        line(text, "| criterion | ns per ray | shell tests per ray | leaf solves per ray |");
        line(text, "| --- | --- | --- | --- |");
        for choice in &ablation.criteria {
            let (tests, solves) = (choice.work.shell_tests, choice.work.leaf_solves);
            line(
                text,
                &format!(
                    "| {} | {:.0} | {:.2} | {:.2} |",
                    criterion_name(&choice.engine),
                    choice.nanoseconds,
                    choice.per_ray(tests),
                    choice.per_ray(solves)
                ),
            );
        }
        line(text, "\n### Cost of a shell test\n");
        line(
            text,
            "Nanoseconds, fitted to the table of leaves by least squares: an overhead and a cost of a \
             leaf solve that are the same for all methods, and the cost of a test of each.\n",
        );
        line(text, "| shells | ns per shell test |");
        line(text, "| --- | --- |");
        for cost in ablation.costs() {
            let name = cost.method.name().to_uppercase();
            line(text, &format!("| {name} | {:.1} |", cost.test));
        }
        if let Some(cost) = ablation.costs().first() {
            line(text, &format!("\nA leaf solve costs {:.1} ns.", cost.solve));
        }
    }

    /// All numbers, one line for each engine in each scene, and for each choice of the ablation.
    ///
    /// # Errors
    /// None that writing to memory does not have.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut table = csv::Writer::from_writer(Vec::new());
        let settings = ["scene", "method", "subdivide", "criterion", "samples"];
        let times = ["seconds_best", "seconds_median", "nanoseconds_per_ray"];
        table.write_record(settings.iter().chain(&times).chain(&Statistics::NAMES))?;
        let mut record = |scene: &str, e: &EngineOptions, times: [String; 3], work: Statistics| {
            let mut fields = vec![
                scene.to_owned(),
                e.method.name().to_owned(),
                e.subdivide.to_string(),
                criterion_name(e),
                e.samples.to_string(),
            ];
            fields.extend(times);
            fields.extend(work.numbers().map(|n| n.to_string()));
            table.write_record(fields)
        };
        for scene in &self.measured {
            for run in &scene.runs {
                let times = [run.best(), run.median()].map(|t| t.to_string());
                let [best, median] = times;
                record(scene.name, &run.engine, [best, median, String::new()], run.work)?;
            }
        }
        if let Some(ablation) = &self.ablation {
            let all = ablation.leaves.iter().chain(&ablation.criteria).chain([&ablation.exact]);
            for choice in all {
                let times = [String::new(), String::new(), choice.nanoseconds.to_string()];
                record("rays", &choice.engine, times, choice.work)?;
            }
        }
        table.into_inner().map_err(|e| io::Error::other(e.to_string()).into())
    }
}

impl Measured {
    /// The run of a method.
    pub fn find(&self, method: Method, subdivide: u32) -> Option<&Run> {
        self.runs.iter().find(|r| r.engine.method == method && r.engine.subdivide == subdivide)
    }
}

fn criterion_name(engine: &EngineOptions) -> String {
    match (engine.method, engine.criterion) {
        (Method::Hy, Criterion::Area { cone_weight: 1.0 }) => "area".into(),
        (Method::Hy, Criterion::Area { cone_weight: f64::INFINITY }) => {
            "cylinders in all inner nodes".into()
        }
        (Method::Hy, Criterion::Area { cone_weight }) => format!("area, cones times {cone_weight}"),
        (Method::Hy, Criterion::Interval) => "interval".into(),
        _ => String::new(),
    }
}

/// One entry, or those of the subdivided and the other run; a single `-` where there is none.
fn both(runs: &[&Run], entry: impl Fn(&Run) -> String) -> String {
    let mut entries: Vec<String> = runs.iter().map(|run| entry(run)).collect();
    if entries.iter().all(|e| e == "-") {
        entries.truncate(1);
    }
    entries.join(" / ")
}

fn line(text: &mut String, line: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

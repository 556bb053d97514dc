//! The report: Markdown for people, CSV for programs.

use std::fmt::Write as _;

use rondure::EngineOptions;

use super::contest::Score;
use super::field::FieldResult;
use super::mesh::Kind;
use super::others::{PaperScene, Povray};
use super::shape::{Best, Engines, ShapeResult};

/// Everything that was measured.
#[derive(Debug)]
pub(crate) struct Report {
    embree: String,
    rounds: u32,
    pub(crate) shapes: Vec<ShapeResult>,
    pub(crate) fields: Vec<FieldResult>,
    pub(crate) povray: Option<Povray>,
    pub(crate) paper: Option<Vec<PaperScene>>,
}

impl Report {
    pub(crate) fn new(embree: String, rounds: u32) -> Self {
        Self { embree, rounds, shapes: Vec::new(), fields: Vec::new(), povray: None, paper: None }
    }

    pub(crate) fn markdown(&self) -> String {
        let mut text = String::from("# The race\n\n");
        let engine = default_name();
        let (version, cpu) = (env!("CARGO_PKG_VERSION"), processor());
        line(
            &mut text,
            format_args!(
                "Rondure {version} (engine `{engine}`, f64, exact) against {}. One thread of: {cpu}. Millions of \
             rays a second, medians of {} interleaved rounds by CPU time.",
                self.embree, self.rounds,
            ),
        );
        for shape in &self.shapes {
            shape_section(&mut text, shape);
        }
        if self.shapes.iter().any(|shape| shape.engines.is_some()) {
            engines_section(&mut text, &self.shapes);
        }
        if !self.shapes.is_empty() {
            building_section(&mut text, &self.shapes);
        }
        if !self.fields.is_empty() {
            fields_section(&mut text, &self.fields);
        }
        if let Some(povray) = self.povray {
            povray_section(&mut text, povray);
        }
        if let Some(paper) = &self.paper {
            paper_section(&mut text, paper);
        }
        text
    }

    /// Every score on the shapes: rays a second, median, least and greatest.
    pub(crate) fn csv(&self) -> String {
        let mut text =
            String::from("shape,rays,engine,kind,error,median,least,greatest,count,hits\n");
        let mut row = |shape: &str,
                       set: &str,
                       count,
                       [engine, kind]: [&str; 2],
                       error: f64,
                       score: &Score| {
            let [least, greatest] = score.spread();
            line(
                &mut text,
                format_args!(
                    "{shape},\"{set}\",{engine},{kind},{error:e},{:.0},{least:.0},{greatest:.0},{count},{}",
                    score.median(),
                    score.hits,
                ),
            );
        };
        for shape in &self.shapes {
            for (i, set) in shape.sets.iter().enumerate() {
                if let Some(score) = shape.rondure(i) {
                    row(&shape.name, &set.name, set.rays, ["rondure", default_name()], 0.0, &score);
                }
                for error in &shape.errors {
                    for mesh in error.heats.iter().flat_map(|heat| &heat.meshes) {
                        if let Some(score) = &mesh.scores[i] {
                            let names = ["embree", mesh.kind.name()];
                            row(&shape.name, &set.name, set.rays, names, error.error, score);
                        }
                    }
                }
            }
        }
        text
    }
}

/// Writes a line; writing to a string cannot fail.
fn line(text: &mut String, what: std::fmt::Arguments<'_>) {
    let _ = writeln!(text, "{what}");
}

fn default_name() -> &'static str {
    EngineOptions::default().method.name()
}

fn row(text: &mut String, cells: impl IntoIterator<Item = String>) {
    let cells: Vec<_> = cells.into_iter().collect();
    line(text, format_args!("| {} |", cells.join(" | ")));
}

/// A table: what its columns are, then its rows.
fn table(text: &mut String, head: &[String], rows: impl IntoIterator<Item = Vec<String>>) {
    text.push('\n');
    row(text, head.iter().cloned());
    row(text, head.iter().map(|_| "---".to_owned()));
    for cells in rows {
        row(text, cells);
    }
}

fn millions(rate: f64) -> String {
    let rate = rate * 1e-6;
    if rate < 100.0 { format!("{}", round(rate)) } else { format!("{rate:.0}") }
}

/// To three digits.
fn round(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let scale = 10.0_f64.powi(2 - x.abs().log10().floor() as i32);
    (x * scale).round() / scale
}

fn or_dash<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), show)
}

fn letter(kind: Kind) -> &'static str {
    match kind {
        Kind::Triangles => "t",
        Kind::Quads => "q",
        Kind::Grids => "g",
    }
}

fn shape_section(text: &mut String, shape: &ShapeResult) {
    if shape.errors.is_empty() {
        return;
    }
    line(text, format_args!("\n## {}, {} segments", shape.name, shape.segments));
    line(
        text,
        format_args!(
            "\nEmbree with its fastest kind of mesh (t triangles, q quads, g grids) of each error, and how many \
         times as fast Rondure is."
        ),
    );
    let mut head = vec!["rays".to_owned(), "count".into(), "hit".into(), "Rondure".into()];
    head.extend(shape.errors.iter().map(|error| format!("Embree {:e}", error.error)));
    head.extend(shape.errors.iter().map(|error| format!("ratio {:e}", error.error)));
    let rows = shape.sets.iter().enumerate().map(|(i, set)| {
        let own = shape.rondure(i);
        let hits = or_dash(own.as_ref(), |score| {
            format!("{:.1} %", 100.0 * score.hits as f64 / set.rays as f64)
        });
        let own = or_dash(own, |score| millions(score.median()));
        let mut cells = vec![set.name.clone(), set.rays.to_string(), hits, own];
        let best: Vec<_> = shape.errors.iter().map(|error| error.best(i)).collect();
        cells.extend(best.iter().map(|best| {
            or_dash(best.as_ref(), |Best { kind, rate, .. }| {
                format!("{} {}", millions(*rate), letter(*kind))
            })
        }));
        cells.extend(best.iter().map(|best| or_dash(best.and_then(|best| best.ratio), ratio)));
        cells
    });
    table(text, &head, rows);
}

fn ratio(x: f64) -> String {
    format!("{x:.2}")
}

fn engines_section(text: &mut String, shapes: &[ShapeResult]) {
    line(text, format_args!("\n## Rondure's engines"));
    line(
        text,
        format_args!(
            "\nOf each set every few rays. In brackets: how many times as fast `{}` is. All but `exact` and \
         `wide` work on a polyline of about {} points.",
            default_name(),
            EngineOptions::default().samples,
        ),
    );
    let all: Vec<(&str, &Engines)> = shapes
        .iter()
        .filter_map(|shape| Some((shape.name.as_str(), shape.engines.as_ref()?)))
        .collect();
    let Some((_, first)) = all.first() else { return };
    let mut head = vec!["shape".to_owned(), "rays".into()];
    head.extend(first.results.iter().map(|engine| format!("`{}`", engine.method.name())));
    let rows = all.iter().flat_map(|(name, engines)| {
        engines.sets.iter().enumerate().map(move |(i, set)| {
            let own = engines.results[0].scores[i].as_ref().map(Score::median);
            let mut cells = vec![(*name).to_owned(), set.name.clone()];
            cells.extend(engines.results.iter().enumerate().map(|(j, engine)| {
                or_dash(engine.scores[i].as_ref(), |score| match own {
                    Some(own) if j > 0 => {
                        let rate = score.median();
                        format!("{} ({:.1})", millions(rate), own / rate)
                    }
                    _ => millions(score.median()),
                })
            }));
            cells
        })
    });
    table(text, &head, rows);
}

fn building_section(text: &mut String, shapes: &[ShapeResult]) {
    line(text, format_args!("\n## Memory and building"));
    line(
        text,
        format_args!(
            "\nWhat is kept after building, and CPU time of building. Embree: mesh and tree, without the time of \
         making the mesh."
        ),
    );
    let head = ["shape", "", "cells", "MB", "ms"].map(str::to_owned);
    let cells = |name: &str, what: String, cells: String, built: super::shape::Built| {
        let [mb, ms] = [built.bytes * 1e-6, built.seconds * 1e3].map(|x| round(x).to_string());
        vec![name.to_owned(), what, cells, mb, ms]
    };
    let rows = shapes.iter().flat_map(|shape| {
        let own =
            cells(&shape.name, format!("Rondure `{}`", default_name()), "–".into(), shape.built);
        let engines = shape.engines.iter().flat_map(|engines| &engines.results).skip(1);
        let engines = engines.map(|engine| {
            cells(
                &shape.name,
                format!("Rondure `{}`", engine.method.name()),
                "–".into(),
                engine.built,
            )
        });
        let meshes = shape.errors.iter().flat_map(|error| {
            let meshes = error.heats.iter().flat_map(|heat| &heat.meshes);
            meshes.map(|mesh| {
                let what = format!("Embree {}, {:e}", mesh.kind.name(), error.error);
                cells(&shape.name, what, error.cells.to_string(), mesh.built)
            })
        });
        std::iter::once(own).chain(engines).chain(meshes)
    });
    table(text, &head, rows);
}

fn fields_section(text: &mut String, fields: &[FieldResult]) {
    line(text, format_args!("\n## Copies of the vase"));
    line(
        text,
        format_args!(
            "\nEmbree's meshes have an error of 1e-4. MB and ms: what the copies add to the model."
        ),
    );
    let Some(first) = fields.first() else { return };
    let mut head = vec!["copies".to_owned(), "engine".into()];
    head.extend(first.sets.iter().map(|(name, _)| name.clone()));
    head.extend(["hit", "MB", "ms"].map(str::to_owned));
    let rows = fields.iter().flat_map(|field| {
        field.scores.iter().map(move |entry| {
            let mut cells = vec![field.copies.to_string(), entry.engine.clone()];
            cells.extend(
                entry
                    .scores
                    .iter()
                    .map(|score| or_dash(score.as_ref(), |score| millions(score.median()))),
            );
            let hits = std::iter::zip(&entry.scores, &field.sets).map(|(score, (_, rays))| {
                or_dash(score.as_ref(), |score| {
                    format!("{:.1}", 100.0 * score.hits as f64 / *rays as f64)
                })
            });
            cells.push(format!("{} %", hits.collect::<Vec<_>>().join(", ")));
            let [mb, ms] = [entry.top.bytes * 1e-6, entry.top.seconds * 1e3];
            cells.extend([mb, ms].map(|x| round(x).to_string()));
            cells
        })
    });
    table(text, &head, rows);
}

fn povray_section(text: &mut String, povray: Povray) {
    line(
        text,
        format_args!(
            "\n## POV-Ray: the still life\n\nWhole process, CPU seconds; see bench/README.md."
        ),
    );
    let head = ["POV-Ray 3.7", "Rondure", "ratio", "per ray followed"].map(str::to_owned);
    let per_ray = or_dash(povray.per_ray, ratio);
    let seconds = [povray.povray, povray.rondure].map(|s| format!("{s:.2}"));
    let [own, other] = [seconds[1].clone(), seconds[0].clone()];
    table(text, &head, [vec![other, own, ratio(povray.povray / povray.rondure), per_ray]]);
}

fn paper_section(text: &mut String, scenes: &[PaperScene]) {
    line(
        text,
        format_args!(
            "\n## The paper's scenes\n\nWhole pictures with shading, CPU seconds; in brackets how many times as \
         fast the first engine is."
        ),
    );
    let mut head = vec!["engine".to_owned()];
    head.extend(scenes.iter().map(|scene| scene.name.to_owned()));
    let Some(first) = scenes.first() else { return };
    let rows = first.runs.iter().enumerate().map(|(i, run)| {
        let mut cells = vec![run.engine.clone()];
        cells.extend(scenes.iter().map(|scene| {
            let [own, seconds] = [0, i].map(|i| scene.runs[i].seconds);
            format!("{seconds:.3} ({:.2})", seconds / own)
        }));
        cells
    });
    table(text, &head, rows);
}

/// What the processor calls itself.
fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = info.lines().find(|line| line.starts_with(name))?;
        Some(line.split(':').nth(1)?.trim().to_owned())
    };
    let model = field("model name").unwrap_or_else(|| "an unknown processor".into());
    match (field("cpu family"), field("model\t")) {
        (Some(family), Some(number)) => format!("{model} (family {family}, model {number})"),
        _ => model,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!(round(0.012_345).to_string(), "0.0123");
        assert_eq!(millions(24_123_456.0), "24.1");
        assert_eq!(millions(162_400_000.0), "162");
        assert_eq!(round(0.0), 0.0);
    }
}

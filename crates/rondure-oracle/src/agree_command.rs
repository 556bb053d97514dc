//! `rondure-oracle agree`: holds the wide engine to the exact one and prints a table.

use std::{fs, path::Path, process::ExitCode, thread, time::Instant};

use crate::command::{answer, number};
use rondure::{Profile, engine::Instructions};
use rondure_oracle::agree::{Amount, Count, Failure, Shape, compare, shapes, wide};

const USAGE: &str = "usage: rondure-oracle agree [--rays N] [--adversarial N] [--profiles LIST]
                            [--instructions NAME] [--seed S] [--threads N]
Holds the wide engine to the exact one on N random (1e7) and N adversarial (1e6) rays for each shape and
instruction set.
  --profiles      names of shapes or files of path data, with commas between them; all shapes unless told
  --instructions  portable, avx2, avx512 or all (the default)
lost, extra, other (another piece), off (farther off than rounding explains, and how far), wrong (out of
order, out of range, odd) are disagreements, counted in rays; the exit status is 1 if there are any.
worst is the largest |dt| over the radius, the last places of t itself left out. The rest is explained by
rounding: graze, hits within the rounding bound of their incidence only, with the largest |dt| over the
radius and sine of the incidence; tangent, rays that all but touch, with the largest distance from touching
over the size; joint, hits given to the neighbour; end, hits at an end of the range; tie, closest hits of
two parts of the surface at one place.";

struct Options {
    amount: Amount,
    shapes: Vec<Shape>,
    instructions: Vec<Instructions>,
}

const FORCED: [Instructions; 3] =
    [Instructions::Portable, Instructions::Avx2, Instructions::Avx512];

pub(crate) fn run(arguments: impl Iterator<Item = String>) -> ExitCode {
    answer(options(arguments), USAGE, |options| agree(&options))
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Option<Options>, String> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let amount = Amount { random: 10_000_000, adversarial: 1_000_000, seed: 1, threads };
    let shapes = shapes().map_err(|error| error.to_string())?;
    let mut options = Options { amount, shapes, instructions: FORCED.to_vec() };
    while let Some(name) = arguments.next() {
        if name == "--help" {
            return Ok(None);
        }
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || number(&name, &value);
        match name.as_str() {
            "--rays" => options.amount.random = number()?,
            "--adversarial" => options.amount.adversarial = number()?,
            "--seed" => options.amount.seed = number()?,
            "--threads" => options.amount.threads = number()? as usize,
            "--profiles" => {
                let chosen = value.split(',').map(|name| shape(name, &options.shapes));
                options.shapes = chosen.collect::<Result<_, _>>()?;
            }
            "--instructions" if value == "all" => options.instructions = FORCED.to_vec(),
            "--instructions" => {
                let found = Instructions::ALL.iter().find(|(_, name)| *name == value);
                let (instructions, _) = found.ok_or(format!("no instruction set {value}"))?;
                options.instructions = vec![*instructions];
            }
            _ => return Err(format!("unknown option {name}")),
        }
    }
    Ok(Some(options))
}

/// A shape by its name, or from a file.
fn shape(name: &str, shapes: &[Shape]) -> Result<Shape, String> {
    if let Some(shape) = shapes.iter().find(|shape| shape.name == name) {
        return Ok(shape.clone());
    }
    let text = fs::read_to_string(name)
        .map_err(|error| format!("{name} is neither a shape nor a file: {error}"))?;
    let profile = Profile::from_path_data(&text).map_err(|error| format!("{name}: {error}"))?;
    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
    Ok(Shape { name: stem.into_owned(), profile })
}

fn agree(options: &Options) -> ExitCode {
    for instructions in options.instructions.iter().filter(|i| !i.are_available()) {
        println!("this machine has no {instructions:?}");
    }
    println!(
        "{:<14} {:<9} {:>9} {:>10} {:>5} {:>5} {:>5} {:>5} {:>8} {:>5} {:>8} | {:>7} {:>8} {:>8} {:>7} {:>8} {:>6} {:>6} {:>5}",
        "shape",
        "instr.",
        "rays",
        "hits",
        "lost",
        "extra",
        "other",
        "off",
        "off by",
        "wrong",
        "worst",
        "graze",
        "|dt|/R",
        "sine",
        "tangent",
        "distance",
        "joint",
        "end",
        "tie"
    );
    let mut sum = Count::default();
    for shape in &options.shapes {
        let start = Instant::now();
        let entrants = wide(shape, &options.instructions);
        let counts = compare(shape, &entrants, &options.amount);
        for (entrant, count) in entrants.iter().zip(counts) {
            print_row(&shape.name, entrant.name, &count);
            for Failure { kind, words } in &count.failures {
                println!("- {kind}: {words}");
            }
            sum.add(count);
        }
        eprintln!("{}: {:.0} s", shape.name, start.elapsed().as_secs_f64());
    }
    print_row("all", "", &sum);
    if sum.is_clean() && sum.rays > 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn print_row(shape: &str, instructions: &str, c: &Count) {
    let [graze_dt, graze_sine] = c.grazing_worst;
    println!(
        "{shape:<14} {instructions:<9} {:>9} {:>10} {:>5} {:>5} {:>5} {:>5} {:>8.1e} {:>5} {:>8.1e} | {:>7} {:>8.1e} \
         {:>8.1e} {:>7} {:>8.1e} {:>6} {:>6} {:>5}",
        c.rays,
        c.hits,
        c.lost,
        c.extra,
        c.other,
        c.off,
        c.off_worst,
        c.inconsistent,
        c.worst,
        c.grazing,
        graze_dt,
        graze_sine,
        c.tangent,
        c.tangent_worst,
        c.joint,
        c.end,
        c.tie
    );
}

//! `rondure-oracle csg`, `rondure-oracle cuts`: solids made of others, as long as one likes.

use std::{process::ExitCode, time::Instant};

use crate::command::{answer, number};
use rondure_oracle::{
    Random,
    cuts::{Cuts, EYES},
    laws::Laws,
    profiles::{STANDARD, standard},
};

const USAGE: &str = "usage: rondure-oracle csg [--rays N] [--seed S]
       rondure-oracle cuts [--random N] [--seed S] [--only NAME]

csg shoots N random rays (1e6) at random solids, half of them with faces that coincide, and says for each
law of sets (A - A is empty, De Morgan's, ..) how often it was broken.

cuts cuts the standard profiles, capped, and N random ones (100) by a plane at the height of each of their
vertices, and holds every pixel of three pictures of each to the oracle. --only cuts those whose name
contains NAME; random ones are called random.";

struct Options {
    rays: u64,
    random: u64,
    seed: u64,
    only: String,
}

pub(crate) fn run(command: &str, arguments: impl Iterator<Item = String>) -> ExitCode {
    let work = if command == "csg" { csg } else { cuts };
    answer(options(command, arguments), USAGE, |options| work(&options))
}

/// `None` if help is asked for.
fn options(
    command: &str,
    mut arguments: impl Iterator<Item = String>,
) -> Result<Option<Options>, String> {
    let mut options = Options { rays: 1_000_000, random: 100, seed: 1, only: String::new() };
    while let Some(name) = arguments.next() {
        if name == "--help" {
            return Ok(None);
        }
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || number(&name, &value);
        match (name.as_str(), command) {
            ("--rays", "csg") => options.rays = number()?,
            ("--random", "cuts") => options.random = number()?,
            ("--only", "cuts") => options.only = value,
            ("--seed", _) => options.seed = number()?,
            _ => return Err(format!("unknown option {name}")),
        }
    }
    Ok(Some(options))
}

fn csg(options: &Options) -> ExitCode {
    let (mut random, mut laws) = (Random::new(options.seed), Laws::default());
    let mut told = Instant::now();
    while laws.rays < options.rays {
        laws.try_on(1, &mut random);
        if told.elapsed().as_secs() >= 10 {
            told = Instant::now();
            eprintln!("{:.0} %", 100.0 * laws.rays as f64 / options.rays as f64);
        }
    }
    println!("{laws}");
    if laws.hold() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn cuts(options: &Options) -> ExitCode {
    let mut clean = true;
    let mut tell = |name: &str, cuts: &Cuts| {
        println!("{name}: {cuts}");
        clean &= cuts.are_right();
    };
    for (name, _) in STANDARD.iter().filter(|(name, _)| name.contains(&options.only)) {
        let mut cuts = Cuts::default();
        cuts.cut(name, &standard(name).capped(), usize::MAX, &EYES);
        tell(name, &cuts);
    }
    if "random".contains(&options.only) {
        let (mut random, mut cuts) = (Random::new(options.seed), Cuts::default());
        for _ in 0..options.random {
            cuts.cut("random", &random.profile().capped(), usize::MAX, &EYES);
        }
        tell("random", &cuts);
    }
    if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

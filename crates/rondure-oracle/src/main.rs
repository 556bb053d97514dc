//! `rondure-oracle soak`, `csg`, `cuts`, `agree`: the comparisons of the test suites, as long as one likes.

mod agree_command;

use std::{env, process::ExitCode, time::Instant};

use rondure_oracle::{
    Random, Tally,
    cuts::{Cuts, EYES},
    laws::Laws,
    profiles::{SOLIDS, STANDARD, standard},
    solids, suites,
};

const USAGE: &str = "usage: rondure-oracle soak [--rays N] [--seed S] [--only NAME]
       rondure-oracle csg [--rays N] [--seed S]
       rondure-oracle cuts [--random N] [--seed S] [--only NAME]
       rondure-oracle agree [OPTION]..., see agree --help

Shoots N random rays (1e6) at each standard profile and at random ones, and compares every hit
with the exact oracle or a closed form; 10 N at the goblet for parity alone; N at random solids, for
spans. --only runs the parts whose name contains NAME.

csg shoots N random rays at random solids, many of them with faces that coincide, and says for each law
of sets (A - A is empty, De Morgan's, ..) how often it was broken.

cuts cuts the standard profiles, capped, and N random ones (100) by a plane at the height of each of their
vertices, and holds every pixel of three pictures of each to the oracle.";

struct Options {
    rays: u64,
    seed: u64,
    only: String,
    random: u64,
}

fn main() -> ExitCode {
    let command = env::args().nth(1).unwrap_or_default();
    if command == "agree" {
        return agree_command::run(env::args().skip(2));
    }
    match options(&command) {
        Ok(options) if command == "csg" => csg(&options),
        Ok(options) if command == "cuts" => cuts(&options),
        Ok(options) => soak(&options),
        Err(message) => {
            eprintln!("{message}\n{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn options(command: &str) -> Result<Options, String> {
    if !["soak", "csg", "cuts"].contains(&command) {
        return Err("the commands are soak, csg, cuts and agree".into());
    }
    let mut arguments = env::args().skip(2);
    let mut options = Options { rays: 1_000_000, seed: 1, only: String::new(), random: 100 };
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || value.parse::<f64>().map_err(|_| format!("{name}: {value} is no number"));
        match name.as_str() {
            "--random" if command == "cuts" => options.random = number()? as u64,
            "--rays" if command != "cuts" => options.rays = number()? as u64,
            "--seed" => options.seed = number()? as u64,
            "--only" if command != "csg" => options.only = value,
            _ => return Err(format!("unknown option {name}")),
        }
    }
    Ok(options)
}

fn soak(options: &Options) -> ExitCode {
    let mut clean = true;
    let mut part = |name: &str, rays: u64, run: &dyn Fn(u64, &mut Random, &mut Tally)| {
        if !name.contains(&options.only) {
            return;
        }
        let (mut random, mut tally) = (Random::new(options.seed), Tally::default());
        let (start, mut told, mut done) = (Instant::now(), Instant::now(), 0);
        while done < rays {
            let chunk = (rays - done).min(2_000);
            run(chunk, &mut random, &mut tally);
            done += chunk;
            if told.elapsed().as_secs() >= 10 {
                told = Instant::now();
                eprintln!("{name}: {:.0} %", 100.0 * done as f64 / rays as f64);
            }
        }
        let rate = tally.rays as f64 / start.elapsed().as_secs_f64();
        println!("{name}: {tally}\n  {rate:.0} rays/s");
        clean &= tally.is_clean();
    };
    for (name, solid) in SOLIDS {
        part(&format!("closed form {name}"), options.rays, &|rays, random, tally| {
            suites::against_closed_form(name, solid, rays, random, tally);
        });
    }
    for (name, _) in STANDARD {
        let profile = standard(name);
        part(&format!("oracle {name}"), options.rays, &|rays, random, tally| {
            suites::against_oracle(&profile, rays, random, tally);
        });
    }
    part("random profiles", options.rays, &suites::random_profiles);
    let goblet = standard("goblet");
    part("parity goblet", 10 * options.rays, &|rays, random, tally| {
        suites::parity(&goblet, rays, random, tally);
    });
    part("spans of random solids", options.rays, &solids::spans);
    if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE }
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

//! `rondure-oracle soak`, `rondure-oracle agree`: the comparisons of the test suites, as long as one likes.

mod agree_command;
mod command;
mod sets_command;

use std::{
    env,
    process::ExitCode,
    sync::atomic::{AtomicU64, Ordering},
    thread,
    time::Instant,
};

use self::command::{answer, number};
use rondure::Method;
use rondure_oracle::{
    Random, Tally,
    closed::{self, Soak},
    profiles::{SOLIDS, STANDARD, standard},
    solids, suites,
};

const USAGE: &str = "usage: rondure-oracle soak [--rays N] [--seed S] [--only NAME]
                            [--threads N] [--engine wide|exact]
       rondure-oracle agree [OPTION]..., see agree --help
       rondure-oracle csg [OPTION]..., rondure-oracle cuts [OPTION]..., see csg --help

Shoots N random rays (1e6) at each standard profile and at random ones, and compares every hit
with the exact oracle or a closed form; 10 N at the goblet for parity alone; N at random solids, for
spans and for the laws of CSG; 100 N, every other one adversarial, at closed profiles of all kinds and
sizes, for parity, for leaving the surface, and N of them for the oracle. --only runs the parts whose
name contains NAME, --only closed-profiles the last, to
which --threads and --engine belong.

lost, extra, odd, inexact, inconsistent, stuck are failures, counted in rays, and the exit status is 1 if
there are any. A ray in the tangency band may have another number of hits than the oracle's.";

struct Options {
    rays: u64,
    seed: u64,
    only: String,
    threads: usize,
    method: Method,
}

fn main() -> ExitCode {
    if env::args().nth(1).as_deref() == Some("agree") {
        return agree_command::run(env::args().skip(2));
    }
    if let Some(command @ ("csg" | "cuts")) = env::args().nth(1).as_deref() {
        return sets_command::run(command, env::args().skip(2));
    }
    answer(options(), USAGE, |options| soak(&options))
}

fn options() -> Result<Option<Options>, String> {
    let mut arguments = env::args().skip(1);
    match arguments.next().as_deref() {
        Some("soak") => {}
        Some("--help") => return Ok(None),
        _ => return Err("the commands are soak, agree, csg and cuts".into()),
    }
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let mut options =
        Options { rays: 1_000_000, seed: 1, only: String::new(), threads, method: Method::Wide };
    while let Some(name) = arguments.next() {
        if name == "--help" {
            return Ok(None);
        }
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || number(&name, &value);
        match name.as_str() {
            "--rays" => options.rays = number()?,
            "--seed" => options.seed = number()?,
            "--only" => options.only = value,
            "--engine" if value == "exact" => options.method = Method::Exact,
            "--engine" if value == "wide" => options.method = Method::Wide,
            "--threads" => options.threads = number()? as usize,
            _ => return Err(format!("unknown option {name}")),
        }
    }
    Ok(Some(options))
}

fn soak(options: &Options) -> ExitCode {
    let (mut clean, mut parts) = (true, 0);
    let mut part = |name: &str, rays: u64, run: &dyn Fn(u64, &mut Random, &mut Tally)| {
        if !name.contains(&options.only) {
            return;
        }
        parts += 1;
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
    part("laws of CSG", options.rays, &solids::laws);
    if CLOSED_PROFILES.contains(&options.only) {
        parts += 1;
        clean &= closed_profiles(options);
    }
    if parts == 0 {
        eprintln!("--only: no part has {} in its name", options.only);
        return ExitCode::from(2);
    }
    if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Rays at closed profiles for each that is compared with the oracle.
const RAYS_PER_COMPARED: u64 = 100;

const CLOSED_PROFILES: &str = "closed-profiles";

fn closed_profiles(options: &Options) -> bool {
    let &Options { rays: compared, seed, threads, method, .. } = options;
    let plan = Soak { rays: RAYS_PER_COMPARED * compared, compared, seed, threads, method };
    let (start, told) = (Instant::now(), AtomicU64::new(0));
    let outcome = closed::soak(&plan, &|tally| {
        let minutes = start.elapsed().as_secs() / 60;
        if told.fetch_max(minutes, Ordering::Relaxed) < minutes {
            let percent = 100.0 * tally.rays as f64 / plan.rays as f64;
            eprintln!("{CLOSED_PROFILES}: {percent:.1} %, {minutes} min: {}", tally.counts());
        }
    });
    match outcome {
        Ok(tally) => {
            println!(
                "{CLOSED_PROFILES}: {tally}\n  {:.0} rays/s",
                tally.rays as f64 / start.elapsed().as_secs_f64()
            );
            tally.is_clean()
        }
        Err(error) => {
            eprintln!("{error}");
            false
        }
    }
}

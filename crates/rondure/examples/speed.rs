//! How many rays a second one thread answers, on profiles given as files of path data:
//! `cargo run --release -p rondure --example speed profiles/*.path`
//!
//! Camera rays come from a pinhole in scanline order; random rays run from the sphere round the
//! bounding box to a point in the box. The best of seven rounds counts, in CPU time.
//! `--engine NAME` and `--instructions NAME` choose how.

mod rays;

use std::{env, error::Error, fs};

use cpu_time::ThreadTime;
use rondure::engine::{EngineOptions, Instructions, Method};

use rondure::{Hits, Profile, Ray, RayColumns, Surface};

use self::rays::{camera_rays, random_rays};

const ROUNDS: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:<28} {:<8} {:>12} {:>9} {:>9} {:>9} {:>6}",
        "profile", "rays", "closest M/s", "any M/s", "batch M/s", "any M/s", "hit %"
    );
    let mut options = EngineOptions::default();
    let mut args = env::args().skip(1);
    while let Some(file) = args.next() {
        match file.as_str() {
            "--engine" => {
                let name = args.next();
                let method = Method::ALL.iter().find(|(_, n)| Some(*n) == name.as_deref());
                options.method = method.ok_or("no such engine")?.0;
                continue;
            }
            "--instructions" => {
                let name = args.next();
                let found = Instructions::ALL.iter().find(|(_, n)| Some(*n) == name.as_deref());
                options.instructions = found.ok_or("no such instructions")?.0;
                continue;
            }
            _ => {}
        }
        let profile = Profile::from_path_data(&fs::read_to_string(&file)?)?;
        let surface = Surface::with_engine(&profile, &options);
        for (name, rays) in [
            ("camera", camera_rays([1024, 768])),
            ("random", random_rays(&surface.bounds(), 1 << 18)),
        ] {
            let (closest, hits) = best(&rays, |ray| surface.closest(ray).is_some());
            let (any, _) = best(&rays, |ray| surface.any(ray));
            let [many, any_many] = batches(&surface, &rays);
            let share = 100.0 * hits as f64 / rays.len() as f64;
            println!(
                "{file:<28} {name:<8} {closest:>12.2} {any:>9.2} {many:>9.2} {any_many:>9.2} {share:>6.1}"
            );
        }
    }
    Ok(())
}

/// Millions of rays a second in the best round, and how many of them hit.
fn best(rays: &[Ray], hit: impl Fn(&Ray) -> bool) -> (f64, usize) {
    let rounds = (0..ROUNDS).map(|_| {
        let start = ThreadTime::now();
        let hits = rays.iter().filter(|ray| hit(ray)).count();
        (rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6, hits)
    });
    rounds.fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
}

/// The same for batches: the closest hits, and whether there are any.
fn batches(surface: &Surface, rays: &[Ray]) -> [f64; 2] {
    let columns = RayColumns::from_iter(rays);
    let columns = columns.rays();
    let (mut hits, mut any) = (Hits::default(), vec![false; rays.len()]);
    let mut best = [0.0_f64; 2];
    for _ in 0..ROUNDS {
        let rate = |start: ThreadTime| rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6;
        let start = ThreadTime::now();
        surface.closest_of_many(&columns, &mut hits);
        best[0] = best[0].max(rate(start));
        let start = ThreadTime::now();
        surface.any_of_many(&columns, &mut any);
        best[1] = best[1].max(rate(start));
    }
    best
}

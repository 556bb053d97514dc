//! How the answers to rays scale with threads, as a Markdown table:
//! `cargo run --release -p rondure --example threads -- profiles/*.path`
//!
//! Random rays, from the sphere round the bounding box to a point in the box; each thread asks its own part of them, one at a
//! time and as batches. Wall-clock time, the best of the rounds, threads in turn. The last column is the ratio to one thread.

mod rays;

use std::{env, error::Error, fs, hint::black_box, thread, time::Instant};

use rondure::{Hits, Profile, RayColumns, Surface};

use self::rays::random_rays;

const ROUNDS: usize = 9;
const RAYS: usize = 1 << 21;
/// As many rays a thread takes at once.
const BATCH: usize = 1 << 12;

fn main() -> Result<(), Box<dyn Error>> {
    let most = thread::available_parallelism()?.get();
    println!("| profile | threads | single rays, M/s | ratio | batches, M/s | ratio |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for file in env::args().skip(1) {
        let surface = Surface::new(&Profile::from_path_data(&fs::read_to_string(&file)?)?);
        let rays = random_rays(&surface.bounds(), RAYS);
        let columns: Vec<_> = rays.chunks(BATCH).map(RayColumns::from_iter).collect();
        let mut best = vec![[f64::INFINITY; 2]; most];
        for _ in 0..ROUNDS {
            for (threads, best) in (1..).zip(&mut best) {
                best[0] = best[0].min(seconds(&rays, threads, |part| {
                    part.iter().filter(|ray| surface.closest(ray).is_some()).count()
                }));
                best[1] = best[1].min(seconds(&columns, threads, |part| {
                    let mut hits = Hits::default();
                    let mut count = 0;
                    for columns in part {
                        surface.closest_of_many(&columns.rays(), &mut hits);
                        count += hits.t.iter().filter(|t| t.is_finite()).count();
                    }
                    count
                }));
            }
        }
        for (threads, own) in (1..).zip(&best) {
            let speed = own.map(|seconds| RAYS as f64 * 1e-6 / seconds);
            let ratio = [0, 1].map(|i| best[0][i] / own[i]);
            println!(
                "| {file} | {threads} | {:.2} | {:.2} | {:.2} | {:.2} |",
                speed[0], ratio[0], speed[1], ratio[1]
            );
        }
    }
    Ok(())
}

/// How long so many threads take for all of it, each its part.
fn seconds<T: Sync>(all: &[T], threads: usize, answer: impl Fn(&[T]) -> usize + Sync) -> f64 {
    let start = Instant::now();
    thread::scope(|scope| {
        for part in all.chunks(all.len().div_ceil(threads)) {
            scope.spawn(|| black_box(answer(part)));
        }
    });
    start.elapsed().as_secs_f64()
}

//! How many instructions every query takes, which is the same at every run, whatever else the
//! machine does: `cargo bench -p bench-queries --bench instructions`
//!
//! Needs valgrind and `cargo install gungraun-runner --version 0.20.0`. Each run is compared with
//! the last one; `-- --save-baseline=NAME` and `-- --baseline=NAME` compare with one of one's choice.

#![allow(
    missing_docs,
    unused_qualifications,
    clippy::expect_used,
    reason = "the benchmark's own functions, and what its macros make of them"
)]

mod common;

use std::hint::black_box;

use common::{camera_rays, profile, random_rays};
use gungraun::prelude::*;
use rondure::{Hit, Profile, Ray, Surface};

const RAYS: u32 = 1024;

fn camera(shape: &str) -> (Surface, Vec<Ray>) {
    (Surface::new(&profile(shape)), camera_rays(RAYS))
}

fn random(shape: &str) -> (Surface, Vec<Ray>) {
    let surface = Surface::new(&profile(shape));
    let rays = random_rays(&surface, RAYS);
    (surface, rays)
}

fn random_hits(shape: &str) -> (Surface, Vec<(Ray, Hit)>) {
    let (surface, rays) = random(shape);
    let hits = rays.iter().filter_map(|ray| Some((*ray, surface.closest(ray)?))).collect();
    (surface, hits)
}

#[library_benchmark]
#[benches::shapes(args = ["vase", "goblet", "pawn", "column"], setup = profile)]
fn build(profile: Profile) -> Surface {
    Surface::new(black_box(&profile))
}

#[library_benchmark]
#[benches::camera(args = ["vase", "goblet", "pawn", "column"], setup = camera)]
#[benches::random(args = ["vase", "goblet", "pawn", "column"], setup = random)]
fn closest((surface, rays): (Surface, Vec<Ray>)) -> (Surface, Vec<Ray>) {
    for ray in &rays {
        black_box(surface.closest(black_box(ray)));
    }
    (surface, rays)
}

#[library_benchmark]
#[benches::camera(args = ["vase", "goblet", "pawn", "column"], setup = camera)]
#[benches::random(args = ["vase", "goblet", "pawn", "column"], setup = random)]
fn any((surface, rays): (Surface, Vec<Ray>)) -> (Surface, Vec<Ray>) {
    for ray in &rays {
        black_box(surface.any(black_box(ray)));
    }
    (surface, rays)
}

#[library_benchmark]
#[benches::camera(args = ["vase", "goblet", "pawn", "column"], setup = camera)]
#[benches::random(args = ["vase", "goblet", "pawn", "column"], setup = random)]
fn all((surface, rays): (Surface, Vec<Ray>)) -> (Surface, Vec<Ray>) {
    let mut hits = Vec::with_capacity(256);
    for ray in &rays {
        surface.all(black_box(ray), &mut hits);
        black_box(&hits);
    }
    (surface, rays)
}

#[library_benchmark]
#[benches::random(args = ["vase", "goblet", "pawn", "column"], setup = random_hits)]
fn interaction((surface, hits): (Surface, Vec<(Ray, Hit)>)) -> (Surface, Vec<(Ray, Hit)>) {
    for (ray, hit) in &hits {
        black_box(surface.interaction(black_box(ray), black_box(hit)));
    }
    (surface, hits)
}

library_benchmark_group!(name = queries, benchmarks = [build, closest, any, all, interaction]);

main!(library_benchmark_groups = queries);

//! How long every query takes: `cargo bench -p bench-queries --bench queries`
//!
//! Times are those of all rays together; `item/s` are rays a second.

#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "the benchmark's own functions, on shapes that are known to be good"
)]

mod common;

use common::{camera_rays, profile, random_rays};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use rondure::{Hit, Ray, Surface};

const RAYS: u32 = 4096;
const SHAPES: [&str; 4] = ["vase", "goblet", "pawn", "column"];
const SETS: [&str; 2] = ["camera", "random"];

fn main() {
    divan::main();
}

/// A standard shape with each set of rays.
fn cases() -> impl Iterator<Item = String> {
    SHAPES.into_iter().flat_map(|shape| SETS.into_iter().map(move |set| format!("{shape} {set}")))
}

fn case(name: &str) -> (Surface, Vec<Ray>) {
    let (shape, set) = name.split_once(' ').expect("a shape and a set");
    let surface = Surface::new(&profile(shape));
    let rays = match set {
        "camera" => camera_rays(RAYS),
        _ => random_rays(&surface, RAYS),
    };
    (surface, rays)
}

#[divan::bench(args = SHAPES)]
fn build(bencher: Bencher<'_, '_>, shape: &str) {
    let profile = profile(shape);
    bencher.bench(|| Surface::new(black_box(&profile)));
}

#[divan::bench(args = cases())]
fn closest(bencher: Bencher<'_, '_>, name: &str) {
    let (surface, rays) = case(name);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| {
        for ray in &rays {
            black_box(surface.closest(black_box(ray)));
        }
    });
}

#[divan::bench(args = cases())]
fn any(bencher: Bencher<'_, '_>, name: &str) {
    let (surface, rays) = case(name);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| {
        for ray in &rays {
            black_box(surface.any(black_box(ray)));
        }
    });
}

#[divan::bench(args = cases())]
fn all(bencher: Bencher<'_, '_>, name: &str) {
    let (surface, rays) = case(name);
    let mut hits = Vec::new();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        for ray in &rays {
            surface.all(black_box(ray), &mut hits);
            black_box(&hits);
        }
    });
}

#[divan::bench(args = cases())]
fn interaction(bencher: Bencher<'_, '_>, name: &str) {
    let (surface, rays) = case(name);
    let hits: Vec<(Ray, Hit)> =
        rays.iter().filter_map(|ray| Some((*ray, surface.closest(ray)?))).collect();
    bencher.counter(ItemsCount::new(hits.len())).bench(|| {
        for (ray, hit) in &hits {
            black_box(surface.interaction(black_box(ray), black_box(hit)));
        }
    });
}

//! What every surface keeps: values are the same both ways, directions come as their density says, and weights
//! are values over densities.

use core::f64::consts::{PI, TAU};

use super::*;
use crate::warp;

/// Opaque surfaces of all kinds of layers.
fn surfaces() -> Vec<(&'static str, Layered)> {
    let gloss = |roughness| Gloss { strength: 1.0, ior: 1.5, lobe: Lobe::new(roughness) };
    let base = Layers {
        fuzz: None,
        coat: None,
        coat_color: Rgb::WHITE,
        gloss: gloss(0.5),
        metalness: 0.0,
        metal: Metal::Tinted,
    };
    let fuzz = Some(Fuzz { color: Rgb { r: 0.9, g: 0.5, b: 0.2 }, weight: 0.8, roughness: 0.4 });
    let coat = Some(Gloss { ior: 1.6, ..gloss(0.4) });
    let gold = Metal::Measured {
        eta: Rgb { r: 0.14, g: 0.37, b: 1.44 },
        k: Rgb { r: 3.98, g: 2.39, b: 1.6 },
    };
    vec![
        ("plastic", Layered::new(base)),
        ("metal", Layered::new(Layers { metalness: 1.0, metal: gold, ..base })),
        ("coat on metal", Layered::new(Layers { coat, metalness: 0.7, ..base })),
        ("fuzz", Layered::new(Layers { fuzz, ..base })),
        ("all", Layered::new(Layers { fuzz, coat, metalness: 0.3, ..base })),
    ]
}

const COLOR: Rgb = Rgb { r: 0.8, g: 0.4, b: 0.1 };

fn towards(cos: f64, angle: f64) -> Vec3 {
    let sin = (1.0 - cos * cos).sqrt();
    Vec3::new(sin * angle.cos(), sin * angle.sin(), cos)
}

fn grid(n: u32) -> impl Iterator<Item = (f64, f64)> {
    let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n * n).map(move |i| (at(i % n), at(i / n)))
}

fn sum(parts: &Parts) -> Rgb {
    parts.wide.value + parts.narrow.value
}

#[test]
fn opaque_surfaces_are_the_same_both_ways() {
    for (name, surface) in surfaces() {
        for (o, i, angle) in [(0.9, 0.3, 0.4), (0.1, 0.8, 2.5), (0.5, 0.05, 3.1), (0.7, 0.6, 1.0)] {
            let (wo, wi) = (towards(o, 0.0), towards(i, angle));
            let there = sum(&surface.evaluate(wo, wi, COLOR)) / i;
            let back = sum(&surface.evaluate(wi, wo, COLOR)) / o;
            for (a, b) in [(there.r, back.r), (there.g, back.g), (there.b, back.b)] {
                assert!((a - b).abs() < 1e-12 * a.max(1.0), "{name}: {a} {b}");
            }
        }
    }
}

#[test]
fn rough_boundaries_are_the_same_both_ways() {
    let roughness = Roughness::new(0.6, 1.5).unwrap();
    let outside = Boundary { before: 1.0, behind: 1.5, roughness: &roughness };
    let inside = Boundary { before: 1.5, behind: 1.0, roughness: &roughness };
    for (o, i, angle) in [(0.9_f64, 0.4_f64, 0.4), (0.3, 0.8, 2.5), (0.6, 0.95, 3.0)] {
        let (wo, wi) = (towards(o, 0.0), towards(i, angle));
        let there = outside.evaluate(wo, wi).value.r / i;
        let back = outside.evaluate(wi, wo).value.r / o;
        assert!((there - back).abs() < 1e-12 * there, "{there} {back}");
        // Through it: basic radiance over the square of the index that the light comes from. From the
        // other side, z points the other way.
        let there = outside.evaluate(wo, -wi).value.r / i / (1.5 * 1.5);
        let back = inside.evaluate(wi, -wo).value.r / o;
        assert!((there - back).abs() < 1e-10 * there, "{there} {back}");
    }
}

/// The share of chosen directions in each cell of the sphere is the integral of the density over it, by a test
/// of chi square at a probability of 1e-4.
fn assert_density(
    name: &str,
    sample: impl Fn(f64, (f64, f64)) -> Option<Scatter>,
    pdf: impl Fn(Vec3) -> f64,
) {
    const ROWS: usize = 10;
    const COLUMNS: usize = 8;
    const SAMPLES: u32 = 400;
    let cell = |w: Vec3| {
        let row = ((1.0 - w.z) * 0.5 * ROWS as f64) as usize;
        let column = (w.y.atan2(w.x).rem_euclid(TAU) / TAU * COLUMNS as f64) as usize;
        row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
    };
    let mut counts = [0.0; ROWS * COLUMNS];
    let mut choice = 0.0;
    for u in grid(SAMPLES) {
        choice = (choice + 0.618_033_988_749_894_9_f64).fract();
        if let Some(found) = sample(choice, u) {
            counts[cell(found.direction)] += 1.0;
        }
    }
    let mut expected = [0.0; ROWS * COLUMNS];
    let fine = 600;
    for u in grid(fine) {
        let w = warp::cap(u, 2.0);
        expected[cell(w)] += pdf(w) * 4.0 * PI / f64::from(fine * fine);
    }
    let all = f64::from(SAMPLES * SAMPLES);
    let (mut chi2, mut cells) = (0.0, 0.0);
    for (count, share) in counts.iter().zip(expected) {
        let expected: f64 = share * all;
        if expected > 20.0 {
            // Evenly spread samples vary less than random ones; the integral of the density adds its own error.
            chi2 += (count - expected).powi(2) / (expected + (2e-3 * expected).powi(2));
            cells += 1.0;
        } else {
            assert!(*count < expected + 60.0, "{name}: {count} {expected}");
        }
    }
    // The Wilson-Hilferty bound.
    let k: f64 = cells - 1.0;
    let limit = k * (1.0 - 2.0 / (9.0 * k) + 3.72 * (2.0 / (9.0 * k)).sqrt()).powi(3);
    assert!(chi2 < limit, "{name}: {chi2} of {limit} over {cells} cells");
}

#[test]
fn directions_have_their_density() {
    for (name, surface) in surfaces() {
        for cos in [0.9, 0.3] {
            let wo = towards(cos, 0.5);
            assert_density(
                name,
                |choice, u| surface.sample(wo, COLOR, choice, u),
                |wi| {
                    let parts = surface.evaluate(wo, wi, COLOR);
                    parts.wide.pdf + parts.narrow.pdf
                },
            );
        }
    }
    let roughness = Roughness::new(0.6, 1.5).unwrap();
    for (before, behind) in [(1.0, 1.5), (1.5, 1.0)] {
        let boundary = Boundary { before, behind, roughness: &roughness };
        for cos in [0.9, 0.4] {
            let wo = towards(cos, 0.5);
            assert_density(
                "boundary",
                |choice, u| boundary.sample(wo, choice, u),
                |wi| boundary.evaluate(wo, wi).pdf,
            );
        }
    }
}

#[test]
fn weights_are_values_over_densities() {
    for (name, surface) in surfaces() {
        let wo = towards(0.6, 0.2);
        for (i, u) in (0..).zip(grid(12)) {
            let choice = (f64::from(i) * 0.618_033_988_749_894_9).fract();
            let Some(found) = surface.sample(wo, COLOR, choice, u) else { continue };
            let parts = surface.evaluate(wo, found.direction, COLOR);
            let part = if found.kind == Kind::Wide { parts.wide } else { parts.narrow };
            assert_eq!(found.pdf, part.pdf, "{name}");
            assert!((found.weight.g - part.value.g / part.pdf).abs() < 1e-12, "{name}");
        }
    }
}

/// What a surface of some colour returns in a white room is its table's word, and never more than came.
#[test]
fn no_surface_returns_more_than_it_gets() {
    for (name, surface) in surfaces() {
        for cos in [0.05, 0.2, 0.6, 1.0] {
            let wo = towards(cos, 0.0);
            for (color, least) in [(COLOR, 0.0), (Rgb::WHITE, 0.0)] {
                let n = 128;
                let mut sum = Rgb::BLACK;
                let mut choice = 0.0;
                for u in grid(n) {
                    choice = (choice + 0.618_033_988_749_894_9_f64).fract();
                    if let Some(found) = surface.sample(wo, color, choice, u) {
                        sum += found.weight;
                    }
                }
                let mean = sum / f64::from(n * n);
                for channel in [mean.r, mean.g, mean.b] {
                    assert!(channel > least && channel < 1.005, "{name} {cos}: {mean:?}");
                }
            }
        }
    }
}

//! The volumes of random profiles, against points inside and against spans of rays.

use rondure::{FillRule, Profile, Ray, Solid, Vec3};
use rondure_oracle::{Random, solids::known};

/// A random profile that bounds a solid and does not cross itself, the solid, and its volume.
fn measured(random: &mut Random) -> (Profile, Solid, f64) {
    loop {
        let profile = random.profile();
        if !profile.bounds_solid() {
            continue;
        }
        if let Ok(measured) = profile.measure().solid
            && measured.volume > 1e-3
        {
            let solid = known(Solid::new(&profile, FillRule::NonZero));
            return (profile, solid, measured.volume);
        }
    }
}

/// The share of random points of the bounding box that are inside, times the volume of the box: within five
/// standard deviations.
#[test]
fn points_inside() {
    const POINTS: u32 = 40_000;
    let mut random = Random::new(31);
    for _ in 0..40 {
        let (profile, solid, volume) = measured(&mut random);
        let (bounds, extent) = (solid.bounds(), solid.bounds().extent());
        let mut inside = 0;
        for _ in 0..POINTS {
            let p = Vec3::new(random.unit(), random.unit(), random.unit());
            let p = Vec3::new(p.x * extent.x, p.y * extent.y, p.z * extent.z) + bounds.min;
            inside += u32::from(solid.contains(p));
        }
        let whole = extent.x * extent.y * extent.z;
        let share = volume / whole;
        let deviation = (share * (1.0 - share) / f64::from(POINTS)).sqrt();
        let found = f64::from(inside) / f64::from(POINTS);
        assert!((found - share).abs() <= 5.0 * deviation, "{found}, not {share}: {profile:?}");
    }
}

/// The lengths of the spans of parallel rays, one in each cell of a grid across them, times the cell's
/// area. The error is that of cells at the edge of the solid's shadow: their share of the grid, by what is random
/// in each.
#[test]
fn spans_of_a_grid_of_rays() {
    const CELLS: u32 = 100;
    let mut random = Random::new(32);
    let mut worst = 0.0_f64;
    for _ in 0..40 {
        let (profile, solid, volume) = measured(&mut random);
        let direction = random.direction();
        let (right, up) = direction.orthonormal_basis();
        let (center, reach) = (solid.bounds().center(), 0.5 * solid.bounds().extent().length());
        let cell = 2.0 * reach / f64::from(CELLS);
        let mut spans = Vec::new();
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..CELLS * CELLS {
            let mut place = |k: u32| (f64::from(k) + random.unit()) * cell - reach;
            let (x, y) = (place(i % CELLS), place(i / CELLS));
            solid.spans(&Ray::line(center + right * x + up * y, direction), &mut spans);
            let length: f64 = spans.iter().map(|s| s.length()).sum();
            sum += length;
            squares += length * length;
        }
        let found = sum * cell * cell;
        // Even if cells were no better than rays anywhere.
        let deviation = squares.sqrt() * cell * cell;
        worst = worst.max((found - volume).abs() / volume);
        assert!((found - volume).abs() <= 2.0 * deviation, "{found}, not {volume}: {profile:?}");
    }
    println!("worst relative difference {worst:e}");
    assert!(worst < 0.02, "{worst}");
}

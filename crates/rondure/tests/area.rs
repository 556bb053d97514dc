//! Points chosen by area: closed forms, counts against areas, densities that integrate to one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use rondure::{
    Affine, AreaSampler, EngineOptions, Instance, Instances, Method, Profile, Ray, Surface, Vec3,
};

const SPHERE: &str = "M 0 -1 A 1 1 0 0 1 0 1";
const CONE: &str = "M 3 0 L 0 4";
const CYLINDER: &str = "M 2 0 L 2 5";
const TORUS: &str = "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z";
const VASE: &str = include_str!("../../../profiles/vase.path");
const GOBLET: &str = include_str!("../../../profiles/goblet.path");
const PAWN: &str = include_str!("../../../profiles/pawn.path");
const COLUMN: &str = include_str!("../../../profiles/column.path");
/// A cusp at each end, a handle of length zero, an arc of an ellipse, a subpath that is closed.
const ODD: &str = "M 1 0 C 1 0 1.3 0 2 1 C 1.3 0.2 1.3 0.2 0.4 2 M 4 1 A 1 0.4 30 1 1 4.2 1.5 Z";

fn surface(path: &str) -> Surface {
    Surface::new(&Profile::from_path_data(path).unwrap())
}

/// The middles of n by n squares.
fn grid(n: u32) -> impl Iterator<Item = [f64; 2]> {
    let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n * n).map(move |i| [at(i % n), at(i / n)])
}

/// Numbers in [0, 1), the same at every run.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn pair(&mut self) -> [f64; 2] {
        [self.number(), self.number()]
    }
}

/// How many standard deviations a chi-square statistic lies above its mean (Wilson and Hilferty 1931).
fn deviation(counts: &[u32], shares: &[f64]) -> f64 {
    let n = f64::from(counts.iter().sum::<u32>());
    let sum: f64 = counts
        .iter()
        .zip(shares)
        .map(|(count, share)| (f64::from(*count) - n * share).powi(2) / (n * share))
        .sum();
    let k = (counts.len() - 1) as f64;
    ((sum / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}

#[test]
fn areas_are_the_closed_forms() {
    for (path, area) in [
        (SPHERE, 4.0 * PI),
        (CONE, 15.0 * PI),
        (CYLINDER, 20.0 * PI),
        (TORUS, 8.0 * PI * PI),
        ("M 1 2 L 3 2", 8.0 * PI),
        ("M 0 0 L 0 5 L 1 5", PI),
    ] {
        let found = AreaSampler::new(&surface(path)).unwrap().area();
        assert!((found - area).abs() < 1e-14 * area, "{path}: {found} {area}");
    }
    for path in [VASE, GOBLET, PAWN, COLUMN, ODD] {
        let surface = surface(path);
        let sampler = AreaSampler::new(&surface).unwrap();
        let measure = surface.profile().measure();
        let bound = measure.area_error + 1e-13 * measure.area;
        assert!((sampler.area() - measure.area).abs() < bound, "{path}: {}", sampler.area());
        assert!(sampler.bytes() < 64 << 10, "{path}: {}", sampler.bytes());
    }
}

#[test]
fn the_share_of_the_area_chooses_the_place() {
    let shares = || (0..=1000).map(|i| f64::from(i) / 1000.0);
    let [sphere, cone, torus] = [SPHERE, CONE, TORUS].map(surface);
    let samplers = [&sphere, &cone, &torus].map(|s| AreaSampler::new(s).unwrap());
    for share in shares() {
        // Archimedes: zones of the same height have the same area.
        let z = sphere.sample(&samplers[0], [0.3, share]).surface.point.z;
        assert!((z - (2.0 * share - 1.0)).abs() < 1e-14, "{share}: {z}");
        let z = cone.sample(&samplers[1], [0.3, share]).surface.point.z;
        assert!((z - 4.0 * (1.0 - (1.0 - share).sqrt())).abs() < 1e-14, "{share}: {z}");
        // At the angle a from the outside, drawn over the top: (2 a + sin a) / (4 pi).
        let p = torus.sample(&samplers[2], [0.0, share]).surface.point;
        let angle = p.z.atan2(p.x - 2.0).rem_euclid(TAU);
        let found = (2.0 * angle + angle.sin()) / (2.0 * TAU);
        let apart = (found - share).rem_euclid(1.0);
        assert!(apart.min(1.0 - apart) < 1e-14, "{share}: {found}");
    }
}

#[test]
fn the_angle_is_the_first_number() {
    let sphere = surface(SPHERE);
    let sampler = AreaSampler::new(&sphere).unwrap();
    for turn in [0.0, 0.125, 0.5, 0.875] {
        let sample = sphere.sample(&sampler, [turn, 0.4]);
        let (sin, cos) = (turn * TAU).sin_cos();
        let rho = (1.0 - 0.04_f64).sqrt();
        let expected = Vec3::new(rho * cos, rho * sin, -0.2);
        assert!((sample.surface.point - expected).max_abs() < 1e-15);
        assert!((sample.surface.normal - expected).max_abs() < 1e-14);
        assert!((sample.surface.uv[0] - turn).abs() < 1e-15);
    }
}

/// The samples are hits of rays that go straight for them, with the same full answer.
#[test]
fn samples_are_places_that_rays_hit() {
    let mut random = Random(5);
    let placement = Affine::translate(Vec3::new(3.0, -2.0, 50.0))
        .after(&Affine::rotate(Vec3::new(1.0, 2.0, -0.5), 0.8))
        .after(&Affine::scale(Vec3::new(2.0, -0.5, 1.2)));
    for path in [SPHERE, CONE, CYLINDER, TORUS, VASE, GOBLET, PAWN, COLUMN, ODD] {
        let surface = Arc::new(surface(path));
        let sampler = AreaSampler::new(&surface).unwrap();
        let placed = Instance::new(Arc::clone(&surface), placement).unwrap();
        let size = surface.bounds().extent().length();
        for _ in 0..300 {
            let u = random.pair();
            for at_home in [true, false] {
                let sample = match at_home {
                    true => surface.sample(&sampler, u),
                    false => placed.sample(&sampler, u),
                };
                let found = sample.surface;
                // A little way off, so that nothing else stands between.
                let away = found.normal * (1e-4 * size);
                let ray = Ray::new(found.point + away, -away);
                let hit = match at_home {
                    true => surface.closest(&ray),
                    false => placed.closest(&ray),
                };
                let hit = hit.unwrap();
                if hit.piece != sample.piece {
                    // At a joint, or where the surface runs through itself.
                    assert!((0.5..1.0 + 1e-9).contains(&hit.t) || path == ODD, "{path} {u:?}");
                    continue;
                }
                let full = match at_home {
                    true => surface.interaction(&ray, &hit),
                    false => placed.interaction(&ray, &hit),
                };
                let near = 1e-9 * size;
                assert!((hit.s - sample.s).abs() < 1e-6, "{path} {u:?} {hit:?} {sample:?}");
                assert!((full.point - found.point).max_abs() < near, "{path} {u:?}");
                assert!((full.normal - found.normal).max_abs() < 1e-5, "{path} {u:?}");
                assert!((full.dp_du - found.dp_du).max_abs() < 1e-4 * size, "{path} {u:?}");
                assert!((full.dp_dv - found.dp_dv).max_abs() < 1e-4 * size, "{path} {u:?}");
                assert!((full.uv[1] - found.uv[1]).abs() < 1e-6, "{path} {u:?}");
                assert_eq!(full.error, found.error);
            }
        }
    }
}

/// The shares of the area in `zones` stretches of v, the same length each, summed up along chords.
fn shares_by_length(profile: &Profile, zones: usize) -> Vec<f64> {
    let steps = 4_000;
    let mut chords = Vec::new();
    for segment in profile.segments() {
        let mut last = segment.start();
        for i in 1..=steps {
            let p = segment.point(f64::from(i) / f64::from(steps));
            chords.push(((p - last).length(), 0.5 * (p.r + last.r) * (p - last).length()));
            last = p;
        }
    }
    let (length, area) = chords.iter().fold((0.0, 0.0), |(l, a), c| (l + c.0, a + c.1));
    let mut shares = vec![0.0; zones];
    let mut before = 0.0;
    for (own, swept) in chords {
        let zone = (before + 0.5 * own) / length * zones as f64;
        shares[(zone as usize).min(zones - 1)] += swept / area;
        before += own;
    }
    shares
}

#[test]
fn counts_agree_with_areas() {
    let mut random = Random(3);
    let (zones, sectors) = (50, 3);
    for path in [CONE, TORUS, VASE, GOBLET, PAWN, ODD] {
        let surface = surface(path);
        let sampler = AreaSampler::new(&surface).unwrap();
        // What hardly has an area goes with its neighbour.
        let mut shares = shares_by_length(surface.profile(), zones);
        let mut cell_of = vec![0; zones];
        let mut cells: Vec<f64> = Vec::new();
        for (zone, share) in shares.iter_mut().enumerate() {
            if zone == 0 || cells[cells.len() - 1] > 1e-3 {
                cells.push(0.0);
            }
            cell_of[zone] = cells.len() - 1;
            cells[cell_of[zone]] += *share;
        }
        let expected: Vec<_> =
            cells.iter().flat_map(|share| vec![share / sectors as f64; sectors]).collect();
        let mut counts = vec![0_u32; expected.len()];
        for _ in 0..100_000 {
            let [turn, v] = surface.sample(&sampler, random.pair()).surface.uv;
            let zone = ((v * zones as f64) as usize).min(zones - 1);
            counts[cell_of[zone] * sectors + (turn * sectors as f64) as usize] += 1;
        }
        let found = deviation(&counts, &expected);
        assert!(found.abs() < 4.0, "{path}: {found} standard deviations");
    }
}

/// The area of the ellipsoid with these half axes, over a fine grid in (u, z).
fn ellipsoid_area([a, b, c]: [f64; 3]) -> f64 {
    // On the unit sphere, where (u, z) has the density 1 / (4 pi): abc |(x/a, y/b, z/c)|.
    let n = 300;
    let sum: f64 = grid(n)
        .map(|[u, w]| {
            // Even in z and by a quarter turn in u; smooth at the pole in z = 1 - w^2.
            let (z, weight) = (1.0 - w * w, 2.0 * w);
            let (sin, cos) = (u * 0.25 * TAU).sin_cos();
            let rho = (1.0 - z * z).max(0.0).sqrt();
            weight * (rho * cos / a).hypot(rho * sin / b).hypot(z / c)
        })
        .sum();
    4.0 * PI * a * b * c * sum / f64::from(n * n)
}

/// 1 / density is what a sample stands for: its mean is the area in the world.
#[test]
fn densities_integrate_to_one_wherever_the_surface_is_placed() {
    let sphere = Arc::new(surface(SPHERE));
    let sampler = AreaSampler::new(&sphere).unwrap();
    let turn = Affine::rotate(Vec3::new(0.3, -1.0, 2.0), 1.1);
    for axes in [[1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [1.0, 2.0, 0.5], [1e-3, 1e-3, 2e-3], [2e9; 3]] {
        let [a, b, c] = axes;
        for mirrored in [1.0, -1.0] {
            let scale = Affine::scale(Vec3::new(a, b * mirrored, c));
            let map = Affine::translate(Vec3::new(7.0, 8.0, 9.0)).after(&turn.after(&scale));
            let placed = Instance::new(Arc::clone(&sphere), map).unwrap();
            let mut instances = Instances::new();
            let shape = instances.add_shape(Arc::clone(&sphere));
            let number = instances.place(shape, map).unwrap();
            let n = 200;
            let sum: f64 = grid(n)
                .map(|u| {
                    let sample = placed.sample(&sampler, u);
                    assert_eq!(sample, instances.sample(number, &sampler, u));
                    let normal = sample.surface.normal;
                    assert_eq!(sample.area_pdf, placed.area_pdf(&sampler, -normal));
                    assert_eq!(sample.area_pdf, instances.area_pdf(number, &sampler, normal));
                    1.0 / sample.area_pdf
                })
                .sum();
            let (found, exact) = (sum / f64::from(n * n), ellipsoid_area(axes));
            assert!((found - exact).abs() < 2e-5 * exact, "{axes:?}: {found} {exact}");
        }
    }
}

/// The density is also the area that (u, v) are stretched by, from the partial derivatives.
#[test]
fn densities_agree_with_partial_derivatives() {
    let mut random = Random(11);
    let map = Affine {
        columns: [Vec3::new(1.0, 0.3, 0.0), Vec3::new(-0.2, 2.0, 0.4), Vec3::new(0.7, 0.1, -0.8)],
        translation: Vec3::new(1.0, 2.0, 3.0),
    };
    for path in [TORUS, VASE, GOBLET, ODD] {
        let surface = Arc::new(surface(path));
        let sampler = AreaSampler::new(&surface).unwrap();
        let placed = Instance::new(Arc::clone(&surface), map).unwrap();
        for _ in 0..1000 {
            let u = random.pair();
            let [own, there] =
                [surface.sample(&sampler, u), placed.sample(&sampler, u)].map(|s| s.surface);
            let stretch =
                there.dp_du.cross(there.dp_dv).length() / own.dp_du.cross(own.dp_dv).length();
            let expected = 1.0 / (sampler.area() * stretch);
            let found = placed.area_pdf(&sampler, there.normal);
            assert!((found - expected).abs() < 1e-9 * expected, "{path} {u:?}: {found} {expected}");
        }
    }
}

/// A sphere of radius 1 seen from the distance 3 fills 2 pi (1 - sqrt(8) / 3) of the view.
#[test]
fn densities_by_solid_angle() {
    let sphere = surface(SPHERE);
    let sampler = AreaSampler::new(&sphere).unwrap();
    let from = Vec3::new(0.0, 1.8, 2.4);
    let n = 500;
    let sum: f64 = grid(n)
        .map(|u| sphere.sample(&sampler, u))
        .filter(|sample| sample.surface.normal.dot(from - sample.surface.point) > 0.0)
        .map(|sample| 1.0 / sample.surface.solid_angle_pdf(sample.area_pdf, from))
        .sum();
    let (found, exact) = (sum / f64::from(n * n), TAU * (1.0 - 8.0_f64.sqrt() / 3.0));
    assert!((found - exact).abs() < 1e-4 * exact, "{found} {exact}");
    let here = sphere.sample(&sampler, [0.1, 0.2]).surface;
    assert_eq!(here.solid_angle_pdf(1.0, here.point), 0.0);
}

#[test]
fn what_sweeps_no_area_has_no_samples() {
    assert!(AreaSampler::new(&surface("M 1e-315 0 L 1e-315 1")).is_none());
    assert!(AreaSampler::new(&surface("M 0 0 L 1e-99 1e-99 L 0 2e-99")).is_some());
}

/// Slivers, corners of the unit square, far away: finite points, unit normals, right densities.
#[test]
fn extreme_surfaces_have_good_samples() {
    for path in [
        "M 0 0 L 1e-12 1 L 1 1 L 1 1.000000000001",
        "M 1e8 5 A 1e-3 1e-3 0 0 1 99999999.998 5 A 1e-3 1e-3 0 0 1 1e8 5 Z",
        "M 0 1e12 A 1 1 0 0 1 0 1000000000002",
        "M 1e60 0 L 0 1e60",
        "M 1e-60 0 Q 0 1e-60 1e-60 2e-60",
        "M 0 0 C 0 0 1 1 1 1",
        ODD,
    ] {
        let surface = surface(path);
        let sampler = AreaSampler::new(&surface).unwrap();
        assert!(sampler.area() > 0.0);
        let ends = [0.0, 1e-300, 1e-17, 0.3, 0.5, 1.0 - 1e-16, 1.0];
        for u in ends.iter().flat_map(|a| ends.map(|b| [*a, b])) {
            let sample = surface.sample(&sampler, u);
            let found = sample.surface;
            assert!(found.point.is_finite() && (0.0..=1.0).contains(&sample.s), "{path} {u:?}");
            assert!((found.normal.length() - 1.0).abs() < 1e-12, "{path} {u:?} {found:?}");
            assert!(found.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{path} {u:?} {found:?}");
        }
    }
}

/// The paper's engines are sampled where they are hit: on their frusta.
#[test]
fn frusta_are_sampled_as_they_are() {
    let profile = Profile::from_path_data(SPHERE).unwrap();
    let options = EngineOptions { method: Method::Hy, samples: 20, ..EngineOptions::default() };
    let surface = Surface::with_engine(&profile, &options);
    let sampler = AreaSampler::new(&surface).unwrap();
    let chords: f64 = surface.piece_ends().map(|[a, b]| PI * (a.r + b.r) * (b - a).length()).sum();
    assert!((sampler.area() - chords).abs() < 1e-13 * chords);
    let sample = surface.sample(&sampler, [0.2, 0.37]);
    let away = sample.surface.normal * 1e-3;
    let hit = surface.closest(&Ray::new(sample.surface.point + away, -away)).unwrap();
    assert_eq!(hit.piece, sample.piece);
}

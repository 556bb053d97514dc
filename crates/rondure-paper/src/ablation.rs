//! What single choices are worth: bare rays on the scenes' profiles, without light or picture.
//!
//! Every profile is shot at by the same random lines, uniformly distributed among those that meet
//! the sphere round it. All configurations are timed in turn, over and over; the shortest time counts.

use cpu_time::ThreadTime;
use rondure::engine::{Criterion, Statistics};
use rondure::{EngineOptions, Method, Profile, Ray, Surface, Vec3};
use rondure_render::{Progress, RenderError};
use rondure_scene::Scene;

use crate::measure::Options;

/// One configuration.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The engine.
    pub engine: EngineOptions,
    /// The time for one ray on the processor, in nanoseconds.
    pub nanoseconds: f64,
    /// The work for all rays.
    pub work: Statistics,
    /// How many rays were shot.
    pub rays: u64,
}

impl Choice {
    /// A number of steps for one ray.
    pub fn per_ray(&self, steps: u64) -> f64 {
        steps as f64 / self.rays as f64
    }
}

/// All of them.
#[derive(Clone, Debug)]
pub struct Ablation {
    /// Each method with 2^0 to 2^8 leaves in each interval, then with one frustum in each leaf.
    pub leaves: Vec<Choice>,
    /// HY by area, with several weights of cone shells, and last by intersection interval.
    pub criteria: Vec<Choice>,
    /// The exact engine.
    pub exact: Choice,
}

/// What a search costs, fitted to the measured times of one method by least squares.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// The method.
    pub method: Method,
    /// Nanoseconds for a shell test.
    pub test: f64,
    /// Nanoseconds for a ray tested against a frustum.
    pub solve: f64,
}

/// Rays on each profile. Few enough to stay in the cache of a core.
const RAYS: usize = 4096;
/// How often they are shot.
const ROUNDS: usize = 9;

/// Measures all choices on the profiles of a scene.
pub(crate) fn measure(
    scene: &Scene,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Ablation, RenderError> {
    let profiles: Vec<&Profile> = scene.surfaces().iter().map(|s| s.profile()).collect();
    let rays: Vec<Vec<Ray>> = profiles.iter().map(|p| lines(&Surface::new(p))).collect();
    let basis = EngineOptions { samples: options.samples, ..EngineOptions::default() };
    let mut engines = vec![basis];
    for method in [Method::Kj, Method::Cy, Method::Co, Method::Hy, Method::Bs] {
        let leaves = (0..=8).chain([crate::measure::TO_SINGLE_FRUSTA]);
        engines.extend(leaves.map(|subdivide| EngineOptions { method, subdivide, ..basis }));
    }
    let leaves = engines.len();
    let criteria = [0.5, 1.0, 1.5, 2.0, 4.0, f64::INFINITY]
        .map(|cone_weight| Criterion::Area { cone_weight })
        .into_iter()
        .chain([Criterion::Interval]);
    engines.extend(criteria.map(|criterion| EngineOptions {
        method: Method::Hy,
        subdivide: options.subdivide,
        criterion,
        ..basis
    }));

    let surfaces = |engine: &EngineOptions| -> Vec<Surface> {
        profiles.iter().map(|profile| Surface::with_engine(profile, engine)).collect()
    };
    let ready: Vec<Vec<Surface>> = engines.iter().map(surfaces).collect();
    let mut best = vec![f64::INFINITY; engines.len()];
    for round in 0..ROUNDS {
        for (best, surfaces) in best.iter_mut().zip(&ready) {
            let start = ThreadTime::now();
            std::hint::black_box(shoot(surfaces, &rays));
            *best = best.min(start.elapsed().as_secs_f64());
        }
        if progress.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        progress.advance((round + 1) as f64 / (ROUNDS + 1) as f64);
    }
    let count = (profiles.len() * RAYS) as u64;
    let mut choices: Vec<Choice> = engines
        .iter()
        .zip(best)
        .map(|(engine, seconds)| {
            let counted = surfaces(&EngineOptions { counted: true, ..*engine });
            shoot(&counted, &rays);
            let works = counted.iter().filter_map(Surface::statistics);
            let work = works.fold(Statistics::default(), |sum, work| sum.plus(&work));
            let nanoseconds = seconds / count as f64 * 1e9;
            Choice { engine: *engine, nanoseconds, work, rays: count }
        })
        .collect();
    progress.advance(1.0);
    let criteria = choices.split_off(leaves);
    let exact = choices.remove(0);
    Ok(Ablation { leaves: choices, criteria, exact })
}

/// How many rays hit.
fn shoot(surfaces: &[Surface], rays: &[Vec<Ray>]) -> usize {
    let pairs = surfaces.iter().zip(rays);
    pairs.map(|(s, rays)| rays.iter().filter(|ray| s.closest(ray).is_some()).count()).sum()
}

/// Lines that meet the sphere round a surface, uniformly distributed, from outside of it.
fn lines(surface: &Surface) -> Vec<Ray> {
    let (center, radius) = (surface.bounds().center(), 0.5 * surface.bounds().extent().length());
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    // Two points on a sphere, each uniform, span a uniformly distributed chord.
    let mut point = move || {
        let z = 2.0 * random() - 1.0;
        let (sin, cos) = (core::f64::consts::TAU * random()).sin_cos();
        let across = (1.0 - z * z).sqrt();
        center + Vec3::new(across * cos, across * sin, z) * radius
    };
    (0..RAYS)
        .map(|_| {
            let (from, to) = (point(), point());
            Ray::new(from, to - from)
        })
        .collect()
}

impl Ablation {
    /// The cost of a shell test and of a leaf, by method: the times of all numbers of leaves, fitted
    /// by an overhead that is the same for all methods, and one cost each.
    pub fn costs(&self) -> Vec<Cost> {
        let methods = [Method::Kj, Method::Cy, Method::Co, Method::Hy, Method::Bs];
        // The unknowns: the overhead, the leaf, and a test of each method.
        const UNKNOWNS: usize = 7;
        let mut matrix = [[0.0; UNKNOWNS + 1]; UNKNOWNS];
        for choice in &self.leaves {
            let mut row = [0.0; UNKNOWNS + 1];
            row[0] = 1.0;
            row[1] = choice.per_ray(choice.work.leaf_solves);
            if let Some(i) = methods.iter().position(|m| *m == choice.engine.method) {
                row[2 + i] = choice.per_ray(choice.work.shell_tests);
            }
            row[UNKNOWNS] = choice.nanoseconds;
            // Relative errors count.
            let row = row.map(|v| v / choice.nanoseconds);
            for i in 0..UNKNOWNS {
                for j in 0..=UNKNOWNS {
                    matrix[i][j] += row[i] * row[j];
                }
            }
        }
        let solution = solve(matrix);
        let cost = |(i, method)| Cost { method, test: solution[2 + i], solve: solution[1] };
        methods.into_iter().enumerate().map(cost).collect()
    }
}

/// Gauss-Jordan elimination; the matrix is symmetric and positive definite.
fn solve<const N: usize, const M: usize>(mut rows: [[f64; M]; N]) -> [f64; N] {
    for i in 0..N {
        let pivot = rows[i];
        for (j, row) in rows.iter_mut().enumerate() {
            if j != i {
                let factor = row[i] / pivot[i];
                row.iter_mut().zip(pivot).for_each(|(value, p)| *value -= factor * p);
            }
        }
    }
    core::array::from_fn(|i| rows[i][N] / rows[i][i])
}

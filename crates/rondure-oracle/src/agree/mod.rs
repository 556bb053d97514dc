//! Whether engines agree: the same hits, ray by ray, on random and on adversarial rays.
//!
//! ```text
//! Shape -> Scene -> blocks of rays -> reference and contenders -> Judge -> Count
//! ```

mod count;
mod judge;
mod rays;
mod shapes;

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};
use std::thread;

use rondure::{
    AllHits, EngineOptions, Hit, Hits, Method, Ray, RayColumns, Surface, Vec3, engine::Instructions,
};

pub use count::{Count, Failure};
pub use judge::{Answers, Judge, SAME};
pub use rays::{ADVERSARIAL_KINDS, RANDOM_KINDS, Scene};
pub use shapes::{Shape, shapes};

use crate::{Oracle, Random};

/// The rays that an engine is asked about at once.
const BLOCK: u64 = 256;
/// Blocks that share a seed and are dealt to one thread.
const BLOCKS: u64 = 32;

/// What is held to the exact engine: answers for blocks of rays.
pub trait Contender: Send + Sync {
    /// The closest hit of each ray.
    fn closest(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>);
    /// Whether each ray hits.
    fn any(&self, rays: &[Ray], found: &mut Vec<bool>);
    /// All hits of each ray.
    fn all(&self, rays: &[Ray], hits: &mut Vec<Vec<Hit>>);
}

impl Contender for Surface {
    fn closest(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.extend(rays.iter().map(|ray| Surface::closest(self, ray)));
    }
    fn any(&self, rays: &[Ray], found: &mut Vec<bool>) {
        found.clear();
        found.extend(rays.iter().map(|ray| Surface::any(self, ray)));
    }
    fn all(&self, rays: &[Ray], hits: &mut Vec<Vec<Hit>>) {
        hits.resize_with(rays.len(), Vec::new);
        for (ray, own) in rays.iter().zip(hits) {
            Surface::all(self, ray, own);
        }
    }
}

/// A surface that is asked about many rays at once.
struct Batches(Surface);

impl Contender for Batches {
    fn closest(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        let mut found = Hits::default();
        self.0.closest_of_many(&RayColumns::from_iter(rays).rays(), &mut found);
        hits.extend((0..rays.len()).map(|i| found.get(i)));
    }
    fn any(&self, rays: &[Ray], found: &mut Vec<bool>) {
        found.clear();
        found.resize(rays.len(), false);
        self.0.any_of_many(&RayColumns::from_iter(rays).rays(), found);
    }
    fn all(&self, rays: &[Ray], hits: &mut Vec<Vec<Hit>>) {
        let mut found = AllHits::default();
        self.0.all_of_many(&RayColumns::from_iter(rays).rays(), &mut found);
        hits.resize_with(rays.len(), Vec::new);
        for (i, own) in hits.iter_mut().enumerate() {
            own.clear();
            own.extend(found.of(i));
        }
    }
}

/// A contender with its name in tables.
pub struct Entrant {
    /// Without spaces.
    pub name: &'static str,
    /// Who answers.
    pub contender: Box<dyn Contender>,
}

/// The wide engine with each of some instruction sets, as far as the machine has them: asked ray by ray, and in
/// batches.
pub fn wide(shape: &Shape, instructions: &[Instructions]) -> Vec<Entrant> {
    let available = instructions.iter().filter(|i| i.are_available());
    available
        .flat_map(|&instructions| {
            let options =
                EngineOptions { method: Method::Wide, instructions, ..EngineOptions::default() };
            let surface = Surface::with_engine(&shape.profile, &options);
            let [single, batches] = match instructions {
                Instructions::Auto => ["auto", "auto-many"],
                Instructions::Portable => ["portable", "portable-many"],
                Instructions::Avx2 => ["avx2", "avx2-many"],
                Instructions::Avx512 => ["avx512", "avx512-many"],
            };
            let many = Entrant { name: batches, contender: Box::new(Batches(surface.clone())) };
            [Entrant { name: single, contender: Box::new(surface) }, many]
        })
        .collect()
}

/// How many rays to shoot.
#[derive(Clone, Copy, Debug)]
pub struct Amount {
    /// Random rays.
    pub random: u64,
    /// Adversarial rays.
    pub adversarial: u64,
    /// Where the random numbers begin.
    pub seed: u64,
    /// How many threads share the work.
    pub threads: usize,
}

/// Compares contenders with the exact engine; one count for each, in their order. The rays, and with them
/// the counts, do not depend on the number of threads.
pub fn compare(shape: &Shape, entrants: &[Entrant], amount: &Amount) -> Vec<Count> {
    let options = EngineOptions { method: Method::Exact, ..EngineOptions::default() };
    let exact = Surface::with_engine(&shape.profile, &options);
    let oracle = Oracle::new(&shape.profile);
    let scene = Scene::new(&exact, &shape.profile);
    let judge = Judge::new(&exact, &oracle, scene.center, scene.radius);
    let total = amount.random + amount.adversarial;
    let stretch = BLOCK * BLOCKS;
    let next = AtomicU64::new(0);
    let done = Mutex::new(Vec::new());
    let work = || {
        let mut bench = Bench::default();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let first = number * stretch;
            if first >= total {
                return;
            }
            let mut random = Random::new(Random::new(amount.seed ^ (number << 20)).bits());
            let mut counts = vec![Count::default(); entrants.len()];
            let last = total.min(first + stretch);
            for start in (first..last).step_by(BLOCK as usize) {
                bench.rays.clear();
                bench.rays.extend((start..last.min(start + BLOCK)).map(|i| {
                    if i < amount.random {
                        scene.random(i, &mut random)
                    } else {
                        scene.adversarial(i, &mut random)
                    }
                }));
                if start / BLOCK % 2 == 1 {
                    make_alike(&mut bench.rays, scene.radius, &mut random);
                }
                bench.answer(&exact, entrants, &judge, &mut counts);
            }
            done.lock().unwrap_or_else(PoisonError::into_inner).push((number, counts));
        }
    };
    thread::scope(|scope| {
        for _ in 0..amount.threads.max(1) {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(number, _)| *number);
    let mut sums = vec![Count::default(); entrants.len()];
    for (_, counts) in done {
        for (sum, count) in sums.iter_mut().zip(counts) {
            sum.add(count);
        }
    }
    sums
}

/// Makes rays like the first of their sixteen, which batches answer together: moved and turned by something between
/// 1e-9 and a tenth, the same for all sixteen, and now and then not at all.
fn make_alike(rays: &mut [Ray], radius: f64, random: &mut Random) {
    for alike in rays.chunks_mut(16) {
        let [moved, turned] = [0; 2].map(|_| {
            if random.below(4) == 0 { 0.0 } else { 10f64.powf(random.within(-9.0, -1.0)) }
        });
        let Some((&mut first, others)) = alike.split_first_mut() else { continue };
        let turned = turned * first.direction.max_abs();
        for ray in others {
            let mut off = |by: f64| {
                let mut one = || by * random.within(-1.0, 1.0);
                Vec3::new(one(), one(), one())
            };
            let (origin, direction) = (off(moved * radius), off(turned));
            *ray = Ray {
                origin: first.origin + origin,
                direction: first.direction + direction,
                ..first
            };
        }
    }
}

/// A block of rays and what was answered, kept for their memory.
#[derive(Default)]
struct Bench {
    rays: Vec<Ray>,
    expected: Sheet,
    found: Sheet,
}

/// The answers for a block of rays.
#[derive(Default)]
struct Sheet {
    closest: Vec<Option<Hit>>,
    any: Vec<bool>,
    all: Vec<Vec<Hit>>,
}

impl Sheet {
    fn fill(&mut self, contender: &dyn Contender, rays: &[Ray]) {
        contender.closest(rays, &mut self.closest);
        contender.any(rays, &mut self.any);
        contender.all(rays, &mut self.all);
    }

    fn answers(&self, i: usize) -> Answers<'_> {
        Answers { all: &self.all[i], closest: self.closest[i], any: self.any[i] }
    }
}

impl Bench {
    fn answer(
        &mut self,
        exact: &Surface,
        entrants: &[Entrant],
        judge: &Judge<'_>,
        counts: &mut [Count],
    ) {
        self.expected.fill(exact, &self.rays);
        for (entrant, count) in entrants.iter().zip(counts) {
            self.found.fill(&*entrant.contender, &self.rays);
            for (i, ray) in self.rays.iter().enumerate() {
                judge.compare(ray, self.expected.answers(i), self.found.answers(i), count);
            }
        }
    }
}

//! Renders both scenes with every method, times them, and counts their work.

use cpu_time::ProcessTime;
use rondure::engine::Statistics;
use rondure::{EngineOptions, Method};
use rondure_render::{Picture, Progress, RenderError, Settings, render};
use rondure_scene::Integrator;
use rondure_scene::Scene;

use crate::ablation::{self, Ablation};
use crate::report::Report;
use crate::scenes;

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How many threads render; all that there are if `None`.
    pub threads: Option<usize>,
    /// About how many points each profile is sampled at.
    pub samples: u32,
    /// Into how many leaves a monotone interval is subdivided, as a power of two.
    pub subdivide: u32,
    /// How often each picture is timed.
    pub repetitions: u32,
    /// The edge of the square pictures, in pixels.
    pub size: u32,
    /// Whether to measure single choices on bare rays, too.
    pub ablate: bool,
}

impl Default for Options {
    /// The paper's size, 1000 points, 2^4 leaves, five repetitions.
    fn default() -> Self {
        Self {
            threads: None,
            samples: 1000,
            subdivide: 4,
            repetitions: 5,
            size: 512,
            ablate: false,
        }
    }
}

/// One engine in one scene.
#[derive(Clone, Debug)]
pub struct Run {
    /// The engine.
    pub engine: EngineOptions,
    /// The time of each repetition on the processor, summed over all threads, in seconds.
    pub seconds: Vec<f64>,
    /// The work of one picture.
    pub work: Statistics,
}

impl Run {
    /// The shortest time: what disturbs a measurement only ever adds to it.
    pub fn best(&self) -> f64 {
        self.seconds.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The time in the middle of all.
    pub fn median(&self) -> f64 {
        let mut sorted = self.seconds.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// One scene, with every engine.
#[derive(Debug)]
pub struct Measured {
    /// The scene's name.
    pub name: &'static str,
    /// The picture on frusta, which is the same for all methods.
    pub picture: Picture,
    /// How many of the methods' pictures differ from it in any bit; 0 unless there is a fault.
    pub different_pictures: usize,
    /// The mean absolute difference of a channel to the picture of the exact engine, as a fraction
    /// of its mean.
    pub difference_to_exact: f64,
    /// The methods, in the order of the table.
    pub runs: Vec<Run>,
    /// How many turned objects there are, of how many profiles.
    pub objects: (usize, usize),
}

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PaperError {
    /// A scene could not be read.
    #[error("the scene cannot be read:\n{0}")]
    Scene(String),
    /// A picture could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Halvings enough that one frustum is left in each leaf: Kajiya's own rule.
pub(crate) const TO_SINGLE_FRUSTA: u32 = 31;

/// The engines of the tables, in their order.
pub(crate) fn engines(options: &Options) -> Vec<EngineOptions> {
    let on = |method, subdivide| EngineOptions {
        method,
        subdivide,
        samples: options.samples,
        ..EngineOptions::default()
    };
    let mut all = vec![on(Method::Exact, 0), on(Method::Kj, TO_SINGLE_FRUSTA)];
    for method in [Method::Kj, Method::Cy, Method::Co, Method::Hy, Method::Bs] {
        all.push(on(method, options.subdivide));
        all.push(on(method, 0));
    }
    all
}

/// Measures everything. `progress` is told how far it is, and may stop it.
///
/// # Errors
/// If it is stopped, or a scene cannot be rendered (see [`PaperError`]).
pub fn measure(options: &Options, progress: &dyn Progress) -> Result<Report, PaperError> {
    let engines = engines(options);
    let renders = 2 * engines.len() * (1 + options.repetitions as usize);
    let of_renders = if options.ablate { 0.8 } else { 1.0 };
    let mut step = Step { whole: progress, before: 0.0, share: of_renders / renders as f64 };
    let mut measured = Vec::new();
    for (name, head) in [("matte", scenes::MATTE), ("mirror", scenes::MIRROR)] {
        let mut scene = scenes::read(name, head).map_err(|r| PaperError::Scene(r.plain()))?;
        (scene.film.width, scene.film.height) = (options.size, options.size);
        scene.film.integrator = Integrator::Whitted;
        measured.push(scene_with(&engines, name, &scene, options, &mut step)?);
    }
    let ablation = if options.ablate {
        let scene = scenes::read("matte", scenes::MATTE);
        let mut scene = scene.map_err(|r| PaperError::Scene(r.plain()))?;
        scene.film.integrator = Integrator::Whitted;
        let rest = Step { whole: progress, before: of_renders, share: 1.0 - of_renders };
        Some(ablation::measure(&scene, options, &rest)?)
    } else {
        None
    };
    Ok(Report { options: *options, measured, ablation: ablation as Option<Ablation> })
}

/// One scene: first every engine with its work counted, then all of them in turn, over and over, so
/// that what disturbs the machine for a while disturbs all alike.
fn scene_with(
    engines: &[EngineOptions],
    name: &'static str,
    scene: &Scene,
    options: &Options,
    step: &mut Step<'_>,
) -> Result<Measured, PaperError> {
    let settings = Settings { threads: options.threads, ..Settings::default() };
    let mut runs = Vec::new();
    let mut ready = Vec::new();
    let mut exact: Option<Picture> = None;
    let mut picture: Option<Picture> = None;
    let mut different_pictures = 0;
    for engine in engines {
        let mut counted = scene.clone();
        counted.set_engine(&EngineOptions { counted: true, ..*engine });
        let own = step.run(|progress| render(&counted, &settings, progress))?;
        runs.push(Run { engine: *engine, seconds: Vec::new(), work: counted.engine_statistics() });
        let mut plain = scene.clone();
        plain.set_engine(engine);
        ready.push(plain);
        match (&picture, engine.method) {
            (_, Method::Exact) => exact = Some(own),
            (None, _) => picture = Some(own),
            (Some(first), _) => {
                different_pictures += usize::from(!same_bits(first, &own));
            }
        }
    }
    for _ in 0..options.repetitions {
        for (run, scene) in runs.iter_mut().zip(&ready) {
            let start = ProcessTime::now();
            step.run(|progress| render(scene, &settings, progress))?;
            run.seconds.push(start.elapsed().as_secs_f64());
        }
    }
    let picture = picture.ok_or(RenderError::Cancelled)?;
    let difference_to_exact = exact.map_or(f64::NAN, |exact| difference(&exact, &picture));
    let turned = |o: &&rondure_scene::Object| matches!(o.shape, rondure_scene::Shape::Turned(_));
    let copies = scene.objects.iter().filter(turned).map(|o| o.copies.count());
    let objects = (copies.sum::<u64>() as usize, scene.surfaces().len());
    Ok(Measured { name, picture, different_pictures, difference_to_exact, runs, objects })
}

/// Whether two pictures agree in every bit.
fn same_bits(a: &Picture, b: &Picture) -> bool {
    let bits = |p: &Picture| p.pixels().iter().map(|c| c.map(f32::to_bits)).collect::<Vec<_>>();
    bits(a) == bits(b)
}

/// The mean absolute difference of two pictures' channels, as a fraction of the mean of the first.
pub(crate) fn difference(a: &Picture, b: &Picture) -> f64 {
    let channels = |p: &Picture| p.pixels().iter().flatten().map(|v| f64::from(*v)).collect();
    let (a, b): (Vec<f64>, Vec<f64>) = (channels(a), channels(b));
    let sum: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
    sum / a.iter().sum::<f64>()
}

/// A part of the work, told to someone who waits for the whole.
pub(crate) struct Step<'a> {
    pub(crate) whole: &'a dyn Progress,
    /// How much was done before, from 0 to 1.
    pub(crate) before: f64,
    /// How much of the whole the part is.
    pub(crate) share: f64,
}

impl Progress for Step<'_> {
    fn advance(&self, done: f64) {
        self.whole.advance(self.before + self.share * done);
    }

    fn is_cancelled(&self) -> bool {
        self.whole.is_cancelled()
    }
}

impl Step<'_> {
    /// Does a part, and moves on to the next one.
    fn run<T>(&mut self, part: impl FnOnce(&dyn Progress) -> T) -> T {
        let done = part(self);
        self.before += self.share;
        done
    }
}

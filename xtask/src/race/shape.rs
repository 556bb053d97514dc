//! The race on one shape: every set of rays, Embree's meshes of every error and kind, and Rondure's
//! engines.

use std::error::Error;
use std::{fs, iter};

use cpu_time::ThreadTime;
use rondure::{EngineOptions, Method, Profile, Surface};
use stats_alloc::Region;

use super::contest::{Contestant, Score, heat, median};
use super::embree::Device;
use super::engines::OneByOne;
use super::mesh::{Kind, Mesh};
use super::rays::{self, RaySet};
use super::{Options, Part, tell};

/// What building took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Built {
    /// What it keeps, in bytes.
    pub(crate) bytes: f64,
    pub(crate) seconds: f64,
}

/// One of Rondure's engines; scores by set of [`Engines`].
#[derive(Clone, Debug)]
pub(crate) struct EngineResult {
    pub(crate) method: Method,
    pub(crate) built: Built,
    pub(crate) scores: Vec<Option<Score>>,
}

/// Rondure's engines against each other, the default one first.
#[derive(Clone, Debug)]
pub(crate) struct Engines {
    pub(crate) sets: Vec<SetInfo>,
    pub(crate) results: Vec<EngineResult>,
}

/// One kind of mesh in Embree; scores by set.
#[derive(Clone, Debug)]
pub(crate) struct MeshResult {
    pub(crate) kind: Kind,
    pub(crate) built: Built,
    pub(crate) scores: Vec<Option<Score>>,
}

/// Rondure's default engine and those meshes that raced together with it.
#[derive(Clone, Debug)]
pub(crate) struct HeatResult {
    pub(crate) rondure: Vec<Option<Score>>,
    pub(crate) meshes: Vec<MeshResult>,
}

/// All kinds of meshes of one error.
#[derive(Clone, Debug)]
pub(crate) struct ErrorResult {
    /// Of the height of the shape.
    pub(crate) error: f64,
    pub(crate) cells: usize,
    pub(crate) heats: Vec<HeatResult>,
}

/// How Embree answers a set of rays fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Best {
    pub(crate) kind: Kind,
    /// Rays a second.
    pub(crate) rate: f64,
    /// How many times as fast Rondure was in the same heat.
    pub(crate) ratio: Option<f64>,
}

impl ErrorResult {
    /// The kind of mesh with which Embree answers a set fastest.
    pub(crate) fn best(&self, set: usize) -> Option<Best> {
        let all = self.heats.iter().flat_map(|heat| {
            let own = heat.rondure[set].as_ref().map(Score::median);
            heat.meshes.iter().filter_map(move |mesh| {
                let rate = mesh.scores[set].as_ref()?.median();
                Some(Best { kind: mesh.kind, rate, ratio: own.map(|own| own / rate) })
            })
        });
        all.max_by(|a, b| a.rate.total_cmp(&b.rate))
    }
}

/// A set of rays, for the report.
#[derive(Clone, Debug)]
pub(crate) struct SetInfo {
    pub(crate) name: String,
    pub(crate) rays: usize,
}

impl SetInfo {
    fn of(sets: &[RaySet]) -> Vec<Self> {
        sets.iter().map(|set| Self { name: set.name.clone(), rays: set.len() }).collect()
    }
}

/// All that was measured on one shape.
#[derive(Clone, Debug)]
pub(crate) struct ShapeResult {
    pub(crate) name: String,
    pub(crate) segments: usize,
    pub(crate) sets: Vec<SetInfo>,
    pub(crate) built: Built,
    pub(crate) errors: Vec<ErrorResult>,
    pub(crate) engines: Option<Engines>,
}

impl ShapeResult {
    /// Rondure's default engine on a set, over all heats.
    pub(crate) fn rondure(&self, set: usize) -> Option<Score> {
        let heats = self.errors.iter().flat_map(|error| &error.heats);
        heats.filter_map(|heat| heat.rondure[set].clone()).reduce(Score::merge)
    }
}

/// Above this many cells the kinds of meshes race one after the other, so that they need not be in
/// memory together.
const CELLS_TOGETHER: usize = 1_000_000;

/// Which of the meshes decides, together with Rondure, what "rays that hit" are.
const HITS_ERROR: f64 = 1e-4;

pub(crate) fn race(
    name: &str,
    device: &Device,
    options: &Options,
) -> Result<ShapeResult, Box<dyn Error>> {
    let file = format!("profiles/{name}.path");
    let text = fs::read_to_string(&file).map_err(|e| format!("cannot read {file}: {e}"))?;
    let profile = Profile::from_path_data(&text).map_err(|e| format!("{file}: {e}"))?;
    let (surface, built) = build(&profile, &EngineOptions::default());
    let height = surface.bounds().extent().z;
    let mut sets = rays::sets(&surface);
    sets.extend(hits_only(&sets, &surface, &profile, device, height)?);
    let mut errors = Vec::new();
    if options.races(Part::Embree) {
        for error in options.errors() {
            errors.push(meshes(name, error, error * height, &surface, device, &sets, options)?);
        }
    }
    let engines =
        options.races(Part::Engines).then(|| race_engines(name, &profile, &sets, options));
    Ok(ShapeResult {
        name: name.to_owned(),
        segments: profile.segments().count(),
        sets: SetInfo::of(&sets),
        built,
        errors,
        engines,
    })
}

/// The rays that hit both the surface and a fine mesh of it.
fn hits_only(
    sets: &[RaySet],
    surface: &Surface,
    profile: &Profile,
    device: &Device,
    height: f64,
) -> Result<Vec<RaySet>, Box<dyn Error>> {
    let mesh = Mesh::new(profile, HITS_ERROR * height).buffers(Kind::Quads);
    let scene = device.mesh(&mesh)?;
    let chosen = sets.iter().filter(|set| rays::HITS_ONLY.contains(&set.name.as_str()));
    Ok(chosen
        .map(|set| {
            let mesh_hits = scene.hits(&set.singles, set.far());
            let hits = set.rays.iter().map(|ray| surface.closest(ray).is_some());
            let keep: Vec<_> = iter::zip(mesh_hits, hits).map(|(a, b)| a && b).collect();
            set.only(&format!("{}, hits only", set.name), &keep)
        })
        .collect())
}

fn meshes(
    name: &str,
    error: f64,
    length: f64,
    surface: &Surface,
    device: &Device,
    sets: &[RaySet],
    options: &Options,
) -> Result<ErrorResult, Box<dyn Error>> {
    let mesh = Mesh::new(surface.profile(), length);
    let cells = mesh.cells();
    tell(format_args!("{name}: Embree, mesh error {error:e}, {cells} cells"));
    let together = if cells > CELLS_TOGETHER { 1 } else { Kind::ALL.len() };
    let mut heats = Vec::new();
    for kinds in Kind::ALL.chunks(together) {
        let mut scenes = Vec::new();
        for &kind in kinds {
            let buffers = mesh.buffers(kind);
            let (before, start) = (device.memory(), ThreadTime::now());
            let scene = device.mesh(&buffers)?;
            let seconds = start.elapsed().as_secs_f64();
            let bytes = (device.memory() - before) as f64;
            scenes.push((kind, scene, Built { bytes, seconds }));
        }
        let mut contestants: Vec<&dyn Contestant> = vec![surface];
        contestants.extend(scenes.iter().map(|(_, scene, _)| scene as &dyn Contestant));
        let singly: Vec<_> = scenes.iter().map(|(_, scene, _)| OneByOne(scene)).collect();
        contestants.extend(singly.iter().map(|scene| scene as &dyn Contestant));
        let mut scores = heat(&contestants, sets, options.rounds());
        let singly = scores.split_off(1 + scenes.len());
        let mut scores = scores.into_iter();
        let rondure = scores.next().unwrap_or_default();
        let scores = iter::zip(scores, singly).map(|(a, b)| faster(a, b));
        let mesh = |((kind, _, built), scores): (&(Kind, _, Built), _)| MeshResult {
            kind: *kind,
            built: *built,
            scores,
        };
        let meshes = iter::zip(&scenes, scores).map(mesh).collect();
        heats.push(HeatResult { rondure, meshes });
    }
    Ok(ErrorResult { error, cells, heats })
}

/// Of two ways to answer each set, the faster one.
pub(crate) fn faster(a: Vec<Option<Score>>, b: Vec<Option<Score>>) -> Vec<Option<Score>> {
    let better = |(a, b): (Option<Score>, Option<Score>)| {
        a.into_iter().chain(b).max_by(|a, b| a.median().total_cmp(&b.median()))
    };
    iter::zip(a, b).map(better).collect()
}

/// How many rays of a set the engines of the paper answer, which are slow.
const ENGINE_RAYS: usize = 1 << 17;

fn race_engines(name: &str, profile: &Profile, sets: &[RaySet], options: &Options) -> Engines {
    tell(format_args!("{name}: Rondure's engines"));
    let sets: Vec<_> = sets
        .iter()
        .filter(|set| !set.batch)
        .map(|set| {
            let every = (set.len() / ENGINE_RAYS).max(1);
            let keep: Vec<_> = (0..set.len()).map(|i| i % every == 0).collect();
            set.only(&set.name, &keep)
        })
        .collect();
    let default = EngineOptions::default();
    let mut methods = vec![default.method];
    let others = Method::ALL.iter().map(|(method, _)| *method);
    methods.extend(others.filter(|method| *method != default.method && *method != Method::Bs));
    let built: Vec<_> = methods
        .iter()
        .map(|&method| build(profile, &EngineOptions { method, ..default }))
        .collect();
    let contestants: Vec<_> = built.iter().map(|(surface, _)| surface as &dyn Contestant).collect();
    let scores = heat(&contestants, &sets, options.rounds());
    let result = |((method, (_, built)), scores)| EngineResult { method, built, scores };
    let built = built.iter().map(|(surface, built)| (surface, *built));
    let results = iter::zip(iter::zip(methods, built), scores).map(result).collect();
    Engines { sets: SetInfo::of(&sets), results }
}

/// Builds a surface, often enough to know how long it takes.
fn build(profile: &Profile, options: &EngineOptions) -> (Surface, Built) {
    let region = Region::new(crate::ALLOCATOR);
    let surface = Surface::with_engine(profile, options);
    let change = region.change();
    // What was reallocated is among both already.
    let kept = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
    let times: Vec<_> = (0..9)
        .map(|_| {
            let start = ThreadTime::now();
            let again = Surface::with_engine(profile, options);
            let seconds = start.elapsed().as_secs_f64();
            drop(again);
            seconds
        })
        .collect();
    let bytes = kept + size_of::<Surface>() as f64;
    (surface, Built { bytes, seconds: median(&times) })
}

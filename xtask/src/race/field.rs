//! Fields of copies of the vase: 1, 100 and 10,000 of them.

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::{fs, iter};

use rondure::{Affine, Assembly, Bounds, Instances, Profile, Surface, Vec3};

use super::contest::{Contestant, Score, heat};
use super::embree::{Device, Scene};
use super::engines::OneByOne;
use super::mesh::{Kind, Mesh};
use super::rays::{self, Camera, RaySet};
use super::shape::{Built, faster};
use super::{Options, tell};

/// One engine on a field; scores by set.
#[derive(Clone, Debug)]
pub(crate) struct FieldScore {
    pub(crate) engine: String,
    /// Building the top level: what the copies add to the model.
    pub(crate) top: Built,
    pub(crate) scores: Vec<Option<Score>>,
}

/// All engines on one field.
#[derive(Clone, Debug)]
pub(crate) struct FieldResult {
    pub(crate) copies: usize,
    pub(crate) sets: Vec<(String, usize)>,
    pub(crate) scores: Vec<FieldScore>,
}

/// The edges of the fields, in copies.
const EDGES: [u32; 3] = [1, 10, 100];

/// How far apart the copies stand. The vase is 1 high and 0.65 wide.
const SPACING: f64 = 0.8;

/// The error of the mesh that Embree copies, of the height.
const MESH_ERROR: f64 = 1e-4;

pub(crate) fn race(device: &Device, options: &Options) -> Result<Vec<FieldResult>, Box<dyn Error>> {
    let text = fs::read_to_string("profiles/vase.path")?;
    let profile = Profile::from_path_data(&text)?;
    let surface = Surface::new(&profile);
    let mesh = Mesh::new(&profile, MESH_ERROR * surface.bounds().extent().z);
    let models: Vec<_> = Kind::ALL
        .iter()
        .map(|&kind| Ok((kind, device.mesh(&mesh.buffers(kind))?)))
        .collect::<Result<_, Box<dyn Error>>>()?;
    EDGES.iter().map(|&edge| race_field(edge, &surface, &models, device, options)).collect()
}

fn race_field(
    edge: u32,
    surface: &Surface,
    models: &[(Kind, Scene<'_>)],
    device: &Device,
    options: &Options,
) -> Result<FieldResult, Box<dyn Error>> {
    let placements = placements(edge);
    tell(format_args!("vase: {} copies", placements.len()));
    let bounds = placements.iter().map(|placement| around(placement, &surface.bounds()));
    let bounds = bounds.reduce(|a, b| a.union(&b)).unwrap_or(surface.bounds());
    let sets = rays::field_sets(&camera(edge), &bounds);
    let mut fields = Vec::new();
    for (kind, model) in models {
        let (before, start) = (device.memory(), cpu_time::ThreadTime::now());
        let scene = device.instances(model, &placements)?;
        let seconds = start.elapsed().as_secs_f64();
        let top = Built { bytes: (device.memory() - before) as f64, seconds };
        fields.push((format!("Embree, {}", kind.name()), top, scene));
    }
    let start = cpu_time::ThreadTime::now();
    let mut instances = Instances::new();
    let shape = instances.add_shape(Arc::new(surface.clone()));
    for placement in &placements {
        instances.place(shape, *placement)?;
    }
    let own = Assembly::new(instances)?;
    let top = Built { bytes: own.bytes() as f64, seconds: start.elapsed().as_secs_f64() };
    let mut contestants: Vec<_> =
        fields.iter().map(|(.., scene)| scene as &dyn Contestant).collect();
    let singly: Vec<_> = fields.iter().map(|(.., scene)| OneByOne(scene)).collect();
    contestants.extend(singly.iter().map(|scene| scene as &dyn Contestant));
    contestants.push(&own);
    let mut scores = heat(&contestants, &sets, options.rounds());
    let own =
        FieldScore { engine: "Rondure".to_owned(), top, scores: scores.pop().unwrap_or_default() };
    let singly = scores.split_off(fields.len());
    let scores = iter::zip(scores, singly).map(|(a, b)| faster(a, b));
    let score = |((engine, top, _), scores): (&(String, Built, _), _)| FieldScore {
        engine: engine.clone(),
        top: *top,
        scores,
    };
    Ok(FieldResult {
        copies: placements.len(),
        sets: sets.iter().map(|set: &RaySet| (set.name.clone(), set.len())).collect(),
        scores: iter::zip(&fields, scores).map(score).chain([own]).collect(),
    })
}

/// Copies on a square, each leaning a little to one side and of a size of its own; a single one is
/// left as it is.
fn placements(edge: u32) -> Vec<Affine> {
    if edge == 1 {
        return vec![Affine::IDENTITY];
    }
    let mut random = rays::Random(3);
    let middle = 0.5 * f64::from(edge - 1);
    let place = |i: u32| {
        let (x, y) = (f64::from(i % edge) - middle, f64::from(i / edge) - middle);
        let side = TAU * random.number();
        let lean = Affine::rotate(Vec3::new(side.cos(), side.sin(), 0.0), 0.3 * random.number());
        let size = 0.8 + 0.4 * random.number();
        let columns = lean.columns.map(|column| column * size);
        Affine { columns, translation: Vec3::new(x * SPACING, y * SPACING, 0.0) }
    };
    (0..edge * edge).map(place).collect()
}

/// In the direction of the other races' camera, so far away that the field fills the picture.
fn camera(edge: u32) -> Camera {
    let Camera { eye, look_at } = Camera::default();
    let away = 1.0 + 0.55 * f64::from(edge - 1);
    Camera { eye: look_at + (eye - look_at) * away, look_at }
}

/// The box round the corners of a placed box.
fn around(placement: &Affine, bounds: &Bounds) -> Bounds {
    let [low, high] = [bounds.min, bounds.max];
    (0..8).fold(Bounds::EMPTY, |all, i| {
        let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        let [x, y, z] = [pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z)];
        all.with_point(placement.point(Vec3::new(x, y, z)))
    })
}

//! From a scene to a picture: tiles, dealt out to threads.
//!
//! A pixel's value depends on the seed and its place alone, and its samples are added up in one
//! order: the picture is the same, bit for bit, for any number of threads.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rondure_scene::Scene;

use crate::{
    Picture, Statistics,
    camera::View,
    color::Rgb,
    filter::Filter,
    integrator::{Tracer, split_bits},
    sampler::{Key, Sample},
    world::World,
};

/// The edge of a tile, in pixels.
const TILE: u32 = 32;
/// The most reflections and refractions, whatever the scene asks for: after so many, the most
/// perfect real mirror has swallowed half of the light, and the stack still holds them.
const MAX_DEPTH: u32 = 200;

/// How to render, beside what the scene says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// The number of threads; `None` takes all that the machine offers.
    pub threads: Option<usize>,
    /// Chooses the random numbers. The same seed gives the same picture, bit for bit, on any
    /// number of threads.
    pub seed: u64,
}

/// Someone who waits for the picture. Called from any thread, in the middle of the work.
pub trait Progress: Sync {
    /// `done` (from 0 to 1) of all samples are taken; it may come out of order.
    fn advance(&self, done: f64) {
        let _ = done;
    }

    /// Whether to stop. Asked once for each row of a tile.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Nobody waits.
impl Progress for () {}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The work was stopped.
    #[error("the rendering was cancelled")]
    Cancelled,
    /// The film has no pixels or no samples.
    #[error("a picture of {width}x{height} pixels with {spp} samples each has nothing to render")]
    EmptyFilm {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples in each pixel.
        spp: u32,
    },
    /// The picture does not fit into memory.
    #[error("a picture of {width}x{height} pixels does not fit into memory")]
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The camera cannot see.
    #[error(
        "the camera sees nothing: eye and look_at must differ, up must not be parallel to the \
         view, and the field of view or height must be positive"
    )]
    Camera,
    /// An object refers to a material that is not there.
    #[error("object {object:?} has material {material}, but the scene has {materials}")]
    NoSuchMaterial {
        /// The object's name.
        object: String,
        /// The index that it refers to.
        material: usize,
        /// How many materials there are.
        materials: usize,
    },
    /// An object cannot stand where it is placed.
    #[error("object {object:?} cannot be placed: {source}")]
    Placement {
        /// The object's name.
        object: String,
        /// Why not.
        source: rondure::PlaceError,
    },
    /// A solid cannot be made, or not where it is placed or cut.
    #[error("object {object:?} cannot be made: {source}")]
    Solid {
        /// The object's name.
        object: String,
        /// Why not.
        source: rondure::solid::CsgError,
    },
    /// The objects do not fit into memory.
    #[error("{count} turned objects do not fit into memory; each takes some 300 bytes")]
    OutOfMemory {
        /// How many there are.
        count: u64,
    },
    /// There are too many objects.
    #[error("a scene can have at most 2 billion objects and lights: {0}")]
    TooManyObjects(#[from] rondure::bvh::TooManyItems),
    /// The threads could not be started.
    #[error("cannot start the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// A stretch of the picture.
#[derive(Clone, Copy)]
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

struct Job<'a> {
    world: World,
    view: View,
    filter: Filter,
    scene: &'a Scene,
    seed: u64,
    progress: &'a dyn Progress,
    done: AtomicU64,
}

/// Renders a scene.
///
/// # Errors
/// If the scene cannot be rendered (see [`RenderError`]), or `progress` asks to stop.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Picture, RenderError> {
    let film = &scene.film;
    let (width, height) = (film.width, film.height);
    if width == 0 || height == 0 || film.spp == 0 {
        return Err(RenderError::EmptyFilm { width, height, spp: film.spp });
    }
    let too_large = || RenderError::TooLarge { width, height };
    let count = (width as usize).checked_mul(height as usize).ok_or_else(too_large)?;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(count).map_err(|_| too_large())?;
    pixels.resize(count, [0.0; 3]);
    let job = Job {
        world: World::new(scene)?,
        view: View::new(&scene.camera, width, height).ok_or(RenderError::Camera)?,
        filter: Filter::new(),
        scene,
        seed: settings.seed,
        progress,
        done: AtomicU64::new(0),
    };
    let statistics = match settings.threads {
        Some(1) => job.sequential(&mut pixels)?,
        Some(threads) => rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?
            .install(|| job.parallel(&mut pixels))?,
        None => job.parallel(&mut pixels)?,
    };
    progress.advance(1.0);
    Ok(Picture { width, height, exposure: film.exposure, pixels, statistics })
}

impl Job<'_> {
    /// The rows of tiles, each with the part of the picture that it fills.
    fn bands<'p>(&self, pixels: &'p mut [[f32; 3]]) -> Vec<(u32, &'p mut [[f32; 3]])> {
        let band = self.scene.film.width as usize * TILE as usize;
        (0..).step_by(TILE as usize).zip(pixels.chunks_mut(band)).collect()
    }

    fn tiles(&self, y: u32) -> impl Iterator<Item = Tile> + use<> {
        let (width, height) = (self.scene.film.width, self.scene.film.height);
        (0..width).step_by(TILE as usize).map(move |x| Tile {
            x,
            y,
            width: TILE.min(width - x),
            height: TILE.min(height - y),
        })
    }

    fn sequential(&self, pixels: &mut [[f32; 3]]) -> Result<Statistics, RenderError> {
        let mut all = Statistics::default();
        for (y, band) in self.bands(pixels) {
            for tile in self.tiles(y) {
                let (values, statistics) = self.tile(tile)?;
                self.place(band, tile, &values);
                all.add(&statistics);
            }
        }
        Ok(all)
    }

    fn parallel(&self, pixels: &mut [[f32; 3]]) -> Result<Statistics, RenderError> {
        self.bands(pixels)
            .into_par_iter()
            .with_max_len(1)
            .map(|(y, band)| {
                let tiles: Vec<_> = self.tiles(y).collect();
                let parts: Vec<_> = tiles
                    .into_par_iter()
                    .with_max_len(1)
                    .map(|tile| self.tile(tile).map(|part| (tile, part)))
                    .collect::<Result<_, _>>()?;
                let mut all = Statistics::default();
                for (tile, (values, statistics)) in parts {
                    self.place(band, tile, &values);
                    all.add(&statistics);
                }
                Ok(all)
            })
            .try_reduce(Statistics::default, |mut a, b| {
                a.add(&b);
                Ok(a)
            })
    }

    fn place(&self, band: &mut [[f32; 3]], tile: Tile, values: &[[f32; 3]]) {
        let stride = self.scene.film.width as usize;
        for (row, line) in values.chunks(tile.width as usize).enumerate() {
            let start = row * stride + tile.x as usize;
            band[start..start + line.len()].copy_from_slice(line);
        }
    }

    fn tile(&self, tile: Tile) -> Result<(Vec<[f32; 3]>, Statistics), RenderError> {
        let film = &self.scene.film;
        let mut statistics = Statistics::default();
        let mut values = Vec::with_capacity((tile.width * tile.height) as usize);
        for y in tile.y..tile.y + tile.height {
            if self.progress.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for x in tile.x..tile.x + tile.width {
                values.push(self.pixel(x, y, &mut statistics));
            }
        }
        let pixels = u64::from(tile.width) * u64::from(tile.height);
        let done = self.done.fetch_add(pixels, Ordering::Relaxed) + pixels;
        let all = u64::from(film.width) * u64::from(film.height);
        self.progress.advance(done as f64 / all as f64);
        Ok((values, statistics))
    }

    fn pixel(&self, x: u32, y: u32, statistics: &mut Statistics) -> [f32; 3] {
        let film = &self.scene.film;
        let mut sum = Rgb::BLACK;
        let mut count = 0_u32;
        for index in 0..film.spp {
            let sample = Sample::new(self.seed, x, y, index, film.spp);
            let (u, v) = sample.pair(Key::FILTER);
            let lens = if self.view.has_lens() { sample.pair(Key::LENS) } else { (0.5, 0.5) };
            let ray = self.view.ray(
                f64::from(x) + 0.5 + self.filter.offset(u),
                f64::from(y) + 0.5 + self.filter.offset(v),
                lens,
            );
            let mut tracer = Tracer {
                world: &self.world,
                depth: film.depth.min(MAX_DEPTH),
                sample,
                split_bits: split_bits(film.spp),
                statistics: Statistics::default(),
            };
            let light = tracer.camera_ray(&ray);
            statistics.add(&tracer.statistics);
            if light.is_light() {
                sum += light;
                count += 1;
            } else {
                statistics.invalid_samples += 1;
            }
        }
        let mean = if count > 0 { sum / f64::from(count) } else { Rgb::BLACK };
        [mean.r as f32, mean.g as f32, mean.b as f32]
    }
}

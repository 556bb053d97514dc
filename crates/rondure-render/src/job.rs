//! What all tiles of a picture share, and how one of them is made.
//!
//! A sample is a function of the scene, the seed, its pixel and its number alone, and the film's sums are exact: whoever makes which tile and
//! which samples, where and when, the picture is the same, bit for bit.

use core::ops::Range;

use fearless_simd::Level;
use rondure::{Ray, Vec3};
use rondure_film::{Film, Guide, Layers, Pass, PixelSample, Portion, Statistics, Window};
use rondure_scene::{Integrator, Scene};

use crate::{
    Progress, RenderError, Settings,
    camera::View,
    features,
    filter::Filter,
    integrator::{Tracer, split_bits},
    numbers,
    path::{
        self,
        photons::{Aim, Photons, Volley},
    },
    sampler::{GROUP, Key, Sample},
    world::{Batch, Contact, World},
};

/// The most reflections and refractions, whatever the scene asks for: after so many, the most
/// perfect real mirror has swallowed half of the light, and the stack still holds them.
const MAX_DEPTH: u32 = 200;

/// A picture to be made: a scene, ready to be asked for tiles.
#[derive(Debug)]
pub struct Job<'a> {
    /// What of the machine's SIMD is used.
    level: Level,
    world: World,
    view: View,
    filter: Filter,
    scene: &'a Scene,
    seed: u64,
    layers: Layers,
    /// Where photons for caustics go, if there are any.
    aim: Option<Aim>,
}

/// What is made once for a pass and shared by all its tiles.
#[derive(Debug)]
pub struct Prepared {
    pass: Pass,
    photons: Option<Photons>,
}

impl Prepared {
    /// The pass that it is for.
    pub fn pass(&self) -> Pass {
        self.pass
    }
}

/// The pixels across and down whose rays from the camera go together.
const EDGE: u32 = 4;
/// And how many those are.
const PIXELS: usize = (EDGE * EDGE) as usize;

/// Some samples, of one [group](GROUP), of the pixels of a square whose corner is a multiple of its edge: those of all pixels, row by row, after
/// those of the sample before.
#[derive(Debug, Default)]
struct Group {
    /// The samples, and whether their weights in the film are negative.
    aims: Vec<(Sample, bool)>,
    rays: Vec<Ray>,
    /// Where they meet the world.
    contacts: Vec<Option<Contact>>,
    batch: Batch,
}

/// What the samples of a tile add up to.
#[derive(Clone, Debug, PartialEq)]
pub struct TileSums {
    /// The sums, over the tile.
    pub film: Film,
    /// The work that went into them.
    pub statistics: Statistics,
}

impl<'a> Job<'a> {
    /// Gets a scene ready; the film will have these layers.
    ///
    /// # Errors
    /// If the scene cannot be rendered.
    pub fn new(scene: &'a Scene, settings: &Settings, layers: Layers) -> Result<Self, RenderError> {
        let film = &scene.film;
        let (width, height) = (film.width, film.height);
        if width == 0 || height == 0 || film.spp == 0 {
            return Err(RenderError::EmptyFilm { width, height, spp: film.spp });
        }
        let world = World::new(scene)?;
        let aim = match film.integrator {
            Integrator::Path => Aim::new(&world),
            Integrator::Reference | Integrator::Whitted => None,
        };
        Ok(Self {
            level: Level::new(),
            world,
            aim,
            view: View::new(&scene.camera, width, height).ok_or(RenderError::Camera)?,
            filter: Filter::new(film.filter),
            scene,
            seed: settings.seed,
            layers,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// The layers of the film.
    pub fn layers(&self) -> Layers {
        self.layers
    }

    /// The size of the picture, width and height.
    pub fn size(&self) -> [u32; 2] {
        [self.scene.film.width, self.scene.film.height]
    }

    /// All pixels with all samples that the scene asks for.
    pub fn whole(&self) -> Portion {
        let [width, height] = self.size();
        Portion { window: Window::whole(width, height), samples: 0..self.scene.film.spp }
    }

    /// Makes what all tiles of a pass share. It depends on the job and the number of the pass alone.
    ///
    /// # Errors
    /// If `progress` asks to stop.
    pub fn prepare(&self, pass: Pass, progress: &dyn Progress) -> Result<Prepared, RenderError> {
        let [width, height] = self.size();
        let samples = pass.samples();
        let volley = Volley {
            seed: self.seed,
            pass: pass.0,
            first: samples.start,
            each: samples.len() as u32,
            samples: f64::from(width) * f64::from(height) * samples.len() as f64,
            depth: self.scene.film.depth.min(MAX_DEPTH),
        };
        let go_on = |done| {
            progress.preparing(done);
            !progress.is_cancelled() && !progress.is_enough()
        };
        let photons = match &self.aim {
            Some(aim) => Some(
                Photons::new(&self.world, aim, &volley, &go_on).ok_or(RenderError::Cancelled)?,
            ),
            None => None,
        };
        Ok(Prepared { pass, photons })
    }

    /// Takes the `samples` of one pass in the pixels of `tile`.
    ///
    /// # Errors
    /// If the samples are not of the pass or the tile is not in the picture, if there is not enough memory, or if `progress` asks to stop.
    pub fn tile(
        &self,
        prepared: &Prepared,
        tile: Window,
        samples: &Range<u32>,
        progress: &dyn Progress,
    ) -> Result<TileSums, RenderError> {
        let of_pass = prepared.pass.samples();
        if samples.start < of_pass.start || samples.end > of_pass.end {
            return Err(RenderError::OtherPass { samples: samples.clone(), pass: of_pass });
        }
        let mut film = Film::new(self.size(), tile, self.layers)?;
        let mut statistics = Statistics::default();
        let mut tracer = self.tracer(prepared);
        let mut group = Group::default();
        for corner_y in (tile.y / EDGE * EDGE..tile.y + tile.height).step_by(EDGE as usize) {
            if progress.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for corner_x in (tile.x / EDGE * EDGE..tile.x + tile.width).step_by(EDGE as usize) {
                let pixels = Window { x: corner_x, y: corner_y, width: EDGE, height: EDGE };
                let Some(wanted) = pixels.common(&tile) else { continue };
                if self.layers.guides && samples.start == 0 {
                    for (x, y) in wanted.coordinates() {
                        film.set_center(x, y, features::center(&self.world, &self.view, x, y));
                    }
                }
                let mut start = samples.start;
                while start < samples.end {
                    let end = samples.end.min((start / GROUP as u32 + 1) * GROUP as u32);
                    self.aim(&pixels, &(start..end), &mut group);
                    for (x, y) in wanted.coordinates() {
                        let pixel = ((y - corner_y) * EDGE + x - corner_x) as usize;
                        for i in (pixel..group.rays.len()).step_by(PIXELS) {
                            match self.sample(tracer.as_mut(), &group, i, &mut statistics) {
                                Some(sample) if film.add(x, y, &sample) => {}
                                _ => statistics.invalid_samples += 1,
                            }
                        }
                    }
                    start = end;
                }
            }
        }
        if let Some(tracer) = tracer {
            statistics.add(&tracer.statistics);
        }
        Ok(TileSums { film, statistics })
    }

    /// Aims at some pixels with some samples, and finds what their rays meet.
    ///
    /// How a ray is answered depends, by rounding, on those beside it. So that the picture does not depend on the tiles it is made of, all rays of
    /// the square are asked about, also those that are not wanted.
    fn aim(&self, pixels: &Window, samples: &Range<u32>, group: &mut Group) {
        let Group { aims, rays, contacts, batch } = group;
        let count = samples.len() * PIXELS;
        aims.resize(count, (Sample::new(0, 0, 0, 0), false));
        rays.resize(count, Ray::new(Vec3::ZERO, Vec3::Z));
        for (pixel, (x, y)) in pixels.coordinates().enumerate() {
            let (first, place) = Sample::new(self.seed, x, y, samples.start).in_group();
            let filters = numbers::pairs(self.level, &first, Key::FILTER);
            let lenses =
                self.view.has_lens().then(|| numbers::pairs(self.level, &first, Key::LENS));
            for (i, index) in samples.clone().enumerate() {
                let (u, v) = filters[place + i];
                let lens = lenses.map_or((0.5, 0.5), |lenses| lenses[place + i]);
                let ((across, a), (down, b)) = (self.filter.offset(u), self.filter.offset(v));
                let (at_x, at_y) = (f64::from(x) + 0.5 + across, f64::from(y) + 0.5 + down);
                rays[i * PIXELS + pixel] = self.view.ray(at_x, at_y, lens);
                aims[i * PIXELS + pixel] = (Sample::new(self.seed, x, y, index), a != b);
            }
        }
        contacts.clear();
        for alike in rays.chunks(PIXELS) {
            self.world.closest_of_many(alike, batch);
            contacts.append(&mut batch.contacts);
        }
    }

    /// What follows paths, unless the integrator is Whitted's.
    fn tracer<'b>(&'b self, prepared: &'b Prepared) -> Option<path::Tracer<'b>> {
        let film = &self.scene.film;
        let depth = film.depth.min(MAX_DEPTH);
        let branches = film.integrator == Integrator::Path;
        let photons = prepared.photons.as_ref();
        (film.integrator != Integrator::Whitted)
            .then(|| path::Tracer::new(&self.world, photons, depth, branches))
    }

    /// One sample of a group; `None` if it is not an amount of light.
    fn sample(
        &self,
        tracer: Option<&mut path::Tracer<'_>>,
        group: &Group,
        i: usize,
        statistics: &mut Statistics,
    ) -> Option<PixelSample> {
        let film = &self.scene.film;
        let ((sample, negative), ray) = (group.aims[i], &group.rays[i]);
        let first = group.contacts[i];
        let light = match tracer {
            Some(tracer) => tracer.camera_ray(sample, ray, first),
            None => {
                let mut tracer = Tracer {
                    world: &self.world,
                    depth: film.depth.min(MAX_DEPTH),
                    sample,
                    split_bits: split_bits(film.spp),
                    statistics: Statistics::default(),
                };
                let light = tracer.camera_ray(ray, first);
                statistics.add(&tracer.statistics);
                light
            }
        };
        let guide = if self.layers.guides {
            features::guide(&self.world, ray, first.as_ref())
        } else {
            Guide::default()
        };
        let light = light.is_light().then_some([light.r, light.g, light.b])?;
        Some(PixelSample { light, negative, guide })
    }
}

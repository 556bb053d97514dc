//! Light along paths (Kajiya 1986, "The Rendering Equation"): from the eye from surface to surface, at each of
//! which lamps and sky are looked for too. What both ways can find is weighted by Veach's power heuristic
//! (1995, "Optimally Combining Sampling Techniques").
//!
//! One kind of light a path finds by chance alone, and too rarely: from a lamp through narrow lobes, mirrors
//! and glass, onto a wide one. That are caustics, and `photons` brings them from the lamps; here what
//! arrives that way is left out, but where chance finds it better (`merging`). `vertex` is a place on a path, `media`
//! what the path is inside of.

mod media;
mod merging;
mod photon_map;
pub(crate) mod photons;
#[cfg(test)]
mod tests;
mod vertex;
mod weighting;

use rondure::{Interaction, Ray, Vec3};
use rondure_film::Statistics;

pub(crate) use self::weighting::Weighting;
use self::{
    media::Media,
    merging::Chance,
    photons::Photons,
    vertex::{Draw, Vertex, is_dispersive},
};
use crate::{
    bsdf::{Kind, Part, Wavelength},
    color::Rgb,
    light::{Incoming, Lamp},
    numbers::Numbers,
    sampler::{Key, Sample},
    world::{Contact, Role, World},
};

/// The first place on a path at which it can be ended at random.
const ROULETTE_FROM: u32 = 3;
/// The most lamps that are all looked at where the eye sees a surface; of more, and later on the path, one is
/// chosen.
const FEW_LAMPS: usize = 16;

/// The scatterings after which a path branches no more. Later branches cost more time than they save noise.
const SPLITS: u32 = 2;
/// A branch that can bring more than this part of white is followed, not left to chance: a lamp seen in it would be
/// a spark.
const SPLIT_LIGHT: f64 = 0.02;
/// The weights between which the least is that a branch must have.
const SPLIT_WEIGHTS: [f64; 2] = [0.0005, 0.01];

// The random numbers of a place on a path, beside those of `Draw`: 1, 2 and 5.
const NEXT: u32 = 0;
const BRANCH: u32 = 8;
const ROULETTE: u32 = 3;
const SKY: u32 = 4;
const LAMP: u32 = 6;
const WAVELENGTH: u32 = 7;
const LAMPS: u32 = 16;

/// Follows the paths of samples, one after the other.
pub(crate) struct Tracer<'a> {
    world: &'a World,
    photons: Option<&'a Photons>,
    /// How often light may be scattered before it meets the eye.
    depth: u32,
    /// The least weight of a branch that is followed; none weighs as much as infinity.
    least_branch: f64,
    weighting: Weighting,
    pub(crate) statistics: Statistics,
    numbers: Numbers,
    /// Branches that are to be followed yet.
    waiting: Vec<(Walk, Media)>,
    /// What the path at hand is inside of.
    media: Media,
}

/// The place that a path goes on from.
struct Departure<'a> {
    vertex: &'a Vertex<'a>,
    /// Its thing, if photons are aimed at that.
    target: Option<u32>,
    /// Whether all lamps were looked for there.
    all_lamps: bool,
    /// The part of the samples that choose between reflecting lobes alone.
    reflecting: f64,
}

/// A path as far as it has come.
#[derive(Clone)]
struct Walk {
    /// How often it was scattered, and how often it passed a boundary that is none.
    depth: u32,
    hidden: u32,
    ray: Ray,
    /// The share of the ray's light that reaches the eye.
    weight: Rgb,
    /// What part of the light's ways it stands for, where it branched.
    part: f64,
    /// The density by solid angle with which the ray was chosen, and by what kind of lobe.
    pdf: f64,
    kind: Kind,
    /// Whether a wide lobe has scattered the path.
    scattered: bool,
    /// What chance counts since then, where photons bring the same light.
    chance: Chance,
    /// What the ray comes from, if photons are aimed at that.
    from_target: Option<u32>,
    /// Whether all lamps were looked for where the ray comes from, and not one of them.
    all_lamps: bool,
    wavelength: Option<Wavelength>,
    key: Key,
}

impl Walk {
    fn from_eye(ray: &Ray) -> Self {
        Self {
            ray: *ray,
            weight: Rgb::WHITE,
            part: 1.0,
            depth: 0,
            hidden: 0,
            pdf: f64::INFINITY,
            kind: Kind::Narrow,
            scattered: false,
            chance: Chance::NONE,
            from_target: None,
            all_lamps: true,
            wavelength: None,
            key: Key::ROOT,
        }
    }
}

impl<'a> Tracer<'a> {
    /// Without photons caustics are left to chance; `branches` tells whether paths branch at the first surfaces, where they can.
    pub(crate) fn new(
        world: &'a World,
        photons: Option<&'a Photons>,
        depth: u32,
        branches: bool,
    ) -> Self {
        let [low, high] = SPLIT_WEIGHTS;
        let least = (SPLIT_LIGHT * world.white / world.brightest).clamp(low, high);
        Self {
            world,
            photons,
            depth,
            least_branch: if branches { least } else { f64::INFINITY },
            weighting: Weighting::default(),
            statistics: Statistics::default(),
            numbers: Numbers::new(),
            waiting: Vec::new(),
            media: Media::default(),
        }
    }

    /// The radiance that comes against a ray from the camera, of unit direction, with the random numbers of a sample; it meets the world
    /// at `first`.
    ///
    /// As long as the path runs by mirrors and glass, and carries enough weight, both ways are followed that
    /// it can take: what is reflected, and the rest.
    pub(crate) fn camera_ray(&mut self, sample: Sample, ray: &Ray, first: Option<Contact>) -> Rgb {
        self.numbers.begin(sample);
        self.statistics.camera_rays += 1;
        let mut light = Rgb::BLACK;
        let mut walk = Walk::from_eye(ray);
        self.media.clear();
        let mut first = Some(first);
        loop {
            // Boundaries that are none do not count, but there is an end to them too.
            while walk.depth <= self.depth + 1 && walk.hidden <= self.depth + 16 {
                let met = first.take().unwrap_or_else(|| self.world.closest(&walk.ray));
                if !self.step(&mut walk, met, &mut light) {
                    break;
                }
            }
            match self.waiting.pop() {
                Some(branch) => (walk, self.media) = branch,
                None => return light,
            }
        }
    }

    /// Adds the light that is found at the next place of the path, where it meets the world, and goes on from there, if it goes on.
    /// Where the path branches, the branch waits.
    fn step(&mut self, walk: &mut Walk, met: Option<Contact>, light: &mut Rgb) -> bool {
        let world = self.world;
        let Some(contact) = met else {
            *light += walk.weight * self.sky(walk);
            return false;
        };
        let filling =
            self.media.filling().and_then(|body| world.optics(body.finish).glass.as_ref());
        if let Some(glass) = filling {
            walk.weight = glass.faded(walk.weight, contact.t);
        }
        let (finish, solid) = match world.met(&walk.ray, &contact) {
            Role::Lamp(lamp) => {
                *light += walk.weight * self.lamp(walk, lamp, contact.t);
                return false;
            }
            Role::Surface { finish, solid } => (finish, solid),
        };
        let optics = world.optics(finish);
        if !optics.emission.is_black() {
            let surface = world.interaction(&walk.ray, &contact);
            *light += walk.weight * optics.emission * self.shine(walk, contact.thing, &surface);
        }
        if walk.depth > self.depth {
            return false;
        }
        if walk.wavelength.is_none() && is_dispersive(optics) {
            let wavelength = Wavelength(self.numbers.single(walk.key, WAVELENGTH));
            walk.weight = walk.weight * wavelength.color();
            walk.wavelength = Some(wavelength);
        }
        let draw = &mut Draw::new(&mut self.numbers, walk.key);
        let (met, wavelength) = ((finish, solid), walk.wavelength);
        let vertex = Vertex::new(world, &walk.ray, &contact, met, &self.media, wavelength, draw);
        let is_target = self.photons.is_some_and(|photons| photons.is_target(contact.thing));
        let target = is_target.then_some(contact.thing);
        let all_lamps = !walk.scattered && world.lamps.len() <= FEW_LAMPS;
        if vertex.is_lit() {
            // What is seen of a lamp in narrow lobes from a wide one is a caustic.
            let target = target.filter(|_| walk.scattered);
            *light += walk.weight * self.direct(walk, &vertex, target, all_lamps);
        }
        let branches = self.least_branch < f64::INFINITY;
        let splits = branches && !walk.scattered && walk.depth < SPLITS;
        let split = splits.then(|| vertex.split()).flatten().filter(|share| {
            share.min(1.0 - share) * walk.weight.max_channel() >= self.least_branch
        });
        let reflecting = split.map_or(1.0, |share| 1.0 - share);
        if let Some(photons) = self.photons
            && vertex.is_wide()
        {
            let left = self.depth - walk.depth;
            let index = filling.map_or(1.0, |glass| glass.ior(walk.wavelength));
            let turn = self.numbers.sample().turn(walk.key);
            let found = photons.gather(&vertex, contact.thing, left, turn, reflecting);
            *light += walk.weight * found / (index * index);
        }
        let from = Departure { vertex: &vertex, target, all_lamps, reflecting };
        let Some(share) = split else { return self.go_on(walk, &from, [0.0, 1.0], NEXT) };
        let (start, media) = (walk.clone(), self.media.clone());
        if self.go_on(walk, &from, [0.0, share], NEXT) {
            self.waiting.push((walk.clone(), self.media.clone()));
        }
        (*walk, self.media) = (start, media);
        self.go_on(walk, &from, [share, 1.0 - share], BRANCH)
    }

    /// Goes on from a place, if the path does not end there. `lobes` tells where the numbers begin that choose between the lobes of the
    /// branch, and what share of all they are.
    fn go_on(
        &mut self,
        walk: &mut Walk,
        from: &Departure<'_>,
        lobes: [f64; 2],
        branch: u32,
    ) -> bool {
        let share = lobes[1];
        let draw = Draw::new(&mut self.numbers, walk.key).among(lobes);
        let Some(onward) = from.vertex.onward(draw) else { return false };
        let mut weight = walk.weight * onward.weight * share;
        if walk.depth >= ROULETTE_FROM && !onward.straight {
            // Where a path branched it became no less worth following.
            let live = (weight.max_channel() / (walk.part * share)).min(1.0);
            if !(self.numbers.single(walk.key, ROULETTE) < live) {
                return false;
            }
            weight = weight / live;
        }
        self.statistics.secondary_rays += 1;
        walk.ray = from.vertex.surface.spawn(onward.direction);
        walk.weight = weight;
        walk.part *= share;
        if onward.through
            && let Some(crossing) = from.vertex.crossing
        {
            self.media.cross(crossing);
        }
        walk.key = walk.key.child(branch);
        if onward.straight {
            walk.hidden += 1;
            return true;
        }
        walk.depth += 1;
        walk.pdf = onward.pdf;
        walk.kind = onward.kind;
        walk.from_target = from.target;
        if onward.kind == Kind::Wide {
            walk.scattered = true;
            let cos = onward.direction.dot(from.vertex.normal());
            walk.chance = match self.photons {
                Some(photons) if from.vertex.even_color().is_none() => {
                    photons.chance(onward.pdf, cos, from.reflecting)
                }
                _ => Chance::NONE,
            };
        }
        walk.all_lamps = from.all_lamps;
        true
    }

    /// The light of the sky along the ray, as far as it was not looked for where the ray comes from.
    fn sky(&self, walk: &Walk) -> Rgb {
        let sky = &self.world.sky;
        let direction = walk.ray.direction;
        if !sky.is_picture() {
            return sky.radiance(direction);
        }
        sky.radiance(direction) * self.weighting.of_chance(walk.pdf, sky.pdf(direction))
    }

    /// The same of a lamp that the ray meets.
    fn lamp(&self, walk: &Walk, lamp: u32, distance: f64) -> Rgb {
        let Ray { origin, direction, .. } = walk.ray;
        let found = &self.world.lamps[lamp as usize];
        let pdf = found.pdf(origin, direction, distance);
        let left = match walk.from_target {
            Some(thing) if walk.scattered && walk.kind == Kind::Narrow => {
                self.left(walk.chance, thing, lamp, (origin, direction * distance), pdf)
            }
            _ => 1.0,
        };
        if left == 0.0 {
            return Rgb::BLACK;
        }
        let share = if walk.all_lamps { 1.0 } else { self.world.lamp_share(origin, lamp as usize) };
        found.radiance() * (left * self.weighting.of_chance(walk.pdf, pdf * share))
    }

    /// The share of the light of a lamp that photons leave, where it comes by the narrow lobes of a thing that they
    /// are aimed at. `way` leads to the lamp from a place where it is looked for with the density `pdf`.
    fn left(
        &self,
        chance: Chance,
        thing: u32,
        lamp: u32,
        (at, way): (Vec3, Vec3),
        pdf: f64,
    ) -> f64 {
        let Some(photons) = self.photons else { return 1.0 };
        let source = (lamp, &self.world.lamps[lamp as usize]);
        let back = (at + way, -way);
        if chance.is_none() {
            return if photons.go(source, thing, back) { 0.0 } else { 1.0 };
        }
        chance.weight(photons.density(source, thing, back, pdf))
    }

    /// The share of the light of a shining surface that was not looked for where the ray comes from, and that
    /// photons do not bring.
    fn shine(&self, walk: &Walk, thing: u32, surface: &Interaction) -> f64 {
        let Some(lamp) = self.world.lamp_of(thing) else { return 1.0 };
        let Lamp::Turned(shining) = &self.world.lamps[lamp as usize] else { return 1.0 };
        let origin = walk.ray.origin;
        let pdf = shining.pdf(origin, surface);
        let left = match walk.from_target {
            Some(target) if walk.scattered && walk.kind == Kind::Narrow => {
                self.left(walk.chance, target, lamp, (origin, surface.point - origin), pdf)
            }
            _ => 1.0,
        };
        let share = if walk.all_lamps { 1.0 } else { self.world.lamp_share(origin, lamp as usize) };
        left * self.weighting.of_chance(walk.pdf, pdf * share)
    }

    /// The light of lamps and sky that a surface sends on; `target` is the surface's thing, if photons bring of the
    /// lamps' light what its narrow lobes send.
    fn direct(&mut self, walk: &Walk, vertex: &Vertex<'_>, target: Option<u32>, all: bool) -> Rgb {
        let world = self.world;
        let at = vertex.surface.point;
        let mut sum = Rgb::BLACK;
        let left = |tracer: &Self, lamp: u32, incoming: &Incoming| {
            let Some(thing) = target else { return 1.0 };
            let way = incoming.direction * incoming.distance;
            tracer.left(walk.chance, thing, lamp, (at, way), incoming.pdf)
        };
        if all {
            for (i, lamp) in (0..).zip(&world.lamps) {
                let u = self.place_on(lamp, walk.key, LAMPS + i);
                if let Some(incoming) = lamp.sample_at(at, u) {
                    let narrow = left(self, i, &incoming);
                    sum += self.arriving(vertex, &incoming, narrow);
                }
            }
        } else {
            let choice = || self.numbers.single(walk.key, LAMP);
            if let Some((lamp, share)) = world.choose_lamp(at, choice) {
                let u = self.place_on(&world.lamps[lamp], walk.key, LAMPS);
                if let Some(incoming) = world.lamps[lamp].sample_at(at, u) {
                    let narrow = left(self, lamp as u32, &incoming);
                    let (light, pdf) = (incoming.light / share, incoming.pdf * share);
                    let incoming = Incoming { light, pdf, ..incoming };
                    sum += self.arriving(vertex, &incoming, narrow);
                }
            }
        }
        // Of an even sky chance knows about as much.
        if world.sky.is_picture()
            && let Some(incoming) = world.sky.sample(self.numbers.pair(walk.key, SKY))
        {
            // No photons come from the sky.
            sum += self.arriving(vertex, &incoming, 1.0);
        }
        sum
    }

    /// The numbers that choose a place on a lamp.
    #[inline]
    fn place_on(&mut self, lamp: &Lamp, key: Key, child: u32) -> (f64, f64) {
        if lamp.is_disk() { self.numbers.disk(key, child) } else { self.numbers.pair(key, child) }
    }

    /// What one sample of a light adds; of what narrow lobes send, the share `narrow`.
    fn arriving(&mut self, vertex: &Vertex<'_>, incoming: &Incoming, narrow: f64) -> Rgb {
        let parts = vertex.evaluate(incoming.direction);
        let weighting = self.weighting;
        let weigh = |part: Part| part.value * weighting.of_looking(incoming.pdf, part.pdf);
        let mut seen = weigh(parts.wide);
        if narrow > 0.0 && !parts.narrow.value.is_black() {
            seen += weigh(parts.narrow) * narrow;
        }
        if seen.is_black() {
            return Rgb::BLACK;
        }
        let ray = incoming.way(&vertex.surface);
        self.statistics.shadow_rays += 1;
        if self.world.is_occluded(&ray) {
            return Rgb::BLACK;
        }
        let mut light = incoming.light * seen;
        if let Some(body) = self.media.filling()
            && let Some(glass) = &self.world.optics(body.finish).glass
        {
            light = glass.faded(light, incoming.distance);
        }
        light
    }
}

//! Caustics: photons from the lamps, through narrow lobes onto wide ones (Jensen 1996, "Global Illumination
//! using Photon Maps"; passes with shrinking radii by Knaus and Zwicker 2011, "Progressive Photon Mapping: A
//! Probabilistic Approach").
//!
//! Photons are aimed at *targets*, the things with narrow lobes: one for each pair of lamp and target, as
//! much as the lamp can send there, into the cone in which the lamp sees the ball round the target. One that meets
//! something else first is given up, so that each way of light belongs to one pair. A photon comes to rest
//! wherever it meets a wide lobe, and goes on by narrow ones.
//!
//! In the peak of a glossy lobe a single photon would be seen as a bright spot, and chance finds the light better.
//! There both ways count (`merging`).
//!
//! The photons of a pass are a function of the scene, the seed and the pass alone.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;
use rondure::Vec3;

use super::{
    media::Media,
    merging::Chance,
    photon_map::{HIGHEST_LEVEL, Photon, PhotonMap},
    vertex::{Draw, Vertex, is_dispersive},
};
use crate::{
    bsdf::{Kind, Wavelength},
    color::Rgb,
    light::{Emitted, Lamp},
    numbers::Numbers,
    sampler::{Key, Sample},
    world::{Role, World},
};

/// The most things that photons are aimed at; caustics of more are left to chance.
const MOST_TARGETS: usize = 4096;
/// The radius of the first pass, as part of the mean radius of the targets.
const FIRST_RADIUS: f64 = 0.03;
/// Photons that a pass sends out for each sample of the picture, and the least and the most of them.
const PER_SAMPLE: f64 = 0.25;
const FEWEST: f64 = 2e4;
const MOST: f64 = 1e6;
/// So many are sent out between two looks at whether to go on.
const AT_A_TIME: u32 = 1024;
/// The way, as part of the radius of its target, from which on a photon counts in a larger radius.
const WIDENS_FROM: f64 = 3.0;

// The random numbers of a photon's start.
const PAIR: u32 = 1;
const PLACE: u32 = 2;
const AIM: u32 = 3;
const WAVELENGTH: u32 = 4;
const ROULETTE: u32 = 5;
const NEXT: u32 = 0;

/// What photons are aimed at, and how often.
#[derive(Clone, Debug)]
pub(crate) struct Aim {
    /// For each thing whether it is a target.
    is_target: Vec<bool>,
    /// Lamp, thing, its ball, and the sum of the weights up to here.
    pairs: Vec<Pair>,
    /// The mean radius of the targets, weighted by the light that they get.
    size: f64,
}

#[derive(Clone, Copy, Debug)]
struct Pair {
    lamp: u32,
    thing: u32,
    center: Vec3,
    radius: f64,
    /// The light that the lamp sends to the ball, about.
    weight: f64,
    /// The sum of the weights up to this pair.
    until: f64,
}

impl Aim {
    /// `None` if no photon can make a caustic.
    pub(crate) fn new(world: &World) -> Option<Self> {
        if !world.is_some_surface_wide() {
            return None;
        }
        let mut is_target = vec![false; world.count()];
        let mut pairs: Vec<Pair> = Vec::new();
        let (mut until, mut size) = (0.0, 0.0);
        let targets = || {
            (0..world.count() as u32).filter_map(|thing| {
                let focus = world.focus(thing)?;
                let bounds = world.bounds(thing);
                let (center, half) =
                    ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
                let radius = half.length();
                (focus > 0.0 && radius > 0.0 && radius.is_finite())
                    .then_some((thing, center, radius, focus))
            })
        };
        if targets().nth(MOST_TARGETS).is_some() {
            return None;
        }
        for (thing, center, radius, focus) in targets() {
            is_target[thing as usize] = true;
            for (lamp, source) in (0..).zip(&world.lamps) {
                let weight = source.flux_to(center, radius).luminance() * focus;
                if weight > 0.0 && weight.is_finite() {
                    until += weight;
                    size += weight * radius;
                    pairs.push(Pair { lamp, thing, center, radius, weight, until });
                }
            }
        }
        (until > 0.0).then(|| Self { is_target, pairs, size: size / until })
    }

    /// How the ball of a thing is seen from a lamp, and the probability that a photon goes this way.
    fn find(&self, lamp: u32, thing: u32) -> Option<(&Pair, f64)> {
        let sum = self.pairs.last()?.until;
        // They were made in this order.
        let place = self.pairs.binary_search_by_key(&(thing, lamp), |p| (p.thing, p.lamp)).ok()?;
        let pair = &self.pairs[place];
        Some((pair, pair.weight / sum))
    }

    /// The pair that a number between 0 and 1 chooses, and its probability.
    fn choose(&self, u: f64) -> Option<(&Pair, f64)> {
        let sum = self.pairs.last()?.until;
        let place = self.pairs.partition_point(|pair| pair.until <= u * sum);
        let pair = self.pairs.get(place).or(self.pairs.last())?;
        Some((pair, pair.weight / sum))
    }
}

/// The photons of one pass.
#[derive(Debug)]
pub(crate) struct Photons {
    aim: Aim,
    /// How many were sent out, and how many samples of a pixel see them.
    count: f64,
    each: f64,
    map: PhotonMap,
}

/// Which photons a pass sends out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volley {
    pub(crate) seed: u64,
    pub(crate) pass: u32,
    /// The first sample of the pass, and how many samples a pixel and the picture take in it.
    pub(crate) first: u32,
    pub(crate) each: u32,
    pub(crate) samples: f64,
    /// How often light may be scattered.
    pub(crate) depth: u32,
}

impl Photons {
    /// Sends photons out; `None` if `go_on`, which is told now and then what share of them is through, says no.
    pub(crate) fn new(
        world: &World,
        aim: &Aim,
        volley: &Volley,
        go_on: &(dyn Fn(f64) -> bool + Sync),
    ) -> Option<Self> {
        let count = (volley.samples * PER_SAMPLE).clamp(FEWEST, MOST) as u32;
        let through = AtomicU32::new(0);
        let shoot_some = |first: u32| {
            let some = first..count.min(first + AT_A_TIME);
            let before = through.fetch_add(some.len() as u32, Ordering::Relaxed);
            let mut numbers = Numbers::new();
            let found =
                || some.flat_map(|i| shoot(world, aim, volley, i, count, &mut numbers)).collect();
            go_on(f64::from(before) / f64::from(count)).then(found)
        };
        let found: Option<Vec<Vec<Photon>>> = (0..count.div_ceil(AT_A_TIME))
            .into_par_iter()
            .map(|i| shoot_some(i * AT_A_TIME))
            .collect();
        // The area shrinks by the third root of the number of samples.
        let radius = FIRST_RADIUS * aim.size * f64::from(volley.first + 1).powf(-1.0 / 6.0);
        let photons = found?.into_iter().flatten().collect();
        let map = PhotonMap::new(radius, world.count(), photons);
        let (count, each) = (f64::from(count), f64::from(volley.each));
        Some(Self { aim: aim.clone(), count, each, map })
    }

    /// Whether photons are aimed at a thing.
    #[inline]
    pub(crate) fn is_target(&self, thing: u32) -> bool {
        self.aim.is_target[thing as usize]
    }

    /// Whether photons go from a lamp to a thing from the place `from` of the lamp on the way `way`.
    pub(crate) fn go(
        &self,
        (i, lamp): (u32, &Lamp),
        thing: u32,
        (from, way): (Vec3, Vec3),
    ) -> bool {
        lamp.sends(from, way) && self.aim.find(i, thing).is_some()
    }

    /// How many do, by area across and solid angle. From the other end of the way the lamp is looked for with the
    /// density `pdf` by solid angle.
    pub(crate) fn density(
        &self,
        (i, lamp): (u32, &Lamp),
        thing: u32,
        (from, way): (Vec3, Vec3),
        pdf: f64,
    ) -> f64 {
        let Some((pair, share)) = self.aim.find(i, thing) else { return 0.0 };
        if !lamp.has_body() {
            return f64::INFINITY;
        }
        let (direction, facing) = (way.normalized(), way.length_squared() / pdf);
        let extent = lamp.extent_to((pair.center, pair.radius), (from, direction), facing);
        if extent > 0.0 { self.count * share / extent } else { 0.0 }
    }

    /// What chance counts beside photons, where it goes on from a place with a density by solid angle, at a cosine.
    /// `reflecting` is the part of the samples there that choose between reflecting lobes alone.
    pub(crate) fn chance(&self, pdf: f64, cos: f64, reflecting: f64) -> Chance {
        Chance::new(pdf, self.each / reflecting, cos, self.map.radius())
    }

    /// The light of the photons that came to rest round a place on the same thing, as it is seen from there;
    /// each scattered at most `left` times before. `turn` is any number, and the next for the next sample; `reflecting`
    /// as in [`chance`](Self::chance).
    pub(crate) fn gather(
        &self,
        vertex: &Vertex<'_>,
        thing: u32,
        left: u32,
        turn: u32,
        reflecting: f64,
    ) -> Rgb {
        self.map.gather(vertex, thing, left, turn, self.each / reflecting)
    }
}

/// Follows one photon to all places where it comes to rest.
fn shoot(
    world: &World,
    aim: &Aim,
    volley: &Volley,
    i: u32,
    count: u32,
    numbers: &mut Numbers,
) -> Vec<Photon> {
    const OWN_SEED: u64 = 0x7068_6f74_6f6e_0001;
    numbers.begin(Sample::new(
        volley.seed ^ OWN_SEED,
        i >> 16,
        volley.pass.wrapping_mul(0x9e37_79b1),
        i & 0xffff,
    ));
    let mut found = Vec::new();
    let mut key = Key::ROOT;
    let Some((pair, share)) = aim.choose(numbers.single(key, PAIR)) else { return found };
    let lamp = &world.lamps[pair.lamp as usize];
    let (place, aimed) = (numbers.pair(key, PLACE), numbers.pair(key, AIM));
    let Some(Emitted { mut ray, power }) = lamp.emit(pair.center, pair.radius, place, aimed) else {
        return found;
    };
    let mut power = power / (share * f64::from(count));
    let first_power = power.max_channel();
    let density =
        if lamp.has_body() { lamp.radiance().max_channel() / first_power } else { f64::INFINITY };
    let (mut media, mut wavelength) = (Media::default(), None);
    let mut bounces = 0;
    let mut hidden = 0;
    // How far it has come since it met its target.
    let mut way = 0.0;
    while bounces <= volley.depth && hidden <= volley.depth + 16 {
        let Some(contact) = world.closest(&ray) else { break };
        if bounces == 0 && hidden == 0 && contact.thing != pair.thing {
            break;
        }
        let Role::Surface { finish, solid } = world.met(&ray, &contact) else { break };
        if let Some(body) = media.filling()
            && let Some(glass) = &world.optics(body.finish).glass
        {
            power = glass.faded(power, contact.t);
        }
        let optics = world.optics(finish);
        if wavelength.is_none() && is_dispersive(optics) {
            let chosen = Wavelength(numbers.single(key, WAVELENGTH));
            power = power * chosen.color();
            wavelength = Some(chosen);
        }
        let own = key.child(7);
        let draw = &mut Draw::new(numbers, own);
        let vertex = Vertex::new(world, &ray, &contact, (finish, solid), &media, wavelength, draw);
        if bounces > 0 {
            way += contact.t;
        }
        if bounces > 0 && vertex.is_wide() {
            // Farther away photons lie farther apart, and what they show is less sharp.
            let level = (0.5 * (way / (WIDENS_FROM * pair.radius)).log2()).round().max(0.0) as u32;
            found.push(Photon {
                point: vertex.surface.point,
                direction: -ray.direction,
                power,
                density,
                thing: contact.thing,
                bounces,
                level: level.min(HIGHEST_LEVEL),
            });
        }
        let Some(onward) = vertex.onward(Draw::new(numbers, own)) else { break };
        if onward.kind == Kind::Wide {
            break;
        }
        power = power * onward.weight;
        let live = (power.max_channel() / first_power).min(1.0);
        if !(numbers.single(key, ROULETTE) < live) {
            break;
        }
        power = power / live;
        ray = vertex.surface.spawn(onward.direction);
        if onward.through
            && let Some(crossing) = vertex.crossing
        {
            media.cross(crossing);
        }
        key = key.child(NEXT);
        if onward.straight { hidden += 1 } else { bounces += 1 }
    }
    found
}

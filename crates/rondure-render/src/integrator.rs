//! The light along a ray, after Whitted 1980, "An Improved Illumination Model for Shaded Display".
//!
//! Matte surfaces and the base of glossy ones are lit by the lights and the sky directly; mirrors,
//! coats and glass follow the light further. There is no light from matte surface to matte surface,
//! and no caustic: glass lets shadow rays through straight. For the same reason nothing that a
//! rough coat reflects, but a lamp itself, is brighter there than white: few rays find the image of
//! a lamp in another surface, and each would stand in the picture as a spark.
//!
//! Glass asks for both branches while the path carries enough weight, and then picks one at
//! random. The weights of the paths of one generation add up to at most one, so at most
//! 1 / [`SPLIT_WEIGHT`] of them branch: the work is bounded by the depth, not by its power of two.

use rondure::{Footing, Ray, Vec3};
use rondure_film::Statistics;

use crate::{
    bsdf::Ggx,
    coat::{HIGHLIGHT_ALPHA, power_heuristic},
    color::Rgb,
    finish::Finish,
    fresnel,
    light::Incoming,
    sampler::{Key, SPLIT_BITS, Sample},
    warp::{self, Frame},
    world::{Contact, Role, World, transmitted},
};

/// The least weight of a path that follows both reflection and refraction.
const SPLIT_WEIGHT: f64 = 0.02;
/// The least weight of a path that asks for several samples of a light: what the eye sees directly,
/// in a mirror or through glass.
const FULL_WEIGHT: f64 = 0.5;
/// What a path can still add to a pixel, as part of white, below which it is ended at random
/// (Russian roulette).
const ROULETTE_LIGHT: f64 = 0.01;
/// A highlight on a mirror or on glass this faint is cut off, and all are lowered by as much so
/// that there is no edge: as part of the light, a quarter of the step of an 8-bit picture.
const FAINT_HIGHLIGHT: f64 = 1e-3;
/// The most bodies of glass within each other that a path keeps account of.
const MAX_NESTED: usize = 4;

// The random numbers of a place on a path.
const REFLECTED: u32 = 0;
const REFRACTED: u32 = 1;
const LOBE: u32 = 2;
const ROULETTE: u32 = 3;
const SKY: u32 = 4;
const CHOICE: u32 = 5;
const LAMPS: u32 = 16;

/// A body of glass that a path is inside of.
#[derive(Clone, Copy, Debug, Default)]
struct Medium {
    thing: u32,
    /// The glass that was met on the way in.
    finish: u32,
}

/// The bodies of glass that a path is inside of, in the order of entering.
#[derive(Clone, Copy, Debug, Default)]
struct Media {
    inside: [Medium; MAX_NESTED],
    len: usize,
}

impl Media {
    fn entered(mut self, medium: Medium) -> Self {
        if self.len < MAX_NESTED {
            self.inside[self.len] = medium;
            self.len += 1;
        }
        self
    }

    fn left(mut self, thing: u32) -> Self {
        if let Some(i) = self.inside[..self.len].iter().rposition(|m| m.thing == thing) {
            self.inside.copy_within(i + 1..self.len, i);
            self.len -= 1;
        }
        self
    }

    /// The finish that fills the place: that of the body entered last.
    #[inline]
    fn top(&self) -> Option<u32> {
        self.len.checked_sub(1).map(|i| self.inside[i].finish)
    }
}

/// What a ray knows of the way behind it.
#[derive(Clone, Copy, Debug)]
struct Path {
    /// How often the light was reflected or refracted.
    depth: u32,
    /// An upper bound on the share of the ray's light that reaches the eye.
    weight: f64,
    /// The density by solid angle with which the ray was chosen.
    pdf: f64,
    /// Whether a rough coat chose the direction of this ray or of one before it.
    blurred: bool,
    key: Key,
    media: Media,
}

impl Path {
    fn next(&self, branch: u32, pdf: f64) -> Self {
        Self { depth: self.depth + 1, key: self.key.child(branch), pdf, ..*self }
    }
}

/// A place where light is looked up: the surface, the viewer's side of it and the viewer.
struct Place<'a> {
    surface: &'a Footing,
    /// The normal on the viewer's side.
    normal: Vec3,
    /// The normal that light sees, turned by a relief.
    shading: Vec3,
    /// The unit direction to the viewer.
    outgoing: Vec3,
    path: &'a Path,
}

/// Follows the rays of one sample of one pixel.
pub(crate) struct Tracer<'a> {
    pub(crate) world: &'a World,
    pub(crate) depth: u32,
    pub(crate) sample: Sample,
    /// How many samples the lights with extent get where a path has its full weight, as a power
    /// of two.
    pub(crate) split_bits: u32,
    pub(crate) statistics: Statistics,
}

/// The number of light samples in a pixel that is enough for soft shadows to look smooth.
const SMOOTH: u32 = 256;

/// The split of light samples that brings few samples a pixel nearer to [`SMOOTH`].
pub(crate) fn split_bits(spp: u32) -> u32 {
    (SMOOTH / spp.max(1)).checked_ilog2().unwrap_or(0).min(SPLIT_BITS)
}

impl Tracer<'_> {
    /// The radiance that comes against a ray from the camera, of unit direction, which meets the world at `first`.
    #[inline]
    pub(crate) fn camera_ray(&mut self, ray: &Ray, first: Option<Contact>) -> Rgb {
        self.statistics.camera_rays += 1;
        let path = Path {
            depth: 0,
            weight: 1.0,
            pdf: f64::INFINITY,
            blurred: false,
            key: Key::ROOT,
            media: Media::default(),
        };
        self.radiance(ray, first, path)
    }

    fn radiance(&mut self, ray: &Ray, met: Option<Contact>, mut path: Path) -> Rgb {
        let world = self.world;
        let Some(contact) = met else {
            return world.sky.radiance(ray.direction);
        };
        let faded = match path.media.top() {
            Some(finish) => {
                let (absorption, _) = world.glass(finish);
                transmitted(absorption * contact.t)
            }
            None => Rgb::WHITE,
        };
        path.weight *= faded.max_channel();
        let (finish, solid) = match world.met(ray, &contact) {
            Role::Lamp(lamp) => {
                let lamp = &world.lamps[lamp as usize];
                let pdf = lamp.pdf(ray.origin, ray.direction, contact.t);
                return lamp.radiance() * faded * power_heuristic(path.pdf, pdf);
            }
            Role::Surface { finish, solid } => (finish, solid),
        };
        let surface = world.footing(ray, &contact);
        let outgoing = -ray.direction;
        let entering = surface.normal.dot(outgoing) >= 0.0;
        let normal = if entering { surface.normal } else { -surface.normal };
        let kind = world.finish(finish);
        let (color, outwards) = world.seen(ray, &contact, finish, kind.color(), surface.normal);
        let shading = if entering { outwards } else { -outwards };
        let place = Place { surface: &surface, normal, shading, outgoing, path: &path };
        let light = match kind {
            Finish::Matte { .. } => self.matte(&place, color),
            Finish::Glossy { coat, .. } => {
                let frame = Frame::new(shading);
                let mut local = frame.to_local(outgoing);
                local.z = local.z.max(f64::MIN_POSITIVE);
                let facing = coat.facing(local);
                let mut sum = self.direct(&place, |incoming| {
                    let wi = frame.to_local(incoming.direction);
                    if !(wi.z > 0.0) {
                        return (Rgb::BLACK, Rgb::BLACK);
                    }
                    let lambert = facing.base(wi.z) * wi.z * core::f64::consts::FRAC_1_PI;
                    let (bright, shared) = if incoming.pdf == f64::INFINITY {
                        (facing.highlight(wi), 0.0)
                    } else {
                        (0.0, coat.shared_highlight(local, wi, incoming.pdf))
                    };
                    (color * lambert + Rgb::splat(bright), Rgb::splat(shared))
                });
                sum += self.sky_light(&place, |cos| color * facing.base(cos));
                let u = if coat.is_rough() {
                    self.sample.pair(path.key.child(LOBE))
                } else {
                    (0.5, 0.5)
                };
                if let Some(found) = coat.sample(local, u) {
                    let direction = frame.to_world(found.direction);
                    let mut next = path.next(REFLECTED, found.pdf);
                    next.blurred |= coat.is_rough();
                    sum += self.follow(&place, direction, normal, Rgb::splat(found.weight), next);
                }
                sum
            }
            Finish::Mirror { .. } => self.mirror(&place, color),
            Finish::Glass { .. } if solid => {
                let medium = Medium { thing: contact.thing, finish };
                self.glass(&place, medium, entering)
            }
            Finish::Glass { ior, .. } => self.sheet(&place, *ior),
        };
        if path.blurred {
            // A lamp's image in what a rough coat reflects: few rays find it.
            return light * faded * (world.white / light.max_channel().max(world.white));
        }
        light * faded
    }

    fn matte(&mut self, place: &Place<'_>, color: Rgb) -> Rgb {
        let lit = self.direct(place, |incoming| {
            let cos = incoming.direction.dot(place.shading).max(0.0);
            (color * (cos * core::f64::consts::FRAC_1_PI), Rgb::BLACK)
        });
        lit + self.sky_light(place, |_| color)
    }

    fn mirror(&mut self, place: &Place<'_>, color: Rgb) -> Rgb {
        let schlick = |cos: f64| color.mix(Rgb::WHITE, (1.0 - cos).clamp(0.0, 1.0).powi(5));
        let weight = schlick(place.shading.dot(place.outgoing));
        let direction = fresnel::reflect(-place.outgoing, place.shading);
        let next = place.path.next(REFLECTED, f64::INFINITY);
        let reflected = self.follow(place, direction, place.normal, weight, next);
        reflected + self.highlight(place, schlick)
    }

    /// A boundary of a body of glass.
    fn glass(&mut self, place: &Place<'_>, medium: Medium, entering: bool) -> Rgb {
        let media = place.path.media;
        let (_, ior) = self.world.glass(medium.finish);
        let index = |media: &Media| media.top().map_or(1.0, |finish| self.world.glass(finish).1);
        let beyond = if entering { media.entered(medium) } else { media.left(medium.thing) };
        let before = match media.top() {
            // A camera within the glass: the path has never entered what it leaves.
            None if !entering => ior,
            _ => index(&media),
        };
        let behind = index(&beyond);
        let incoming = -place.outgoing;
        let cos = place.normal.dot(place.outgoing).clamp(0.0, 1.0);
        let reflected = place.path.next(REFLECTED, f64::INFINITY);
        let mut refracted = place.path.next(REFRACTED, f64::INFINITY);
        refracted.media = beyond;
        let mirrored = fresnel::reflect(incoming, place.normal);
        let mut sum = Rgb::BLACK;
        if entering && media.len == 0 {
            sum += self.highlight(place, |cos| Rgb::splat(fresnel::from_air(cos, ior)));
        }
        let Some((reflectance, cos_t)) = fresnel::dielectric(cos, before, behind) else {
            return sum + self.follow(place, mirrored, place.normal, Rgb::WHITE, reflected);
        };
        let through = fresnel::refract(incoming, place.normal, before / behind, cos, cos_t);
        let (share, other) = self.shares(place.path, reflectance);
        if share > 0.0 {
            let weight = Rgb::splat(share);
            sum += self.follow(place, mirrored, place.normal, weight, reflected);
        }
        if other > 0.0 {
            sum += self.follow(place, through, -place.normal, Rgb::splat(other), refracted);
        }
        sum
    }

    /// A sheet of glass without thickness.
    fn sheet(&mut self, place: &Place<'_>, ior: f64) -> Rgb {
        let reflectance = |cos: f64| fresnel::sheet(fresnel::from_air(cos, ior));
        let cos = place.normal.dot(place.outgoing).clamp(0.0, 1.0);
        let mut sum = self.highlight(place, |cos| Rgb::splat(reflectance(cos)));
        let (share, other) = self.shares(place.path, reflectance(cos));
        if share > 0.0 {
            let mirrored = fresnel::reflect(-place.outgoing, place.normal);
            let next = place.path.next(REFLECTED, f64::INFINITY);
            sum += self.follow(place, mirrored, place.normal, Rgb::splat(share), next);
        }
        if other > 0.0 {
            let next = place.path.next(REFRACTED, f64::INFINITY);
            sum += self.follow(place, -place.outgoing, -place.normal, Rgb::splat(other), next);
        }
        sum
    }

    /// The weights of reflection and refraction: both, or one of them chosen at random.
    fn shares(&self, path: &Path, reflectance: f64) -> (f64, f64) {
        if path.weight >= SPLIT_WEIGHT {
            (reflectance, 1.0 - reflectance)
        } else if self.sample.single(path.key.child(CHOICE)) < reflectance {
            (1.0, 0.0)
        } else {
            (0.0, 1.0)
        }
    }

    /// The light from a direction on the given side of a place, times `weight`.
    fn follow(
        &mut self,
        place: &Place<'_>,
        direction: Vec3,
        side: Vec3,
        mut weight: Rgb,
        mut next: Path,
    ) -> Rgb {
        if next.depth > self.depth {
            return Rgb::BLACK;
        }
        next.weight *= weight.max_channel();
        let least = ROULETTE_LIGHT * self.world.white / self.world.brightest;
        if next.weight < least {
            let u = self.sample.single(next.key.child(ROULETTE));
            if u * least >= next.weight {
                return Rgb::BLACK;
            }
            weight = weight * (least / next.weight);
            next.weight = least;
        }
        self.statistics.secondary_rays += 1;
        // Rounding may turn a grazing direction to the wrong side, by as little as it is off.
        let off = direction.dot(side);
        let direction = if off < 0.0 { direction - side * (2.0 * off) } else { direction };
        let ray = place.surface.spawn(direction);
        self.radiance(&ray, self.world.closest(&ray), next) * weight
    }

    /// The highlights of the lights that have no body in a perfectly smooth surface.
    fn highlight(&mut self, place: &Place<'_>, reflectance: impl Fn(f64) -> Rgb) -> Rgb {
        if self.world.lamps.is_empty() {
            return Rgb::BLACK;
        }
        let frame = Frame::new(place.shading);
        let mut wo = frame.to_local(place.outgoing);
        wo.z = wo.z.max(f64::MIN_POSITIVE);
        self.direct(place, |incoming| {
            if incoming.pdf < f64::INFINITY {
                return (Rgb::BLACK, Rgb::BLACK);
            }
            let (value, cos) =
                Ggx { alpha: HIGHLIGHT_ALPHA }.reflect(wo, frame.to_local(incoming.direction));
            let light = reflectance(cos) * value;
            (light.map(|v| (v - FAINT_HIGHLIGHT).max(0.0)), Rgb::BLACK)
        })
    }

    /// The light of all lamps, `reflected` by the surface to the viewer: the factor on irradiance
    /// at right angles, and a second one that counts only where the view of the lamp is free.
    fn direct(&mut self, place: &Place<'_>, reflected: impl Fn(&Incoming) -> (Rgb, Rgb)) -> Rgb {
        let mut sum = Rgb::BLACK;
        for (i, lamp) in (0..).zip(&self.world.lamps) {
            if !lamp.has_extent() {
                if let Some(incoming) = lamp.sample(place.surface.point, (0.5, 0.5)) {
                    sum += self.arriving(place, &incoming, &reflected);
                }
                continue;
            }
            let key = place.path.key.child(LAMPS + i);
            sum += self.split(place.path, |tracer, sample| {
                match lamp.sample(place.surface.point, sample.pair(key)) {
                    Some(incoming) => tracer.arriving(place, &incoming, &reflected),
                    None => Rgb::BLACK,
                }
            });
        }
        sum
    }

    /// The mean over the samples that a light with extent gets at this place of the path.
    #[inline]
    fn split(&mut self, path: &Path, mut one: impl FnMut(&mut Self, Sample) -> Rgb) -> Rgb {
        let bits = if path.weight >= FULL_WEIGHT { self.split_bits } else { 0 };
        let mut sum = Rgb::BLACK;
        for part in 0..1 << bits {
            let sample = self.sample.part(part, bits);
            sum += one(self, sample);
        }
        sum / f64::from(1 << bits)
    }

    /// What one sample of a lamp adds.
    #[inline]
    fn arriving(
        &mut self,
        place: &Place<'_>,
        incoming: &Incoming,
        reflected: &impl Fn(&Incoming) -> (Rgb, Rgb),
    ) -> Rgb {
        if !(incoming.direction.dot(place.normal) > 0.0) {
            return Rgb::BLACK;
        }
        let (always, free) = reflected(incoming);
        if always.is_black() && free.is_black() {
            return Rgb::BLACK;
        }
        let ray = incoming.sight(place.surface);
        self.statistics.shadow_rays += 1;
        let passed = self.world.transmittance(&ray);
        if passed == Rgb::WHITE {
            incoming.light * (always + free)
        } else if passed.is_black() {
            Rgb::BLACK
        } else {
            incoming.light * passed * always
        }
    }

    /// The light of the sky on a diffuse surface, whose reflectance depends on the cosine.
    fn sky_light(&mut self, place: &Place<'_>, reflectance: impl Fn(f64) -> Rgb) -> Rgb {
        if self.world.sky.is_black() {
            return Rgb::BLACK;
        }
        let key = place.path.key.child(SKY);
        let frame = Frame::new(place.shading);
        self.split(place.path, |tracer, sample| {
            let sky = &tracer.world.sky;
            let mut u = sample.pair(key);
            // Of a picture half of the directions are chosen by its light; the density is that of both
            // ways together (Veach and Guibas 1995).
            let by_light = sky.is_picture() && u.1 < 0.5;
            if sky.is_picture() {
                u.1 = (2.0 * u.1).fract();
            }
            let direction = match by_light {
                true => sky.sample(u).map(|found| found.direction),
                false => Some(frame.to_world(warp::cosine_hemisphere(u))),
            };
            let Some(direction) = direction else { return Rgb::BLACK };
            let cos = direction.dot(place.shading);
            // At the very horizon rounding decides on which side the direction lies.
            if !(cos > 0.0 && direction.dot(place.normal) > 0.0) {
                return Rgb::BLACK;
            }
            let even = cos * core::f64::consts::FRAC_1_PI;
            let weight =
                if sky.is_picture() { 2.0 * even / (even + sky.pdf(direction)) } else { 1.0 };
            let light = sky.radiance(direction) * reflectance(cos) * weight;
            if light.is_black() {
                return Rgb::BLACK;
            }
            tracer.statistics.shadow_rays += 1;
            light * tracer.world.transmittance(&place.surface.spawn(direction))
        })
    }
}

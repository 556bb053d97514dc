//! Opaque surfaces in layers, from the top: fuzz, a clear coat, and a base that is metal, or scatters light
//! evenly under its own gloss, or both in parts (after the OpenPBR surface, version 1.1).
//!
//! Each layer is lit by what those above let through on the way in and on the way out, (1 - E(o)) (1 - E(i)).
//! What all these lobes together miss of a white surface is known from a table, and an even lobe returns it
//! in the base's colour ([`Albedo::rest`]). So light is neither gained nor lost, and can be followed both ways.

use rondure::Vec3;

use super::{
    Kind, Lobe, Metal, Parts, Scatter,
    albedo::{Albedo, Place},
    metal::Curve,
};
use crate::{color::Rgb, fresnel, warp};

/// A dielectric boundary that reflects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gloss {
    /// The factor on its reflectance, from 0 to 1.
    pub(crate) strength: f64,
    pub(crate) ior: f64,
    pub(crate) lobe: Lobe,
}

impl Gloss {
    #[inline]
    fn fresnel(&self, cos: f64) -> f64 {
        self.strength * fresnel::from_air(cos, self.ior)
    }
}

/// Fine fibres that stand up: velvet, peach skin, dust (Estevez and Kulla 2017, "Production Friendly
/// Microfacet Sheen BRDF").
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fuzz {
    pub(crate) color: Rgb,
    pub(crate) weight: f64,
    pub(crate) roughness: f64,
}

impl Fuzz {
    /// The value of white fuzz times the cosine.
    #[inline]
    fn reflect(&self, wo: Vec3, wi: Vec3) -> f64 {
        let half = (wo + wi).normalized();
        let sin = ((1.0 - half.z) * (1.0 + half.z)).max(0.0).sqrt();
        let exponent = 1.0 / self.roughness;
        let density = (2.0 + exponent) * sin.powf(exponent) * 0.5 * core::f64::consts::FRAC_1_PI;
        self.weight * density * wi.z / (4.0 * (wo.z + wi.z - wo.z * wi.z))
    }
}

/// The parts of a surface, before its tables are made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layers {
    pub(crate) fuzz: Option<Fuzz>,
    pub(crate) coat: Option<Gloss>,
    /// What the coat leaves of the light that goes through it and back.
    pub(crate) coat_color: Rgb,
    /// The gloss of the base; its lobe is that of the metal too.
    pub(crate) gloss: Gloss,
    /// The share of the base that is metal, from 0 to 1.
    pub(crate) metalness: f64,
    pub(crate) metal: Metal,
}

/// A surface in layers.
#[derive(Clone, Debug)]
pub(crate) struct Layered {
    layers: Layers,
    /// What fuzz and coat return by themselves.
    fuzz_alone: Albedo,
    coat_alone: Albedo,
    /// What coat and base return under the layers above them, and all together, were they white.
    coat: Albedo,
    base: Albedo,
    all: Albedo,
    /// The mean albedo of a white metal, before what bounces twice between its microfacets.
    metal_alone: f64,
    /// The mean reflectance of a measured metal, which takes long to find.
    measured_mean: Rgb,
    /// And the reflectance itself.
    measured: Option<Curve>,
    is_even: bool,
}

/// The probabilities of the lobes.
#[derive(Clone, Copy, Debug)]
struct Shares {
    fuzz: f64,
    coat: f64,
    base: f64,
    rest: f64,
}

impl Layered {
    pub(crate) fn new(mut layers: Layers) -> Self {
        let fuzz_alone = match &mut layers.fuzz {
            Some(fuzz) => {
                // Where the light grazes, the model would return more than there is.
                let peak = (1..=16).map(|i| sum_of_fuzz(fuzz, f64::from(i) / 16.0));
                fuzz.weight /= peak.fold(1.0, f64::max);
                let fuzz = *fuzz;
                Albedo::from_fn(|cos| sum_of_fuzz(&fuzz, cos))
            }
            None => Albedo::zero(),
        };
        let coat_alone = match layers.coat {
            Some(coat) => reflected(coat.lobe, |cos| coat.fresnel(cos), |_, _| 1.0),
            None => Albedo::zero(),
        };
        let fuzz_through = |o: f64, i: f64| fuzz_alone.missing(o) * fuzz_alone.missing(i);
        let coat = match layers.coat {
            Some(coat) => reflected(coat.lobe, |cos| coat.fresnel(cos), fuzz_through),
            None => Albedo::zero(),
        };
        let through =
            |o: f64, i: f64| fuzz_through(o, i) * coat_alone.missing(o) * coat_alone.missing(i);
        let Layers { gloss, metalness, .. } = layers;
        let white = |cos| (1.0 - metalness) * gloss.fresnel(cos) + metalness;
        let base = reflected(gloss.lobe, white, through);
        let all = Albedo::from_fn(|cos| fuzz_alone.get(cos) + coat.get(cos) + base.get(cos));
        // Tables take time: what is all metal has this one already, what is none needs none.
        let is_bare = layers.coat.is_none() && layers.fuzz.is_none();
        let metal_alone = if metalness == 0.0 || (metalness == 1.0 && is_bare) {
            base.mean()
        } else {
            reflected(gloss.lobe, |_| 1.0, |_, _| 1.0).mean()
        };
        let is_even = layers.fuzz.is_none()
            && layers.coat.is_none()
            && layers.coat_color == Rgb::WHITE
            && gloss.strength == 0.0
            && metalness == 0.0;
        let measured_mean = layers.metal.mean(Rgb::WHITE);
        Self {
            layers,
            fuzz_alone,
            coat_alone,
            coat,
            base,
            all,
            metal_alone,
            measured_mean,
            measured: layers.metal.is_measured().then(|| Curve::new(&layers.metal)),
            is_even,
        }
    }

    /// Whether some lobe is of a kind.
    pub(crate) fn has(&self, kind: Kind) -> bool {
        let Layers { coat, gloss, metalness, .. } = &self.layers;
        let base = (gloss.strength > 0.0 || *metalness > 0.0).then_some(gloss.lobe);
        let lobes = [coat.map(|coat| coat.lobe), base];
        // What the others miss is always wide, unless nothing is missing.
        (kind == Kind::Wide && self.all.mean() < 1.0)
            || lobes.iter().flatten().any(|lobe| lobe.kind() == kind)
    }

    /// The share of the light that narrow lobes return, on average.
    pub(crate) fn narrow_albedo(&self) -> f64 {
        let Layers { coat, gloss, .. } = &self.layers;
        let narrow = |lobe: Lobe, albedo: &Albedo| {
            if lobe.kind() == Kind::Narrow { albedo.mean() } else { 0.0 }
        };
        coat.map_or(0.0, |coat| narrow(coat.lobe, &self.coat)) + narrow(gloss.lobe, &self.base)
    }

    /// The light that layers above the coat, and above the base, let through both ways.
    #[inline]
    fn through_fuzz(&self, o: f64, i: f64) -> f64 {
        match self.layers.fuzz {
            Some(_) => self.fuzz_alone.missing(o) * self.fuzz_alone.missing(i),
            None => 1.0,
        }
    }

    #[inline]
    fn through_coat(&self, o: f64, i: f64) -> f64 {
        match self.layers.coat {
            Some(_) => self.coat_alone.missing(o) * self.coat_alone.missing(i),
            None => 1.0,
        }
    }

    /// The reflectance of the base's metal.
    #[inline]
    fn reflectance(&self, cos: f64, color: Rgb) -> Rgb {
        match &self.measured {
            Some(curve) => curve.at(cos),
            None => self.layers.metal.reflectance(cos, color),
        }
    }

    /// The reflectance of the base's microfacets.
    #[inline]
    fn base_fresnel(&self, cos: f64, color: Rgb) -> Rgb {
        let Layers { gloss, metalness, .. } = &self.layers;
        let mut sum = Rgb::BLACK;
        if *metalness < 1.0 {
            sum = Rgb::splat((1.0 - metalness) * gloss.fresnel(cos));
        }
        if *metalness > 0.0 {
            sum += self.reflectance(cos, color) * *metalness;
        }
        sum
    }

    /// The colour of the lobe that returns what the others miss.
    #[inline]
    fn rest_color(&self, color: Rgb) -> Rgb {
        let Layers { metalness, metal, coat_color, .. } = &self.layers;
        let mut sum = color * (1.0 - metalness);
        if *metalness > 0.0 {
            // Once more reflected after each bounce between the microfacets (Kulla and Conty 2017).
            let mean = match metal {
                Metal::Tinted => metal.mean(color),
                Metal::Measured { .. } => self.measured_mean,
            };
            let alone = self.metal_alone;
            let again =
                |f: f64| if f < 1.0 { f * f * alone / (1.0 - f * (1.0 - alone)) } else { 1.0 };
            sum += mean.map(again) * *metalness;
        }
        sum * *coat_color
    }

    /// The surface as it is seen from `wo`, on the upper side, where it has this colour.
    #[inline]
    pub(crate) fn facing(&self, wo: Vec3, color: Rgb) -> Facing<'_> {
        let (shares, missing, root) = if self.is_even {
            (None, 0.0, 0.0)
        } else {
            let place = Albedo::place(wo.z);
            let missing = 1.0 - self.all.at(place);
            let root = match self.layers.gloss.lobe {
                Lobe::Rough(ggx) => ggx.root(wo.z),
                Lobe::Smooth => 0.0,
            };
            (self.shares(wo.z, place, missing, color), missing, root)
        };
        Facing { all: self, wo, color, shares, missing, root }
    }

    #[inline]
    fn shares(&self, cos: f64, place: Place, missing: f64, color: Rgb) -> Option<Shares> {
        let Layers { fuzz, coat, metalness, .. } = &self.layers;
        let metal = if *metalness > 0.0 {
            1.0 - metalness + metalness * self.reflectance(cos, color).max_channel()
        } else {
            1.0
        };
        let shares = Shares {
            fuzz: fuzz.map_or(0.0, |f| self.fuzz_alone.at(place) * f.color.max_channel()),
            coat: coat.map_or(0.0, |_| self.coat.at(place)),
            base: self.base.at(place) * metal,
            rest: missing * self.rest_color(color).max_channel(),
        };
        let sum = shares.fuzz + shares.coat + shares.base + shares.rest;
        (sum > 0.0).then(|| {
            let part = 1.0 / sum;
            Shares {
                fuzz: shares.fuzz * part,
                coat: shares.coat * part,
                base: shares.base * part,
                rest: shares.rest * part,
            }
        })
    }

    /// What a surface of this colour sends to `wo` of the light from `wi`; see [`Facing::evaluate`].
    #[cfg(test)]
    pub(crate) fn evaluate(&self, wo: Vec3, wi: Vec3, color: Rgb) -> Parts {
        self.facing(wo, color).evaluate(wi)
    }

    /// A direction; see [`Facing::sample`].
    #[cfg(test)]
    pub(crate) fn sample(
        &self,
        wo: Vec3,
        color: Rgb,
        choice: f64,
        u: (f64, f64),
    ) -> Option<Scatter> {
        self.facing(wo, color).sample(choice, u)
    }
}

/// A surface in layers, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing<'a> {
    all: &'a Layered,
    wo: Vec3,
    color: Rgb,
    /// `None` if it sends nothing there, and where it is even.
    shares: Option<Shares>,
    /// What all lobes miss.
    missing: f64,
    /// The root in the masking of the base's microfacets.
    root: f64,
}

impl Facing<'_> {
    /// The colour of a surface that scatters evenly.
    #[inline]
    pub(crate) fn even_color(&self) -> Option<Rgb> {
        self.all.is_even.then_some(self.color)
    }

    /// Whether some of the lobes are wide.
    #[inline]
    pub(crate) fn is_wide(&self) -> bool {
        self.all.has(Kind::Wide)
    }

    /// What the surface sends on of the light from `wi` on the upper side; perfect mirrors send nothing.
    #[inline]
    pub(crate) fn evaluate(&self, wi: Vec3) -> Parts {
        if self.all.is_even {
            let mut parts = Parts::default();
            if self.wo.z > 0.0 && wi.z > 0.0 {
                let even = wi.z * core::f64::consts::FRAC_1_PI;
                parts.add(Kind::Wide, self.color * even, even);
            }
            return parts;
        }
        match self.shares {
            Some(shares) => self.value(shares, wi),
            None => Parts::default(),
        }
    }

    fn value(&self, shares: Shares, wi: Vec3) -> Parts {
        let mut parts = Parts::default();
        let &Self { all, wo, color, .. } = self;
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return parts;
        }
        let even = wi.z * core::f64::consts::FRAC_1_PI;
        let Layers { fuzz, coat, coat_color, gloss, .. } = &all.layers;
        if let Some(fuzz) = fuzz {
            parts.add(Kind::Wide, fuzz.color * fuzz.reflect(wo, wi), shares.fuzz * even);
        }
        let through_fuzz = all.through_fuzz(wo.z, wi.z);
        if let Some(coat) = coat
            && let Lobe::Rough(ggx) = coat.lobe
        {
            let found = ggx.reflect_and_pdf(wo, wi, ggx.root(wo.z));
            let light = Rgb::splat(found.value * coat.fresnel(found.cos) * through_fuzz);
            parts.add(coat.lobe.kind(), light, shares.coat * found.pdf);
        }
        if let Lobe::Rough(ggx) = gloss.lobe
            && shares.base > 0.0
        {
            let found = ggx.reflect_and_pdf(wo, wi, self.root);
            let through = through_fuzz * all.through_coat(wo.z, wi.z);
            let light = all.base_fresnel(found.cos, color) * *coat_color * (found.value * through);
            parts.add(gloss.lobe.kind(), light, shares.base * found.pdf);
        }
        if shares.rest > 0.0 {
            let rest = all.rest_color(color) * (all.all.rest_of(self.missing, wi.z) * wi.z);
            parts.add(Kind::Wide, rest, shares.rest * even);
        }
        parts
    }

    /// The part of the choices in [`sample`](Self::sample) that scatter evenly; the others reflect.
    #[inline]
    pub(crate) fn split(&self) -> Option<f64> {
        self.shares.map(|shares| shares.rest + shares.fuzz)
    }

    /// A direction above a point of the unit disk, of a surface that scatters [evenly](Self::even_color).
    #[inline]
    pub(crate) fn sample_even(&self, disk: (f64, f64)) -> Option<Scatter> {
        let (direction, weight) = (warp::above_disk(disk), self.color);
        let pdf = direction.z * core::f64::consts::FRAC_1_PI;
        let good = pdf > 0.0 && !weight.is_black();
        good.then_some(Scatter { direction, weight, pdf, kind: Kind::Wide })
    }

    /// A direction, chosen about in proportion to the light that it sends.
    pub(crate) fn sample(&self, choice: f64, u: (f64, f64)) -> Option<Scatter> {
        let &Self { all, wo, color, .. } = self;
        if all.is_even {
            return self.sample_even(warp::disk(u));
        }
        let shares = self.shares?;
        let Layers { coat, coat_color, gloss, .. } = &all.layers;
        let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
        let perfect = |weight| {
            let pdf = f64::INFINITY;
            Some(Scatter { direction: mirrored, weight, pdf, kind: Kind::Narrow })
        };
        let rest_or_fuzz = shares.rest + shares.fuzz;
        let (direction, kind) = if choice < rest_or_fuzz {
            (warp::cosine_hemisphere(u), Kind::Wide)
        } else {
            let in_coat = choice < rest_or_fuzz + shares.coat;
            let lobe = match coat {
                Some(coat) if in_coat => coat.lobe,
                _ => gloss.lobe,
            };
            match lobe {
                Lobe::Smooth => {
                    let through_fuzz = all.through_fuzz(wo.z, wo.z);
                    return match coat {
                        Some(coat) if in_coat => {
                            perfect(Rgb::splat(coat.fresnel(wo.z) * through_fuzz / shares.coat))
                        }
                        _ => {
                            let through = through_fuzz * all.through_coat(wo.z, wo.z);
                            let light = all.base_fresnel(wo.z, color) * *coat_color;
                            perfect(light * (through / shares.base))
                        }
                    };
                }
                Lobe::Rough(ggx) => (ggx.direction(wo, u)?.0, lobe.kind()),
            }
        };
        let parts = self.value(shares, direction);
        let part = parts.of(kind);
        (part.pdf > 0.0).then(|| Scatter {
            direction,
            weight: part.value / part.pdf,
            pdf: part.pdf,
            kind,
        })
    }
}

fn towards(cos: f64) -> Vec3 {
    Vec3::new(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos)
}

/// The albedo of a lobe under layers that let `through` pass.
fn reflected(
    lobe: Lobe,
    fresnel: impl Fn(f64) -> f64,
    through: impl Fn(f64, f64) -> f64,
) -> Albedo {
    match lobe {
        Lobe::Smooth => Albedo::from_fn(|cos| fresnel(cos) * through(cos, cos)),
        Lobe::Rough(ggx) => Albedo::integrate(|cos, u| {
            ggx.sample(towards(cos), u)
                .map_or(0.0, |(wi, half, masked)| masked * fresnel(half) * through(cos, wi.z))
        }),
    }
}

/// The albedo of white fuzz.
fn sum_of_fuzz(fuzz: &Fuzz, cos: f64) -> f64 {
    const STEPS: u32 = 48;
    let wo = towards(cos);
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    let cells = (0..STEPS * STEPS).map(|i| (at(i % STEPS), at(i / STEPS)));
    let sum: f64 = cells
        .map(warp::cosine_hemisphere)
        .filter(|wi| wi.z > 0.0)
        .map(|wi| fuzz.reflect(wo, wi) * core::f64::consts::PI / wi.z)
        .sum();
    sum / f64::from(STEPS * STEPS)
}

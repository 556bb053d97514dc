//! Opaque surfaces in layers, from the top: fuzz, a clear coat, and a base that is metal, or scatters light
//! evenly under its own gloss, or both in parts (after the OpenPBR surface, version 1.1).
//!
//! Each layer is lit by what those above let through on the way in and on the way out, (1 - E(o)) (1 - E(i)).
//! What all these lobes together miss of a white surface is known from a table, and an even lobe returns it
//! in the base's colour ([`Albedo::rest`]). So light is neither gained nor lost, and can be followed both ways.

use rondure::Vec3;

use super::{Kind, Lobe, Metal, Parts, Scatter, albedo::Albedo};
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
        let metal_alone = reflected(gloss.lobe, |_| 1.0, |_, _| 1.0).mean();
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

    /// The reflectance of the base's microfacets.
    #[inline]
    fn base_fresnel(&self, cos: f64, color: Rgb) -> Rgb {
        let Layers { gloss, metalness, metal, .. } = &self.layers;
        let mut sum = Rgb::splat((1.0 - metalness) * gloss.fresnel(cos));
        if *metalness > 0.0 {
            sum += metal.reflectance(cos, color) * *metalness;
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

    /// Whether there is nothing but a base that scatters evenly (Lambert).
    #[inline]
    pub(crate) fn is_even(&self) -> bool {
        self.is_even
    }

    #[inline]
    fn shares(&self, cos: f64, color: Rgb) -> Option<Shares> {
        let Layers { fuzz, metalness, .. } = &self.layers;
        let metal = if *metalness > 0.0 {
            1.0 - metalness + metalness * self.layers.metal.reflectance(cos, color).max_channel()
        } else {
            1.0
        };
        let shares = Shares {
            fuzz: fuzz.map_or(0.0, |fuzz| self.fuzz_alone.get(cos) * fuzz.color.max_channel()),
            coat: self.coat.get(cos),
            base: self.base.get(cos) * metal,
            rest: self.all.missing(cos) * self.rest_color(color).max_channel(),
        };
        let sum = shares.fuzz + shares.coat + shares.base + shares.rest;
        (sum > 0.0).then(|| Shares {
            fuzz: shares.fuzz / sum,
            coat: shares.coat / sum,
            base: shares.base / sum,
            rest: shares.rest / sum,
        })
    }

    /// What a surface of this colour sends to `wo` of the light from `wi`, both on the upper side; perfect
    /// mirrors send nothing.
    #[inline]
    pub(crate) fn evaluate(&self, wo: Vec3, wi: Vec3, color: Rgb) -> Parts {
        if self.is_even {
            let mut parts = Parts::default();
            if wo.z > 0.0 && wi.z > 0.0 {
                let even = wi.z * core::f64::consts::FRAC_1_PI;
                parts.add(Kind::Wide, color * even, even);
            }
            return parts;
        }
        match self.shares(wo.z, color) {
            Some(shares) => self.value(shares, wo, wi, color),
            None => Parts::default(),
        }
    }

    fn value(&self, shares: Shares, wo: Vec3, wi: Vec3, color: Rgb) -> Parts {
        let mut parts = Parts::default();
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return parts;
        }
        let even = wi.z * core::f64::consts::FRAC_1_PI;
        let Layers { fuzz, coat, coat_color, gloss, .. } = &self.layers;
        if let Some(fuzz) = fuzz {
            parts.add(Kind::Wide, fuzz.color * fuzz.reflect(wo, wi), shares.fuzz * even);
        }
        let through_fuzz = self.through_fuzz(wo.z, wi.z);
        if let Some(coat) = coat
            && let Lobe::Rough(ggx) = coat.lobe
        {
            let (value, cos) = ggx.reflect(wo, wi);
            let light = Rgb::splat(value * coat.fresnel(cos) * through_fuzz);
            parts.add(coat.lobe.kind(), light, shares.coat * ggx.pdf(wo, wi));
        }
        if let Lobe::Rough(ggx) = gloss.lobe
            && shares.base > 0.0
        {
            let (value, cos) = ggx.reflect(wo, wi);
            let through = through_fuzz * self.through_coat(wo.z, wi.z);
            let light = self.base_fresnel(cos, color) * *coat_color * (value * through);
            parts.add(gloss.lobe.kind(), light, shares.base * ggx.pdf(wo, wi));
        }
        let rest = self.rest_color(color) * (self.all.rest(wo.z, wi.z) * wi.z);
        parts.add(Kind::Wide, rest, shares.rest * even);
        parts
    }

    /// The part of the choices in [`sample`](Self::sample) that scatter evenly; the others reflect.
    pub(crate) fn split(&self, cos: f64, color: Rgb) -> Option<f64> {
        if self.is_even {
            return None;
        }
        self.shares(cos, color).map(|shares| shares.rest + shares.fuzz)
    }

    /// A direction, chosen about in proportion to the light that it sends.
    pub(crate) fn sample(
        &self,
        wo: Vec3,
        color: Rgb,
        choice: f64,
        u: (f64, f64),
    ) -> Option<Scatter> {
        if self.is_even {
            let direction = warp::cosine_hemisphere(u);
            let pdf = direction.z * core::f64::consts::FRAC_1_PI;
            let good = pdf > 0.0 && !color.is_black();
            return good.then_some(Scatter { direction, weight: color, pdf, kind: Kind::Wide });
        }
        let shares = self.shares(wo.z, color)?;
        let Layers { coat, coat_color, gloss, .. } = &self.layers;
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
                    let through_fuzz = self.through_fuzz(wo.z, wo.z);
                    return match coat {
                        Some(coat) if in_coat => {
                            perfect(Rgb::splat(coat.fresnel(wo.z) * through_fuzz / shares.coat))
                        }
                        _ => {
                            let through = through_fuzz * self.through_coat(wo.z, wo.z);
                            let light = self.base_fresnel(wo.z, color) * *coat_color;
                            perfect(light * (through / shares.base))
                        }
                    };
                }
                Lobe::Rough(ggx) => (ggx.sample(wo, u)?.0, lobe.kind()),
            }
        };
        let parts = self.value(shares, wo, direction, color);
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

//! The clear coat of a glossy surface: a rough or smooth dielectric over a coloured base.
//!
//! The rough coat is made of microfacets ([`Ggx`]). What the coat does not reflect reaches the base: the base is
//! weighted by what the coat lets through on the way in and on the way out (Kelemen and
//! Szirmay-Kalos 2001), so that no more light leaves than came, and with a white base all of it.
//!
//! Directions here are in the frame of the surface: z is the normal, on the viewer's side.

use rondure::Vec3;

use crate::{bsdf::Ggx, fresnel};

/// The index of refraction of the coat: that of glaze, lacquer and most plastics.
const INDEX: f64 = 1.5;
/// Below this width alpha the coat counts as a mirror: the lobe is narrower than a pixel of a
/// picture 1000 pixels wide at 60 degrees.
const MIRROR_ALPHA: f64 = 1e-3;
/// The least width alpha of the highlight of a light that has no body, a point or a sun: a perfect
/// mirror would show nothing of it.
pub(crate) const HIGHLIGHT_ALPHA: f64 = 0.02;
/// The steps of the table of reflectances.
const STEPS: usize = 64;

/// A clear coat.
#[derive(Clone, Debug)]
pub(crate) struct Coat {
    strength: f64,
    /// The lobe; `None` if the coat is a mirror.
    lobe: Option<Ggx>,
    /// The reflectance of the coat over the root of the cosine.
    albedo: Vec<f64>,
    /// The mean of the reflectance over all directions.
    mean_albedo: f64,
}

/// What [`Coat::sample`] finds.
pub(crate) struct Reflection {
    pub(crate) direction: Vec3,
    pub(crate) weight: f64,
    /// The density of the direction by solid angle; infinite for a mirror.
    pub(crate) pdf: f64,
}

impl Coat {
    /// `strength` is the factor on the reflectance of a real coat, from 0 to 1; `roughness` is the
    /// root of the width alpha of the lobe.
    pub(crate) fn new(strength: f64, roughness: f64) -> Self {
        let strength = strength.clamp(0.0, 1.0);
        let alpha = roughness.clamp(0.0, 1.0).powi(2);
        let lobe = (alpha >= MIRROR_ALPHA).then_some(Ggx { alpha });
        let at = |i: usize| (i as f64 / STEPS as f64).powi(2);
        let albedo: Vec<_> = (0..=STEPS).map(|i| strength * reflectance(lobe, at(i))).collect();
        let mut coat = Self { strength, lobe, albedo, mean_albedo: 0.0 };
        let n = 8 * STEPS;
        coat.mean_albedo = (0..n)
            .map(|i| ((i as f64 + 0.5) / n as f64).sqrt())
            .map(|cos| coat.albedo(cos))
            .sum::<f64>()
            / n as f64;
        coat
    }

    /// The share of the light from a direction that the coat reflects.
    #[inline]
    fn albedo(&self, cos: f64) -> f64 {
        let place = cos.clamp(0.0, 1.0).sqrt() * STEPS as f64;
        let i = (place as usize).min(STEPS - 1);
        let (a, b) = (self.albedo[i], self.albedo[i + 1]);
        a + (b - a) * (place - i as f64)
    }

    /// The coat as it is seen from a direction.
    #[inline]
    pub(crate) fn facing(&self, wo: Vec3) -> Facing<'_> {
        // A coat that reflects everything leaves nothing for the base.
        let through = 1.0 - self.mean_albedo;
        let base = if through > 0.0 { (1.0 - self.albedo(wo.z)) / through } else { 0.0 };
        let alpha = self.lobe.map_or(0.0, |lobe| lobe.alpha).max(HIGHLIGHT_ALPHA);
        let highlight = Ggx { alpha };
        Facing { coat: self, wo, base, highlight, root_o: highlight.root(wo.z) }
    }

    #[inline]
    fn fresnel(&self, cos: f64) -> f64 {
        self.strength * fresnel::from_air(cos, INDEX)
    }

    /// The highlight of a light with a body, found with the density `light_pdf`: the value of the
    /// lobe times the cosine, less what [`sample`](Self::sample) is better at (Veach's power
    /// heuristic). A mirror coat sees such lights by its reflection alone.
    #[inline]
    pub(crate) fn shared_highlight(&self, wo: Vec3, wi: Vec3, light_pdf: f64) -> f64 {
        let Some(lobe) = self.lobe else { return 0.0 };
        let (value, cos) = lobe.reflect(wo, wi);
        value * self.fresnel(cos) * power_heuristic(light_pdf, lobe.pdf(wo, wi))
    }

    /// A direction of reflection and its share of the light.
    #[inline]
    pub(crate) fn sample(&self, wo: Vec3, u: (f64, f64)) -> Option<Reflection> {
        let Some(lobe) = self.lobe else {
            let direction = Vec3::new(-wo.x, -wo.y, wo.z);
            let weight = self.fresnel(wo.z);
            return Some(Reflection { direction, weight, pdf: f64::INFINITY });
        };
        let (direction, cos, masked) = lobe.sample(wo, u)?;
        let weight = self.fresnel(cos) * masked;
        Some(Reflection { direction, weight, pdf: lobe.pdf(wo, direction) })
    }

    /// Whether the reflection needs random numbers.
    pub(crate) fn is_rough(&self) -> bool {
        self.lobe.is_some()
    }
}

/// A coat seen from a direction.
pub(crate) struct Facing<'a> {
    coat: &'a Coat,
    wo: Vec3,
    /// What the coat lets through towards there.
    base: f64,
    highlight: Ggx,
    root_o: f64,
}

impl Facing<'_> {
    /// The factor on the reflected light of the base for a light at the cosine `cos_i`.
    #[inline]
    pub(crate) fn base(&self, cos_i: f64) -> f64 {
        self.base * (1.0 - self.coat.albedo(cos_i))
    }

    /// The highlight of a light without a body: the value of the lobe times the cosine.
    #[inline]
    pub(crate) fn highlight(&self, wi: Vec3) -> f64 {
        let found = self.highlight.reflect_and_pdf(self.wo, wi, self.root_o);
        found.value * self.coat.fresnel(found.cos)
    }
}

/// The weight of the first of two ways to find the same light.
#[inline]
pub(crate) fn power_heuristic(pdf: f64, other: f64) -> f64 {
    if pdf == f64::INFINITY {
        return 1.0;
    }
    let (square, both) = (pdf * pdf, pdf * pdf + other * other);
    if both > f64::MIN_POSITIVE && both < f64::INFINITY {
        return square / both;
    }
    // Where squares are no numbers any more.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

/// The share of the light at the cosine `cos` that a lobe of full strength reflects, by summing
/// over evenly spread visible normals.
fn reflectance(lobe: Option<Ggx>, cos: f64) -> f64 {
    const SAMPLES: u32 = 512;
    // The additive recurrence of the plastic number: evenly spread in the square.
    const STEP: (f64, f64) = (0.754_877_666_246_692_8, 0.569_840_290_998_053_2);
    let Some(lobe) = lobe else { return fresnel::from_air(cos, INDEX) };
    // At 0 the limit is taken from a little above, where a direction is still defined.
    let cos = cos.max(0.25 / (STEPS * STEPS) as f64);
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let one = |i: u32| {
        let at = f64::from(i) + 0.5;
        let u = ((at * STEP.0).fract(), (at * STEP.1).fract());
        lobe.sample(wo, u).map_or(0.0, |(_, cos, masked)| masked * fresnel::from_air(cos, INDEX))
    };
    (0..SAMPLES).map(one).sum::<f64>() / f64::from(SAMPLES)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::warp;

    fn grid(n: u32) -> impl Iterator<Item = (f64, f64)> {
        let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n * n).map(move |i| (at(i % n), at(i / n)))
    }

    fn towards(cos: f64) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    #[test]
    fn coat_and_white_base_return_all_light() {
        for (strength, roughness) in [(1.0, 0.0), (1.0, 0.3), (0.5, 0.6), (1.0, 1.0), (0.0, 0.2)] {
            let coat = Coat::new(strength, roughness);
            for cos in [0.02, 0.1, 0.3, 0.7, 1.0] {
                let wo = towards(cos);
                let n = 128;
                let sum: f64 = grid(n)
                    .map(|u| {
                        let base = coat.facing(wo).base(warp::cosine_hemisphere(u).z);
                        base + coat.sample(wo, u).map_or(0.0, |s| s.weight)
                    })
                    .sum();
                let total = sum / f64::from(n * n);
                assert!((total - 1.0).abs() < 4e-3, "{strength} {roughness} {cos}: {total}");
            }
        }
    }

    #[test]
    fn highlight_holds_the_energy_of_the_reflection() {
        let coat = Coat::new(1.0, 0.5);
        let wo = towards(0.8);
        let n = 512;
        let by_light =
            grid(n).map(|u| TAU * coat.facing(wo).highlight(warp::cap(u, 1.0))).sum::<f64>()
                / f64::from(n * n);
        let by_lobe = grid(n).filter_map(|u| coat.sample(wo, u)).map(|s| s.weight).sum::<f64>()
            / f64::from(n * n);
        assert!((by_light - by_lobe).abs() < 1e-3 * by_lobe, "{by_light} {by_lobe}");
    }
}

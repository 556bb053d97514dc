//! Boundaries between clear media, smooth or rough (Walter et al. 2007).
//!
//! What rough microfacets keep, since light that bounces twice between them is not followed, two even lobes
//! return, one on each side (Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks").

use core::f64::consts::FRAC_1_PI;

use rondure::Vec3;

use super::{Ggx, Kind, Lobe, Part, Scatter, albedo::Albedo};
use crate::{color::Rgb, fresnel, warp};

/// The microfacets of a rough boundary between air and glass.
#[derive(Clone, Debug)]
pub(crate) struct Roughness {
    ggx: Ggx,
    ior: f64,
    /// What leaves again, on either side, of light that comes from the air, and from the glass.
    sides: [Albedo; 2],
}

impl Roughness {
    /// `None` if the boundary is smooth.
    pub(crate) fn new(roughness: f64, ior: f64) -> Option<Self> {
        let Lobe::Rough(ggx) = Lobe::new(roughness) else { return None };
        let side = |before: f64, behind: f64| {
            Albedo::integrate(|cos, u| {
                let wo = Vec3::new(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos);
                let facet = Facet::new(ggx.visible_normal(wo, u), wo, before, behind);
                let reflected = ggx.masked(wo, facet.mirrored(wo)) * facet.reflectance;
                let refracted = facet.refracted(wo).map_or(0.0, |wi| ggx.shadowing(wi.z));
                reflected + (1.0 - facet.reflectance) * refracted
            })
        };
        Some(Self { ggx, ior, sides: [side(1.0, ior), side(ior, 1.0)] })
    }
}

/// A rough boundary, seen from the side of the ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boundary<'a> {
    /// The indices of refraction before it and behind it.
    pub(crate) before: f64,
    pub(crate) behind: f64,
    pub(crate) roughness: &'a Roughness,
}

/// A smooth boundary, seen at a cosine from the side of the ray. It needs no frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smooth {
    pub(crate) reflectance: f64,
    cos: f64,
    /// The ratio of the indices, before over behind, and the cosine beyond.
    eta: f64,
    cos_t: f64,
}

impl Smooth {
    #[inline]
    pub(crate) fn new(before: f64, behind: f64, cos: f64) -> Self {
        let (reflectance, cos_t) = fresnel::dielectric(cos, before, behind).unwrap_or((1.0, 0.0));
        Self { reflectance, cos, eta: before / behind, cos_t }
    }

    /// A direction, and whether it leads to the other side; `normal` is that on the side of the ray, of the direction
    /// `outgoing`.
    #[inline]
    pub(crate) fn sample(&self, normal: Vec3, outgoing: Vec3, choice: f64) -> (Vec3, bool) {
        if choice < self.reflectance {
            (normal * (2.0 * self.cos) - outgoing, false)
        } else {
            (normal * (self.eta * self.cos - self.cos_t) - outgoing * self.eta, true)
        }
    }
}

/// A microfacet.
struct Facet {
    normal: Vec3,
    /// The cosine with the viewer.
    cos: f64,
    reflectance: f64,
    /// The ratio of the indices, and the cosine beyond; `None` where all is reflected.
    beyond: Option<(f64, f64)>,
}

impl Facet {
    #[inline]
    fn new(normal: Vec3, wo: Vec3, before: f64, behind: f64) -> Self {
        let cos = normal.dot(wo).clamp(0.0, 1.0);
        let split = fresnel::dielectric(cos, before, behind);
        Self {
            normal,
            cos,
            reflectance: split.map_or(1.0, |(reflectance, _)| reflectance),
            beyond: split.map(|(_, cos_t)| (before / behind, cos_t)),
        }
    }

    #[inline]
    fn mirrored(&self, wo: Vec3) -> Vec3 {
        self.normal * (2.0 * self.cos) - wo
    }

    #[inline]
    fn refracted(&self, wo: Vec3) -> Option<Vec3> {
        let (eta, cos_t) = self.beyond?;
        Some(fresnel::refract(-wo, self.normal, eta, self.cos, cos_t)).filter(|wi| wi.z < 0.0)
    }
}

impl Boundary<'_> {
    /// The microfacets and the tables of both sides, the viewer's first; for a boundary between glass and
    /// something else than air none is known, and a part of the light is lost.
    fn tables(&self) -> Option<(&Albedo, &Albedo)> {
        let rough = self.roughness;
        let [air, glass] = &rough.sides;
        if self.before == 1.0 && self.behind == rough.ior {
            Some((air, glass))
        } else if self.before == rough.ior && self.behind == 1.0 {
            Some((glass, air))
        } else {
            None
        }
    }

    /// The share of what the microfacets keep that comes back to the viewer's side. The other side gets as
    /// much as makes the lobe the same both ways.
    fn kept_here(&self, here: &Albedo, there: &Albedo) -> f64 {
        let weight = |n: f64, albedo: &Albedo| n * n * (1.0 - albedo.mean());
        let (a, b) = (weight(self.before, here), weight(self.behind, there));
        a / (a + b)
    }

    /// What goes from `wi`, on either side, to `wo`.
    pub(crate) fn evaluate(&self, wo: Vec3, wi: Vec3) -> Part {
        let ggx = self.roughness.ggx;
        if !(wo.z > 0.0) || wi.z == 0.0 {
            return Part::default();
        }
        let (mut value, mut pdf);
        if wi.z > 0.0 {
            let half = (wo + wi).normalized();
            let facet = Facet::new(half, wo, self.before, self.behind);
            value = facet.reflectance * ggx.reflect(wo, wi).0;
            pdf = facet.reflectance * ggx.pdf(wo, wi);
        } else {
            let sum = wo * self.before + wi * self.behind;
            let half = sum.normalized() * if self.before < self.behind { -1.0 } else { 1.0 };
            let (cos_o, cos_i) = (half.dot(wo), half.dot(wi));
            (value, pdf) = (0.0, 0.0);
            if self.before != self.behind && half.z > 0.0 && cos_o > 0.0 && cos_i < 0.0 {
                let facet = Facet::new(half, wo, self.before, self.behind);
                let visible = ggx.density(half.z) * 2.0 * cos_o / (wo.z + ggx.root(wo.z));
                let spread = (self.behind / (self.before * cos_o + self.behind * cos_i)).powi(2);
                pdf = (1.0 - facet.reflectance) * visible * -cos_i * spread;
                value = pdf * ggx.shadowing(wi.z);
            }
        }
        if let Some((here, there)) = self.tables() {
            let kept = here.missing(wo.z);
            let share_here = self.kept_here(here, there);
            let even = wi.z.abs() * FRAC_1_PI;
            let (share, side) =
                if wi.z > 0.0 { (share_here, here) } else { (1.0 - share_here, there) };
            let missing = 1.0 - side.mean();
            pdf = (1.0 - kept) * pdf + kept * share * even;
            if missing > 0.0 {
                value += share * kept * side.missing(wi.z) * even / missing;
            }
        }
        Part { value: Rgb::splat(value), pdf }
    }

    /// A direction on either side.
    pub(crate) fn sample(&self, wo: Vec3, choice: f64, u: (f64, f64)) -> Option<Scatter> {
        let ggx = self.roughness.ggx;
        let mut choice = choice;
        let mut even = None;
        if let Some((here, there)) = self.tables() {
            let kept = here.missing(wo.z);
            if choice < kept {
                let up = warp::cosine_hemisphere(u);
                let back = choice < kept * self.kept_here(here, there);
                even = Some(if back { up } else { -up });
            } else {
                choice = (choice - kept) / (1.0 - kept);
            }
        }
        let direction = match even {
            Some(direction) => direction,
            None => {
                let facet = Facet::new(ggx.visible_normal(wo, u), wo, self.before, self.behind);
                if choice < facet.reflectance {
                    Some(facet.mirrored(wo)).filter(|wi| wi.z > 0.0)?
                } else {
                    facet.refracted(wo)?
                }
            }
        };
        let Part { value, pdf } = self.evaluate(wo, direction);
        (pdf > 0.0).then(|| Scatter { direction, weight: value / pdf, pdf, kind: Kind::Narrow })
    }
}

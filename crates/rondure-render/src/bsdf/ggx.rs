//! Microfacets: the GGX distribution of normals (Walter et al. 2007, "Microfacet Models for Refraction
//! through Rough Surfaces") with the height-correlated masking of Heitz 2014, sampled by visible
//! normals (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps").
//!
//! Directions are in the frame of the surface: z is the normal, on the viewer's side.

use core::f64::consts::PI;

use rondure::Vec3;

use crate::warp;

/// The distribution of microfacet normals of a given width.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ggx {
    pub(crate) alpha: f64,
}

/// What microfacets reflect from one direction to another, before the Fresnel factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflected {
    pub(crate) value: f64,
    /// The cosine with the half vector.
    pub(crate) cos: f64,
    pub(crate) pdf: f64,
}

impl Ggx {
    /// The density of the normals at the cosine `cos_h`.
    #[inline]
    pub(crate) fn density(self, cos_h: f64) -> f64 {
        let a2 = self.alpha * self.alpha;
        // sin^2 + a^2 cos^2 from the difference, which keeps narrow lobes accurate.
        let sin2 = (1.0 - cos_h) * (1.0 + cos_h);
        let s = sin2 + a2 * cos_h * cos_h;
        a2 / (PI * s * s)
    }

    /// sqrt(a^2 + (1 - a^2) cos^2), the root in Smith's masking.
    #[inline]
    pub(crate) fn root(self, cos: f64) -> f64 {
        let a2 = self.alpha * self.alpha;
        (a2 + (1.0 - a2) * cos * cos).sqrt()
    }

    /// D G2 / (4 cos_o cos_i) times cos_i: what a light from `wi` adds towards `wo`, before the
    /// Fresnel factor, which is to be taken at the second number, the cosine with the half vector.
    #[inline]
    pub(crate) fn reflect(self, wo: Vec3, wi: Vec3) -> (f64, f64) {
        let half = (wo + wi).normalized();
        let masking = 0.5 / (wo.z * self.root(wi.z) + wi.z * self.root(wo.z));
        (self.density(half.z) * masking * wi.z, half.dot(wo).clamp(0.0, 1.0))
    }

    /// [`reflect`](Self::reflect) and [`pdf`](Self::pdf) in one; `root_o` is the [`root`](Self::root) of `wo`.
    ///
    /// With the half vector h = o + i, as long as it is, the [`density`](Self::density) is a^2 |h|^4 / (pi (hx^2 + hy^2 + a^2 hz^2)^2), which takes
    /// no root, and the cosine with it |h| / 2. All three quotients take one division.
    #[inline]
    pub(crate) fn reflect_and_pdf(self, wo: Vec3, wi: Vec3, root_o: f64) -> Reflected {
        let half = wo + wi;
        let a2 = self.alpha * self.alpha;
        let (across2, along2) = (half.x * half.x + half.y * half.y, half.z * half.z);
        let (length2, s) = (across2 + along2, across2 + a2 * along2);
        let seen = wo.z + root_o;
        let masking = wo.z * self.root(wi.z) + wi.z * root_o;
        let density = 0.5 * a2 * length2 * length2 / (PI * (s * s) * (seen * masking));
        let (value, pdf) = (density * seen * wi.z, density * masking);
        Reflected { value, cos: (0.5 * length2.sqrt()).min(1.0), pdf }
    }

    /// A microfacet normal, in proportion to how much of it `wo` sees.
    #[inline]
    pub(crate) fn visible_normal(self, wo: Vec3, u: (f64, f64)) -> Vec3 {
        self.visible(wo, u).normalized()
    }

    /// The same, of another length.
    #[inline]
    fn visible(self, wo: Vec3, u: (f64, f64)) -> Vec3 {
        let a = self.alpha;
        let stretched = Vec3::new(wo.x * a, wo.y * a, wo.z).normalized();
        let z = (1.0 - u.1) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = warp::sin_cos_turn(u.0);
        let half = Vec3::new(radius * cos, radius * sin, z) + stretched;
        Vec3::new(half.x * a, half.y * a, half.z.max(0.0))
    }

    /// The density, by solid angle, with which [`sample`](Self::sample) finds `wi`.
    #[inline]
    pub(crate) fn pdf(self, wo: Vec3, wi: Vec3) -> f64 {
        let half = (wo + wi).normalized();
        self.density(half.z) * 0.5 / (wo.z + self.root(wo.z))
    }

    /// A direction of reflection, and the cosine with the half vector. `None` if the direction leads into the surface.
    #[inline]
    pub(crate) fn direction(self, wo: Vec3, u: (f64, f64)) -> Option<(Vec3, f64)> {
        let half = self.visible(wo, u);
        let (along, length2) = (half.dot(wo), half.length_squared());
        let wi = half * (2.0 * along / length2) - wo;
        (wi.z > 0.0).then(|| (wi, (along / length2.sqrt()).clamp(0.0, 1.0)))
    }

    /// The same, and what is left of the light before the Fresnel factor: G2 / G1.
    #[inline]
    pub(crate) fn sample(self, wo: Vec3, u: (f64, f64)) -> Option<(Vec3, f64, f64)> {
        self.direction(wo, u).map(|(wi, cos)| (wi, cos, self.masked(wo, wi)))
    }

    /// Smith's masking of one direction, on either side.
    #[inline]
    pub(crate) fn shadowing(self, cos: f64) -> f64 {
        let cos = cos.abs();
        2.0 * cos / (cos + self.root(cos))
    }

    /// What masking leaves of light in a direction on the viewer's side that was found by a visible normal.
    #[inline]
    pub(crate) fn masked(self, wo: Vec3, wi: Vec3) -> f64 {
        if wi.z > 0.0 {
            wi.z * (wo.z + self.root(wo.z)) / (wo.z * self.root(wi.z) + wi.z * self.root(wo.z))
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;

    fn grid(n: u32) -> impl Iterator<Item = (f64, f64)> {
        let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n * n).map(move |i| (at(i % n), at(i / n)))
    }

    fn towards(cos: f64) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    #[test]
    fn visible_normals_have_their_density() {
        let lobe = Ggx { alpha: 0.4 };
        let wo = towards(0.6);
        // The integral of the density over the directions that lead out is the share of samples
        // that do.
        let n = 512;
        let integral =
            grid(n).map(|u| TAU * lobe.pdf(wo, warp::cap(u, 1.0))).sum::<f64>() / f64::from(n * n);
        let share = grid(n).filter(|&u| lobe.sample(wo, u).is_some()).count();
        let share = share as f64 / f64::from(n * n);
        assert!((integral - share).abs() < 2e-3, "{integral} {share}");
    }

    #[test]
    fn both_in_one_are_what_each_is() {
        for alpha in [1e-3, 0.1, 1.0] {
            let lobe = Ggx { alpha };
            let wo = towards(0.3);
            for u in grid(24) {
                let wi = warp::cap(u, 1.0);
                let found = lobe.reflect_and_pdf(wo, wi, lobe.root(wo.z));
                let (value, cos) = lobe.reflect(wo, wi);
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
                assert!(near(found.value, value) && near(found.pdf, lobe.pdf(wo, wi)), "{wi:?}");
                assert!(near(found.cos, cos), "{wi:?}");
            }
        }
    }

    #[test]
    fn sampled_weight_is_value_over_density() {
        let lobe = Ggx { alpha: 0.3 };
        let wo = towards(0.5);
        for u in grid(20) {
            let Some((wi, _, masked)) = lobe.sample(wo, u) else { continue };
            let (value, _) = lobe.reflect(wo, wi);
            let expected = value / lobe.pdf(wo, wi);
            assert!((masked - expected).abs() < 1e-9 * expected, "{masked} {expected}");
        }
    }
}

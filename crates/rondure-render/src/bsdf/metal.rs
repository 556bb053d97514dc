//! How much metals reflect: measured ones by their complex index of refraction, others by Schlick's curve.

use crate::color::Rgb;

/// The reflectance of a metal.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Metal {
    /// By the colour at normal incidence (Schlick 1994).
    Tinted,
    /// By the index eta + i k of each channel.
    Measured { eta: Rgb, k: Rgb },
}

impl Metal {
    /// The reflectance at the cosine; `color` is that of a tinted metal at normal incidence.
    #[inline]
    pub(crate) fn reflectance(&self, cos: f64, color: Rgb) -> Rgb {
        match *self {
            Self::Tinted => color.mix(Rgb::WHITE, (1.0 - cos).clamp(0.0, 1.0).powi(5)),
            Self::Measured { eta, k } => Rgb {
                r: conductor(cos, eta.r, k.r),
                g: conductor(cos, eta.g, k.g),
                b: conductor(cos, eta.b, k.b),
            },
        }
    }

    /// Whether it is known by the index.
    pub(crate) fn is_measured(&self) -> bool {
        matches!(self, Self::Measured { .. })
    }

    /// The mean of the reflectance over a hemisphere weighted by the cosine.
    pub(crate) fn mean(&self, color: Rgb) -> Rgb {
        match *self {
            Self::Tinted => color * (20.0 / 21.0) + Rgb::splat(1.0 / 21.0),
            Self::Measured { .. } => {
                const STEPS: u32 = 256;
                let cosines = (0..STEPS).map(|i| ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt());
                let sum = cosines.fold(Rgb::BLACK, |sum, cos| sum + self.reflectance(cos, color));
                sum / f64::from(STEPS)
            }
        }
    }
}

/// The steps of a curve.
const STEPS: usize = 512;

/// The reflectance of a measured metal as a table over the cosine, within 1e-5 of it.
#[derive(Clone, Debug)]
pub(crate) struct Curve(Box<[Rgb; STEPS + 1]>);

impl Curve {
    pub(crate) fn new(metal: &Metal) -> Self {
        let at = |i| metal.reflectance(i as f64 / STEPS as f64, Rgb::WHITE);
        Self(Box::new(core::array::from_fn(at)))
    }

    /// The reflectance at a cosine between 0 and 1.
    #[inline]
    pub(crate) fn at(&self, cos: f64) -> Rgb {
        let place = cos.clamp(0.0, 1.0) * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        self.0[step].mix(self.0[step + 1], place - step as f64)
    }
}

/// The reflectance, for unpolarised light, of a metal of index eta + i k in air (Born and Wolf, section
/// 14.2).
fn conductor(cos: f64, eta: f64, k: f64) -> f64 {
    let cos2 = cos * cos;
    let sin2 = (1.0 - cos) * (1.0 + cos);
    let t0 = eta * eta - k * k - sin2;
    let a2_b2 = (t0 * t0 + 4.0 * eta * eta * k * k).sqrt();
    let t1 = a2_b2 + cos2;
    let a = (0.5 * (a2_b2 + t0)).max(0.0).sqrt();
    let t2 = 2.0 * cos * a;
    let across = (t1 - t2) / (t1 + t2);
    let t3 = cos2 * a2_b2 + sin2 * sin2;
    let t4 = t2 * sin2;
    let along = across * (t3 - t4) / (t3 + t4);
    0.5 * (across + along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_on_is_the_closed_form() {
        for (eta, k) in [(0.14_f64, 3.98_f64), (1.5, 0.0), (0.05, 2.0)] {
            let expected = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
            assert!((conductor(1.0, eta, k) - expected).abs() < 1e-14, "{eta} {k}");
        }
    }

    #[test]
    fn curve_keeps_to_the_reflectance() {
        let gold = Metal::Measured {
            eta: Rgb { r: 0.18, g: 0.42, b: 1.37 },
            k: Rgb { r: 3.42, g: 2.35, b: 1.77 },
        };
        let copper = Metal::Measured {
            eta: Rgb { r: 0.23, g: 0.84, b: 1.17 },
            k: Rgb { r: 3.67, g: 2.57, b: 2.32 },
        };
        for metal in [gold, copper] {
            let curve = Curve::new(&metal);
            for i in 0..=10_000 {
                let cos = f64::from(i) / 10_000.0;
                let (found, expected) = (curve.at(cos), metal.reflectance(cos, Rgb::WHITE));
                let off = [found.r - expected.r, found.g - expected.g, found.b - expected.b];
                assert!(off.iter().all(|x| x.abs() < 1e-5), "{cos} {off:?}");
            }
        }
    }

    #[test]
    fn without_absorption_it_is_a_dielectric() {
        for cos in [0.05, 0.3, 0.8] {
            let expected = crate::fresnel::from_air(cos, 1.5);
            assert!((conductor(cos, 1.5, 0.0) - expected).abs() < 1e-14, "{cos}");
        }
        assert_eq!(conductor(0.0, 0.2, 3.0), 1.0);
    }

    #[test]
    fn mean_of_a_tinted_metal_is_the_integral() {
        let color = Rgb { r: 0.2, g: 0.5, b: 1.0 };
        let n = 100_000;
        let cosines = (0..n).map(|i| ((f64::from(i) + 0.5) / f64::from(n)).sqrt());
        let sum = cosines.fold(Rgb::BLACK, |sum, cos| sum + Metal::Tinted.reflectance(cos, color));
        let off = (sum / f64::from(n)).r - Metal::Tinted.mean(color).r;
        assert!(off.abs() < 1e-6, "{off}");
    }
}

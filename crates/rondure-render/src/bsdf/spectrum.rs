//! Dispersion: glass bends blue light more than red. A path that meets such glass goes on with the light of
//! one wavelength, chosen evenly, and with the colour of that wavelength.

use crate::color::Rgb;

/// The visible light that is followed, in nanometres.
const SHORTEST: f64 = 400.0;
const LONGEST: f64 = 700.0;
/// The lines of helium and hydrogen at which Abbe's number is defined, in nanometres.
const LINE_D: f64 = 587.6;
const LINE_F: f64 = 486.1;
const LINE_C: f64 = 656.3;

/// A wavelength, by its place in the visible light, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wavelength(pub(crate) f64);

/// The index of refraction by Cauchy's formula, n = a + b / wavelength^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dispersion {
    a: f64,
    b: f64,
}

impl Dispersion {
    /// `ior` is the index at the yellow line of helium, `abbe` is (n_d - 1) / (n_F - n_C).
    pub(crate) fn new(ior: f64, abbe: f64) -> Self {
        let b = (ior - 1.0) / (abbe * (1.0 / (LINE_F * LINE_F) - 1.0 / (LINE_C * LINE_C)));
        Self { a: ior - b / (LINE_D * LINE_D), b }
    }

    pub(crate) fn ior(&self, at: Wavelength) -> f64 {
        let nanometres = SHORTEST + (LONGEST - SHORTEST) * at.0;
        self.a + self.b / (nanometres * nanometres)
    }
}

impl Wavelength {
    /// The colour of the wavelength, none of whose channels is negative; the mean over all
    /// wavelengths is white. The sensitivities are those of the eye's matching functions in Rec. 709 as far
    /// as they are positive, as sums of bells.
    pub(crate) fn color(self) -> Rgb {
        let bell = |middle: f64, width: f64| {
            let off = (SHORTEST + (LONGEST - SHORTEST) * self.0 - middle) / width;
            (-0.5 * off * off).exp()
        };
        // Each over its mean.
        Rgb {
            r: (bell(605.0, 32.0) + 0.12 * bell(430.0, 16.0)) / 0.282_529,
            g: bell(543.0, 36.0) / 0.300_783,
            b: bell(450.0, 24.0) / 0.196_798,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_wavelengths_together_are_white() {
        let n = 100_000;
        let at = |i: u32| Wavelength((f64::from(i) + 0.5) / f64::from(n));
        let mean = (0..n).fold(Rgb::BLACK, |sum, i| sum + at(i).color()) / f64::from(n);
        for channel in [mean.r, mean.g, mean.b] {
            assert!((channel - 1.0).abs() < 1e-4, "{mean:?}");
        }
    }

    #[test]
    fn indices_are_those_of_the_lines() {
        let glass = Dispersion::new(1.5168, 64.17);
        let at = |line: f64| glass.ior(Wavelength((line - SHORTEST) / (LONGEST - SHORTEST)));
        assert!((at(LINE_D) - 1.5168).abs() < 1e-12);
        assert!(((at(LINE_D) - 1.0) / (at(LINE_F) - at(LINE_C)) - 64.17).abs() < 1e-9);
    }
}

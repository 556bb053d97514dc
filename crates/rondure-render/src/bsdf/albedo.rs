//! Tables of directional albedo: the share of the light from a direction that a lobe returns, over the
//! root of the cosine, where it changes most evenly.

use core::f64::consts::FRAC_1_PI;

/// The steps of a table.
const STEPS: usize = 64;
/// Samples for each entry.
const SAMPLES: u32 = 1024;

/// A function of the cosine, and its mean over a hemisphere weighted by the cosine.
#[derive(Clone, Debug)]
pub(crate) struct Albedo {
    at: Box<[f64; STEPS + 1]>,
    mean: f64,
}

/// A step of the tables, and where in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    step: usize,
    share: f64,
}

impl Albedo {
    pub(crate) fn zero() -> Self {
        Self::from_fn(|_| 0.0)
    }

    pub(crate) fn from_fn(f: impl Fn(f64) -> f64) -> Self {
        // At 0 the limit is taken from a little above, where directions are still defined.
        let least = 0.25 / (STEPS * STEPS) as f64;
        let at = |i: usize| f((i as f64 / STEPS as f64).powi(2).max(least)).clamp(0.0, 1.0);
        let mut albedo = Self { at: Box::new(core::array::from_fn(at)), mean: 0.0 };
        let n = 16 * STEPS;
        let cosines = (0..n).map(|i| ((i as f64 + 0.5) / n as f64).sqrt());
        albedo.mean = cosines.map(|cos| albedo.get(cos)).sum::<f64>() / n as f64;
        albedo
    }

    /// From the mean of `one` over evenly spread points of the unit square.
    pub(crate) fn integrate(one: impl Fn(f64, (f64, f64)) -> f64) -> Self {
        Self::from_fn(|cos| points().map(|u| one(cos, u)).sum::<f64>() / f64::from(SAMPLES))
    }

    #[inline]
    pub(crate) fn get(&self, cos: f64) -> f64 {
        self.at(Self::place(cos))
    }

    /// Where in all tables a cosine stands.
    #[inline]
    pub(crate) fn place(cos: f64) -> Place {
        let place = cos.abs().min(1.0).sqrt() * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        Place { step, share: place - step as f64 }
    }

    #[inline]
    pub(crate) fn at(&self, place: Place) -> f64 {
        let (a, b) = (self.at[place.step], self.at[place.step + 1]);
        a + (b - a) * place.share
    }

    pub(crate) fn mean(&self) -> f64 {
        self.mean
    }

    /// What is missing of 1.
    #[inline]
    pub(crate) fn missing(&self, cos: f64) -> f64 {
        1.0 - self.get(cos)
    }

    /// The even lobe that returns what this one misses, and is the same both ways (Kelemen and
    /// Szirmay-Kalos 2001): (1 - E(o)) (1 - E(i)) / (pi (1 - mean E)).
    ///
    /// `missing_o` is 1 - E(o).
    #[inline]
    pub(crate) fn rest_of(&self, missing_o: f64, cos_i: f64) -> f64 {
        let missing = 1.0 - self.mean;
        if missing > 0.0 { missing_o * self.missing(cos_i) * FRAC_1_PI / missing } else { 0.0 }
    }
}

/// The additive recurrence of the plastic number: evenly spread in the square.
fn points() -> impl Iterator<Item = (f64, f64)> {
    const STEP: (f64, f64) = (0.754_877_666_246_692_8, 0.569_840_290_998_053_2);
    (0..SAMPLES).map(|i| {
        let at = f64::from(i) + 0.5;
        // `f64::fract` is a call of the library where SSE 4.1 is not a matter of course.
        let fract = |x: f64| x - f64::from(x as u32);
        (fract(at * STEP.0), fract(at * STEP.1))
    })
}

//! How far a line strays from the surface between two of its points.
//!
//! Along a wall that it does not leave by more than rounding, a line may have any hits, in pairs: every point of the
//! wall may be before or behind it. No estimate from the extrema of F says so, since the whole line need not
//! touch when it is moved.

use dashu_int::IBig;

use super::{ExactLine, Oracle, Piece, Place, Setup};
use crate::exact::{decode, shl};

/// Points that are looked at on the line, and first on each piece.
const STEPS: u32 = 32;
/// Parameters on a piece are multiples of 2^-`PLACES`.
const PLACES: i64 = 62;
/// Golden sections of two of the steps on a piece: to 2^-`PLACES`.
const SECTIONS: u32 = 84;
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Oracle {
    /// The largest distance from the surface, as a fraction of its size, of the points of a line between two
    /// parameters, as far as can be seen from some of them.
    pub fn straying(&self, line: &ExactLine, [t0, t1]: [f64; 2]) -> f64 {
        let setup = Setup::new(line, self.pieces.exponent);
        let at = |i: u32| t0 + (t1 - t0) * f64::from(i) / f64::from(STEPS);
        let points = (0..=STEPS).map(|i| self.distance_of(&Stop::new(&setup, at(i))));
        points.fold(0.0, f64::max) / self.pieces.size
    }

    fn distance_of(&self, stop: &Stop<'_>) -> f64 {
        self.pieces
            .list
            .iter()
            .map(|piece| stop.distance(self, piece))
            .fold(f64::INFINITY, f64::min)
    }
}

/// A point of a line: T = numerator / 2^places in units of [`Setup::t_exponent`].
struct Stop<'a> {
    setup: &'a Setup,
    numerator: IBig,
    places: i64,
    /// (a T^2 + 2 b T + c) 4^places, the squared distance from the axis.
    rho2: IBig,
}

impl<'a> Stop<'a> {
    fn new(setup: &'a Setup, t: f64) -> Self {
        let (mantissa, exponent) = decode(t);
        let exponent = exponent - setup.t_exponent;
        let places = (-exponent).max(0);
        let numerator = shl(&IBig::from(mantissa), exponent + places);
        let rho2 = &setup.a * &numerator * &numerator
            + shl(&(&setup.b * &numerator), places + 1)
            + shl(&setup.c, 2 * places);
        Self { setup, numerator, places, rho2 }
    }

    /// The distance from a piece, in the half plane.
    fn distance(&self, oracle: &Oracle, piece: &Piece) -> f64 {
        let step = 1.0 / f64::from(STEPS);
        let at = |s: f64| self.distance_at(oracle, piece, s.clamp(0.0, 1.0));
        let coarse = (0..=STEPS).map(|i| f64::from(i) * step).map(|s| (at(s), s));
        let (least, s) = coarse.fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a });
        let (mut low, mut high) = (s - step, s + step);
        let mut least = least;
        for _ in 0..SECTIONS {
            let width = GOLDEN * (high - low);
            let (left, right) = (high - width, low + width);
            let (of_left, of_right) = (at(left), at(right));
            least = least.min(of_left).min(of_right);
            if of_left < of_right { high = right } else { low = left }
        }
        least
    }

    fn distance_at(&self, oracle: &Oracle, piece: &Piece, s: f64) -> f64 {
        let setup = self.setup;
        let x = IBig::from((s * (1_u64 << PLACES) as f64) as u64);
        let at = Place::at(piece, x, PLACES, setup);
        let per = &at.q << self.places as usize;
        let drop = (&at.height << self.places as usize) - &self.numerator * &setup.dz * &at.q;
        let radius = &at.r * &setup.lift;
        let excess =
            &self.rho2 * &at.q * &at.q - ((&radius * &radius) << (2 * self.places as usize));
        let rho = setup.area(&self.rho2, &(IBig::from(1) << (2 * self.places as usize))).sqrt();
        let r = crate::exact::ratio_f64(&at.r, &at.q, oracle.pieces.exponent);
        let sum = rho + r;
        let across = if sum > 0.0 { setup.area(&excess, &(&per * &per)) / sum } else { 0.0 };
        across.hypot(setup.length(&drop, &per))
    }
}

//! Which leaves a ray hits: sixteen at a time, in f32, without a division but the last.
//!
//! Everything is measured in a unit near the surface's radius, so that f32 holds it. With the ray in the
//! form `F = X^2 + kappa - eta w` (see [`meridian`](crate::meridian); w = rho^2, X linear in z), a leaf
//! lies, in the plane (z, w), near the chord of its ends, no more than `below` under and `above` over
//! it. Along the chord F is a parabola that opens upwards, with the Bernstein coefficients F0,
//! (F0 + F1 - dX^2) / 2 and F1. On the leaf it is no less than that parabola lowered by eta `above`, and
//! no more than max(F0, F1) + eta `below`: if the first has no root, or the second is negative, the
//! whole line misses the leaf. Ranges of z and w tell whether the
//! part of the line that counts comes near it. Groups of leaves are boxes in (z, w), tested likewise.
//!
//! Of the leaves that remain, most have one root or none for certain, by the argument of
//! [`leaf`](super::leaf), with room for the rounding of f32. The others are left to that.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::arithmetic::{greater, lesser};
use super::course::Course;
use crate::meridian::Meridian;
use crate::piece::{Kind, Piece};

/// How many pieces or boxes are tested at once.
pub(super) const LANES: usize = 16;

/// How far rounding can move F, z and w here, twice over, for eta <= 1. The radius is below 2, so z and
/// sqrt(w) are, and X where F is near 0; X at z = 0 is below 4. With u = 2^-24 that makes an error of
/// 10 u in X, of 44 u in X^2, and of 20 u in kappa and eta w. Beyond eta = 1 X^2 and so all errors of F grow
/// with eta at most.
const PADDING: f32 = 128.0 * (0.5 * f32::EPSILON);

/// How far it can move sqrt(eta w - kappa): no more than the square root of that, rounded up.
const ROOT_PADDING: f32 = 1.0 / 256.0;

/// Sixteen leaves.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// The heights of the two ends, the lower one first.
    z: [[f32; LANES]; 2],
    /// w at the same ends.
    w: [[f32; LANES]; 2],
    below: [f32; LANES],
    above: [f32; LANES],
    /// The range of r r' / z'.
    slopes: [[f32; LANES]; 2],
}

/// What is known of sixteen leaves: sets of bits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hits {
    /// Those that have one root for certain, or one on each half of the ray,
    pub(super) sure: u32,
    /// of which these have it at a height where the line is.
    pub(super) inside: u32,
    /// Those that may have some.
    pub(super) unsure: u32,
    /// Of the sure ones: about where on the leaf, from 0 to 1 from its lower end,
    pub(super) guess: [f32; LANES],
    /// and whether X >= 0 there.
    pub(super) above: u32,
    /// Those that have one on the other half, too, and where.
    pub(super) double: u32,
    pub(super) other_guess: [f32; LANES],
}

/// The roots on one leaf: about where, as a share of the leaf from its lower end, and whether X >= 0
/// there; and where on the other half of the ray, if there is one, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roots {
    pub(super) guess: f32,
    pub(super) above: bool,
    pub(super) other: Option<f32>,
    /// Whether all of the leaf is at heights where the line is.
    pub(super) inside: bool,
}

/// Sixteen boxes in (z, w).
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Boxes {
    z: [[f32; LANES]; 2],
    w: [[f32; LANES]; 2],
}

/// A ray for these tests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    slope: f32,
    /// X at z = 0.
    x: f32,
    kappa: f32,
    eta: f32,
    /// The padding of F and of its root.
    padding: f32,
    root_padding: f32,
    /// Between which heights, and from which w on, the part of the line lies that counts.
    z: [f32; 2],
    w: f32,
    /// z as a function of the ray's parameter, to shorten the line.
    oz: f64,
    dz: f64,
    unit: f64,
    /// The height at which it was shortened, with room for rounding.
    end: f64,
}

impl Line {
    /// The part of a ray between two parameters, of its own course; `unit` is one over the surface's
    /// radius, or near it.
    #[inline(always)]
    pub(super) fn along(course: &Course, range: [f64; 2], unit: f64) -> Self {
        // Half the derivative of w.
        let outward = course.a * range[0] + course.b;
        // Away from the axis, w grows from where the line begins.
        let w = if outward >= 0.0 { course.w(outward) * (unit * unit) } else { 0.0 };
        Self::new(1.0, course.x, course.kappa, course.eta, [course.oz, course.dz], range, w, unit)
    }

    /// The same for a ray in the form of the exact engine.
    #[inline(always)]
    pub(super) fn of(ray: &Meridian, range: [f64; 2], unit: f64) -> Self {
        let (slope, x) = (ray.slope(), ray.x(0.0));
        Self::new(slope, x, ray.kappa(), ray.eta, [ray.oz, ray.dz], range, 0.0, unit)
    }

    #[expect(clippy::too_many_arguments, reason = "the coefficients of the two ways to see a ray")]
    #[inline(always)]
    fn new(
        slope: f64,
        x: f64,
        kappa: f64,
        eta: f64,
        [oz, dz]: [f64; 2],
        range: [f64; 2],
        w: f64,
        unit: f64,
    ) -> Self {
        let eta = eta as f32;
        let growth = if eta > 1.0 { eta } else { 1.0 };
        // Written out: the compiler keeps closures out of line here.
        let z = [((oz + dz * range[0]) * unit) as f32, ((oz + dz * range[1]) * unit) as f32];
        // Not a number for a line without end that is perpendicular to the axis.
        let z = if z[0] <= z[1] {
            [z[0] - PADDING, z[1] + PADDING]
        } else if z[0] > z[1] {
            [z[1] - PADDING, z[0] + PADDING]
        } else {
            [f32::NEG_INFINITY, f32::INFINITY]
        };
        Self {
            slope: slope as f32,
            x: (x * unit) as f32,
            kappa: (kappa * (unit * unit)) as f32,
            eta,
            padding: PADDING * growth,
            // No less than the square root of the growth.
            root_padding: ROOT_PADDING * (0.5 + 0.5 * growth),
            z,
            w: w as f32 - PADDING,
            oz,
            dz,
            unit,
            end: if dz >= 0.0 { f64::INFINITY } else { f64::NEG_INFINITY },
        }
    }

    /// Whether z grows along the ray.
    #[inline(always)]
    pub(super) fn rises(&self) -> bool {
        self.dz >= 0.0
    }

    /// Ends the line at a parameter.
    #[inline(always)]
    pub(super) fn end_at(&mut self, t: f64) {
        let z = self.oz + self.dz * t;
        let end = (z * self.unit) as f32;
        let pad = f64::from(PADDING) / self.unit;
        if self.dz >= 0.0 {
            self.z[1] = end + PADDING;
            self.end = z + pad;
        } else {
            self.z[0] = end - PADDING;
            self.end = z - pad;
        }
    }

    /// Ends the line beyond a leaf.
    #[inline(always)]
    pub(super) fn end_after(&mut self, [z0, z1]: [f64; 2]) {
        let (low, high) = (lesser(z0, z1) * self.unit, greater(z0, z1) * self.unit);
        if self.dz >= 0.0 {
            self.z[1] = self.z[1].min(high as f32 + PADDING);
        } else {
            self.z[0] = self.z[0].max(low as f32 - PADDING);
        }
    }

    /// Whether all of a leaf lies beyond the end of the line, since it was last shortened.
    #[inline(always)]
    pub(super) fn ends_before(&self, [z0, z1]: [f64; 2]) -> bool {
        if self.dz >= 0.0 { z0 > self.end && z1 > self.end } else { z0 < self.end && z1 < self.end }
    }
}

impl Block {
    pub(super) const EMPTY: Self = Self {
        // No line reaches so high.
        z: [[f32::MAX; LANES]; 2],
        w: [[0.0; LANES]; 2],
        below: [0.0; LANES],
        above: [0.0; LANES],
        slopes: [[0.0; LANES]; 2],
    };

    pub(super) fn set(&mut self, lane: usize, piece: &Piece, slopes: [f32; 2], unit: f64) {
        let [a, b] = [piece.start(), piece.end()].map(|p| [p.z * unit, (p.r * unit).powi(2)]);
        let [low, high] = if a[0] <= b[0] { [a, b] } else { [b, a] };
        let [below, above] = deviation(piece, unit);
        for (i, [z, w]) in [low, high].into_iter().enumerate() {
            self.z[i][lane] = z as f32;
            self.w[i][lane] = w as f32;
        }
        self.below[lane] = below as f32;
        self.above[lane] = above as f32;
        for (lanes, slope) in self.slopes.iter_mut().zip(slopes) {
            lanes[lane] = slope;
        }
    }

    /// Which of the leaves the line hits, and where.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, line: &Line, hits: &mut Hits) {
        let [z0, z1] = [load(simd, &self.z[0]), load(simd, &self.z[1])];
        let [w0, w1] = [load(simd, &self.w[0]), load(simd, &self.w[1])];
        let slope = splat(simd, line.slope);
        let (x, kappa, eta) =
            (splat(simd, line.x), splat(simd, line.kappa), splat(simd, -line.eta));
        let (x0, x1) = (slope.mul_add(z0, x), slope.mul_add(z1, x));
        let (q0, q1) = (eta.mul_add(w0, kappa), eta.mul_add(w1, kappa));
        let (f0, f1) = (x0.mul_add(x0, q0), x1.mul_add(x1, q1));
        let dx = x1 - x0;
        let zero = splat(simd, 0.0);
        let padding = splat(simd, line.padding);
        let lowered = eta.mul_sub(load(simd, &self.above), padding);
        let (low0, low1) = (f0 + lowered, f1 + lowered);
        // Twice the middle coefficient, and the discriminant with room for rounding.
        let middle = low0 + low1 - dx * dx;
        let dips =
            middle.simd_lt(zero) & (middle * middle).simd_ge((low0 * splat(simd, 3.999)) * low1);
        let highest = f0.max(f1) - eta * load(simd, &self.below);
        let may = (low0.min(low1).simd_le(zero) | dips)
            & highest.simd_ge(-padding)
            & z0.simd_le(splat(simd, line.z[1]))
            & z1.simd_ge(splat(simd, line.z[0]))
            & w0.max(w1).simd_ge(splat(simd, line.w));
        let may = may.to_bitmask() as u32;
        (hits.sure, hits.unsure) = (0, 0);
        if may == 0 {
            return;
        }
        let (reach0, reach1) = ((-q0).max(zero).sqrt(), (-q1).max(zero).sqrt());
        let room = splat(simd, line.root_padding);
        let near = (reach0.min(reach1) - room).max(zero);
        let far = reach0.max(reach1) + room;
        // A root lies on the half of the ray where the end with F >= 0 does. X at roots there, times
        // the slope of X; on the other half it is the opposite.
        let (a, b) = (slope * near, slope * far);
        let (low, high) = (a.min(b), a.max(b));
        let above0 = x0.simd_ge(zero).to_bitmask() as u32;
        let one_half = !(above0 ^ x1.simd_ge(zero).to_bitmask() as u32);
        let outer0 = f0.simd_ge(zero).to_bitmask() as u32;
        let outer1 = f1.simd_ge(zero).to_bitmask() as u32;
        let above = !(above0 ^ (one_half | outer0));
        let steepest = load(simd, &self.slopes[1]) * -eta;
        let flattest = load(simd, &self.slopes[0]) * -eta;
        // Whether F' has one sign at all roots with X > 0, and with X < 0.
        let certain_above = (low.simd_gt(steepest) | high.simd_lt(flattest)).to_bitmask() as u32;
        let certain_below =
            ((-high).simd_gt(steepest) | (-low).simd_lt(flattest)).to_bitmask() as u32;
        let certain_here = above & certain_above | !above & certain_below;
        let across = certain_above & certain_below & near.simd_gt(zero).to_bitmask() as u32;
        let clear = f0.abs().min(f1.abs()).simd_gt(padding).to_bitmask() as u32;
        let certain = may & clear & (one_half & certain_here | !one_half & across);
        let double = !one_half & outer0 & outer1;
        hits.unsure = may & !certain;
        let sure = certain & (outer0 ^ outer1 | double);
        if sure == 0 {
            return;
        }
        hits.sure = sure;
        hits.above = above;
        hits.double = sure & double;
        let within = z0.simd_ge(splat(simd, line.z[0] + 2.0 * PADDING))
            & z1.simd_le(splat(simd, line.z[1] - 2.0 * PADDING));
        hits.inside = sure & within.to_bitmask() as u32;
        // |X| - reach, signed, on the one half and, for those that have roots on both, on the other.
        let sign = mask32x16::from_bitmask(simd, u64::from(above & 0xffff));
        let sign = sign.select(splat(simd, 1.0), splat(simd, -1.0));
        let (g0, g1) = (sign.mul_sub(x0, reach0), sign.mul_sub(x1, reach1));
        (g0 / (g0 - g1)).store_array(&mut hits.guess);
        if hits.double != 0 {
            let (g0, g1) = (sign.mul_add(x0, reach0), sign.mul_add(x1, reach1));
            (g0 / (g0 - g1)).store_array(&mut hits.other_guess);
        }
    }
}

impl Hits {
    pub(super) const NONE: Self = Self {
        sure: 0,
        inside: 0,
        unsure: 0,
        guess: [0.0; LANES],
        above: 0,
        double: 0,
        other_guess: [0.0; LANES],
    };

    /// The roots on a leaf; `None` if they are not certain.
    #[inline(always)]
    pub(super) fn roots(&self, lane: usize) -> Option<Roots> {
        let (bit, lane) = (1 << lane, lane % LANES);
        (self.sure & bit != 0).then(|| Roots {
            guess: self.guess[lane],
            above: self.above & bit != 0,
            inside: self.inside & bit != 0,
            other: (self.double & bit != 0).then(|| self.other_guess[lane]),
        })
    }
}

impl Boxes {
    pub(super) const EMPTY: Self = Self { z: [[f32::MAX; LANES]; 2], w: [[0.0; LANES]; 2] };

    /// The box round the ends of all pieces, which are monotone.
    pub(super) fn set<'a>(
        &mut self,
        lane: usize,
        pieces: impl Iterator<Item = &'a Piece>,
        unit: f64,
    ) {
        let (mut z, mut w) =
            ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        for p in pieces.flat_map(|p| [p.start(), p.end()]) {
            let own = [p.z * unit, (p.r * unit).powi(2)];
            z = [z[0].min(own[0]), z[1].max(own[0])];
            w = [w[0].min(own[1]), w[1].max(own[1])];
        }
        for i in 0..2 {
            self.z[i][lane] = z[i] as f32;
            self.w[i][lane] = w[i] as f32;
        }
    }

    /// Which of the boxes the line may meet, as a set of bits.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, line: &Line) -> u32 {
        let [z0, z1] = [load(simd, &self.z[0]), load(simd, &self.z[1])];
        let [w0, w1] = [load(simd, &self.w[0]), load(simd, &self.w[1])];
        let (slope, x, kappa, eta) = (
            splat(simd, line.slope),
            splat(simd, line.x),
            splat(simd, line.kappa),
            splat(simd, -line.eta),
        );
        let (x0, x1) = (slope.mul_add(z0, x), slope.mul_add(z1, x));
        let (low, high) = (x0.min(x1), x0.max(x1));
        // The X nearest to 0 and the one farthest from it.
        let near = low.max(splat(simd, 0.0)) + high.min(splat(simd, 0.0));
        let far = high.max(splat(simd, 0.0) - low);
        let lowest = eta.mul_add(w1, near.mul_add(near, kappa));
        let highest = eta.mul_add(w0, far.mul_add(far, kappa));
        let mask = lowest.simd_le(splat(simd, line.padding))
            & highest.simd_ge(splat(simd, -line.padding))
            & z0.simd_le(splat(simd, line.z[1]))
            & z1.simd_ge(splat(simd, line.z[0]))
            & w1.simd_ge(splat(simd, line.w));
        mask.to_bitmask() as u32
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[f32; LANES]) -> f32x16<S> {
    f32x16::from_slice(simd, lanes)
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// How often a piece is halved to enclose it: its control points are then 64 times nearer to it.
const HALVINGS: usize = 3;

/// u times this is far below the roundoff of f32.
const STEEPEST_CHORD: f64 = (1_u32 << 20) as f64;

/// How far w of a piece lies under and over the chord of its ends in (z, w), at most.
///
/// On each part of the piece rho^2 - w(chord) is a polynomial, or a quotient of two, in Bernstein form;
/// its coefficients enclose it.
fn deviation(piece: &Piece, unit: f64) -> [f64; 2] {
    let [(z0, w0), (z1, w1)] =
        [piece.start(), piece.end()].map(|p| (p.z * unit, (p.r * unit).powi(2)));
    // As w is monotone, so much at the most.
    let most = (w1 - w0).abs();
    let p = (w1 - w0) / (z1 - z0);
    // A chord so flat, or so short, that rounding tilts it by more than f32 would.
    if p.is_nan() || p.abs() >= STEEPEST_CHORD {
        return [most; 2];
    }
    let mut parts = vec![*piece];
    for _ in 0..HALVINGS {
        parts = parts.iter().flat_map(Piece::halves).collect();
    }
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for part in parts {
        let (r, z) = (part.r.map(|r| r * unit), part.z.map(|z| z * unit - z0));
        let mut add = |value: f64| (low, high) = (low.min(value), high.max(value));
        // The coefficient of the product of the control values i and j.
        let d = |i: usize, j: usize| r[i] * r[j] - (w0 + p * (0.5 * (z[i] + z[j])));
        match part.kind {
            Kind::Line => [d(0, 0), d(0, 3), d(3, 3)].into_iter().for_each(&mut add),
            Kind::Quadratic => {
                let middle = (d(0, 3) + 2.0 * d(1, 1)) / 3.0;
                [d(0, 0), d(0, 1), middle, d(1, 3), d(3, 3)].into_iter().for_each(&mut add);
            }
            Kind::Conic(w) => {
                let middle = (d(0, 3) + 2.0 * w * w * d(1, 1)) / (1.0 + 2.0 * w * w);
                [d(0, 0), d(0, 1), middle, d(1, 3), d(3, 3)].into_iter().for_each(&mut add);
            }
            Kind::Cubic => {
                let c2 = (2.0 * d(0, 2) + 3.0 * d(1, 1)) / 5.0;
                let c3 = (d(0, 3) + 9.0 * d(1, 2)) / 10.0;
                let c4 = (2.0 * d(1, 3) + 3.0 * d(2, 2)) / 5.0;
                [d(0, 0), d(0, 1), c2, c3, c4, d(2, 3), d(3, 3)].into_iter().for_each(&mut add);
            }
        }
    }
    [(-low).min(most), high.min(most)]
}

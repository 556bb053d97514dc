//! The hit of a ray on a part of a piece that is known to have one.
//!
//! F = X^2 + kappa - eta w (see [`course`](super::course); w = r^2) has the derivative
//!
//! ```text
//! F' / 2 = X z' - eta r r' = z' (X - eta m),    m = r r' / z'.
//! ```
//!
//! At a root X^2 = eta w - kappa, so that on each half of the ray, X < 0 and X > 0, the roots on a leaf
//! lie between two values of X that come from the ends of the leaf; m lies in a range that is computed
//! once. If the two ranges, times eta, have nothing in common, F' has one sign at all roots on that
//! half, and since F cannot cross zero twice in one direction there is one root or none, according to
//! the signs of F and X at the ends. [`cull`](super::cull) decides that; a step of Halley's and one of
//! Newton's method then find the root.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::arithmetic::{Best, Fused, greater, lesser};
use super::cone::slope_range;
use super::course::Course;
use crate::numeric::gamma;
use crate::piece::{Kind, Piece};

/// A part of a piece: two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Leaf {
    /// r by powers of s, which runs from 0 to 1 on the leaf; for a conic the first three are those of
    /// r times its denominator 1 + q s + p s^2, and the last is q.
    r: [f64; 4],
    /// z likewise; for a conic the last is p.
    z: [f64; 4],
    /// z at s = 1.
    end: f64,
    /// The parameter on the piece is `first + share s`.
    first: f64,
    share: f64,
    /// The range of m, in units of the radius, with room for rounding.
    slopes: [f32; 2],
    /// The piece, times two, and whether it is a conic.
    piece_and_kind: u32,
}

/// A hit on a leaf: s on the piece, and the ray parameter.
pub(super) type Place = (f64, f64);

/// A Newton step shorter than this part of the leaf is the last: what remains is the square of the
/// step times half the ratio of the second to the first derivative.
const LAST_STEP: f64 = 2e-8;
/// More are needed only where F' nearly vanishes.
const MOST_STEPS: u32 = 5;
/// How far a root may leave the leaf by rounding.
const OVERSHOOT: f64 = gamma(4096);
/// The share by which ranges must differ: more than f32 and rounding can make of it.
const CERTAIN: f64 = 1.0 / 1_048_576.0;

impl Leaf {
    /// The part of a piece that begins at the parameter `first` and is `share` long, and is the
    /// curve `part` itself. `unit` is one over the surface's radius, or near it.
    pub(super) fn new(
        pieces: &[Piece],
        piece: u32,
        part: &Piece,
        [first, share]: [f64; 2],
        unit: f64,
    ) -> Self {
        let whole = &pieces[piece as usize];
        let [r, z] = match whole.kind {
            Kind::Conic(w) => {
                let (q, p) = (2.0 * (w - 1.0), -2.0 * (w - 1.0));
                let at_first = 1.0 + first * (q + first * p);
                // From the whole piece to the part, whose denominator begins with 1.
                let on_part = |b: f64, a: f64| {
                    [share * (b + 2.0 * first * a) / at_first, share * share * a / at_first]
                };
                let numerator = |whole: &[f64; 4]| {
                    let middle = w * whole[1];
                    on_part(2.0 * (middle - whole[0]), (whole[0] - middle) + (whole[3] - middle))
                };
                let ([rb, ra], [zb, za]) = (numerator(&whole.r), numerator(&whole.z));
                let [q, p] = on_part(q, p);
                [[part.r[0], rb, ra, q], [part.z[0], zb, za, p]]
            }
            kind => [&part.r, &part.z].map(|c| match kind {
                Kind::Line => [c[0], c[3] - c[0], 0.0, 0.0],
                Kind::Quadratic => [c[0], 2.0 * (c[1] - c[0]), (c[0] - c[1]) + (c[3] - c[1]), 0.0],
                _ => {
                    let (d0, d1, d2) = (c[1] - c[0], c[2] - c[1], c[3] - c[2]);
                    [c[0], 3.0 * d0, 3.0 * (d1 - d0), (d2 - d1) - (d1 - d0)]
                }
            }),
        };
        let outward = |m: f64, up: bool| {
            if up == (m >= 0.0) { m * (1.0 + CERTAIN) } else { m * (1.0 - CERTAIN) }
        };
        let [low, high] = slope_range(part, unit);
        Self {
            r,
            z,
            end: part.z[3],
            first,
            share,
            slopes: [outward(low, false) as f32, outward(high, true) as f32],
            piece_and_kind: piece * 2 + u32::from(matches!(whole.kind, Kind::Conic(_))),
        }
    }

    /// The piece that it is a part of.
    #[inline(always)]
    pub(super) fn piece(&self) -> u32 {
        self.piece_and_kind / 2
    }

    /// The range of m.
    pub(super) fn slopes(&self) -> [f32; 2] {
        self.slopes
    }

    /// The heights of the two ends.
    #[inline(always)]
    pub(super) fn heights(&self) -> [f64; 2] {
        [self.z[0], self.end]
    }

    /// The hit near a place given as a share of the leaf from its lower end, on the half of the ray
    /// where X has the sign that is told; `None` if the steps lead elsewhere.
    #[inline(always)]
    pub(super) fn hit(
        &self,
        fma: impl Fused,
        course: &Course,
        guess: f32,
        above: bool,
    ) -> Option<Place> {
        let guess = f64::from(guess);
        let guess = if self.z[0] <= self.end { guess } else { 1.0 - guess };
        let start = self.expand(fma, course, guess);
        // Halley's step.
        let Expansion { value, half_slope, .. } = start;
        let curvature = fma.fused(4.0 * half_slope, half_slope, -(value * start.half_bend));
        let mut s = guess - 2.0 * (value * half_slope) / curvature;
        for _ in 1..MOST_STEPS {
            let at = self.expand(fma, course, s);
            let step = 0.5 * at.value / at.half_slope;
            s -= step;
            if step.abs() <= LAST_STEP {
                let above_here = fma.fused(-step, at.dx, at.x) >= 0.0;
                if !((-OVERSHOOT..=1.0 + OVERSHOOT).contains(&s) && above_here == above) {
                    return None;
                }
                let s = greater(lesser(s, 1.0), 0.0);
                let (r, z) = self.point(fma, s);
                return Some((fma.fused(s, self.share, self.first), course.t(r, z, above)));
            }
        }
        None
    }

    /// r and z.
    #[inline(always)]
    fn point(&self, fma: impl Fused, s: f64) -> (f64, f64) {
        let [r, z] = [&self.r, &self.z];
        if self.piece_and_kind & 1 == 1 {
            let per = 1.0 / fma.fused(fma.fused(z[3], s, r[3]), s, 1.0);
            return (quadratic_value(fma, r, s) * per, quadratic_value(fma, z, s) * per);
        }
        (cubic_value(fma, r, s), cubic_value(fma, z, s))
    }

    #[inline(always)]
    fn expand(&self, fma: impl Fused, course: &Course, s: f64) -> Expansion {
        if self.piece_and_kind & 1 == 1 {
            return self.expand_conic(fma, course, s);
        }
        let [r, dr, ddr] = cubic(fma, &self.r, self.r[0], s);
        let [x, dx, ddx] = cubic(fma, &self.z, self.z[0] + course.x, s);
        let (value, half_slope, half_bend) = (
            fma.fused(x, x, fma.fused(-(course.eta * r), r, course.kappa)),
            fma.fused(x, dx, -(course.eta * r) * dr),
            fma.fused(x, ddx, dx * dx) - course.eta * fma.fused(r, ddr, dr * dr),
        );
        Expansion { value, half_slope, half_bend, x, dx }
    }

    /// The same times the square of the denominator.
    #[inline(always)]
    fn expand_conic(&self, fma: impl Fused, course: &Course, s: f64) -> Expansion {
        let (b, a) = (self.r[3], self.z[3]);
        let q = fma.fused(fma.fused(a, s, b), s, 1.0);
        let (dq, ddq) = (fma.fused(2.0 * a, s, b), 2.0 * a);
        let r = fma.fused(fma.fused(self.r[2], s, self.r[1]), s, self.r[0]);
        let (dr, ddr) = (fma.fused(2.0 * self.r[2], s, self.r[1]), 2.0 * self.r[2]);
        let z = fma.fused(fma.fused(self.z[2], s, self.z[1]), s, self.z[0]);
        let (dz, ddz) = (fma.fused(2.0 * self.z[2], s, self.z[1]), 2.0 * self.z[2]);
        let x = fma.fused(course.x, q, z);
        let (dx, ddx) = (fma.fused(course.x, dq, dz), fma.fused(course.x, ddq, ddz));
        let (eta, kappa) = (course.eta, course.kappa);
        let value = fma.fused(x, x, fma.fused(kappa * q, q, -(eta * r) * r));
        let half_slope = fma.fused(x, dx, fma.fused(kappa * q, dq, -(eta * r) * dr));
        let half_bend = fma.fused(x, ddx, dx * dx) + kappa * fma.fused(q, ddq, dq * dq)
            - eta * fma.fused(r, ddr, dr * dr);
        Expansion { value, half_slope, half_bend, x, dx }
    }
}

#[inline(always)]
fn quadratic_value(fma: impl Fused, c: &[f64; 4], s: f64) -> f64 {
    fma.fused(fma.fused(c[2], s, c[1]), s, c[0])
}

#[inline(always)]
fn cubic_value(fma: impl Fused, c: &[f64; 4], s: f64) -> f64 {
    fma.fused(fma.fused(fma.fused(c[3], s, c[2]), s, c[1]), s, c[0])
}

/// F with half its first and half its second derivative, and X with its derivative, all at one place.
struct Expansion {
    value: f64,
    half_slope: f64,
    half_bend: f64,
    x: f64,
    dx: f64,
}

/// How many roots are found at once.
const WIDTH: usize = 8;

/// The numbers that eight roots depend on, side by side.
#[derive(Default)]
#[repr(C, align(64))]
struct Columns {
    r: [[f64; WIDTH]; 4],
    z: [[f64; WIDTH]; 4],
    /// The denominators' coefficients.
    q: [[f64; WIDTH]; 2],
    /// X at z = 0, eta, kappa.
    course: [[f64; WIDTH]; 3],
    s: [f64; WIDTH],
}

/// Finds up to eight roots, each on a leaf, of a course, near a guess and on a half of the ray, as
/// [`Leaf::hit`] does: the place on the piece and the ray parameter, not a number if they were not found.
#[inline(always)]
pub(super) fn solve<'a, S: Simd>(
    simd: S,
    tasks: &[(&'a Leaf, &'a Course, f32, bool)],
    found: &mut [Place; WIDTH],
) {
    let mut c = Columns::default();
    let mut conics = false;
    for (i, (leaf, course, guess, _)) in tasks.iter().enumerate().take(WIDTH) {
        let conic = leaf.piece_and_kind & 1 == 1;
        conics |= conic;
        for k in 0..3 {
            c.r[k][i] = leaf.r[k];
            c.z[k][i] = leaf.z[k];
        }
        if conic {
            (c.q[0][i], c.q[1][i]) = (leaf.r[3], leaf.z[3]);
        } else {
            (c.r[3][i], c.z[3][i]) = (leaf.r[3], leaf.z[3]);
        }
        c.course[0][i] = course.x;
        c.course[1][i] = course.eta;
        c.course[2][i] = course.kappa;
        let guess = f64::from(*guess);
        c.s[i] = if leaf.z[0] <= leaf.end { guess } else { 1.0 - guess };
    }
    let roots = if conics { c.roots::<S, true>(simd) } else { c.roots::<S, false>(simd) };
    for (i, (leaf, course, _, above)) in tasks.iter().enumerate().take(WIDTH) {
        let inside = (-OVERSHOOT..=1.0 + OVERSHOOT).contains(&roots.s[i]);
        let known = inside && roots.step[i].abs() <= LAST_STEP && (roots.x[i] >= 0.0) == *above;
        if known {
            let s = greater(lesser(roots.s[i], 1.0), 0.0);
            let t = course.t(roots.r[i], roots.z[i], *above);
            found[i] = (Best(simd).fused(s, leaf.share, leaf.first), t);
        } else {
            found[i] = (f64::NAN, f64::NAN);
        }
    }
}

/// Eight roots, with the last step that led there.
struct Solved {
    s: [f64; WIDTH],
    step: [f64; WIDTH],
    x: [f64; WIDTH],
    r: [f64; WIDTH],
    z: [f64; WIDTH],
}

impl Columns {
    /// A step of Halley's and two of Newton's.
    #[inline(always)]
    fn roots<S: Simd, const CONIC: bool>(&self, simd: S) -> Solved {
        let load = |lanes: &[f64; WIDTH]| f64x8::from_slice(simd, lanes);
        let two = f64x8::splat(simd, 2.0);
        let half = f64x8::splat(simd, 0.5);
        let mut s = load(&self.s);
        let [value, slope, bend, _] = self.expand::<S, CONIC>(simd, s);
        let curvature = (slope * slope) * f64x8::splat(simd, 4.0) - value * bend;
        s -= (two * (value * slope)) / curvature;
        let [value, slope, ..] = self.expand::<S, CONIC>(simd, s);
        s -= half * value / slope;
        let [value, slope, _, x] = self.expand::<S, CONIC>(simd, s);
        let step = half * value / slope;
        s -= step;
        let clamped = s.max(f64x8::splat(simd, 0.0)).min(f64x8::splat(simd, 1.0));
        let mut r = cubic_of(simd, &self.r, clamped)[0];
        let mut z = cubic_of(simd, &self.z, clamped)[0];
        if CONIC {
            let one = f64x8::splat(simd, 1.0);
            let q = load(&self.q[1]).mul_add(clamped, load(&self.q[0])).mul_add(clamped, one);
            (r, z) = (r / q, z / q);
        }
        Solved { s: s.into(), step: step.into(), x: x.into(), r: r.into(), z: z.into() }
    }

    /// F, half its first and half its second derivative, and X, as [`Leaf::expand`].
    #[inline(always)]
    fn expand<S: Simd, const CONIC: bool>(&self, simd: S, s: f64x8<S>) -> [f64x8<S>; 4] {
        let load = |lanes: &[f64; WIDTH]| f64x8::from_slice(simd, lanes);
        let [offset, eta, kappa] = [0, 1, 2].map(|i: usize| load(&self.course[i]));
        let [r, dr, ddr] = cubic_of(simd, &self.r, s);
        let [z, dz, ddz] = cubic_of(simd, &self.z, s);
        let er = eta * r;
        if CONIC {
            let (b, a) = (load(&self.q[0]), load(&self.q[1]));
            let q = a.mul_add(s, b).mul_add(s, f64x8::splat(simd, 1.0));
            let ddq = a + a;
            let dq = ddq.mul_add(s, b);
            let x = offset.mul_add(q, z);
            let (dx, ddx) = (offset.mul_add(dq, dz), offset.mul_add(ddq, ddz));
            let kq = kappa * q;
            let value = x * x + (kq * q - er * r);
            let slope = x * dx + (kq * dq - er * dr);
            let bend =
                (x * ddx + dx * dx) + kappa * (q * ddq + dq * dq) - eta * (r * ddr + dr * dr);
            return [value, slope, bend, x];
        }
        let x = z + offset;
        let value = x.mul_add(x, kappa - er * r);
        let slope = x.mul_sub(dz, er * dr);
        let bend = x.mul_add(ddz, dz * dz) - eta * r.mul_add(ddr, dr * dr);
        [value, slope, bend, x]
    }
}

/// Cubics with their first and second derivatives.
#[inline(always)]
fn cubic_of<S: Simd>(simd: S, c: &[[f64; WIDTH]; 4], s: f64x8<S>) -> [f64x8<S>; 3] {
    let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|i: usize| f64x8::from_slice(simd, &c[i]));
    let last = c3 * s;
    let inner = c2 + last;
    let value = inner.mul_add(s, c1).mul_add(s, c0);
    let slope = (inner + inner + last).mul_add(s, c1);
    let bend = inner + last + last;
    [value, slope, bend + bend]
}

/// A cubic with its first and second derivative; its constant coefficient is given apart.
#[inline(always)]
fn cubic(fma: impl Fused, c: &[f64; 4], constant: f64, s: f64) -> [f64; 3] {
    let last = c[3] * s;
    let inner = c[2] + last;
    let value = fma.fused(fma.fused(inner, s, c[1]), s, constant);
    let slope = fma.fused(inner + inner + last, s, c[1]);
    [value, slope, 2.0 * (inner + last + last)]
}

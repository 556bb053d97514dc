//! The hits of a ray on one piece of the profile: all of them, and in the right number.
//!
//! On a piece, F (see [`meridian`](crate::meridian)) is a polynomial of twice the piece's degree.
//! Its Bernstein coefficients are built from control values shifted next to the ray; the number of
//! their sign changes says how many roots there can be: 0 none, 1 exactly one, otherwise the piece
//! is halved. A single root is found by bracketed Newton steps on F in factored form.
//!
//! Whether the number of hits is even or odd depends on nothing but the signs of F at the two ends
//! of the piece, with sign(0) = +. Both pieces at a joint compute the same bits there, so that
//! neighbours can neither both claim a hit nor both drop it, and a closed profile has an even number.
//! Where rounding hides whether the ray touches the surface or passes it, the signs at the ends
//! decide: a tangency has two hits or none, never one.
//!
//! A shallow ray meets a piece that it crosses near its closest approach to the axis twice, and F
//! becomes a perfect square as dz -> 0. There the piece is split at the height z* of that approach,
//! X(s*) = 0, into parts that each meet one half of the ray only; X then has full relative accuracy
//! beside s*, and so has F.

use crate::meridian::Meridian;
use crate::numeric::{UNIT_ROUNDOFF, difference_of_products, gamma, reciprocal_power_of_two};
use crate::piece::{Kind, Piece};

/// Reports every hit of the whole line on a piece, as (s, t), in no particular order.
#[inline]
pub(crate) fn hits(piece: &Piece, ray: &Meridian, mut report: impl FnMut(f64, f64)) {
    crossings(piece, ray, |s, t, _| report(s, t));
}

/// The same hits as (s, t, step): `step` is by how much the winding number of the profile round the
/// point of the meridian grows as the ray passes the hit, 1 or -1 (see `docs/solids.md`).
///
/// With the ray going up, F >= 0 is to its left, so that a profile along which F falls crosses it
/// from left to right: 1. It comes from the same signs as the hit itself, so that the steps of one
/// piece add up to what the signs of F at its ends say.
#[inline]
pub(crate) fn crossings(piece: &Piece, ray: &Meridian, mut report: impl FnMut(f64, f64, i32)) {
    if piece.kind == Kind::Line && misses_line(piece, ray) {
        return;
    }
    let x = piece.z.map(|z| ray.x(z));
    if ray.steep || (x[0] >= 0.0) == (x[3] >= 0.0) {
        let stretch = Stretch { r: piece.r, x, weights: Weights::of(piece.kind), s: [0.0, 1.0] };
        stretch.hits(piece, ray, x[0] >= 0.0, &mut report);
    } else {
        hits_across(piece, ray, &x, &mut report);
    }
}

/// Whether the coefficients of F on a straight piece, as [`Stretch`] has them, are all of one sign, and
/// the ray's closest approach to the axis lies elsewhere. Most rays miss most frusta of a polyline.
#[inline]
fn misses_line(piece: &Piece, ray: &Meridian) -> bool {
    let (r, x) = ([piece.r[0], piece.r[3]], [ray.x(piece.z[0]), ray.x(piece.z[3])]);
    let across = !ray.steep && (x[0] >= 0.0) != (x[1] >= 0.0);
    let negative = |i: usize, j: usize| ray.form([x[i], x[j]], [r[i], r[j]]) < 0.0;
    let [first, middle, last] = [negative(0, 0), negative(0, 1), negative(1, 1)];
    !across && first == middle && middle == last
}

/// The hits of a shallow ray whose closest approach to the axis lies within the heights of the piece.
fn hits_across(
    piece: &Piece,
    ray: &Meridian,
    x: &[f64; 4],
    report: &mut impl FnMut(f64, f64, i32),
) {
    let rising = x[0] < 0.0;
    let secant = x[0] / (x[0] - x[3]);
    let s = bracketed_root(|s| piece.coordinate(x, s), [0.0, 1.0], !rising, secant);
    if ray.eta == 0.0 {
        // Perpendicular to the axis: both hits share s.
        let step = if rising { 1 } else { -1 };
        if let Some([first, second]) = ray.chord(piece.coordinate(&piece.r, s).0) {
            report(s, first, step);
            report(s, second, -step);
        }
        return;
    }
    let whole = Stretch { r: piece.r, x: *x, weights: Weights::of(piece.kind), s: [0.0, 1.0] };
    let [mut first, mut second] = whole.split(piece.kind, s);
    first.x[3] = 0.0;
    second.x[0] = 0.0;
    first.hits(piece, ray, !rising, report);
    second.hits(piece, ray, rising, report);
}

/// The homogeneous weights of the control points of a conic; 1 throughout on other pieces.
#[derive(Clone, Copy)]
struct Weights([f64; 3]);

impl Weights {
    #[inline]
    fn of(kind: Kind) -> Self {
        match kind {
            Kind::Conic(w) => Self([1.0, w, 1.0]),
            _ => Self([1.0; 3]),
        }
    }
}

/// A part of a piece, by the control values of r and X.
#[derive(Clone, Copy)]
struct Stretch {
    r: [f64; 4],
    x: [f64; 4],
    weights: Weights,
    /// The parameters on the piece of its two ends.
    s: [f64; 2],
}

/// The Bernstein coefficients of F on a stretch; those beyond the degree are not used.
struct Coefficients {
    c: [f64; 7],
    degree: usize,
}

impl Coefficients {
    /// How often the sign changes from one coefficient to the next, with sign(0) = +.
    #[inline]
    fn sign_changes(&self) -> u32 {
        let negative = |c: &f64| *c < 0.0;
        let signs = &self.c[..=self.degree];
        signs.windows(2).map(|pair| u32::from(negative(&pair[0]) != negative(&pair[1]))).sum()
    }

    fn largest(&self) -> f64 {
        self.c[..=self.degree].iter().fold(0.0, |m: f64, c| m.max(c.abs()))
    }
}

/// Nearer than this to an end, F may have no digit that is not rounding: where it has a double root
/// at the end, it has grown to u at the square root of u, some 2^-26, and to 2^12 u here.
const CLOSE: f64 = 1.0 / 1_048_576.0;

/// A tangency is told by rounding long before this; it only bounds the recursion.
const MOST_HALVINGS: u32 = 64;

impl Stretch {
    /// Reports the hits on this stretch; `above` tells on which half of the ray they lie.
    #[inline]
    fn hits(
        &self,
        piece: &Piece,
        ray: &Meridian,
        above: bool,
        report: &mut impl FnMut(f64, f64, i32),
    ) {
        let f = self.coefficients(piece.kind, ray);
        match f.sign_changes() {
            0 => {}
            1 => {
                let s = self.single_root(piece, ray, &f);
                report_at(s, f.c[0] >= 0.0, piece, ray, above, report);
            }
            _ if piece.kind == Kind::Line => {
                if let Some([falling, rising]) = self.two_roots(ray, &f) {
                    report_at(falling, true, piece, ray, above, report);
                    report_at(rising, false, piece, ray, above, report);
                }
            }
            _ => self.hits_by_halving(piece, ray, above, report, MOST_HALVINGS),
        }
    }

    /// Halves the stretch until each part has no root, one, or cannot be told apart from a tangency.
    #[cold]
    fn hits_by_halving(
        &self,
        piece: &Piece,
        ray: &Meridian,
        above: bool,
        report: &mut impl FnMut(f64, f64, i32),
        halvings: u32,
    ) {
        let f = self.coefficients(piece.kind, ray);
        match f.sign_changes() {
            0 => {}
            1 => {
                let s = self.single_root(piece, ray, &f);
                report_at(s, f.c[0] >= 0.0, piece, ray, above, report);
            }
            _ if halvings == 0 || f.largest() <= self.rounding(piece, ray) => {
                // A tangency: the ends decide.
                if (f.c[0] < 0.0) != (f.c[f.degree] < 0.0) {
                    let middle = 0.5 * (self.s[0] + self.s[1]);
                    report_at(middle, f.c[0] >= 0.0, piece, ray, above, report);
                }
            }
            _ => {
                for half in self.split(piece.kind, 0.5) {
                    half.hits_by_halving(piece, ray, above, report, halvings - 1);
                }
            }
        }
    }

    /// How far rounding can have moved a coefficient of F: each is a mean of at most four terms made
    /// in at most eight operations, of control values that carry the error of at most eight more, be
    /// it from halving: then it is relative to the whole piece, however short the stretch.
    fn rounding(&self, piece: &Piece, ray: &Meridian) -> f64 {
        let largest = |c: &[f64; 4]| c.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let (x, r) = (largest(&self.x), largest(&self.r));
        let x_error = gamma(8) * ray.x(piece.z[0]).abs().max(ray.x(piece.z[3]).abs());
        let r_error = gamma(8) * piece.r[0].max(piece.r[3]);
        gamma(20) * ray.magnitude(x, r)
            + x_error * (2.0 * x + x_error)
            + ray.eta * (r_error * (2.0 * r + r_error))
    }

    #[inline]
    fn coefficients(&self, kind: Kind, ray: &Meridian) -> Coefficients {
        let (r, x) = (&self.r, &self.x);
        let f = |i: usize, j: usize| ray.form([x[i], x[j]], [r[i], r[j]]);
        let (first, last) = (f(0, 0), f(3, 3));
        let (c, degree) = match kind {
            Kind::Line => ([first, f(0, 3), last, 0.0, 0.0, 0.0, 0.0], 2),
            Kind::Quadratic => {
                let middle = (f(0, 3) + 2.0 * f(1, 1)) / 3.0;
                ([first, f(0, 1), middle, f(1, 3), last, 0.0, 0.0], 4)
            }
            Kind::Conic(_) => {
                let [w0, w1, w2] = self.weights.0;
                let middle = (w0 * w2 * f(0, 3) + 2.0 * (w1 * w1) * f(1, 1)) / 3.0;
                let (left, right) = (w0 * w1 * f(0, 1), w1 * w2 * f(1, 3));
                ([w0 * w0 * first, left, middle, right, w2 * w2 * last, 0.0, 0.0], 4)
            }
            Kind::Cubic => {
                let c2 = (2.0 * f(0, 2) + 3.0 * f(1, 1)) / 5.0;
                let c3 = (f(0, 3) + 9.0 * f(1, 2)) / 10.0;
                let c4 = (2.0 * f(1, 3) + 3.0 * f(2, 2)) / 5.0;
                ([first, f(0, 1), c2, c3, c4, f(2, 3), last], 6)
            }
        };
        Coefficients { c, degree }
    }

    /// The parameter on the piece of the only root on this stretch.
    #[inline]
    fn single_root(&self, piece: &Piece, ray: &Meridian, f: &Coefficients) -> f64 {
        let positive = f.c[0] >= 0.0;
        let [s0, s1] = self.s;
        if piece.kind == Kind::Line {
            let (unit2, discriminant) = self.discriminant(ray);
            let [falling, rising] = quadratic_roots(f, unit2, discriminant);
            let s = if positive { falling } else { rising };
            return s0 + (s1 - s0) * s.clamp(0.0, 1.0);
        }
        // F is a difference of squares, X^2 - h^2 reach^2, and for a shallow ray nearly a square
        // itself; the difference of the roots of the two is nearly linear, and guesses better.
        let (f0, f1) = (f.c[0], f.c[f.degree]);
        let (g0, g1) = if ray.steep {
            (f0, f1)
        } else {
            let g = |x: f64, r: f64| x.abs() - ray.h * ray.reach2(r).max(0.0).sqrt();
            (g(self.x[0], self.r[0]), g(self.x[3], self.r[3]))
        };
        let mut guess = g0 / (g0 - g1);
        let close = !(CLOSE..=1.0 - CLOSE).contains(&guess);
        if close {
            // An end that lies on the ray is no root of this stretch if the signs say so, but beside
            // it F is nothing but rounding: look elsewhere. Where the piece was split, X = 0, F is as
            // exact as anywhere.
            let noise = self.rounding(piece, ray);
            let on_ray = |f: f64, x: f64| f.abs() <= noise && x != 0.0;
            if on_ray(f0, self.x[0]) || on_ray(f1, self.x[3]) {
                guess = 0.5;
            }
        }
        let f = |s| {
            let jet = piece.jet(s);
            let (r, x) = (jet.point.r, ray.x(jet.point.z));
            let value = ray.form([x, x], [r, r]);
            (value, 2.0 * (x * ray.slope() * jet.tangent.z - ray.eta * (r * jet.tangent.r)))
        };
        if close {
            // At a pole that the ray passes through, F ends in what is all but a double root, which is none
            // of this stretch but would hold the search: it is left out if the root is not there.
            let near = s0 + (s1 - s0) * if guess < 0.5 { CLOSE } else { 1.0 - CLOSE };
            let before = (f(near).0 >= 0.0) != positive;
            if before != (guess < 0.5) {
                let part = if before { [s0, near] } else { [near, s1] };
                return bracketed_root(f, part, positive, 0.5 * (part[0] + part[1]));
            }
        }
        bracketed_root(f, self.s, positive, s0 + (s1 - s0) * guess)
    }

    /// The two roots on a straight stretch whose coefficients change sign twice, or none.
    fn two_roots(&self, ray: &Meridian, f: &Coefficients) -> Option<[f64; 2]> {
        let (unit2, discriminant) = self.discriminant(ray);
        (discriminant > 0.0).then(|| {
            let [s0, s1] = self.s;
            quadratic_roots(f, unit2, discriminant).map(|s| s0 + (s1 - s0) * s.clamp(0.0, 1.0))
        })
    }

    /// c1^2 - c0 c2 on a straight stretch. Lagrange's identity for the form F brings it to terms that
    /// cancel only where the ray is tangent to the cone. The cross product must not be rounded to the size of
    /// its terms: on a segment of length l that would move the roots as if F were off by u R^3 / l.
    ///
    /// Products of four lengths leave the range of an f64 where squares do not: lengths are in units of a power
    /// of two near the stretch's size. The first result is what squares must be multiplied by.
    fn discriminant(&self, ray: &Meridian) -> (f64, f64) {
        let ([x0, .., x1], [r0, .., r1]) = (self.x, self.r);
        let size = x0.abs().max(x1.abs()).max(r0).max(r1);
        let unit = reciprocal_power_of_two(size.max(f64::MIN_POSITIVE.sqrt()));
        let ([x0, x1], [r0, r1]) = ([x0, x1].map(|x| x * unit), [r0, r1].map(|r| r * unit));
        let (dx, dr, cross) = (x1 - x0, r1 - r0, difference_of_products(x0, r1, x1, r0));
        let (unit2, kappa) = (unit * unit, ray.kappa() * (unit * unit));
        (unit2, ray.eta * (cross * cross) + kappa * (ray.eta * (dr * dr) - dx * dx))
    }

    /// The two parts before and after the parameter u, 0 <= u <= 1, of this stretch.
    fn split(&self, kind: Kind, u: f64) -> [Self; 2] {
        let middle = self.s[0] + (self.s[1] - self.s[0]) * u;
        let mut parts = [*self, *self];
        parts[0].s[1] = middle;
        parts[1].s[0] = middle;
        let mix = |a: f64, b: f64| (1.0 - u) * a + u * b;
        if let Kind::Conic(_) = kind {
            let [w0, w1, w2] = self.weights.0;
            let (left, right) = (mix(w0, w1), mix(w1, w2));
            let center = mix(left, right);
            parts[0].weights = Weights([w0, left, center]);
            parts[1].weights = Weights([center, right, w2]);
            for (i, c) in [&self.r, &self.x].into_iter().enumerate() {
                let (l, r) = (mix(w0 * c[0], w1 * c[1]), mix(w1 * c[1], w2 * c[3]));
                let m = mix(l, r) / center;
                let halves = [[c[0], l / left, m, m], [m, r / right, c[3], c[3]]];
                for (part, half) in parts.iter_mut().zip(halves) {
                    *(if i == 0 { &mut part.r } else { &mut part.x }) = half;
                }
            }
            return parts;
        }
        for (i, c) in [&self.r, &self.x].into_iter().enumerate() {
            let halves = match kind {
                Kind::Line => {
                    let m = mix(c[0], c[3]);
                    [[c[0], m, m, m], [m, c[3], c[3], c[3]]]
                }
                Kind::Quadratic => {
                    let (l, r) = (mix(c[0], c[1]), mix(c[1], c[3]));
                    let m = mix(l, r);
                    [[c[0], l, m, m], [m, r, c[3], c[3]]]
                }
                _ => {
                    let (ab, bc, cd) = (mix(c[0], c[1]), mix(c[1], c[2]), mix(c[2], c[3]));
                    let (abc, bcd) = (mix(ab, bc), mix(bc, cd));
                    let m = mix(abc, bcd);
                    [[c[0], ab, abc, m], [m, bcd, cd, c[3]]]
                }
            };
            for (part, half) in parts.iter_mut().zip(halves) {
                *(if i == 0 { &mut part.r } else { &mut part.x }) = half;
            }
        }
        parts
    }
}

/// Reports the hit at s; `falls` tells the sign of F before and after it.
#[inline]
fn report_at(
    s: f64,
    falls: bool,
    piece: &Piece,
    ray: &Meridian,
    above: bool,
    report: &mut impl FnMut(f64, f64, i32),
) {
    let point = piece.jet(s).point;
    let step = if falls == (ray.dz >= 0.0) { 1 } else { -1 };
    report(s, ray.t(point.r, point.z, above), step);
}

/// The roots of a quadratic in Bernstein form, real by the caller's word: first the one where it
/// falls, then the one where it rises. With A = c0 - 2 c1 + c2, B = c1 - c0 and the discriminant
/// B^2 - A c0 these are (-B -/+ sqrt(discriminant)) / A, computed without cancellation. F is to be multiplied by
/// `unit2` before.
///
/// The root nearer to 0 is c0 / q with q = |B| + sqrt(discriminant). Beside a joint at which the ray touches
/// the surface all three are rounding and need not fit each other, but that root is no larger than the
/// geometric mean of both, sqrt(c0 / A), which is as far as the rounding of c0 moves it.
#[inline]
fn quadratic_roots(f: &Coefficients, unit2: f64, discriminant: f64) -> [f64; 2] {
    let [c0, c1, c2] = [f.c[0] * unit2, f.c[1] * unit2, f.c[2] * unit2];
    let (a, b) = ((c0 - c1) + (c2 - c1), c1 - c0);
    let q = (b.abs() + discriminant.max(0.0).sqrt()).max((a * c0).abs().sqrt());
    match (q == 0.0, b < 0.0) {
        (true, _) => [0.0; 2],
        (_, true) => [c0 / q, q / a],
        (_, false) => [-q / a, -c0 / q],
    }
}

/// The root of a function between two parameters, by Newton steps that never leave the bracket and
/// give way to bisection where they do not at least halve.
///
/// `positive` is the sign at the first end; the other end has the other one. The function itself is
/// never asked at the ends, where its rounding might say otherwise.
#[inline]
pub(crate) fn bracketed_root(
    f: impl Fn(f64) -> (f64, f64),
    [mut lo, mut hi]: [f64; 2],
    positive: bool,
    guess: f64,
) -> f64 {
    let mut s = if lo < guess && guess < hi { guess } else { 0.5 * (lo + hi) };
    let mut last_step = hi - lo;
    let mut converging = false;
    loop {
        // The parameter is between 0 and 1: it cannot be known better.
        if hi - lo <= 2.0 * UNIT_ROUNDOFF || !(lo < s && s < hi) {
            return s.max(lo).min(hi);
        }
        let (value, derivative) = f(s);
        if value == 0.0 {
            return s;
        }
        if (value > 0.0) == positive {
            lo = s;
        } else {
            hi = s;
        }
        let newton = s - value / derivative;
        if newton == s {
            return s;
        }
        let step = (newton - s).abs();
        let ratio = step / last_step;
        // Also false where the derivative vanishes and the quotient is NaN, and where the step ends just on an end: that
        // is not to be asked, nor is it the root for being met.
        let good = lo < newton && newton < hi && ratio <= 0.5;
        if !good {
            s = 0.5 * (lo + hi);
            last_step = 0.5 * (hi - lo);
            converging = false;
            continue;
        }
        s = newton;
        // Newton steps shrink as step' = c step^2. What the last two say of c may be too little by
        // chance, and 16 is more than it is away from a tangency.
        let c = (ratio / last_step).max(16.0);
        let rest = if converging { c * step * step } else { step };
        if rest <= 0.5 * UNIT_ROUNDOFF {
            return s;
        }
        last_step = step;
        converging = true;
    }
}

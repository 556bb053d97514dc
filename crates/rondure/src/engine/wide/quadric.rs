//! A quadric of revolution beside a stretch of a piece, with bounds: the shell round a leaf.
//!
//! With w = rho^2 and zeta the height above the middle of the stretch, a quadric of revolution is the
//! set where
//!
//! ```text
//! Q = alpha w + beta zeta + gamma + p zeta^2 = 0,
//! ```
//!
//! and along a ray Q is a quadratic in t. It goes through three points of the stretch, or, where that
//! is no good, is the paraboloid (p = 0) through two. Q is scaled to a gradient of 1 in (r, z) at the
//! middle, so that its values are nearly distances.
//!
//! The place along the stretch is `lambda`, affine in (zeta, w), from -1 to 1. As neither r nor z turns
//! it grows along the curve, which is therefore Q = h(lambda), with |h| <= `error` and |h'| <= `slope`.
//! Both are bounds by Bernstein coefficients, good on the stretch and a little beyond.

use super::bernstein::{derivative, polar, product, whole};
use crate::numeric::gamma;
use crate::piece::{Kind, Piece};

/// By how much a fit is good beyond the stretch, as a part of its length.
const BEYOND: f64 = 1.0 / 16.0;
/// Into how many parts the stretch is cut, to have its Bernstein coefficients near it.
const PARTS: usize = 3;
/// What curvature costs, in units of the error, when two quadrics are compared: in a block of height h a term of Q is
/// p h^2, and this is its rounding to f32 for h = 1/8.
const CURVED: f64 = ROUNDOFF * (1.0 / 64.0);
/// The unit roundoff of f32.
const ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;
/// What rounding leaves of a coefficient that vanishes, as a part of the largest: fewer than 1024 roundings go
/// into one.
const NOTHING: f64 = gamma(1024);

/// A quadric of revolution beside a stretch of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadric {
    /// The height from which zeta counts.
    pub(super) z: f64,
    pub(super) alpha: f64,
    pub(super) beta: f64,
    pub(super) gamma: f64,
    pub(super) p: f64,
    /// Bounds on |Q| and on the derivative of Q by lambda along the curve; infinite if there is none.
    pub(super) error: f64,
    pub(super) slope: f64,
    /// lambda = lambda[0] zeta + lambda[1] w + lambda[2].
    pub(super) lambda: [f64; 3],
    /// The largest radius of the stretch.
    pub(super) r_max: f64,
    /// The largest |zeta|.
    pub(super) height: f64,
    /// The parameters on the piece between which the bounds hold.
    pub(super) valid: [f64; 2],
    pub(super) guess: Guess,
}

/// The parameter on the piece as a function of lambda, about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    /// By powers of lambda: s, or the square of the distance from an end on the axis.
    pub(super) by_powers: [f64; 4],
    /// The end on the axis, 0 or 1.
    pub(super) pole: Option<u32>,
    /// How far off it may be, at some places.
    pub(super) error: f64,
}

/// A stretch of a piece in homogeneous coordinates: polynomials with N coefficients over one with Q, which is 1 if there
/// is one of these. Squares have M coefficients, and derivatives of a quotient of squares have S.
struct Curve<const N: usize, const M: usize, const Q: usize, const S: usize> {
    r: [f64; N],
    z: [f64; N],
    /// The denominator.
    q: [f64; Q],
}

impl<const N: usize, const M: usize, const Q: usize, const S: usize> Curve<N, M, Q, S> {
    /// The part between two parameters, which may lie beyond the ends.
    #[inline(always)]
    fn stretch(&self, ends: [f64; 2]) -> Self {
        Self { r: part(&self.r, ends), z: part(&self.z, ends), q: part(&self.q, ends) }
    }

    /// (r, z) at a parameter.
    #[inline(always)]
    fn point(&self, s: f64) -> [f64; 2] {
        let (r, z) = (polar(&self.r, |_| s), polar(&self.z, |_| s));
        if Q == 1 {
            return [r, z];
        }
        let q = polar(&self.q, |_| s);
        [r / q, z / q]
    }
}

/// The coefficients of a polynomial on another interval.
#[inline(always)]
fn part<const N: usize>(c: &[f64; N], [u, v]: [f64; 2]) -> [f64; N] {
    core::array::from_fn(|i| polar(c, |k| if k + i + 1 < N { u } else { v }))
}

/// The monomials of Q along a curve, times the square of the denominator.
struct Monomials<const N: usize, const M: usize, const Q: usize, const S: usize> {
    w: [f64; M],
    zeta: [f64; M],
    one: [f64; M],
    zeta2: [f64; M],
    q: [f64; Q],
    /// The derivative of lambda along the curve, times the cube of the denominator.
    along: [f64; S],
    /// The largest coefficients of those of w, zeta and zeta^2.
    largest: [f64; 3],
}

impl<const N: usize, const M: usize, const Q: usize, const S: usize> Monomials<N, M, Q, S> {
    #[inline(always)]
    fn new(curve: &Curve<N, M, Q, S>, z: f64, [a, b, c]: [f64; 3]) -> Self {
        let q: [f64; N] = core::array::from_fn(|i| curve.q[i % Q]);
        let zeta: [f64; N] = core::array::from_fn(|i| curve.z[i] - z * q[i]);
        let mut own = Self {
            w: product(whole(&curve.r), whole(&curve.r)),
            zeta: product(whole(&zeta), whole(&q)),
            one: product(whole(&q), whole(&q)),
            zeta2: product(whole(&zeta), whole(&zeta)),
            q: curve.q,
            along: [0.0; S],
            largest: [0.0; 3],
        };
        own.along = own.slope(&own.combine([b, a, c, 0.0]));
        own.largest = [&own.w, &own.zeta, &own.zeta2].map(|monomial| largest(&own.slope(monomial)));
        own
    }

    /// A combination of w, zeta, 1 and zeta^2.
    #[inline(always)]
    fn combine(&self, [w, zeta, one, zeta2]: [f64; 4]) -> [f64; M] {
        core::array::from_fn(|i| {
            w * self.w[i] + zeta * self.zeta[i] + (one * self.one[i] + zeta2 * self.zeta2[i])
        })
    }

    /// The derivative of a combination divided by the square of the denominator, times its cube.
    #[inline(always)]
    fn slope(&self, f: &[f64; M]) -> [f64; S] {
        if Q == 1 {
            return core::array::from_fn(derivative(f).1);
        }
        // (f / q^2)' q^3 = f' q - 2 f q'
        let a: [f64; S] = product(derivative(f), whole(&self.q));
        let b: [f64; S] = product(whole(f), derivative(&self.q));
        core::array::from_fn(|i| a[i] - 2.0 * b[i])
    }
}

impl Quadric {
    /// The best of those that there are, for the stretch of a piece between two parameters;
    /// coordinates are in units of `unit`.
    pub(super) fn new(piece: &Piece, ends: [f64; 2], unit: f64) -> Self {
        let ([r0, r1, r2, r3], [z0, z1, z2, z3]) =
            (piece.r.map(|r| r * unit), piece.z.map(|z| z * unit));
        match piece.kind {
            Kind::Line => {
                Self::best(&Curve::<2, 3, 1, 2> { r: [r0, r3], z: [z0, z3], q: [1.0] }, ends)
            }
            Kind::Quadratic => Self::best(
                &Curve::<3, 5, 1, 4> { r: [r0, r1, r3], z: [z0, z1, z3], q: [1.0] },
                ends,
            ),
            Kind::Cubic => Self::best(
                &Curve::<4, 7, 1, 6> { r: [r0, r1, r2, r3], z: [z0, z1, z2, z3], q: [1.0] },
                ends,
            ),
            Kind::Conic(w) => {
                let (r, z) = ([r0, w * r1, r3], [z0, w * z1, z3]);
                Self::best(&Curve::<3, 5, 3, 6> { r, z, q: [1.0, w, 1.0] }, ends)
            }
        }
    }

    fn best<const N: usize, const M: usize, const Q: usize, const S: usize>(
        curve: &Curve<N, M, Q, S>,
        [s0, s1]: [f64; 2],
    ) -> Self {
        let beyond = BEYOND * (s1 - s0);
        let widest = [s0 - beyond, s1 + beyond];
        let mut best = Self::on(curve, [s0, s1], widest);
        // Beyond an end of the piece its curve may turn.
        if (widest[0] < 0.0 || widest[1] > 1.0) && !best.slope.is_finite() {
            best = Self::on(curve, [s0, s1], [widest[0].max(0.0), widest[1].min(1.0)]);
        }
        best
    }

    fn on<const N: usize, const M: usize, const Q: usize, const S: usize>(
        curve: &Curve<N, M, Q, S>,
        [s0, s1]: [f64; 2],
        valid: [f64; 2],
    ) -> Self {
        let [start, end] = [curve.point(s0), curve.point(s1)];
        let at = |u: f64| curve.point(valid[0] + u * (valid[1] - valid[0]));
        let middle = at(0.5);
        // Between the ends, so that |zeta| is no larger than it must be.
        let z = 0.5 * (start[1] + end[1]);
        let r_max = start[0].max(end[0]);
        let lambda = lambda(start, end, z);
        let parts: [_; PARTS] = core::array::from_fn(|i| {
            let share = |i: usize| valid[0] + (valid[1] - valid[0]) * i as f64 / PARTS as f64;
            Monomials::new(&curve.stretch([share(i), share(i + 1)]), z, lambda)
        });
        let guess = Guess::new(curve, [s0, s1], z, lambda);
        let mut best = Self {
            z,
            alpha: 0.0,
            beta: 1.0,
            gamma: 0.0,
            p: 0.0,
            error: f64::INFINITY,
            slope: f64::INFINITY,
            lambda,
            r_max,
            height: (start[1] - z).abs().max((end[1] - z).abs()),
            valid,
            guess,
        };
        for [alpha, beta, p] in [through_three(at, middle, z), through_two(at)] {
            let slope = beta + 2.0 * (p * (middle[1] - z));
            let gradient = slope.hypot(2.0 * middle[0] * alpha);
            let scale = 1.0 / gradient;
            let own = Self { alpha: alpha * scale, beta: beta * scale, p: p * scale, ..best };
            let bounded = own.bounded(&parts, middle);
            let cost = |own: &Self| own.error + CURVED * own.p.abs();
            if cost(&bounded) < cost(&best) {
                best = bounded;
            }
        }
        best
    }

    /// The same with gamma in the middle, and with its bounds.
    fn bounded<const N: usize, const M: usize, const Q: usize, const S: usize>(
        mut self,
        parts: &[Monomials<N, M, Q, S>],
        middle: [f64; 2],
    ) -> Self {
        let (w, zeta) = (middle[0] * middle[0], middle[1] - self.z);
        self.gamma = -(self.alpha * w + zeta * (self.beta + self.p * zeta));
        let coefficients = |own: &Self| [own.alpha, own.beta, own.gamma, own.p];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for part in parts {
            let values = part.combine(coefficients(&self));
            for (value, one) in values.iter().zip(&part.one) {
                // A denominator that is not positive bounds nothing.
                let value = if *one > 0.0 { value / one } else { f64::NAN };
                (low, high) = (low.min(value), high.max(value));
                if value.is_nan() {
                    (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
                }
            }
        }
        self.gamma -= 0.5 * (low + high);
        self.error = 0.5 * (high - low);
        self.slope = 0.0;
        for part in parts {
            let across = part.slope(&part.combine(coefficients(&self)));
            // Terms may cancel, and what rounding leaves of them is that part of the terms.
            let [w, zeta, zeta2] = part.largest;
            let term = (self.alpha.abs() * w).max(self.beta.abs() * zeta).max(self.p.abs() * zeta2);
            let (no_across, no_along) = (NOTHING * term, NOTHING * largest(&part.along));
            for (along, across) in part.along.iter().zip(&across) {
                if *along > no_along {
                    self.slope = self.slope.max(across.abs() / along);
                } else if !(along.abs() <= no_along && across.abs() <= no_across) {
                    self.slope = f64::INFINITY;
                }
            }
        }
        if !(self.error.is_finite() && self.alpha.is_finite() && self.p.is_finite()) {
            (self.error, self.slope) = (f64::INFINITY, f64::INFINITY);
        }
        self
    }

    /// A bound on how fast lambda grows along a line, by its length.
    pub(super) fn growth(&self) -> f64 {
        self.lambda[0].abs() + 2.0 * self.lambda[1].abs() * self.r_max
    }
}

/// The largest absolute value.
#[inline(always)]
fn largest<const S: usize>(c: &[f64; S]) -> f64 {
    c.iter().fold(0.0, |most, c| most.max(c.abs()))
}

/// lambda along the chord of a stretch, in coordinates that are nearly lengths.
fn lambda([r0, z0]: [f64; 2], [r1, z1]: [f64; 2], z: f64) -> [f64; 3] {
    let (w0, w1) = (r0 * r0, r1 * r1);
    // From w to r.
    let per_w = 1.0 / (r0 + r1);
    let (dz, dr) = (z1 - z0, (w1 - w0) * per_w);
    let scale = 2.0 / (dz * dz + dr * dr);
    let (a, b) = (scale * dz, scale * dr * per_w);
    [a, b, -0.5 * (a * ((z0 - z) + (z1 - z)) + b * (w0 + w1))]
}

/// alpha, beta and p of the quadric through the middle and two more points.
fn through_three(at: impl Fn(f64) -> [f64; 2], middle: [f64; 2], z: f64) -> [f64; 3] {
    // The places of Chebyshev's nodes.
    let away = 0.25 * 3.0_f64.sqrt();
    let row = |u: f64| {
        let [r, own] = at(u);
        let (dr, dz) = (r - middle[0], own - middle[1]);
        [dr * (r + middle[0]), dz, dz * ((own - z) + (middle[1] - z))]
    };
    let ([a0, a1, a2], [b0, b1, b2]) = (row(0.5 - away), row(0.5 + away));
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

/// alpha and beta of the paraboloid parallel to a chord, and p = 0.
fn through_two(at: impl Fn(f64) -> [f64; 2]) -> [f64; 3] {
    let away = 0.25 * 2.0_f64.sqrt();
    let ([r0, z0], [r1, z1]) = (at(0.5 - away), at(0.5 + away));
    [z1 - z0, -(r1 - r0) * (r1 + r0), 0.0]
}

impl Guess {
    fn new<const N: usize, const M: usize, const Q: usize, const S: usize>(
        curve: &Curve<N, M, Q, S>,
        s: [f64; 2],
        z: f64,
        lambda: [f64; 3],
    ) -> Self {
        let plain = Self::with(curve, s, z, lambda, None);
        let on_axis = |i: usize| s[i] == i as f64 && curve.point(s[i])[0] == 0.0;
        let poles = [0, 1].into_iter().filter(|&i| on_axis(i));
        let others = poles.map(|i| Self::with(curve, s, z, lambda, Some(i as u32)));
        others.fold(plain, |best, other| if other.error < best.error { other } else { best })
    }

    /// Goes through four points.
    fn with<const N: usize, const M: usize, const Q: usize, const S: usize>(
        curve: &Curve<N, M, Q, S>,
        [s0, s1]: [f64; 2],
        z: f64,
        [a, b, c]: [f64; 3],
        pole: Option<u32>,
    ) -> Self {
        let lambda_at = |s: f64| {
            let [r, own] = curve.point(s);
            a * (own - z) + (b * (r * r) + c)
        };
        let place = |s: f64| pole.map_or(s, |end| (s - f64::from(end)).powi(2));
        let nodes = [0.038, 0.309, 0.691, 0.962].map(|u| {
            let s = s0 + u * (s1 - s0);
            [lambda_at(s), place(s)]
        });
        // Newton's divided differences, then powers.
        let [[x0, mut y0], [x1, mut y1], [x2, mut y2], [x3, mut y3]] = nodes;
        y3 = (y3 - y2) / (x3 - x2);
        y2 = (y2 - y1) / (x2 - x1);
        y1 = (y1 - y0) / (x1 - x0);
        y3 = (y3 - y2) / (x3 - x1);
        y2 = (y2 - y1) / (x2 - x0);
        y3 = (y3 - y2) / (x3 - x0);
        let c2 = y2 - y3 * (x0 + x1 + x2);
        let c1 = y1 - y2 * (x0 + x1) + y3 * (x0 * x1 + x0 * x2 + x1 * x2);
        y0 += -y1 * x0 + y2 * (x0 * x1) - y3 * (x0 * x1 * x2);
        let guess = Self { by_powers: [y0, c1, c2, y3], pole, error: 0.0 };
        const SAMPLES: u32 = 12;
        let off = |i: u32| {
            let s = s0 + (s1 - s0) * (f64::from(i) / f64::from(SAMPLES));
            (guess.at(lambda_at(s)) - s).abs()
        };
        let error = (0..=SAMPLES).map(off).fold(0.0, |m: f64, e| if e <= m { m } else { e });
        Self { error: if error.is_nan() { f64::INFINITY } else { error }, ..guess }
    }

    fn at(&self, lambda: f64) -> f64 {
        let [c0, c1, c2, c3] = self.by_powers;
        let value = c0 + lambda * (c1 + lambda * (c2 + lambda * c3));
        match self.pole {
            None => value,
            Some(0) => value.max(0.0).sqrt(),
            Some(_) => 1.0 - value.max(0.0).sqrt(),
        }
    }
}

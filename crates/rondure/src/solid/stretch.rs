//! A stretch of a piece by homogeneous control points, and the few operations on Bernstein
//! coefficients that searching along it takes.

use crate::piece::{Kind, Piece};
use crate::profile::Point;

/// A stretch of a piece: control points w (r, z) and weights w, relative to some origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    r: [f64; 4],
    z: [f64; 4],
    w: [f64; 4],
    degree: usize,
    /// The parameters on the piece of its two ends.
    pub(super) s: [f64; 2],
}

/// Binomial coefficients up to the degree of |c|^2 on a cubic.
const BINOMIAL: [[f64; 7]; 7] = [
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0, 0.0, 0.0],
    [1.0, 5.0, 10.0, 10.0, 5.0, 1.0, 0.0],
    [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0],
];

/// A polynomial by its Bernstein coefficients.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polynomial {
    c: [f64; 7],
    degree: usize,
}

impl Polynomial {
    pub(super) fn coefficients(&self) -> &[f64] {
        &self.c[..=self.degree]
    }

    /// Adds the product of two polynomials times a factor; the degrees must add up to this one's.
    fn add_product(&mut self, a: &[f64], b: &[f64], factor: f64) {
        let (m, n) = (a.len() - 1, b.len() - 1);
        for (i, x) in a.iter().enumerate() {
            for (j, y) in b.iter().enumerate() {
                let weight = BINOMIAL[m][i] * BINOMIAL[n][j] / BINOMIAL[m + n][i + j];
                self.c[i + j] += factor * weight * (x * y);
            }
        }
    }

    /// How often the sign changes from one coefficient to the next, with sign(0) = +.
    pub(super) fn sign_changes(&self) -> usize {
        self.coefficients().windows(2).filter(|c| (c[0] < 0.0) != (c[1] < 0.0)).count()
    }

    /// The value and the derivative at a parameter from 0 to 1 (de Casteljau).
    pub(super) fn jet(&self, s: f64) -> (f64, f64) {
        let mut c = self.c;
        for n in (1..self.degree).rev() {
            for i in 0..=n {
                c[i] = (1.0 - s) * c[i] + s * c[i + 1];
            }
        }
        let value = (1.0 - s) * c[0] + s * c[1];
        (value, self.degree as f64 * (c[1] - c[0]))
    }
}

impl Stretch {
    /// A whole piece, seen from `origin`.
    pub(super) fn new(piece: &Piece, origin: Point) -> Self {
        let (controls, weight, degree): ([usize; 4], f64, usize) = match piece.kind {
            Kind::Line => ([0, 3, 3, 3], 1.0, 1),
            Kind::Quadratic => ([0, 1, 3, 3], 1.0, 2),
            Kind::Conic(w) => ([0, 1, 3, 3], w, 2),
            Kind::Cubic => ([0, 1, 2, 3], 1.0, 3),
        };
        let w = if degree == 2 { [1.0, weight, 1.0, 1.0] } else { [1.0; 4] };
        Self {
            r: core::array::from_fn(|i| w[i] * (piece.r[controls[i]] - origin.r)),
            z: core::array::from_fn(|i| w[i] * (piece.z[controls[i]] - origin.z)),
            w,
            degree,
            s: [0.0, 1.0],
        }
    }

    /// The stretch between two parameters of the piece, of which it must be the whole.
    pub(super) fn between(&self, [s0, s1]: [f64; 2]) -> Self {
        let mut part = *self;
        if s1 < 1.0 {
            part = part.split(s1)[0];
        }
        if s0 > 0.0 {
            part = part.split(s0 / s1)[1];
        }
        part.s = [s0, s1];
        part
    }

    /// The control points.
    pub(super) fn controls(&self) -> impl Iterator<Item = Point> + '_ {
        (0..=self.degree).map(|i| Point::new(self.r[i] / self.w[i], self.z[i] / self.w[i]))
    }

    pub(super) fn start(&self) -> Point {
        Point::new(self.r[0] / self.w[0], self.z[0] / self.w[0])
    }

    pub(super) fn end(&self) -> Point {
        let n = self.degree;
        Point::new(self.r[n] / self.w[n], self.z[n] / self.w[n])
    }

    /// The two parts before and after the fraction u, 0 <= u <= 1.
    pub(super) fn split(&self, u: f64) -> [Self; 2] {
        let middle = self.s[0] + (self.s[1] - self.s[0]) * u;
        let mut parts = [*self, *self];
        parts[0].s[1] = middle;
        parts[1].s[0] = middle;
        let n = self.degree;
        let [first, second] = &mut parts;
        for (own, left, right) in [
            (self.r, &mut first.r, &mut second.r),
            (self.z, &mut first.z, &mut second.z),
            (self.w, &mut first.w, &mut second.w),
        ] {
            let mut c = own;
            for step in 0..=n {
                left[step] = c[0];
                right[n - step] = c[n - step];
                for i in 0..n - step {
                    c[i] = (1.0 - u) * c[i] + u * c[i + 1];
                }
            }
        }
        parts
    }

    /// w^2 (|c|^2 - d^2), where c is the point of the curve; and how far rounding may have moved a
    /// coefficient.
    pub(super) fn beyond(&self, d: f64) -> (Polynomial, f64) {
        let n = self.degree;
        let mut p = Polynomial { c: [0.0; 7], degree: 2 * n };
        p.add_product(&self.r[..=n], &self.r[..=n], 1.0);
        p.add_product(&self.z[..=n], &self.z[..=n], 1.0);
        p.add_product(&self.w[..=n], &self.w[..=n], -d * d);
        let largest = |c: &[f64; 4]| c[..=n].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let (r, z, w) = (largest(&self.r), largest(&self.z), largest(&self.w));
        (p, crate::numeric::gamma(24) * (r * r + z * z + d * d * w * w))
    }

    /// c . c' up to a positive factor: the derivative of the squared distance from the origin.
    pub(super) fn outward_motion(&self) -> Polynomial {
        let (n, w) = (self.degree, &self.w);
        if n == 2 && *w != [1.0; 4] {
            // c = p / w has the derivative (p' w - p w') / w^2, whose numerator is quadratic.
            let velocity = |p: &[f64; 4]| {
                [
                    p[1] * w[0] - p[0] * w[1],
                    0.5 * (p[2] * w[0] - p[0] * w[2]),
                    p[2] * w[1] - p[1] * w[2],
                ]
            };
            let mut p = Polynomial { c: [0.0; 7], degree: 4 };
            p.add_product(&self.r[..3], &velocity(&self.r), 1.0);
            p.add_product(&self.z[..3], &velocity(&self.z), 1.0);
            return p;
        }
        let velocity = |p: &[f64; 4]| [p[1] - p[0], p[2] - p[1], p[3] - p[2]];
        let mut p = Polynomial { c: [0.0; 7], degree: 2 * n - 1 };
        p.add_product(&self.r[..=n], &velocity(&self.r)[..n], 1.0);
        p.add_product(&self.z[..=n], &velocity(&self.z)[..n], 1.0);
        p
    }
}

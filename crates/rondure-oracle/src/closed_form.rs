//! Hits of lines with sphere, cylinder, cone and torus from their equations in space, in integers.
//!
//! None of this knows about profiles: it is what the oracle itself is tested against.

use dashu_int::IBig;
use rondure::{Ray, numeric::UNIT_ROUNDOFF};

use crate::{
    exact::{Double, align, ratio, shl, sqrt, to_double},
    polynomial::{isolate, product},
};

/// A solid whose hits are roots of a quadratic or quartic; its axis is the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// A ball about the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// A closed cylinder that stands on z = 0.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A closed cone that stands on z = 0, its apex up.
    Cone {
        /// The radius of its base.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A torus in the plane z = 0.
    Torus {
        /// The distance of the tube's middle from the axis.
        major: f64,
        /// The radius of the tube.
        minor: f64,
    },
}

/// Square roots carry this many bits more than their argument's last.
const ROOT_BITS: usize = 256;

impl Solid {
    /// All hits of the whole line, in order; tangencies as none.
    pub fn hits(&self, ray: &Ray) -> Vec<Double> {
        let mut ts = match *self {
            Self::Sphere { radius } => sphere(ray, radius),
            Self::Cylinder { radius, height } => upright(ray, radius, height, false),
            Self::Cone { radius, height } => upright(ray, radius, height, true),
            Self::Torus { major, minor } => torus(ray, major, minor),
        };
        ts.sort_by(|x, y| x.hi.total_cmp(&y.hi).then(x.lo.total_cmp(&y.lo)));
        ts
    }
}

fn sphere(ray: &Ray, radius: f64) -> Vec<Double> {
    let (o, d) = (ray.origin, ray.direction);
    let (lengths, unit) = align(&[o.x, o.y, o.z, radius]);
    let (d, exponent) = align(&[d.x, d.y, d.z]);
    let dot = |a: &[IBig], b: &[IBig]| -> IBig { a.iter().zip(b).map(|(x, y)| x * y).sum() };
    let (a, b) = (dot(&d, &d), dot(&lengths[..3], &d));
    let c = dot(&lengths[..3], &lengths[..3]) - &lengths[3] * &lengths[3];
    roots(&a, &b, &c).iter().map(|(n, d)| ratio(n, d, unit - exponent)).collect()
}

/// The roots of u t^2 + 2 v t + w as fractions with a common accuracy of [`ROOT_BITS`].
fn roots(u: &IBig, v: &IBig, w: &IBig) -> Vec<(IBig, IBig)> {
    if *u == IBig::ZERO {
        return if *v == IBig::ZERO { vec![] } else { vec![(-w.clone(), v << 1)] };
    }
    let disc = v * v - u * w;
    if disc <= IBig::ZERO {
        return vec![];
    }
    let root = sqrt(&(disc << (2 * ROOT_BITS)));
    let middle = -(v << ROOT_BITS);
    vec![(&middle - &root, u << ROOT_BITS), (&middle + &root, u << ROOT_BITS)]
}

fn upright(ray: &Ray, radius: f64, height: f64, cone: bool) -> Vec<Double> {
    let (o, d) = (ray.origin, ray.direction);
    let (lengths, unit) = align(&[o.x, o.y, o.z, radius, height]);
    let [ox, oy, oz, radius, height] = core::array::from_fn(|i| lengths[i].clone());
    let (d, exponent) = align(&[d.x, d.y, d.z]);
    let [dx, dy, dz] = core::array::from_fn(|i| d[i].clone());
    let a = &dx * &dx + &dy * &dy;
    let b = &ox * &dx + &oy * &dy;
    let c = &ox * &ox + &oy * &oy;
    let mut fractions = if cone {
        // h^2 w = R^2 (h - z)^2
        let (h2, r2) = (&height * &height, &radius * &radius);
        let rest = &height - &oz;
        roots(
            &(&a * &h2 - &r2 * &dz * &dz),
            &(&b * &h2 + &r2 * &dz * &rest),
            &(&c * &h2 - &r2 * &rest * &rest),
        )
    } else {
        roots(&a, &b, &(&c - &radius * &radius))
    };
    fractions.retain(|(n, q)| {
        // q z = q oz + n dz
        let (z, top) = (&oz * q + n * &dz, &height * q);
        if *q > IBig::ZERO { z > IBig::ZERO && z < top } else { z < IBig::ZERO && z > top }
    });
    if dz != IBig::ZERO {
        for cap in if cone { vec![IBig::ZERO] } else { vec![IBig::ZERO, height.clone()] } {
            let n = cap - &oz;
            let w = &a * &n * &n + &b * &n * &dz * IBig::from(2) + &c * &dz * &dz;
            if w < &radius * &radius * &dz * &dz {
                fractions.push((n, dz.clone()));
            }
        }
    }
    fractions.iter().map(|(n, q)| ratio(n, q, unit - exponent)).collect()
}

fn torus(ray: &Ray, major: f64, minor: f64) -> Vec<Double> {
    // The stretch of the line inside a ball half as large again: generous, as `middle` is an f64 and
    // off by a few units of the distance of the origin.
    let (o, d) = (ray.origin, ray.direction);
    let speed = d.length();
    let unit = d * speed.recip();
    let middle = -o.dot(unit);
    let reach = 1.5 * (major + minor) + 32.0 * UNIT_ROUNDOFF * o.length();
    let ends = [(middle - reach) / speed, (middle + reach) / speed];
    let (lengths, mut length_unit) = align(&[o.x, o.y, o.z, major, minor]);
    let (direction, direction_unit) = align(&[d.x, d.y, d.z]);
    let (ts, t_unit) = align(&ends);
    let shift = (length_unit - (direction_unit + t_unit)).max(0);
    length_unit -= shift;
    let product_shift = direction_unit + t_unit - length_unit;
    let lift = |x: &IBig| shl(x, shift);
    let coordinate = |i: usize| -> Vec<IBig> {
        ts.iter().map(|t| lift(&lengths[i]) + shl(&(&direction[i] * t), product_shift)).collect()
    };
    // Each square carries a factor 2, the product of two of them another 12.
    let squares: Vec<Vec<IBig>> = (0..3).map(|i| product(&coordinate(i), &coordinate(i))).collect();
    let (big, small) = (lift(&lengths[3]), lift(&lengths[4]));
    let constant = (&big * &big - &small * &small) * IBig::from(2);
    let sum: Vec<IBig> =
        (0..3).map(|k| &squares[0][k] + &squares[1][k] + &squares[2][k] + &constant).collect();
    let w: Vec<IBig> = (0..3).map(|k| &squares[0][k] + &squares[1][k]).collect();
    let left = product(&sum, &sum);
    let right = product(&w, &vec![IBig::from(1); 3]);
    let quartic: Vec<IBig> =
        left.iter().zip(&right).map(|(l, r)| l - r * &big * &big * IBig::from(8)).collect();
    let mut hits = Vec::new();
    for bracket in isolate(&quartic, 120, 200).iter().filter(|b| b.changes == 1) {
        let (x, m) = bracket.middle();
        let t = shl(&ts[0], m) + (&ts[1] - &ts[0]) * x;
        hits.push(to_double(&t, t_unit - m));
    }
    hits
}

impl Solid {
    /// The sine of the angle between a line and the surface where it hits, as an f64.
    pub fn incidence(&self, ray: &Ray, t: Double) -> f64 {
        let p = ray.at(t.hi);
        let rho = p.x.hypot(p.y);
        // The normal as its radial part over rho, and its axial part; of a wall and a flat end, that of
        // the one that the point is nearer to.
        let (radial, axial) = match *self {
            Self::Sphere { .. } => (1.0, p.z),
            Self::Cylinder { radius, height } => {
                let to_end = p.z.abs().min((p.z - height).abs());
                if to_end < (rho - radius).abs() { (0.0, 1.0) } else { (1.0 / rho, 0.0) }
            }
            Self::Cone { radius, height } => {
                let slant = height.hypot(radius);
                let to_wall = (rho * height + (p.z - height) * radius).abs() / slant;
                if p.z.abs() < to_wall { (0.0, 1.0) } else { (height / rho, radius) }
            }
            Self::Torus { major, .. } => ((rho - major) / rho, p.z),
        };
        let d = ray.direction;
        let dot = radial * (p.x * d.x + p.y * d.y) + axial * d.z;
        dot.abs() / ((radial * rho).hypot(axial) * d.length())
    }
}

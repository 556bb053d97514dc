//! The profile as exact curves: integer Bernstein coefficients of r, z and (for arcs) the weight.
//!
//! Lines and Béziers are taken as they are. An arc is its ellipse, from `start_angle` over
//! `sweep_angle` (added exactly), as four rational quadratics of which each spans a quarter of the
//! sweep; its cosines and sines are rounded to 2^-`TRIGONOMETRY_BITS`. The fields of an arc
//! are f64, so the ellipse passes its `start` and `end` at a distance of some 1e-16 of its radius:
//! straight bridges, shorter than that, join the ellipse to these two points, so that the curve is
//! connected and the parity of hits exact. A hit on a bridge counts as a hit of the arc.

use dashu_int::IBig;
use rondure::{
    Point, Profile, Segment,
    profile::{Arc, Subpath},
};

use crate::{
    exact::{align, decode, shl, to_f64},
    polynomial::{derivative, product, to_power_basis},
    trigonometry::cos_sin,
};

const TRIGONOMETRY_BITS: usize = 180;

/// Pieces shorter than this fraction of the object's size are specks: some hundred unit roundoffs.
const SPECK: f64 = 1e-14;

/// One polynomial or rational curve of the profile; lengths in units of 2^[`Pieces::exponent`].
#[derive(Clone, Debug)]
pub struct Piece {
    /// The segment of the profile that it belongs to, counted over all subpaths.
    pub segment: usize,
    /// The parameters on that segment at which the piece begins and ends.
    pub span: [f64; 2],
    /// Half the angle of an arc that the piece covers; 0 if it is none.
    pub half_angle: f64,
    /// The piece before it in the chain and the one after it, if any.
    pub neighbours: [Option<usize>; 2],
    /// Bernstein coefficients of r q, z q and q.
    pub controls: [Vec<IBig>; 3],
    /// The same in the power basis.
    pub power: [Vec<IBig>; 3],
    /// The derivatives of r q, z q and q by the degree, in the power basis.
    pub slope: [Vec<IBig>; 3],
    /// Bernstein coefficients of (z q)^2, z q^2, q^2 and (r q)^2, times a common factor.
    pub squares: [Vec<IBig>; 4],
    /// Whether the piece is so short that a line may as well pass on its other side: a tiny segment,
    /// or the bridge between an arc and its end point.
    pub is_speck: bool,
    /// Whether q is 1 throughout.
    pub polynomial: bool,
}

/// All pieces of a profile.
#[derive(Clone, Debug)]
pub struct Pieces {
    /// The curves, in drawing order.
    pub list: Vec<Piece>,
    /// The power of two that all lengths are multiples of.
    pub exponent: i64,
    /// The larger of the profile's largest radius and its extent along the axis.
    pub size: f64,
    /// The middle of the profile on the axis.
    pub center: f64,
}

/// A curve before all lengths have been brought to one unit.
struct Raw {
    segment: usize,
    span: [f64; 2],
    half_angle: f64,
    controls: [Vec<IBig>; 3],
    exponent: i64,
}

impl Pieces {
    /// Takes a profile apart.
    pub fn new(profile: &Profile) -> Self {
        let mut raw = Vec::new();
        let mut chains = Vec::new();
        let mut segment = 0;
        for subpath in profile.subpaths() {
            let first = raw.len();
            for curve in subpath.segments() {
                push_segment(&mut raw, segment, curve);
                segment += 1;
            }
            chains.push((first..raw.len(), subpath));
        }
        let exponent = raw.iter().map(|r| r.exponent).min().unwrap_or(0);
        let mut list: Vec<Piece> = raw.into_iter().map(|r| finish(r, exponent)).collect();
        for (range, subpath) in chains {
            link(&mut list, range, subpath);
        }
        let coordinate = |i: usize| {
            list.iter().flat_map(move |p| {
                (0..p.controls[i].len()).filter(|&k| p.controls[2][k] != IBig::ZERO).map(move |k| {
                    to_f64(&p.controls[i][k], exponent) / to_f64(&p.controls[2][k], 0)
                })
            })
        };
        let low = coordinate(1).fold(f64::INFINITY, f64::min);
        let high = coordinate(1).fold(f64::NEG_INFINITY, f64::max);
        let radius = coordinate(0).fold(0.0, f64::max);
        let size = radius.max(high - low);
        let center = 0.5 * (low + high);
        for piece in &mut list {
            piece.is_speck = [0, 1].iter().all(|&i| piece.extent(i, exponent) <= SPECK * size);
        }
        Self { size, center, list, exponent }
    }
}

fn link(list: &mut [Piece], range: core::ops::Range<usize>, subpath: &Subpath) {
    for i in range.clone() {
        let (first, last) = (i == range.start, i + 1 == range.end);
        let around = |at_end: bool, wrapped, next| match (at_end, subpath.is_closed()) {
            (false, _) => Some(next),
            (true, true) => Some(wrapped),
            (true, false) => None,
        };
        list[i].neighbours =
            [around(first, range.end - 1, i.wrapping_sub(1)), around(last, range.start, i + 1)];
    }
}

fn push_segment(raw: &mut Vec<Raw>, segment: usize, curve: &Segment) {
    let mut bezier = |points: &[Point]| {
        let flat: Vec<f64> = points.iter().flat_map(|p| [p.r, p.z]).collect();
        let (integers, exponent) = align(&flat);
        let pick = |offset: usize| integers.iter().skip(offset).step_by(2).cloned().collect();
        let controls = [pick(0), pick(1), vec![IBig::from(1); points.len()]];
        raw.push(Raw { segment, span: [0.0, 1.0], half_angle: 0.0, controls, exponent });
    };
    match curve {
        Segment::Line(p) => bezier(p),
        Segment::Quadratic(p) => bezier(p),
        Segment::Cubic(p) => bezier(p),
        Segment::Arc(arc) => push_arc(raw, segment, arc),
    }
}

fn push_arc(raw: &mut Vec<Raw>, segment: usize, arc: &Arc) {
    const P: usize = TRIGONOMETRY_BITS;
    let (angles, angle_exponent) = align(&[arc.start_angle, arc.sweep_angle]);
    // (cos, sin) after the k-th eighth of the sweep, over 2^P.
    let direction = |k: i64| {
        let eighths = (&angles[0] << 3) + &angles[1] * IBig::from(k);
        cos_sin(&eighths, 3 - angle_exponent, P)
    };
    let (turn, turn_exponent) = decode(arc.rotation);
    let (turn_cos, turn_sin) = cos_sin(&IBig::from(turn), -turn_exponent, P);
    let [start, end] = [arc.start, arc.end];
    let [a, b] = arc.radii;
    let (lengths, exponent) =
        align(&[arc.center.r, arc.center.z, a, b, start.r, start.z, end.r, end.z]);
    let exponent = exponent - P as i64;
    // A point of the unit circle with its weight q, all over 2^P, to [r q, z q, q]; r and z are then
    // in units of 2^exponent.
    let place = |(x, y): (IBig, IBig), weight: &IBig| -> [IBig; 3] {
        let (x, y) = (&lengths[2] * &x, &lengths[3] * &y);
        let r = ((&lengths[0] * weight) << P) + (&turn_cos * &x - &turn_sin * &y);
        let z = ((&lengths[1] * weight) << P) + (&turn_sin * &x + &turn_cos * &y);
        [r, z, weight.clone()]
    };
    let one = IBig::from(1) << P;
    // Rounded to whole units, so that a piece and the next one meet exactly.
    let knot = |k: i64| -> [IBig; 2] {
        let [r, z, _] = place(direction(2 * k), &one);
        [r >> P, z >> P]
    };
    let bridge = |raw: &mut Vec<Raw>, from: &[IBig; 2], to: &[IBig; 2], at: f64| {
        if from != to {
            let pair = |i: usize| vec![from[i].clone(), to[i].clone()];
            let controls = [pair(0), pair(1), vec![IBig::from(1); 2]];
            raw.push(Raw { segment, span: [at, at], half_angle: 0.0, controls, exponent });
        }
    };
    let vertex = |i: usize| [&lengths[i] << P, &lengths[i + 1] << P];
    let (half_cos, _) = cos_sin(&angles[1], 3 - angle_exponent, P);
    bridge(raw, &vertex(4), &knot(0), 0.0);
    for quarter in 0..4 {
        let weighted = |[r, z]: [IBig; 2]| [r << P, z << P, one.clone()];
        let points = [
            weighted(knot(quarter)),
            place(direction(2 * quarter + 1), &half_cos),
            weighted(knot(quarter + 1)),
        ];
        let controls = core::array::from_fn(|i| points.iter().map(|p| p[i].clone()).collect());
        let from = 0.25 * quarter as f64;
        let (span, half_angle) = ([from, from + 0.25], arc.sweep_angle / 8.0);
        raw.push(Raw { segment, span, half_angle, controls, exponent });
    }
    bridge(raw, &knot(4), &vertex(6), 1.0);
}

fn finish(raw: Raw, exponent: i64) -> Piece {
    let [r, z, q] = raw.controls;
    let shift = raw.exponent - exponent;
    let lift = |xs: Vec<IBig>| -> Vec<IBig> { xs.iter().map(|x| shl(x, shift)).collect() };
    let controls = [lift(r), lift(z), q];
    let [r, z, q] = &controls;
    let squares = [product(z, z), product(z, q), product(q, q), product(r, r)];
    let power = [to_power_basis(r), to_power_basis(z), to_power_basis(q)];
    let slope = controls.clone().map(|c| to_power_basis(&derivative(&c)));
    let polynomial = q.iter().all(|q| *q == IBig::from(1));
    Piece {
        segment: raw.segment,
        span: raw.span,
        half_angle: raw.half_angle,
        neighbours: [None; 2],
        controls,
        power,
        slope,
        squares,
        is_speck: false,
        polynomial,
    }
}

impl Piece {
    /// Whether one of its ends, 0 or 1, lies on the axis.
    pub(crate) fn ends_on_axis(&self, end: usize) -> bool {
        let radii = &self.controls[0];
        radii[end * (radii.len() - 1)] == IBig::ZERO
    }

    /// The extent of the control points in r (0) or z (1).
    fn extent(&self, coordinate: usize, exponent: i64) -> f64 {
        let unit = |k: usize| to_f64(&self.controls[2][k], 0).recip();
        let values: Vec<f64> = self.controls[coordinate]
            .iter()
            .enumerate()
            .map(|(k, x)| to_f64(x, exponent) * unit(k))
            .collect();
        let from = values[0];
        values.iter().fold(0.0, |m, v| m.max((v - from).abs()))
    }

    /// The parameter on the segment for one on the piece; on an arc, the fraction of the sweep.
    pub fn segment_parameter(&self, local: f64) -> f64 {
        let [from, to] = self.span;
        let v = local;
        let fraction = if self.half_angle == 0.0 {
            v
        } else {
            let (sin, cos) = self.half_angle.sin_cos();
            let x = cos * ((1.0 - v) * (1.0 - v) + v * v) + 2.0 * v * (1.0 - v);
            let y = sin * (v * v - (1.0 - v) * (1.0 - v));
            0.5 * (1.0 + y.atan2(x) / self.half_angle)
        };
        from + (to - from) * fraction
    }
}

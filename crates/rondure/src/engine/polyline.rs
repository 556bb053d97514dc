//! The profile as the paper has it: a chain of points, near enough to each other, whose chords sweep
//! frusta.

use crate::arc_length;
use crate::piece::{Kind, Piece};
use crate::profile::Point;

/// Where the frusta of a polyline come from.
///
/// A hit knows its parameter on the frustum; the curve's tangent at the same place of its own
/// parameter gives the normal. Its error then falls with the square of the frustum's size, as that of
/// the point does, and shading is smooth.
#[derive(Clone, Debug)]
pub(crate) struct Polyline {
    pub(crate) curves: Vec<Piece>,
    /// One for each frustum.
    sources: Vec<Source>,
}

/// The stretch of a curve that a frustum replaces.
#[derive(Clone, Copy, Debug)]
struct Source {
    curve: u32,
    /// The parameters on the curve of the frustum's ends.
    s: [f64; 2],
}

impl Polyline {
    /// Samples monotone pieces at about `samples` points in all: each piece gets its share by arc
    /// length, at least its two ends, evenly spaced in its parameter.
    ///
    /// The second part are the frusta. The points of a piece run in the direction in which the piece
    /// does: no rounding makes r or z turn.
    pub(crate) fn sample(curves: Vec<Piece>, samples: u32) -> (Self, Vec<Piece>) {
        let lengths: Vec<f64> = curves.iter().map(arc_length::length).collect();
        let length: f64 = lengths.iter().sum();
        let mut frusta = Vec::new();
        let mut sources = Vec::new();
        for (i, (curve, own)) in curves.iter().zip(&lengths).enumerate() {
            let steps = (f64::from(samples) * (own / length)).round().max(1.0) as u32;
            let (start, end) = (curve.start(), curve.end());
            let (mut s0, mut from) = (0.0, start);
            for step in 1..=steps {
                let s1 = f64::from(step) / f64::from(steps);
                let to = if step == steps {
                    end
                } else {
                    let p = curve.jet(s1).point;
                    Point::new(between(p.r, from.r, end.r), between(p.z, from.z, end.z))
                };
                // Steps smaller than rounding are taken together with the next one.
                if to != from {
                    let controls = |a: f64, b: f64| [a, b, b, b];
                    let frustum = Piece {
                        kind: Kind::Line,
                        r: controls(from.r, to.r),
                        z: controls(from.z, to.z),
                    };
                    frusta.push(frustum);
                    sources.push(Source { curve: i as u32, s: [s0, s1] });
                    (s0, from) = (s1, to);
                }
            }
        }
        (Self { curves, sources }, frusta)
    }

    /// The curve that a frustum comes from, and the parameter there that belongs to its s.
    pub(crate) fn place(&self, frustum: usize, s: f64) -> (usize, f64) {
        let Source { curve, s: [s0, s1] } = self.sources[frustum];
        (curve as usize, s0 + (s1 - s0) * s)
    }
}

/// The number nearest to x between two others.
fn between(x: f64, a: f64, b: f64) -> f64 {
    x.clamp(a.min(b), a.max(b))
}

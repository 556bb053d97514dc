//! The integrals along the outline of a solid, each subpath reckoned from its own middle.
//!
//! For a closed subpath round the middle (r_c, z_c) the integrals of r_c^2, and of r_c^2 times any
//! polynomial in z, vanish. They are left out before anything is rounded, so that a thin ring far
//! from the axis has the accuracy of its own size.

use core::f64::consts::{PI, TAU};

use super::quadrature::{Sum, adaptive, gauss, jet, smooth_steps, steps};
use super::{NoSolid, Solid};
use crate::numeric::gamma;
use crate::profile::{Point, Segment, Subpath};

/// The height half way between the lowest and the highest end of a segment.
pub(super) fn middle<'a>(segments: impl Iterator<Item = &'a Segment>) -> f64 {
    let heights = segments.flat_map(|s| [s.start().z, s.end().z]);
    let (low, high) = heights
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
    0.5 * (low + high)
}

/// How far the numbers reach that describe a curve: their largest distance from a center in r or z,
/// of control points, and for arcs of a square round the arc.
pub(super) fn reach<'a>(segments: impl Iterator<Item = &'a Segment>, center: Point) -> f64 {
    let mut reach = 0.0_f64;
    let mut add = |p: Point, size: f64| {
        let p = p - center;
        reach = reach.max(p.r.abs() + size).max(p.z.abs() + size);
    };
    for segment in segments {
        match segment {
            Segment::Line(p) => p.iter().for_each(|p| add(*p, 0.0)),
            Segment::Quadratic(p) => p.iter().for_each(|p| add(*p, 0.0)),
            Segment::Cubic(p) => p.iter().for_each(|p| add(*p, 0.0)),
            Segment::Arc(arc) => {
                // An arc leaves its start by no more than its length, or twice its larger radius.
                let size = arc.radii[0].max(arc.radii[1]) * arc.sweep_angle.abs().min(2.0);
                add(arc.start, size);
            }
        }
    }
    reach
}

/// A subpath, moved so that its middle is the origin, and the measures of its surface.
pub(super) struct Part<'a> {
    subpath: &'a Subpath,
    /// The middle; on the axis unless the subpath is closed, because only then ∮ r_c^2 dz vanishes.
    center: Point,
    reach: f64,
    segments: Vec<Segment>,
    /// The arc length and the bound for its error.
    pub(super) length: [f64; 2],
    /// The area and the bound for its error.
    pub(super) area: [f64; 2],
}

impl<'a> Part<'a> {
    pub(super) fn new(subpath: &'a Subpath) -> Self {
        let segments = subpath.segments();
        let mut center = Point::new(0.0, middle(segments.iter()));
        if subpath.is_closed() {
            let r = segments.iter().map(|s| s.start().r);
            let (low, high) =
                r.fold((f64::INFINITY, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)));
            center.r = 0.5 * (low + high);
        }
        let reach = reach(segments.iter(), center);
        let mut sums = [Sum::default(); 4];
        for segment in segments {
            let [[length, area], [length_error, area_error]] = length_and_area(segment);
            for (sum, term) in sums.iter_mut().zip([length, length_error, area, area_error]) {
                sum.add(term);
            }
        }
        let [length, length_error, area, area_error] = sums.map(Sum::value);
        let away = Point::new(-center.r, -center.z);
        let segments = segments.iter().map(|s| s.moved(away)).collect();
        Self {
            subpath,
            center,
            reach,
            segments,
            length: [length, length_error],
            area: [area, area_error],
        }
    }

    /// ∮ of r^2 - r_c^2, of that times h, of that times h^2, and of r^4 - r_c^4, each dz along the
    /// drawing direction, where h is the height above `z` + `above`.
    ///
    /// What is subtracted integrates to zero; with it goes what would cancel. With p = r - r_c the
    /// first is p (2 r_c + p), and the last the first times r^2 + r_c^2.
    fn moments(&self, z: f64, above: f64) -> [f64; 4] {
        let up = (self.center.z - z) - above;
        let r_c = self.center.r;
        let mut sums = [Sum::default(); 4];
        for segment in &self.segments {
            for range in steps(segment) {
                let terms = gauss(
                    |s| {
                        let jet = jet(segment, s);
                        let (p, height) = (jet.point.r, jet.point.z + up);
                        let q = p * (2.0 * r_c + p) * jet.tangent.z;
                        let r = r_c + p;
                        [q, q * height, q * height * height, q * (r * r + r_c * r_c)]
                    },
                    range,
                );
                for (sum, term) in sums.iter_mut().zip(terms) {
                    sum.add(term);
                }
            }
        }
        sums.map(Sum::value)
    }
}

/// The length of a segment and the area that it sweeps, and bounds for their errors.
fn length_and_area(segment: &Segment) -> [[f64; 2]; 2] {
    let rounding = gamma(16);
    if let Segment::Line([a, b]) = segment {
        let length = (*b - *a).length();
        let area = PI * (a.r + b.r) * length;
        return [[length, area], [rounding * length, rounding * area]];
    }
    let mut sums = [Sum::default(); 4];
    for range in smooth_steps(segment) {
        let integrand = |s| {
            let jet = jet(segment, s);
            let speed = jet.tangent.length();
            [speed, TAU * jet.point.r.max(0.0) * speed]
        };
        let [[length, area], [length_error, area_error]] = adaptive(integrand, range);
        for (sum, term) in sums.iter_mut().zip([length, area, length_error, area_error]) {
            sum.add(term);
        }
    }
    let [length, area, length_error, area_error] = sums.map(Sum::value);
    [[length, area], [length_error, area_error]]
}

/// Puts the solid together. Rounding moves each point of a subpath by no more than a multiple of
/// u times its own reach, which changes the volume by that times the area.
pub(super) fn solid(
    parts: &[Part<'_>],
    senses: &[f64],
    z: f64,
    reach: f64,
) -> Result<Solid, NoSolid> {
    if let Some(i) = parts.iter().position(|part| !part.subpath.bounds_solid()) {
        let ends = [parts[i].subpath.start(), parts[i].subpath.end()];
        return Err(NoSolid::Open { subpath: i, ends });
    }
    let total = |above: f64| {
        let mut sums = [Sum::default(); 4];
        for (part, sense) in parts.iter().zip(senses) {
            for (sum, moment) in sums.iter_mut().zip(part.moments(z, above)) {
                sum.add(sense * moment);
            }
        }
        sums.map(|sum| PI * sum.value())
    };
    let [volume, first, ..] = total(0.0);
    let above = if volume > 0.0 { first / volume } else { 0.0 };
    let centroid_z = z + above;
    let [_, _, second, fourth] = total(above);
    let displaced: f64 = parts.iter().map(|part| part.reach * part.area[0]).sum();
    let volume_error = gamma(64) * displaced;
    Ok(Solid {
        volume,
        volume_error,
        centroid_z,
        // The numerator is off by the volume's error times the height above the middle.
        centroid_error: (volume_error * (2.0 * reach) / volume)
            .min(2.0 * reach)
            .max(gamma(2) * centroid_z.abs()),
        inertia_axial: 0.5 * fourth,
        inertia_transverse: 0.25 * fourth + second,
        inertia_error: volume_error * (4.0 * reach * reach),
    })
}

//! Shells: the region between two coaxial surfaces that encloses what a piece of the profile sweeps
//! (paper, sections 3.1 and 4.1.1), and whether a ray meets it.
//!
//! A cylinder shell (CY) is a box in (z, rho^2): `z0 <= z <= z1, w0 <= rho^2 <= w1`. A cone shell
//! (CO) is a strip along a chord in the same slab: `inner <= rho - slope z <= outer`. Along a ray rho
//! is convex and z linear, so that on a stretch of the ray both quantities have their largest value
//! at an end and their smallest where they turn: the tests are exact. The hybrid shell (HY) is
//! whichever of the two has the smaller area (section 3.3, criterion 1).

use crate::meridian::Meridian;
use crate::numeric::gamma;
use crate::piece::Piece;

/// The region that encloses a node's part of the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shell {
    z: [f64; 2],
    wall: Wall,
}

/// What bounds a shell inwards and outwards.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wall {
    /// Two cylinders, by their squared radii.
    Cylinder { w: [f64; 2] },
    /// Two cones: rho - slope z lies between the two offsets.
    Cone { slope: f64, offsets: [f64; 2] },
}

impl Shell {
    /// The hybrid shell round consecutive pieces: CY or CO, whichever has the smaller area.
    ///
    /// `radius` is that of the sphere round the whole surface, about its centre; the shell is
    /// padded by what rounding can do to a ray inside it.
    pub(crate) fn hybrid(pieces: &[Piece], radius: f64) -> Self {
        let (cylinder, cylinder_area) = Self::cylinder(pieces, radius);
        match Self::cone(pieces, radius) {
            Some((cone, area)) if area < cylinder_area => cone,
            _ => cylinder,
        }
    }

    /// The cylinder shell and its area in the half plane.
    fn cylinder(pieces: &[Piece], radius: f64) -> (Self, f64) {
        let r = ends(pieces, |p| p.r);
        let w_pad = padding(radius) * radius;
        let w = [r[0] * r[0] - w_pad, r[1] * r[1] + w_pad];
        let z = heights(pieces, radius);
        let area = (z[1] - z[0]) * (w[1].sqrt() - w[0].max(0.0).sqrt());
        (Self { z, wall: Wall::Cylinder { w } }, area)
    }

    /// The cone shell along the chord from the first to the last point, and its area in the half
    /// plane; `None` where the chord is horizontal.
    fn cone(pieces: &[Piece], radius: f64) -> Option<(Self, f64)> {
        let (first, last) = (pieces.first()?.start(), pieces.last()?.end());
        let slope = (last.r - first.r) / (last.z - first.z);
        if !slope.is_finite() {
            return None;
        }
        let mut offsets = [f64::INFINITY, f64::NEG_INFINITY];
        for piece in pieces {
            let controls = core::array::from_fn(|i| piece.r[i] - slope * piece.z[i]);
            let (low, high) = piece.range(&controls);
            offsets = [offsets[0].min(low), offsets[1].max(high)];
        }
        let pad = padding(radius) * (1.0 + slope.abs());
        let offsets = [offsets[0] - pad, offsets[1] + pad];
        let z = heights(pieces, radius);
        let area = (z[1] - z[0]) * (offsets[1] - offsets[0]);
        Some((Self { z, wall: Wall::Cone { slope, offsets } }, area))
    }

    /// The stretch of the ray between the parameters `range` that lies between the shell's two
    /// planes, if the ray meets the shell there.
    #[inline]
    pub(crate) fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
        let [near, far] = if ray.dz >= 0.0 { self.z } else { [self.z[1], self.z[0]] };
        // Where dz = 0 these are infinite, or NaN for a ray in the plane, which max and min ignore.
        let lo = range[0].max((near - ray.oz) * ray.inverse_dz);
        let hi = range[1].min((far - ray.oz) * ray.inverse_dz);
        if lo > hi {
            return None;
        }
        let x = [ray.offset + ray.speed * lo, ray.offset + ray.speed * hi];
        let w = x.map(|x| x * x + ray.delta2);
        let turns = x[0] < 0.0 && x[1] > 0.0;
        let met = match self.wall {
            Wall::Cylinder { w: [w0, w1] } => {
                let nearest = if turns { ray.delta2 } else { w[0].min(w[1]) };
                w[0].max(w[1]) >= w0 && nearest <= w1
            }
            Wall::Cone { slope, offsets: [inner, outer] } => {
                let axial = [lo, hi].map(|t| slope * (ray.oz + t * ray.dz));
                let beyond = |i: usize| {
                    let rho = axial[i] + inner;
                    rho <= 0.0 || w[i] >= rho * rho
                };
                let within = |i: usize| {
                    let rho = axial[i] + outer;
                    rho >= 0.0 && w[i] <= rho * rho
                };
                (beyond(0) || beyond(1))
                    && (within(0) || within(1) || dips_within(ray, slope, outer, [lo, hi]))
            }
        };
        met.then_some([lo, hi])
    }
}

/// Whether rho - slope z, which exceeds `outer` at both ends of a stretch of the ray, turns between
/// them and reaches `outer` there.
///
/// With g = slope dz its derivative speed X / rho - g vanishes at X = g delta / sqrt(speed^2 - g^2),
/// where rho = speed delta / sqrt(speed^2 - g^2).
fn dips_within(ray: &Meridian, slope: f64, outer: f64, [lo, hi]: [f64; 2]) -> bool {
    let g = slope * ray.dz;
    let rest = ray.speed * ray.speed - g * g;
    if rest <= 0.0 {
        return false;
    }
    let scale = (ray.delta2 / rest).sqrt();
    let t = (g * scale - ray.offset) / ray.speed;
    lo < t && t < hi && ray.speed * scale <= slope * (ray.oz + t * ray.dz) + outer
}

/// How far rounding can move a point of a ray inside the sphere of this radius, counting all steps
/// from the given ray to the comparison: fewer than 64, each of a number no larger than twice the
/// radius.
fn padding(radius: f64) -> f64 {
    2.0 * gamma(64) * radius
}

fn heights(pieces: &[Piece], radius: f64) -> [f64; 2] {
    let [low, high] = ends(pieces, |p| p.z);
    [low - padding(radius), high + padding(radius)]
}

/// The smallest and the largest value of a coordinate; as pieces are monotone, they occur at ends.
fn ends(pieces: &[Piece], coordinate: impl Fn(&Piece) -> [f64; 4]) -> [f64; 2] {
    pieces.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], piece| {
        let c = coordinate(piece);
        [low.min(c[0]).min(c[3]), high.max(c[0]).max(c[3])]
    })
}

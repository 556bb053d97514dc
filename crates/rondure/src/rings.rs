//! The circles of a surface that decide how far it reaches, for the box round a placed surface.
//!
//! A circle of radius r round the axis at height z, placed by the affine map with the columns
//! (x, y, c), reaches along a world axis from its center by r times the length of (x, y) there: for a
//! turn that is r sqrt(1 - axis^2). How far a surface reaches is the largest value of the linear
//! function `c z + length r` on its profile, and that is attained on the convex hull. The length is not
//! negative, so the part of the hull to the right will do.

use crate::piece::Piece;
use crate::profile::Point;
use crate::{Affine, Bounds, Vec3};

/// Into how many parts a curved piece is cut, as a power of two: the control points of a sixteenth of
/// a quarter circle lie within 0.04 % of it.
const HALVINGS: u32 = 4;

/// The right part of the convex hull of a profile, upwards.
#[derive(Clone, Debug)]
pub(crate) struct Rings {
    points: Vec<Point>,
}

impl Rings {
    pub(crate) fn new(pieces: &[Piece]) -> Self {
        let mut points = Vec::new();
        for piece in pieces {
            let mut parts = vec![*piece];
            for _ in 0..HALVINGS {
                parts = parts.iter().flat_map(Piece::halves).collect();
            }
            points
                .extend(parts.iter().flat_map(|p| (0..4).map(move |i| Point::new(p.r[i], p.z[i]))));
        }
        Self { points: right_hull(points) }
    }

    /// The box round the placed circles. `center_z` is the height of the pieces' own origin.
    #[inline]
    pub(crate) fn placed_bounds(&self, center_z: f64, placement: &Affine) -> Bounds {
        let [x, y, z] = placement.columns;
        let middle = placement.translation + z * center_z;
        let along = |i: usize| {
            let reach = (x[i] * x[i] + y[i] * y[i]).sqrt();
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in &self.points {
                let (center, reach) = (z[i] * p.z, reach * p.r);
                low = low.min(center - reach);
                high = high.max(center + reach);
            }
            [middle[i] + low, middle[i] + high]
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        Bounds { min: Vec3::new(x[0], y[0], z[0]), max: Vec3::new(x[1], y[1], z[1]) }
    }
}

/// Andrew's monotone chain, by height. Points that rounding takes for points of a straight line
/// stay: they do no harm.
fn right_hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.z.total_cmp(&b.z).then(b.r.total_cmp(&a.r)));
    // Of the points at one height only the outermost counts.
    points.dedup_by(|b, a| a.z == b.z);
    let mut hull: Vec<Point> = Vec::new();
    for p in points {
        while let [.., a, b] = hull[..] {
            let (along, across) = (b - a, p - a);
            if along.z * across.r - along.r * across.z < 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(p);
    }
    hull.shrink_to_fit();
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Profile, Surface};

    #[test]
    fn the_box_of_a_turned_ring_is_tight() {
        // A washer: two circles of radius 2 and a hole, of no height to speak of.
        let washer = Surface::new(&Profile::from_path_data("M 1 0 L 2 0").unwrap());
        for axis in [Vec3::Z, Vec3::X, Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 1e-3, 0.5)] {
            let bounds = washer.placed_bounds(&Affine::align_z(axis), 0.0);
            let n = axis.normalized();
            for i in 0..3 {
                let reach = 2.0 * (1.0 - n[i] * n[i]).max(0.0).sqrt();
                assert!((bounds.max[i] - reach).abs() < 1e-7, "{axis:?} {bounds:?}");
                assert!((bounds.min[i] + reach).abs() < 1e-7, "{axis:?} {bounds:?}");
            }
        }
    }

    #[test]
    fn the_box_of_a_turned_sphere_stays_that_of_a_sphere() {
        let sphere = Surface::new(&Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap());
        let turn = Affine::rotate(Vec3::new(0.3, 1.0, -0.5), 0.7);
        let bounds = sphere.placed_bounds(&turn, 0.0);
        for i in 0..3 {
            assert!((1.0..1.003).contains(&bounds.max[i]), "{bounds:?}");
            assert!((1.0..1.003).contains(&-bounds.min[i]), "{bounds:?}");
        }
    }

    #[test]
    fn hulls_are_those_of_brute_force() {
        for path in [
            include_str!("../../../profiles/vase.path"),
            include_str!("../../../profiles/goblet.path"),
            include_str!("../../../profiles/column.path"),
            "M 1 0 L 1 0 L 1 5 L 0.5 5 L 2 2.5 L 1 2 Z",
            "M 0 0 L 3 0",
        ] {
            let surface = Surface::new(&Profile::from_path_data(path).unwrap());
            let rings = Rings::new(&surface.pieces.iter().collect::<Vec<_>>());
            assert!(rings.points.len() < 100, "{}", rings.points.len());
            for i in 0..64 {
                let (dz, dr) = (core::f64::consts::PI * (f64::from(i) / 63.0 - 0.5)).sin_cos();
                let far = |p: &Point| dr.max(0.0) * p.r + dz * p.z;
                let hull = rings.points.iter().map(far).fold(f64::NEG_INFINITY, f64::max);
                let points = surface
                    .pieces
                    .iter()
                    .flat_map(|piece| (0..=64).map(move |i| piece.jet(f64::from(i) / 64.0).point));
                let whole = points.map(|p| far(&p)).fold(f64::NEG_INFINITY, f64::max);
                let size = surface.radius;
                assert!(hull >= whole - 1e-15 * size && hull < whole + 2e-3 * size, "{path} {i}");
            }
        }
    }
}

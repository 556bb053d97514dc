//! Rays that are alike, asked about together: one of them goes through the tree, and boxes are larger by as much as the
//! others may be away from it.
//!
//! Two rays o + t d and o' + t d' are no farther apart at t than |o - o'| + |t| |d - d'|. No ray is still near the boxes,
//! whose sphere has the radius R, when |t| > (|o| + R) / |d|. What moves the planes of a slab by `pad` moves the parameter
//! at which the ray meets it by |pad / d|, which costs nothing to add.

use super::space::{LocalRay, Space};
use crate::batch::Rays;
use crate::{Ray, Vec3};

/// How far apart rays may be along each axis, in the tree's coordinates, in which all boxes together are between 1 and 2 wide.
const WIDEST: f64 = 1.0 / 16.0;
/// The same as a part of what items are wide, on average: rays that are farther apart meet other ones each.
const PART: f64 = 1.0 / 4.0;
/// More than the length of a vector of that size along each axis.
const ROOM: f64 = 2.0 * WIDEST;
/// A direction that is farther from another than this part of its length is not alike.
const TURNED: f64 = 0.25;
/// More than the roundings of a width, as a part of it.
const WIDER: f64 = 1.0 + 1.0 / 1024.0;
/// More than what the pad adds to the roundings of a slab, which [`space`](super::space) has room for: u |o| + 2 u |pad| < 9 u.
const ROUNDED: f64 = 8.0 * f32::EPSILON as f64;

/// One of the rays, and by how much boxes grow on each axis.
pub(super) struct Bundle {
    pub(super) ray: LocalRay,
    pub(super) pad: [f32; 3],
}

/// What there is to say of some rays.
pub(super) enum Together {
    /// They are not alike.
    Apart,
    /// They are, and pass all boxes.
    Pass,
    /// They go together.
    Bundle(Bundle),
}

impl Together {
    /// Looks at rays, of which there must be one, for a tree whose items are so wide on average.
    pub(super) fn new(space: &Space, width: f64, rays: &Rays<'_>) -> Self {
        let first = rays.get(0);
        let Some((from, direction)) = space.measured(&first) else { return Self::Apart };
        let length = direction.own.length();
        // How far rays are apart that differ by so much, or nothing if that is too far.
        let pad = |[origins, directions]: [Vec3; 2]| {
            let (o_apart, d_apart) = (space.scaled(origins), directions * direction.unit);
            let slower = length - d_apart.length();
            // No ray is still near the boxes after that.
            let latest = (from.length() + o_apart.length() + space.radius() + ROOM) / slower;
            let pad = (o_apart + d_apart * latest) * WIDER;
            // Also where one is not a number.
            let alike =
                slower >= (1.0 - TURNED) * length && pad.max_abs() <= (PART * width).min(WIDEST);
            alike.then_some(pad)
        };
        // Most rays that are not alike show that by the last one.
        let last = rays.get(rays.len() - 1);
        let differences =
            [(last.origin - first.origin).abs(), (last.direction - first.direction).abs()];
        if pad(differences).is_none() {
            return Self::Apart;
        }
        let spread = [spread(rays.origins()), spread(rays.directions())];
        let Some(pad) = pad(spread) else { return Self::Apart };
        let [starts, ends] = rays.ranges();
        // A range that is not a number belongs to no ray.
        let t_min =
            starts.iter().fold(f64::INFINITY, |least, t| if *t < least { *t } else { least });
        let t_max =
            ends.iter().fold(f64::NEG_INFINITY, |most, t| if *t > most { *t } else { most });
        let all = Ray { t_min, t_max, ..first };
        match space.enter_within(&all, ROOM) {
            Some(ray) => {
                let pad = pad + Vec3::splat(ROUNDED);
                Self::Bundle(Bundle { ray, pad: [pad.x as f32, pad.y as f32, pad.z as f32] })
            }
            None => Self::Pass,
        }
    }
}

/// How far vectors are from the first one along each axis; those that are not numbers do not count.
fn spread(columns: [&[f64]; 3]) -> Vec3 {
    let along = |column: &[f64]| {
        let first = column[0];
        column.iter().fold(0.0, |most, x| {
            let difference = (x - first).abs();
            if difference > most { difference } else { most }
        })
    };
    let [x, y, z] = columns;
    Vec3::new(along(x), along(y), along(z))
}

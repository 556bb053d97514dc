//! Eight rays as they come near the surface: what [`course`](super::course) says of one, for batches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::Wide;
use super::course::{Course, LONGEST, NEAR, SHORTEST, VANISHING};
use crate::Vec3;
use crate::batch::Rays;
use crate::frame::Frame;

/// How many rays are looked at together.
pub(super) const WIDTH: usize = 8;

/// Eight rays in the surface's own size, from where they begin; see [`Course`](super::course::Course).
#[derive(Clone, Copy)]
pub(super) struct Near<S: Simd> {
    pub(super) origin: [f64x8<S>; 3],
    pub(super) direction: [f64x8<S>; 3],
    pub(super) abc: [f64x8<S>; 3],
    pub(super) length2: f64x8<S>,
    pub(super) far: f64x8<S>,
    pub(super) range: [f64x8<S>; 2],
    /// Those that may meet the surface.
    pub(super) meets: u32,
    /// Those that are not for batches.
    pub(super) strange: u32,
}

impl<S: Simd> Near<S> {
    /// The rays from the one numbered `start` on, of which there must be eight, at a surface that stands where it was
    /// built.
    #[inline(always)]
    pub(super) fn new(simd: S, wide: &Wide, frame: &Frame, rays: &Rays<'_>, start: usize) -> Self {
        let outline = &wide.outline;
        let unit = splat(simd, outline.unit);
        let [ox, oy, oz] = rays.origin;
        let [dx, dy, dz] = rays.direction;
        let ox = load(simd, ox, start) * unit;
        let oy = load(simd, oy, start) * unit;
        let oz = (load(simd, oz, start) - splat(simd, frame.center_z())) * unit;
        let dx = load(simd, dx, start) * unit;
        let dy = load(simd, dy, start) * unit;
        let dz = load(simd, dz, start) * unit;
        let t_min = load(simd, rays.range[0], start);
        let t_max = load(simd, rays.range[1], start);
        let a = dx * dx + dy * dy;
        let k = ox * dy - oy * dx;
        let far = ox.abs().max(oy.abs()).max(oz.abs());
        let length2 = dz.mul_add(dz, a);
        let ordinary = far.simd_le(splat(simd, NEAR))
            & length2.simd_ge(splat(simd, SHORTEST))
            & length2.simd_le(splat(simd, LONGEST));
        let b = ox * dx + oy * dy;
        let c = ox * ox + oy * oy;
        let along = oz.mul_add(dz, b);
        let outside = oz.mul_add(oz, c) - splat(simd, outline.radius2);
        let reach2 = a * splat(simd, outline.reach2) + splat(simd, VANISHING);
        let meets = ordinary
            & t_min.simd_le(t_max)
            & (k * k).simd_le(reach2)
            & (along * along).simd_ge(outside * length2);
        Self {
            origin: [ox, oy, oz],
            direction: [dx, dy, dz],
            abc: [a, b, c],
            length2,
            far,
            range: [t_min, t_max],
            meets: meets.to_bitmask() as u32,
            strange: (!ordinary).to_bitmask() as u32,
        }
    }

    /// One of the rays.
    #[inline(always)]
    pub(super) fn course(&self, lane: usize) -> Course {
        let lane = lane % WIDTH;
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.origin, &self.direction);
        Course {
            origin: Vec3::new(ox[lane], oy[lane], oz[lane]),
            direction: Vec3::new(dx[lane], dy[lane], dz[lane]),
            a: self.abc[0][lane],
            b: self.abc[1][lane],
            c: self.abc[2][lane],
            length2: self.length2[lane],
            far: self.far[lane],
            turn: 0.0,
            range: [self.range[0][lane], self.range[1][lane]],
            shift: 0.0,
        }
    }
}

/// Whether eight rays surely pass the axis too far away, as [`passes`](super::course::passes) tells of one: half of what
/// there is to know of them need not even be read.
#[inline(always)]
pub(super) fn pass<S: Simd>(simd: S, wide: &Wide, rays: &Rays<'_>, start: usize) -> bool {
    let outline = &wide.outline;
    let unit = splat(simd, outline.unit);
    let ox = load(simd, rays.origin[0], start) * unit;
    let oy = load(simd, rays.origin[1], start) * unit;
    let dx = load(simd, rays.direction[0], start) * unit;
    let dy = load(simd, rays.direction[1], start) * unit;
    let k = ox * dy - oy * dx;
    let reach2 = (dx * dx + dy * dy).mul_add(splat(simd, outline.reach2), splat(simd, VANISHING));
    let near = ox.abs().max(oy.abs()).simd_le(splat(simd, NEAR));
    (near & (k * k).simd_gt(reach2)).all_true()
}

#[inline(always)]
fn load<S: Simd>(simd: S, column: &[f64], start: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &column[start..start + WIDTH])
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> f64x8<S> {
    f64x8::splat(simd, value)
}

//! Eight rays as they come near the surface: what [`course`](super::course) says of one, for batches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::Wide;
use super::course::{Course, FAR, FLAT, LONGEST, NEAR, SHORTEST, VANISHING};
use crate::Vec3;
use crate::batch::Rays;
use crate::frame::Frame;
use crate::numeric::UNIT_ROUNDOFF;

/// How many rays are looked at together.
pub(super) const WIDTH: usize = 8;

/// More than a ray goes on, from where it is closest to the surface or near it, to any point of that, times what turning its direction
/// may cancel at the most: NEAR has three coordinates, and the radius is no more than 2.
const TURN: f64 = 2.0 * (NEAR + 2.0) * FLAT;
/// Room round a ball for rounding: products of squared lengths, and the square of a dot product, which is no larger, are good to fewer than 64
/// roundings of themselves together, and from no farther than FAR radii they are no more than FAR^2 times the ball's.
const ROOM: f64 = 1.0 + 64.0 * UNIT_ROUNDOFF * FAR * FAR;

/// Eight rays in the surface's own size, from where they begin; see [`Course`](super::course::Course).
#[derive(Clone, Copy)]
pub(super) struct Near<S: Simd> {
    pub(super) origin: [f64x8<S>; 3],
    pub(super) direction: [f64x8<S>; 3],
    pub(super) abc: [f64x8<S>; 3],
    pub(super) length2: f64x8<S>,
    /// What is rounded of a point of the ray, or more: also by turning the direction, however far it goes on.
    pub(super) far: f64x8<S>,
    pub(super) shift: f64x8<S>,
    pub(super) range: [f64x8<S>; 2],
    /// Those that may meet the surface.
    pub(super) meets: u32,
    /// Those that are not for batches.
    pub(super) strange: u32,
}

impl<S: Simd> Near<S> {
    /// The rays from the one numbered `start` on, of which there must be eight, at a surface that stands in a frame.
    #[inline(always)]
    pub(super) fn new(simd: S, wide: &Wide, frame: &Frame, rays: &Rays<'_>, start: usize) -> Self {
        let outline = &wide.outline;
        let (unit, rows) = (splat(simd, outline.unit), frame.rows());
        let at = load3(simd, &rays.origin, start);
        let way = load3(simd, &rays.direction, start);
        let center = splat3(simd, frame.center());
        let from = [at[0] - center[0], at[1] - center[1], at[2] - center[2]];
        let [mut ox, mut oy, mut oz] = scaled(turned(simd, rows, from), unit);
        let [dx, dy, dz] = scaled(turned(simd, rows, way), unit);
        let a = dx * dx + dy * dy;
        let k = ox * dy - oy * dx;
        let distance = ox.abs().max(oy.abs()).max(oz.abs());
        let length2 = dz.mul_add(dz, a);
        let mut ordinary = distance.simd_le(splat(simd, FAR))
            & length2.simd_ge(splat(simd, SHORTEST))
            & length2.simd_le(splat(simd, LONGEST));
        let mut far = distance.min(splat(simd, NEAR));
        if let Some(rows) = rows {
            let flat = splat(simd, FLAT);
            let of_origin = terms(simd, rows, from) * unit;
            let of_direction = terms(simd, rows, way) * unit;
            ordinary &= of_origin.simd_le(flat * (distance + splat(simd, 2.0)))
                & (of_direction * of_direction).simd_le(flat * flat * length2);
            far = of_origin.max(distance) + splat(simd, TURN);
        }
        let mut shift = splat(simd, 0.0);
        let distant = ordinary & distance.simd_gt(splat(simd, NEAR));
        if distant.any_true() {
            let along = oz.mul_add(dz, ox * dx + oy * dy);
            shift = distant.select(-along / length2, shift);
            let moved = [
                approached(at[0], center[0], way[0], shift),
                approached(at[1], center[1], way[1], shift),
                approached(at[2], center[2], way[2], shift),
            ];
            [ox, oy, oz] = scaled(turned(simd, rows, moved), unit);
        }
        let b = ox * dx + oy * dy;
        let c = ox * ox + oy * oy;
        let along = oz.mul_add(dz, b);
        let outside = oz.mul_add(oz, c) - splat(simd, outline.radius2);
        let reach2 = a * splat(simd, outline.reach2) + splat(simd, VANISHING);
        let t_min = load(simd, rays.range[0], start);
        let t_max = load(simd, rays.range[1], start);
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
            shift,
            range: [t_min - shift, t_max - shift],
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
            shift: self.shift[lane],
        }
    }
}

/// Whether eight rays surely pass the axis too far away, as [`passes`](super::course::passes) tells of one: half of what
/// there is to know of them need not even be read. A surface that was placed they must pass outside of the ball round it.
#[inline(always)]
pub(super) fn pass<S: Simd>(
    simd: S,
    wide: &Wide,
    frame: &Frame,
    rays: &Rays<'_>,
    start: usize,
) -> bool {
    if frame.inverse().is_some() {
        return pass_ball(simd, frame, rays, start);
    }
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
fn pass_ball<S: Simd>(simd: S, frame: &Frame, rays: &Rays<'_>, start: usize) -> bool {
    let at = load3(simd, &rays.origin, start);
    let way = load3(simd, &rays.direction, start);
    let center = splat3(simd, frame.center());
    let from = [at[0] - center[0], at[1] - center[1], at[2] - center[2]];
    let (distance2, length2, along) = (dot(from, from), dot(way, way), dot(from, way));
    let radius2 = frame.radius2();
    // From no farther away there is room for rounding.
    let near = distance2.simd_le(splat(simd, FAR * FAR * radius2));
    let outside = distance2 - splat(simd, ROOM * radius2);
    (near & (along * along).simd_lt(outside * length2)).all_true()
}

/// A coordinate of points moved along rays, without losing what cancels; see [`course`](super::course).
#[inline(always)]
fn approached<S: Simd>(
    from: f64x8<S>,
    center: f64x8<S>,
    direction: f64x8<S>,
    shift: f64x8<S>,
) -> f64x8<S> {
    // As `two_diff`.
    let difference = from - center;
    let rest = from - difference;
    let low = (from - (difference + rest)) + (rest - center);
    shift.mul_add(direction, difference) + low
}

/// Vectors as a surface sees them that was turned by these rows, if by any.
#[inline(always)]
fn turned<S: Simd>(simd: S, rows: Option<&[Vec3; 3]>, v: [f64x8<S>; 3]) -> [f64x8<S>; 3] {
    let Some([x, y, z]) = rows else { return v };
    [dot(splat3(simd, *x), v), dot(splat3(simd, *y), v), dot(splat3(simd, *z), v)]
}

/// Bounds on the terms that [`turned`] adds up.
#[inline(always)]
fn terms<S: Simd>(simd: S, [x, y, z]: &[Vec3; 3], v: [f64x8<S>; 3]) -> f64x8<S> {
    let v = [v[0].abs(), v[1].abs(), v[2].abs()];
    let [x, y, z] = [splat3(simd, x.abs()), splat3(simd, y.abs()), splat3(simd, z.abs())];
    dot(x, v).max(dot(y, v)).max(dot(z, v))
}

#[inline(always)]
fn dot<S: Simd>(a: [f64x8<S>; 3], b: [f64x8<S>; 3]) -> f64x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn scaled<S: Simd>(v: [f64x8<S>; 3], by: f64x8<S>) -> [f64x8<S>; 3] {
    [v[0] * by, v[1] * by, v[2] * by]
}

#[inline(always)]
fn load3<S: Simd>(simd: S, columns: &[&[f64]; 3], start: usize) -> [f64x8<S>; 3] {
    [load(simd, columns[0], start), load(simd, columns[1], start), load(simd, columns[2], start)]
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, v: Vec3) -> [f64x8<S>; 3] {
    [splat(simd, v.x), splat(simd, v.y), splat(simd, v.z)]
}

#[inline(always)]
fn load<S: Simd>(simd: S, column: &[f64], start: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &column[start..start + WIDTH])
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> f64x8<S> {
    f64x8::splat(simd, value)
}

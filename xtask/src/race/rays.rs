//! The rays of the race: the same for every engine, in double precision, and rounded to single for
//! Embree.

use rondure::{Ray, RayColumns, Surface, Vec3};

use super::embree::{Packets, Single};

/// What is asked about each ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Query {
    Closest,
    Any,
}

/// Rays to be answered one after the other, or all at once.
#[derive(Clone, Debug)]
pub(crate) struct RaySet {
    pub(crate) name: String,
    pub(crate) query: Query,
    /// Whether an engine may take rays together.
    pub(crate) batch: bool,
    /// Whether rays that follow each other are alike.
    pub(crate) coherent: bool,
    /// All from t = 0 to the same t, see [`far`](Self::far).
    pub(crate) rays: Vec<Ray>,
    pub(crate) singles: Vec<Single>,
    pub(crate) packets: Packets,
    pub(crate) columns: RayColumns,
}

impl RaySet {
    fn new(name: &str, query: Query, rays: Vec<Ray>) -> Self {
        let singles = rays.iter().map(single).collect();
        let (name, packets) = (name.to_owned(), Packets::new(&[]));
        let columns = RayColumns::default();
        Self { name, query, batch: false, coherent: true, rays, singles, packets, columns }
    }

    fn batch(name: &str, query: Query, coherent: bool, rays: Vec<Ray>) -> Self {
        let set = Self::new(name, query, rays);
        let packets = Packets::new(&set.singles);
        let columns = set.rays.iter().collect();
        Self { batch: true, coherent, packets, columns, ..set }
    }

    pub(crate) fn len(&self) -> usize {
        self.rays.len()
    }

    /// Where all rays end: at the light, or nowhere.
    pub(crate) fn far(&self) -> f32 {
        self.rays.first().map_or(f32::INFINITY, |ray| ray.t_max as f32)
    }

    /// The rays of this set for which `keep` says so, as a set of their own.
    pub(crate) fn only(&self, name: &str, keep: &[bool]) -> Self {
        let kept = self.rays.iter().zip(keep).filter(|(_, keep)| **keep).map(|(ray, _)| *ray);
        let rays = kept.collect();
        if self.batch {
            Self::batch(name, self.query, self.coherent, rays)
        } else {
            Self::new(name, self.query, rays)
        }
    }
}

/// All sets for one shape.
pub(crate) fn sets(surface: &Surface) -> Vec<RaySet> {
    let scanlines = camera_rays(&Camera::default(), scanline_order);
    let tiles = camera_rays(&Camera::default(), tile_order);
    let (random, secondary) = (random_rays(surface, 1 << 20), secondary_rays(surface, &scanlines));
    let shadow = [shadow_rays(surface, &scanlines), shadow_rays(surface, &tiles)];
    let [shadow, shadow_tiles] = shadow;
    use Query::{Any, Closest};
    vec![
        RaySet::new("camera", Closest, scanlines),
        RaySet::batch("camera, batch", Closest, true, tiles),
        RaySet::new("random", Closest, random.clone()),
        RaySet::batch("random, batch", Closest, false, random),
        RaySet::new("secondary", Closest, secondary.clone()),
        RaySet::batch("secondary, batch", Closest, false, secondary),
        RaySet::new("shadow", Any, shadow),
        RaySet::batch("shadow, batch", Any, true, shadow_tiles),
    ]
}

/// Which sets are run again with the rays that miss left out.
pub(crate) const HITS_ONLY: [&str; 4] = ["camera", "camera, batch", "random", "random, batch"];

/// Sets for a field of copies: camera rays that see all of it, and random rays through its box.
pub(crate) fn field_sets(camera: &Camera, bounds: &rondure::Bounds) -> Vec<RaySet> {
    let tiles = camera_rays(camera, tile_order);
    vec![
        RaySet::new("camera", Query::Closest, camera_rays(camera, scanline_order)),
        RaySet::batch("camera, batch", Query::Closest, true, tiles),
        RaySet::new("random", Query::Closest, random_rays_in(bounds, 1 << 20)),
    ]
}

fn single(ray: &Ray) -> Single {
    let f32s = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
    Single { origin: f32s(ray.origin), direction: f32s(ray.direction) }
}

/// A pinhole camera, 1024 x 768 pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    pub(crate) eye: Vec3,
    pub(crate) look_at: Vec3,
}

impl Default for Camera {
    fn default() -> Self {
        Self { eye: Vec3::new(1.30, 0.45, 0.95), look_at: Vec3::new(0.0, 0.0, 0.48) }
    }
}

const WIDTH: u32 = 1024;
const HEIGHT: u32 = 768;
const FIELD_OF_VIEW: f64 = 46.0;
const LIGHT: Vec3 = Vec3 { x: 1.5, y: -1.2, z: 2.2 };

/// How far off the surface rays begin that start on it, so that no engine hits where they start.
const OFFSET: f64 = 1e-4;

fn scanline_order(i: u32) -> [u32; 2] {
    [i % WIDTH, i / WIDTH]
}

/// Tiles of 8 x 8 pixels, in each four packets of 4 x 4.
fn tile_order(i: u32) -> [u32; 2] {
    let (tile, packet, lane) = (i / 64, i / 16 % 4, i % 16);
    let tiles = WIDTH / 8;
    [tile % tiles * 8 + packet % 2 * 4 + lane % 4, tile / tiles * 8 + packet / 2 * 4 + lane / 4]
}

fn camera_rays(camera: &Camera, order: impl Fn(u32) -> [u32; 2]) -> Vec<Ray> {
    let forward = (camera.look_at - camera.eye).normalized();
    let right = forward.cross(Vec3::Z).normalized();
    let up = right.cross(forward);
    let scale = (0.5 * FIELD_OF_VIEW).to_radians().tan() / (0.5 * f64::from(HEIGHT));
    let ray = |i| {
        let [column, row] = order(i);
        let x = f64::from(column) + 0.5 - 0.5 * f64::from(WIDTH);
        let y = 0.5 * f64::from(HEIGHT) - f64::from(row) - 0.5;
        Ray::new(camera.eye, forward + right * (x * scale) + up * (y * scale))
    };
    (0..WIDTH * HEIGHT).map(ray).collect()
}

/// From the sphere round the bounding box to points in the box.
fn random_rays(surface: &Surface, count: usize) -> Vec<Ray> {
    random_rays_in(&surface.bounds(), count)
}

fn random_rays_in(bounds: &rondure::Bounds, count: usize) -> Vec<Ray> {
    let mut random = Random(1);
    let (center, extent) = (bounds.center(), bounds.extent());
    let radius = 0.5 * extent.length();
    let ray = |_| {
        let origin = center + random.direction() * radius;
        let v = random.vector();
        let target = bounds.min + Vec3::new(extent.x * v.x, extent.y * v.y, extent.z * v.z);
        Ray::new(origin, target - origin)
    };
    (0..count).map(ray).collect()
}

/// Points on the surface that the camera sees, a little above it, and the normals there.
fn seen<'a>(surface: &'a Surface, camera: &'a [Ray]) -> impl Iterator<Item = [Vec3; 2]> + 'a {
    camera.iter().filter_map(|ray| {
        let at = surface.interaction(ray, &surface.closest(ray)?);
        let side = if at.normal.dot(ray.direction) < 0.0 { 1.0 } else { -1.0 };
        let normal = at.normal * side;
        Some([at.point + normal * OFFSET, normal])
    })
}

/// From what the camera sees, as from a matte surface: directions as often as the cosine to the
/// normal is large.
fn secondary_rays(surface: &Surface, camera: &[Ray]) -> Vec<Ray> {
    let count = 1 << 19;
    let seen: Vec<_> = seen(surface, camera).collect();
    let mut random = Random(2);
    let ray = |i: usize| {
        let [origin, normal] = seen[i * seen.len() / count];
        Ray::new(origin, normal + random.direction())
    };
    (0..count).map(ray).collect()
}

/// From what the camera sees to the light.
fn shadow_rays(surface: &Surface, camera: &[Ray]) -> Vec<Ray> {
    seen(surface, camera)
        .map(|[origin, _]| Ray::new(origin, LIGHT - origin).with_range(0.0, 1.0))
        .collect()
}

/// Numbers that look random and are the same at every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn number(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In the unit cube.
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Of length 1, all directions alike.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector() * 2.0 - Vec3::splat(1.0);
            if (1e-6..=1.0).contains(&v.length_squared()) {
                return v.normalized();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_pixel_is_in_one_tile() {
        let pixels: HashSet<_> = (0..WIDTH * HEIGHT).map(tile_order).collect();
        assert_eq!(pixels.len(), (WIDTH * HEIGHT) as usize);
        assert!(pixels.iter().all(|&[x, y]| x < WIDTH && y < HEIGHT));
        let tile: HashSet<_> = (64..128).map(tile_order).map(|[x, y]| [x / 8, y / 8]).collect();
        assert_eq!(tile, HashSet::from([[1, 0]]));
    }
}

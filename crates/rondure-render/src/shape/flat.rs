//! The flat shapes: the endless plane, the disk and the parallelogram.

use rondure::{Bounds, Footing, Interaction, Ray, Vec3};

use super::{padded, point_error};

/// An endless plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    point: Vec3,
    normal: Vec3,
}

impl Plane {
    pub(crate) fn new(point: Vec3, normal: Vec3) -> Self {
        Self { point, normal: normal.normalized() }
    }

    /// For [`Flats`](super::Flats).
    pub(super) fn parts(&self) -> [Vec3; 4] {
        [self.point, self.normal, Vec3::ZERO, Vec3::ZERO]
    }

    /// Where the ray meets the plane, in its range. A ray in the plane or along it has no hit.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<f64> {
        let t = self.normal.dot(self.point - ray.origin) / self.normal.dot(ray.direction);
        // False for a NaN, and infinite where the ray is parallel.
        (ray.t_min <= t && t <= ray.t_max && t < f64::INFINITY).then_some(t)
    }

    /// The point's place relative to the plane's own point, moved back onto the plane along the
    /// normal.
    #[inline]
    fn local(&self, ray: &Ray, t: f64) -> Vec3 {
        let local = ray.origin - self.point + ray.direction * t;
        local - self.normal * self.normal.dot(local)
    }

    #[inline]
    pub(crate) fn footing(&self, ray: &Ray, t: f64) -> Footing {
        let local = self.local(ray, t);
        let error = point_error(self.point, local.max_abs());
        Footing { point: self.point + local, normal: self.normal, error }
    }

    #[inline]
    fn interaction_along(&self, ray: &Ray, t: f64, axes: [Vec3; 2], uv: [f64; 2]) -> Interaction {
        let Footing { point, normal, error } = self.footing(ray, t);
        let [dp_du, dp_dv] = axes;
        Interaction { point, normal, uv, dp_du, dp_dv, error }
    }

    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, t: f64) -> Interaction {
        let local = self.local(ray, t);
        let (x, y) = self.normal.orthonormal_basis();
        self.interaction_along(ray, t, [x, y], [x.dot(local), y.dot(local)])
    }
}

/// A flat disk, with two sides or, as a lamp, with one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disk {
    plane: Plane,
    radius: f64,
    one_sided: bool,
}

impl Disk {
    pub(crate) fn new(center: Vec3, normal: Vec3, radius: f64) -> Self {
        Self { plane: Plane::new(center, normal), radius, one_sided: false }
    }

    /// The disk that rays meet only on the side of its normal.
    pub(crate) fn one_sided(self) -> Self {
        Self { one_sided: true, ..self }
    }

    pub(crate) fn bounds(&self) -> Bounds {
        let n = self.plane.normal;
        let half = Vec3::new(n.y.hypot(n.z), n.z.hypot(n.x), n.x.hypot(n.y)) * self.radius;
        padded(self.plane.point, half)
    }

    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<f64> {
        if self.one_sided && self.plane.normal.dot(ray.direction) >= 0.0 {
            return None;
        }
        let t = self.plane.closest(ray)?;
        let local = ray.origin - self.plane.point + ray.direction * t;
        (local.length_squared() <= self.radius * self.radius).then_some(t)
    }

    #[inline]
    pub(crate) fn footing(&self, ray: &Ray, t: f64) -> Footing {
        self.plane.footing(ray, t)
    }

    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, t: f64) -> Interaction {
        self.plane.interaction(ray, t)
    }
}

/// A parallelogram round its centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    plane: Plane,
    edges: [Vec3; 2],
    /// The dual vectors: their products with a point are its coordinates along the edges.
    dual: [Vec3; 2],
}

impl Rectangle {
    pub(crate) fn new(center: Vec3, edges: [Vec3; 2]) -> Self {
        let normal = edges[0].cross(edges[1]);
        let area2 = normal.length_squared();
        let dual = [edges[1].cross(normal) / area2, normal.cross(edges[0]) / area2];
        Self { plane: Plane::new(center, normal), edges, dual }
    }

    /// For [`Flats`](super::Flats).
    pub(super) fn parts(&self) -> [Vec3; 4] {
        let [u, v] = self.dual;
        [self.plane.point, self.plane.normal, u, v]
    }

    pub(crate) fn bounds(&self) -> Bounds {
        padded(self.plane.point, (self.edges[0].abs() + self.edges[1].abs()) * 0.5)
    }

    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<f64> {
        let t = self.plane.closest(ray)?;
        let local = ray.origin - self.plane.point + ray.direction * t;
        (self.dual[0].dot(local).abs() <= 0.5 && self.dual[1].dot(local).abs() <= 0.5).then_some(t)
    }

    #[inline]
    pub(crate) fn footing(&self, ray: &Ray, t: f64) -> Footing {
        self.plane.footing(ray, t)
    }

    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, t: f64) -> Interaction {
        let local = self.plane.local(ray, t);
        let lengths = self.edges.map(Vec3::length);
        let uv = [self.dual[0].dot(local) * lengths[0], self.dual[1].dot(local) * lengths[1]];
        let axes = [self.edges[0] / lengths[0], self.edges[1] / lengths[1]];
        self.plane.interaction_along(ray, t, axes, uv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disks_end_at_their_radius() {
        let disk = Disk::new(Vec3::new(1.0, 0.0, 5.0), Vec3::new(0.0, 0.0, -2.0), 2.0);
        let down = |x: f64| Ray::new(Vec3::new(x, 0.0, 9.0), -Vec3::Z);
        assert_eq!(disk.closest(&down(2.999)), Some(4.0));
        assert_eq!(disk.closest(&down(3.001)), None);
        assert_eq!(disk.one_sided().closest(&down(1.0)), None);
        let up = Ray::new(Vec3::new(1.0, 0.0, 0.0), Vec3::Z);
        assert_eq!(disk.one_sided().closest(&up), Some(5.0));
    }

    #[test]
    fn rectangles_may_be_slanted() {
        let edges = [Vec3::new(4.0, 0.0, 0.0), Vec3::new(2.0, 2.0, 0.0)];
        let slanted = Rectangle::new(Vec3::ZERO, edges);
        let down = |x: f64, y: f64| Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z);
        assert!(slanted.closest(&down(2.9, 0.99)).is_some());
        assert!(slanted.closest(&down(-2.0, 0.9)).is_none());
        let full = slanted.interaction(&down(1.0, 1.0), 1.0);
        assert!(full.uv[0].abs() < 1e-15 && (full.uv[1] - 2.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn rays_leave_a_plane_from_its_own_point_too() {
        for normal in [Vec3::Z, Vec3::new(3.0, -4.0, 0.0)] {
            let plane = Plane::new(Vec3::ZERO, normal);
            let onto = Ray::new(normal * 2.0, normal * -1.0);
            let hit = plane.interaction(&onto, plane.closest(&onto).unwrap());
            for direction in [normal, normal * -0.5] {
                assert_eq!(plane.closest(&hit.spawn(direction)), None, "{hit:?}");
            }
        }
    }

    #[test]
    fn rays_along_the_plane_miss() {
        let plane = Plane::new(Vec3::ZERO, Vec3::Z);
        assert_eq!(plane.closest(&Ray::new(Vec3::new(0.0, 0.0, 1.0), Vec3::X)), None);
        assert_eq!(plane.closest(&Ray::new(Vec3::ZERO, Vec3::X)), None);
    }

    #[test]
    fn bounds_hold_the_shape() {
        for normal in [Vec3::Z, Vec3::new(1e-9, 0.0, 1.0), Vec3::new(1.0, 2.0, 3.0)] {
            let disk = Disk::new(Vec3::new(3.0, 4.0, 5.0), normal, 2.0);
            let (a, b) = normal.normalized().orthonormal_basis();
            let bounds = disk.bounds();
            for i in 0..64 {
                let (sin, cos) = (f64::from(i) * 0.1).sin_cos();
                let rim = Vec3::new(3.0, 4.0, 5.0) + (a * cos + b * sin) * 2.0;
                assert!(bounds.contains(rim), "{rim:?} {bounds:?}");
            }
        }
    }
}

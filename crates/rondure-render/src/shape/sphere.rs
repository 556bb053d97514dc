//! The sphere, by Haines, Günther and Akenine-Möller 2019, "Precision Improvements for Ray/Sphere
//! Intersection": the discriminant from the distance of the centre to the ray, the roots without
//! cancellation. Accurate for small spheres far away and for large ones close by.

use core::f64::consts::{PI, TAU};

use rondure::{Bounds, Footing, Interaction, Ray, Vec3};

use super::{padded, point_error};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Sphere {
    center: Vec3,
    radius: f64,
}

impl Sphere {
    pub(crate) fn new(center: Vec3, radius: f64) -> Self {
        Self { center, radius }
    }

    pub(crate) fn center(&self) -> Vec3 {
        self.center
    }

    pub(crate) fn bounds(&self) -> Bounds {
        padded(self.center, Vec3::splat(self.radius))
    }

    /// Both roots in order, if the ray's line meets the sphere; where it only touches, twice the
    /// same.
    #[inline]
    fn roots(&self, ray: &Ray) -> Option<(f64, f64)> {
        let d = ray.direction;
        let a = d.length_squared();
        let from_center = ray.origin - self.center;
        let b = -from_center.dot(d);
        let off_axis = from_center + d * (b / a);
        let r2 = self.radius * self.radius;
        let discriminant = r2 - off_axis.length_squared();
        // Not `< 0`: rays that are not finite have no hits.
        if !(discriminant >= 0.0) {
            return None;
        }
        let c = from_center.length_squared() - r2;
        let q = b + (a * discriminant).sqrt().copysign(b);
        let (near, far) = if b > 0.0 { (c / q, q / a) } else { (q / a, c / q) };
        // A line through the centre of a sphere from the centre itself: b = 0 and q = sqrt > 0.
        Some(if near <= far { (near, far) } else { (far, near) })
    }

    /// The hits in the ray's range, in order.
    #[inline]
    pub(crate) fn all(&self, ray: &Ray) -> impl Iterator<Item = f64> + use<> {
        let [t_min, t_max] = [ray.t_min, ray.t_max];
        let roots = self.roots(ray).map(|(near, far)| [near, far]);
        roots.into_iter().flatten().filter(move |&t| t_min <= t && t <= t_max)
    }

    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<f64> {
        self.all(ray).next()
    }

    #[inline]
    pub(crate) fn footing(&self, ray: &Ray, t: f64) -> Footing {
        let outwards = ray.origin - self.center + ray.direction * t;
        let normal = outwards.normalized();
        Footing {
            point: self.center + normal * self.radius,
            normal,
            error: point_error(self.center, self.radius),
        }
    }

    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, t: f64) -> Interaction {
        let Footing { point, normal, error } = self.footing(ray, t);
        let angle = normal.y.atan2(normal.x) / TAU;
        let u = if angle < 0.0 { angle + 1.0 } else { angle };
        // v counts along the half circle from the lower pole, as its turned profile would.
        let v = normal.z.clamp(-1.0, 1.0).asin() / PI + 0.5;
        let across = normal.x.hypot(normal.y);
        let (cos, sin) =
            if across > 0.0 { (normal.x / across, normal.y / across) } else { (1.0, 0.0) };
        Interaction {
            point,
            normal,
            uv: [if u < 1.0 { u } else { 0.0 }, v],
            dp_du: Vec3::new(-normal.y, normal.x, 0.0) * (TAU * self.radius),
            dp_dv: Vec3::new(-cos * normal.z, -sin * normal.z, across) * (PI * self.radius),
            error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_are_the_closed_form() {
        let sphere = Sphere::new(Vec3::new(1.0, 2.0, 3.0), 2.0);
        let ray = Ray::new(Vec3::new(1.0, -8.0, 3.0), Vec3::new(0.0, 2.0, 0.0));
        assert_eq!(sphere.closest(&ray), Some(4.0));
        assert_eq!(sphere.closest(&ray.with_range(4.5, 10.0)), Some(6.0));
        assert_eq!(sphere.closest(&ray.with_range(0.0, 3.5)), None);
        let inside = Ray::new(Vec3::new(1.0, 2.0, 3.0), Vec3::Z);
        assert_eq!(sphere.closest(&inside), Some(2.0));
    }

    #[test]
    fn small_spheres_far_away_are_sharp() {
        let far = 1e6;
        let sphere = Sphere::new(Vec3::new(far, 0.0, 0.0), 1.0);
        for (y, hit) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
            let ray = Ray::new(Vec3::new(0.0, y, 0.0), Vec3::X);
            assert_eq!(sphere.closest(&ray).is_some(), hit, "{y}");
        }
        let t = sphere.closest(&Ray::new(Vec3::new(0.0, 0.6, 0.0), Vec3::X)).unwrap();
        assert!((t - (far - 0.8)).abs() < 1e-9);
    }

    #[test]
    fn partial_derivatives_are_finite_differences() {
        let sphere = Sphere::new(Vec3::new(0.5, -1.0, 2.0), 1.5);
        let at = |u: f64, v: f64| {
            let (sin, cos) = (TAU * u).sin_cos();
            let latitude = PI * (v - 0.5);
            let n = Vec3::new(cos * latitude.cos(), sin * latitude.cos(), latitude.sin());
            Ray::new(sphere.center + n * 4.0, -n)
        };
        let full = |u, v| sphere.interaction(&at(u, v), sphere.closest(&at(u, v)).unwrap());
        let (u, v, h) = (0.3, 0.7, 1e-6);
        let here = full(u, v);
        assert!((here.uv[0] - u).abs() < 1e-15 && (here.uv[1] - v).abs() < 1e-15);
        let du = (full(u + h, v).point - full(u - h, v).point) / (2.0 * h);
        let dv = (full(u, v + h).point - full(u, v - h).point) / (2.0 * h);
        assert!((du - here.dp_du).max_abs() < 1e-8 && (dv - here.dp_dv).max_abs() < 1e-8);
    }
}

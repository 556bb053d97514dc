//! The camera: from a place in the picture and on the lens to a ray.

use rondure::{Ray, Vec3};
use rondure_scene::{Camera, Lens, Projection};

use crate::warp;

/// A camera with its frame worked out for one picture format.
#[derive(Clone, Debug)]
pub(crate) struct View {
    eye: Vec3,
    forward: Vec3,
    /// One pixel to the right and one pixel down, on the plane at distance 1 from the eye
    /// (perspective) or in the picture plane (orthographic).
    right: Vec3,
    down: Vec3,
    middle: [f64; 2],
    perspective: bool,
    lens: Option<(Lens, Vec3, Vec3)>,
}

impl View {
    /// `None` if the camera has no direction, no upright or no field of view.
    pub(crate) fn new(camera: &Camera, width: u32, height: u32) -> Option<Self> {
        let forward = (camera.look_at - camera.eye).normalized();
        let right = forward.cross(camera.up.normalized()).normalized();
        let down = forward.cross(right);
        let (plane_height, perspective) = match camera.projection {
            Projection::Perspective { fov } => (2.0 * (0.5 * fov).tan(), true),
            Projection::Orthographic { height } => (height, false),
        };
        let pixel = plane_height / f64::from(height);
        let usable = right.is_finite() && camera.eye.is_finite() && pixel > 0.0;
        let lens = camera.lens.filter(|lens| lens.radius > 0.0);
        (usable && pixel.is_finite()).then(|| Self {
            eye: camera.eye,
            forward,
            right: right * pixel,
            down: down * pixel,
            middle: [0.5 * f64::from(width), 0.5 * f64::from(height)],
            perspective,
            lens: lens.map(|lens| (lens, right * lens.radius, down * lens.radius)),
        })
    }

    /// The distance of a point from the eye along the direction of view.
    pub(crate) fn depth(&self, point: Vec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    pub(crate) fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// The ray, of unit direction, through the point (x, y) of the picture: in pixels, from the
    /// upper left corner. `lens` is a point of the unit square.
    #[inline]
    pub(crate) fn ray(&self, x: f64, y: f64, lens: (f64, f64)) -> Ray {
        let across = self.right * (x - self.middle[0]) + self.down * (y - self.middle[1]);
        let (origin, direction) = if self.perspective {
            (self.eye, self.forward + across)
        } else {
            (self.eye + across, self.forward)
        };
        let Some((glass, right, down)) = &self.lens else {
            return Ray::new(origin, direction.normalized());
        };
        let (a, b) = warp::disk(lens);
        let shift = *right * a + *down * b;
        let direction = direction * glass.focus - shift;
        Ray::new(origin + shift, direction.normalized())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection, lens: Option<Lens>) -> Camera {
        let (eye, look_at) = (Vec3::new(0.0, -5.0, 1.0), Vec3::new(0.0, 0.0, 1.0));
        Camera { eye, look_at, up: Vec3::Z, projection, lens }
    }

    #[test]
    fn perspective_corners_have_the_field_of_view() {
        let fov = 0.8;
        let view = View::new(&camera(Projection::Perspective { fov }, None), 40, 20).unwrap();
        let middle = view.ray(20.0, 10.0, (0.5, 0.5));
        assert!((middle.direction - Vec3::Y).max_abs() < 1e-15);
        let top = view.ray(20.0, 0.0, (0.5, 0.5)).direction;
        assert!((top.z.atan2(top.y) - 0.4).abs() < 1e-15 && top.x.abs() < 1e-15);
        let right = view.ray(40.0, 10.0, (0.5, 0.5)).direction;
        assert!((right.x / right.y - 2.0 * 0.4_f64.tan()).abs() < 1e-14);
    }

    #[test]
    fn orthographic_rays_are_parallel_and_spaced() {
        let view =
            View::new(&camera(Projection::Orthographic { height: 3.0 }, None), 40, 20).unwrap();
        let (a, b) = (view.ray(0.0, 0.0, (0.5, 0.5)), view.ray(40.0, 20.0, (0.5, 0.5)));
        assert_eq!(a.direction, b.direction);
        assert!((a.origin - Vec3::new(-3.0, -5.0, 2.5)).max_abs() < 1e-15);
        assert!((b.origin - Vec3::new(3.0, -5.0, -0.5)).max_abs() < 1e-15);
    }

    #[test]
    fn rays_through_the_lens_meet_in_the_plane_of_focus() {
        let lens = Some(Lens { radius: 0.3, focus: 4.0 });
        for projection in
            [Projection::Perspective { fov: 0.8 }, Projection::Orthographic { height: 3.0 }]
        {
            let view = View::new(&camera(projection, lens), 40, 20).unwrap();
            let sharp = View::new(&camera(projection, None), 40, 20).unwrap();
            let chief = sharp.ray(33.0, 4.0, (0.5, 0.5));
            let focus = chief.at(4.0 / chief.direction.y);
            for lens_point in [(0.1, 0.2), (0.9, 0.5), (0.4, 0.99)] {
                let ray = view.ray(33.0, 4.0, lens_point);
                let meets = ray.at((focus.y - ray.origin.y) / ray.direction.y);
                assert!((meets - focus).max_abs() < 1e-14);
                assert!((ray.origin - chief.origin).length() <= 0.3 + 1e-15);
            }
        }
    }

    #[test]
    fn cameras_without_a_direction_are_refused() {
        let mut flat = camera(Projection::Perspective { fov: 0.8 }, None);
        flat.look_at = flat.eye;
        assert!(View::new(&flat, 4, 4).is_none());
        let mut upright = camera(Projection::Perspective { fov: 0.8 }, None);
        upright.up = Vec3::Y;
        assert!(View::new(&upright, 4, 4).is_none());
        assert!(View::new(&camera(Projection::Perspective { fov: 0.0 }, None), 4, 4).is_none());
    }
}

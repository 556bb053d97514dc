//! How a camera moves: on a turntable, or along keyframes.
//!
//! Between keyframes, places go on Catmull-Rom splines (cubic Hermite, with the slope at a key that of the line through its neighbours),
//! and numbers that must stay positive on monotone ones (Fritsch and Butland 1984), which never leave the range of the keys on both sides.

use rondure::{Vec3, numeric::gamma};

use crate::{Camera, Lens, Projection};

/// The camera at a moment of its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// When, in seconds.
    pub time: f64,
    /// The camera then.
    pub camera: Camera,
}

impl Camera {
    /// Whether it looks anywhere, and not along its own `up`.
    pub fn has_view(&self) -> bool {
        let view = self.look_at - self.eye;
        let size = view.max_abs();
        let angle = match self.projection {
            Projection::Perspective { fov } => fov > 0.0 && fov < core::f64::consts::PI,
            Projection::Orthographic { height } => height > 0.0,
        };
        let up = self.up / self.up.max_abs();
        size > 0.0
            && view.is_finite()
            && up.is_finite()
            && angle
            && !is_parallel((view / size).normalized(), up.normalized())
    }

    /// The camera turned round the axis through `look_at` along `up`, by an angle in radians, against the clock when seen
    /// from above.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Self {
        let axis = self.up.normalized();
        let arm = self.eye - self.look_at;
        let along = axis * axis.dot(arm);
        let (sin, cos) = angle.sin_cos();
        let across = arm - along;
        let eye = self.look_at + along + across * cos + axis.cross(across) * sin;
        Self { eye, ..self.clone() }
    }

    /// The camera on its way along `keys`, which are in order of time: at the first before it, at the last after it. `None` without keys.
    pub fn between(keys: &[Key], time: f64) -> Option<Self> {
        let (first, last) = (keys.first()?, keys.last()?);
        if time <= first.time || time.is_nan() {
            return Some(first.camera.clone());
        }
        let after = keys.partition_point(|key| key.time <= time);
        let (Some(next), Some(i)) = (keys.get(after), after.checked_sub(1)) else {
            return Some(last.camera.clone());
        };
        let previous = &keys[i];
        let span = Span {
            times: [i.saturating_sub(1), i, after, (after + 1).min(keys.len() - 1)]
                .map(|k| keys[k].time),
            ends: [i == 0, after + 1 == keys.len()],
            place: (time - previous.time) / (next.time - previous.time),
        };
        let around = |value: &dyn Fn(&Camera) -> f64| {
            [i.saturating_sub(1), i, after, (after + 1).min(keys.len() - 1)]
                .map(|k| value(&keys[k].camera))
        };
        let smooth = |value: &dyn Fn(&Camera) -> Vec3| {
            let [x, y, z] =
                [around(&|c| value(c).x), around(&|c| value(c).y), around(&|c| value(c).z)];
            Vec3::new(span.smooth(x), span.smooth(y), span.smooth(z))
        };
        let number = |value: &dyn Fn(&Camera) -> f64| span.monotone(around(value));
        let size = number(&|camera| match camera.projection {
            Projection::Perspective { fov } => fov,
            Projection::Orthographic { height } => height,
        });
        let projection = match previous.camera.projection {
            Projection::Perspective { .. } => Projection::Perspective { fov: size },
            Projection::Orthographic { .. } => Projection::Orthographic { height: size },
        };
        let radius = number(&|camera| camera.lens.map_or(0.0, |lens| lens.radius));
        let focus = number(&|camera| {
            camera.lens.map_or((camera.look_at - camera.eye).length(), |lens| lens.focus)
        });
        Some(Self {
            eye: smooth(&|camera| camera.eye),
            look_at: smooth(&|camera| camera.look_at),
            up: smooth(&|camera| camera.up),
            projection,
            lens: (radius > 0.0).then_some(Lens { radius, focus }),
        })
    }
}

/// Whether two unit vectors are parallel as far as f64 can tell: each has been through up to eight
/// roundings, and the cross product cancels what is left.
pub(crate) fn is_parallel(a: Vec3, b: Vec3) -> bool {
    a.cross(b).length() <= 2.0 * gamma(8)
}

/// The way from the second to the third of four keys.
struct Span {
    times: [f64; 4],
    /// Whether the first, and the last, of them is but the next one again: there is none before, or behind.
    ends: [bool; 2],
    /// How far along, from 0 to 1.
    place: f64,
}

impl Span {
    fn smooth(&self, v: [f64; 4]) -> f64 {
        let t = self.times;
        let slope = |a: usize, b: usize| (v[b] - v[a]) / (t[b] - t[a]);
        let start = slope(if self.ends[0] { 1 } else { 0 }, 2);
        let end = slope(1, if self.ends[1] { 2 } else { 3 });
        self.hermite(v, start, end)
    }

    fn monotone(&self, v: [f64; 4]) -> f64 {
        let t = self.times;
        let slope = |a: usize, b: usize| (v[b] - v[a]) / (t[b] - t[a]);
        // The harmonic mean, weighted by the lengths of both sides; level where the direction changes.
        let joint = |a: usize, b: usize, c: usize| {
            let (before, after) = (slope(a, b), slope(b, c));
            let share = (1.0 + (t[c] - t[b]) / (t[c] - t[a])) / 3.0;
            let mean = before * after / (share * after + (1.0 - share) * before);
            if before * after > 0.0 { mean } else { 0.0 }
        };
        let here = slope(1, 2);
        let start = if self.ends[0] { here } else { joint(0, 1, 2) };
        let end = if self.ends[1] { here } else { joint(1, 2, 3) };
        self.hermite(v, start, end)
    }

    /// The cubic with these slopes at its ends.
    fn hermite(&self, v: [f64; 4], start: f64, end: f64) -> f64 {
        let (u, span) = (self.place, self.times[2] - self.times[1]);
        let (a, b) = ((1.0 - u) * (1.0 - u), u * u);
        v[1] * (a * (1.0 + 2.0 * u))
            + v[2] * (b * (3.0 - 2.0 * u))
            + span * (start * (a * u) - end * (b * (1.0 - u)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: Vec3, fov: f64) -> Camera {
        let projection = Projection::Perspective { fov };
        Camera { eye, look_at: Vec3::new(0.0, 1.0, 2.0), up: Vec3::Z, projection, lens: None }
    }

    fn keys() -> Vec<Key> {
        let key = |time, x, fov| Key { time, camera: camera(Vec3::new(x, -5.0, 1.0), fov) };
        vec![key(0.0, 0.0, 0.1), key(1.0, 2.0, 0.5), key(3.0, 2.5, 0.5), key(4.0, -1.0, 0.2)]
    }

    #[test]
    fn a_turn_keeps_distance_height_and_comes_round() {
        let start = camera(Vec3::new(3.0, -2.0, 5.0), 0.5);
        for i in 0..8 {
            let turned = start.turned(f64::from(i) * core::f64::consts::FRAC_PI_4);
            assert!((turned.eye.z - 5.0).abs() < 1e-14);
            let distance = (turned.eye - turned.look_at).length();
            assert!((distance - (start.eye - start.look_at).length()).abs() < 1e-14);
        }
        let quarter = start.turned(core::f64::consts::FRAC_PI_2).eye;
        assert!((quarter - Vec3::new(3.0, 4.0, 5.0)).max_abs() < 1e-14, "{quarter:?}");
        let tilted = Camera { up: Vec3::new(0.0, 2.0, 0.0), ..start };
        assert!((tilted.turned(1.0).eye.y + 2.0).abs() < 1e-14);
    }

    #[test]
    fn keys_are_met_and_the_ends_last() {
        let keys = keys();
        for key in &keys {
            let at = Camera::between(&keys, key.time).unwrap();
            assert!((at.eye - key.camera.eye).max_abs() < 1e-14);
            assert!((at.look_at - key.camera.look_at).max_abs() < 1e-14);
        }
        assert_eq!(Camera::between(&keys, -1.0).unwrap(), keys[0].camera);
        assert_eq!(Camera::between(&keys, 9.0).unwrap(), keys[3].camera);
        assert_eq!(Camera::between(&keys[..1], 0.5).unwrap(), keys[0].camera);
        assert!(Camera::between(&[], 0.5).is_none());
    }

    #[test]
    fn the_way_is_smooth_and_the_zoom_stays_within_its_keys() {
        let keys = keys();
        let at = |time| Camera::between(&keys, time).unwrap();
        let fov = |camera: &Camera| match camera.projection {
            Projection::Perspective { fov } => fov,
            Projection::Orthographic { .. } => panic!(),
        };
        let h = 1e-6;
        for i in 1..400 {
            let time = f64::from(i) / 100.0;
            let (a, b, c) = (at(time - h), at(time), at(time + h));
            let (before, after) = ((b.eye.x - a.eye.x) / h, (c.eye.x - b.eye.x) / h);
            assert!((before - after).abs() < 1e-3, "{time}: {before} {after}");
            let (before, after) = ((fov(&b) - fov(&a)) / h, (fov(&c) - fov(&b)) / h);
            assert!((before - after).abs() < 1e-3, "{time}: {before} {after}");
            assert!((0.1..=0.5 + 1e-12).contains(&fov(&b)), "{time}");
        }
        // From 1 to 3 the zoom stands still.
        assert!((fov(&at(2.0)) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_camera_without_a_view_is_known() {
        assert!(camera(Vec3::new(3.0, -2.0, 5.0), 0.5).has_view());
        let bad = [
            camera(Vec3::new(0.0, 1.0, 2.0), 0.5),
            camera(Vec3::new(0.0, 1.0, 9.0), 0.5),
            camera(Vec3::new(3.0, -2.0, 5.0), 0.0),
            camera(Vec3::new(f64::NAN, -2.0, 5.0), 0.5),
            Camera { up: Vec3::new(0.0, 0.0, 0.0), ..camera(Vec3::new(3.0, -2.0, 5.0), 0.5) },
        ];
        assert!(bad.iter().all(|camera| !camera.has_view()));
    }
}

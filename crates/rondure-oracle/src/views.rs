//! Pictures without light: the rays of small cameras.

use rondure::{Ray, Vec3};

/// The width and height of the pictures; odd, so that the middle row and column pass exactly
/// through the point that is looked at.
pub const WIDTH: usize = 97;
/// See [`WIDTH`].
pub const HEIGHT: usize = 73;

fn frame(forward: Vec3) -> [Vec3; 3] {
    let forward = forward.normalized();
    let up = if forward.x == 0.0 && forward.y == 0.0 { Vec3::Y } else { Vec3::Z };
    let right = forward.cross(up).normalized();
    [right, right.cross(forward), forward]
}

fn offsets() -> impl Iterator<Item = (f64, f64)> {
    let half = |n: usize| (n / 2) as f64;
    (0..HEIGHT).flat_map(move |j| {
        (0..WIDTH).map(move |i| {
            let scale = half(HEIGHT).recip();
            ((i as f64 - half(WIDTH)) * scale, (half(HEIGHT) - j as f64) * scale)
        })
    })
}

/// The rays of a camera at `eye` that looks at `target`; half the height of the picture spans
/// `half_angle` radians.
pub fn perspective(eye: Vec3, target: Vec3, half_angle: f64) -> Vec<Ray> {
    let [right, up, forward] = frame(target - eye);
    let reach = half_angle.tan();
    offsets()
        .map(|(x, y)| Ray::new(eye, forward + right * (x * reach) + up * (y * reach)))
        .collect()
}

/// The rays of an orthographic camera that looks along `forward` at `target`; half the height of the
/// picture spans `half_height`.
pub fn orthographic(target: Vec3, forward: Vec3, distance: f64, half_height: f64) -> Vec<Ray> {
    let [right, up, forward] = frame(forward);
    offsets()
        .map(|(x, y)| {
            let shift = right * (x * half_height) + up * (y * half_height);
            Ray::new(target - forward * distance + shift, forward)
        })
        .collect()
}

//! Light from pictures of all directions, against its integral.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::{f64::consts::PI, sync::Arc};

use common::{Build, matte, mean, scene};
use rondure::Vec3;
use rondure_scene::{Image, Integrator, Projection, Shape, Sky};

/// A dim sky with a bright spot half way up, to the right of +y: some hundred times as bright.
fn picture() -> Image {
    let (width, height) = (64, 32);
    let value = |i: u32| match (i % width, i / width) {
        (40..=42, 7..=8) => 60.0,
        (_, 0..=15) => 0.4,
        _ => 0.1,
    };
    Image::new(width, height, 1, (0..width * height).map(value).collect()).unwrap()
}

/// The light on a level surface, summed over the pixels: what is interpolated between them has the same sum but
/// for the change of the solid angle across a pixel.
fn irradiance(image: &Image) -> f64 {
    let parts = 16;
    let (width, height) = (image.width() * parts, image.height() * parts);
    let mut sum = 0.0;
    let at = |x: i64, y: i64| {
        let x = x.rem_euclid(i64::from(image.width())) as u32;
        f64::from(image.pixel(x, y.clamp(0, i64::from(image.height()) - 1) as u32)[0])
    };
    for j in 0..height / 2 {
        let v = (f64::from(j) + 0.5) / f64::from(parts) - 0.5;
        let (top, fy) = (v.floor(), v - v.floor());
        let (sin, cos) = (PI * (f64::from(j) + 0.5) / f64::from(height)).sin_cos();
        for i in 0..width {
            let u = (f64::from(i) + 0.5) / f64::from(parts) - 0.5;
            let (left, fx) = (u.floor(), u - u.floor());
            let row = |y: i64| at(left as i64, y) * (1.0 - fx) + at(left as i64 + 1, y) * fx;
            let light = row(top as i64) * (1.0 - fy) + row(top as i64 + 1) * fy;
            sum += light * sin * cos;
        }
    }
    sum * 2.0 * PI * PI / (f64::from(width) * f64::from(height))
}

#[test]
fn level_ground_gets_the_integral_of_the_picture() {
    let image = Arc::new(picture());
    let ground = Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z };
    let expected = 0.5 / PI * irradiance(&image) * 0.25;
    for integrator in [Integrator::Path, Integrator::Whitted] {
        for rotation in [0.0, 2.0] {
            let sky = Sky::Image { image: Arc::clone(&image), intensity: 0.25, rotation };
            let view = Projection::Orthographic { height: 1.0 };
            let mut scene = scene(16, 64, Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, view)
                .with(ground.clone(), matte(0.5))
                .under(sky);
            scene.film.integrator = integrator;
            let found = mean(&scene.shoot());
            let apart = (found / expected - 1.0).abs();
            assert!(apart < 0.02, "{integrator:?}: {found}, not {expected}");
        }
    }
}

//! The white furnace: under a white sky nothing may give back more light than it gets, and what
//! absorbs nothing gives back all.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::sync::Arc;

use common::{Build, WHITE, at, matte, mean, scene};
use rondure::{Affine, Instance, Profile, Surface, Vec3};
use rondure_scene::{Glass, Material, Paint, Projection, Scene, Shape};

const PAINT: Paint = Paint::Solid([1.0; 3]);

fn ball(material: Material) -> Scene {
    furnace(Shape::Sphere { center: Vec3::ZERO, radius: 1.0 }, material)
}

fn furnace(shape: Shape, material: Material) -> Scene {
    let eye = Vec3::new(0.0, -6.0, 0.5);
    let mut scene = scene(24, 256, eye, Vec3::ZERO, Projection::Perspective { fov: 0.3 });
    scene.film.depth = 60;
    scene.under(WHITE).with(shape, material)
}

#[test]
fn white_matte_vanishes() {
    let picture = ball(matte(1.0)).shoot();
    assert!(picture.pixels().iter().all(|p| (p[0] - 1.0).abs() < 1e-6));
}

#[test]
fn grey_matte_is_its_reflectance() {
    let picture = ball(matte(0.3)).shoot();
    assert!((at(&picture, 12, 12) - 0.3).abs() < 1e-6);
}

#[test]
fn white_gloss_vanishes() {
    for (specular, roughness) in [(1.0, 0.0), (0.5, 0.0), (1.0, 0.3), (1.0, 0.8)] {
        let picture = ball(Material::Glossy { color: PAINT, specular, roughness }).shoot();
        let mean = mean(&picture);
        assert!((mean - 1.0).abs() < 3e-3, "{specular} {roughness}: {mean}");
        let brightest = picture.pixels().iter().map(|p| p[0]).fold(0.0, f32::max);
        assert!(brightest < 1.08, "{specular} {roughness}: {brightest}");
    }
}

#[test]
fn white_mirror_vanishes() {
    let picture = ball(Material::Mirror { color: PAINT }).shoot();
    assert!(picture.pixels().iter().all(|p| (p[0] - 1.0).abs() < 1e-6));
}

#[test]
fn clear_glass_vanishes() {
    let glass = || Material::Glass(Glass::clear([1.0; 3], 1.5));
    let mean_of_ball = mean(&ball(glass()).shoot());
    assert!((mean_of_ball - 1.0).abs() < 3e-3, "{mean_of_ball}");
    let pane = Shape::Disk { center: Vec3::ZERO, normal: Vec3::Y, radius: 1.0 };
    let mean_of_pane = mean(&furnace(pane, glass()).shoot());
    assert!((mean_of_pane - 1.0).abs() < 1e-3, "{mean_of_pane}");
    let goblet = Profile::from_path_data(include_str!("../../../profiles/goblet.path")).unwrap();
    let placement = Affine::translate(Vec3::new(0.0, 0.0, -0.5));
    let goblet = Instance::new(Arc::new(Surface::new(&goblet)), placement).unwrap();
    let mean_of_goblet = mean(&furnace(Shape::Turned(goblet), glass()).shoot());
    assert!((mean_of_goblet - 1.0).abs() < 5e-3, "{mean_of_goblet}");
}

#[test]
fn coloured_glass_absorbs_by_length() {
    // Straight through the middle of a ball of radius 1: two boundaries, two units of way.
    let mut scene = ball(Material::Glass(Glass::clear([0.5; 3], 1.5)));
    scene.camera.eye = Vec3::new(0.0, -6.0, 0.0);
    scene.camera.projection = Projection::Orthographic { height: 1e-3 };
    // R of the front; the rest goes to and fro inside, a quarter of it left after each crossing.
    let (r, a) = (0.04, 0.25);
    let expected = r + (1.0 - r) * (1.0 - r) * a / (1.0 - r * a);
    let found = mean(&scene.shoot());
    assert!((found - expected).abs() < 1e-4, "{found} {expected}");
}

//! Scenes for the tests, built by hand.

#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use rondure::Vec3;
use rondure_render::{Picture, Settings, render};
use rondure_scene::{
    Camera, Copies, Cut, Film, Integrator, Light, Material, Object, Paint, Projection, Scene,
    Shape, Sky,
};

pub(crate) const BLACK: Sky = Sky::Constant { color: [0.0; 3] };
pub(crate) const WHITE: Sky = Sky::Constant { color: [1.0; 3] };

pub(crate) fn matte(v: f64) -> Material {
    Material::Matte { color: Paint::Solid([v; 3]) }
}

/// A square picture seen from `eye`.
pub(crate) fn scene(
    size: u32,
    spp: u32,
    eye: Vec3,
    look_at: Vec3,
    projection: Projection,
) -> Scene {
    let up = if (look_at - eye).normalized().z.abs() > 0.9 { Vec3::Y } else { Vec3::Z };
    Scene {
        film: Film {
            width: size,
            height: size,
            spp,
            integrator: Integrator::Whitted,
            ..Film::default()
        },
        keys: Vec::new(),
        camera: Camera { eye, look_at, up, projection, lens: None },
        sky: BLACK,
        lights: Vec::new(),
        objects: Vec::new(),
        materials: Vec::new(),
        reliefs: Vec::new(),
        section: Vec::new(),
    }
}

pub(crate) trait Build: Sized {
    fn with(self, shape: Shape, material: Material) -> Self;
    fn lit(self, light: Light) -> Self;
    fn under(self, sky: Sky) -> Self;
    fn shoot(&self) -> Picture;
}

impl Build for Scene {
    fn with(mut self, shape: Shape, material: Material) -> Self {
        let name = format!("object {}", self.objects.len());
        let index = self.materials.len();
        self.objects.push(Object {
            name,
            shape,
            material: index,
            copies: Copies::default(),
            section: Cut::default(),
        });
        self.materials.push(material);
        self
    }

    fn lit(mut self, light: Light) -> Self {
        self.lights.push(light);
        self
    }

    fn under(mut self, sky: Sky) -> Self {
        self.sky = sky;
        self
    }

    fn shoot(&self) -> Picture {
        let picture = render(self, &Settings { threads: Some(1), seed: 1 }, &()).unwrap();
        assert_eq!(picture.statistics().invalid_samples, 0);
        picture
    }
}

pub(crate) fn at(picture: &Picture, x: u32, y: u32) -> f64 {
    f64::from(picture.pixels()[(y * picture.width() + x) as usize][1])
}

pub(crate) fn mean(picture: &Picture) -> f64 {
    let sum: f64 = picture.pixels().iter().map(|p| f64::from(p[1])).sum();
    sum / picture.pixels().len() as f64
}

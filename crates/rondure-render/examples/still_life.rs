//! Renders a small still life of china and glass and tells what a ray costs.
//!
//! `cargo run --release -p rondure-render --example still_life -- OUT.png [SPP] [THREADS] [KIND]`
//!
//! KIND is `art` (the default: lamps with area, a sky, glass) or `plain` (matte things and one point
//! light, for timing).

use std::{error::Error, f64::consts::PI, fs, path::PathBuf, sync::Arc, time::Instant};

use rondure::{Affine, Instance, Profile, Surface, Vec3};
use rondure_render::{Settings, render};
use rondure_scene::{
    Camera, Copies, Cut, Film, Glass, Integrator, Light, Material, Object, Paint, Projection,
    Scene, Shape, Sky,
};

fn turned(name: &str, at: [f64; 2], scale: f64) -> Result<Shape, Box<dyn Error>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../profiles");
    let text = fs::read_to_string(path.join(name).with_extension("path"))?;
    let surface = Surface::new(&Profile::from_path_data(&text)?);
    let placement =
        Affine::translate(Vec3::new(at[0], at[1], 0.0)).after(&Affine::scale(Vec3::splat(scale)));
    Instance::new(Arc::new(surface), placement)
        .map(Shape::Turned)
        .ok_or_else(|| "a placement cannot be inverted".into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let out = args.next().unwrap_or_else(|| "still_life.png".to_owned());
    let spp = args.next().map_or(Ok(16), |s| s.parse())?;
    let threads = args.next().map(|s| s.parse()).transpose()?;
    let plain = args.next().as_deref() == Some("plain");
    let china =
        |color| Material::Glossy { color: Paint::Solid(color), specular: 1.0, roughness: 0.0 };
    let mut materials = vec![
        china([0.75, 0.75, 0.72]),
        china([0.05, 0.12, 0.35]),
        Material::Glass(Glass::clear([0.75, 0.95, 0.85], 1.5)),
        Material::Glossy { color: Paint::Solid([0.5, 0.06, 0.03]), specular: 1.0, roughness: 0.35 },
        Material::Mirror { color: Paint::Solid([0.9, 0.75, 0.4]) },
        Material::Matte {
            color: Paint::Checker { colors: [[0.45, 0.4, 0.35], [0.6, 0.56, 0.5]], size: [0.5; 2] },
        },
    ];
    let mut lights = vec![
        Light::Disk {
            center: Vec3::new(-3.0, -1.5, 4.0),
            normal: Vec3::new(3.0, 1.5, -3.6).normalized(),
            radius: 0.8,
            radiance: [14.0, 13.0, 11.5],
        },
        Light::Point { position: Vec3::new(3.0, -3.0, 3.0), intensity: [2.0, 2.2, 2.6] },
    ];
    let mut sky =
        Sky::Gradient { zenith: [0.25, 0.35, 0.6], horizon: [0.6, 0.6, 0.6], ground: [0.2; 3] };
    if plain {
        materials.fill(Material::Matte { color: Paint::Solid([0.6, 0.5, 0.4]) });
        lights = vec![Light::Point { position: Vec3::new(3.0, -3.0, 3.0), intensity: [30.0; 3] }];
        sky = Sky::Constant { color: [0.0; 3] };
    }
    let objects = [
        ("vase", turned("vase", [-0.9, 0.6], 1.6)?, 0),
        ("goblet", turned("goblet", [0.15, -0.35], 1.1)?, 2),
        ("pawn", turned("pawn", [-0.45, -0.55], 0.6)?, 3),
        ("pawn 2", turned("pawn", [0.75, -0.8], 0.5)?, 1),
        ("column", turned("column", [1.3, 1.0], 1.9)?, 0),
        ("ring", turned("torus", [0.62, 0.1], 0.16)?, 4),
        ("ball", Shape::Sphere { center: Vec3::new(-1.15, -0.45, 0.22), radius: 0.22 }, 2),
        ("table", Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z }, 5),
    ]
    .map(|(name, shape, material)| Object {
        name: name.to_owned(),
        shape,
        material,
        copies: Copies::default(),
        section: Cut::default(),
    });
    let scene = Scene {
        film: Film { spp, depth: 12, integrator: Integrator::Whitted, ..Film::default() },
        keys: Vec::new(),
        camera: Camera {
            eye: Vec3::new(0.4, -4.2, 1.7),
            look_at: Vec3::new(0.05, 0.0, 0.62),
            up: Vec3::Z,
            projection: Projection::Perspective { fov: 36.0 * PI / 180.0 },
            lens: None,
        },
        sky,
        lights,
        objects: objects.into(),
        materials,
        reliefs: Vec::new(),
        section: Vec::new(),
    };
    let start = Instant::now();
    let picture = render(&scene, &Settings { threads, seed: 0 }, &())?;
    let seconds = start.elapsed().as_secs_f64();
    picture.write_png(&out, 8)?;
    let s = picture.statistics();
    let rays = s.camera_rays + s.secondary_rays + s.shadow_rays;
    println!("{s:?}\n{seconds:.3} s, {:.0} ns per ray", seconds * 1e9 / rays as f64);
    Ok(())
}

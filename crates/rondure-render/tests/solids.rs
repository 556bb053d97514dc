//! Solids made of others, sweeps and sections in pictures: what is cut is seen where it must be, nothing
//! shadows itself, glass stays glass, and faces have the right material.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::{f64::consts::PI, sync::Arc};

use common::{BLACK, Build, WHITE, at, matte, mean, scene};
use rondure::{
    Affine, Bounds, FillRule, Instance, Profile, Solid, Surface, Vec3,
    solid::{Csg, Sweep},
};
use rondure_render::Picture;
use rondure_scene::{Body, Cut, Glass, Light, Material, Paint, Projection, Scene, Section, Shape};

fn color(color: [f64; 3]) -> Material {
    Material::Matte { color: Paint::Solid(color) }
}

fn surface(path: &str) -> Arc<Surface> {
    Arc::new(Surface::new(&Profile::from_path_data(path).unwrap()))
}

fn turned(path: &str) -> Csg {
    let solid = Solid::new(&Profile::from_path_data(path).unwrap(), FillRule::NonZero).unwrap();
    Csg::turned(Arc::new(solid))
}

fn cube(half: Vec3) -> Csg {
    Csg::cuboid(Bounds { min: half * -1.0, max: half })
}

/// A body whose primitives have these materials.
fn body(csg: Csg, materials: &[Option<usize>], placement: Affine) -> Shape {
    Shape::Body(Body { csg: Arc::new(csg), materials: materials.into(), placement })
}

fn cut(mut scene: Scene, point: Vec3, normal: Vec3, material: Option<usize>) -> Scene {
    scene.section.push(Section { point, normal, material });
    scene
}

fn pixel(picture: &Picture, x: u32, y: u32) -> [f32; 3] {
    picture.pixels()[(y * picture.width() + x) as usize]
}

/// Where a level plane cuts solids at the height of a vertex, the face must be seen just where the
/// solid goes on above and below: in these rings, known without any ray. Where the solid ends at the plane
/// its own face is seen.
#[test]
fn cuts_at_the_height_of_a_vertex_show_the_face_pixel_for_pixel() {
    type Case = (&'static str, f64, &'static [[f64; 2]]);
    let double = "M 0 0 L 1 0.7 L 0 1.4 L 1 2.1 L 0 2.8";
    let ring = "M 1 0 L 2 0 L 2.5 1 L 2 2 L 1 2 L 0.5 1 Z";
    let stairs = "M 0 0 H 3 V 0.5 H 2 V 1 H 1 V 1.5 H 0";
    let sphere = "M 0 -1 A 1 1 0 0 1 1 0 A 1 1 0 0 1 0 1";
    let torus = "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z";
    let cases: [Case; 11] = [
        (double, 0.7, &[[0.0, 1.0]]),
        (double, 1.4, &[]),
        (double, 2.1, &[[0.0, 1.0]]),
        (ring, 0.0, &[]),
        (ring, 1.0, &[[0.5, 2.5]]),
        (ring, 2.0, &[]),
        (stairs, 0.5, &[[0.0, 2.0]]),
        (stairs, 1.0, &[[0.0, 1.0]]),
        (stairs, 1.5, &[]),
        (sphere, 0.0, &[[0.0, 1.0]]),
        (torus, 0.0, &[[1.0, 3.0]]),
    ];
    let mut faces = 0;
    for (path, z, rings) in cases {
        let eye = Vec3::new(0.7, -6.0, z + 5.0);
        let height = 6.4;
        let mut scene =
            scene(73, 4, eye, Vec3::new(0.0, 0.0, z), Projection::Orthographic { height });
        scene.film.width = 97;
        let instance = Instance::new(surface(path), Affine::IDENTITY).unwrap();
        let scene = scene.under(WHITE).with(Shape::Turned(instance), color([1.0, 0.0, 0.0])).with(
            Shape::Disk { center: Vec3::new(0.0, 0.0, 90.0), normal: Vec3::Z, radius: 0.1 },
            color([0.0, 1.0, 0.0]),
        );
        let picture = cut(scene, Vec3::new(0.0, 0.0, z), Vec3::Z, Some(1)).shoot();
        // Where the ray through a place of the picture, in pixels, passes the plane.
        let forward = (Vec3::new(0.0, 0.0, z) - eye).normalized();
        let right = forward.cross(Vec3::Z).normalized();
        let down = forward.cross(right);
        let radius = |x: f64, y: f64| {
            let size = height / 73.0;
            let p = eye + right * ((x - 48.5) * size) + down * ((y - 36.5) * size);
            let on = p + forward * ((z - p.z) / forward.z);
            on.x.hypot(on.y)
        };
        let on_face = |r: f64| rings.iter().any(|[a, b]| (*a..*b).contains(&r));
        for y in 0..73 {
            for x in 0..97 {
                // Samples lie up to two pixels off.
                let near = (0..25).map(|i| [f64::from(i % 5), f64::from(i / 5)]);
                let near =
                    near.map(|[i, j]| radius(f64::from(x) + i - 1.5, f64::from(y) + j - 1.5));
                let on: Vec<_> = near.map(on_face).collect();
                if on.iter().any(|o| *o != on[0]) {
                    continue;
                }
                let [r, g, b] = pixel(&picture, x, y);
                let green = g > 0.9 && r == 0.0 && b == 0.0;
                assert_eq!(green, on[0], "{path} at {z}: {x} {y}: {r} {g} {b}");
                faces += u32::from(green);
            }
        }
    }
    assert!(faces > 3_500, "{faces}");
}

/// Under a white sky white convex bodies vanish: no ray that leaves them meets them again.
#[test]
fn convex_bodies_do_not_shadow_themselves() {
    let ball = || Csg::sphere(Vec3::ZERO, 1.0);
    let half = |n: Vec3| Csg::half_space(Vec3::ZERO, n);
    let rod = "M 0 -1 H 0.8 V 1 H 0";
    let shapes = [
        cube(Vec3::new(1.0, 0.5, 0.7)),
        ball().intersection(half(Vec3::new(0.0, -0.3, 1.0))),
        ball().difference(half(Vec3::X)),
        turned(rod).swept(&Sweep::degrees(-130.0, -20.0).unwrap()),
        turned("M 0 -1 L 1 0 L 0 1").intersection(half(Vec3::Z)),
    ];
    for csg in shapes {
        for (size, offset) in [(1.0, 0.0), (1e-3, 1e3), (1e4, 1e5)] {
            let place = Vec3::new(1.0, -0.4, 0.3) * (offset * size);
            let turn = Affine::rotate(Vec3::new(1.0, 0.4, 0.2), 0.3);
            let map = turn.after(&Affine::scale(Vec3::splat(size)));
            let map = Affine::translate(place).after(&map);
            let eye = place + Vec3::new(0.5, -5.0, 2.5) * size;
            let view = Projection::Orthographic { height: 3.0 * size };
            let scene = scene(24, 16, eye, place, view).under(WHITE);
            let picture = scene.with(body(csg.clone(), &[None; 3], map), matte(1.0)).shoot();
            let off = |p: &[f32; 3]| (p[0] - 1.0).abs() > 1e-6;
            assert!(!picture.pixels().iter().any(off), "{size} {offset} {csg:?}");
        }
    }
}

/// The same solid as a turned object and as a body, of glass and of stone.
#[test]
fn a_body_of_one_solid_looks_like_the_turned_object() {
    let goblet = include_str!("../../../profiles/goblet.path");
    let glass = Material::Glass(Glass::clear([0.7, 0.9, 0.8], 1.5));
    // In glass a ray that rounding moves over an edge goes another way.
    for (material, most) in [(glass, 80), (matte(0.7), 4)] {
        let shoot = |shape: Shape| {
            let look_at = Vec3::new(0.0, 0.0, 0.5);
            let view = Projection::Perspective { fov: 0.45 };
            scene(32, 16, Vec3::new(0.0, -5.0, 2.0), look_at, view)
                .with(shape, material.clone())
                .with(Shape::Plane { point: Vec3::ZERO, normal: Vec3::Z }, matte(0.5))
                .lit(Light::Point { position: Vec3::new(2.0, -2.0, 4.0), intensity: [20.0; 3] })
                .under(WHITE)
                .shoot()
        };
        let plain = shoot(Shape::Turned(Instance::new(surface(goblet), Affine::IDENTITY).unwrap()));
        let made = shoot(body(turned(goblet), &[None], Affine::IDENTITY));
        let same = plain.pixels().iter().zip(made.pixels());
        let different = same.filter(|(a, b)| (a[1] - b[1]).abs() > 1e-3).count();
        assert!(different <= most, "{different}");
        assert!((mean(&plain) - mean(&made)).abs() < 2e-3);
    }
}

/// Clear glass that absorbs nothing gives back all the light of a white sky, however it is cut.
#[test]
fn glass_that_is_cut_keeps_all_light() {
    let ball = |x: f64| Csg::sphere(Vec3::new(x, 0.0, 0.0), 1.0);
    let eye = Vec3::new(0.3, -6.0, 1.0);
    let shoot = |csg: Csg| {
        let glass = Material::Glass(Glass::clear([1.0; 3], 1.5));
        let mut scene = scene(16, 64, eye, Vec3::ZERO, Projection::Perspective { fov: 0.3 });
        scene.film.depth = 80;
        let scene = scene.under(WHITE).with(body(csg, &[None; 4], Affine::IDENTITY), glass);
        cut(scene, Vec3::new(0.0, -0.2, 0.0), Vec3::new(0.2, -1.0, 0.3), None).shoot()
    };
    for csg in [
        ball(0.0).union(ball(0.6)),
        ball(0.0).intersection(ball(0.6)),
        ball(0.0).difference(Csg::sphere(Vec3::ZERO, 0.8)),
        cube(Vec3::splat(0.8)).difference(ball(0.0)),
    ] {
        let mean = mean(&shoot(csg));
        assert!((mean - 1.0).abs() < 0.01, "{mean}");
    }
}

/// Light that passes straight through a slab of glass is weakened by the way inside.
#[test]
fn shadows_of_cut_glass_are_as_thick_as_what_is_left() {
    let glass = Material::Glass(Glass::clear([0.5; 3], 1.0));
    let slab = cube(Vec3::new(2.0, 2.0, 1.0));
    let look = Projection::Orthographic { height: 0.5 };
    let floor = Shape::Plane { point: Vec3::new(0.0, 0.0, -2.0), normal: Vec3::Z };
    let light = Light::Sun { direction: Vec3::Z, irradiance: [PI; 3], angular_radius: 0.0 };
    let eye = Vec3::new(0.0, -4.0, -1.6);
    for (top, left) in [(5.0, 2.0), (0.0, 1.0), (-0.5, 0.5)] {
        let scene = scene(4, 4, eye, Vec3::new(0.0, 0.0, -2.0), look)
            .under(BLACK)
            .with(body(slab.clone(), &[None], Affine::IDENTITY), glass.clone())
            .with(floor.clone(), matte(1.0))
            .lit(light.clone());
        let picture = cut(scene, Vec3::new(0.0, 0.0, top), Vec3::Z, None).shoot();
        let (found, law) = (at(&picture, 2, 2), 0.5_f64.powf(left));
        assert!((found - law).abs() < 1e-6, "{top}: {found} {law}");
    }
}

/// Seen from above: a slotted disk and its cut. Each face has the material of its primitive, or if that has
/// none, of what it was cut from; the section's comes after the object's own.
#[test]
fn faces_have_the_material_of_the_right_operand() {
    let [red, green, blue, white] =
        [[0.8, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8], [0.8; 3]].map(color);
    // A red disk of radius 2, in it a green ball that stands out; a slot taken away at x = 1.
    let csg = || {
        let slot =
            Csg::cuboid(Bounds { min: Vec3::new(1.0, -9.0, -0.5), max: Vec3::new(1.5, 9.0, 9.0) });
        Csg::Difference(vec![
            turned("M 0 -1 H 2 V 0 H 0").union(Csg::sphere(Vec3::new(-1.0, 0.0, 0.0), 0.5)),
            slot,
        ])
    };
    let shoot = |slot: Option<usize>, own: Option<usize>, section: Option<(f64, Option<usize>)>| {
        let eye = Vec3::new(0.0, 0.0, 10.0);
        let mut scene = scene(40, 4, eye, Vec3::ZERO, Projection::Orthographic { height: 4.0 })
            .under(WHITE)
            .with(body(csg(), &[Some(1), Some(2), slot], Affine::IDENTITY), white.clone());
        scene.materials.extend([red.clone(), green.clone(), blue.clone()]);
        scene.objects[0].section = Cut::Open { material: own };
        match section {
            Some((z, material)) => cut(scene, Vec3::new(0.0, 0.0, z), Vec3::Z, material).shoot(),
            None => scene.shoot(),
        }
    };
    // The channels that a pixel at (x, 0.3) has.
    let seen = |picture: &Picture, x: f64| {
        let across = ((x + 2.0) * 10.0) as u32;
        pixel(picture, across, 17).map(|channel| channel > 0.1)
    };
    let (is_red, is_green, is_blue) =
        ([true, false, false], [false, true, false], [false, false, true]);
    for (slot, expected) in [(Some(3), is_blue), (None, is_red)] {
        let picture = shoot(slot, None, None);
        assert_eq!([-1.0, 0.0, 1.25].map(|x| seen(&picture, x)), [is_green, is_red, expected]);
    }
    // Of the union's operands the first that holds the place: below z = 0 the disk, above it the ball.
    let through = |z: f64, own, material| shoot(Some(3), own, Some((z, material)));
    assert_eq!(seen(&through(-0.25, None, None), -1.0), is_red);
    assert_eq!(seen(&through(0.25, None, None), -1.0), is_green);
    let painted = through(-0.25, None, Some(3));
    assert_eq!([-1.0, 0.0, 1.25].map(|x| seen(&painted, x)), [is_blue; 3]);
    let own = through(-0.25, Some(2), Some(3));
    assert_eq!([-1.0, 0.0, 1.25].map(|x| seen(&own, x)), [is_green, is_green, is_blue]);
}

/// Open surfaces are cut and closed by nothing; what is to stay whole stays whole; what lies in front
/// of one of two planes alone stays.
#[test]
fn sections_leave_open_surfaces_open() {
    let sheet = |x: f64| {
        let map = Affine::translate(Vec3::new(x, 0.0, 0.0));
        Shape::Turned(Instance::new(surface("M 0.5 -1 V 1"), map).unwrap())
    };
    let sphere = |x: f64| Shape::Sphere { center: Vec3::new(x, 0.0, 0.0), radius: 0.5 };
    let eye = Vec3::new(0.0, -20.0, 0.0);
    let mut base = scene(64, 4, eye, Vec3::ZERO, Projection::Orthographic { height: 6.4 })
        .under(WHITE)
        .with(sheet(-2.5), matte(0.0))
        .with(sphere(-1.0), matte(0.0))
        .with(sphere(0.5), color([0.0, 0.8, 0.0]))
        .with(sphere(2.5), matte(0.0));
    base.objects[1].section = Cut::Whole;
    // In front: nothing is left of the sheet's and the balls' front halves.
    let front = cut(base.clone(), Vec3::ZERO, -Vec3::Y, None).shoot();
    let is = |picture: &Picture, x: f64| pixel(picture, (10.0 * x + 32.0) as u32, 32);
    // The sheet's back half is black, too.
    assert_eq!(is(&front, -2.5), [0.0; 3]);
    assert_eq!(is(&front, 0.5).map(|c| c > 0.1), [false, true, false]);
    // All in front but what stays whole.
    let nothing = cut(base.clone(), Vec3::new(0.0, 5.0, 0.0), -Vec3::Y, None).shoot();
    assert_eq!([-2.5, -1.0, 0.5, 2.5].map(|x| is(&nothing, x)[0]), [1.0, 0.0, 1.0, 1.0]);
    // A quarter: of what is in front of both planes alone.
    let quarter = cut(base, Vec3::new(0.0, 5.0, 0.0), -Vec3::Y, None);
    let quarter = cut(quarter, Vec3::ZERO, Vec3::X, None).shoot();
    assert_eq!([-2.5, -1.0, 2.5].map(|x| is(&quarter, x)[0]), [0.0, 0.0, 1.0]);
}

/// Of a sheet swept over a part of the turn the rest lets rays and light through.
#[test]
fn open_sweeps_have_holes() {
    let instance = Instance::new(surface("M 1 -1 V 1"), Affine::IDENTITY).unwrap();
    let sweep = Sweep::degrees(0.0, 180.0).unwrap();
    let light = Light::Point { position: Vec3::ZERO, intensity: [PI; 3] };
    let eye = Vec3::new(0.0, -20.0, 0.0);
    let picture = scene(20, 4, eye, Vec3::ZERO, Projection::Orthographic { height: 2.2 })
        .with(Shape::Swept { instance, sweep }, matte(1.0))
        .lit(light)
        .shoot();
    // The inside of the back wall, at a distance of 1 from the light.
    assert!((at(&picture, 10, 10) - 1.0).abs() < 0.02, "{}", at(&picture, 10, 10));
}

//! Liquids: what fills a vessel is level on top, ends in the wall, and gives way to it.

#![allow(clippy::expect_used, clippy::panic, reason = "a test that fails may stop")]

use std::{f64::consts::PI, path::Path};

use rondure::{FillRule, Instance, Point, Solid, Vec3};
use rondure_scene::{Cut, Material, Object, Scene, Shape, parse_scene};

const START: &str = "[camera]\neye = [0, -5, 1]\nlook_at = [0, 0, 0]\n[sky]\n\
    [materials]\nglass = { type = \"glass\" }\nfirm = { type = \"glass\", priority = 3 }\n\
    wine = { type = \"glass\", ior = 1.34 }\nmilk = { color = \"white\" }\n\
    [profiles]\n";

fn parse(text: &str) -> Scene {
    let text = format!("{START}{text}");
    let (scene, _) = parse_scene("<scene>", &text, Path::new("../../scenes"))
        .map_err(|e| e.to_string())
        .expect("good");
    scene
}

fn turned(object: &Object) -> &Instance {
    let Shape::Turned(instance) = &object.shape else { panic!("not turned") };
    instance
}

fn solid(object: &Object) -> Solid {
    let surface = turned(object).surface();
    Solid::from_surface(surface.clone(), FillRule::NonZero).expect("a solid")
}

/// Everywhere in the vessel's hollow below the level is liquid, nothing above, and what is liquid elsewhere is
/// wall.
fn fills(vessel: &Object, liquid: &Object, level: f64) {
    let cavity = turned(vessel).surface().profile().measure().cavity.expect("a hollow");
    let (wall, liquid) = (solid(vessel), solid(liquid));
    let bounds = wall.bounds();
    let (mut inside, mut seen) = (0, 0);
    for i in 0..400 {
        for k in 0..400 {
            let r = bounds.max.x * (f64::from(i) + 0.37) / 400.0;
            let z = bounds.min.z + (bounds.max.z - bounds.min.z) * (f64::from(k) + 0.41) / 400.0;
            let at = Vec3::new(r, 0.0, z);
            let (wet, in_wall) = (liquid.contains(at), wall.contains(at));
            let hollow = cavity.contains(Point::new(r, z)) && z < level;
            assert!(wet || !hollow, "no liquid at ({r}, {z})");
            assert!(!wet || (z <= level && (hollow || in_wall)), "liquid at ({r}, {z})");
            seen += usize::from(hollow);
            inside += usize::from(wet && in_wall);
        }
    }
    assert!(seen > 1000 && inside > 20, "{seen} {inside}");
}

#[test]
fn vessels_are_filled_to_a_level() {
    for (profile, level) in [
        ("{ path = \"M 0 0 L 1 0 L 1 2 L 0.9 2 L 0.9 0.1 L 0 0.1\" }", 1.3),
        // To the brim.
        ("{ path = \"M 0 0 L 1 0 L 1 2 L 0.9 2 L 0.9 0.1 L 0 0.1\" }", 2.0),
        // Drawn the other way, and closed.
        ("{ path = \"M 0 0.1 H 0.9 V 2 H 1 V 0 H 0 Z\" }", 0.4),
        ("{ file = \"profiles/wine-glass.path\" }", 13.2),
        ("{ file = \"profiles/wine-glass.path\" }", 19.0),
        ("{ file = \"profiles/bottle.path\" }", 20.0),
        // A shallow bowl, a hump in the middle under and above the level, a bottom that ends in a point.
        ("{ path = \"M 0 0 A 4 4 0 0 1 3 1 L 2.9 1 A 4 4 0 0 0 0 0.1\" }", 0.3),
        ("{ path = \"M 0 0 H 1.1 V 2 H 1 V 0.1 L 0 0.8\" }", 1.5),
        ("{ path = \"M 0 0 H 1.1 V 2 H 1 V 0.1 L 0 0.8\" }", 0.5),
        ("{ path = \"M 0 -0.3 L 1.2 2 H 1.1 L 0 0\" }", 1.0),
        ("{ path = \"M 0 0 C 1.5 0 1.5 1 0.6 1.6\", thickness = 0.03, side = \"centered\" }", 1.2),
    ] {
        let scene = parse(&format!(
            "vessel = {profile}\n[[object]]\nprofile = \"vessel\"\nmaterial = \"glass\"\n\
             liquid = {{ material = \"wine\", level = {level} }}\n"
        ));
        let [vessel, liquid] = &scene.objects[..] else { panic!("two objects") };
        fills(vessel, liquid, level);
    }
}

#[test]
fn volumes_are_what_the_hollow_takes() {
    let scene = parse(
        "cup = { path = \"M 0 0 L 1 0 L 1 2 L 0.9 2 L 0.9 0.1 L 0 0.1\" }\n\
         [[object]]\nprofile = \"cup\"\nliquid = { material = \"wine\", volume = 1.5 }\n",
    );
    let top = turned(&scene.objects[1]).surface().bounds().max.z;
    assert!((top - (0.1 + 1.5 / (PI * 0.81))).abs() < 1e-12, "{top}");
}

#[test]
fn liquids_give_way_and_go_where_their_vessel_goes() {
    let scene = parse(
        "cup = { path = \"M 0 0 L 1 0 L 1 2 L 0.9 2 L 0.9 0.1 L 0 0.1\" }\n\
         [[object]]\nname = \"cups\"\nprofile = \"cup\"\nmaterial = \"glass\"\nposition = [3, 1, 2]\nrotation = 20\nat = [[0, 0, 0], [4, 0, 0]]\n\
         liquid = { material = \"wine\", level = 1 }\nsection = { material = \"milk\" }\n\
         [[object]]\nprofile = \"cup\"\nmaterial = \"firm\"\nliquid = { material = \"wine\", level = 1 }\n\
         [[object]]\nprofile = \"cup\"\nmaterial = \"glass\"\nliquid = { material = \"milk\", level = 1 }\nsection = false\n",
    );
    let priority = |object: &Object| match &scene.materials[object.material] {
        Material::Glass(glass) => Some(glass.priority),
        _ => None,
    };
    let [cups, wine, _, beside_firm, _, milk] = &scene.objects[..] else { panic!("six objects") };
    assert_eq!((priority(cups), priority(wine)), (Some(0), Some(-1)));
    assert_eq!((priority(beside_firm), priority(milk)), (Some(0), None));
    assert_eq!(turned(cups).placement(), turned(wine).placement());
    assert_eq!(wine.copies.count(), 2);
    assert_eq!(wine.name, "liquid in cups");
    assert_eq!(wine.section, Cut::Open { material: None });
    assert_eq!(milk.section, Cut::Whole);
}

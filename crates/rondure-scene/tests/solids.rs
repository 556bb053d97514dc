//! Sweeps, caps, unions, intersections, differences and sections, down to what they hold.

#![allow(clippy::expect_used, clippy::panic, reason = "a test that fails may stop")]

use std::{path::Path, sync::Arc};

use rondure::{Vec3, solid::Compound};
use rondure_scene::{Body, Cut, Report, Scene, Shape, parse_scene};

const START: &str = "[camera]\neye = [0, -5, 1]\nlook_at = [0, 0, 0]\n[sky]\n\
    [materials]\nred = { color = \"red\" }\nblue = { color = \"blue\" }\n\
    [profiles]\nrod = { path = \"M 0 0 H 1 V 2 H 0\" }\nsheet = { path = \"M 1 0 V 2\" }\n";

fn parse(text: &str) -> (Scene, Report) {
    let text = format!("{START}{text}");
    parse_scene("<scene>", &text, Path::new("")).map_err(|e| e.to_string()).expect("good")
}

/// What a report says beside that something is never used.
fn told(report: &Report) -> Vec<&str> {
    let all = report.diagnostics().iter().map(|d| d.message.as_str());
    all.filter(|message| !message.contains("never used")).collect()
}

fn body(scene: &Scene, object: usize) -> (&Body, Compound) {
    let Shape::Body(body) = &scene.objects[object].shape else { panic!("no body") };
    (body, body.placed().build().expect("a body that can be built"))
}

fn at(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3::new(x, y, z)
}

#[test]
fn closed_sweeps_are_wedges_in_their_own_frame() {
    let (scene, _) = parse(
        "[[object]]\nprofile = \"rod\"\nsweep = [0, 90]\nposition = [5, 0, 0]\nrotation = 90\n\
         [[object]]\nprofile = \"rod\"\nmaterial = \"red\"\nsweep = { from = -90, to = 180, material = \"blue\" }\n",
    );
    let (own, quarter) = body(&scene, 0);
    assert!(quarter.contains(at(4.5, 0.5, 1.0)));
    assert!(!quarter.contains(at(5.5, 0.5, 1.0)) && !quarter.contains(at(4.5, -0.5, 1.0)));
    assert_eq!(&*own.materials, [None; 3]);
    let (own, wide) = body(&scene, 1);
    assert!(wide.contains(at(0.5, 0.5, 1.0)) && wide.contains(at(0.5, -0.5, 1.0)));
    assert!(!wide.contains(at(-0.5, -0.5, 1.0)));
    let red = scene.objects[1].material;
    assert_eq!(own.materials[0], Some(red));
    assert!(own.materials[1].is_some_and(|blue| blue != red && own.materials[2] == Some(blue)));
}

#[test]
fn open_sweeps_stay_surfaces() {
    let (scene, _) = parse(
        "[[object]]\nprofile = \"sheet\"\nsweep = { from = 0, to = 90, open = true }\n\
         [[object]]\nprofile = \"rod\"\nsweep = { from = 0, to = 90, open = true }\n",
    );
    assert!(scene.objects.iter().all(|o| matches!(o.shape, Shape::Swept { .. })));
}

#[test]
fn caps_close_a_profile_once_for_all_that_use_it() {
    let (scene, report) = parse(
        "[[object]]\nprofile = \"sheet\"\ncaps = true\n[[object]]\nprofile = \"sheet\"\ncaps = true\n\
         [[object]]\nprofile = \"sheet\"\ncaps = false\n[[object]]\nprofile = \"rod\"\ncaps = true\n",
    );
    let surface = |i: usize| match &scene.objects[i].shape {
        Shape::Turned(instance) => Arc::clone(instance.surface()),
        _ => panic!("not turned"),
    };
    assert!(surface(0).profile().bounds_solid() && Arc::ptr_eq(&surface(0), &surface(1)));
    assert!(!surface(2).profile().bounds_solid());
    assert_eq!(told(&report), ["`caps` changes nothing: the profile bounds a solid already"]);
}

#[test]
fn operands_have_their_own_places_copies_and_materials() {
    let (scene, report) = parse(
        "[[object]]\nmaterial = \"red\"\nposition = [10, 0, 0]\nscale = 2\n\
         difference = [\n\
           { union = [{ profile = \"rod\" }, { type = \"sphere\", radius = 1, position = [0, 0, 2], material = \"blue\" }] },\n\
           { type = \"box\", size = [4, 0.5, 0.5], position = [0, 0, 0.5], rotation = 90, repeat = { count = 2, step = [0, 0, 1] } },\n\
         ]\n",
    );
    assert_eq!(told(&report), [""; 0]);
    let (own, solid) = body(&scene, 0);
    let red = scene.objects[0].material;
    assert_eq!(own.materials.len(), 4);
    assert_eq!([own.materials[0], own.materials[2], own.materials[3]], [Some(red); 3]);
    assert!(own.materials[1].is_some_and(|blue| blue != red));
    // Twice as large, about x = 10; the bars lie along y.
    assert!(solid.contains(at(10.0, 0.0, 5.0)) && solid.contains(at(10.0, 0.0, 0.2)));
    for z in [1.0, 3.0] {
        assert!(!solid.contains(at(10.0, 0.0, z)) && !solid.contains(at(10.0, 1.9, z)));
        assert!(solid.contains(at(11.0, 0.0, z)));
    }
}

/// Where nobody names a material, faces get that of what they are cut from: the scene leaves it open.
#[test]
fn what_names_no_material_leaves_it_open() {
    let (scene, _) = parse(
        "[[object]]\ndifference = [{ profile = \"rod\", material = \"blue\" }, { type = \"half-space\", normal = [1, 0, 0] }]\n",
    );
    let (own, solid) = body(&scene, 0);
    assert!(own.materials[0].is_some() && own.materials[1].is_none());
    assert!(solid.contains(at(0.5, 0.0, 1.0)) && !solid.contains(at(-0.5, 0.0, 1.0)));
}

#[test]
fn copies_of_solids_vary_too() {
    let (scene, _) = parse(
        "[[object]]\nunion = [{ profile = \"rod\" }, { type = \"box\", size = [1, 1, 1] }]\nposition = [1, 0, 0]\n\
         repeat = { count = 3, step = [5, 0, 0] }\nvary = { scale = [2, 2] }\n",
    );
    let placed: Vec<_> = scene.objects[0].shapes().map(|s| s.expect("a placement")).collect();
    assert_eq!(placed.len(), 3);
    let Shape::Body(last) = &placed[2] else { panic!("no body") };
    let last = last.placed().build().expect("a body");
    assert!(last.contains(at(11.0, 1.9, 1.0)) && !last.contains(at(11.0, 2.1, 1.0)));
}

#[test]
fn sections_cut_all_that_does_not_say_otherwise() {
    let (scene, _) = parse(
        "[section]\nposition = [0, 1, 0]\nnormal = [0, -2, 0]\nmaterial = \"red\"\n\
         [[object]]\nprofile = \"rod\"\n[[object]]\nprofile = \"rod\"\nsection = false\n\
         [[object]]\nprofile = \"rod\"\nsection = { material = \"blue\" }\n[[object]]\nprofile = \"rod\"\nsection = true\n",
    );
    let [plane] = &*scene.section else { panic!("{:?}", scene.section) };
    assert_eq!((plane.point, plane.normal), (at(0.0, 1.0, 0.0), at(0.0, -1.0, 0.0)));
    let cuts: Vec<_> = scene.objects.iter().map(|o| o.section).collect();
    assert_eq!(cuts[0], Cut::default());
    assert_eq!(cuts[1], Cut::Whole);
    assert!(matches!(cuts[2], Cut::Open { material: Some(blue) } if Some(blue) != plane.material));
    assert_eq!(cuts[3], Cut::default());
    let (two, _) = parse("[[section]]\nnormal = [0, -1, 0]\n[[section]]\nnormal = [1, 0, 0]\n");
    assert_eq!(two.section.len(), 2);
}

#[test]
fn nothing_in_a_solid_and_open_glass_are_warnings() {
    let (_, report) = parse(
        "[[object]]\nintersection = [{ profile = \"rod\" }, { profile = \"rod\", position = [3, 0, 0] }]\n\
         [[object]]\nprofile = \"rod\"\nsweep = { from = 0, to = 9, open = true }\nmaterial = { type = \"glass\" }\n\
         [[object]]\nprofile = \"rod\"\nmaterial = \"red\"\n[[object]]\nprofile = \"sheet\"\nmaterial = \"blue\"\n",
    );
    insta::assert_snapshot!("warnings-of-solids", report);
}

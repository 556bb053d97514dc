//! Good scenes, down to their numbers.

#![allow(clippy::expect_used, clippy::panic, reason = "a test that fails may stop")]

use std::{f64::consts::PI, fs, path::Path, sync::Arc};

use rondure::Vec3;
use rondure_scene::{
    Along, Glass, Light, Material, Paint, Projection, Relief, Report, Scene, Shape, Sky, Wrap,
    parse_scene,
};

const START: &str = "[camera]\neye = [0, -5, 1]\nlook_at = [0, 0, 0]\n[sky]\n";

fn parse(text: &str) -> (Scene, Report) {
    let folder = Path::new("tests/good");
    parse_scene("<scene>", text, folder).map_err(|e| e.to_string()).expect("good")
}

fn examples() -> Vec<String> {
    let text = fs::read_to_string("../../docs/scene.md").expect("docs/scene.md");
    let blocks: Vec<_> = text.split("```toml\n").skip(1).collect();
    let block = |b: &str| b.split("```").next().unwrap_or_default().to_owned();
    blocks.into_iter().map(block).collect()
}

#[test]
fn the_documentation_is_right() {
    let examples = examples();
    assert!(examples.len() >= 4);
    for (i, example) in examples.iter().enumerate() {
        let text = if i == 0 { example.clone() } else { format!("{START}{example}") };
        let (_, warnings) = parse(&text);
        let unused = warnings.diagnostics().iter().filter(|d| !d.message.contains("never used"));
        assert_eq!(unused.count(), 0, "{warnings}");
    }
    assert!(parse(&examples[0]).1.is_empty());
}

#[test]
fn darkness_is_a_warning_however_it_comes() {
    let camera = "[camera]\neye = [0, -5, 1]\nlook_at = [0, 0, 0]\n";
    let black = "[sky]\nintensity = 0\n[[light]]\ntype = \"point\"\nposition = [0, 0, 1]\n\
                 color = \"black\"\n";
    for (text, warnings) in [("", 1), (black, 1), ("[sky]\ncolor = [0, 0, 1e-9]\n", 0)] {
        let (_, report) = parse(&format!("{camera}{text}"));
        assert_eq!(report.warnings(), warnings, "{text}: {report}");
    }
}

#[test]
fn first_example() {
    let (scene, _) = parse(&examples()[0]);
    assert_eq!((scene.film.width, scene.film.height, scene.film.spp), (640, 480, 64));
    assert_eq!((scene.film.depth, scene.film.bits, scene.film.exposure), (8, 8, 1.0));
    assert_eq!(scene.camera.projection, Projection::Perspective { fov: 30_f64.to_radians() });
    assert_eq!((scene.camera.up, scene.camera.lens), (Vec3::Z, None));
    let Sky::Gradient { horizon, ground, .. } = scene.sky else { panic!("no gradient") };
    assert_eq!(ground, horizon);
    assert!((horizon[0] - 0.54).abs() < 1e-15);
    let Light::Sun { direction, irradiance, angular_radius } = scene.lights[0] else {
        panic!("no sun")
    };
    assert!((direction.length() - 1.0).abs() < 1e-15 && irradiance[0] == 2.5);
    assert!((angular_radius - 0.265_f64.to_radians()).abs() < 1e-15);
    let names: Vec<_> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["object 1", "pawns"]);
    let surfaces: Vec<_> = scene.objects[1]
        .shapes()
        .map(|shape| match shape {
            Some(Shape::Turned(instance)) => Arc::clone(instance.surface()),
            _ => panic!("not turned"),
        })
        .collect();
    assert_eq!(surfaces.len(), 3);
    assert!(surfaces.iter().all(|s| Arc::ptr_eq(s, &surfaces[0])), "copies share one surface");
    let floor = &scene.materials[scene.objects[0].material];
    let Material::Matte { color: Paint::Checker { colors, size } } = floor else {
        panic!("no checker: {floor:?}")
    };
    assert_eq!((colors[0], *size), ([1.0; 3], [0.5, 0.5]));
}

fn origins(text: &str) -> Vec<Vec3> {
    let (scene, _) = parse(&format!("{START}{text}"));
    let origin = |shape: &Shape| match shape {
        Shape::Turned(instance) => instance.placement().point(Vec3::ZERO),
        Shape::Sphere { center, .. } => *center,
        _ => panic!("neither turned nor a sphere"),
    };
    let shapes = scene.objects.iter().flat_map(|o| o.shapes());
    shapes.map(|shape| origin(&shape.expect("a placement"))).collect()
}

fn assert_near(found: Vec3, expected: [f64; 3]) {
    let [x, y, z] = expected;
    assert!((found - Vec3::new(x, y, z)).max_abs() < 1e-14, "{found:?} is not {expected:?}");
}

#[test]
fn colonnade() {
    let examples = examples();
    let colonnade = examples.iter().find(|text| text.contains("column")).expect("one");
    let (scene, _) = parse(&format!("{START}{colonnade}"));
    let columns: Vec<_> = scene.objects[0].shapes().collect();
    assert_eq!(columns.len(), 200);
    let Some(Shape::Turned(last)) = &columns[199] else { panic!("not turned") };
    assert_eq!(last.placement().point(Vec3::ZERO), Vec3::new(2.0, 198.0, 0.0));
}

#[test]
fn ten_million_vases() {
    let examples = examples();
    let field = examples.iter().find(|text| text.contains("count = 3162")).expect("one");
    let (scene, _) = parse(&format!("{START}{field}"));
    let vases = &scene.objects[0];
    assert_eq!(vases.copies.count(), 10_001_406);
    let last = vases.copies.motion(10_001_405, vases.shape.position());
    let place = last.map.point(vases.shape.position());
    assert!((place - Vec3::new(1580.0, 1581.0, 0.0)).max_abs() <= 0.2);
    assert!((0.5..=1.0).contains(&last.scale));
}

#[test]
fn copies() {
    let sphere = "[[object]]\ntype = \"sphere\"\nradius = 1\nposition = [1, 0, 0]\n";
    assert_eq!(
        origins(&format!("{sphere}at = [[0, 0, 1], [0, 2, 0]]")),
        [Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 2.0, 0.0)]
    );
    let ring = origins(&format!("{sphere}repeat = {{ count = 4, about = [0, 0, 0] }}"));
    for (found, expected) in
        ring.into_iter().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    {
        assert_near(found, expected);
    }
    let arc = origins(&format!(
        "{sphere}repeat = {{ count = 3, turn = 90, about = [1, 0, 1], axis = [0, 1, 0] }}"
    ));
    for (found, expected) in
        arc.into_iter().zip([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 2.0]])
    {
        assert_near(found, expected);
    }
    let both = origins(&format!(
        "{sphere}at = [[0, 0, 0], [5, 0, 0]]\nrepeat = {{ count = 3, step = [0, 1, 0] }}"
    ));
    assert_eq!(both.len(), 6);
}

#[test]
fn scattered_and_varied_copies() {
    let sphere = "[[object]]\ntype = \"sphere\"\nradius = 1\nposition = [1, 0, 0]\n";
    let scattered = "repeat = { count = 100, scatter = [4, 4, 0] }\n";
    let places = origins(&format!("{sphere}{scattered}"));
    assert_eq!(places.len(), 100);
    assert!(places.iter().all(|p| (p.x - 1.0).abs() <= 2.0 && p.y.abs() <= 2.0 && p.z == 0.0));
    // Another object is scattered otherwise, unless both have one seed.
    let both = origins(&format!("{sphere}{scattered}{sphere}{scattered}"));
    assert!(both[..100] == places && both[100..] != places);
    let seeded = "repeat = { count = 100, scatter = 3, seed = 5 }\n";
    let both = origins(&format!("{sphere}{seeded}{sphere}{seeded}"));
    assert_eq!(both[..100], both[100..]);
    // A clump in a row is always the same, a row in a clump is not.
    let row = "{ count = 2, step = [9, 0, 0] }";
    let clump = "{ count = 3, scatter = 1 }";
    let clumps = origins(&format!("{sphere}repeat = [{clump}, {row}]"));
    assert_near(clumps[1] - clumps[0], [9.0, 0.0, 0.0]);
    let others = origins(&format!("{sphere}repeat = [{row}, {clump}]"));
    assert!((others[3] - others[0] - Vec3::X * 9.0).max_abs() > 1e-3);

    let text = format!("{START}{sphere}vary = {{ scale = [2, 3], move = [0, 0.5, 0] }}");
    let (scene, _) = parse(&text);
    let Some(Some(Shape::Sphere { center, radius })) = scene.objects[0].shapes().next() else {
        panic!("no sphere")
    };
    assert!((2.0..=3.0).contains(&radius) && center.x == 1.0 && center.y.abs() <= 0.5);
}

fn image(object: &str, point: [f64; 3]) -> Vec3 {
    let cone = "[[object]]\nprofile = { path = \"M 0 0 L 1 0 L 0 2\" }\n";
    let (scene, _) = parse(&format!("{START}{cone}{object}"));
    let Shape::Turned(instance) = &scene.objects[0].shape else { panic!("not turned") };
    instance.placement().point(Vec3::new(point[0], point[1], point[2]))
}

#[test]
fn placement_goes_scale_rotation_axis_position() {
    assert_near(image("scale = 2\nposition = [1, 0, 0]", [1.0, 0.0, 1.0]), [3.0, 0.0, 2.0]);
    assert_near(image("scale = [2, 1, -1]\nrotation = 90", [1.0, 0.0, 1.0]), [0.0, 2.0, -1.0]);
    // x, then y, then z: z -> (about x) -y -> (about y) -y -> (about z) x.
    assert_near(image("rotation = [90, 90, 90]", [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
    assert_near(image("axis = [3, 0, 0]\nrotation = 90", [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
    assert_near(image("axis = [0, 0, -2]\nposition = [0, 0, 5]", [0.0, 0.0, 1.0]), [0.0, 0.0, 4.0]);
}

#[test]
fn every_kind_of_object_and_light() {
    let text = r#"
[[light]]
type = "point"
position = [0, 0, 3]
[[light]]
type = "disk"
position = [0, 0, 3]
radius = 1
look_at = [0, 0, 1]
intensity = 4
color = [0.5, 1, 0]
[[light]]
type = "sphere"
position = [0, 0, 3]
radius = 1

[[object]]
type = "rectangle"
normal = [1, 0, 0]
size = [2, 3]
rotation = 90
material = { type = "mirror" }
[[object]]
type = "disk"
radius = 2
normal = [0, 3, 0]
material = { type = "glass", ior = 1.3, color = "white" }
[[object]]
type = "plane"
"#;
    let (scene, report) = parse(&format!("{START}{text}"));
    assert!(report.is_empty(), "{report}");
    let Light::Disk { normal, radiance, .. } = scene.lights[1] else { panic!("no disk") };
    assert_eq!((normal, radiance), (-Vec3::Z, [2.0, 4.0, 0.0]));
    let Shape::Rectangle { edges, .. } = scene.objects[0].shape else { panic!("no rectangle") };
    // z goes to x, so x goes to -z; before that, a quarter turn takes x to y and y to -x.
    assert_near(edges[0], [0.0, 2.0, 0.0]);
    assert_near(edges[1], [0.0, 0.0, 3.0]);
    assert_eq!(
        scene.materials[scene.objects[1].material],
        Material::Glass(Glass::clear([1.0; 3], 1.3))
    );
    let default = &scene.materials[scene.objects[2].material];
    assert_eq!(*default, Material::Matte { color: Paint::Solid([0.8; 3]) });
}

#[test]
fn lens_and_orthographic_view() {
    let start = "[sky]\n[camera]\neye = [0, -5, 0]\nlook_at = [0, 0, 0]\n";
    let (scene, _) = parse(&format!("{start}lens_radius = 0.1"));
    let lens = scene.camera.lens.expect("a lens");
    assert_eq!((lens.radius, lens.focus), (0.1, 5.0));
    let (scene, _) = parse(&format!("{start}projection = \"orthographic\"\nheight = 3"));
    assert_eq!(scene.camera.projection, Projection::Orthographic { height: 3.0 });
}

#[test]
fn warnings_come_with_the_scene() {
    let text = "[camera]\neye = [0, -5, 1]\nlook_at = [0, 0, 0]\nfocus = 3\n[materials.a]\n\
                [profiles.b]\npath = \"M 0 0 L 1 1\"\n\
                [[object]]\nprofile = { path = \"M 1 0 L 2 1\" }\nmaterial = { type = \"glass\" }";
    insta::assert_snapshot!("warnings", parse(text).1);
}

/// Cuts and overwrites good scenes everywhere: whatever comes of it, nothing panics, and what is
/// refused has something to say.
#[test]
fn damaged_scenes() {
    for example in examples() {
        let text = format!("{START}{example}");
        for i in (0..text.len()).step_by(3).filter(|i| text.is_char_boundary(*i)) {
            let rest = text[i..].chars().next().map_or(i, |c| i + c.len_utf8());
            for put in ["", "\"", "[", "=", "\u{e9}", "\0", "9e999"] {
                let damaged = format!("{}{put}{}", &text[..i], &text[rest..]);
                if let Err(report) = parse_scene("<scene>", &damaged, Path::new("tests/good")) {
                    assert!(report.errors() > 0);
                    if i % 7 == 0 {
                        assert!(
                            report.plain().starts_with("error")
                                || report.plain().starts_with("warning")
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn paints_and_reliefs() {
    let (scene, _) = parse(&format!(
        "{START}{}",
        r#"
[materials]
log = { wood = { axis = [0, 0, 2], ring = 0.5, seed = 9 } }
inner = { type = "glossy", color = { checker = { colors = ["white", "black"], space = true } } }
deep = { type = "principled", base_color = { marble = { turbulence = 0 } }, normal_map = "label.png" }
jar = { label = [
    { file = "label.png", z = [1, 2], around = [-90, 90], over = { image = { file = "label.png", wrap = "once" } } },
    { file = "label.png", length = [0, 3] },
], bump = { noise = 0.5, height = -0.1 } }
"#
    ));
    let material = |i: usize| &scene.materials[i];
    let Material::Matte { color: Paint::Wood(wood) } = material(0) else { panic!("no wood") };
    assert_eq!((wood.axis, wood.ring, wood.seed), (Vec3::Z, 0.5, Some(9)));
    let Material::Glossy { color: Paint::Blocks { size, .. }, .. } = material(1) else {
        panic!("no blocks")
    };
    assert_eq!(*size, Vec3::splat(1.0));
    let Material::Principled(deep) = material(2) else { panic!("not principled") };
    assert!(matches!(&deep.base_color, Paint::Marble(m) if m.turbulence == 0.0));
    // The last label lies on the first, and that on a picture; the file is read once.
    let Material::Matte { color: Paint::Label(top) } = material(3) else { panic!("no label") };
    assert_eq!((top.along, top.range, top.around), (Along::Length, [0.0, 3.0], [-PI, PI]));
    let Paint::Label(below) = &top.over else { panic!("no second label") };
    assert_eq!((below.along, below.around), (Along::Z, [-0.5 * PI, 0.5 * PI]));
    let Paint::Picture(picture) = &below.over else { panic!("no picture") };
    assert_eq!(picture.sheet.wrap, Wrap::Once);
    assert!(Arc::ptr_eq(&picture.sheet.image, &top.image));
    // Colours are decoded, normals are not.
    let Some(Some(Relief::Normals { sheet, .. })) = scene.reliefs.get(2) else { panic!("no map") };
    assert!(sheet.image.pixel(1, 1)[0] > top.image.pixel(1, 1)[0] + 0.1);
    assert!(matches!(scene.reliefs[3], Some(Relief::Noise { height, .. }) if height == -0.1));
    assert_eq!(scene.reliefs[0], None);
}

//! Patterns on things of a scene, as rays see them.

use std::path::Path;

use rondure::{Ray, Vec3};
use rondure_scene::parse_scene;

use crate::{features::guide, world::World};

fn world(objects: &str) -> World {
    let text = format!(
        "[camera]\neye = [0, -9, 0]\nlook_at = [0, 0, 0]\n[sky]\n\
         [profiles]\n\
         pot = {{ path = \"M 0 0 L 1 0 L 1 2 L 0.8 2 L 0.8 0.2 L 0 0.2\" }}\n\
         post = {{ path = \"M 0 0 L 1 0 L 1 2 L 0 2\" }}\n\
         {objects}"
    );
    let folder = Path::new("../rondure-scene/tests/pictures");
    let (scene, _) = parse_scene("<test>", &text, folder).map_err(|e| e.to_string()).unwrap();
    World::new(&scene).unwrap()
}

/// The colour that a ray from a point towards another sees.
fn seen(world: &World, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    guide(world, &ray(from, to), world.closest(&ray(from, to)).as_ref()).albedo
}

fn ray(from: [f64; 3], to: [f64; 3]) -> Ray {
    let [from, to] = [from, to].map(|[x, y, z]| Vec3::new(x, y, z));
    Ray::new(from, (to - from).normalized())
}

const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];
const BELOW: [f64; 3] = [0.25, 0.5, 0.75];

/// Red and green above, blue and grey below, on the side to the viewer.
const LABEL: &str = "material = { label = { file = \"square.png\", z = [0.5, 1.5], around = [-135, -45], \
                     over = { color = [0.25, 0.5, 0.75] } } }\n";

#[test]
fn labels_are_on_their_part_of_the_outer_wall_alone() {
    let pot = world(&format!("[[object]]\nprofile = \"pot\"\n{LABEL}"));
    // Well within the pixels, in the middle of the left and of the right half.
    let (left, right) = ([-0.55, -0.84], [0.55, -0.84]);
    let wall = |[x, y]: [f64; 2], z| seen(&pot, [9.0 * x, 9.0 * y, z], [0.0, 0.0, z]);
    assert_eq!(wall(left, 1.4), RED);
    assert_eq!(wall(right, 1.4), GREEN);
    assert_eq!(wall(left, 0.6), BLUE);
    // Above, below, beside it and on the back.
    for (side, z) in [(left, 1.7), (left, 0.3), ([1.0, 0.1], 1.0), ([0.1, 1.0], 1.0)] {
        assert_eq!(wall(side, z), BELOW, "{side:?} {z}");
    }
    // On the inner wall, from above; on the rim.
    assert_eq!(seen(&pot, [0.0, 3.0, 3.4], [0.0, -0.8, 1.0]), BELOW);
    assert_eq!(seen(&pot, [0.0, -0.9, 5.0], [0.0, -0.9, 0.0]), BELOW);
}

#[test]
fn labels_go_with_the_thing() {
    let placed = "rotation = 180\nscale = 2\nposition = [20, 0, 0]\n";
    for kind in [
        "profile = \"pot\"\n",
        "difference = [{ profile = \"post\" }, { profile = \"post\", position = [0, 0, 1.9], scale = 0.7 }]\n",
    ] {
        let pot = world(&format!("[[object]]\n{kind}{placed}{LABEL}"));
        assert_eq!(seen(&pot, [20.0 + 10.0, 16.8, 2.8], [20.0, 0.0, 2.8]), RED, "{kind}");
        assert_eq!(seen(&pot, [20.0 - 10.0, -16.8, 2.8], [20.0, 0.0, 2.8]), BELOW, "{kind}");
    }
    // Of an open wall the back shows nothing.
    let label = LABEL.replace("z = ", "v = ").replace("[0.5, 1.5]", "[0, 1]");
    let wall = world(&format!("[[object]]\nprofile = {{ path = \"M 1 0 L 1 2\" }}\n{label}"));
    assert_eq!(seen(&wall, [-5.5, -8.4, 1.9], [0.0, 0.0, 1.9]), RED);
    assert_eq!(seen(&wall, [0.0, 0.0, 1.9], [-0.55, -0.84, 1.9]), BELOW);
}

const OAK: &str = "material = { wood = { axis = [1, 0, 0.2], pith = [0, 0.3, -1] } }\n";

#[test]
fn the_grain_sits_still_in_what_is_placed() {
    let first = world(&format!("[[object]]\nprofile = \"post\"\n{OAK}"));
    let moved = "scale = 3\nrotation = 90\nposition = [10, 20, 30]\n";
    let placed = world(&format!("[[object]]\nprofile = \"post\"\n{moved}{OAK}"));
    let cut = "[section]\nposition = [0, 0.5, 0]\nnormal = [0, 1, 0]\n";
    let cut = world(&format!("{cut}[[object]]\nprofile = \"post\"\n{OAK}"));
    let compound = "union = [{ profile = \"post\" }, { type = \"sphere\", radius = 0.1 }]\n";
    let compound = world(&format!("[[object]]\n{compound}{moved}{OAK}"));
    let mut different = 0;
    let mut last = [0.0; 3];
    for i in 0..40 {
        let z = 0.05 + 0.047 * f64::from(i);
        let own = ([0.3, -5.0, z], [0.1, 0.0, z]);
        // A quarter counterclockwise, three times as large, moved.
        let there = |[x, y, z]: [f64; 3]| [10.0 - 3.0 * y, 20.0 + 3.0 * x, 30.0 + 3.0 * z];
        let color = seen(&first, own.0, own.1);
        for (name, other) in [
            ("placed", seen(&placed, there(own.0), there(own.1))),
            ("cut", seen(&cut, own.0, own.1)),
            ("compound", seen(&compound, there(own.0), there(own.1))),
        ] {
            let apart = (0..3).map(|c| (color[c] - other[c]).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-6, "{name} {i}: {color:?} {other:?}");
        }
        different += u32::from((color[0] - last[0]).abs() > 1e-3);
        last = color;
    }
    assert!(different > 20, "there is a grain");
}

#[test]
fn copies_are_cut_from_one_place_or_from_several() {
    let repeat = "repeat = { count = 6, step = [5, 0, 0] }\n";
    let colors = |material: &str, before: &str| {
        let text = format!("{before}[[object]]\nprofile = \"post\"\n{repeat}{material}");
        let posts = world(&text);
        let at = |i: u32| {
            let x = 5.0 * f64::from(i);
            seen(&posts, [x + 0.2, -5.0, 0.7], [x, 0.0, 0.7])
        };
        (0..6).map(at).collect::<Vec<_>>()
    };
    let near = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 1e-9);
    let same = colors(OAK, "");
    assert!(same.windows(2).all(|pair| near(&pair[0], &pair[1])), "{same:?}");
    let seeded = OAK.replace("pith", "seed = 4, pith");
    let varied = colors(&seeded, "");
    assert!(varied.windows(2).all(|pair| !near(&pair[0], &pair[1])), "{varied:?}");
    // Other objects before it change nothing.
    let before = "[[object]]\nprofile = \"pot\"\nposition = [0, 50, 0]\n";
    assert_eq!(colors(&seeded, before), varied);
}

#[test]
fn reliefs_turn_normals_to_the_viewer() {
    let bumps = "material = { bump = { noise = 0.3, height = 0.05 } }\n";
    let ball = world(&format!("[[object]]\ntype = \"sphere\"\nradius = 1\n{bumps}"));
    let smooth = world("[[object]]\ntype = \"sphere\"\nradius = 1\n");
    let (mut turned, mut sum) = (0, Vec3::ZERO);
    for i in 0..400 {
        let (x, z) = (-0.9 + 0.09 * f64::from(i % 20), -0.9 + 0.09 * f64::from(i / 20));
        let ray = ray([x, -5.0, z], [x, 0.0, z]);
        if x.hypot(z) > 0.9 {
            continue;
        }
        let [found, plain] = [&ball, &smooth].map(|world| {
            let [x, y, z] = guide(world, &ray, world.closest(&ray).as_ref()).normal;
            Vec3::new(x, y, z)
        });
        assert!((found.length() - 1.0).abs() < 1e-12 && found.dot(ray.direction) <= 0.0);
        turned += u32::from((found - plain).max_abs() > 0.02);
        sum += found - plain;
    }
    assert!(turned > 200, "{turned}");
    // Up and down in equal measure.
    assert!(sum.length() / f64::from(turned) < 0.1, "{sum:?}");
}

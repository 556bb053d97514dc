//! `rondure render` and `rondure check`, end to end.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use common::Desk;

/// A drum, half of it lit, on a plane.
const SCENE: &str = r#"
[film]
size = [48, 32]
spp = 2

[camera]
eye = [6, 0, 3]
look_at = [0, 0, 1]

[materials.clay]
type = "matte"
color = "firebrick"

[profiles.drum]
path = "M 0 0 L 1 0 L 1 2 L 0 2 Z"

[[light]]
type = "point"
position = [3, 3, 5]
intensity = 40

[[object]]
profile = "drum"
material = "clay"

[[object]]
profile = "drum"
material = "clay"
position = [0, 3, 0]

[[object]]
type = "plane"
material = "clay"
"#;

/// Width, height, bits and the 8 or 16 bit values of a PNG file.
fn png(bytes: &[u8]) -> (u32, u32, u8, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    let info = reader.info();
    (info.width, info.height, info.bit_depth as u8, data)
}

fn names(desk: &Desk) -> Vec<String> {
    let entries = std::fs::read_dir(desk.path(".")).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_picture_appears_beside_us_under_the_scenes_name() {
    let desk = Desk::new();
    desk.file("scenes/drum.toml", SCENE);
    let outcome = desk.run("render scenes/drum.toml --quiet");
    assert_eq!((outcome.code, &*outcome.stdout, &*outcome.stderr), (0, "", ""));
    assert_eq!(names(&desk), ["drum.png", "scenes"]);
    let file = std::fs::read(desk.path("drum.png")).unwrap();
    // The file names its scene, but not the folder that it lay in.
    let holds = |text: &[u8]| file.windows(text.len()).any(|bytes| bytes == text);
    assert!(holds(b"rondure:scene\0drum.toml") && !holds(b"scenes/"));
    let (width, height, bits, data) = png(&file);
    assert_eq!((width, height, bits), (48, 32, 8));
    // The drum in the middle is red, and lit from one side.
    let pixel = |x: usize, y: usize| &data[3 * (y * 48 + x)..][..3];
    let middle = pixel(24, 16);
    assert!(middle[0] > 60 && middle[0] > 2 * middle[1], "{middle:?}");
}

#[test]
fn options_take_the_place_of_what_the_scene_says() {
    let desk = Desk::new();
    desk.file("drum.toml", SCENE.replace("spp = 2", "spp = 2\nbits = 16"));
    let render = |name: &str, options: &str| {
        let outcome = desk.run(&format!("render drum.toml -o {name}.png -q {options}"));
        assert_eq!((outcome.code, &*outcome.stderr), (0, ""));
        std::fs::read(desk.path(&format!("{name}.png"))).unwrap()
    };
    let usual = render("usual", "");
    assert_eq!((png(&usual).0, png(&usual).1, png(&usual).2), (48, 32, 16));
    assert!(render("one", "--threads 1") == usual);
    assert!(render("three", "--threads 3 --seed 0") == usual);
    assert!(render("seed", "--seed 1") != usual);
    assert!(render("spp", "--spp 3") != usual);
    assert_eq!(png(&render("size", "--size 20x31")).1, 31);
}

#[test]
fn what_was_done_is_told_at_the_end() {
    let desk = Desk::new();
    desk.file("drum.toml", SCENE);
    let outcome = desk.run("render drum.toml");
    assert_eq!((outcome.code, &*outcome.stdout), (0, ""));
    insta::with_settings!({filters => vec![
        (r"\d+(\.\d)? (ms|s|min)\b", "[time]"),
        (r"\d+\.\d ([kM] )?(samples|rays)/s", "[rate] $2/s"),
    ]}, {
        insta::assert_snapshot!(outcome.stderr);
    });
}

#[test]
fn nothing_is_computed_if_the_picture_has_no_place() {
    let desk = Desk::new();
    // The work would take minutes.
    desk.file("drum.toml", SCENE.replace("spp = 2", "spp = 1000000")).file("folder.png/x", "");
    for (output, word) in [
        ("none/out.png", "no such file or directory"),
        ("folder.png", "is a directory"),
        ("drum.toml/out.png", "not a directory"),
        ("out.jpg", "PNG or OpenEXR"),
        ("out", "PNG or OpenEXR"),
    ] {
        let outcome = desk.run(&format!("render drum.toml -o {output}"));
        assert_eq!(outcome.code, 1, "{output}");
        assert!(outcome.stderr.contains(word), "{output}: {}", outcome.stderr);
    }
    assert_eq!(names(&desk), ["drum.toml", "folder.png"]);
}

#[test]
fn check_tells_what_is_in_good_scenes() {
    let desk = Desk::new();
    desk.file("drum.toml", SCENE);
    let outcome = desk.run("check drum.toml");
    assert_eq!((outcome.code, &*outcome.stderr), (0, ""));
    insta::assert_snapshot!(outcome.stdout);
}

#[test]
fn check_goes_on_after_a_bad_scene() {
    let desk = Desk::new();
    desk.file("good.toml", SCENE).file("bad.toml", SCENE.replace("clay\"", "mud\""));
    let outcome = desk.run("check bad.toml none.toml good.toml");
    assert_eq!(outcome.code, 1);
    assert!(outcome.stdout.starts_with("good.toml: good\n"), "{}", outcome.stdout);
    insta::assert_snapshot!(outcome.stderr);
}

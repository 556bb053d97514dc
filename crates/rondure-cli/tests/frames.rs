//! `rondure turntable` and `rondure animate`: frames, what is kept of them, and what is made of them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::{fmt::Write, fs, path::Path};

use common::{Desk, Outcome};

const SCENE: &str = r#"
[film]
size = [24, 16]
spp = 2

[camera]
eye = [0, -5, 2]
look_at = [0, 0, 0.5]
fov = 30

[sky]
zenith = "steelblue"
horizon = "white"

[[object]]
profile = { path = "M 0 0 L 1 0 L 0 1.5 Z" }
material = { color = "tomato" }

[[object]]
type = "sphere"
position = [1.2, 0, 0.5]
radius = 0.4
material = { color = "gold" }
"#;

const KEYS: &str = r#"
[[camera.key]]
time = 1

[[camera.key]]
time = 1.5
eye = [4, -3, 2]
fov = 40
"#;

fn scene_with_keys() -> String {
    SCENE.replace("\n[sky]", &format!("{KEYS}\n[sky]"))
}

/// Runs the command where there is no ffmpeg.
fn run(desk: &Desk, arguments: &str) -> Outcome {
    let child = desk.command(arguments).env("PATH", "").spawn().unwrap();
    let output = child.wait_with_output().unwrap();
    Outcome {
        code: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

fn names(folder: &Path) -> Vec<String> {
    let name = |entry: fs::DirEntry| entry.file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| name(e.unwrap())).collect();
    names.sort();
    names
}

#[test]
fn a_turntable_makes_frames_a_sheet_and_an_animation() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    let outcome = run(&desk, "turntable scene.toml --frames 4 --fps 10");
    assert_eq!(outcome.code, 0, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("no MP4 was made: the program ffmpeg is not installed"));
    let folder = desk.path("scene-turntable");
    let frames = ["frame-0001.png", "frame-0002.png", "frame-0003.png", "frame-0004.png"];
    let all = [&["animation.png", "contact-sheet.png"][..], &frames].concat();
    assert_eq!(names(&folder), all);
    // The first frame is the picture that `render` makes.
    assert_eq!(desk.run("render scene.toml").code, 0);
    assert_eq!(desk.run("compare scene.png scene-turntable/frame-0001.png --exact").code, 0);
    assert_eq!(desk.run("compare scene.png scene-turntable/frame-0003.png --exact").code, 3);
    let file = std::io::BufReader::new(fs::File::open(folder.join("animation.png")).unwrap());
    let info = png::Decoder::new(file).read_info().unwrap();
    let control = info.info().animation_control.unwrap();
    assert_eq!((control.num_frames, info.info().width), (4, 24));
}

#[test]
fn frames_are_kept_and_others_made_again() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    let whole = "turntable scene.toml --frames 3 -o all";
    assert_eq!(run(&desk, whole).code, 0);
    let path = |i| desk.path(&format!("all/frame-000{i}.png"));
    let before: Vec<_> = (1..=3).map(|i| fs::read(path(i)).unwrap()).collect();
    let times = || (1..=3).map(|i| fs::metadata(path(i)).unwrap().modified().unwrap());
    let written: Vec<_> = times().collect();
    // One is cut short, one is missing.
    fs::write(path(1), &before[0][..before[0].len() / 2]).unwrap();
    fs::remove_file(path(3)).unwrap();
    let outcome = run(&desk, whole);
    assert!(outcome.stderr.contains("1 of 3 frames are there already"), "{}", outcome.stderr);
    assert!((1..=3).all(|i| fs::read(path(i)).unwrap() == before[i - 1]));
    assert_eq!(times().nth(1), Some(written[1]));
    // All are there, on any number of threads.
    let outcome = run(&desk, &format!("{whole} --threads 1"));
    assert!(outcome.stderr.contains("3 of 3 frames are there already"), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("3 frames, 0 made"), "{}", outcome.stderr);
    // Of other settings, or of another scene, none is.
    for other in ["--spp 3", "--seed 7", "--exposure 1", "--view agx", "--frames 2", "--degrees 90"]
    {
        let outcome = run(
            &desk,
            &format!("{whole} {other}")
                .replace("--frames 3 -o all --frames 2", "--frames 2 -o all"),
        );
        assert_eq!(outcome.code, 0, "{other}: {}", outcome.stderr);
        // The first camera is the same for any way.
        let kept =
            if other.starts_with("--frames") || other.starts_with("--degrees") { 1 } else { 0 };
        let said = format!("{kept} of ");
        assert_eq!(
            outcome.stderr.contains("are there already"),
            kept > 0,
            "{other}: {}",
            outcome.stderr
        );
        assert!(kept == 0 || outcome.stderr.contains(&said), "{other}: {}", outcome.stderr);
        assert_eq!(run(&desk, whole).code, 0);
    }
    desk.file("scene.toml", SCENE.replace("tomato", "teal"));
    assert!(!run(&desk, whole).stderr.contains("there already"));
}

#[test]
fn an_animation_follows_the_keys() {
    let desk = Desk::new();
    desk.file("scene.toml", scene_with_keys());
    let outcome = run(&desk, "animate scene.toml --fps 8");
    assert_eq!(outcome.code, 0, "{}", outcome.stderr);
    let frames = names(&desk.path("scene-animation"));
    assert_eq!(frames.iter().filter(|name| name.starts_with("frame-")).count(), 5);
    // The last frame is a picture of the scene with the last key's camera.
    desk.file(
        "last.toml",
        SCENE.replace("[0, -5, 2]", "[4, -3, 2]").replace("fov = 30", "fov = 40"),
    );
    assert_eq!(desk.run("render last.toml").code, 0);
    assert_eq!(desk.run("compare last.png scene-animation/frame-0005.png --exact").code, 0);
}

#[test]
fn bad_input() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE).file("taken", "");
    // Half way, the camera passes through what it looks at.
    let through = "[[camera.key]]\ntime = 0\n[[camera.key]]\ntime = 2\neye = [0, 5, -1]\n";
    desk.file("through.toml", SCENE.replace("\n[sky]", &format!("{through}\n[sky]")));
    let late = "[[camera.key]]\ntime = 0\n[[camera.key]]\ntime = 1e9\n";
    desk.file("long.toml", SCENE.replace("\n[sky]", &format!("{late}\n[sky]")));
    let mut gallery = String::new();
    for (arguments, code) in [
        ("animate scene.toml", 1),
        ("animate through.toml", 1),
        ("animate long.toml", 1),
        ("turntable none.toml", 1),
        ("turntable scene.toml -o taken", 1),
        ("turntable scene.toml --frames 0", 2),
        ("turntable scene.toml --fps 0", 2),
        ("turntable scene.toml --degrees inf", 2),
        ("turntable", 2),
    ] {
        let outcome = run(&desk, arguments);
        assert_eq!(outcome.code, code, "{arguments}: {}", outcome.stderr);
        writeln!(gallery, "$ rondure {arguments}\n{}\n", outcome.stderr.trim_end()).unwrap();
    }
    insta::assert_snapshot!(gallery);
}

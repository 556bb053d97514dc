//! `rondure denoise`: from a picture with layers to a clean one.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::fmt::Write;

use common::Desk;

const SCENE: &str = r#"
[film]
size = [48, 32]
spp = 4
view = "neutral"

[camera]
eye = [0, -5, 2]
look_at = [0, 0, 0.5]
fov = 30

[sky]
zenith = "steelblue"
horizon = "white"
intensity = 0.3

[[light]]
type = "disk"
position = [4, -4, 6]
look_at = [0, 0, 0]
radius = 2
intensity = 4

[[object]]
profile = { path = "M 0 0 L 1 0 L 0 1.5 Z" }
material = { color = "tomato" }

[[object]]
type = "plane"
material = { color = "wheat" }
"#;

fn relative_error(desk: &Desk, picture: &str) -> f64 {
    let outcome = desk.run(&format!("compare {picture} reference.exr --json"));
    assert_eq!(outcome.code, 0, "{}", outcome.stderr);
    let line = outcome.stdout.lines().find(|line| line.contains("\"relmse\"")).unwrap();
    line.trim().trim_end_matches(',').split_once(": ").unwrap().1.parse().unwrap()
}

#[test]
fn there_is_less_noise_and_the_layers_stay() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    let run = |arguments: &str| {
        let outcome = desk.run(arguments);
        assert_eq!(outcome.code, 0, "{arguments}: {}", outcome.stderr);
    };
    run("render scene.toml -o noisy.exr");
    run("render scene.toml -o reference.exr --spp 256 --seed 5");
    run("denoise noisy.exr");
    let (before, after) =
        (relative_error(&desk, "noisy.exr"), relative_error(&desk, "noisy-denoised.exr"));
    assert!(after < 0.5 * before, "{before} {after}");
    // Again, on one thread, into another file: the same bits.
    run("denoise noisy.exr --threads 1 -o again.exr");
    run("compare again.exr noisy-denoised.exr --exact");
    // The PNG has the scene's view, and says where it is from.
    run("denoise noisy.exr -o clean.png");
    run("denoise noisy.exr -o neutral.png --view neutral --bits 16");
    run("denoise noisy.exr -o srgb.png --view srgb");
    run("compare clean.png neutral.png --max-relmse 1e-3");
    assert_eq!(desk.run("compare clean.png srgb.png --max-relmse 1e-3").code, 3);
    let file = std::io::BufReader::new(std::fs::File::open(desk.path("clean.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    reader.finish().unwrap();
    let texts = &reader.info().uncompressed_latin1_text;
    let has = |key: &str| texts.iter().any(|text| text.keyword == key);
    assert!(has("rondure:denoised") && has("rondure:scene") && has("rondure:view"));
    // What was denoised has its layers still, and can be denoised again.
    run("denoise noisy-denoised.exr -o twice.exr");
}

#[test]
fn bad_input() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    assert_eq!(desk.run("render scene.toml -o good.exr --size 8x8").code, 0);
    assert_eq!(desk.run("render scene.toml -o one.exr --size 8x8 --spp 1").code, 0);
    let good = std::fs::read(desk.path("good.exr")).unwrap();
    desk.file("cut.exr", &good[..good.len() / 2]).file("text.exr", "no picture");
    desk.file("folder.exr/file", "");
    let mut gallery = String::new();
    for (arguments, code) in [
        ("denoise none.exr", 1),
        ("denoise cut.exr", 1),
        ("denoise text.exr", 1),
        ("denoise folder.exr", 1),
        ("denoise one.exr", 1),
        ("denoise good.exr -o part.rdf", 1),
        ("denoise good.exr -o clean.jpg", 1),
        ("denoise good.exr -o no/clean.png", 1),
        ("denoise good.exr -o clean.png --white-balance 1500 --tint 100", 1),
        ("denoise good.exr -o clean.png --bits 12", 2),
        ("denoise good.exr --white-balance 10", 2),
        ("denoise", 2),
        ("compare good.exr cut.exr", 1),
    ] {
        let outcome = desk.run(arguments);
        assert_eq!(outcome.code, code, "{arguments}: {}", outcome.stderr);
        writeln!(gallery, "$ rondure {arguments}\n{}\n", outcome.stderr.trim_end()).unwrap();
    }
    insta::assert_snapshot!(gallery);
}

#[test]
fn a_limit_of_noise_saves_samples() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    let outcome = desk.run("render scene.toml -o a.exr --spp 64 --noise 0.05");
    assert_eq!(outcome.code, 0, "{}", outcome.stderr);
    let (mean, _) = outcome.stderr.split_once(" of 64 spp").unwrap();
    let mean: f64 = mean.rsplit(' ').next().unwrap().parse().unwrap();
    assert!((16.0..60.0).contains(&mean), "{mean}");
    assert_eq!(desk.run("render scene.toml -o b.exr --spp 64 --noise 0.05 --threads 1").code, 0);
    assert_eq!(desk.run("compare a.exr b.exr --exact").code, 0);
    for (arguments, code) in [("--noise 0", 2), ("--noise 0.1 --sample-range 0..2 -o a.rdf", 1)] {
        let outcome = desk.run(&format!("render scene.toml {arguments}"));
        assert_eq!(outcome.code, code, "{}", outcome.stderr);
    }
}

/// A program in the place of Intel's.
#[cfg(unix)]
fn stand_in(desk: &Desk, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    desk.file("bin/oidnDenoise", format!("#!/bin/sh\n[ \"$1\" = --help ] && exit 0\n{script}\n"));
    let path = desk.path("bin/oidnDenoise");
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[cfg(unix)]
#[test]
fn open_image_denoise_gets_the_layers_and_gives_the_light() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    assert_eq!(desk.run("render scene.toml -q -o noisy.exr").code, 0);
    let denoise = |options: &str| {
        let mut command = desk.command(&format!("denoise noisy.exr --method oidn {options}"));
        command.env("PATH", format!("{}:/usr/bin:/bin", desk.path("bin").display()));
        let output = command.output().unwrap();
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = denoise("-o x.exr");
    assert_eq!(code, 1);
    assert!(said.contains("no program oidnDenoise is in the PATH") && said.contains("install it"));
    // One that gives each of the layers back: --hdr 2, --alb 4, --nrm 6, -o 8.
    let read = |name: &str| rondure_film::ExrPicture::read(desk.path(name)).unwrap();
    let noisy = read("noisy.exr");
    for (place, names) in [
        (2, ["R", "G", "B"]),
        (4, ["albedo.R", "albedo.G", "albedo.B"]),
        (6, ["normal.X", "normal.Y", "normal.Z"]),
    ] {
        stand_in(&desk, &format!("echo $1 $3 $5 $7 $9 ${{10}} > said; cp \"${place}\" \"$8\""));
        let (code, said) = denoise("-o clean.exr --threads 3");
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("denoised by Open Image Denoise"), "{said}");
        let arguments = std::fs::read_to_string(desk.path("said")).unwrap();
        assert_eq!(arguments, "--hdr --alb --nrm -o --threads 3\n");
        let clean = read("clean.exr");
        for (channel, name) in ["R", "G", "B"].into_iter().zip(names) {
            assert_eq!(clean.channel(channel), noisy.channel(name));
        }
        assert_eq!(clean.channel("Z"), noisy.channel("Z"));
        assert_eq!(clean.setting("denoised"), Some("oidn"));
    }
    for (script, words) in [
        ("echo Error: no >&2; exit 1", "gave no picture: Error: no"),
        ("exit 0", "gave no picture"),
        ("echo PF > \"$8\"", "its file is not whole"),
        ("printf 'PF\\n1 1\\n-1.0\\n000000000000' > \"$8\"", "another size"),
    ] {
        stand_in(&desk, script);
        let (code, said) = denoise("-o x.exr");
        assert!(code == 1 && said.contains(words), "{script}: {said}");
    }
    let left: Vec<_> = std::fs::read_dir(desk.path(".")).unwrap().map(Result::unwrap).collect();
    assert_eq!(left.len(), 5, "{left:?}");
}

//! Solids made of others, sweeps and sections, from the command line.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::fmt::Write;

use common::{Desk, pixels};

const SCENE: &str = r#"
[film]
size = [24, 16]
spp = 2

[camera]
eye = [6, 0, 3]
look_at = [0, 0, 1]

[sky]

[section]
normal = [1, 0, 0]

[profiles]
pot = { path = "M 0 0 H 2 V 3 H 1 V 1 H 0" }
screen = { path = "M 3 0 V 3" }

[[object]]
name = "pot"
profile = "pot"

[[object]]
name = "half a pot"
profile = "pot"
sweep = [0, 180]

[[object]]
name = "screen"
profile = "screen"
sweep = { from = 90, to = 270, open = true }

[[object]]
name = "slotted"
difference = [{ profile = "pot" }, { type = "box", size = [9, 0.2, 1], position = [0, 0, 3] }]
at = [[0, 5, 0], [0, -5, 0]]
"#;

#[test]
fn what_is_in_a_scene_is_told() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    let mut gallery = String::new();
    for arguments in [
        "check scene.toml",
        "measure scene.toml",
        "measure scene.toml --object screen",
        "measure scene.toml --object slotted",
    ] {
        let outcome = desk.run(arguments);
        writeln!(gallery, "$ rondure {arguments}\n{}{}", outcome.stdout, outcome.stderr).unwrap();
    }
    insta::assert_snapshot!(gallery);
}

#[test]
fn every_engine_renders_them() {
    let desk = Desk::new();
    desk.file("scene.toml", SCENE);
    for engine in ["wide", "exact", "hy"] {
        let outcome =
            desk.run(&format!("render scene.toml --quiet --engine {engine} -o {engine}.png"));
        assert_eq!((outcome.code, &*outcome.stderr), (0, ""), "{engine}");
    }
    // The files say which engine made them.
    let picture = |engine: &str| pixels(&desk.path(&format!("{engine}.png")));
    assert!(picture("wide") == picture("exact"));
}

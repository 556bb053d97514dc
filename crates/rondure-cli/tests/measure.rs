//! `rondure measure`, end to end.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use std::{f64::consts::PI, fmt::Write};

use common::{CONE, Desk, SPHERE, TORUS};

/// A pot with walls and a bottom of thickness 1, 10 wide inside and 9 deep.
const POT: &str = "M 0 0 L 6 0 L 6 10 L 5 10 L 5 1 L 0 1";

const SCENE: &str = r#"
[camera]
eye = [60, 0, 30]
look_at = [0, 0, 10]

[sky]

[profiles]
pot = { path = "M 0 0 L 6 0 L 6 10 L 5 10 L 5 1 L 0 1" }

[[object]]
name = "pot"
profile = "pot"

[[object]]
name = "large"
profile = "pot"
scale = 2
position = [30, 0, 5]

[[object]]
name = "tall"
profile = "pot"
scale = [1, 1, 3]

[[object]]
name = "flat"
profile = "pot"
scale = [1, 2, 1]

[[object]]
name = "on its head"
profile = { path = "M 0 3 L 5 3 L 5 10 L 6 10 L 6 -1 L 4 -1 L 4 2 L 0 2" }
rotation = [180, 0, 0]

[[object]]
name = "fallen"
profile = "pot"
rotation = [0, 90, 0]

[[object]]
name = "sheet"
profile = { path = "M 0 0 L 3 0 L 3 4" }
at = [[0, 20, 0], [0, 30, 0]]

[[object]]
name = "ball"
type = "sphere"
radius = 2
"#;

/// The number after a key of JSON; the first one, if there are several.
fn number(json: &str, key: &str) -> f64 {
    let after =
        json.split_once(&format!("\"{key}\": ")).unwrap_or_else(|| panic!("{key}: {json}")).1;
    after.split([',', '\n', '}']).next().unwrap().parse().unwrap()
}

fn good(desk: &Desk, arguments: &str) -> String {
    let outcome = desk.run(arguments);
    assert_eq!((outcome.code, &*outcome.stderr), (0, ""), "{arguments}");
    outcome.stdout
}

#[test]
fn a_pot_is_told_in_text() {
    let desk = Desk::new();
    desk.file("pot.path", POT).file("torus.path", TORUS).file("sheet.path", "M 1 0 L 2 3");
    let mut gallery = String::new();
    for arguments in [
        "measure pot.path",
        "measure pot.path --in cm --density 2.4 --level 1 --level 6 --volume 0.5l --volume 1l",
        "measure pot.path --in mm --scale 10",
        "measure torus.path",
        "measure sheet.path",
    ] {
        writeln!(gallery, "$ rondure {arguments}\n{}", good(&desk, arguments)).unwrap();
    }
    insta::assert_snapshot!(gallery);
}

#[test]
fn a_pot_is_told_in_json() {
    let desk = Desk::new();
    desk.file("pot.path", POT);
    let json = good(&desk, "measure pot.path --json --in cm --density 2 --level 6 --volume 1l");
    insta::assert_snapshot!(json);
    assert!((number(&json, "volume") / (PI * (360.0 - 225.0)) - 1.0).abs() < 1e-14);
    assert!((number(&json, "capacity") / (PI * 225.0) - 1.0).abs() < 1e-14);
}

#[test]
fn json_has_all_digits() {
    let desk = Desk::new();
    desk.file("sphere.path", SPHERE).file("cone.path", CONE);
    for (name, path) in [("sphere", SPHERE), ("cone", CONE)] {
        let json = good(&desk, &format!("measure {name}.path --json"));
        let measure = rondure::Profile::from_path_data(path).unwrap().measure();
        let solid = measure.solid.unwrap();
        for (key, value) in [
            ("length", measure.length),
            ("area", measure.area),
            ("volume", solid.volume),
            ("xx", solid.inertia_transverse),
            ("zz", solid.inertia_axial),
        ] {
            let error = (number(&json, key) - value).abs();
            // The tensor is put together from second moments.
            assert!(error <= if key.len() == 2 { 1e-15 } else { 0.0 }, "{key}: {error:e}");
        }
        assert!(json.contains("\"capacity\": null"), "{json}");
    }
}

#[test]
fn scenes_are_told_object_by_object() {
    let desk = Desk::new();
    desk.file("pots.toml", SCENE);
    let text = good(&desk, "measure pots.toml --in cm --density 2.4 --level 6");
    insta::assert_snapshot!(text);
}

#[test]
fn placements_change_measures_as_they_should() {
    let desk = Desk::new();
    desk.file("pots.toml", SCENE);
    let object = |name: &str| {
        let mut command = desk.command("measure pots.toml --json --object");
        let output = command.arg(name).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let near = |name: &str, key: &str, exact: f64| {
        let value = number(&object(name), key);
        assert!((value - exact).abs() <= 1e-13 * exact.abs(), "{name} {key}: {value} {exact}");
    };
    let (volume, capacity) = (PI * 135.0, PI * 225.0);
    near("pot", "volume", volume);
    near("pot", "brim", 10.0);
    near("large", "volume", 8.0 * volume);
    near("large", "capacity", 8.0 * capacity);
    near("large", "brim", 25.0);
    near("large", "bottom", 7.0);
    near("large", "zz", 32.0 * number(&object("pot"), "zz"));
    near("large", "area", 4.0 * number(&object("pot"), "area"));
    near("tall", "capacity", 3.0 * capacity);
    near("tall", "area", PI * (36.0 + 2.0 * 6.0 * 30.0 + 11.0 + 2.0 * 5.0 * 27.0 + 25.0));
    near("flat", "volume", 2.0 * volume);
    near("fallen", "volume", volume);
    near("fallen", "xx", number(&object("pot"), "zz"));
    near("fallen", "zz", number(&object("pot"), "xx"));
    assert!(object("flat").contains("\"area\": null"));
    assert!(object("fallen").contains("\"capacity\": null"));
    // The foot ring, 3 deep and 4 wide inside.
    near("on its head", "capacity", PI * 16.0 * 3.0);
    near("on its head", "bottom", -2.0);
    near("on its head", "brim", 1.0);
    near("sheet #2", "capacity", PI * 36.0);
}

#[test]
fn drawings_bring_their_unit() {
    let desk = Desk::new();
    desk.file(
        "pot.svg",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100mm\" height=\"200mm\" \
         viewBox=\"0 0 100 200\">\
         <path d=\"M 0 200 L 60 200 L 60 100 L 50 100 L 50 190 L 0 190\"/></svg>",
    );
    let text = good(&desk, "measure pot.svg --unit cm --volume 5cl");
    assert!(text.contains("volume      424.1150"), "{text}");
    assert!(text.contains("706.85835 ml"), "{text}");
    assert!(text.contains("50 ml       z = 1.6366198"), "{text}");
    // In millimetres, and in user units, which here are the same.
    let json = good(&desk, "measure pot.svg --unit mm --json");
    assert!(json.contains("\"unit\": \"mm\""), "{json}");
    assert!((number(&json, "capacity") / (PI * 225e3) - 1.0).abs() < 1e-12);
    let json = good(&desk, "measure pot.svg --json");
    assert!(json.contains("\"unit\": null"), "{json}");
}

#[test]
fn bad_input_is_told() {
    let desk = Desk::new();
    desk.file("pot.path", POT).file("pots.toml", SCENE).file("bad.path", "M 1 0 L -1 1");
    desk.file("cross.path", "M 1 0 L 3 2 L 1 2 L 3 0 Z").file("bad.toml", "[[object]]\ntype = 1");
    desk.file(
        "none.toml",
        "[camera]\neye = [6, 0, 3]\nlook_at = [0, 0, 1]\n[sky]\n[[object]]\ntype = \"sphere\"\nradius = 1",
    );
    let mut gallery = String::new();
    for (arguments, code) in [
        ("measure none.path", 1),
        ("measure bad.path", 1),
        ("measure bad.toml", 1),
        ("measure pot.path --object pot", 1),
        ("measure pots.toml --object pit", 1),
        ("measure none.toml --object pit", 1),
        ("measure pots.toml --scale 2", 1),
        ("measure pots.toml --unit cm", 1),
        ("measure pot.path --unit cm", 1),
        ("measure pot.path --unit cm --in mm", 1),
        ("measure pot.path --volume 100ml", 1),
        ("measure pot.path --volume -1", 2),
        ("measure pot.path --volume 1pt", 2),
        ("measure pot.path --density 0", 2),
        ("measure pot.path --density -1", 2),
        ("measure pot.path --level nan", 2),
        ("measure pot.path --in ft", 2),
        ("measure", 2),
        // No errors of the command: the measures say why they are missing.
        ("measure cross.path", 0),
        ("measure none.toml", 0),
    ] {
        let outcome = desk.run(arguments);
        assert_eq!(outcome.code, code, "{arguments}: {}", outcome.stderr);
        assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
        let said = outcome.stdout + &outcome.stderr;
        writeln!(gallery, "$ rondure {arguments}\n{}\n", said.trim_end()).unwrap();
    }
    insta::assert_snapshot!(gallery);
}

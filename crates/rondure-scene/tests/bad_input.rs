//! What is wrong with bad input, word for word. Every file in `tests/bad` is refused.

#![allow(clippy::expect_used, clippy::panic, reason = "a test that fails may stop")]

use std::{error::Error, fs, path::Path};

use rondure_scene::{
    LARGEST_FILE, ProfileFormat, ProfileOptions, Report, Unit, parse_profile, parse_scene,
    read_profile, read_scene,
};

fn read(path: &Path) -> Report {
    let result = if path.extension().is_some_and(|e| e == "toml") {
        read_scene(path).map(|_| ())
    } else {
        read_profile(path, &ProfileOptions::default()).map(|_| ())
    };
    result.expect_err(&format!("{} is good", path.display()))
}

#[test]
fn every_bad_file() -> Result<(), Box<dyn Error>> {
    let mut paths = fs::read_dir("tests/bad")?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>, std::io::Error>>()?;
    paths.sort();
    assert!(paths.len() >= 46, "{} files", paths.len());
    for path in paths {
        let report = read(&path);
        assert!(report.errors() > 0);
        insta::assert_snapshot!(path.file_name().unwrap().to_str().unwrap(), report);
    }
    Ok(())
}

#[test]
fn missing_file() {
    insta::assert_snapshot!("missing-profile", read(Path::new("tests/bad/missing.path")));
    insta::assert_snapshot!("missing-scene", read(Path::new("tests/bad/missing.toml")));
}

#[test]
fn directory() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    for name in ["profile.svg", "scene.toml"] {
        let path = folder.path().join(name);
        fs::create_dir(&path)?;
        let text = read(&path).to_string().replace(&folder.path().display().to_string(), "DIR");
        insta::assert_snapshot!(format!("directory-{name}"), text);
    }
    Ok(())
}

#[test]
fn huge_file() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("huge.csv");
    // A sparse file: it takes no room.
    fs::File::create(&path)?.set_len(LARGEST_FILE + 1)?;
    let text = read(&path).to_string().replace(&folder.path().display().to_string(), "DIR");
    insta::assert_snapshot!("huge-file", text);
    Ok(())
}

fn options_error(format: ProfileFormat, text: &str, options: ProfileOptions) -> Report {
    parse_profile("<text>", text, format, &options).expect_err("good")
}

#[test]
fn options() {
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path id="a" d="M 1 0 L 2 2"/><g id="g"/></svg>"#;
    let id = |id: &str| ProfileOptions { id: Some(id.into()), ..Default::default() };
    insta::assert_snapshot!("no-such-id", options_error(ProfileFormat::Svg, svg, id("b")));
    insta::assert_snapshot!("id-of-a-group", options_error(ProfileFormat::Svg, svg, id("g")));
    let unit = ProfileOptions { unit: Some(Unit::Mm), ..Default::default() };
    insta::assert_snapshot!("unit-without-size", options_error(ProfileFormat::Svg, svg, unit));
    let axis = ProfileOptions { axis: Some(1.5), ..Default::default() };
    insta::assert_snapshot!("axis-through-the-path", options_error(ProfileFormat::Svg, svg, axis));
    let mut senseless = id("a");
    senseless.scale = Some(-1.0);
    senseless.spline = Some(rondure::Spline::Natural);
    insta::assert_snapshot!(
        "options-without-meaning",
        options_error(ProfileFormat::PathData, "M 0 0 L 1 1", senseless)
    );
}

#[test]
fn swinging_spline() {
    let options = ProfileOptions { spline: Some(rondure::Spline::Natural), ..Default::default() };
    let text = "r,z\n# a narrow neck\n0.05,0\n1,1\n0,1.2\n0.05,1.3\n1,1.4\n";
    insta::assert_snapshot!("swinging-spline", options_error(ProfileFormat::Csv, text, options));
}

#[test]
fn many_errors_are_counted() {
    let text = "x,1\n".repeat(1000);
    let report =
        options_error(ProfileFormat::Csv, &text.replacen("x,1", "1,1", 1), Default::default());
    assert_eq!(report.errors(), 999);
    assert!(report.to_string().ends_with("... and 959 more"));
}

#[test]
fn long_lines_are_cut() {
    let text = format!("M 0 0 {} L 1 y", "L 1 2 ".repeat(100_000));
    let report = options_error(ProfileFormat::PathData, &text, Default::default());
    let shown = report.to_string();
    assert!(shown.len() < 2000, "{} bytes: {}", shown.len(), &shown[..500]);
    assert!(shown.contains("1 y"));
}

#[test]
fn what_could_command_a_terminal_is_not_shown() {
    let text = "[[object]]\r\nmaterial = \"\\u001b[31mred\\n\"\r\n";
    let report = parse_scene("<scene>", text, Path::new("")).expect_err("good");
    assert!(!report.plain().contains(|c: char| c.is_control() && c != '\n'), "{report}");
    insta::assert_snapshot!("control-characters", report);
    let svg =
        "<svg xmlns=\"http://www.w3.org/2000/svg\">\u{9b}31m<path d=\"M 0 0 L 1 x\"/></svg\u{7f}>";
    for text in [svg, "M 0 0 L 1 \u{9b}31m", "M 0 0 \u{85} \u{7f}"] {
        for format in [ProfileFormat::Svg, ProfileFormat::PathData, ProfileFormat::Csv] {
            let report = options_error(format, text, ProfileOptions::default());
            assert!(!report.plain().contains(|c: char| c.is_control() && c != '\n'), "{report}");
        }
    }
}

#[test]
fn colors_are_only_in_the_colored_text() {
    let report = parse_scene("<scene>", "x = 1", Path::new("")).expect_err("good");
    assert!(!report.plain().contains('\x1b'));
    assert!(report.colored().contains('\x1b'));
}

/// Cuts and overwrites good profiles everywhere: nothing panics.
#[test]
fn damaged_profiles() -> Result<(), Box<dyn Error>> {
    for (name, format) in [
        ("goblet.svg", ProfileFormat::Svg),
        ("vase.csv", ProfileFormat::Csv),
        ("bowl.path", ProfileFormat::PathData),
    ] {
        let text = fs::read_to_string(Path::new("tests/good").join(name))?;
        let options = ProfileOptions {
            id: (format == ProfileFormat::Svg).then(|| "goblet".into()),
            ..Default::default()
        };
        for i in 0..text.len() {
            for put in ["", "\"", "<", "&", "\u{e9}", "\0", "-9", "e", ","] {
                let damaged = format!("{}{put}{}", &text[..i], &text[i + 1..]);
                if let Err(report) = parse_profile(name, &damaged, format, &options) {
                    assert!(report.plain().starts_with("error"));
                }
            }
        }
    }
    Ok(())
}

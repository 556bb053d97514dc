//! Good profile files, and maps of drawings.

#![allow(clippy::expect_used, clippy::panic, reason = "a test that fails may stop")]

use std::path::Path;

use proptest::prelude::*;
use rondure::{Point, Profile, Segment, Spline};
use rondure_scene::{ProfileFormat, ProfileOptions, Unit, parse_profile, read_profile};

fn svg(text: &str, options: &ProfileOptions) -> Profile {
    parse_profile("<svg>", text, ProfileFormat::Svg, options)
        .map_err(|e| e.to_string())
        .expect("good")
}

fn id(id: &str) -> ProfileOptions {
    ProfileOptions { id: Some(id.into()), ..Default::default() }
}

fn read(name: &str, options: &ProfileOptions) -> Profile {
    let path = Path::new("tests/good").join(name);
    read_profile(&path, options).map_err(|e| e.to_string()).expect("good")
}

fn near(a: Point, r: f64, z: f64, tolerance: f64) -> bool {
    (a - Point::new(r, z)).length() <= tolerance
}

#[test]
fn inkscape_goblet() {
    let profile = read("goblet.svg", &ProfileOptions { axis: Some(50.0), ..id("goblet") });
    assert_eq!(profile.subpaths().len(), 1);
    let subpath = &profile.subpaths()[0];
    // 39.7 + 10.3 and 124.7 - 4.7: on the axis, at the bottom of the page.
    assert_eq!(subpath.start().r, 0.0);
    assert!(near(subpath.start(), 0.0, 0.0, 1e-13), "{:?}", subpath.start());
    assert!(near(subpath.segments()[0].end(), 20.0, 0.0, 1e-13));
    assert!(matches!(subpath.segments()[1], Segment::Cubic(_)));
    assert!(subpath.is_closed());
    // The relative steps back to the axis end on it, in spite of their rounding.
    let last = subpath.segments()[subpath.segments().len() - 2].end();
    assert_eq!(last.r, 0.0);
    assert!(near(last, 0.0, 48.0, 1e-12), "{last:?}");

    let options =
        ProfileOptions { unit: Some(Unit::Cm), scale: Some(2.0), axis: Some(50.0), ..id("goblet") };
    let end = read("goblet.svg", &options).subpaths()[0].segments()[0].end();
    assert!(near(end, 4.0, 0.0, 1e-13), "{end:?}");
}

#[test]
fn table_with_swapped_columns() {
    let profile = read("vase.csv", &ProfileOptions::default());
    let ends: Vec<_> = profile.segments().map(|s| (s.end().r, s.end().z)).collect();
    assert_eq!(ends, [(3.5, 0.0), (4.0, 1.0), (5.5, 6.0), (2.0, 12.0), (3.0, 14.0)]);
    let smooth = read(
        "vase.csv",
        &ProfileOptions { spline: Some(Spline::CatmullRom), ..Default::default() },
    );
    assert!(smooth.segments().all(|s| matches!(s, Segment::Cubic(_))));
}

#[test]
fn table_without_a_header() {
    let options = ProfileOptions { scale: Some(0.5), ..Default::default() };
    let profile = parse_profile("<csv>", "1,2\r\n 3 ,4e0\r\n", ProfileFormat::Csv, &options);
    let expected = Segment::Line([Point::new(0.5, 1.0), Point::new(1.5, 2.0)]);
    assert_eq!(profile.expect("good").segments().collect::<Vec<_>>(), [&expected]);
}

#[test]
fn path_data_with_comments() {
    let profile = read("bowl.path", &ProfileOptions { scale: Some(10.0), ..Default::default() });
    let all: Vec<_> = profile.segments().collect();
    assert_eq!(all.len(), 3);
    let Segment::Arc(outside) = all[0] else { panic!("no arc") };
    assert!(near(outside.center, 0.0, 10.0, 1e-14) && outside.radii == [10.0, 10.0], "{outside:?}");
    assert!(profile.bounds_solid());
}

#[test]
fn byte_order_mark() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("marked.csv");
    std::fs::write(&path, "\u{feff}r,z\n1,2\n3,4\n").expect("written");
    assert_eq!(
        read_profile(&path, &ProfileOptions::default()).expect("good").segments().count(),
        1
    );
}

#[test]
fn shapes() {
    let page = |shape: &str| {
        let text =
            format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10">{shape}</svg>"#);
        svg(&text, &ProfileOptions::default())
    };
    // A ring torus, round (5, 4) in r and z.
    let torus = page(r#"<circle cx="5" cy="6" r="2"/>"#);
    assert_eq!(torus.segments().count(), 4);
    for segment in torus.segments() {
        let Segment::Arc(arc) = segment else { panic!("no arc") };
        assert_eq!((arc.center, arc.radii), (Point::new(5.0, 4.0), [2.0, 2.0]));
        assert!(((arc.point(0.3) - arc.center).length() - 2.0).abs() < 1e-14);
    }
    // A horn torus touches the axis in a point.
    assert!(page(r#"<circle cx="2" cy="6" r="2"/>"#).segments().any(|s| s.end().r == 0.0));
    let cylinder = page(r#"<rect x="0" y="2" width="3" height="8"/>"#);
    let ends: Vec<_> = cylinder.segments().map(|s| (s.end().r, s.end().z)).collect();
    assert_eq!(ends, [(3.0, 8.0), (3.0, 0.0), (0.0, 0.0), (0.0, 8.0)]);
    assert_eq!(page(r#"<rect x="1" y="1" width="3" height="8" rx="1"/>"#).segments().count(), 8);
    assert_eq!(page(r#"<ellipse cx="1in" cy="0" rx="3" ry="2"/>"#).segments().count(), 4);
    assert_eq!(page(r#"<line x1="1" y1="1" x2="2" y2="2"/>"#).segments().count(), 1);
    assert_eq!(page(r#"<polyline points="1,1 2,2 3 1"/>"#).segments().count(), 2);
    assert_eq!(page(r#"<polygon points="1,1 2,2 3 1"/>"#).segments().count(), 3);
}

#[test]
fn a_group_with_one_shape_can_be_chosen() {
    let text = r#"<svg xmlns="http://www.w3.org/2000/svg">
        <g id="a"><path d="M 1 0 L 2 0"/></g><path id="b" d="M 3 0 L 4 0"/></svg>"#;
    assert_eq!(svg(text, &id("a")).segments().next().expect("one").start().r, 1.0);
}

#[test]
fn snap_puts_a_careless_drawing_on_the_axis() {
    let text =
        r#"<svg xmlns="http://www.w3.org/2000/svg"><path d="M -0.001 0 L 2 0 L 0.002 3"/></svg>"#;
    let careless = |snap| ProfileOptions { snap, ..Default::default() };
    assert!(parse_profile("<svg>", text, ProfileFormat::Svg, &careless(None)).is_err());
    assert!(svg(text, &careless(Some(0.01))).bounds_solid());
}

#[test]
fn deeply_nested_groups() {
    let depth = 100_000;
    let text = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg">{}<path d="M 1 1 L 2 2"/>{}</svg>"#,
        "<g>".repeat(depth),
        "</g>".repeat(depth)
    );
    assert_eq!(svg(&text, &ProfileOptions::default()).segments().count(), 1);
}

#[test]
fn many_points() {
    let text: String = (0..100_000).map(|i| format!("{},{i}\n", 2.0 + f64::from(i % 7))).collect();
    for spline in [Spline::Polyline, Spline::Natural, Spline::CatmullRom] {
        let options =
            ProfileOptions { spline: Some(spline), scale: Some(0.01), ..Default::default() };
        let profile = parse_profile("<csv>", &text, ProfileFormat::Csv, &options);
        assert_eq!(profile.expect("good").segments().count(), 99_999);
    }
}

/// A transform in SVG's syntax and as kurbo's map.
fn transform() -> impl Strategy<Value = (String, kurbo::Affine)> {
    use kurbo::Affine;
    let number = || -20.0..20.0_f64;
    prop_oneof![
        (number(), number())
            .prop_map(|(x, y)| (format!("translate({x},{y})"), Affine::translate((x, y)))),
        (0.2..3.0_f64, -3.0..-0.2_f64)
            .prop_map(|(x, y)| (format!("scale({x} {y})"), Affine::scale_non_uniform(x, y))),
        (-400.0..400.0_f64).prop_map(|a| (format!("rotate({a})"), Affine::rotate(a.to_radians()))),
        (-400.0..400.0_f64, number(), number()).prop_map(|(a, x, y)| {
            (format!("rotate({a} {x} {y})"), Affine::rotate_about(a.to_radians(), (x, y)))
        }),
        (-60.0..60.0_f64)
            .prop_map(|a| (format!("skewX({a})"), Affine::skew(a.to_radians().tan(), 0.0))),
        (-60.0..60.0_f64)
            .prop_map(|a| (format!("skewY({a})"), Affine::skew(0.0, a.to_radians().tan()))),
        prop::array::uniform6(0.1..2.0_f64)
            .prop_filter("regular", |m| (m[0] * m[3] - m[1] * m[2]).abs() > 0.05)
            .prop_map(|m| {
                let [a, b, c, d, e, f] = m;
                (format!("matrix({a} {b} {c} {d} {e} {f})"), Affine::new(m))
            }),
    ]
}

proptest! {
    /// Nested transforms of a drawing with every kind of segment, against kurbo's.
    #[test]
    fn transforms_agree_with_kurbo(
        outer in prop::collection::vec(transform(), 0..3),
        inner in prop::collection::vec(transform(), 0..3),
        axis in -1e4..-5e3_f64,
    ) {
        let join = |list: &[(String, kurbo::Affine)]| {
            let text: Vec<_> = list.iter().map(|(t, _)| t.as_str()).collect();
            (text.join(" "), list.iter().fold(kurbo::Affine::IDENTITY, |m, (_, n)| m * *n))
        };
        let ((outer, outer_map), (inner, inner_map)) = (join(&outer), join(&inner));
        let data = "M 1 2 L 4 3 Q 5 7 2 8 C 1 9 3 4 6 5 A 3 2 30 1 0 7 6";
        let text = format!(
            r#"<svg viewBox="0 -5 10 15"><g transform="{outer}"><path transform="{inner}" d="{data}"/></g></svg>"#
        );
        let options = ProfileOptions { axis: Some(axis), ..Default::default() };
        let found = svg(&text, &options);
        let map = kurbo::Affine::new([1.0, 0.0, 0.0, -1.0, -axis, 10.0]) * outer_map * inner_map;
        let plain = Profile::from_path_data(data).expect("good");
        let size = map.as_coeffs().iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        prop_assert_eq!(found.segments().count(), plain.segments().count());
        for (a, b) in found.segments().zip(plain.segments()) {
            for i in 0..=8 {
                let s = f64::from(i) / 8.0;
                let p = b.point(s);
                let expected = map * kurbo::Point::new(p.r, p.z);
                let tolerance = 1e-13 * size;
                prop_assert!(
                    near(a.point(s), expected.x, expected.y, tolerance),
                    "{:?} is not {expected:?}: {a:?}", a.point(s)
                );
            }
        }
    }
}

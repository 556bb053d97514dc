//! `rondure trace`: entries and exits, `--spans`, `--occluded`, `--thickness`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use common::{CYLINDER, Desk, SPHERE, TORUS, rows};

const HEADER: &str = "ox,oy,oz,dx,dy,dz";

fn trace(profile: &str, rays: &str, options: &str) -> String {
    let desk = Desk::new();
    desk.file("it.path", profile).file("rays.csv", rays);
    let outcome = desk.run(&format!("trace it.path --rays rays.csv {options}"));
    assert_eq!((outcome.code, &*outcome.stderr), (0, ""));
    outcome.stdout
}

/// The lines after the header as numbers; what is empty is NaN.
fn table(text: &str) -> Vec<Vec<f64>> {
    let number = |field: &str| if field.is_empty() { f64::NAN } else { field.parse().unwrap() };
    text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}

#[test]
fn hits_tell_entry_from_exit_and_their_segment() {
    let text = trace(CYLINDER, &format!("{HEADER}\n-2,0,0.5,1,0,1\n0,0,1,0,0,-3\n"), "--all");
    let found = rows(&text);
    let told: Vec<_> = found.iter().map(|row| (row.ray, row.segment, row.enters)).collect();
    // In through the side, out through the lid; out through the bottom.
    assert_eq!(told, [(0, 1, true), (0, 2, false), (1, 0, false)]);
    let torus = rows(&trace(TORUS, &format!("{HEADER}\n5,0,0.1,-1,0,0\n"), "--all"));
    assert_eq!(torus.iter().map(|row| row.enters).collect::<Vec<_>>(), [true, false, true, false]);
}

#[test]
fn spans_have_both_ends() {
    let rays = format!("{HEADER}\n5,0,0,-1,0,0\n5,9,0,-1,0,0\n0,0,-5,0,0,2\n");
    let text = trace(TORUS, &rays, "--spans");
    let names: Vec<_> = text.lines().next().unwrap().split(',').collect();
    assert_eq!(names.len(), 21);
    assert_eq!(
        (names[0], names[1], names[11], names[20]),
        ("ray", "enter_t", "exit_t", "exit_segment")
    );
    let found = table(&text);
    assert_eq!(found.len(), 2);
    for (row, (enter, exit)) in found.iter().zip([(2.0, 4.0), (6.0, 8.0)]) {
        assert_eq!((row[0], row[1], row[11]), (0.0, enter, exit));
        // Point and outward normal at both ends.
        assert_eq!((row[2], row[12]), (5.0 - enter, 5.0 - exit));
        assert!((row[5] - 1.0).abs() < 1e-15 && (row[15] + 1.0).abs() < 1e-15, "{row:?}");
    }
}

#[test]
fn spans_begin_and_end_with_the_range() {
    let rays = format!("{HEADER},tmin,tmax\n0,0,0,0,0,2,0,inf\n0,0,0,0,0,2,-inf,0.25\n");
    let found = table(&trace(SPHERE, &rays, "--spans"));
    assert_eq!((found[0][1], found[0][11]), (0.0, 0.5));
    assert!(found[0][5..11].iter().all(|x| x.is_nan()) && found[0][20] == 0.0, "{:?}", found[0]);
    assert_eq!((found[1][1], found[1][11], found[1][14]), (-0.5, 0.25, 0.5));
    assert!(found[1][15..].iter().all(|x| x.is_nan()), "{:?}", found[1]);
}

#[test]
fn the_fill_rule_decides_what_is_inside_where_a_profile_crosses_itself() {
    // Two squares that overlap in r from 1.5 to 2.
    let twice = "M 1 0 H 2 V 1 H 1 Z M 1.5 0 H 2.5 V 1 H 1.5 Z";
    let rays = format!("{HEADER}\n9,0,0.5,-1,0,0,\n").replace(",\n", "\n");
    for (rule, spans) in [("", 2), (" --fill-rule nonzero", 2), (" --fill-rule evenodd", 4)] {
        assert_eq!(table(&trace(twice, &rays, &format!("--spans{rule}"))).len(), spans, "{rule}");
    }
}

#[test]
fn occluded_has_a_line_for_every_ray() {
    let rays = format!(
        "{HEADER},tmin,tmax\n5,0,0,-1,0,0,0,1\n5,0,0,-1,0,0,0,inf\n5,9,0,-1,0,0,0,inf\n0,0,0,0,0,1,0,2\n"
    );
    assert_eq!(trace(SPHERE, &rays, "--occluded"), "ray,occluded\n0,0\n1,1\n2,0\n3,1\n");
}

#[test]
fn a_bowl_with_a_wall_is_a_solid() {
    let bowl = "M 0 -1 A 1 1 0 0 1 1 0";
    let rays = format!("{HEADER}\n0,0,-5,0,0,1\n-5,0,-0.5,1,0,0\n");
    for (options, faces) in [
        ("--thickness 0.25", [0.75, 1.0]),
        ("--thickness 0.25 --side outward", [1.0, 1.25]),
        ("--thickness 0.25 --side centered --rim round", [0.875, 1.125]),
    ] {
        let found = table(&trace(bowl, &rays, &format!("{options} --spans")));
        assert_eq!(found.len(), 3, "{options}: {found:?}");
        let [inner, outer] = faces;
        assert!((found[0][1] - (5.0 - outer)).abs() < 1e-14, "{options}: {:?}", found[0]);
        assert!((found[0][11] - (5.0 - inner)).abs() < 1e-14, "{options}: {:?}", found[0]);
        let reach = |radius: f64| (radius * radius - 0.25).sqrt();
        assert!((found[1][1] - (5.0 - reach(outer))).abs() < 1e-14, "{options}: {:?}", found[1]);
        assert!((found[2][1] - (5.0 + reach(inner))).abs() < 1e-14, "{options}: {:?}", found[2]);
    }
}

/// The same, whatever the number of threads; and as many spans as pairs of hits.
#[test]
fn spans_stream_in_order() {
    let mut rays = String::from(HEADER);
    for i in 0..20_000 {
        let height = f64::from(i % 1999) / 2000.0;
        rays += &format!("\n5,{},{height},-1,0,0", f64::from(i) * 1e-9);
    }
    let one = trace(TORUS, &rays, "--spans --threads 1");
    assert!(one == trace(TORUS, &rays, "--spans --threads 4"));
    let hits = rows(&trace(TORUS, &rays, "--all")).len();
    assert_eq!(2 * table(&one).len(), hits);
}

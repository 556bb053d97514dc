//! `rondure trace` on shapes whose hits are known in closed form.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod common;

use common::{CONE, CYLINDER, Desk, Row, SPHERE, TORUS, rows};
use rondure::{Profile, Ray, Surface, Vec3};

const HEADER: &str = "ox,oy,oz,dx,dy,dz";

fn trace(profile: &str, rays: &str, options: &str) -> Vec<Row> {
    let desk = Desk::new();
    desk.file("it.path", profile).file("rays.csv", rays);
    let outcome = desk.run(&format!("trace it.path --rays rays.csv {options}"));
    assert_eq!((outcome.code, &*outcome.stderr), (0, ""));
    rows(&outcome.stdout)
}

/// All t of one ray.
fn hits(profile: &str, ray: &str) -> Vec<f64> {
    trace(profile, &format!("{HEADER}\n{ray}\n"), "--all").iter().map(|row| row.t).collect()
}

/// Sizes here are about 1 and distances at most 10, so that a few roundings make up this much.
const CLOSE: f64 = 64.0 * f64::EPSILON;

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} is not {expected:?}");
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= CLOSE, "{found:?} is not {expected:?}");
    }
}

#[test]
fn sphere() {
    let h = 0.75_f64.sqrt();
    assert_close(&hits(SPHERE, "5,0,0,-1,0,0"), &[4.0, 6.0]);
    assert_close(&hits(SPHERE, "5,0,0.5,-1,0,0"), &[5.0 - h, 5.0 + h]);
    assert_close(&hits(SPHERE, "0,0,-4,0,0,2"), &[1.5, 2.5]);
    assert_close(&hits(SPHERE, "0.5,0,-4,0,0,1"), &[4.0 - h, 4.0 + h]);
    assert_close(&hits(SPHERE, "0,0,0,0,0.5,0"), &[2.0]);
    assert_close(&hits(SPHERE, "5,1.5,0,-1,0,0"), &[]);
    assert_close(&hits(SPHERE, "5,0,0,1,0,0"), &[]);
}

#[test]
fn cone() {
    // r = 1 - z/2, base at z = 0.
    assert_close(&hits(CONE, "5,0,1,-1,0,0"), &[4.5, 5.5]);
    assert_close(&hits(CONE, "0.25,0,5,0,0,-1"), &[3.5, 5.0]);
    assert_close(&hits(CONE, "5,0,-0.5,-1,0,0"), &[]);
}

#[test]
fn cylinder() {
    assert_close(&hits(CYLINDER, "0,-3,1,0,1,0"), &[2.0, 4.0]);
    assert_close(&hits(CYLINDER, "0.5,0.5,5,0,0,-1"), &[3.0, 5.0]);
    // In through the side, out through the lid.
    assert_close(&hits(CYLINDER, "-2,0,0.5,1,0,1"), &[1.0, 1.5]);
}

#[test]
fn torus() {
    assert_close(&hits(TORUS, "5,0,0,-1,0,0"), &[2.0, 4.0, 6.0, 8.0]);
    assert_close(&hits(TORUS, "2,0,-5,0,0,1"), &[4.0, 6.0]);
    assert_close(&hits(TORUS, "0,0,-5,0,0,1"), &[]);
}

#[test]
fn points_normals_and_parameters() {
    let rays = format!("{HEADER}\n0,5,0,0,-1,0\n-5,0,0,1,0,0\n0,0,3,0,0,-1\n");
    let found = trace(SPHERE, &rays, "");
    for (row, (t, p, u, v)) in found.iter().zip([
        (4.0, [0.0, 1.0, 0.0], 0.25, 0.5),
        (4.0, [-1.0, 0.0, 0.0], 0.5, 0.5),
        (2.0, [0.0, 0.0, 1.0], row_u(&found[2]), 1.0),
    ]) {
        assert_close(&[row.t], &[t]);
        assert_close(&row.point, &p);
        assert_close(&row.normal, &p);
        assert_close(&row.uv, &[u, v]);
    }
}

/// At a pole every angle is right.
fn row_u(row: &Row) -> f64 {
    assert!((0.0..1.0).contains(&row.uv[0]));
    row.uv[0]
}

#[test]
fn a_negative_zero_is_a_zero() {
    let plus = trace(CYLINDER, &format!("{HEADER}\n5,0,1,-1,0,0\n0.5,0,5,0,0,-1"), "--all");
    let minus = trace(CYLINDER, &format!("{HEADER}\n5,-0,1,-1,-0,-0\n0.5,-0,5,-0,-0,-1"), "--all");
    let t = |rows: &[Row]| rows.iter().map(|row| row.t).collect::<Vec<_>>();
    assert_eq!(t(&plus), [4.0, 6.0, 3.0, 5.0]);
    assert_eq!(t(&plus), t(&minus));
}

#[test]
fn only_the_closest_unless_all_are_wanted() {
    let rays = format!("{HEADER}\n5,0,0,-1,0,0\n5,9,0,-1,0,0\n0,0,0,1,0,0\n");
    let closest = trace(TORUS, &rays, "");
    assert_eq!(closest.iter().map(|row| row.ray).collect::<Vec<_>>(), [0, 2]);
    let all = trace(TORUS, &rays, "--all");
    assert_eq!(all.iter().map(|row| row.ray).collect::<Vec<_>>(), [0, 0, 0, 0, 2, 2]);
    assert_eq!(closest, [all[0].clone(), all[4].clone()]);
}

#[test]
fn the_range_of_t() {
    let rays = format!(
        "{HEADER},tmin,tmax\n\
         5,0,0,-1,0,0,3,7\n\
         5,0,0,-1,0,0,4.5,inf\n\
         5,0,0,-1,0,0,-inf,4.5\n\
         0,0,0,-1,0,0,-inf,inf\n\
         0,0,0,-1,0,0,0,0\n\
         0,0,0,-1,0,0,inf,inf\n"
    );
    let found = trace(TORUS, &rays, "--all");
    let of = |ray| found.iter().filter(|r| r.ray == ray).map(|r| r.t).collect::<Vec<_>>();
    assert_close(&of(0), &[4.0, 6.0]);
    assert_close(&of(1), &[6.0, 8.0]);
    assert_close(&of(2), &[2.0, 4.0]);
    assert_close(&of(3), &[-3.0, -1.0, 1.0, 3.0]);
    assert_close(&of(4), &[]);
    assert_close(&of(5), &[]);
}

#[test]
fn columns_may_stand_in_any_order() {
    let usual = trace(TORUS, &format!("{HEADER},tmin,tmax\n5,0.1,0.2,-1,0.03,0.04,1,7\n"), "--all");
    let other = trace(TORUS, "tmax,dz,oy,dx,ox,tmin,dy,oz\n7,0.04,0.1,-1,5,1,0.03,0.2\n", "--all");
    assert!(!usual.is_empty());
    assert_eq!(usual, other);
}

#[test]
fn what_spreadsheets_write_is_understood() {
    let usual = trace(SPHERE, "ox,oy,oz,dx,dy,dz\n5,0,0.5,-1,0,0\n0,0,0,1,0,0\n", "");
    assert_eq!(usual.len(), 2);
    let quoted = "\u{feff}\"ox\",\"oy\",\"oz\",\"dx\",\"dy\",\"dz\"\r\n\
                  \"5\", 0, +0.5,-1,0E0,0\r\n\r\n.0,0.,0,1e0,0,0";
    let found = trace(SPHERE, quoted, "");
    assert_eq!(usual.len(), found.len());
    for (a, b) in usual.iter().zip(&found) {
        assert_eq!((a.ray, a.t), (b.ray, b.t));
    }
}

#[test]
fn a_header_alone_has_no_rays() {
    for rays in ["ox,oy,oz,dx,dy,dz", "ox,oy,oz,dx,dy,dz\n", "ox,oy,oz,dx,dy,dz\r\n\r\n\r\n"] {
        assert_eq!(trace(SPHERE, rays, ""), []);
    }
}

#[test]
fn rays_from_standard_input() {
    let desk = Desk::new();
    desk.file("it.path", CONE).file("rays.csv", format!("{HEADER}\n5,0,1,-1,0,0\n"));
    let file = desk.run("trace it.path --rays rays.csv");
    let input = std::fs::read(desk.path("rays.csv")).unwrap();
    let stdin = desk.run_with_input("trace it.path --rays -", &input);
    assert_eq!((stdin.code, &*stdin.stderr), (0, ""));
    assert_eq!(stdin.stdout, file.stdout);
    assert_eq!(rows(&stdin.stdout).len(), 1);
}

/// What is printed is, bit for bit, what the library says.
#[test]
fn numbers_round_trip() {
    let mut state = 1_u64;
    let mut random = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    let mut text = String::from(HEADER);
    let mut rays = Vec::new();
    for _ in 0..500 {
        let origin = Vec3::new(6.0 * random(), 6.0 * random(), 6.0 * random());
        let target = Vec3::new(2.0 * random(), 2.0 * random(), random());
        let d = target - origin;
        text += &format!("\n{},{},{},{},{},{}", origin.x, origin.y, origin.z, d.x, d.y, d.z);
        rays.push(Ray::new(origin, d));
    }
    let surface = Surface::new(&Profile::from_path_data(TORUS).unwrap());
    let mut expected = Vec::new();
    let mut hits = Vec::new();
    for (ray, r) in rays.iter().enumerate() {
        surface.all(r, &mut hits);
        expected.extend(hits.iter().map(|hit| {
            let at = surface.interaction(r, hit);
            let [point, normal] = [at.point, at.normal].map(|v| [v.x, v.y, v.z]);
            let enters = at.normal.dot(r.direction) < 0.0;
            let segment = surface.segment(hit);
            Row { ray, t: hit.t, point, normal, uv: at.uv, segment, enters }
        }));
    }
    assert!(expected.len() > 500);
    assert_eq!(trace(TORUS, &text, "--all"), expected);
}

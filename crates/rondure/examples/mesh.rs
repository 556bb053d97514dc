//! A profile of path data as a fine mesh of triangles with normals, for renderers that know nothing else:
//! `cargo run --release -p rondure --example mesh profiles/goblet.path goblet.ply --along 64 --around 720`
//!
//! `--along` counts stretches of each segment, `--around` those of the turn. Segments share no vertices, so that corners stay
//! sharp. Normals point to the right of the profile's drawing direction. The file is binary PLY in single precision.

use std::{env, error::Error, f64::consts::TAU, fs};

use rondure::{Point, Profile, Segment};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut files, mut along, mut around) = (Vec::new(), 64, 720);
    let mut args = env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--along" => along = args.next().ok_or("--along needs a number")?.parse()?,
            "--around" => around = args.next().ok_or("--around needs a number")?.parse()?,
            _ => files.push(arg),
        }
    }
    let [from, to] = &files[..] else { return Err("needs a profile and a file to write".into()) };
    if along < 1 || around < 3 {
        return Err("at least one stretch along a segment and three round the axis".into());
    }
    let profile = Profile::from_path_data(&fs::read_to_string(from)?)?;
    let mut mesh = Mesh::default();
    for segment in profile.segments() {
        // What runs along the axis sweeps nothing.
        if (0..=along).any(|i| segment.point(i as f64 / along as f64).r > 0.0) {
            mesh.add(segment, along, around);
        }
    }
    fs::write(to, mesh.ply())?;
    println!("{to}: {} vertices, {} triangles", mesh.vertices.len(), mesh.faces.len());
    Ok(())
}

#[derive(Default)]
struct Mesh {
    vertices: Vec<[f64; 6]>,
    faces: Vec<[u32; 3]>,
}

impl Mesh {
    fn add(&mut self, segment: &Segment, along: usize, around: usize) {
        let first = self.vertices.len() as u32;
        for i in 0..=along {
            let s = i as f64 / along as f64;
            let (p, right) = (segment.point(s), right(segment, s));
            for k in 0..around {
                let (sin, cos) = (TAU * k as f64 / around as f64).sin_cos();
                let r = p.r;
                self.vertices.push([r * cos, r * sin, p.z, right.r * cos, right.r * sin, right.z]);
            }
        }
        let at = |i: usize, k: usize| first + (i * around + k % around) as u32;
        let is_pole = |i: usize| segment.point(i as f64 / along as f64).r == 0.0;
        for i in 0..along {
            for k in 0..around {
                let [a, b, c, d] = [at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)];
                if !is_pole(i) {
                    self.faces.push([a, b, c]);
                }
                if !is_pole(i + 1) {
                    self.faces.push([a, c, d]);
                }
            }
        }
    }

    fn ply(&self) -> Vec<u8> {
        let header = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{}element face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.vertices.len(),
            ["x", "y", "z", "nx", "ny", "nz"]
                .map(|name| format!("property float {name}\n"))
                .concat(),
            self.faces.len(),
        );
        let mut bytes = header.into_bytes();
        for x in self.vertices.iter().flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        for face in &self.faces {
            bytes.push(3);
            face.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        }
        bytes
    }
}

/// The unit normal of a segment to the right of its drawing direction, by central differences.
fn right(segment: &Segment, s: f64) -> Point {
    let [a, b] = [(s - 1e-5).max(0.0), (s + 1e-5).min(1.0)].map(|s| segment.point(s));
    let along = b - a;
    Point::new(along.z, -along.r) * (1.0 / along.length())
}

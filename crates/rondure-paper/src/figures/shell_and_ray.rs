//! Figure 1: a ray, a frustum of the surface, and the shell round the part that it belongs to.

use rondure::engine::Region;
use rondure::{Method, Ray, Vec3};

use super::half_plane::legend;
use super::{CONE, CYLINDER, FAINT, INK, RAY, WALL, area, dashed, stroke, surface};
use crate::svg::{P, Svg};

/// A view from slightly above, along y, without perspective.
struct View {
    origin: P,
    unit: f64,
}

/// The sine and the cosine of the elevation of the view.
const ELEVATION: [f64; 2] = [0.342_020_143_325_668_7, 0.939_692_620_785_908_4];

impl View {
    fn at(&self, p: Vec3) -> P {
        let [sin, cos] = ELEVATION;
        [self.origin[0] + self.unit * p.x, self.origin[1] - self.unit * (p.z * cos + p.y * sin)]
    }

    /// A part of a circle round the axis, in turns from the x axis; the front is from 1/2 to 1.
    fn circle(&self, r: f64, z: f64, [from, to]: [f64; 2]) -> Vec<P> {
        const STEPS: u32 = 72;
        (0..=STEPS)
            .map(|i| {
                let turn = from + (to - from) * f64::from(i) / f64::from(STEPS);
                let (sin, cos) = (core::f64::consts::TAU * turn).sin_cos();
                self.at(Vec3::new(r * cos, r * sin, z))
            })
            .collect()
    }

    /// The front, and dashed the back, of what the chord between two points sweeps.
    fn band(&self, svg: &mut Svg, ends: [[f64; 2]; 2], color: &str, opacity: f64, width: f64) {
        let [[r0, z0], [r1, z1]] = ends;
        let mut front = self.circle(r0, z0, [0.5, 1.0]);
        front.extend(self.circle(r1, z1, [1.0, 0.5]));
        for [r, z] in ends {
            svg.path(self.circle(r, z, [0.0, 0.5]), false, &dashed(color, 0.75 * width));
        }
        svg.path(front, true, &area(color, opacity, width));
    }
}

pub(super) fn figure() -> String {
    let mut svg = Svg::new(860.0, 370.0);
    let (Some(surface), Some(cones)) =
        (surface(WALL, Method::Cy, 9, 0), surface(WALL, Method::Co, 9, 0))
    else {
        return svg.finish();
    };
    let shells = [surface.tree(), cones.tree()];
    let ends: Vec<_> = surface.piece_ends().collect();
    let ray = Ray::line(Vec3::new(-2.08, -0.69, 1.2725), Vec3::new(4.2, 1.1455, -0.9068));
    let mut hits = Vec::new();
    surface.all(&ray, &mut hits);

    for (i, name) in ["cylinder shell (CY)", "cone shell (CO)"].into_iter().enumerate() {
        let view = View { origin: [215.0 + 430.0 * i as f64, 245.0], unit: 100.0 };
        let (engine, color) = [(&surface, CYLINDER), (&cones, CONE)][i];
        let Some(root) = shells[i].first() else { continue };
        let walls = match root.region {
            Region::Cylinder { z: [z0, z1], w } => w.map(f64::sqrt).map(|r| [[r, z0], [r, z1]]),
            Region::Cone { z: [z0, z1], slope, offsets } => {
                offsets.map(|o| [[slope * z0 + o, z0], [slope * z1 + o, z1]])
            }
            Region::Strip { .. } | Region::Rectangle { .. } => continue,
        };
        svg.line(
            view.at(Vec3::new(0.0, 0.0, -0.15)),
            view.at(Vec3::new(0.0, 0.0, 1.95)),
            &format!("{} stroke-dasharray=\"10 3 2 3\"", stroke(FAINT, 1.0)),
        );
        let [x, y] = view.at(Vec3::new(0.0, 0.0, 1.95));
        svg.text([x - 4.0, y - 6.0], &format!("fill=\"{FAINT}\" font-style=\"italic\""), "z");

        // From the inside out.
        view.band(&mut svg, walls[0], color, 0.10, 1.0);
        let hit_pieces: Vec<usize> = hits.iter().map(|hit| hit.piece as usize).collect();
        for (j, [a, b]) in ends.iter().enumerate() {
            let hit = hit_pieces.contains(&j);
            let (tone, opacity, width) =
                if hit { ("#3a9a5b", 0.55, 1.2) } else { ("#5b6472", 0.10, 0.5) };
            view.band(&mut svg, [[a.r, a.z], [b.r, b.z]], tone, opacity, width);
        }
        let curve = ends.iter().flatten().map(|p| view.at(Vec3::new(p.r, 0.0, p.z)));
        svg.path(curve, false, &stroke(INK, 2.0));
        view.band(&mut svg, walls[1], color, 0.10, 1.6);

        let at = |t: f64| view.at(ray.origin + ray.direction * t);
        svg.arrow(at(0.0), at(1.0), RAY, 1.3);
        for [from, to] in engine.intersection_intervals(&ray, 0) {
            svg.line(at(from), at(to), &format!("{} stroke-opacity=\"0.55\"", stroke(RAY, 5.0)));
        }
        for hit in &hits {
            svg.dot(at(hit.t), 4.2, &format!("fill=\"#fff\" stroke=\"{RAY}\" stroke-width=\"2\""));
        }
        let [x, _] = view.origin;
        svg.text([x, 28.0], "text-anchor=\"middle\" font-size=\"15\" font-weight=\"bold\"", name);
    }
    legend(&mut svg, [120.0, 347.0], INK, 2.0, "profile");
    legend(&mut svg, [220.0, 347.0], "#3a9a5b", 8.0, "frusta that the ray meets");
    legend(&mut svg, [440.0, 347.0], RAY, 5.0, "intersection interval");
    svg.dot([655.0, 343.0], 4.2, &format!("fill=\"#fff\" stroke=\"{RAY}\" stroke-width=\"2\""));
    svg.text([667.0, 347.0], "", "hits");
    svg.finish()
}

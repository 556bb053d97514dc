//! Figure 2: the intersection interval: none, one, or two.

use rondure::{Method, Ray, Vec3};

use super::half_plane::{HalfPlane, legend};
use super::{CURVE, CYLINDER, FAINT, INK, RAY, WALL, area, dashed, stroke, surface};
use crate::svg::Svg;

pub(super) fn figure() -> String {
    let mut svg = Svg::new(930.0, 580.0);
    let Some(surface) = surface(WALL, Method::Cy, 60, 0) else { return svg.finish() };
    let nodes = surface.tree();
    let Some(root) = nodes.first() else { return svg.finish() };
    let ends: Vec<_> = surface.piece_ends().collect();
    let line = |y: f64, z: f64, up: f64| {
        Ray::line(Vec3::new(-2.0, y, z - 2.0 * up), Vec3::new(1.0, 0.0, up))
    };
    // Rays by their distance from the axis, their height beside it, and their slope.
    let panels = [
        ("(a) one interval", vec![("a", line(1.38, 0.52, 0.1)), ("b", line(1.12, 0.86, 0.1))]),
        ("(b) two intervals", vec![("c", line(0.35, 0.78, 0.2))]),
        ("(c) none", vec![("d", line(1.68, 0.8, 0.22))]),
    ];
    let (r_inner, r_outer) = (0.9, 1.55);
    for (i, (title, rays)) in panels.into_iter().enumerate() {
        let left = 25.0 + 302.0 * i as f64;
        svg.text(
            [left + 130.0, 26.0],
            "text-anchor=\"middle\" font-size=\"15\" font-weight=\"bold\"",
            title,
        );
        let small = format!("text-anchor=\"middle\" fill=\"{FAINT}\" font-size=\"12\"");
        svg.text([left + 130.0, 268.0], &small, "seen along the axis");
        svg.text([left + 130.0, 524.0], &small, "in the half plane");
        // From above: two circles and a line.
        let (center, unit) = ([left + 130.0, 150.0], 62.0);
        svg.dot(center, unit * r_outer, &area(CYLINDER, 0.14, 1.4));
        svg.dot(center, unit * r_inner, &format!("fill=\"#fff\" {}", &stroke(CYLINDER, 1.4)[12..]));
        svg.dot(center, 1.8, &format!("fill=\"{FAINT}\""));
        let plane = HalfPlane { origin: [left + 45.0, 495.0], unit: 118.0 };
        plane.axes(&mut svg, 1.98, [0.12, 1.62]);
        plane.region(&mut svg, &root.region, &area(CYLINDER, 0.14, 1.4));
        plane.profile(&mut svg, &ends, &stroke(CURVE, 2.2));
        for (j, (name, ray)) in rays.iter().enumerate() {
            let above = |t: f64| {
                let p = ray.origin + ray.direction * t;
                [center[0] + unit * p.x, center[1] - unit * p.y]
            };
            let visible = [0.1, 3.9];
            svg.arrow(above(visible[0]), above(visible[1]), RAY, 1.2);
            let [x, y] = above(visible[0]);
            svg.text([x - 4.0, y - 7.0], &format!("fill=\"{RAY}\" font-style=\"italic\""), name);
            // In the half plane: a branch of a hyperbola.
            let reach = (1.95_f64.powi(2) - ray.origin.y.powi(2)).max(0.01).sqrt();
            let shown = [2.0 - reach, 2.0 + reach];
            let path = plane.meridian(ray, shown);
            svg.path(path.clone(), false, &stroke(RAY, 1.2));
            if let Some([x, y]) = path.first() {
                let style = format!("fill=\"{RAY}\" font-style=\"italic\"");
                svg.text([x + 6.0, y + 5.0], &style, name);
            }
            for [from, to] in surface.intersection_intervals(ray, 0) {
                let heavy = format!("{} stroke-opacity=\"0.55\"", stroke(RAY, 5.0));
                svg.line(above(from), above(to), &heavy);
                svg.path(plane.meridian(ray, [from, to]), false, &heavy);
                // Its projection on the axis.
                let heights = [from, to].map(|t| ray.origin.z + t * ray.direction.z);
                let beside = |z: f64| {
                    let [x, y] = plane.at(0.0, z);
                    [x - 22.0 + 9.0 * j as f64, y]
                };
                svg.line(beside(heights[0]), beside(heights[1]), &stroke(RAY, 4.0));
                for (t, z) in [from, to].into_iter().zip(heights) {
                    let p = ray.origin + ray.direction * t;
                    let thin = format!("{} stroke-opacity=\"0.5\"", dashed(RAY, 0.6));
                    svg.line(beside(z), plane.at(p.x.hypot(p.y), z), &thin);
                }
            }
            let mut hits = Vec::new();
            surface.all(ray, &mut hits);
            let ring = format!("fill=\"#fff\" stroke=\"{RAY}\" stroke-width=\"2\"");
            for hit in &hits {
                let p = ray.origin + ray.direction * hit.t;
                svg.dot(plane.at(p.x.hypot(p.y), p.z), 3.8, &ring);
                svg.dot(above(hit.t), 3.8, &ring);
            }
        }
    }
    legend(&mut svg, [60.0, 562.0], INK, 2.2, "profile");
    svg.rect([165.0, 551.0], [24.0, 13.0], &area(CYLINDER, 0.14, 1.4));
    svg.text([197.0, 562.0], "", "between the two cylinders of the shell");
    legend(&mut svg, [475.0, 562.0], RAY, 5.0, "intersection interval, and on the axis");
    svg.dot([795.0, 558.0], 3.8, &format!("fill=\"#fff\" stroke=\"{RAY}\" stroke-width=\"2\""));
    svg.text([807.0, 562.0], "", "hit");
    svg.finish()
}

//! The half plane of the profile on paper: r to the right, z upwards.

use rondure::engine::{Region, TreeNode};
use rondure::{Point, Ray, Surface};

use super::{FAINT, stroke};
use crate::svg::{P, Svg};

/// Where the half plane lies on the drawing.
#[derive(Clone, Copy)]
pub(super) struct HalfPlane {
    /// Where r = z = 0 lies.
    pub(super) origin: P,
    /// How long a unit is.
    pub(super) unit: f64,
}

impl HalfPlane {
    pub(super) fn at(&self, r: f64, z: f64) -> P {
        [self.origin[0] + self.unit * r, self.origin[1] - self.unit * z]
    }

    /// The axis of revolution, and the r axis at its foot.
    pub(super) fn axes(&self, svg: &mut Svg, r: f64, z: [f64; 2]) {
        svg.arrow(self.at(0.0, z[0]), self.at(0.0, z[1]), FAINT, 1.0);
        svg.arrow(self.at(0.0, z[0]), self.at(r, z[0]), FAINT, 1.0);
        let style = format!("fill=\"{FAINT}\" font-style=\"italic\"");
        let ([x, y], [u, v]) = (self.at(0.0, z[1]), self.at(r, z[0]));
        svg.text([x - 13.0, y + 10.0], &style, "z");
        svg.text([u - 6.0, v + 16.0], &style, "\u{3c1}");
    }

    /// A part of the polyline.
    pub(super) fn profile(&self, svg: &mut Svg, ends: &[[Point; 2]], style: &str) {
        let mut chain: Vec<Point> = Vec::new();
        for [a, b] in ends {
            if chain.last() != Some(a) {
                svg.path(chain.drain(..).map(|p| self.at(p.r, p.z)), false, style);
                chain.push(*a);
            }
            chain.push(*b);
        }
        svg.path(chain.into_iter().map(|p| self.at(p.r, p.z)), false, style);
    }

    /// The section of a region with the half plane.
    pub(super) fn region(&self, svg: &mut Svg, region: &Region, style: &str) {
        svg.path(outline(region).into_iter().map(|[r, z]| self.at(r, z)), true, style);
    }

    /// The ray's image between two parameters: one branch of a hyperbola.
    pub(super) fn meridian(&self, ray: &Ray, [from, to]: [f64; 2]) -> Vec<P> {
        const STEPS: u32 = 96;
        (0..=STEPS)
            .map(|i| {
                let t = from + (to - from) * f64::from(i) / f64::from(STEPS);
                let p = ray.origin + ray.direction * t;
                self.at(p.x.hypot(p.y), p.z)
            })
            .collect()
    }
}

/// The corners of a region's section. Those of strips and rectangles are not drawn anywhere.
fn outline(region: &Region) -> Vec<[f64; 2]> {
    match *region {
        Region::Cylinder { z: [z0, z1], w } => {
            let [r0, r1] = w.map(f64::sqrt);
            vec![[r0, z0], [r1, z0], [r1, z1], [r0, z1]]
        }
        Region::Cone { z: [z0, z1], slope, offsets: [inner, outer] } => {
            let at = |offset: f64, z: f64| [(slope * z + offset).max(0.0), z];
            vec![at(inner, z0), at(outer, z0), at(outer, z1), at(inner, z1)]
        }
        Region::Strip { .. } | Region::Rectangle { .. } => Vec::new(),
    }
}

/// The ends of the pieces below a node.
pub(super) fn part(surface: &Surface, node: &TreeNode) -> Vec<[Point; 2]> {
    surface.piece_ends().skip(node.first).take(node.count).collect()
}

/// The nodes that hold a whole monotone interval: the topmost ones along which nothing turns.
pub(super) fn intervals(nodes: &[TreeNode]) -> Vec<usize> {
    let mut found = Vec::new();
    let mut end = 0;
    for (i, node) in nodes.iter().enumerate() {
        if node.rising.is_some() && node.first >= end {
            found.push(i);
            end = node.first + node.count;
        }
    }
    found
}

/// A small legend: a line in a style, and what it is.
pub(super) fn legend(svg: &mut Svg, [x, y]: P, color: &str, width: f64, text: &str) {
    svg.line([x, y - 4.0], [x + 24.0, y - 4.0], &stroke(color, width));
    svg.text([x + 32.0, y], "fill=\"#1f2430\"", text);
}

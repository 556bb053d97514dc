//! Figure 4: the shells round one profile, CY, CO and HY.

use rondure::Method;
use rondure::engine::Region;

use super::half_plane::{HalfPlane, intervals};
use super::{CONE, CURVE, CYLINDER, VASE, area, stroke, surface};
use crate::svg::Svg;

pub(super) fn figure() -> String {
    let mut svg = Svg::new(960.0, 600.0);
    let panels = [(Method::Cy, "CY"), (Method::Co, "CO"), (Method::Hy, "HY")];
    for (i, (method, name)) in panels.into_iter().enumerate() {
        let Some(surface) = surface(VASE, method, 160, 2) else { continue };
        let nodes = surface.tree();
        let whole = intervals(&nodes);
        let plane = HalfPlane { origin: [45.0 + 315.0 * i as f64, 515.0], unit: 218.0 };
        plane.axes(&mut svg, 1.15, [-0.05, 2.18]);
        let color = |region: &Region| {
            if matches!(region, Region::Cone { .. }) { CONE } else { CYLINDER }
        };
        for node in nodes.iter().filter(|n| n.depth <= 1) {
            let outline =
                format!("{} stroke-dasharray=\"1.5 3.5\"", stroke(color(&node.region), 1.6));
            plane.region(&mut svg, &node.region, &outline);
        }
        for i in &whole {
            let region = &nodes[*i].region;
            let outline = format!("{} stroke-dasharray=\"6 4\"", area(color(region), 0.07, 1.2));
            plane.region(&mut svg, region, &outline);
        }
        for node in nodes.iter().filter(|n| n.leaf) {
            plane.region(&mut svg, &node.region, &area(color(&node.region), 0.30, 0.9));
        }
        let ends: Vec<_> = surface.piece_ends().collect();
        plane.profile(&mut svg, &ends, &stroke(CURVE, 1.8));
        let [x, _] = plane.at(0.55, 0.0);
        let bold = "text-anchor=\"middle\" font-size=\"15\" font-weight=\"bold\"";
        svg.text([x, 28.0], bold, name);
    }
    for (x, color, text) in [(30.0, CYLINDER, "cylinder shell"), (160.0, CONE, "cone shell")] {
        svg.rect([x, 566.0], [22.0, 13.0], &area(color, 0.30, 0.9));
        svg.text([x + 30.0, 577.0], "", text);
    }
    let gray = "#5b6472";
    let dots = format!("{} stroke-dasharray=\"1.5 3.5\"", stroke(gray, 1.6));
    svg.rect([275.0, 566.0], [22.0, 13.0], &dots);
    svg.text([305.0, 577.0], "", "of the root and its children");
    let dashes = format!("{} stroke-dasharray=\"6 4\"", area(gray, 0.07, 1.2));
    svg.rect([500.0, 566.0], [22.0, 13.0], &dashes);
    svg.text([530.0, 577.0], "", "of a monotone interval");
    svg.rect([700.0, 566.0], [22.0, 13.0], &area(gray, 0.30, 0.9));
    svg.text([730.0, 577.0], "", "of a leaf, a quarter of an interval");
    svg.finish()
}

//! Figure 3: the tree of a profile: grouping nodes above the monotone intervals, refinement nodes
//! below.

use rondure::Method;
use rondure::engine::TreeNode;

use super::half_plane::{HalfPlane, intervals, part};
use super::{FAINT, INK, INTERVALS, VASE, stroke, surface};
use crate::svg::{P, Svg};

pub(super) fn figure() -> String {
    let mut svg = Svg::new(1010.0, 560.0);
    let Some(surface) = surface(VASE, Method::Hy, 40, 1) else { return svg.finish() };
    let nodes = surface.tree();
    let whole = intervals(&nodes);
    let color_of = |node: &TreeNode| {
        let found = whole.iter().position(|i| {
            (nodes[*i].first..nodes[*i].first + nodes[*i].count).contains(&node.first)
        });
        found.map_or(INK, |i| INTERVALS[i % INTERVALS.len()])
    };

    let plane = HalfPlane { origin: [50.0, 500.0], unit: 205.0 };
    plane.axes(&mut svg, 1.2, [-0.06, 2.2]);
    for (n, i) in whole.iter().enumerate() {
        let node = &nodes[*i];
        let (ends, color) = (part(&surface, node), color_of(node));
        plane.profile(&mut svg, &ends, &stroke(color, 2.6));
        for p in ends.iter().flatten() {
            svg.dot(plane.at(p.r, p.z), 2.4, &format!("fill=\"{color}\""));
        }
        if let Some([p, _]) = ends.get(ends.len() / 2) {
            let [x, y] = plane.at(p.r, p.z);
            // Beside the curve; under it where it is level.
            let level = node.rising.is_some_and(|[_, z]| z.is_none());
            let leans_back = node.rising.is_some_and(|[r, _]| r == Some(false));
            let place = match (level, leans_back) {
                (true, _) => [x - 6.0, y + 20.0],
                (_, true) => [x + 10.0, y - 4.0],
                _ => [x + 12.0, y + 12.0],
            };
            let style = format!("fill=\"{color}\" font-weight=\"bold\" font-style=\"italic\"");
            svg.text(place, &style, subscript("C", n + 1));
        }
    }

    // Leaves side by side, every other node above the middle of its children.
    let leaves = nodes.iter().filter(|n| n.leaf).count();
    let (left, width) = (360.0, 620.0);
    let mut next = 0.0;
    let mut x = vec![0.0; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        if node.leaf {
            x[i] = left + width * (next + 0.5) / leaves as f64;
            next += 1.0;
        }
    }
    let children = |i: usize| -> Vec<usize> {
        let below = (i + 1..nodes.len()).take_while(|j| nodes[*j].depth > nodes[i].depth);
        below.filter(|j| nodes[*j].depth == nodes[i].depth + 1).collect()
    };
    for i in (0..nodes.len()).rev() {
        let below = children(i);
        if let [a, b] = below[..] {
            x[i] = 0.5 * (x[a] + x[b]);
        }
    }
    let deepest = nodes.iter().map(|n| n.depth).max().unwrap_or(1).max(1);
    let at = |i: usize| [x[i], 70.0 + 370.0 * nodes[i].depth as f64 / deepest as f64];
    for i in 0..nodes.len() {
        for child in children(i) {
            svg.line(at(i), at(child), &stroke(FAINT, 1.2));
        }
    }
    for (i, node) in nodes.iter().enumerate() {
        let [x, y] = at(i);
        let grouping = node.rising.is_none();
        let color = if grouping { INK } else { color_of(node) };
        if grouping {
            svg.dot([x, y], 9.0, &format!("fill=\"#fff\" stroke=\"{INK}\" stroke-width=\"1.8\""));
        } else {
            let style =
                format!("rx=\"3\" fill=\"{color}\" stroke=\"{color}\" stroke-width=\"1.8\"");
            let pale = if node.leaf { "" } else { " fill-opacity=\"0.25\"" };
            svg.rect([x - 9.0, y - 9.0], [18.0, 18.0], "rx=\"3\" fill=\"#fff\"");
            svg.rect([x - 9.0, y - 9.0], [18.0, 18.0], &format!("{style}{pale}"));
        }
        if let Some(flags) = node.rising {
            let style = format!("text-anchor=\"middle\" font-size=\"11\" fill=\"{color}\"");
            if let Some(n) = whole.iter().position(|j| *j == i) {
                let bold = "text-anchor=\"end\" font-weight=\"bold\" font-style=\"italic\"";
                let place = [x - 13.0, y - 6.0];
                svg.text(place, &format!("{bold} fill=\"{color}\""), subscript("C", n + 1));
            }
            if node.leaf {
                let last = node.first + node.count;
                svg.text([x, y + 24.0], &style, format!("{}\u{2013}{last}", node.first));
                svg.text([x, y + 38.0], &style, format!("\u{3c1}{}", arrow(flags[0])));
                svg.text([x, y + 51.0], &style, format!("z{}", arrow(flags[1])));
            }
        }
    }
    let key = |svg: &mut Svg, [x, y]: P, text: &str| svg.text([x + 16.0, y + 4.0], "", text);
    let circle = format!("fill=\"#fff\" stroke=\"{INK}\" stroke-width=\"1.8\"");
    svg.dot([380.0, 535.0], 7.0, &circle);
    key(&mut svg, [380.0, 535.0], "grouping node");
    let square = format!("rx=\"3\" stroke=\"{INK}\" stroke-width=\"1.5\" fill=\"{INK}\"");
    svg.rect([513.0, 528.0], [14.0, 14.0], &format!("{square} fill-opacity=\"0.25\""));
    key(&mut svg, [520.0, 535.0], "monotone interval C, halved");
    svg.rect([753.0, 528.0], [14.0, 14.0], &square);
    key(&mut svg, [760.0, 535.0], "leaf: its points, how \u{3c1} and z run");
    let bold = "font-size=\"15\" font-weight=\"bold\"";
    svg.text([90.0, 28.0], bold, "profile");
    svg.text([left, 28.0], bold, "tree");
    svg.finish()
}

fn arrow(rising: Option<bool>) -> &'static str {
    match rising {
        Some(true) => "\u{2191}",
        Some(false) => "\u{2193}",
        None => "=",
    }
}

fn subscript(name: &str, n: usize) -> String {
    format!("{name}<tspan dy=\"4\" font-size=\"10\">{n}</tspan>")
}

//! Profiles as POV-Ray's `lathe` takes them: cubic Bézier curves with four control points each.
//!
//! Lines and quadratics are raised to cubics exactly. Arcs become cubics that stay within
//! [`ARC_TOLERANCE`] of them, relative to the larger radius. POV-Ray refuses control points at
//! r < 0, even of curves at r >= 0: those are halved until there are none.

use kurbo::{CubicBez, ParamCurve, Point, QuadBez, Vec2};
use rondure::{Profile, Segment, profile::Arc};

/// How far a cubic may stray from its arc, in larger radii of the ellipse: a hundredth of a pixel
/// of an arc that fills a picture ten thousand pixels high.
pub(crate) const ARC_TOLERANCE: f64 = 1e-6;
/// How often a curve is halved at most: its parts are then points, as far as f64 can tell.
const MOST_HALVINGS: u32 = 52;

/// The whole profile as cubics, in drawing order.
pub(crate) fn cubics(profile: &Profile) -> Vec<CubicBez> {
    let mut all = Vec::new();
    for segment in profile.segments() {
        for cubic in raised(segment) {
            keep_right_of_axis(cubic, MOST_HALVINGS, &mut all);
        }
    }
    all
}

fn raised(segment: &Segment) -> Vec<CubicBez> {
    let point = |p: rondure::Point| Point::new(p.r, p.z);
    match *segment {
        Segment::Line([a, b]) => {
            let (a, b) = (point(a), point(b));
            vec![CubicBez::new(a, a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0), b)]
        }
        Segment::Quadratic([a, b, c]) => vec![QuadBez::new(point(a), point(b), point(c)).raise()],
        Segment::Cubic([a, b, c, d]) => {
            vec![CubicBez::new(point(a), point(b), point(c), point(d))]
        }
        Segment::Arc(arc) => arc_cubics(&arc),
    }
}

fn arc_cubics(arc: &Arc) -> Vec<CubicBez> {
    let curve = kurbo::Arc {
        center: Point::new(arc.center.r, arc.center.z),
        radii: Vec2::new(arc.radii[0], arc.radii[1]),
        start_angle: arc.start_angle,
        sweep_angle: arc.sweep_angle,
        x_rotation: arc.rotation,
    };
    let mut cubics = Vec::new();
    let mut from = Point::new(arc.start.r, arc.start.z);
    curve.to_cubic_beziers(ARC_TOLERANCE * arc.radii[0].max(arc.radii[1]), |a, b, to| {
        cubics.push(CubicBez::new(from, a, b, to));
        from = to;
    });
    if let Some(last) = cubics.last_mut() {
        last.p3 = Point::new(arc.end.r, arc.end.z);
    }
    cubics
}

fn keep_right_of_axis(cubic: CubicBez, halvings: u32, all: &mut Vec<CubicBez>) {
    let outside = [cubic.p0, cubic.p1, cubic.p2, cubic.p3].iter().all(|p| p.x >= 0.0);
    if outside {
        all.push(cubic);
    } else if halvings > 0 {
        let (first, second) = cubic.subdivide();
        keep_right_of_axis(first, halvings - 1, all);
        keep_right_of_axis(second, halvings - 1, all);
    } else {
        let on_axis = |p: Point| Point::new(p.x.max(0.0), p.y);
        let [a, b, c, d] = [cubic.p0, cubic.p1, cubic.p2, cubic.p3].map(on_axis);
        all.push(CubicBez::new(a, b, c, d));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_quadratics_are_raised_exactly() {
        let profile = Profile::from_path_data("M 1 0 L 4 3 Q 5 4 2 6").unwrap();
        let cubics = cubics(&profile);
        for (cubic, segment) in cubics.iter().zip(profile.segments()) {
            for i in 0..=16 {
                let s = f64::from(i) / 16.0;
                let (a, b) = (cubic.eval(s), segment.point(s));
                assert!((a.x - b.r).abs() < 1e-14 && (a.y - b.z).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn arcs_stay_within_the_tolerance() {
        let profile = Profile::from_path_data("M 0 -2 A 2 2 0 0 1 0 2").unwrap();
        let cubics = cubics(&profile);
        assert!(cubics.len() > 2);
        for cubic in cubics {
            for i in 0..=64 {
                let p = cubic.eval(f64::from(i) / 64.0);
                assert!((p.to_vec2().hypot() - 2.0).abs() < 2.0 * ARC_TOLERANCE, "{p:?}");
            }
        }
    }

    #[test]
    fn handles_beyond_the_axis_are_halved_away() {
        let profile = Profile::from_path_data("M 1 0 C -0.2 0 -0.2 1 1 1").unwrap();
        let cubics = cubics(&profile);
        assert!(cubics.len() > 1);
        for c in cubics {
            assert!([c.p0, c.p1, c.p2, c.p3].iter().all(|p| p.x >= 0.0));
        }
    }
}

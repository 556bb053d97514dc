//! Profiles made from others, or from nothing: caps on open ends, and the half circle.

use core::f64::consts::{FRAC_PI_2, PI};

use super::{Arc, Point, Profile, Segment, Subpath};

impl Profile {
    /// The same profile with the ends of open subpaths that are off the axis joined to it by flat caps,
    /// so that every subpath bounds a solid. Closed subpaths stay as they are.
    ///
    /// A cap is a segment of its own, before the first or behind the last of its subpath, and counts
    /// when segments are counted.
    #[must_use]
    pub fn capped(&self) -> Self {
        let cap = |subpath: &Subpath| {
            let mut segments = subpath.segments.clone();
            let (start, end) = (subpath.start(), subpath.end());
            if !subpath.closed {
                let foot = |p: Point| Point::new(0.0, p.z);
                if start.r > 0.0 {
                    segments.insert(0, Segment::Line([foot(start), start]));
                }
                if end.r > 0.0 {
                    segments.push(Segment::Line([end, foot(end)]));
                }
            }
            Subpath { segments, closed: subpath.closed }
        };
        Self { subpaths: self.subpaths.iter().map(cap).collect() }
    }

    /// The half circle of radius 1 about the origin, drawn upwards.
    pub(crate) fn half_circle() -> Self {
        let arc = Arc {
            start: Point::new(0.0, -1.0),
            end: Point::new(0.0, 1.0),
            center: Point::default(),
            radii: [1.0; 2],
            rotation: 0.0,
            start_angle: -FRAC_PI_2,
            sweep_angle: PI,
        };
        Self { subpaths: vec![Subpath { segments: vec![Segment::Arc(arc)], closed: false }] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_half_circle_is_the_one_that_is_drawn() {
        assert_eq!(
            Profile::half_circle(),
            Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap()
        );
    }

    #[test]
    fn caps_reach_the_axis() {
        let draw = |path: &str| Profile::from_path_data(path).unwrap();
        let open = draw("M 0.5 0 Q 1 1 0.7 2 M 0 3 L 1 4 M 1 5 L 2 5 L 2 6 Z");
        assert!(!open.bounds_solid() && open.capped().bounds_solid());
        assert_eq!(
            open.capped(),
            draw("M 0 0 L 0.5 0 Q 1 1 0.7 2 L 0 2 M 0 3 L 1 4 L 0 4 M 1 5 L 2 5 L 2 6 Z")
        );
    }
}

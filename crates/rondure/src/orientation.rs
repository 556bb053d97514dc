//! Which side of a profile is outside.

use crate::piece;
use crate::profile::{Point, Profile, Subpath};

/// For each subpath, 1 if the outside is to the right of the drawing direction (r to the right, z
/// up) and -1 if it is to the left.
///
/// A subpath that bounds a solid runs round it one way or the other, which the sign of its area
/// tells; one that lies within another is the wall of a hollow, and its outside is the hollow's
/// inside. Subpaths that bound no solid have their outside to the right.
pub(crate) fn outward_senses(profile: &Profile) -> Vec<f64> {
    let outlines: Vec<Option<Vec<Point>>> = profile.subpaths().iter().map(outline).collect();
    let sense = |i: usize| {
        let Some(own) = &outlines[i] else { return 1.0 };
        let around = |(j, other): (usize, &Option<Vec<Point>>)| {
            j != i && other.as_ref().is_some_and(|o| winds_around(o, own[0]))
        };
        let hollow = outlines.iter().enumerate().filter(|&o| around(o)).count() % 2 == 1;
        let counterclockwise = area(own) >= 0.0;
        if hollow == counterclockwise { -1.0 } else { 1.0 }
    };
    (0..outlines.len()).map(sense).collect()
}

/// For each subpath, 1 if the outside of the bare curve is to the right of its drawing direction, and -1
/// if it is to the left: what does not lie between the curve and the axis. Subpaths that bound a solid
/// have the outside of that.
pub(crate) fn outward_of_curve(profile: &Profile) -> Vec<f64> {
    let mut senses = outward_senses(profile);
    for (subpath, sense) in profile.subpaths().iter().zip(&mut senses) {
        if !subpath.bounds_solid() {
            let foot = |p: Point| Point::new(0.0, p.z);
            let mut polygon = vec![foot(subpath.start())];
            polygon.extend(along(subpath));
            polygon.push(foot(subpath.end()));
            *sense = if area(&polygon) >= 0.0 { 1.0 } else { -1.0 };
        }
    }
    senses
}

/// A polygon along a subpath that bounds a solid. It need not be close to the curve: only the sense
/// of rotation and which subpath lies within which are read from it.
fn outline(subpath: &Subpath) -> Option<Vec<Point>> {
    subpath.bounds_solid().then(|| along(subpath).collect())
}

fn along(subpath: &Subpath) -> impl Iterator<Item = Point> + '_ {
    const STEPS: u32 = 16;
    let pieces = subpath.segments().iter().flat_map(piece::cut);
    pieces
        .flat_map(|p| (0..STEPS).map(move |i| p.jet(f64::from(i) / f64::from(STEPS)).point))
        .chain([subpath.end()])
}

/// Twice the signed area of the polygon, positive if it runs from r towards z.
fn area(polygon: &[Point]) -> f64 {
    edges(polygon)
        .map(|(a, b)| {
            (a.r - polygon[0].r) * (b.z - polygon[0].z)
                - (b.r - polygon[0].r) * (a.z - polygon[0].z)
        })
        .sum()
}

/// Whether the polygon contains the point, by the even-odd rule.
fn winds_around(polygon: &[Point], p: Point) -> bool {
    edges(polygon)
        .filter(|(a, b)| {
            (a.z > p.z) != (b.z > p.z) && p.r < a.r + (b.r - a.r) * ((p.z - a.z) / (b.z - a.z))
        })
        .count()
        % 2
        == 1
}

fn edges(polygon: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]))
}

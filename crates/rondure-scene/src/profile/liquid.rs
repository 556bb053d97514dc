//! The liquid in a vessel, as a profile: level on top, and all round half way into the wall, so that nothing lies
//! between wall and liquid.
//!
//! The wall fills its place by priority (Schmidt and Budge 2002), so where in it the liquid ends is never seen. It
//! is a polyline beside the wetted part of the vessel's curve:
//!
//! ```text
//! the vessel's curve -> its wetted runs, below the level -> each moved into the wall -> closed by the level
//! ```

use rondure::{
    FillRule, Point, Profile, ProfileError, Segment, Solid, Surface, Vec3, measure::Cavity,
};
use std::sync::Arc;

/// Points on each segment of the vessel.
const STEPS: usize = 24;
/// How far off the curve a place is looked at to find out what lies there, as part of the length of an edge.
const ASIDE: f64 = 1e-3;
/// The places between the vessel's curve and twice the depth at which there must be wall.
const PROBES: u32 = 5;
/// As often a depth or a length that has no room in the wall is halved: a wall that is thinner, by 2^-60, is none.
const HALVINGS: usize = 60;
/// The farthest that a corner is moved, as a multiple of what the edges beside it are.
const MITRE: f64 = 3.0;

/// Why there is no profile of a liquid.
#[derive(Clone, Debug)]
pub(crate) enum NoLiquid {
    /// The vessel has no wall that the liquid could reach into.
    NoWall,
    /// What is wetted does not run from the level or the axis to the level or the axis.
    Intricate,
    Profile(ProfileError),
}

/// A point of the vessel, and how it is reached from the one before.
#[derive(Clone, Copy)]
struct Vertex {
    at: Point,
    /// The unit normal into the wall of the edge to here; `None` if that is not wetted.
    into: Option<Point>,
}

/// The liquid that stands in a vessel up to a level above the cavity's bottom.
pub(crate) fn liquid(
    vessel: &Arc<Surface>,
    cavity: &Cavity,
    level: f64,
) -> Result<Profile, NoLiquid> {
    let solid =
        Solid::from_surface(Arc::clone(vessel), FillRule::NonZero).map_err(|_| NoLiquid::NoWall)?;
    let in_wall = |p: Point| solid.contains(Vec3::new(p.r, 0.0, p.z));
    let mut runs = Vec::new();
    for subpath in vessel.profile().subpaths() {
        runs.extend(wetted(subpath.segments(), cavity, level)?);
    }
    let mut size = 0.0_f64;
    for run in &runs {
        size = run.iter().fold(size, |size, v| size.max(v.at.r));
    }
    // As far into the wall as there is room everywhere, and as much again behind.
    let fits = |depth: f64| {
        let clear = |v: &Vertex, into: Point| {
            let probe = 2.0 * depth / f64::from(PROBES);
            (1..=PROBES).all(|i| in_wall(v.at + into * (probe * f64::from(i))))
        };
        runs.iter().flatten().all(|v| v.at.z >= level || v.into.is_none_or(|into| clear(v, into)))
    };
    let halvings = core::iter::successors(Some(0.5 * size), |depth| Some(0.5 * depth));
    let depth = halvings.take(HALVINGS).find(|depth| fits(*depth)).ok_or(NoLiquid::NoWall)?;
    let mut builder = Profile::builder();
    for run in &runs {
        let points = outline(run, depth, level, in_wall);
        let mut points = points.into_iter();
        let Some(start) = points.next() else { continue };
        builder = builder.move_to(start.r, start.z);
        builder = points.fold(builder, |b, p| b.line_to(p.r, p.z));
        if start.r > 0.0 {
            builder = builder.close();
        }
    }
    builder.build().map_err(NoLiquid::Profile)
}

/// The wetted runs of a subpath.
fn wetted(segments: &[Segment], cavity: &Cavity, level: f64) -> Result<Vec<Vec<Vertex>>, NoLiquid> {
    let mut vertices: Vec<Vertex> = Vec::new();
    for segment in segments {
        if vertices.is_empty() {
            vertices.push(Vertex { at: segment.start(), into: None });
        }
        for [a, b] in steps(segment, level) {
            let from = vertices[vertices.len() - 1].at;
            let mut at = segment.point(b);
            if crosses(segment, [a, b], level) || is_level(at.z, level) {
                at.z = level;
            }
            let edge = at - from;
            if edge.length() == 0.0 {
                continue;
            }
            let normal = Point::new(edge.z, -edge.r) * (1.0 / edge.length());
            let middle = segment.point(0.5 * (a + b));
            let aside = ASIDE * edge.length();
            let wets =
                |sign: f64| middle.z < level && cavity.contains(middle + normal * (sign * aside));
            let into = match [wets(1.0), wets(-1.0)] {
                [true, false] => Some(normal * -1.0),
                [false, true] => Some(normal),
                _ => None,
            };
            vertices.push(Vertex { at, into });
        }
    }
    // A closed subpath begins where it is dry, or there is no such place.
    let closed = vertices.len() > 2 && vertices[0].at == vertices[vertices.len() - 1].at;
    if closed && vertices[1].into.is_some() {
        let dry = (1..vertices.len()).find(|i| vertices[*i].into.is_none());
        let first = dry.ok_or(NoLiquid::Intricate)?;
        vertices.remove(0);
        vertices.rotate_left(first - 1);
        let begin = Vertex { into: None, ..vertices[vertices.len() - 1] };
        vertices.insert(0, begin);
    }
    let mut runs: Vec<Vec<Vertex>> = Vec::new();
    for (before, vertex) in vertices.iter().zip(vertices.iter().skip(1)) {
        if vertex.into.is_none() {
            continue;
        }
        match runs.last_mut().filter(|_| before.into.is_some()) {
            Some(run) => run.push(*vertex),
            None => runs.push(vec![*before, *vertex]),
        }
    }
    for run in &mut runs {
        for (end, beside) in [(0, 1), (run.len() - 1, run.len() - 2)] {
            // A rim that turns at the level is reached but for a step.
            let step = (run[end].at - run[beside].at).length();
            if run[end].at.r > 0.0 {
                if level - run[end].at.z > step {
                    return Err(NoLiquid::Intricate);
                }
                run[end].at.z = level;
            }
        }
    }
    Ok(runs)
}

/// The parameters between which a segment is followed, with one where it passes the level.
fn steps(segment: &Segment, level: f64) -> Vec<[f64; 2]> {
    let mut all = Vec::with_capacity(STEPS + 1);
    for i in 0..STEPS {
        let [a, b] = [i, i + 1].map(|i| i as f64 / STEPS as f64);
        if !crosses(segment, [a, b], level) {
            all.push([a, b]);
            continue;
        }
        let below = segment.point(a).z < level;
        let (mut low, mut high) = (a, b);
        // Halved until nothing lies between.
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (segment.point(middle).z < level) == below { low = middle } else { high = middle }
        }
        all.extend([[a, high], [high, b]]);
    }
    all
}

/// Whether a height is the level but for the rounding of the sum of the bottom's height and the depth, half a unit in the
/// last place of either.
fn is_level(z: f64, level: f64) -> bool {
    (z - level).abs() <= f64::EPSILON * level.abs()
}

fn crosses(segment: &Segment, [a, b]: [f64; 2], level: f64) -> bool {
    (segment.point(a).z < level) != (segment.point(b).z < level)
}

/// A run moved into the wall, and closed by the level: from the axis to the axis, or a ring.
fn outline(run: &[Vertex], depth: f64, level: f64, in_wall: impl Fn(Point) -> bool) -> Vec<Point> {
    let last = run.len() - 1;
    let mut points = Vec::new();
    for (i, vertex) in run.iter().enumerate() {
        // The edges before and behind.
        let edges = [if i == 0 { None } else { vertex.into }, run.get(i + 1).and_then(|v| v.into)];
        let [a, b] = [edges[0].or(edges[1]), edges[1].or(edges[0])].map(Option::unwrap_or_default);
        if vertex.at.r == 0.0 && (i == 0 || i == last) {
            let down = depth * (1.0 / a.z.abs()).min(MITRE);
            let end = Point::new(0.0, vertex.at.z + down.copysign(a.z));
            points.push(end);
        } else if i == 0 || i == last {
            // Along the level, as far as the wall goes.
            let reach = depth * (1.0 / a.r.abs()).min(MITRE);
            let across = |part: f64| Point::new(vertex.at.r + part * reach.copysign(a.r), level);
            let parts =
                core::iter::successors(Some(1.0), |part: &f64| Some(0.5 * part)).take(HALVINGS);
            let free = |part: f64| in_wall(across(part)) && in_wall(across(0.5 * part));
            let end = across(parts.into_iter().find(|part| free(*part)).unwrap_or(0.0));
            points.push(end);
        } else {
            let sum = a + b;
            let length2 = sum.r * sum.r + sum.z * sum.z;
            // Of length 1 / cos of half the turn.
            let scale = (2.0 / length2).min(MITRE / length2.sqrt().max(f64::MIN_POSITIVE));
            let moved = vertex.at + sum * (depth * scale);
            if moved.z < level && moved.r > 0.0 {
                points.push(moved);
            }
        }
    }
    if run[0].at.r > 0.0 && run[last].at.r == 0.0 {
        points.reverse();
    }
    if points.first().is_some_and(|p| p.r == 0.0) && points.last().is_some_and(|p| p.r > 0.0) {
        points.push(Point::new(0.0, level));
    }
    points
}

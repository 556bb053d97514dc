//! What must hold of solids, whatever they are: spans against inside tests, and the laws of sets.

use std::sync::Arc;

use rondure::{
    Affine, Bounds, EngineOptions, FillRule, Hit, Method, Profile, Ray, Solid, Surface, Vec3,
    solid::{Compound, Csg, Face, Span},
};

use crate::{
    Oracle, Random, Tally,
    compare::TANGENCY_BAND,
    laws::{Laws, RAYS_PER_ROUND},
};

/// The fill rules.
pub const RULES: [FillRule; 2] = [FillRule::NonZero, FillRule::EvenOdd];

/// As many failures are told in words.
const TOLD: usize = 10;

/// A solid, or what makes one, that is known to be in order.
///
/// # Panics
///
/// If it is not.
pub fn known<T, E: std::fmt::Display>(made: Result<T, E>) -> T {
    match made {
        Ok(made) => made,
        Err(error) => unreachable!("{error}"),
    }
}

/// The surface on the scalar exact engine, whose hits are those at which spans end, bit for bit.
pub fn scalar_surface(profile: &Profile) -> Arc<Surface> {
    let options = EngineOptions { method: Method::Exact, ..EngineOptions::default() };
    Arc::new(Surface::with_engine(profile, &options))
}

/// Random lines through the solid of a random closed profile, by both rules: spans are ordered,
/// disjoint, end at hits on both sides, and their middles are inside, those of the gaps outside.
pub fn spans(rays: u64, random: &mut Random, tally: &mut Tally) {
    const RAYS_PER_PROFILE: u64 = 200;
    for _ in 0..rays.div_ceil(RAYS_PER_PROFILE) {
        let profile = loop {
            let profile = random.profile();
            if profile.bounds_solid() {
                break profile;
            }
        };
        let oracle = Oracle::new(&profile);
        let surface = scalar_surface(&profile);
        let solids = RULES.map(|rule| known(Solid::from_surface(Arc::clone(&surface), rule)));
        let (mut spans, mut hits) = (Vec::new(), Vec::new());
        for _ in 0..RAYS_PER_PROFILE {
            let ray = random.line(oracle.center(), oracle.size());
            surface.all(&ray, &mut hits);
            tally.rays += 1;
            tally.hits += hits.len() as u64;
            for solid in &solids {
                solid.spans(&ray, &mut spans);
                if let Some(wrong) = wrong_spans(solid, &ray, &spans, &hits, oracle.size()) {
                    match wrong {
                        "open" => tally.odd += 1,
                        _ => tally.inconsistent += 1,
                    }
                    if tally.failures.len() < TOLD {
                        let rule = solid.fill_rule();
                        tally.failures.push(format!("{wrong} {rule:?} {ray:?} {profile:?}"));
                    }
                }
            }
        }
    }
}

/// What is wrong with the spans of a line, in a word.
fn wrong_spans(
    solid: &Solid,
    ray: &Ray,
    spans: &[Span],
    hits: &[Hit],
    size: f64,
) -> Option<&'static str> {
    let ends = || spans.iter().flat_map(|s| [s.enter, s.exit]);
    if ends().any(|end| end.wall.is_none()) {
        return Some("open");
    }
    if !ends().is_sorted_by(|a, b| a.t < b.t) {
        return Some("out of order");
    }
    if ends().any(|end| end.wall.is_some_and(|wall| !hits.contains(&wall.hit))) {
        return Some("not at a hit");
    }
    let ends: Vec<f64> = ends().map(|end| end.t).collect();
    let mut stretches = ends.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).enumerate();
    let wrong = stretches.any(|(i, middle)| {
        let p = ray.at(middle);
        solid.contains(p) != (i % 2 == 0) && !solid_is_thin(solid, p, size)
    });
    wrong.then_some("inside and outside confused")
}

/// Whether the surface passes within rounding of a point.
fn solid_is_thin(solid: &Solid, p: Vec3, size: f64) -> bool {
    let reach = TANGENCY_BAND * size;
    solid.distance(p).abs() < reach || corners_differ(solid, p, reach)
}

/// Whether some corners of a small cube are inside and some are not.
pub fn corners_differ(solid: &Solid, p: Vec3, reach: f64) -> bool {
    let corner = |i: usize| {
        let side = |bit: usize| if i & bit == 0 { -reach } else { reach };
        solid.contains(p + Vec3::new(side(1), side(2), side(4)))
    };
    (1..8).any(|i| corner(i) != corner(0))
}

/// The solid of path data, as it is drawn.
pub fn turned(path: &str) -> Csg {
    let profile = known(Profile::from_path_data(path));
    Csg::turned(Arc::new(known(Solid::new(&profile, FillRule::NonZero))))
}

/// A random solid. If `aligned`, from a few coordinates, so that many faces coincide; size about 2.
pub fn random_solid(random: &mut Random, aligned: bool) -> Csg {
    let mut x = |low: f64, high: f64| {
        let x = random.within(low, high);
        if aligned { (2.0 * x).round() / 2.0 } else { x }
    };
    let (r, z, r1, h) = (x(0.3, 1.2).max(0.5), x(-1.0, 0.0), x(0.3, 1.2).max(0.5), x(0.5, 1.5));
    let corner = Vec3::new(x(-1.5, 0.5), x(-1.5, 0.5), x(-1.5, 0.5));
    let edges = Vec3::new(x(0.5, 2.0), x(0.5, 2.0), x(0.5, 2.0));
    let shift = Vec3::new(x(-0.6, 0.6), x(-0.6, 0.6), x(-0.6, 0.6));
    let solid = match random.below(7) {
        0 => turned(&format!("M 0 {z} H {r} V {} H 0", z + h)),
        1 => turned(&format!("M 0 {z} L {r} {z} L {r1} {} L 0 {}", z + h, z + h)),
        2 => turned(&format!("M 0 {z} H {} V {} H {r} V {} H 0", r + r1, z + 0.5 * h, z + h)),
        3 => {
            let (inner, outer) = (r + r1, r + 3.0 * r1);
            turned(&format!(
                "M {inner} 0 A {r1} {r1} 0 0 1 {outer} 0 A {r1} {r1} 0 0 1 {inner} 0 Z"
            ))
        }
        4 => Csg::sphere(Vec3::ZERO, r),
        5 => Csg::half_space(
            Vec3::new(0.0, 0.0, z),
            [Vec3::X, -Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(1.0, 1.0, 0.0)][random.below(5)],
        ),
        _ => Csg::cuboid(Bounds { min: corner, max: corner + edges }),
    };
    match random.below(4) {
        0 | 1 => solid,
        2 => solid.placed(&Affine::translate(shift)),
        _ if aligned => solid.placed(&Affine::rotate(Vec3::X, core::f64::consts::FRAC_PI_2)),
        _ => {
            let axis = random.direction();
            solid.placed(&Affine::translate(shift).after(&Affine::rotate(axis, shift.x * 5.0)))
        }
    }
}

/// A line through such solids; if `aligned`, now and then along an axis, maybe within faces.
pub fn random_ray(random: &mut Random, aligned: bool) -> Ray {
    let line = random.line(Vec3::ZERO, 3.0);
    if !aligned || random.below(3) > 0 {
        return line;
    }
    let snap = |x: f64| (4.0 * x).round() / 4.0;
    let o = line.origin;
    let direction = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 0.0, 1.0)][random.below(4)];
    Ray::line(Vec3::new(snap(o.x), snap(o.y), snap(o.z)), direction)
}

/// The ends of a compound's spans.
pub fn ends(compound: &Compound, ray: &Ray) -> Vec<[f64; 2]> {
    let mut spans: Vec<Span<Face>> = Vec::new();
    compound.spans(ray, &mut spans);
    spans.iter().map(|s| [s.enter.t, s.exit.t]).collect()
}

/// The [`Laws`] of sets on random solids.
pub fn laws(rays: u64, random: &mut Random, tally: &mut Tally) {
    let mut laws = Laws::default();
    laws.try_on(rays.div_ceil(RAYS_PER_ROUND), random);
    tally.rays += laws.rays;
    for law in &laws.laws {
        tally.hits += 2 * law.spans;
        tally.inconsistent += law.broken;
    }
    let room = TOLD.saturating_sub(tally.failures.len());
    tally.failures.extend(laws.failures.into_iter().take(room));
}

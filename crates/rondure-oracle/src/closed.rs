//! The soak at closed profiles: random and adversarial lines, of which none may have an odd number of hits.
//!
//! Profile i, the rays at it and what is done with them depend on the seed and on i alone, so that threads
//! may take profiles in any order, and a failure can be found again. Of the rays
//!
//! * every one is a line whose hits must be even in number;
//! * some are sent on from one of their hits, with as many hits before them as there is solid around them;
//! * some are read as spans, which have walls at both ends;
//! * some are compared, hit by hit, with the oracle.

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};

use rondure::{
    EngineOptions, FillRule, Hit, Method, Profile, ProfileError, Ray, Segment, Solid, Surface,
    profile::PlaneMap,
};

use crate::{
    Oracle, Random, Tally,
    agree::{Scene, shapes},
    solids::known,
};

/// Rays at one profile, which make up for building it.
const RAYS_PER_PROFILE: u64 = 4000;
/// Every so many rays, one is sent on, and one is read as spans.
const PER_CHECK: u64 = 16;
/// Sizes are from 10^-`DECADES` to 10^`DECADES`.
const DECADES: f64 = 6.0;
/// How far along the axis, in its own size, a profile may lie from the origin.
const FAR: f64 = 1e6;
/// The same for one with arcs, whose centre and ends are rounded there: its ends miss the ellipse by
/// the rounding of their heights, and what lies between is not defined better than that.
const FAR_ARCS: f64 = 100.0;

/// How much is to be done.
#[derive(Clone, Copy, Debug)]
pub struct Soak {
    /// Lines in all.
    pub rays: u64,
    /// How many of them, about, are compared with the oracle.
    pub compared: u64,
    /// Decides all that is random.
    pub seed: u64,
    /// How many threads work.
    pub threads: usize,
    /// What is shot at.
    pub method: Method,
}

/// Shoots at closed profiles; `told` hears now and then what came of those that are done.
///
/// # Errors
///
/// None, as long as the profiles in the repository are sound.
pub fn soak(plan: &Soak, told: &(dyn Fn(&Tally) + Sync)) -> Result<Tally, ProfileError> {
    let fixed = fixed()?;
    let profiles = plan.rays.div_ceil(RAYS_PER_PROFILE);
    let share = plan.compared as f64 / plan.rays.max(1) as f64;
    let (next, total) = (AtomicU64::new(0), Mutex::new(Tally { strict: true, ..Tally::default() }));
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= profiles {
                return;
            }
            let mut tally = Tally { strict: true, ..Tally::default() };
            let rays = RAYS_PER_PROFILE.min(plan.rays - i * RAYS_PER_PROFILE);
            one_profile(&fixed, plan, i, rays, share, &mut tally);
            let mut total = total.lock().unwrap_or_else(PoisonError::into_inner);
            total.add(tally);
            told(&total);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..plan.threads.max(1) {
            scope.spawn(work);
        }
    });
    Ok(total.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// The profile that a failure names.
///
/// # Errors
///
/// None, as long as the profiles in the repository are sound.
pub fn profile(seed: u64, index: u64) -> Result<Profile, ProfileError> {
    Ok(closed_profile(&fixed()?, index, &mut random_at(seed, index)))
}

fn random_at(seed: u64, index: u64) -> Random {
    Random::new(Random::new(seed ^ index.rotate_left(32)).bits())
}

fn fixed() -> Result<Vec<Profile>, ProfileError> {
    Ok(shapes()?.into_iter().map(|s| s.profile).filter(Profile::bounds_solid).collect())
}

fn one_profile(
    fixed: &[Profile],
    plan: &Soak,
    index: u64,
    rays: u64,
    share: f64,
    tally: &mut Tally,
) {
    let &Soak { seed, method, .. } = plan;
    let mut random = random_at(seed, index);
    let profile = closed_profile(fixed, index, &mut random);
    let options = EngineOptions { method, ..EngineOptions::default() };
    let surface = Arc::new(Surface::with_engine(&profile, &options));
    let scene = Scene::new(&surface, &profile);
    let oracle = Oracle::new(&profile);
    let solid = known(Solid::from_surface(Arc::clone(&surface), FillRule::EvenOdd));
    let (mut hits, mut spans) = (Vec::new(), Vec::new());
    for i in 0..rays {
        let ray = if i % 2 == 0 {
            scene.random(i / 2, &mut random)
        } else {
            scene.adversarial(i / 2, &mut random)
        };
        let line = Ray::line(ray.origin, ray.direction);
        let failures = tally.failures.len();
        if random.unit() < share {
            // Now and then with its range.
            let asked = if random.below(4) == 0 { ray } else { line };
            tally.compare(&*surface, &oracle, &asked, true);
        } else {
            surface.all(&line, &mut hits);
            tally.rays += 1;
            tally.hits += hits.len() as u64;
            if hits.len() % 2 == 1 {
                tally.odd += 1;
                tally.fail(|| format!("odd: {line:?}\n  found {hits:?}"));
            }
            if i % PER_CHECK < 2 && !hits.is_empty() {
                let hit = hits[random.below(hits.len())];
                send_on(&surface, &oracle, &line, &hits, &hit, tally);
            }
            if i % PER_CHECK == 2 || i % PER_CHECK == 3 {
                solid.spans(&line, &mut spans);
                if spans.iter().any(|s| s.enter.wall.is_none() || s.exit.wall.is_none()) {
                    tally.odd += 1;
                    tally.fail(|| format!("open span: {line:?}\n  {spans:?}"));
                }
            }
        }
        if tally.failures.len() > failures
            && let Some(last) = tally.failures.last_mut()
        {
            last.push_str(&format!("\n  at closed::profile({seed}, {index})"));
        }
    }
}

/// From this cosine on between normals, a hit beside the place that was left is on the same face of the surface.
/// Otherwise the surface turns within some 1e-14 of its size, as at the tip of a needle, and has no side there that a
/// ray could start from.
const SAME_FACE: f64 = 0.999;

/// Sends a ray on from one of its hits, the same way. It must not hit what it leaves: the same piece, nearby,
/// on the same side of the axis, from the same side of the surface. If it has not as many hits before it as the line
/// has behind that one, the oracle is asked.
fn send_on(
    target: &Surface,
    oracle: &Oracle,
    line: &Ray,
    hits: &[Hit],
    hit: &Hit,
    tally: &mut Tally,
) {
    let at = target.interaction(line, hit);
    let on = at.spawn(line.direction);
    let mut next = Vec::new();
    target.all(&on, &mut next);
    tally.leaving += 1;
    let back = next.first().filter(|n| n.piece == hit.piece).is_some_and(|n| {
        let again = target.interaction(&on, n);
        let sides = again.normal.dot(on.direction) * at.normal.dot(on.direction);
        let along = again.point.x * at.point.x + again.point.y * at.point.y;
        // A hit farther on may be the next of many, with a tangency between.
        let near = n.t * again.normal.dot(on.direction).abs() <= 4.0 * at.error;
        sides > 0.0 && along > 0.0 && near && again.normal.dot(at.normal) > SAME_FACE
    });
    if back {
        tally.stuck += 1;
        tally.fail(|| {
            format!("stuck: {on:?}, from {line:?} at {hit:?}\n  found {next:?}\n  {at:?}")
        });
    } else if next.len() != hits.iter().filter(|h| h.t > hit.t).count() {
        tally.compare(target, oracle, &on, true);
    }
}

/// A profile that bounds a solid: one of the repository, or a random one of cubics, of arcs, of lines, or of
/// all of them; of any size, anywhere on the axis.
fn closed_profile(fixed: &[Profile], index: u64, random: &mut Random) -> Profile {
    loop {
        let profile = match index % 8 {
            0 => Ok(fixed[(index / 8) as usize % fixed.len()].clone()),
            1 | 2 => cubics(random),
            3 | 4 => arcs(random),
            5 | 6 => polyline(random),
            _ => Ok(random.profile()),
        };
        let size = 10f64.powf(random.within(-DECADES, DECADES));
        let map = PlaneMap::scale(size, size);
        let map = if random.below(4) == 0 {
            let far = if has_arcs(&profile) { FAR_ARCS } else { FAR };
            PlaneMap::translate(0.0, size * far * random.within(-1.0, 1.0)).after(&map)
        } else {
            map
        };
        if let Ok(profile) = profile.and_then(|p| p.mapped(&map))
            && profile.bounds_solid()
        {
            return profile;
        }
    }
}

fn has_arcs(profile: &Result<Profile, ProfileError>) -> bool {
    let arcs = |p: &Profile| p.segments().any(|s| matches!(s, Segment::Arc(_)));
    profile.as_ref().is_ok_and(arcs)
}

/// A radius and a height round a ring, or anywhere.
fn point(random: &mut Random, turn: f64) -> [f64; 2] {
    if random.below(8) == 0 {
        return [random.unit(), random.within(-1.0, 1.0)];
    }
    let (sin, cos) = (core::f64::consts::TAU * turn).sin_cos();
    let reach = random.within(0.2, 1.0);
    [(1.0 + reach * cos).max(0.0), reach * sin]
}

/// Closed, or from pole to pole.
fn begin(random: &mut Random) -> ([f64; 2], bool) {
    if random.below(2) == 0 { ([0.0, -1.0], true) } else { (point(random, 0.0), false) }
}

fn cubics(random: &mut Random) -> Result<Profile, ProfileError> {
    let ([r, z], poles) = begin(random);
    let count = 1 + random.below(8);
    let mut path = Profile::builder().move_to(r, z);
    for i in 1..=count {
        let turn = |k: f64| (i as f64 + k) / count as f64;
        let (a, b) = (point(random, turn(-0.7)), point(random, turn(-0.3)));
        let last = i == count && poles;
        let [r, z] = if last { [0.0, 1.0] } else { point(random, turn(0.0)) };
        path = path.cubic_to(a, b, r, z);
    }
    if poles { path } else { path.close() }.build()
}

fn arcs(random: &mut Random) -> Result<Profile, ProfileError> {
    let ([r, z], poles) = begin(random);
    let count = 1 + random.below(6);
    let mut path = Profile::builder().move_to(r, z);
    for i in 1..=count {
        let last = i == count && poles;
        let [r, z] = if last { [0.0, 1.0] } else { point(random, i as f64 / count as f64) };
        let radius = random.within(0.1, 2.0);
        let other = if random.below(2) == 0 { radius } else { random.within(0.1, 2.0) };
        let (large, sweep) = (random.below(4) == 0, random.below(2) == 0);
        path = path.arc_to([radius, other], random.within(-2.0, 2.0), large, sweep, r, z);
    }
    if poles { path } else { path.close() }.build()
}

fn polyline(random: &mut Random) -> Result<Profile, ProfileError> {
    let ([r, z], poles) = begin(random);
    let count = [3, 8, 50, 400][random.below(4)];
    let mut path = Profile::builder().move_to(r, z);
    let mut before = [r, z];
    for i in 1..count {
        let [mut r, mut z] = point(random, i as f64 / count as f64);
        // Level, upright, and points given twice.
        match random.below(8) {
            0 => z = before[1],
            1 => r = before[0],
            2 => [r, z] = before,
            _ => {}
        }
        before = [r, z];
        path = path.line_to(r, z);
    }
    if poles { path.line_to(0.0, 1.0) } else { path.close() }.build()
}

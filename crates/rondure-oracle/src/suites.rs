//! The long comparisons, for tests in small and for the `soak` command in large.

use rondure::{Profile, Ray, Surface};

use crate::{
    ExactLine, Oracle, Random, Tally, closed_form::Solid, compare::Target, oracle::OracleHit,
    profiles::standard,
};

/// Random lines through one surface, against the oracle.
pub fn against_oracle(profile: &Profile, rays: u64, random: &mut Random, tally: &mut Tally) {
    let (surface, oracle) = (Surface::new(profile), Oracle::new(profile));
    let even = profile.bounds_solid();
    for _ in 0..rays {
        let ray = random.line(oracle.center(), oracle.size());
        tally.compare(&surface, &oracle, &ray, even);
    }
}

/// Random lines through a standard profile, against the equation of the solid that it draws.
pub fn against_closed_form(
    name: &str,
    solid: Solid,
    rays: u64,
    random: &mut Random,
    tally: &mut Tally,
) {
    let profile = standard(name);
    let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
    for _ in 0..rays {
        let ray = random.line(oracle.center(), oracle.size());
        let expected = solid
            .hits(&ray)
            .into_iter()
            .map(|t| OracleHit {
                t,
                segment: 0,
                s: 0.0,
                incidence: solid.incidence(&ray, t),
                joint_incidence: 1.0,
                joint_distance: f64::INFINITY,
                changes: 1,
            })
            .collect();
        tally.compare_with(&surface, &oracle, &ExactLine::new(&ray), &ray, true, expected);
    }
}

/// Random lines through a closed surface, of which only the parity is looked at; the oracle is asked
/// about odd counts alone.
pub fn parity(profile: &Profile, rays: u64, random: &mut Random, tally: &mut Tally) {
    let (surface, oracle) = (Surface::new(profile), Oracle::new(profile));
    let mut hits = Vec::new();
    for _ in 0..rays {
        let ray = random.line(oracle.center(), oracle.size());
        Target::all(&surface, &ray, &mut hits);
        tally.rays += 1;
        tally.hits += hits.len() as u64;
        if hits.len() % 2 == 1 {
            tally.compare(&surface, &oracle, &ray, true);
        }
    }
}

/// Random profiles, `rays` lines in all, of which every second is a half line or a stretch with random
/// ends.
pub fn random_profiles(rays: u64, random: &mut Random, tally: &mut Tally) {
    const RAYS_PER_PROFILE: u64 = 50;
    for _ in 0..rays.div_ceil(RAYS_PER_PROFILE) {
        let profile = random.profile();
        let (surface, oracle) = (Surface::new(&profile), Oracle::new(&profile));
        let failures = tally.failures.len();
        for i in 0..RAYS_PER_PROFILE {
            let line = random.line(oracle.center(), oracle.size());
            let speed = line.direction.length();
            let mut end = || random.within(-1.0, 5.0) * oracle.size() / speed;
            let ray = match i % 4 {
                0 => Ray::new(line.origin, line.direction),
                2 => {
                    let (x, y) = (end(), end());
                    line.with_range(x.min(y), x.max(y))
                }
                _ => line,
            };
            tally.compare(&surface, &oracle, &ray, profile.bounds_solid());
        }
        if tally.failures.len() > failures
            && let Some(last) = tally.failures.last_mut()
        {
            last.push_str(&format!("\n  {profile:?}"));
        }
    }
}

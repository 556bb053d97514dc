//! Ends of ranges that are as extreme as the lengths of directions: whatever is asked, hits are in the
//! range, all queries agree, and no hit of the whole line that lies in the range is missing.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::sync::Arc;

use rondure::{
    Affine, EngineOptions, Hit, Hits, Instance, Method, Profile, Ray, RayColumns, Surface, Vec3,
    profile::PlaneMap,
};

const PROFILES: [&str; 4] = [
    "M 0 -1 A 1 1 0 0 1 0 1",
    "M 0 -1 L 1 0 L 0.5 0.25 L 0 1",
    "M 0 -1 C 2 -1 0 1 0 1",
    "M 1 -0.5 C 1.5 -0.5 1.5 0.5 1 0.5 C 0.5 0.5 0.5 -0.5 1 -0.5 Z",
];

fn surfaces() -> Vec<Arc<Surface>> {
    let of = |path: &&str| {
        [Method::Wide, Method::Exact].map(|method| {
            let options = EngineOptions { method, ..EngineOptions::default() };
            let profile = Profile::from_path_data(path).unwrap();
            Arc::new(Surface::with_engine(&profile, &options))
        })
    };
    PROFILES.iter().flat_map(of).collect()
}

/// Lines through the surfaces, from nearby, from afar, and from within.
fn lines() -> Vec<(Vec3, Vec3)> {
    let mut lines = Vec::new();
    for distance in [0.0, 3.0, 1e5, 1e12] {
        for toward in [
            Vec3::new(1.0, 0.1, 0.2),
            Vec3::new(-0.3, 0.2, 1.0),
            Vec3::X,
            -Vec3::Z,
            Vec3::new(1e-162, 2e-162, 1.0),
            Vec3::new(1.0, 0.3, -1e-170),
        ] {
            lines.push((Vec3::new(0.15, 0.07, 0.2) - toward * distance, toward));
        }
    }
    lines
}

/// What both a surface and a placed one answer.
trait Target {
    fn all(&self, ray: &Ray, hits: &mut Vec<Hit>);
    fn closest(&self, ray: &Ray) -> Option<Hit>;
    fn any(&self, ray: &Ray) -> bool;
    fn many(&self, rays: &RayColumns) -> Option<(Hits, Vec<bool>)>;
}

impl Target for Surface {
    fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.all(ray, hits);
    }
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest(ray)
    }
    fn any(&self, ray: &Ray) -> bool {
        self.any(ray)
    }
    fn many(&self, rays: &RayColumns) -> Option<(Hits, Vec<bool>)> {
        let (mut hits, mut any) = (Hits::default(), vec![false; rays.rays().len()]);
        self.closest_of_many(&rays.rays(), &mut hits);
        self.any_of_many(&rays.rays(), &mut any);
        Some((hits, any))
    }
}

impl Target for Instance {
    fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.all(ray, hits);
    }
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest(ray)
    }
    fn any(&self, ray: &Ray) -> bool {
        self.any(ray)
    }
    fn many(&self, _: &RayColumns) -> Option<(Hits, Vec<bool>)> {
        None
    }
}

/// Asks for hits in every range that the awkward ends and the neighbours of hits make.
fn check(target: &impl Target, line: &Ray, reach: f64, found: &mut u64) {
    let mut whole = Vec::new();
    target.all(line, &mut whole);
    assert!(whole.len().is_multiple_of(2), "{line:?} {whole:?}");
    *found += whole.len() as u64;
    let mut ends = vec![
        f64::NEG_INFINITY,
        f64::MIN,
        -f64::MIN_POSITIVE,
        -5e-324,
        0.0,
        5e-324,
        1e-310,
        1.0,
        f64::MAX,
        f64::INFINITY,
    ];
    for hit in &whole {
        ends.extend([hit.t.next_down(), hit.t, hit.t.next_up(), 0.5 * hit.t]);
    }
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let speed = line.direction.max_abs();
    let size = (reach / speed).min(f64::MAX);
    let mut rays = Vec::new();
    for (i, &t_min) in ends.iter().enumerate() {
        for &t_max in &ends[i..] {
            rays.push(line.with_range(t_min, t_max));
        }
    }
    let many = target.many(&rays.iter().collect());
    let mut hits = Vec::new();
    for (number, ray) in rays.iter().enumerate() {
        let inside = |t: f64| ray.t_min <= t && t <= ray.t_max;
        target.all(ray, &mut hits);
        let words = || format!("{ray:?} has {hits:?} of {whole:?}");
        assert!(hits.is_sorted_by(|a, b| a.t <= b.t), "{}", words());
        assert!(hits.iter().all(|h| inside(h.t)), "all out of range: {}", words());
        let closest = target.closest(ray);
        assert!(closest.iter().all(|h| inside(h.t)), "{closest:?} out of range: {}", words());
        // At an end each may decide for itself.
        let near = |t: f64, end: f64| {
            let rounding = 1e-13 * size + 4.0 * f64::EPSILON * t.abs() + 5e-324;
            t == end || (t - end).abs() <= rounding
        };
        let at_end = |t: f64| near(t, ray.t_min) || near(t, ray.t_max);
        let sure = whole.iter().filter(|h| inside(h.t) && !at_end(h.t)).count();
        let may = whole.iter().filter(|h| inside(h.t) || at_end(h.t)).count();
        assert!(sure <= hits.len() && hits.len() <= may, "{sure} to {may}: {}", words());
        let any = target.any(ray);
        if sure > 0 || may == 0 {
            assert_eq!(closest.is_some(), sure > 0, "closest {closest:?}: {}", words());
            assert_eq!(any, sure > 0, "any: {}", words());
        }
        assert_eq!(closest.is_some(), !hits.is_empty(), "closest {closest:?}: {}", words());
        assert_eq!(any, !hits.is_empty(), "any: {}", words());
        if let Some((closest, any)) = &many {
            let closest = closest.get(number);
            assert!(closest.iter().all(|h| inside(h.t)), "batch {closest:?}: {}", words());
            if sure > 0 || may == 0 {
                assert_eq!(closest.is_some(), sure > 0, "batch {closest:?}: {}", words());
                assert_eq!(any[number], sure > 0, "any of batch: {}", words());
            }
        }
    }
}

#[test]
fn ranges_hold_for_directions_of_any_length() {
    let mut found = 0;
    for surface in surfaces() {
        for (origin, toward) in lines() {
            for k in [-1070, -1000, -31, 0, 510, 1021] {
                // In two steps: the powers themselves would overflow.
                let power = |k: i32| 2.0_f64.powi(k / 2) * 2.0_f64.powi(k - k / 2);
                let line = Ray::line(origin, toward * power(k));
                check(&*surface, &line, 2.0 + origin.max_abs(), &mut found);
            }
        }
    }
    assert!(found > 500, "{found}");
}

/// What was to keep a ray all but parallel to the axis from the surface compared squares that had vanished.
#[test]
fn parallel_rays_meet_what_lies_on_their_way() {
    let mut found = 0;
    for surface in surfaces().iter().filter(|s| s.bounds().max.x > 1.3) {
        let turn = Affine::rotate(Vec3::Z, 0.0);
        let placed = Instance::new(Arc::clone(surface), turn).unwrap();
        for tenths in 1..80 {
            let direction = Vec3::new(f64::from(tenths) * 1e-163, 0.0, 1.0);
            let line = Ray::line(Vec3::new(0.0, 1.37, -3.0), direction);
            check(&**surface, &line, 5.0, &mut found);
            check(&placed, &line, 5.0, &mut found);
            let mut hits = Vec::new();
            surface.all(&line, &mut hits);
            assert_eq!(hits.len(), 2, "{line:?}");
        }
    }
    assert!(found > 0);
}

/// Products of four lengths leave the range of an f64 long before the squares do.
#[test]
fn surfaces_of_any_size_have_the_same_hits() {
    let mut hits = Vec::new();
    for path in PROFILES {
        let own = Profile::from_path_data(path).unwrap();
        for (origin, toward) in lines().into_iter().filter(|(o, _)| o.max_abs() < 10.0) {
            let mut counts = Vec::new();
            for k in [0, -330, -250, -90, 90, 250, 330] {
                let size = 2.0_f64.powi(k);
                let profile = own.mapped(&PlaneMap::scale(size, size)).unwrap();
                for method in [Method::Wide, Method::Exact] {
                    let options = EngineOptions { method, ..EngineOptions::default() };
                    let surface = Surface::with_engine(&profile, &options);
                    surface.all(&Ray::line(origin * size, toward), &mut hits);
                    counts.push(hits.len());
                }
            }
            assert!(
                counts.iter().all(|n| *n == counts[0]),
                "{path}: {origin:?} {toward:?} {counts:?}"
            );
        }
    }
}

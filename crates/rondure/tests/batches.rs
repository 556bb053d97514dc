//! Batches answer as single queries do, whatever the surface, the engine and the number of rays.

use std::error::Error;
use std::sync::Arc;

use rondure::{
    Affine, AllHits, EngineOptions, Hit, Hits, Instance, Method, Profile, ProfileError, Ray,
    RayColumns, Surface, Vec3,
};

struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number() - 0.5, self.number() - 0.5, self.number() - 0.5)
    }
}

/// Rays at a surface: most go each their own way, some are alike, some start within, and a few are strange.
fn rays(surface: &Surface, count: usize) -> Vec<Ray> {
    let mut random = Random(count as u64);
    let (center, extent) = (surface.bounds().center(), surface.bounds().extent());
    let size = extent.length();
    let mut last = Ray::new(center, Vec3::X);
    (0..count)
        .map(|i| {
            let v = random.vector();
            let target = center + Vec3::new(v.x * extent.x, v.y * extent.y, v.z * extent.z);
            let origin = match i % 97 {
                0 => center + Vec3::new(0.0, 0.0, 3.0 * size),
                1 => target,
                2 => center + random.vector() * (1e9 * size),
                _ => center + random.vector().normalized() * size,
            };
            let ray = match i % 97 {
                3 => Ray::new(origin, Vec3::ZERO),
                4 => Ray::new(origin, (target - origin) * 1e-30),
                5 => Ray::new(origin, target - origin).with_range(0.9, 1.1),
                // Straight down, on the axis and beside it.
                6 => Ray::new(Vec3::new(0.0, 0.0, origin.z), -Vec3::Z),
                7 => Ray::new(origin, -Vec3::Z),
                60..=90 => Ray::new(last.origin, last.direction + random.vector() * 1e-3),
                _ => Ray::new(origin, target - origin),
            };
            last = ray;
            ray
        })
        .collect()
}

/// As far as rounding may put two answers apart.
fn is_same(instance: &Instance, ray: &Ray, found: &Hit, expected: &Hit) -> bool {
    let slack = 2.0 * instance.interaction(ray, expected).error / ray.direction.length();
    // From afar t is no better than its own last bits.
    let slack = slack + 4.0 * f64::EPSILON * expected.t.abs();
    found.piece == expected.piece && (found.t - expected.t).abs() <= slack
}

/// A surface that stands where it was built, or in the world.
enum Target<'a> {
    Unplaced(&'a Surface),
    Placed(&'a Instance),
}

impl Target<'_> {
    fn ask(&self, rays: &RayColumns, closest: &mut Hits, any: &mut [bool], all: &mut AllHits) {
        let rays = rays.rays();
        match self {
            Self::Unplaced(surface) => {
                surface.closest_of_many(&rays, closest);
                surface.any_of_many(&rays, any);
                surface.all_of_many(&rays, all);
            }
            Self::Placed(instance) => {
                instance.closest_of_many(&rays, closest);
                instance.any_of_many(&rays, any);
                instance.all_of_many(&rays, all);
            }
        }
    }
}

fn check(profile: &Profile, options: &EngineOptions, count: usize) -> Result<usize, String> {
    let surface = Surface::with_engine(profile, options);
    let rays = rays(&surface, count);
    let alone = place(&Arc::new(surface.clone()), Affine::IDENTITY)?;
    Ok(compare(&Target::Unplaced(&surface), &alone, &rays))
}

fn place(surface: &Arc<Surface>, placement: Affine) -> Result<Instance, String> {
    let instance = Instance::new(surface.clone(), placement);
    instance.ok_or_else(|| format!("{placement:?} cannot be inverted"))
}

/// Batches at a target, against single rays at the same surface in the same place; returns how many hits there are.
fn compare(target: &Target<'_>, alone: &Instance, rays: &[Ray]) -> usize {
    let count = rays.len();
    let columns = RayColumns::from_iter(rays);
    // What was in them before is of no matter.
    let mut closest = Hits::default();
    let mut all = AllHits { starts: vec![7; 3], t: vec![1.0], piece: vec![1], s: vec![1.0] };
    let mut any = vec![true; count];
    target.ask(&columns, &mut closest, &mut any, &mut all);
    assert_eq!(all.starts.len(), count + 1);
    assert_eq!([all.t.len(), all.piece.len(), all.s.len()], [all.starts[count]; 3]);
    let mut expected = Vec::new();
    for (i, ray) in rays.iter().enumerate() {
        alone.all(ray, &mut expected);
        let own: Vec<_> = all.of(i).collect();
        assert_eq!(own.len(), expected.len(), "{ray:?}: {own:?} {expected:?}");
        assert!(own.is_sorted_by(|a, b| a.t <= b.t), "{ray:?}: {own:?}");
        for (found, expected) in own.iter().zip(&expected) {
            assert!(is_same(alone, ray, found, expected), "{ray:?}: {found:?} {expected:?}");
        }
        assert_eq!(any[i], !expected.is_empty(), "{ray:?}");
        assert_eq!(any[i], alone.any(ray), "{ray:?}");
        let [found, single] = [closest.get(i), alone.closest(ray)];
        assert_eq!(found.is_some(), single.is_some(), "{ray:?}: {found:?} {single:?}");
        if let (Some(found), Some(single)) = (found, single) {
            assert!(is_same(alone, ray, &found, &single), "{ray:?}: {found:?} {single:?}");
        }
    }
    all.t.len()
}

fn shape(name: &str) -> Result<Profile, Box<dyn Error>> {
    let file = format!("{}/../../profiles/{name}.path", env!("CARGO_MANIFEST_DIR"));
    Ok(Profile::from_path_data(&std::fs::read_to_string(file)?)?)
}

/// A wall with so many waves that its blocks do not all fit into one lot.
fn waves(count: usize) -> Result<Profile, ProfileError> {
    let wave = |i: usize| format!("Q {} {} {} {}", 2 + i % 2, i as f64 + 0.5, 2, i + 1);
    let path: Vec<_> = (0..count).map(wave).collect();
    Profile::from_path_data(&format!("M 2 0 {}", path.join(" ")))
}

#[test]
fn batches_answer_as_single_rays_do() -> Result<(), Box<dyn Error>> {
    let mut profiles = vec![waves(400)?];
    for name in ["vase", "goblet", "pawn", "column", "torus", "sphere", "cone"] {
        profiles.push(shape(name)?);
    }
    for profile in &profiles {
        for method in [Method::Wide, Method::Exact] {
            let options = EngineOptions { method, ..EngineOptions::default() };
            assert!(check(profile, &options, 4000)? > 2000);
        }
    }
    Ok(())
}

#[test]
fn any_number_of_rays_is_a_batch() -> Result<(), Box<dyn Error>> {
    let profile = shape("goblet")?;
    for count in [0, 1, 2, 15, 16, 17, 31, 63, 64, 65, 127, 129, 1000] {
        check(&profile, &EngineOptions::default(), count)?;
    }
    Ok(())
}

/// Moved, turned, mirrored, sheared, flattened, tiny, huge, and far away.
fn placements() -> Vec<Affine> {
    let turn = Affine::rotate(Vec3::new(1.0, -2.0, 0.5), 0.7);
    let shear = Affine {
        columns: [Vec3::X, Vec3::new(0.4, 1.0, 0.0), Vec3::new(-0.2, 0.3, 1.0)],
        ..Affine::IDENTITY
    };
    let at = Affine::translate(Vec3::new(3.0, -2.0, 0.7));
    vec![
        at,
        Affine::translate(Vec3::new(1e6, 0.0, -1e7)),
        at.after(&turn),
        turn.after(&Affine::scale(Vec3::new(-1.0, 1.0, 1.0))),
        at.after(&shear).after(&turn),
        turn.after(&Affine::scale(Vec3::new(1.0, 1.0, 0.05))),
        turn.after(&Affine::scale(Vec3::new(1.0, 1.0, 1e-4))),
        Affine::scale(Vec3::splat(1e-6)).after(&turn),
        Affine::translate(Vec3::splat(1e5)).after(&Affine::scale(Vec3::splat(1e4))),
    ]
}

/// Also rays that come from far beyond the surface's size, alike and not.
#[test]
fn batches_at_placed_surfaces_answer_as_single_rays_do() -> Result<(), Box<dyn Error>> {
    for name in ["vase", "pawn", "column"] {
        let surface = Arc::new(Surface::new(&shape(name)?));
        let mut own = rays(&surface, 3000);
        for i in 0..own.len() / 2 {
            let away = 10.0_f64.powf(1.0 + (i / 50 % 30) as f64 * 0.1);
            let ray = &mut own[2 * i];
            ray.origin = ray.origin - ray.direction * away;
        }
        for placement in placements() {
            let world = own.iter().map(|ray| Ray {
                origin: placement.point(ray.origin),
                direction: placement.vector(ray.direction),
                ..*ray
            });
            let instance = place(&surface, placement)?;
            let hits = compare(&Target::Placed(&instance), &instance, &world.collect::<Vec<_>>());
            assert!(hits > 1000, "{name} {placement:?}: {hits}");
        }
    }
    Ok(())
}

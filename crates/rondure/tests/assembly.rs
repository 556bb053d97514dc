//! The assembly against all its instances one by one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::sync::Arc;

use rondure::{
    Affine, Assembly, Contact, Contacts, Instance, Instances, PlaceErrorKind, Profile, Ray,
    RayColumns, Surface, Vec3,
};

const PATHS: [&str; 4] = [
    include_str!("../../../profiles/vase.path"),
    include_str!("../../../profiles/goblet.path"),
    include_str!("../../../profiles/torus.path"),
    "M 1 0 L 2 0.3",
];

/// Numbers in [-1, 1), the same at every run.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Turned, stretched by 1 / `range` to `range`, every other one sheared, every third mirrored.
    fn placement(&mut self, i: usize, range: f64, spread: f64) -> Affine {
        let size = range.powf(self.number());
        let mut own = Affine::scale(Vec3::new(
            size,
            size * (1.3 + self.number()),
            if i.is_multiple_of(3) { -size } else { size },
        ));
        if i.is_multiple_of(2) {
            own.columns[2] += self.vector() * (0.7 * size);
        }
        let turn = Affine::rotate(self.vector(), 4.0 * self.number());
        let turn = if i.is_multiple_of(5) { Affine::IDENTITY } else { turn };
        Affine::translate(self.vector() * spread).after(&turn.after(&own))
    }
}

struct Scene {
    assembly: Assembly,
    alone: Vec<Instance>,
}

impl Scene {
    fn new(random: &mut Random, count: usize, range: f64, spread: f64, center: Vec3) -> Self {
        let surfaces =
            PATHS.map(|path| Arc::new(Surface::new(&Profile::from_path_data(path).unwrap())));
        let mut instances = Instances::new();
        let shapes = surfaces.each_ref().map(|surface| instances.add_shape(Arc::clone(surface)));
        let mut alone = Vec::new();
        for i in 0..count {
            let placement = Affine::translate(center).after(&random.placement(i, range, spread));
            assert_eq!(instances.place(shapes[i % 4], placement), Ok(i as u32));
            alone.push(Instance::new(Arc::clone(&surfaces[i % 4]), placement).unwrap());
        }
        Self { assembly: Assembly::new(instances).unwrap(), alone }
    }

    fn brute_force(&self, ray: &Ray) -> Vec<Contact> {
        let mut all = Vec::new();
        let mut own = Vec::new();
        for (instance, placed) in (0..).zip(&self.alone) {
            placed.all(ray, &mut own);
            all.extend(own.iter().map(|&hit| Contact { instance, hit }));
        }
        all.sort_by(|a, b| {
            let by_t = a.hit.t.total_cmp(&b.hit.t);
            by_t.then(a.instance.cmp(&b.instance)).then(a.hit.piece.cmp(&b.hit.piece))
        });
        all
    }

    /// Compares all answers for a ray; returns how many hits it has.
    fn check(&self, ray: &Ray) -> usize {
        let expected = self.brute_force(ray);
        let mut hits =
            vec![Contact { instance: 99, hit: rondure::Hit { t: 0.0, piece: 0, s: 0.0 } }];
        self.assembly.all(ray, &mut hits);
        assert_eq!(hits, expected, "{ray:?}");
        let closest = self.assembly.closest(ray);
        assert_eq!(closest.is_some(), !expected.is_empty(), "{ray:?}");
        for (closest, first) in closest.iter().zip(&expected) {
            assert_eq!(closest.instance, first.instance, "{ray:?}");
            assert_eq!(closest.hit.piece, first.hit.piece, "{ray:?}");
            // They come by different ways, each of which may be off by as much.
            let at = self.alone[first.instance as usize].interaction(ray, &first.hit);
            let off = (closest.hit.t - first.hit.t).abs() * ray.direction.length();
            assert!(off <= 2.0 * at.error, "{ray:?}: {closest:?}, {first:?}, off by {off}, {at:?}");
        }
        assert_eq!(self.assembly.any(ray), closest.is_some(), "{ray:?}");
        if let Some(contact) = closest {
            let alone = &self.alone[contact.instance as usize];
            let full = self.assembly.interaction(ray, &contact);
            assert_eq!(full, alone.interaction(ray, &contact.hit));
            let instances = self.assembly.instances();
            let footing = instances.footing(contact.instance, ray, &contact.hit);
            assert_eq!(footing, full.footing());
            let normal = instances.normal(contact.instance, ray, &contact.hit);
            assert_eq!(normal, alone.normal(ray, &contact.hit));
        }
        expected.len()
    }

    /// Compares what many rays meet together with what each of them meets alone; returns how many meet anything.
    fn check_together(&self, rays: &[Ray]) -> usize {
        let columns = RayColumns::from_iter(rays);
        let (mut contacts, mut hits) = (Contacts::default(), vec![true; rays.len()]);
        self.assembly.closest_of_many(&columns.rays(), &mut contacts);
        self.assembly.any_of_many(&columns.rays(), &mut hits);
        for (i, ray) in rays.iter().enumerate() {
            let (own, alone) = (contacts.get(i), self.assembly.closest(ray));
            assert_eq!(own.is_some(), alone.is_some(), "{ray:?}: {own:?} {alone:?}");
            assert_eq!(hits[i], alone.is_some(), "{ray:?}");
            let (Some(own), Some(alone)) = (own, alone) else { continue };
            let at = |met: &Contact| self.assembly.interaction(ray, met).error;
            let off = (own.hit.t - alone.hit.t).abs() * ray.direction.length();
            assert!(off <= 2.0 * (at(&own) + at(&alone)), "{ray:?}: {own:?} {alone:?}");
            let same = (own.instance, own.hit.piece) == (alone.instance, alone.hit.piece);
            assert!(same, "{ray:?}: {own:?} {alone:?}");
        }
        hits.into_iter().filter(|hit| *hit).count()
    }
}

#[test]
fn many_rays_meet_what_each_of_them_meets() {
    let mut random = Random(9);
    let mut hits = 0;
    for (count, range, spread, center) in [
        (1, 1.0, 0.0, Vec3::ZERO),
        (300, 3.0, 9.0, Vec3::ZERO),
        (100, 1e3, 50.0, Vec3::ZERO),
        (60, 3.0, 5.0, Vec3::new(1e6, -3e5, 2e6)),
        (60, 1e-3, 1e-9, Vec3::ZERO),
    ] {
        let scene = Scene::new(&mut random, count, range, spread, center);
        let bounds = scene.assembly.bounds();
        let (middle, extent) = (bounds.center(), bounds.extent());
        let size = extent.max_abs();
        for i in 0..1000_usize {
            let v = random.vector() * 0.5;
            let target = middle + Vec3::new(v.x * extent.x, v.y * extent.y, v.z * extent.z);
            let distance = [0.0, 0.2, 1.0, 3.0, 1e4][i % 5];
            let direction = random.vector();
            if direction.max_abs() < 1e-3 {
                continue;
            }
            let origin = target - direction.normalized() * (distance * size);
            // From all but one place, side by side, or neither; closely, or so widely that they do not go together.
            let (apart, turned) = [(0.0, 0.02), (0.01, 0.0), (1e-3, 1e-3), (0.3, 0.5)][i % 4];
            let rays: Vec<_> = (0..40)
                .map(|k| {
                    let from = origin + random.vector() * (apart * size);
                    let ray = Ray::new(from, direction + random.vector() * turned);
                    match k % 10 {
                        7 => ray.with_range(-0.1 * size, 0.5 * size),
                        8 => ray.with_range(0.4 * size, 1e4 * size),
                        9 => ray.with_range(f64::NAN, 1.0),
                        _ => ray,
                    }
                })
                .collect();
            hits += scene.check_together(&rays);
        }
    }
    assert!(hits > 20_000, "{hits}");
}

#[test]
fn agrees_with_all_instances_one_by_one() {
    let mut random = Random(3);
    let mut hits = 0;
    for (count, range, spread, center) in [
        (1, 1.0, 0.0, Vec3::ZERO),
        (9, 3.0, 3.0, Vec3::ZERO),
        (100, 1e3, 50.0, Vec3::ZERO),
        (100, 1e3, 1e6, Vec3::ZERO),
        (60, 3.0, 5.0, Vec3::new(1e6, -3e5, 2e6)),
        (60, 1e3, 5.0, Vec3::new(-1e12, 1e3, 0.0)),
        (60, 1e-3, 1e-9, Vec3::ZERO),
    ] {
        let scene = Scene::new(&mut random, count, range, spread, center);
        let bounds = scene.assembly.bounds();
        let (middle, extent) = (bounds.center(), bounds.extent());
        for i in 0..3000_usize {
            let v = random.vector() * 0.5;
            let target = if i.is_multiple_of(2) {
                middle + Vec3::new(v.x * extent.x, v.y * extent.y, v.z * extent.z)
            } else {
                scene.alone[i % count].bounds().center()
            };
            let distance = [0.0, 0.1, 1.0, 1e3, 1e6][i % 5] * extent.max_abs();
            let mut direction = random.vector();
            match i % 7 {
                1 => direction.x = 0.0,
                2 => direction = Vec3::new(0.0, -0.0, direction.z),
                3 => direction = Vec3::new(-direction.x.abs(), -0.0, 0.0),
                4 => direction.y *= 1e-12,
                5 => direction.z *= 1e-300,
                _ => {}
            }
            if direction.max_abs() < 1e-3 {
                continue;
            }
            let ray = Ray::new(target - direction.normalized() * distance, direction);
            hits += scene.check(&ray);
            hits += scene.check(&Ray::line(ray.origin, direction * 1e-20));
            hits += scene.check(&ray.with_range(-0.1 * extent.max_abs(), 0.2 * extent.max_abs()));
        }
    }
    assert!(hits > 100_000, "{hits}");
}

#[test]
fn equal_hits_belong_to_the_first_instance() {
    let ball = Surface::new(&Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap());
    let mut instances = Instances::new();
    let ball = instances.add_shape(Arc::new(ball));
    for _ in 0..100 {
        instances.place(ball, Affine::IDENTITY).unwrap();
    }
    let assembly = Assembly::new(instances).unwrap();
    let ray = Ray::new(Vec3::new(0.3, 0.2, -5.0), Vec3::Z);
    assert_eq!(assembly.closest(&ray).map(|c| c.instance), Some(0));
    let mut hits = Vec::new();
    assembly.all(&ray, &mut hits);
    assert_eq!(hits.len(), 200);
    assert!(hits[..100].iter().zip(0..).all(|(c, i)| c.instance == i));
    let mut contacts = Contacts::default();
    assembly.closest_of_many(&RayColumns::from_iter(&[ray; 20]).rays(), &mut contacts);
    assert!((0..20).all(|i| contacts.get(i).map(|c| c.instance) == Some(0)));
}

#[test]
fn nothing_placed_is_nothing_hit() {
    let nothing = Assembly::new(Instances::new()).unwrap();
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    assert_eq!(nothing.closest(&ray), None);
    assert!(!nothing.any(&ray));
    let (columns, mut contacts) = (RayColumns::from_iter(&[ray; 20]), Contacts::default());
    nothing.closest_of_many(&columns.rays(), &mut contacts);
    assert!((0..20).all(|i| contacts.get(i).is_none()));
    let mut hits = [true; 20];
    nothing.any_of_many(&columns.rays(), &mut hits);
    assert_eq!(hits, [false; 20]);
}

#[test]
fn errors_tell_which_instance() {
    let ball = Surface::new(&Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap());
    let mut instances = Instances::new();
    let ball = instances.add_shape(Arc::new(ball));
    instances.place(ball, Affine::IDENTITY).unwrap();
    let flat = Affine::scale(Vec3::new(1.0, 0.0, 2.0));
    let error = instances.place(ball, flat).unwrap_err();
    assert_eq!((error.instance, &error.kind), (1, &PlaceErrorKind::NotInvertible(flat.into())));
    assert_eq!(
        error.to_string(),
        "instance 1: the placement cannot be inverted in f64 arithmetic: it carries x to (1.0, 0.0, 0.0), \
         y to (0.0, 0.0, 0.0), z to (0.0, 0.0, 2.0) and the origin to (0.0, 0.0, 0.0); it must not be \
         flat, and neither it nor its inverse too large"
    );
    let error = instances.place(5, Affine::IDENTITY).unwrap_err();
    assert_eq!(error.to_string(), "instance 1: there is no shape 5, only 1, counted from 0");
    assert_eq!(instances.len(), 1);
}

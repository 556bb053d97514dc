//! Extreme but valid geometry: no panic, closest is the first of all, and lines through closed
//! profiles have an even number of hits.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::sync::Arc;

use rondure::{Affine, FillRule, Instance, Profile, Ray, Solid, Surface, Vec3};

/// Splitmix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From -1 to 1.
    fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    /// 10^-decades to 10^decades, of either sign.
    fn size(&mut self, decades: f64) -> f64 {
        10_f64.powf(decades * self.signed()).copysign(self.signed())
    }

    fn placement(&mut self) -> Affine {
        let stretch = Vec3::new(self.size(6.0), self.size(6.0), self.size(6.0));
        // The condition of two turns round a stretch is that of the stretch.
        let least = stretch.max_abs() * 1e-6;
        let bounded = |x: f64| x.abs().max(least).copysign(x);
        let stretch = Vec3::new(bounded(stretch.x), bounded(stretch.y), bounded(stretch.z));
        let (a, b) = (self.vector(), self.vector());
        let far = self.vector() * self.size(9.0);
        Affine::translate(far)
            .after(&Affine::rotate(a, 3.0 * self.signed()))
            .after(&Affine::scale(stretch))
            .after(&Affine::rotate(b, 3.0 * self.signed()))
    }

    /// A line in the object's own frame, aimed at it in most cases, now and then at a special place.
    fn line(&mut self, reach: f64) -> (Vec3, Vec3) {
        let from = match self.bits() % 8 {
            0 => Vec3::new(0.0, 0.0, self.signed()),
            1 => Vec3::new(1.0, 0.0, 0.0),
            2 => Vec3::ZERO,
            _ => self.vector() * 1.5,
        };
        let along = match self.bits() % 8 {
            0 => Vec3::Z,
            1 => -Vec3::X,
            2 => Vec3::new(0.0, 1.0, 0.0),
            3 => Vec3::new(self.signed(), self.signed(), 1e-17),
            4 => Vec3::new(1e-300, 0.0, 1.0),
            _ => self.vector(),
        };
        (from - along * reach, along)
    }
}

fn profiles() -> Vec<(&'static str, bool, Profile)> {
    let path = |text: &str| Profile::from_path_data(text).unwrap();
    let wave = |n: u32| {
        let mut builder = Profile::builder().move_to(0.0, -1.0);
        for i in 1..n {
            let z = -1.0 + 2.0 * f64::from(i) / f64::from(n);
            builder = builder.line_to(0.6 + 0.3 * (40.0 * z).sin(), z);
        }
        builder.line_to(0.0, 1.0).build().unwrap()
    };
    vec![
        ("line", false, path("M 0.5 -1 L 1 1")),
        ("disk", false, path("M 0 0.25 L 1 0.25")),
        ("two lines", true, path("M 0 -1 L 1 0 L 0 1")),
        ("sphere", true, path("M 0 -1 A 1 1 0 0 1 0 1")),
        ("torus", true, path("M 1 0 A 0.25 0.25 0 0 1 0.5 0 A 0.25 0.25 0 0 1 1 0 Z")),
        ("cubic", true, path("M 0 -1 C 2 -1 0 1 0 1")),
        ("needle", true, path("M 0 -1 L 1e-9 0 L 0 1")),
        ("plate", true, path("M 0 0 L 1 0 L 1 1e-12 L 0 1e-12")),
        ("wave", true, wave(10_000)),
    ]
}

#[test]
fn extreme_placements_and_rays() {
    let mut random = Random(7);
    let (mut found, mut lines) = (0, 0);
    for (name, closed, profile) in profiles() {
        let surface = Arc::new(Surface::new(&profile));
        assert_eq!(closed, profile.bounds_solid(), "{name}");
        for _ in 0..300 {
            let placement = random.placement();
            let instance = Instance::new(Arc::clone(&surface), placement).unwrap();
            let bounds = instance.bounds();
            assert!(bounds.min.is_finite() && bounds.max.is_finite(), "{name} {placement:?}");
            for _ in 0..20 {
                let reach = [0.0, 5.0, 1e3, 1e9][(random.bits() % 4) as usize];
                let (from, along) = random.line(reach);
                let (origin, direction) = (placement.point(from), placement.vector(along));
                let direction = direction * random.size(20.0);
                let ray = Ray::new(origin, direction);
                check(name, closed, &instance, &ray, &mut found);
                lines += 1;
            }
        }
    }
    assert!(found > lines / 4, "{found} of {lines}");
}

fn check(name: &str, closed: bool, instance: &Instance, ray: &Ray, found: &mut u32) {
    let mut hits = Vec::new();
    let line = ray.with_range(f64::NEG_INFINITY, f64::INFINITY);
    instance.all(&line, &mut hits);
    let words = || format!("{name}: {:?} {line:?}: {hits:?}", instance.placement());
    assert!(!closed || hits.len() % 2 == 0, "{}", words());
    assert!(hits.iter().all(|h| h.t.is_finite()), "{}", words());
    assert!(hits.is_sorted_by(|a, b| a.t <= b.t), "{}", words());
    *found += u32::from(!hits.is_empty());
    for range in [[f64::NEG_INFINITY, f64::INFINITY], [0.0, f64::INFINITY], [0.0, 0.0]] {
        let ray = ray.with_range(range[0], range[1]);
        let mut inside = Vec::new();
        instance.all(&ray, &mut inside);
        let closest = instance.closest(&ray);
        assert_eq!(closest.is_some(), !inside.is_empty(), "{} {range:?}", words());
        for (closest, first) in closest.iter().zip(&inside) {
            // They come by different ways, from placements that are all but flat: off by the bound on
            // rounding over the incidence, and by the last places of t.
            let off = instance.interaction(&ray, first).error / ray.direction.length();
            let near = (closest.t - first.t).abs() <= 16.0 * off + 1e-9 * first.t.abs();
            assert!(near, "{} {range:?} {closest:?}", words());
        }
        assert_eq!(closest.is_some(), instance.any(&ray), "{} {range:?}", words());
        for hit in &inside {
            assert!(range[0] <= hit.t && hit.t <= range[1]);
            let at = instance.interaction(&ray, hit);
            assert!(at.point.is_finite() && at.normal.is_finite(), "{} {at:?}", words());
            assert!((at.normal.length() - 1.0).abs() < 1e-9, "{} {at:?}", words());
            assert!(at.error >= 0.0 && at.error.is_finite(), "{} {at:?}", words());
            assert!(at.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{} {at:?}", words());
        }
    }
}

#[test]
fn rays_that_are_not_finite_or_have_no_direction_hit_nothing_and_do_not_panic() {
    let strange = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 5e-324, 0.0, -0.0, 1.0];
    let (mut hits, mut spans) = (Vec::new(), Vec::new());
    for (name, _, profile) in profiles() {
        let surface = Arc::new(Surface::new(&profile));
        let solid = Solid::from_surface(Arc::clone(&surface), FillRule::NonZero).ok();
        for i in 0..strange.len().pow(4) {
            let pick = |k: u32| strange[i / strange.len().pow(k) % strange.len()];
            let origin = Vec3::new(pick(0), 0.1, pick(1));
            let direction = Vec3::new(pick(2), 0.0, pick(3));
            for t_min in [f64::NAN, f64::NEG_INFINITY, 0.0] {
                let ray = Ray { origin, direction, t_min, t_max: f64::INFINITY };
                surface.all(&ray, &mut hits);
                let closest = surface.closest(&ray);
                assert_eq!(closest.is_some(), surface.any(&ray), "{name} {ray:?}");
                let finite = origin.is_finite() && direction.is_finite() && !t_min.is_nan();
                if !finite || direction == Vec3::ZERO {
                    assert!(hits.is_empty() && closest.is_none(), "{name} {ray:?} {hits:?}");
                    if let Some(solid) = &solid {
                        solid.spans(&ray, &mut spans);
                        assert!(spans.is_empty(), "{name} {ray:?} {spans:?}");
                    }
                }
            }
        }
    }
}

/// A point whose distance from the axis is a subnormal number has a direction from it all the same.
#[test]
fn normals_are_unit_vectors_beside_the_axis() {
    let cone = Surface::new(&Profile::from_path_data("M 0 0 L 1 0 L 0 2 Z").unwrap());
    let mut hits = Vec::new();
    for tiny in [1.4e-322, 5e-324, 3e-310, 1e-300] {
        cone.all(&Ray::line(Vec3::Z, Vec3::new(tiny, tiny, 3.25)), &mut hits);
        assert_eq!(hits.len(), 2, "{tiny:e}");
        for hit in &hits {
            let at = cone.interaction(&Ray::line(Vec3::Z, Vec3::new(tiny, tiny, 3.25)), hit);
            assert!((at.normal.length() - 1.0).abs() < 1e-15, "{tiny:e}: {at:?}");
        }
    }
}

//! A profile and rays: all queries agree, and what bounds a solid is hit an even number of times.

use arbitrary::{Result, Unstructured};
use rondure::{
    EngineOptions, FillRule, Hit, Method, Profile, Ray, Solid, Surface, Vec3,
    profile::ProfileBuilder, solid::Span,
};

/// A profile of at most this many segments.
const SEGMENTS: u8 = 12;
/// How far the length of a normal may be from 1: a few roundings make less than a thousandth of that.
const UNIT: f64 = 1e-9;
/// And at most this many rays.
const RAYS: u8 = 6;

/// A profile, drawn by the first bytes, and the rays that the others describe.
pub fn trace(data: &[u8]) {
    let mut bytes = Numbers { source: Unstructured::new(data), used: Vec::new() };
    // The bytes never run out: beyond the last they are zero.
    let _ = shoot(&mut bytes);
}

fn shoot(bytes: &mut Numbers<'_>) -> Result<()> {
    let Ok(profile) = draw(bytes)?.build() else { return Ok(()) };
    let engines = [Method::Wide, Method::Exact].map(|method| {
        Surface::with_engine(&profile, &EngineOptions { method, ..EngineOptions::default() })
    });
    let solids = [FillRule::NonZero, FillRule::EvenOdd].map(|rule| Solid::new(&profile, rule).ok());
    let rays = 1 + bytes.below(RAYS)?;
    for _ in 0..rays {
        let ray = bytes.ray()?;
        for surface in &engines {
            queries(surface, &ray, profile.bounds_solid());
        }
        for solid in solids.iter().flatten() {
            spans(solid, &ray);
            points(solid, ray.origin);
        }
    }
    Ok(())
}

fn queries(surface: &Surface, ray: &Ray, even: bool) {
    let mut hits: Vec<Hit> = Vec::new();
    surface.all(ray, &mut hits);
    assert!(hits.is_sorted_by(|a, b| a.t <= b.t), "out of order: {ray:?} {hits:?}");
    assert!(hits.iter().all(|h| ray.t_min <= h.t && h.t <= ray.t_max), "out of range: {ray:?}");
    assert_eq!(surface.any(ray), !hits.is_empty(), "any and all: {ray:?} {hits:?}");
    let closest = surface.closest(ray);
    assert_eq!(closest.is_some(), !hits.is_empty(), "closest and all: {ray:?} {hits:?}");
    for hit in hits.iter().chain(&closest) {
        assert!((0.0..=1.0).contains(&hit.s), "{ray:?} {hit:?}");
        let at = surface.interaction(ray, hit);
        let unit = (at.normal.length() - 1.0).abs() < UNIT;
        assert!(at.point.is_finite() && unit, "{ray:?} {hit:?} {at:?}");
    }
    if even {
        surface.all(&Ray::line(ray.origin, ray.direction), &mut hits);
        assert_eq!(hits.len() % 2, 0, "odd: {ray:?} {hits:?}");
    }
}

fn spans(solid: &Solid, ray: &Ray) {
    let mut spans: Vec<Span> = Vec::new();
    for line in [*ray, Ray::line(ray.origin, ray.direction)] {
        solid.spans(&line, &mut spans);
        let ends: Vec<f64> = spans.iter().flat_map(|s| [s.enter.t, s.exit.t]).collect();
        assert!(ends.is_sorted_by(|a, b| a < b), "overlapping: {line:?} {spans:?}");
        let inside = |t: &f64| line.t_min <= *t && *t <= line.t_max;
        assert!(ends.iter().all(inside), "out of range: {line:?} {spans:?}");
    }
    let walls = spans.iter().flat_map(|s| [s.enter, s.exit]);
    assert!(walls.into_iter().all(|end| end.wall.is_some()), "no wall: {ray:?} {spans:?}");
}

fn points(solid: &Solid, point: Vec3) {
    let Some(nearest) = solid.nearest(point) else { return };
    assert!(!nearest.distance.is_nan(), "{point:?} {nearest:?}");
    assert_eq!(
        nearest.distance < 0.0,
        solid.contains(point) && nearest.distance != 0.0,
        "{point:?}"
    );
}

/// Numbers from bytes: often such as were there before, or their neighbours.
struct Numbers<'a> {
    source: Unstructured<'a>,
    used: Vec<f64>,
}

impl Numbers<'_> {
    /// A whole number below n.
    fn below(&mut self, n: u8) -> Result<u8> {
        Ok(self.source.arbitrary::<u8>()? % n)
    }

    fn number(&mut self) -> Result<f64> {
        let number = match self.below(8)? {
            0..=2 => f64::from(self.source.arbitrary::<i8>()?) / 16.0,
            3 | 4 => self.earlier()?,
            5 => {
                let steps = i64::from(self.source.arbitrary::<i8>()?);
                f64::from_bits(self.earlier()?.to_bits().wrapping_add_signed(steps))
            }
            6 => self.earlier()? * 2f64.powi(i32::from(self.source.arbitrary::<i8>()?)),
            _ => self.source.arbitrary::<f64>()?,
        };
        self.used.push(number);
        Ok(number)
    }

    fn earlier(&mut self) -> Result<f64> {
        let back = usize::from(self.source.arbitrary::<u8>()?);
        let count = self.used.len();
        Ok(if count == 0 { 1.0 } else { self.used[back % count] })
    }

    fn radius(&mut self) -> Result<f64> {
        self.number().map(f64::abs)
    }

    fn vector(&mut self) -> Result<Vec3> {
        Ok(Vec3::new(self.number()?, self.number()?, self.number()?))
    }

    fn ray(&mut self) -> Result<Ray> {
        let (origin, mut direction) = (self.vector()?, self.vector()?);
        let kind = self.below(4)?;
        if kind & 1 == 1 {
            // Towards the point instead.
            direction = direction - origin;
        }
        let ray = Ray::line(origin, direction);
        Ok(if kind & 2 == 2 { ray.with_range(self.number()?, self.number()?) } else { ray })
    }
}

fn draw(bytes: &mut Numbers<'_>) -> Result<ProfileBuilder> {
    let mut path = Profile::builder();
    let count = 1 + bytes.below(SEGMENTS)?;
    for i in 0..count {
        let kind = if i == 0 { 0 } else { bytes.below(8)? };
        let r = if bytes.below(8)? == 0 { 0.0 } else { bytes.radius()? };
        let z = bytes.number()?;
        path = match kind {
            0 => path.move_to(r, z),
            1..=3 => path.line_to(r, z),
            4 => path.quad_to([bytes.radius()?, bytes.number()?], r, z),
            5 => {
                let controls = [bytes.radius()?, bytes.number()?, bytes.radius()?, bytes.number()?];
                let [a, b, c, d] = controls;
                path.cubic_to([a, b], [c, d], r, z)
            }
            6 => {
                let (radii, flags) = ([bytes.radius()?, bytes.radius()?], bytes.below(8)?);
                let turn = if flags & 4 == 4 { bytes.number()? } else { 0.0 };
                path.arc_to(radii, turn, flags & 1 == 1, flags & 2 == 2, r, z)
            }
            _ => path.close(),
        };
    }
    Ok(if bytes.below(2)? == 0 { path.close() } else { path })
}

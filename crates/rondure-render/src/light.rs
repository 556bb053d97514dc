//! The lights and the sky: where light comes from, as seen from a point.

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use rondure::{
    AreaSampler, Footing, Instance, Interaction, Ray, SurfaceSample, Vec3, numeric::gamma,
};
use rondure_scene::{Light, Sky};

use crate::{
    color::Rgb,
    environment::Environment,
    warp::{self, Frame},
};

/// A light with what sampling it needs worked out.
#[derive(Clone, Debug)]
pub(crate) enum Lamp {
    Point {
        position: Vec3,
        intensity: Rgb,
    },
    Sun {
        direction: Vec3,
        irradiance: Rgb,
    },
    SunDisk {
        frame: Frame,
        light: Rgb,
        cap: f64,
    },
    Disk {
        center: Vec3,
        frame: Frame,
        radius: f64,
        radiance: Rgb,
    },
    Sphere {
        center: Vec3,
        radius: f64,
        radiance: Rgb,
    },
    /// A turned surface that shines on both sides.
    Turned(Box<Shining>),
}

/// The least cosine at which the rounding of a point of a lamp is reckoned along the ray: flatter ones light
/// less than a thousandth, and might reach in front of the place that is lit.
const GRAZING: f64 = 1e-3;

/// A turned surface that shines.
#[derive(Clone, Debug)]
pub(crate) struct Shining {
    instance: Instance,
    sampler: AreaSampler,
    radiance: Rgb,
    /// Its area in the world, about, and the ball round it.
    area: f64,
    center: Vec3,
    radius: f64,
}

impl Shining {
    /// `None` if it has no area.
    pub(crate) fn new(instance: &Instance, radiance: Rgb) -> Option<Self> {
        let sampler = AreaSampler::new(instance.surface())?;
        let bounds = instance.bounds();
        let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
        // The mean of what one point of an even grid stands for.
        const STEPS: u32 = 16;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
        let points = (0..STEPS * STEPS).map(|i| [at(i % STEPS), at(i / STEPS)]);
        let sum: f64 = points.map(|u| 1.0 / instance.sample(&sampler, u).area_pdf).sum();
        let area = sum / f64::from(STEPS * STEPS);
        (area > 0.0 && area.is_finite()).then(|| Self {
            instance: instance.clone(),
            sampler,
            radiance,
            area,
            center,
            radius: half.length(),
        })
    }

    fn at(&self, u: (f64, f64)) -> SurfaceSample {
        self.instance.sample(&self.sampler, [u.0, u.1])
    }

    /// The density by solid angle, seen from a place, with which a point of it is looked for.
    pub(crate) fn pdf(&self, from: Vec3, surface: &Interaction) -> f64 {
        let area_pdf = self.instance.area_pdf(&self.sampler, surface.normal);
        surface.solid_angle_pdf(area_pdf, from)
    }
}

/// Light that could arrive at a point, were nothing in its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Incoming {
    /// The unit direction to where it comes from.
    pub(crate) direction: Vec3,
    /// How far away its source is.
    pub(crate) distance: f64,
    /// The irradiance of a surface that faces it.
    pub(crate) light: Rgb,
    /// The density of the direction by solid angle, of a light whose body can be seen; infinite
    /// for the others.
    pub(crate) pdf: f64,
}

impl Incoming {
    /// The way to the source from the place that it was looked for from, as a ray whose direction is as long as the way. It begins off the
    /// surface there, and so ends at the same point of the source that was meant: with the direction and the distance from the surface it would
    /// end behind it, and the source hide itself.
    #[inline]
    pub(crate) fn way(&self, from: &Footing) -> Ray {
        let ray = from.spawn(self.direction);
        if self.distance == f64::INFINITY {
            return ray;
        }
        let to = from.point + self.direction * self.distance - ray.origin;
        if to.length_squared() > 0.0 {
            Ray::new(ray.origin, to).with_range(0.0, 1.0)
        } else {
            ray.with_range(0.0, 0.0)
        }
    }

    /// The same with a direction of unit length.
    #[inline]
    pub(crate) fn sight(&self, from: &Footing) -> Ray {
        let way = self.way(from);
        if way.t_max != 1.0 {
            return way;
        }
        let length = way.direction.length();
        Ray::new(way.origin, way.direction / length).with_range(0.0, length)
    }
}

impl Lamp {
    pub(crate) fn new(light: &Light) -> Self {
        match *light {
            Light::Point { position, intensity } => {
                Self::Point { position, intensity: intensity.into() }
            }
            Light::Sun { direction, irradiance, angular_radius } => {
                let direction = direction.normalized();
                let irradiance = Rgb::from(irradiance);
                let sin = angular_radius.sin();
                if !(sin * sin > 0.0) {
                    return Self::Sun { direction, irradiance };
                }
                // 1 - cos without cancellation.
                let cap = 2.0 * (0.5 * angular_radius).sin().powi(2);
                // The radiance, irradiance / (pi sin^2), times the solid angle, 2 pi cap, where
                // cap / sin^2 = 1 / (1 + cos).
                let light = irradiance * (2.0 / (1.0 + angular_radius.cos()));
                Self::SunDisk { frame: Frame::new(direction), light, cap }
            }
            Light::Disk { center, normal, radius, radiance } => {
                let frame = Frame::new(normal.normalized());
                Self::Disk { center, frame, radius, radiance: radiance.into() }
            }
            Light::Sphere { center, radius, radiance } => {
                Self::Sphere { center, radius, radiance: radiance.into() }
            }
        }
    }

    /// Whether random numbers choose the place on the light.
    #[inline]
    pub(crate) fn has_extent(&self) -> bool {
        !matches!(self, Self::Point { .. } | Self::Sun { .. })
    }

    /// The radiance of the light's body.
    #[inline]
    pub(crate) fn radiance(&self) -> Rgb {
        match *self {
            Self::Disk { radiance, .. } | Self::Sphere { radiance, .. } => radiance,
            Self::Turned(ref shining) => shining.radiance,
            _ => Rgb::BLACK,
        }
    }

    /// Whether places on it are points of a disk.
    #[inline]
    pub(crate) fn is_disk(&self) -> bool {
        matches!(self, Self::Disk { .. })
    }

    /// Light from a place chosen by `u`; `None` if none comes from there.
    #[inline]
    pub(crate) fn sample(&self, at: Vec3, u: (f64, f64)) -> Option<Incoming> {
        self.sample_at(at, if self.is_disk() { warp::disk(u) } else { u })
    }

    /// The same, but `u` is a point of the unit disk where places on the light [are](Self::is_disk).
    #[inline]
    pub(crate) fn sample_at(&self, at: Vec3, u: (f64, f64)) -> Option<Incoming> {
        match *self {
            Self::Point { position, intensity } => {
                let to_light = position - at;
                let distance2 = to_light.length_squared();
                if !(distance2 > 0.0) {
                    return None;
                }
                let distance = distance2.sqrt();
                let direction = to_light / distance;
                let light = intensity / distance2;
                Some(Incoming { direction, distance, light, pdf: f64::INFINITY })
            }
            Self::Sun { direction, irradiance: light } => {
                Some(Incoming { direction, distance: f64::INFINITY, light, pdf: f64::INFINITY })
            }
            Self::SunDisk { frame, light, cap } => {
                let direction = frame.to_world(warp::cap(u, cap));
                Some(Incoming { direction, distance: f64::INFINITY, light, pdf: f64::INFINITY })
            }
            Self::Disk { center, ref frame, radius, radiance } => {
                let target = center + frame.across(u.0 * radius, u.1 * radius);
                let to_light = target - at;
                // The cosine at the lamp times the distance.
                let facing = -frame.normal().dot(to_light);
                if !(facing > 0.0) {
                    return None;
                }
                let distance = to_light.length();
                let inverse = 1.0 / distance;
                let solid_angle = facing * inverse * (PI * radius * radius) * (inverse * inverse);
                Some(Incoming {
                    direction: to_light * inverse,
                    distance: before(distance, target, at),
                    light: radiance * solid_angle,
                    pdf: 1.0 / solid_angle,
                })
            }
            Self::Sphere { center, radius, radiance } => {
                let (to_center, cap) = visible_cap(center, radius, at);
                let distance = to_center.length();
                let local = warp::cap(u, cap);
                let axis = if distance > 0.0 { to_center / distance } else { Vec3::Z };
                let direction = Frame::new(axis).to_world(local);
                // The near end of the chord, from inside the far one: the distance along it less
                // or plus half its length.
                let sin2 = (1.0 - local.z) * (1.0 + local.z);
                let half = (radius * radius - distance * distance * sin2).max(0.0).sqrt();
                let half = if cap < ALL_ROUND { -half } else { half };
                let reach = distance * local.z + half;
                let solid_angle = TAU * cap;
                Some(Incoming {
                    direction,
                    distance: before(reach, center, at),
                    light: radiance * solid_angle,
                    pdf: 1.0 / solid_angle,
                })
            }
            Self::Turned(ref shining) => {
                let found = shining.at(u);
                let to_light = found.surface.point - at;
                let distance = to_light.length();
                let direction = to_light / distance;
                let pdf = found.surface.solid_angle_pdf(found.area_pdf, at);
                let usable = pdf > 0.0 && pdf.is_finite() && distance > 0.0;
                usable.then(|| Incoming {
                    direction,
                    // Before the surface, by its own rounding seen along the ray.
                    distance: before(distance, found.surface.point, at)
                        - 4.0 * found.surface.error
                            / found.surface.normal.dot(direction).abs().max(GRAZING),
                    light: shining.radiance / pdf,
                    pdf,
                })
            }
        }
    }

    /// How much the lamp lights a place, about, were nothing in the way.
    #[inline]
    pub(crate) fn importance(&self, at: Vec3) -> f64 {
        let spread = |center: Vec3, size: f64| (center - at).length_squared().max(size * size);
        match *self {
            Self::Point { position, intensity } => {
                intensity.luminance() / spread(position, f64::MIN_POSITIVE)
            }
            Self::Sun { irradiance: light, .. } | Self::SunDisk { light, .. } => light.luminance(),
            Self::Disk { center, radius, radiance, .. }
            | Self::Sphere { center, radius, radiance } => {
                radiance.luminance() * PI * radius * radius / spread(center, radius)
            }
            Self::Turned(ref shining) => {
                let size = shining.radius;
                shining.radiance.luminance() * 0.5 * shining.area / spread(shining.center, size)
            }
        }
    }

    /// The density by solid angle with which [`sample`](Self::sample) finds a place on the light's
    /// body that lies in this direction at this distance.
    #[inline]
    pub(crate) fn pdf(&self, at: Vec3, direction: Vec3, distance: f64) -> f64 {
        match *self {
            Self::Disk { frame, radius, .. } => {
                let cos = -frame.normal().dot(direction);
                if cos > 0.0 { distance * distance / (cos * PI * radius * radius) } else { 0.0 }
            }
            Self::Sphere { center, radius, .. } => {
                let (_, cap) = visible_cap(center, radius, at);
                1.0 / (TAU * cap)
            }
            // That of a turned one depends on where it is met.
            Self::Point { .. } | Self::Sun { .. } | Self::SunDisk { .. } | Self::Turned(_) => 0.0,
        }
    }
}

/// A ray of light that leaves a lamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Emitted {
    pub(crate) ray: Ray,
    /// The flux that goes this way, over the density with which it was chosen.
    pub(crate) power: Rgb,
}

/// Light sent out towards a ball.
impl Lamp {
    /// The flux that meets the ball, about, were nothing in the way.
    pub(crate) fn flux_to(&self, center: Vec3, radius: f64) -> Rgb {
        let seen_from = |at: Vec3| TAU * visible_cap(center, radius, at).1;
        match *self {
            Self::Point { position, intensity } => intensity * seen_from(position),
            Self::Sun { irradiance: light, .. } | Self::SunDisk { light, .. } => {
                light * (PI * radius * radius)
            }
            Self::Disk { center: from, frame, radius: r, radiance } => {
                let towards = frame.to_local(center - from);
                // Half hidden behind the plane of the disk, it still gets some.
                let cos = (towards.z + radius).max(0.0) / (towards.length() + radius);
                radiance * (PI * r * r * cos * seen_from(from))
            }
            Self::Sphere { center: from, radius: r, radiance } => {
                radiance * (PI * r * r * seen_from(from))
            }
            Self::Turned(ref shining) => {
                shining.radiance * (0.5 * shining.area * seen_from(shining.center))
            }
        }
    }

    /// Whether its body can be met by a ray.
    #[inline]
    pub(crate) fn has_body(&self) -> bool {
        matches!(self, Self::Disk { .. } | Self::Sphere { .. } | Self::Turned(_))
    }

    /// Whether it sends light from a place of its body this way, of any length: a sphere sends none inwards.
    #[inline]
    pub(crate) fn sends(&self, from: Vec3, way: Vec3) -> bool {
        match *self {
            Self::Sphere { center, .. } => (from - center).dot(way) > 0.0,
            _ => true,
        }
    }

    /// The radiance times this is the power that [`emit`](Self::emit) gives a ray from the place `from` of the lamp's body
    /// towards the ball: cos / (area density x density by solid angle). `facing` is the cosine over the
    /// area density with which places on the body are chosen.
    pub(crate) fn extent_to(
        &self,
        (center, radius): (Vec3, f64),
        (from, direction): (Vec3, Vec3),
        facing: f64,
    ) -> f64 {
        let facing = match *self {
            // Places are looked for by solid angle, but light is sent from all alike.
            Self::Sphere { center: own, radius: r, .. } => {
                let (_, height) = facing_half((own, r), (center, radius));
                TAU * height * r * (from - own).dot(direction).max(0.0)
            }
            _ => facing,
        };
        facing * TAU * visible_cap(center, radius, from).1
    }

    /// A ray towards the ball, from a place chosen by `place`, in a direction chosen by `aim`.
    pub(crate) fn emit(
        &self,
        center: Vec3,
        radius: f64,
        place: (f64, f64),
        aim: (f64, f64),
    ) -> Option<Emitted> {
        // A direction into the cone in which the ball is seen, and its solid angle.
        let towards = |from: Vec3| {
            let (to_center, cap) = visible_cap(center, radius, from);
            let axis = if cap < ALL_ROUND { to_center.normalized() } else { Vec3::Z };
            (Frame::new(axis).to_world(warp::cap(aim, cap)), TAU * cap)
        };
        let parallel = |direction: Vec3, light: Rgb| {
            let (x, y) = warp::disk(place);
            let across = Frame::new(direction).to_world(Vec3::new(x, y, 0.0)) * radius;
            // From beyond all things: the first of them counts. How far that is, the world's size
            // would tell; the ray is a line instead.
            let ray =
                Ray::new(center + across, -direction).with_range(f64::NEG_INFINITY, f64::INFINITY);
            Emitted { ray, power: light * (PI * radius * radius) }
        };
        match *self {
            Self::Point { position, intensity } => {
                let (direction, solid_angle) = towards(position);
                let ray = Ray::new(position, direction);
                Some(Emitted { ray, power: intensity * solid_angle })
            }
            Self::Sun { direction, irradiance } => Some(parallel(direction, irradiance)),
            Self::SunDisk { frame, light, cap } => {
                Some(parallel(frame.to_world(warp::cap(aim, cap)), light))
            }
            Self::Disk { center: from, frame, radius: r, radiance } => {
                let (x, y) = warp::disk(place);
                let from = from + frame.to_world(Vec3::new(x * r, y * r, 0.0));
                let (direction, solid_angle) = towards(from);
                let cos = frame.to_local(direction).z;
                let power = radiance * (PI * r * r * cos * solid_angle);
                (cos > 0.0).then(|| Emitted {
                    ray: leaving(from, frame.to_world(Vec3::Z), direction),
                    power,
                })
            }
            Self::Turned(ref shining) => {
                let found = shining.at(place);
                let (direction, solid_angle) = towards(found.surface.point);
                let cos = found.surface.normal.dot(direction).abs();
                let power = shining.radiance * (cos * solid_angle / found.area_pdf);
                (cos > 0.0).then(|| Emitted { ray: found.surface.spawn(direction), power })
            }
            Self::Sphere { center: from, radius: r, radiance } => {
                let (axis, height) = facing_half((from, r), (center, radius));
                let normal = Frame::new(axis).to_world(warp::cap(place, height));
                let from = from + normal * r;
                let (direction, solid_angle) = towards(from);
                let cos = direction.dot(normal);
                let power = radiance * (TAU * height * r * r * cos * solid_angle);
                (cos > 0.0).then(|| Emitted { ray: leaving(from, normal, direction), power })
            }
        }
    }
}

/// The cap of a sphere from which a ball can be seen, its axis and height as part of the radius: a little more than
/// half, and all if the two are within each other.
fn facing_half((from, r): (Vec3, f64), (center, radius): (Vec3, f64)) -> (Vec3, f64) {
    let to_ball = center - from;
    let distance = to_ball.length();
    if distance > radius + r {
        (to_ball / distance, 1.0 + (radius + r) / distance)
    } else {
        (Vec3::Z, ALL_ROUND)
    }
}

/// A ray from a place on the body of a lamp, which it does not meet.
fn leaving(from: Vec3, normal: Vec3, direction: Vec3) -> Ray {
    Ray::new(from + normal * (gamma(64) * from.max_abs()), direction)
}

/// 1 - cos of the half angle under which a sphere is seen from inside.
const ALL_ROUND: f64 = 2.0;

/// The way to the centre of a sphere and 1 - cos of the half angle under which it is seen.
#[inline]
fn visible_cap(center: Vec3, radius: f64, at: Vec3) -> (Vec3, f64) {
    let to_center = center - at;
    let sin2 = radius * radius / to_center.length_squared();
    // 1 - cos = sin^2 / (1 + cos), without cancellation.
    let cap = if sin2 < 1.0 { sin2 / (1.0 + (1.0 - sin2).sqrt()) } else { ALL_ROUND };
    (to_center, cap)
}

/// The distance less the rounding of its ends, so that what the light is fixed to does not hide it.
#[inline]
fn before(distance: f64, target: Vec3, at: Vec3) -> f64 {
    distance - gamma(32) * (target.max_abs() + at.max_abs() + distance)
}

/// The light of the sky.
#[derive(Clone, Debug)]
pub(crate) enum Heaven {
    Gradient(Gradient),
    Picture(Box<Environment>),
}

impl Heaven {
    pub(crate) fn new(sky: &Sky) -> Self {
        match *sky {
            Sky::Constant { color } => {
                let color = color.into();
                Self::Gradient(Gradient { zenith: color, horizon: color, ground: color })
            }
            Sky::Gradient { zenith, horizon, ground } => Self::Gradient(Gradient {
                zenith: zenith.into(),
                horizon: horizon.into(),
                ground: ground.into(),
            }),
            Sky::Image { ref image, intensity, rotation } => {
                let environment = Environment::new(Arc::clone(image), intensity, rotation);
                Self::Picture(Box::new(environment))
            }
        }
    }

    /// The radiance from a unit direction.
    #[inline]
    pub(crate) fn radiance(&self, direction: Vec3) -> Rgb {
        match self {
            Self::Gradient(gradient) => gradient.radiance(direction),
            Self::Picture(environment) => environment.radiance(direction),
        }
    }

    /// Light from a direction chosen by its luminance; the radiance over the density. `None` if none comes
    /// from there.
    pub(crate) fn sample(&self, u: (f64, f64)) -> Option<Incoming> {
        match self {
            Self::Gradient(gradient) => gradient.sample(u),
            Self::Picture(environment) => environment.sample(u),
        }
    }

    /// The density by solid angle with which [`sample`](Self::sample) finds a direction.
    pub(crate) fn pdf(&self, direction: Vec3) -> f64 {
        match self {
            Self::Gradient(gradient) => gradient.pdf(direction),
            Self::Picture(environment) => environment.pdf(direction),
        }
    }

    /// The radiances between which all others lie.
    pub(crate) fn extremes(&self) -> [Rgb; 3] {
        match self {
            Self::Gradient(Gradient { zenith, horizon, ground }) => [*zenith, *horizon, *ground],
            Self::Picture(environment) => [environment.brightest(); 3],
        }
    }

    pub(crate) fn is_black(&self) -> bool {
        self.extremes().iter().all(|light| light.is_black())
    }

    /// Whether the light may come from some directions very much more than from others.
    pub(crate) fn is_picture(&self) -> bool {
        matches!(self, Self::Picture(_))
    }
}

/// A sky whose radiance goes over from the horizon to the zenith, and to the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gradient {
    zenith: Rgb,
    horizon: Rgb,
    ground: Rgb,
}

impl Gradient {
    #[inline]
    fn radiance(&self, direction: Vec3) -> Rgb {
        let end = if direction.z >= 0.0 { self.zenith } else { self.ground };
        self.horizon.mix(end, direction.z.abs().min(1.0))
    }

    fn sample(&self, u: (f64, f64)) -> Option<Incoming> {
        let [up, down] =
            [self.zenith, self.ground].map(|end| self.horizon.mix(end, 0.5).luminance());
        let sum = up + down;
        if !(sum > 0.0) {
            return None;
        }
        let above = u.0 * sum < up;
        let (u0, end) = if above {
            (u.0 * sum / up, self.zenith)
        } else {
            ((u.0 * sum - up) / down, self.ground)
        };
        // The luminance is a line over the height; its integral, a parabola, is inverted.
        let (a, b) = (self.horizon.luminance(), end.luminance());
        let target = u0.clamp(0.0, 1.0) * (a + b);
        let height = (target / (a + (a * a + (b - a) * target).max(0.0).sqrt())).clamp(0.0, 1.0);
        let radius = ((1.0 - height) * (1.0 + height)).sqrt();
        let (sin, cos) = (TAU * u.1).sin_cos();
        let z = if above { height } else { -height };
        let direction = Vec3::new(radius * cos, radius * sin, z);
        let pdf = self.pdf(direction);
        (pdf > 0.0).then(|| Incoming {
            direction,
            distance: f64::INFINITY,
            light: self.radiance(direction) / pdf,
            pdf,
        })
    }

    fn pdf(&self, direction: Vec3) -> f64 {
        let [up, down] =
            [self.zenith, self.ground].map(|end| self.horizon.mix(end, 0.5).luminance());
        let sum = up + down;
        if sum > 0.0 { self.radiance(direction).luminance() / (TAU * sum) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The irradiance of a surface at `at` that faces `normal`, by the mean of many samples.
    fn irradiance(light: &Light, at: Vec3, normal: Vec3) -> f64 {
        let lamp = Lamp::new(light);
        let n = 256;
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let sum: f64 = (0..n * n)
            .filter_map(|i| lamp.sample(at, (place(i % n), place(i / n))))
            .map(|s| s.light.r * s.direction.dot(normal).max(0.0))
            .sum();
        sum / f64::from(n * n)
    }

    #[test]
    fn irradiances_are_the_closed_forms() {
        let color = [1.0; 3];
        let point = Light::Point { position: Vec3::new(0.0, 0.0, 2.0), intensity: color };
        assert!((irradiance(&point, Vec3::ZERO, Vec3::Z) - 0.25).abs() < 1e-14);
        for angular_radius in [0.0, 1e-160, 1e-9, 0.00465, 0.3] {
            let sun = Light::Sun { direction: Vec3::Z, irradiance: color, angular_radius };
            let found = irradiance(&sun, Vec3::ZERO, Vec3::Z);
            assert!((found - 1.0).abs() < 1e-5, "{angular_radius}: {found}");
        }
        // A disk facing the point: pi r^2 / (r^2 + d^2). A sphere: pi (r / d)^2.
        let (center, radius) = (Vec3::new(0.0, 0.0, 2.0), 0.5);
        let disk = Light::Disk { center, normal: -Vec3::Z, radius, radiance: color };
        let found = irradiance(&disk, Vec3::ZERO, Vec3::Z);
        assert!((found - PI * 0.25 / 4.25).abs() < 1e-5, "{found}");
        let away = Light::Disk { center, normal: Vec3::Z, radius, radiance: color };
        assert_eq!(irradiance(&away, Vec3::ZERO, Vec3::Z), 0.0);
        let sphere = Light::Sphere { center, radius, radiance: color };
        let found = irradiance(&sphere, Vec3::ZERO, Vec3::Z);
        assert!((found - PI * 0.0625).abs() < 1e-6, "{found}");
        // All round: pi, wherever the point is.
        for center in [Vec3::ZERO, Vec3::new(0.1, 0.2, -0.3)] {
            let round = Light::Sphere { center, radius, radiance: color };
            let found = irradiance(&round, Vec3::ZERO, Vec3::Z);
            assert!((found - PI).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn sampled_places_lie_on_the_light() {
        let (center, radius) = (Vec3::new(3.0, -1.0, 2.0), 0.5);
        let lamp = Lamp::new(&Light::Sphere { center, radius, radiance: [1.0; 3] });
        for u in [(0.1, 0.2), (0.999, 0.7), (0.5, 0.5)] {
            let found = lamp.sample(Vec3::ZERO, u).unwrap();
            let place = found.direction * found.distance;
            assert!(((place - center).length() - radius).abs() < 1e-13);
            let inside = center + Vec3::new(0.1, -0.2, 0.3);
            let found = lamp.sample(inside, u).unwrap();
            let place = inside + found.direction * found.distance;
            assert!(((place - center).length() - radius).abs() < 1e-13);
        }
    }

    #[test]
    fn sky_is_mixed_by_the_sine_of_the_height() {
        let sky =
            Heaven::new(&Sky::Gradient { zenith: [1.0; 3], horizon: [0.5; 3], ground: [0.0; 3] });
        let at = |z: f64| sky.radiance(Vec3::new((1.0 - z * z).sqrt(), 0.0, z)).g;
        assert_eq!((at(1.0), at(0.5), at(0.0), at(-0.5), at(-1.0)), (1.0, 0.75, 0.5, 0.25, 0.0));
    }
}

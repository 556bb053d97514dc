//! Rays for the comparison of engines: random ones, and all that engines find hard.

use core::f64::consts::TAU;

use rondure::{Bounds, Hit, Point, Profile, Ray, Segment, Surface, Vec3};

use crate::Random;

/// How many kinds of random rays there are; ray i is of the kind i modulo this.
pub const RANDOM_KINDS: u64 = 8;
/// The same for adversarial rays.
pub const ADVERSARIAL_KINDS: u64 = 15;

/// Half the height of a camera's picture over its distance: 23 degrees.
const HALF_PICTURE: f64 = 0.424;
/// How many times its radius a far ray's origin lies from a shape.
const FAR: f64 = 1e6;

/// A shape as those who shoot at it see it.
#[derive(Debug)]
pub struct Scene<'a> {
    surface: &'a Surface,
    segments: Vec<Segment>,
    joints: Vec<Point>,
    bounds: Bounds,
    /// The middle of the bounding box.
    pub center: Vec3,
    /// The radius of the sphere round the surface about its centre.
    pub radius: f64,
}

impl<'a> Scene<'a> {
    /// `surface` answers what must be known to aim: where hits are.
    pub fn new(surface: &'a Surface, profile: &Profile) -> Self {
        let bounds = surface.bounds();
        Self {
            surface,
            segments: profile.segments().copied().collect(),
            joints: surface.piece_ends().flatten().collect(),
            bounds,
            center: bounds.center(),
            radius: bounds.max.x.hypot(0.5 * bounds.extent().z),
        }
    }

    /// A ray as pictures need it.
    pub fn random(&self, i: u64, random: &mut Random) -> Ray {
        match i % RANDOM_KINDS {
            0 | 1 => self.towards_box(random),
            2 => Ray::new(self.in_box(random), random.direction()),
            3 => {
                let away = random.direction();
                self.secondary(random, |_| away, f64::INFINITY)
            }
            4 => {
                let light = self.around(random, 4.0);
                self.secondary(random, |point| light - point, 1.0)
            }
            5 => self.camera(random),
            6 => {
                let line = self.towards_box(random);
                let (a, b) = (random.within(-0.5, 2.5), random.within(-0.5, 2.5));
                line.with_range(a.min(b), a.max(b))
            }
            _ => {
                let ray = self.towards_box(random);
                self.ended_between_hits(ray, random)
            }
        }
    }

    /// A ray of the degenerate kinds: see the arms.
    pub fn adversarial(&self, i: u64, random: &mut Random) -> Ray {
        let kind = i % ADVERSARIAL_KINDS;
        let line = match kind {
            0 => self.parallel(random),
            1 => self.on_axis(random),
            2 => self.nearly_parallel(random),
            3 => self.level(0.0, random),
            4 => {
                let tilt = 10f64.powf(random.within(-320.0, -2.0));
                self.level(tilt, random)
            }
            5 => self.through_axis(random),
            6 => self.at_joint(random),
            7 | 8 => self.tangent(random),
            9 => return self.leaving_surface(random),
            10 => self.far_off(random),
            11 => {
                let line = self.towards_box(random);
                let length = 10f64.powf(random.within(-150.0, 150.0)) / line.direction.length();
                Ray::line(line.origin, line.direction * length)
            }
            12 => self.at_pole(random),
            13 => {
                let other = random.bits();
                let kind = [0, 2, 3, 4, 5, 6, 7, 10][(other % 8) as usize];
                let base = self.adversarial(kind, random);
                return self.ended_at_hits(base, random);
            }
            _ => {
                // Two at once: of another kind, and from far off or with a direction of odd length.
                let kind = random.bits() % 8;
                let base = self.adversarial(kind, random);
                if random.below(2) == 0 {
                    let steps = FAR * self.radius / base.direction.length();
                    Ray::line(base.origin - base.direction * steps, base.direction)
                } else {
                    let power = 2f64.powi(random.below(800) as i32 - 400);
                    Ray::line(base.origin, base.direction * power)
                }
            }
        };
        if random.below(3) == 0 { Ray::new(line.origin, line.direction) } else { line }
    }

    /// From the sphere round the bounding box to a point in the box, which t = 1 reaches.
    fn towards_box(&self, random: &mut Random) -> Ray {
        let origin = self.center + random.direction() * (0.5 * self.bounds.extent().length());
        Ray::new(origin, self.in_box(random) - origin)
    }

    fn in_box(&self, random: &mut Random) -> Vec3 {
        let (e, v) = (self.bounds.extent(), random.cube() * 0.5);
        self.center + Vec3::new(e.x * v.x, e.y * v.y, e.z * v.z)
    }

    /// A point outside, up to so many radii away.
    fn around(&self, random: &mut Random, radii: f64) -> Vec3 {
        self.center + random.direction() * (self.radius * random.within(1.1, radii))
    }

    /// A ray that leaves the surface as a renderer's would.
    fn secondary(&self, random: &mut Random, to: impl Fn(Vec3) -> Vec3, t_max: f64) -> Ray {
        let ray = self.towards_box(random);
        let Some(hit) = self.surface.closest(&ray) else { return ray };
        let interaction = self.surface.interaction(&ray, &hit);
        interaction.spawn(to(interaction.point)).with_range(0.0, t_max)
    }

    fn camera(&self, random: &mut Random) -> Ray {
        let eye = self.around(random, 4.0);
        let forward = (self.center - eye).normalized();
        let (right, up) = forward.orthonormal_basis();
        let (x, y) = (random.within(-1.3, 1.3), random.within(-1.0, 1.0));
        Ray::new(eye, forward + right * (x * HALF_PICTURE) + up * (y * HALF_PICTURE))
    }

    fn hits(&self, ray: &Ray) -> Vec<Hit> {
        let mut hits = Vec::new();
        self.surface.all(ray, &mut hits);
        hits
    }

    fn ended_between_hits(&self, ray: Ray, random: &mut Random) -> Ray {
        let hits = self.hits(&Ray::line(ray.origin, ray.direction));
        if hits.len() < 2 {
            return ray.with_range(0.0, random.within(0.0, 2.0));
        }
        let mut between = || {
            let i = random.below(hits.len() - 1);
            hits[i].t + random.unit() * (hits[i + 1].t - hits[i].t)
        };
        let (a, b) = (between(), between());
        ray.with_range(a.min(b), a.max(b))
    }

    /// With one or both ends of the range at a hit, as it is reported, or a unit in the last place beside.
    fn ended_at_hits(&self, ray: Ray, random: &mut Random) -> Ray {
        let hits = self.hits(&Ray::line(ray.origin, ray.direction));
        if hits.is_empty() {
            return ray;
        }
        let mut end = || {
            let t = hits[random.below(hits.len())].t;
            [t, t.next_up(), t.next_down()][random.below(3)]
        };
        let (a, b) = (end(), end());
        match random.below(4) {
            0 => ray.with_range(a, f64::INFINITY),
            1 => ray.with_range(f64::NEG_INFINITY, a),
            2 => ray.with_range(a.min(b), a.max(b)),
            _ => ray.with_range(a, a),
        }
    }

    fn joint(&self, random: &mut Random) -> Point {
        self.joints[random.below(self.joints.len())]
    }

    fn on_profile(&self, random: &mut Random) -> Point {
        self.segments[random.below(self.segments.len())].point(random.unit())
    }

    /// A radius and height worth aiming at: of a joint, exactly or all but, or anywhere on the profile.
    fn mark(&self, random: &mut Random) -> Point {
        let nudge = |x: f64, random: &mut Random| match random.below(6) {
            0 => x.next_up(),
            1 => x.next_down(),
            2 => x + self.radius * 10f64.powf(random.within(-17.0, -6.0)),
            _ => x,
        };
        let mark = if random.below(4) == 0 { self.on_profile(random) } else { self.joint(random) };
        Point::new(nudge(mark.r, random), nudge(mark.z, random))
    }

    /// A point swept by a point of the profile; in the plane y = 0 now and then, where nothing is rounded.
    fn swept(&self, p: Point, random: &mut Random) -> Vec3 {
        match random.below(4) {
            0 => Vec3::new(p.r, 0.0, p.z),
            1 => Vec3::new(0.0, -p.r, p.z),
            _ => {
                let (sin, cos) = (TAU * random.unit()).sin_cos();
                Vec3::new(p.r * cos, p.r * sin, p.z)
            }
        }
    }

    /// A line through a point, from a few radii away or, every fourth time, from the point itself.
    fn through(&self, point: Vec3, direction: Vec3, random: &mut Random) -> Ray {
        let back = if random.below(4) == 0 { 0.0 } else { random.within(0.5, 4.0) };
        let steps = back * self.radius / direction.length();
        Ray::line(point - direction * steps, direction)
    }

    fn sign(random: &mut Random) -> f64 {
        if random.below(2) == 0 { 1.0 } else { -1.0 }
    }

    fn parallel(&self, random: &mut Random) -> Ray {
        let mark = self.mark(random);
        let point = self.swept(mark, random);
        let d = Vec3::new(0.0, -0.0, Self::sign(random) * random.within(0.5, 2.0));
        self.through(point, d, random)
    }

    fn on_axis(&self, random: &mut Random) -> Ray {
        let z = self.center.z + random.within(-2.0, 2.0) * self.radius;
        let zero = [0.0, -0.0][random.below(2)];
        Ray::line(
            Vec3::new(zero, 0.0, z),
            Vec3::new(0.0, zero, Self::sign(random) * random.within(0.5, 2.0)),
        )
    }

    fn nearly_parallel(&self, random: &mut Random) -> Ray {
        let tilt = 10f64.powf(random.within(-300.0, -3.0));
        let d = random.direction();
        let d = Vec3::new(d.x * tilt, d.y * tilt, Self::sign(random));
        let mark = self.mark(random);
        let point = match random.below(4) {
            0 => Vec3::new(0.0, 0.0, mark.z),
            _ => self.swept(mark, random),
        };
        self.through(point, d, random)
    }

    /// Perpendicular to the axis but for a tilt.
    fn level(&self, tilt: f64, random: &mut Random) -> Ray {
        let mark = self.mark(random);
        let (sin, cos) = (TAU * random.unit()).sin_cos();
        let d = match random.below(3) {
            0 => Vec3::new(1.0, 0.0, 0.0),
            _ => Vec3::new(cos, sin, 0.0),
        };
        let d = Vec3 { z: Self::sign(random) * tilt, ..d * random.within(0.5, 2.0) };
        // Where it passes the axis: at any distance, on it, or all but touching the circle.
        let miss = match random.below(4) {
            0 => 0.0,
            1 => mark.r,
            2 => mark.r * (1.0 - 10f64.powf(random.within(-17.0, -3.0))),
            _ => mark.r * random.within(0.0, 1.0),
        };
        let across = Vec3::new(-d.y, d.x, 0.0).normalized() * miss;
        let point = Vec3 { z: mark.z, ..across };
        self.through(point, d, random)
    }

    fn through_axis(&self, random: &mut Random) -> Ray {
        let d = random.direction();
        let d = if random.below(2) == 0 { Vec3 { y: 0.0, ..d } } else { d };
        let mark = self.mark(random);
        self.through(Vec3::new(0.0, 0.0, mark.z), d, random)
    }

    fn at_joint(&self, random: &mut Random) -> Ray {
        let joint = self.joint(random);
        let point = self.swept(joint, random);
        let d = if random.below(3) == 0 {
            // Towards another joint: along an edge, now and then.
            let other = self.joint(random);
            self.swept(other, random) - point
        } else {
            random.direction()
        };
        if d == Vec3::ZERO { self.on_axis(random) } else { self.through(point, d, random) }
    }

    fn at_pole(&self, random: &mut Random) -> Ray {
        let poles: Vec<_> = self.joints.iter().filter(|p| p.r == 0.0).collect();
        if poles.is_empty() {
            return self.through_axis(random);
        }
        let pole = poles[random.below(poles.len())];
        let off = [0.0, 1e-300, 1e-17, 1e-12, 1e-6][random.below(5)] * self.radius;
        let d = random.direction();
        self.through(Vec3::new(off, 0.0, pole.z), d, random)
    }

    /// A point of the surface and the normal there.
    fn place(&self, random: &mut Random) -> (Vec3, Vec3) {
        if random.below(2) == 0 {
            for _ in 0..8 {
                let ray = self.towards_box(random);
                if let Some(hit) = self.surface.closest(&ray) {
                    let found = self.surface.interaction(&ray, &hit);
                    return (found.point, found.normal);
                }
            }
        }
        // Differences will do: what they leave is a small perturbation.
        const STEP: f64 = 1e-6;
        let segment = &self.segments[random.below(self.segments.len())];
        let s = [0.0, 1.0, 0.5, random.unit(), random.unit()][random.below(5)];
        let (p, a, b) = (
            segment.point(s),
            segment.point((s - STEP).max(0.0)),
            segment.point((s + STEP).min(1.0)),
        );
        let (sin, cos) = (TAU * random.unit()).sin_cos();
        let (dr, dz) = (b.r - a.r, b.z - a.z);
        let normal = Vec3::new(dz * cos, dz * sin, -dr).normalized();
        let normal = if normal.is_finite() { normal } else { Vec3::X };
        (Vec3::new(p.r * cos, p.r * sin, p.z), normal)
    }

    /// 0, a unit in the last place, or more up to 1e-6.
    fn perturbation(random: &mut Random) -> f64 {
        match random.below(4) {
            0 => 0.0,
            1 => Self::sign(random) * f64::EPSILON,
            _ => Self::sign(random) * 10f64.powf(random.within(-16.0, -6.0)),
        }
    }

    fn tangent(&self, random: &mut Random) -> Ray {
        let (point, normal) = self.place(random);
        let (u, v) = normal.orthonormal_basis();
        let (sin, cos) = match random.below(6) {
            // Along the parallel and along the meridian.
            0 => return self.tangent_along(point, normal, Vec3::Z.cross(normal), random),
            1 => {
                let parallel = Vec3::Z.cross(normal);
                return self.tangent_along(point, normal, normal.cross(parallel), random);
            }
            _ => (TAU * random.unit()).sin_cos(),
        };
        self.tangent_along(point, normal, u * cos + v * sin, random)
    }

    fn tangent_along(&self, point: Vec3, normal: Vec3, along: Vec3, random: &mut Random) -> Ray {
        let along = if along.length() > 0.0 { along.normalized() } else { Vec3::X };
        let d = along - normal * along.dot(normal);
        let tilted = d + normal * Self::perturbation(random);
        let point = match random.below(2) {
            0 => point,
            _ => point + normal * (self.radius * Self::perturbation(random)),
        };
        self.through(point, tilted, random)
    }

    /// A half line that starts exactly on the surface, as far as its points have coordinates.
    fn leaving_surface(&self, random: &mut Random) -> Ray {
        if random.below(3) == 0 {
            let joint = self.joint(random);
            return Ray::new(self.swept(joint, random), random.direction());
        }
        let (point, normal) = self.place(random);
        let direction = match random.below(3) {
            0 => self.tangent_along(point, normal, random.direction(), random).direction,
            1 => normal * Self::sign(random),
            _ => random.direction(),
        };
        Ray::new(point, direction)
    }

    fn far_off(&self, random: &mut Random) -> Ray {
        let target = match random.below(3) {
            0 => self.place(random).0,
            1 => {
                let mark = self.mark(random);
                self.swept(mark, random)
            }
            _ => self.in_box(random),
        };
        let origin = self.center + random.direction() * (FAR * self.radius);
        let d = target - origin;
        Ray::line(origin, if random.below(2) == 0 { d } else { d.normalized() })
    }
}

//! Holding [`Surface`] and [`Instance`] to the oracle.
//!
//! Counts must agree unless the line is nearer than [`TANGENCY_BAND`] to having another number of
//! hits. Where they agree, each t must lie within [`allowed`] of the exact one.

use core::fmt;

use rondure::{Hit, Instance, Ray, Surface, Vec3, numeric::UNIT_ROUNDOFF};

use crate::oracle::{ExactLine, Oracle, OracleHit};

/// Lines whose distance from a tangency is below this fraction of the object's size (or of the
/// distance of the ray's origin, if that is larger, times 2^-40) may have two hits more or fewer.
pub const TANGENCY_BAND: f64 = 1e-12;

/// By how many unit roundoffs of the object's size a line may seem to be moved. A hit is then off along
/// the line by this over the sine of the incidence.
pub const BACKWARD_ROUNDOFFS: f64 = 32.0;

/// Below this, incidence is no more than the rounding of the f64 that holds it.
const LEAST_INCIDENCE: f64 = UNIT_ROUNDOFF;

/// The largest error of a hit along the line, as a length, that counts as right.
///
/// `size` is the object's size, `reach` the largest of the lengths that must be subtracted to bring the
/// ray next to the object: |o - centre|, and the coordinates of the object if it is far from its
/// origin.
pub fn allowed(hit: &OracleHit, speed: f64, size: f64, reach: f64) -> f64 {
    let moved = UNIT_ROUNDOFF * (BACKWARD_ROUNDOFFS * size + 4.0 * reach);
    // Parallel to a side, a line that passes its edge by less than `moved` may hit either end of it.
    let at_joint = moved / hit.joint_incidence.max(LEAST_INCIDENCE);
    let incidence =
        if hit.joint_distance * size <= at_joint { hit.joint_incidence } else { hit.incidence };
    moved / incidence.max(LEAST_INCIDENCE) + 2.0 * UNIT_ROUNDOFF * (hit.t.hi * speed).abs()
}

/// What asks for hits: a surface, or a placed one.
pub trait Target {
    /// All hits in the range.
    fn all(&self, ray: &Ray, hits: &mut Vec<Hit>);
    /// The first hit in the range.
    fn closest(&self, ray: &Ray) -> Option<Hit>;
    /// Whether there is any.
    fn any(&self, ray: &Ray) -> bool;
    /// The ray's line in the object's frame.
    fn line(&self, ray: &Ray) -> ExactLine;
    /// The length of the ray's direction in the object's frame, and the largest length there that must
    /// be subtracted from another to bring the ray next to the object.
    fn speed_and_reach(&self, ray: &Ray) -> [f64; 2];
}

impl Target for Surface {
    fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        Surface::all(self, ray, hits);
    }
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        Surface::closest(self, ray)
    }
    fn any(&self, ray: &Ray) -> bool {
        Surface::any(self, ray)
    }
    fn line(&self, ray: &Ray) -> ExactLine {
        ExactLine::new(ray)
    }
    fn speed_and_reach(&self, ray: &Ray) -> [f64; 2] {
        [length(ray.direction), ray.origin.max_abs()]
    }
}

impl Target for Instance {
    fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        Instance::all(self, ray, hits);
    }
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        Instance::closest(self, ray)
    }
    fn any(&self, ray: &Ray) -> bool {
        Instance::any(self, ray)
    }
    fn line(&self, ray: &Ray) -> ExactLine {
        ExactLine::placed(ray, self.placement())
    }
    fn speed_and_reach(&self, ray: &Ray) -> [f64; 2] {
        let map = self.placement();
        let Some(rows) = map.inverse_rows() else { return [0.0; 2] };
        let d = ray.direction;
        let image = Vec3::new(rows[0].dot(d), rows[1].dot(d), rows[2].dot(d));
        // What the entries of the inverse make of rounding in the world, the object's included.
        let bounds = self.bounds();
        let world =
            ray.origin.abs() + map.translation.abs() + bounds.min.abs().max(bounds.max.abs());
        let reach = rows.iter().map(|r| r.abs().dot(world)).fold(0.0, f64::max);
        [length(image), reach]
    }
}

pub(crate) fn length(v: Vec3) -> f64 {
    let scale = v.max_abs();
    scale * (v * scale.recip()).length()
}

/// What came of many rays.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Rays compared.
    pub rays: u64,
    /// Hits that the oracle found.
    pub hits: u64,
    /// The largest |dt| |d| over the size, of all hits.
    pub worst_forward: f64,
    /// The largest |dt| |d| over what is allowed.
    pub worst_of_allowed: f64,
    /// Rays with too few hits outside the tangency band.
    pub lost: u64,
    /// Rays with too many.
    pub extra: u64,
    /// Rays of the whole line with an odd number of hits, where even is promised.
    pub odd: u64,
    /// Rays in the tangency band with another count than the oracle's.
    pub tangent: u64,
    /// Hits farther off than allowed.
    pub inexact: u64,
    /// Rays for which `closest`, `any` and `all` contradict each other.
    pub inconsistent: u64,
    /// The first few failures, in words.
    pub failures: Vec<String>,
}

impl Tally {
    /// Whether nothing was wrong.
    pub fn is_clean(&self) -> bool {
        self.lost + self.extra + self.odd + self.inexact + self.inconsistent == 0
    }

    /// Fails the test if anything was wrong.
    ///
    /// # Panics
    ///
    /// If anything was wrong.
    #[track_caller]
    pub fn assert_clean(&self) {
        assert!(self.is_clean(), "{self}");
    }

    fn fail(&mut self, what: impl FnOnce() -> String) {
        if self.failures.len() < 8 {
            self.failures.push(what());
        }
    }

    /// Compares one ray's hits; `even` if the surface bounds a solid.
    pub fn compare(&mut self, target: &impl Target, oracle: &Oracle, ray: &Ray, even: bool) {
        let line = target.line(ray);
        self.compare_with(target, ray, oracle.size(), even, oracle.hits_of_line(&line), || {
            oracle.tangency_of_line(&line)
        });
    }

    /// Compares one ray's hits with given ones.
    pub fn compare_with(
        &mut self,
        target: &impl Target,
        ray: &Ray,
        size: f64,
        even: bool,
        mut expected: Vec<OracleHit>,
        tangency: impl FnOnce() -> f64,
    ) {
        self.rays += 1;
        let mut found = Vec::new();
        target.all(ray, &mut found);
        let closest = self.consistent(target, ray, &found);
        let whole = ray.t_min == f64::NEG_INFINITY && ray.t_max == f64::INFINITY;
        if whole && even && found.len() % 2 == 1 {
            self.odd += 1;
            self.fail(|| format!("odd: {ray:?}\n  found {found:?}\n  exact {expected:?}"));
        }
        let [speed, reach] = target.speed_and_reach(ray);
        let slack = |h: &OracleHit| allowed(h, speed, size, reach) / speed;
        // A hit at the very end of the range may fall on either side.
        let at_end = |h: &OracleHit| {
            [ray.t_min, ray.t_max].iter().any(|&end| h.t.distance(end).abs() <= slack(h))
        };
        let at_ends = expected.iter().filter(|h| at_end(h)).count();
        expected.retain(|h| ray.t_min <= h.t.hi && h.t.hi <= ray.t_max);
        self.hits += expected.len() as u64;
        if found.len() != expected.len() {
            let distance = tangency();
            if distance <= TANGENCY_BAND.max(reach / size * 2f64.powi(-40)) {
                self.tangent += 1;
                return;
            }
            if found.len().abs_diff(expected.len()) <= at_ends {
                return;
            }
            let lost = found.len() < expected.len();
            *(if lost { &mut self.lost } else { &mut self.extra }) += 1;
            self.fail(|| {
                let word = if lost { "lost" } else { "extra" };
                format!(
                    "{word}: {ray:?}, {distance:e} from a tangency\n  found {found:?}\n  exact {}",
                    describe(&expected)
                )
            });
            return;
        }
        // The closest hit comes by another way than all hits do.
        let closest = closest.iter().zip(expected.first());
        for (hit, exact) in found.iter().zip(&expected).chain(closest) {
            let error = exact.t.distance(hit.t).abs() * speed;
            let ratio = error / allowed(exact, speed, size, reach);
            self.worst_forward = self.worst_forward.max(error / size);
            self.worst_of_allowed = self.worst_of_allowed.max(ratio);
            if ratio.is_nan() || ratio > 1.0 {
                self.inexact += 1;
                self.fail(|| {
                    format!(
                        "inexact: {ray:?}, t = {:e} is off by {:e} of the size, {ratio:.2} of what is \
                         allowed\n  exact {}",
                        hit.t,
                        error / size,
                        describe(&expected)
                    )
                });
            }
        }
    }

    /// Checks all hits against what the other queries say, and returns the closest.
    fn consistent(&mut self, target: &impl Target, ray: &Ray, all: &[Hit]) -> Option<Hit> {
        let closest = target.closest(ray);
        let sorted = all.windows(2).all(|w| w[0].t <= w[1].t);
        let inside = all.iter().all(|h| ray.t_min <= h.t && h.t <= ray.t_max);
        let any = target.any(ray);
        let none = all.is_empty();
        if !(sorted && inside && closest.is_none() == none && any != none) {
            self.inconsistent += 1;
            self.fail(|| {
                format!("inconsistent: {ray:?}\n  all {all:?}\n  closest {closest:?}, any {any}")
            });
        }
        closest
    }
}

fn describe(hits: &[OracleHit]) -> String {
    let words: Vec<_> = hits
        .iter()
        .map(|h| {
            format!(
                "[t = {:e}, segment {}, s = {}, incidence {:.1e}, {:.1e} from a joint]",
                h.t.hi, h.segment, h.s, h.incidence, h.joint_distance
            )
        })
        .collect();
    words.join(" ")
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} rays, {} hits; worst |dt| {:.2e} of the size, {:.2} of what is allowed; lost {}, extra \
             {}, odd {}, inexact {}, inconsistent {}; {} within {TANGENCY_BAND:e} of a tangency",
            self.rays,
            self.hits,
            self.worst_forward,
            self.worst_of_allowed,
            self.lost,
            self.extra,
            self.odd,
            self.inexact,
            self.inconsistent,
            self.tangent
        )?;
        for failure in &self.failures {
            write!(f, "\n- {failure}")?;
        }
        Ok(())
    }
}

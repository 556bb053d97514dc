//! Holding [`Surface`] and [`Instance`] to the oracle.
//!
//! Hits and exact hits must go together in pairs, each t within [`allowed`] of the exact one. Not always in
//! order: a hit of a line that runs along a wall may lie anywhere on the wall, before or behind another that
//! is known to the last place.
//!
//! What is left over is lost or extra, unless the line is nearer than [`TANGENCY_BAND`] to having another number
//! of hits, *and* what is left over is what such a touch takes or gives: two hits with hardly any depth between
//! them, or one hardly beyond a joint ([`Loose`]). A touch excuses no other hit of its line. Nor is a pair of hits
//! lost or extra if the line is nearer than that to the surface all the way from one to the other.

use core::{cmp::Ordering, fmt};

use rondure::{Hit, Instance, Ray, Surface, Vec3, numeric::UNIT_ROUNDOFF};

use crate::oracle::{ExactLine, Oracle, OracleHit};

/// Lines whose distance from a tangency is below this fraction of the object's size (or of the
/// distance of the ray's origin, if that is larger, times 2^-40) may have two hits more or fewer.
pub const TANGENCY_BAND: f64 = 1e-12;

/// By how many unit roundoffs of the object's size a line may seem to be moved. A hit is then off along
/// the line by this over the sine of the incidence.
pub const BACKWARD_ROUNDOFFS: f64 = 32.0;

/// The sine of the incidence from which hits count for [`Tally::worst_steep`].
pub const STEEP: f64 = 0.1;

/// Hits are known as well as each other within so many powers of two of what is allowed.
const AS_WELL: f64 = 4.0;

/// Below this, incidence is no more than the rounding of the f64 that holds it.
const LEAST_INCIDENCE: f64 = UNIT_ROUNDOFF;

/// The largest error of a hit along the line, as a length, that counts as right.
///
/// `size` is the object's size, `reach` the largest of the lengths that must be subtracted to bring the
/// ray next to the object: |o - centre|, and the coordinates of the object if it is far from its
/// origin.
pub fn allowed(hit: &OracleHit, speed: f64, size: f64, reach: f64) -> f64 {
    let moved = UNIT_ROUNDOFF * (BACKWARD_ROUNDOFFS * size + 4.0 * reach);
    // A line that is moved by so much may pass the joint and hit what lies beyond it, which it may run along.
    let at_joint = moved / hit.incidence.max(LEAST_INCIDENCE);
    let incidence =
        if hit.joint_distance * size <= at_joint { hit.joint_incidence } else { hit.incidence };
    moved / incidence.max(LEAST_INCIDENCE) + 2.0 * UNIT_ROUNDOFF * (hit.t.hi * speed).abs()
}

/// Which hit stands for which exact one, as many as possible, and those first that come first in `order`; `off`
/// tells how far apart the two are if they fit. Of hits that fit an exact one takes the nearest that it can have.
fn pair_up(
    found: usize,
    order: &[usize],
    off: &impl Fn(usize, usize) -> Option<f64>,
) -> Vec<Option<usize>> {
    // Hungarian method: an exact hit takes one from another that can take a third instead.
    fn settle(
        exact: usize,
        off: &impl Fn(usize, usize) -> Option<f64>,
        taken: &mut [Option<usize>],
        seen: &mut [bool],
    ) -> bool {
        let mut fitting: Vec<(f64, usize)> =
            (0..taken.len()).filter_map(|hit| Some((off(hit, exact)?, hit))).collect();
        // Those that are free first: who has come before has chosen better.
        fitting.sort_by(|a, b| {
            let taken = |hit: &(f64, usize)| taken[hit.1].is_some();
            taken(a).cmp(&taken(b)).then(a.0.total_cmp(&b.0))
        });
        fitting.into_iter().any(|(_, hit)| {
            if seen[hit] {
                return false;
            }
            seen[hit] = true;
            let free = taken[hit].is_none_or(|other| settle(other, off, taken, seen));
            if free {
                taken[hit] = Some(exact);
            }
            free
        })
    }
    if found == order.len() && (0..found).all(|i| off(i, i).is_some()) {
        return (0..found).map(Some).collect();
    }
    let mut taken = vec![None; found];
    for &exact in order {
        settle(exact, off, &mut taken, &mut vec![false; found]);
    }
    taken
}

/// A hit that is lost or extra: where it is, and how it lies to the surface.
///
/// A line that touches by a depth h has two hits a chord c apart. At a corner the angles there have the sines
/// p <= q and h = c p q / (p + q), hence c p <= 2 h; at a contact of order n, in h = k (c / 2)^n, the sines are
/// n h / (c / 2), hence c p <= 2 n h, and n is six at the most. A level line at the height of a plane that
/// caps a wall has its two hits on opposite walls, each hardly beyond the joint.
struct Loose {
    t: f64,
    sine: f64,
    /// The distance, in the half plane, from the end of its piece, as a fraction of the size.
    joint: f64,
}

impl Loose {
    /// See there: of the chord times the sine, over the depth.
    const MOST_OF_CHORD: f64 = 12.0;
    /// Of the distance from a joint times the sine, over the depth: 1, and as much again for the other side.
    const MOST_OF_JOINT: f64 = 2.0;

    fn is_beside_joint(&self, depth: f64) -> bool {
        self.joint * self.sine <= Self::MOST_OF_JOINT * depth
    }

    /// `speed` is that of the line in units of the size.
    fn is_touch(&self, other: &Self, speed: f64, depth: f64) -> bool {
        let chord = (self.t - other.t).abs() * speed;
        chord * self.sine.min(other.sine) <= Self::MOST_OF_CHORD * depth
    }
}

/// Whether hits that are lost or extra, in order of t, are no more than touches of this depth, as a fraction of the size.
fn are_touches(loose: &[Loose], speed: f64, depth: f64) -> bool {
    (0..loose.len()).all(|i| {
        let one = &loose[i];
        let beside = |j: usize| loose.get(j).is_some_and(|other| one.is_touch(other, speed, depth));
        one.is_beside_joint(depth) || beside(i + 1) || i.checked_sub(1).is_some_and(beside)
    })
}

/// Whether hits that are lost or extra, in order of t, are pairs between which the line does not leave the surface.
fn run_along(loose: &[Loose], straying: impl Fn([f64; 2]) -> f64, depth: f64) -> bool {
    loose.len().is_multiple_of(2)
        && loose.chunks(2).all(|pair| straying([pair[0].t, pair[1].t]) <= depth)
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
    /// The sine of the incidence of a hit, and its distance, in the half plane, from the end of its piece.
    fn incidence_and_joint(&self, ray: &Ray, hit: &Hit) -> [f64; 2];
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
    fn incidence_and_joint(&self, ray: &Ray, hit: &Hit) -> [f64; 2] {
        let at = self.interaction(ray, hit);
        let r = at.point.x.hypot(at.point.y);
        let ends = self.piece_ends().nth(hit.piece as usize).unwrap_or_default();
        let joint = ends.map(|e| (e.r - r).hypot(e.z - at.point.z));
        [sine(at.normal, ray.direction), joint[0].min(joint[1])]
    }
}

fn sine(normal: Vec3, direction: Vec3) -> f64 {
    let d = direction * direction.max_abs().recip();
    normal.dot(d).abs() / d.length()
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
    /// Joints are not looked for in the world: each hit counts as one.
    fn incidence_and_joint(&self, ray: &Ray, hit: &Hit) -> [f64; 2] {
        [sine(self.interaction(ray, hit).normal, ray.direction), 0.0]
    }
}

pub(crate) fn length(v: Vec3) -> f64 {
    let scale = v.max_abs();
    scale * (v * scale.recip()).length()
}

/// As many failures of each kind are told in words.
const TOLD: usize = 8;

/// What came of many rays.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Rays compared.
    pub rays: u64,
    /// Hits that the oracle found.
    pub hits: u64,
    /// The largest |dt| |d| over the size, of all hits.
    pub worst_forward: f64,
    /// The same of the hits whose incidence, and that beyond the nearer joint, is at least [`STEEP`].
    pub worst_steep: f64,
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
    /// Rays that were compared with the oracle or a closed form.
    pub compared: u64,
    /// Rays sent on from a hit.
    pub leaving: u64,
    /// Of these, those that hit what they had left, or missed what they should have hit.
    pub stuck: u64,
    /// Whether the band is [`TANGENCY_BAND`] however far away rays begin.
    pub strict: bool,
    /// The first few failures, in words.
    pub failures: Vec<String>,
}

impl Tally {
    /// Whether nothing was wrong.
    pub fn is_clean(&self) -> bool {
        self.lost + self.extra + self.odd + self.inexact + self.inconsistent + self.stuck == 0
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

    /// Adds what came of other rays.
    pub fn add(&mut self, other: Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.worst_forward = self.worst_forward.max(other.worst_forward);
        self.worst_steep = self.worst_steep.max(other.worst_steep);
        self.worst_of_allowed = self.worst_of_allowed.max(other.worst_of_allowed);
        self.lost += other.lost;
        self.extra += other.extra;
        self.odd += other.odd;
        self.tangent += other.tangent;
        self.inexact += other.inexact;
        self.inconsistent += other.inconsistent;
        self.compared += other.compared;
        self.leaving += other.leaving;
        self.stuck += other.stuck;
        for failure in other.failures {
            self.fail(|| failure);
        }
    }

    /// Words that begin with the kind of failure and a colon.
    pub(crate) fn fail(&mut self, what: impl FnOnce() -> String) {
        let kind = |words: &str| words.split(':').next().map(str::to_owned);
        let what = what();
        let same = self.failures.iter().filter(|told| kind(told) == kind(&what)).count();
        if same < TOLD {
            self.failures.push(what);
        }
    }

    /// The counts alone, in one line.
    pub fn counts(&self) -> String {
        format!(
            "{} rays, {} compared, {} hits; worst |dt| {:.2e} of the size, {:.2e} from {STEEP} of incidence \
             on, {:.2} of what is allowed; {} sent on, {} stuck; lost {}, extra {}, odd {}, inexact {}, \
             inconsistent {}; {} within {TANGENCY_BAND:e} of a tangency",
            self.rays,
            self.compared,
            self.hits,
            self.worst_forward,
            self.worst_steep,
            self.worst_of_allowed,
            self.leaving,
            self.stuck,
            self.lost,
            self.extra,
            self.odd,
            self.inexact,
            self.inconsistent,
            self.tangent
        )
    }

    /// Compares one ray's hits; `even` if the surface bounds a solid.
    pub fn compare(&mut self, target: &impl Target, oracle: &Oracle, ray: &Ray, even: bool) {
        let line = target.line(ray);
        let expected = oracle.hits_of_line(&line);
        self.compare_with(target, oracle, &line, ray, even, expected);
    }

    /// Compares one ray's hits with given ones.
    pub fn compare_with(
        &mut self,
        target: &impl Target,
        oracle: &Oracle,
        line: &ExactLine,
        ray: &Ray,
        even: bool,
        mut expected: Vec<OracleHit>,
    ) {
        let size = oracle.size();
        self.rays += 1;
        self.compared += 1;
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
        let within = |h: &OracleHit| ray.t_min <= h.t.hi && h.t.hi <= ray.t_max;
        let mut candidates = expected.clone();
        candidates.retain(|h| within(h) || at_end(h));
        expected.retain(within);
        self.hits += expected.len() as u64;
        let far = if self.strict { 0.0 } else { reach / size * 2f64.powi(-40) };
        // The size is up to twice the radius of the sphere round the object.
        let band = if self.strict { 0.5 * TANGENCY_BAND } else { TANGENCY_BAND.max(far) };
        let reaches: Vec<f64> = candidates.iter().map(|h| allowed(h, speed, size, reach)).collect();
        let off = |hit: &Hit, i: usize| candidates[i].t.distance(hit.t).abs() * speed;
        // Those that are known best choose first, of those that are known as well the one that has the nearest hit, and those
        // at an end of the range last.
        let (mut order, mut may): (Vec<usize>, Vec<usize>) =
            (0..candidates.len()).partition(|&i| !at_end(&candidates[i]));
        let choice: Vec<(f64, f64)> = (0..candidates.len())
            .map(|i| {
                let nearest = found.iter().map(|hit| off(hit, i)).fold(f64::INFINITY, f64::min);
                ((reaches[i].log2() / AS_WELL).floor(), nearest)
            })
            .collect();
        let by_choice = |&a: &usize, &b: &usize| {
            let (a, b) = (choice[a], choice[b]);
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        order.sort_by(by_choice);
        may.sort_by(by_choice);
        let must = order.clone();
        order.append(&mut may);
        let pairs = pair_up(found.len(), &order, &|hit, i| {
            let off = off(&found[hit], i);
            (off <= reaches[i]).then_some(off)
        });
        for (hit, i) in found.iter().zip(&pairs).filter_map(|(hit, i)| i.map(|i| (hit, i))) {
            let error = off(hit, i);
            self.worst_forward = self.worst_forward.max(error / size);
            self.worst_of_allowed = self.worst_of_allowed.max(error / reaches[i]);
            if candidates[i].incidence.min(candidates[i].joint_incidence) >= STEEP {
                self.worst_steep = self.worst_steep.max(error / size);
            }
        }
        let lost: Vec<usize> = must.into_iter().filter(|i| !pairs.contains(&Some(*i))).collect();
        let extra = found.iter().zip(&pairs).filter(|(_, i)| i.is_none()).map(|(hit, _)| hit);
        let extra: Vec<&Hit> = extra.collect();
        if !(lost.is_empty() && extra.is_empty()) {
            let distance = oracle.tangency_of_line(line);
            let of_exact = lost.iter().map(|&i| {
                let h = &candidates[i];
                Loose { t: h.t.hi, sine: h.incidence, joint: h.joint_distance }
            });
            let of_found = extra.iter().map(|hit| {
                let [sine, joint] = target.incidence_and_joint(ray, hit);
                Loose { t: hit.t, sine, joint: joint / size }
            });
            let mut loose: Vec<Loose> = of_exact.chain(of_found).collect();
            loose.sort_by(|a, b| a.t.total_cmp(&b.t));
            // The other hit of a touch may lie beyond the end of the range.
            let touches = distance <= band && (!whole || are_touches(&loose, speed / size, band));
            if touches || run_along(&loose, |range| oracle.straying(line, range), band) {
                self.tangent += 1;
                return;
            }
            let (counter, word) = match lost.len().cmp(&extra.len()) {
                Ordering::Greater => (&mut self.lost, "lost"),
                Ordering::Less => (&mut self.extra, "extra"),
                Ordering::Equal => (&mut self.inexact, "inexact"),
            };
            *counter += 1;
            self.fail(|| {
                let errors: Vec<_> = extra
                    .iter()
                    .flat_map(|hit| lost.iter().map(|&i| off(hit, i) / reaches[i]))
                    .collect();
                format!(
                    "{word}: {ray:?}, {distance:e} from a tangency, off by {errors:.2?} of what is allowed\n  \
                     found {found:?}\n  exact {}",
                    describe(&expected)
                )
            });
            return;
        }
        let mut inexact = None;
        // The closest hit comes by another way than all hits do: it is a hit, and none is before it.
        if let Some(closest) = closest {
            let near = |i: usize| off(&closest, i) <= reaches[i];
            let behind =
                |i: usize| closest.t <= candidates[i].t.hi || near(i) || at_end(&candidates[i]);
            let all = 0..candidates.len();
            if !(all.clone().any(near) && all.clone().all(behind)) {
                let error = all.map(|i| off(&closest, i)).fold(f64::INFINITY, f64::min);
                inexact = Some((closest, error));
            }
        }
        if let Some((hit, error)) = inexact {
            self.inexact += 1;
            self.fail(|| {
                format!(
                    "inexact: {ray:?}, the closest hit, t = {:e}, is off by {:e} of the size\n  found \
                     {found:?}\n  exact {}",
                    hit.t,
                    error / size,
                    describe(&expected)
                )
            });
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
        f.write_str(&self.counts())?;
        for failure in &self.failures {
            write!(f, "\n- {failure}")?;
        }
        Ok(())
    }
}

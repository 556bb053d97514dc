//! Holding one engine's answers to those of the exact engine, hit by hit.
//!
//! The same hit is on the same piece with |dt| |d| <= 1e-12 R ([`SAME`]), beside what t itself is rounded by
//! ([`last_places`]). Everything else is either explained by rounding, and counted as such, or a
//! disagreement:
//!
//! * *grazing*: rounding moves the ray by [`moved`], hence the hit by that over the sine of
//!   the incidence, in each of the two engines;
//! * *tangent*: hits that one engine has and the other has not, on a ray within [`moved`] of touching only,
//!   or within [`TANGENCY_BAND`] as the exact oracle says, beside whose touching place they lie;
//! * *joint*: a hit on another piece, at the joint that both pieces have in common;
//! * *end*: a hit at an end of the ray's range, to within what it may be off;
//! * *tie*: closest hits of two parts of the surface, nearer to each other than they may be off, of which each
//!   engine takes another.

use core::cell::OnceCell;

use rondure::{Hit, Ray, Surface, Vec3, numeric::UNIT_ROUNDOFF};

use super::count::{Count, Failure, has_room};
use crate::{
    Oracle, OracleHit,
    compare::{BACKWARD_ROUNDOFFS, TANGENCY_BAND, allowed, length},
};

/// Hits no farther apart, as a share of the surface's radius, are the same.
pub const SAME: f64 = 1e-12;

/// An engine need not move the origin of a ray that is no more than so many radii away; from there the
/// coordinates are rounded.
const NEARBY: f64 = 16.0;

/// A hit that is lost or found by moving its ray by [`TANGENCY_BAND`] of the size has no larger sine, where the
/// profile's radius of curvature is above 1e-4 of the size: a chord of half-length l and height h = l^2 / (2 rho)
/// has the sine l / rho = sqrt(2 h / rho).
const TOUCHING_SINE: f64 = 1.5e-4;
/// Or else it is so near to the end of a piece, as a share of the radius: moved by [`TANGENCY_BAND`], a ray at any larger
/// sine than 1e-6 reaches no farther along the surface.
const TOUCHING_JOINT: f64 = 1e-6;

/// Hits on one piece, one of each engine, are one hit and inexact up to this distance as a share of the radius;
/// beyond it one is lost and one is extra.
const OFF: f64 = 1e-3;

/// The rounding of t as a length: of the result, and of the shift that is part of it, in both engines.
fn last_places(t: f64, speed: f64) -> f64 {
    4.0 * UNIT_ROUNDOFF * (t * speed).abs()
}

/// By how much rounding may move a ray whose origin is at a distance from the middle of the surface.
fn moved(radius: f64, distance: f64) -> f64 {
    UNIT_ROUNDOFF * (BACKWARD_ROUNDOFFS * radius + 4.0 * distance.min(NEARBY * radius))
}

/// One engine's answers for one ray.
#[derive(Clone, Copy, Debug)]
pub struct Answers<'a> {
    /// All hits in the range, in order.
    pub all: &'a [Hit],
    /// The first.
    pub closest: Option<Hit>,
    /// Whether there is any.
    pub any: bool,
}

/// Who knows the truth about a shape.
#[derive(Debug)]
pub struct Judge<'a> {
    exact: &'a Surface,
    oracle: &'a Oracle,
    ends: Vec<[rondure::Point; 2]>,
    solid: bool,
    center: Vec3,
    radius: f64,
}

/// How two hits compare.
enum Same {
    /// Their distance as a share of R.
    Near(f64),
    /// The same, and the sine of the incidence.
    Grazing(f64, f64),
    No,
}

/// What explains that only one engine has a hit.
#[derive(Clone, Copy, PartialEq)]
enum Reason {
    End,
    Tangent(f64),
    None,
}

/// What is found out about one ray.
#[derive(Default)]
struct Findings {
    lost: bool,
    extra: bool,
    other: bool,
    off: Option<f64>,
    unordered: bool,
    outside: bool,
    odd: bool,
    any: bool,
    end: bool,
    tie: bool,
    tangent: Option<f64>,
}

impl Findings {
    fn is_off(&mut self, distance: f64) {
        self.off = Some(self.off.map_or(distance, |d| d.max(distance)));
    }
}

/// A ray, with what the oracle says of it once it has been asked.
struct Case<'a> {
    judge: &'a Judge<'a>,
    ray: &'a Ray,
    speed: f64,
    moved: f64,
    hits: OnceCell<Vec<OracleHit>>,
    tangency: OnceCell<f64>,
}

impl<'a> Judge<'a> {
    /// A judge for the shape of a surface, which must be that of the exact engine.
    pub fn new(exact: &'a Surface, oracle: &'a Oracle, center: Vec3, radius: f64) -> Self {
        let solid = exact.profile().bounds_solid();
        Self { exact, oracle, ends: exact.piece_ends().collect(), solid, center, radius }
    }

    /// Compares the answers of an engine with those of the exact one.
    pub fn compare(&self, ray: &Ray, exact: Answers<'_>, found: Answers<'_>, count: &mut Count) {
        count.rays += 1;
        count.hits += exact.all.len() as u64;
        let distance = length(ray.origin - self.center);
        let case = Case {
            judge: self,
            ray,
            speed: length(ray.direction),
            moved: moved(self.radius, distance),
            hits: OnceCell::new(),
            tangency: OnceCell::new(),
        };
        let mut findings = Findings::default();
        self.check_order(ray, found.all, &mut findings);
        case.compare_all(exact.all, found.all, count, &mut findings);
        case.compare_closest(exact, found, count, &mut findings);
        case.compare_any(exact, found, &mut findings);
        let Findings { lost, extra, other, off, unordered, outside, odd, any, end, tie, tangent } =
            findings;
        count.lost += u64::from(lost);
        count.extra += u64::from(extra);
        count.other += u64::from(other);
        count.off += u64::from(off.is_some());
        count.off_worst = count.off_worst.max(off.unwrap_or(0.0));
        count.inconsistent += u64::from(unordered || outside || odd || any);
        count.end += u64::from(end);
        count.tie += u64::from(tie);
        if let Some(distance) = tangent {
            count.tangent += 1;
            count.tangent_worst = count.tangent_worst.max(distance);
        }
        let kinds = [
            (lost, "lost"),
            (extra, "extra"),
            (other, "other piece"),
            (off.is_some(), "off"),
            (unordered, "out of order"),
            (outside, "out of range"),
            (odd, "odd"),
            (any, "any alone"),
        ];
        let kinds: Vec<_> = kinds.iter().filter(|(is, _)| *is).map(|(_, kind)| *kind).collect();
        let kind = kinds.join(", ");
        if !kind.is_empty() && has_room(&count.failures, &kind) {
            let words = case.describe(exact, found);
            count.failures.push(Failure { kind, words });
        }
    }

    fn check_order(&self, ray: &Ray, all: &[Hit], findings: &mut Findings) {
        let sorted = all.windows(2).all(|w| w[0].t <= w[1].t);
        let inside = all.iter().all(|h| ray.t_min <= h.t && h.t <= ray.t_max);
        let whole = ray.t_min == f64::NEG_INFINITY && ray.t_max == f64::INFINITY;
        let odd = whole && self.solid && all.len() % 2 == 1;
        findings.unordered |= !sorted;
        findings.outside |= !inside;
        findings.odd |= odd;
    }
}

impl Case<'_> {
    fn oracle_hits(&self) -> &[OracleHit] {
        self.hits.get_or_init(|| self.judge.oracle.hits(self.ray))
    }

    fn tangency(&self) -> f64 {
        *self.tangency.get_or_init(|| self.judge.oracle.tangency(self.ray))
    }

    /// The sine of the angle between the ray and the surface at a hit.
    fn sine(&self, hit: &Hit) -> f64 {
        let normal = self.judge.exact.interaction(self.ray, hit).normal;
        let d = self.ray.direction;
        let unit = d * d.max_abs().recip();
        (normal.dot(unit) / unit.length()).abs()
    }

    fn distance(&self, a: &Hit, b: &Hit) -> f64 {
        if a.t == b.t { 0.0 } else { (a.t - b.t).abs() * self.speed }
    }

    /// How far each engine may be off along the ray, by incidence; as a length.
    fn slack(&self, hit: &Hit) -> f64 {
        let plain = SAME * self.judge.radius;
        plain.max(self.moved / self.sine(hit).max(UNIT_ROUNDOFF)) + last_places(hit.t, self.speed)
    }

    /// Whether two hits, whatever their pieces, lie as near to each other as the same one would.
    fn same(&self, a: &Hit, b: &Hit) -> Same {
        let radius = self.judge.radius;
        let rounding = last_places(a.t, self.speed);
        let distance = (self.distance(a, b) - rounding).max(0.0);
        if distance <= SAME * radius {
            return Same::Near(distance / radius);
        }
        // At a tangency the incidence itself moves; the smaller one is a bound for both.
        let sine = self.sine(a).min(self.sine(b)).max(UNIT_ROUNDOFF);
        if distance <= 2.0 * self.moved / sine {
            return Same::Grazing(distance / radius, sine);
        }
        if a.piece != b.piece {
            return Same::No;
        }
        // At a joint the ray may meet the other side, whose incidence only the oracle knows.
        let (size, reach) = (self.judge.oracle.size(), self.moved / (4.0 * UNIT_ROUNDOFF));
        let right = |hit: &Hit, true_one: &OracleHit| {
            let error = true_one.t.distance(hit.t).abs() * self.speed;
            error <= allowed(true_one, self.speed, size, reach)
        };
        let agreed = self.oracle_hits().iter().find(|h| right(a, h) && right(b, h));
        match agreed {
            Some(h) => Same::Grazing(distance / radius, h.incidence.min(h.joint_incidence)),
            None => Same::No,
        }
    }

    /// Whether two hits that are not the same are likely meant to be.
    fn is_off(&self, a: &Hit, b: &Hit) -> bool {
        a.piece == b.piece && self.distance(a, b) <= OFF * self.judge.radius
    }

    /// The distance of a hit, in the half plane, from the nearer end of its piece.
    fn joint_distance(&self, hit: &Hit) -> f64 {
        let p = self.judge.exact.interaction(self.ray, hit).point;
        let r = p.x.hypot(p.y);
        let ends = self.judge.ends[hit.piece as usize];
        ends.iter().map(|e| (e.r - r).hypot(e.z - p.z)).fold(f64::INFINITY, f64::min)
    }

    fn are_at_joint(&self, a: &Hit, b: &Hit) -> bool {
        [a, b].iter().all(|hit| self.joint_distance(hit) <= self.slack(hit))
    }

    /// Whether two hits on different pieces may be the same.
    fn is_beside(&self, a: &Hit, b: &Hit) -> bool {
        match self.same(a, b) {
            Same::Near(_) => true,
            Same::Grazing(..) => self.are_at_joint(a, b),
            Same::No => false,
        }
    }

    fn compare_all(
        &self,
        exact: &[Hit],
        found: &[Hit],
        count: &mut Count,
        findings: &mut Findings,
    ) {
        let radius = self.judge.radius;
        if exact.len() == found.len() {
            let mut worst = 0.0_f64;
            let mut same = true;
            for (a, b) in exact.iter().zip(found) {
                let error = (self.distance(a, b) - last_places(a.t, self.speed)).max(0.0) / radius;
                same &= a.piece == b.piece && error <= SAME;
                worst = worst.max(error);
            }
            if same {
                count.worst = count.worst.max(worst);
                return;
            }
        }
        let mut rest = found.to_vec();
        let mut unmatched = Vec::new();
        for a in exact {
            let mut matches = |same_piece: bool| {
                let place = (0..rest.len()).find(|&i| {
                    if (rest[i].piece == a.piece) != same_piece {
                        return false;
                    }
                    match self.same(a, &rest[i]) {
                        Same::No => false,
                        Same::Near(distance) => {
                            count.worst = count.worst.max(distance);
                            true
                        }
                        Same::Grazing(distance, sine) => {
                            count.grazing += 1;
                            let [d, s] = count.grazing_worst;
                            count.grazing_worst = [d.max(distance), s.max(sine)];
                            true
                        }
                    }
                });
                place.map(|i| rest.remove(i))
            };
            if matches(true).is_none() {
                unmatched.push(*a);
            }
        }
        // What is left may be the same hit on another piece, or all but the same hit.
        let mut missing = Vec::new();
        for a in unmatched {
            let place = rest.iter().position(|b| self.is_off(&a, b) || self.is_beside(&a, b));
            match place.map(|i| rest.remove(i)) {
                Some(b) if b.piece == a.piece => findings.is_off(self.distance(&a, &b) / radius),
                Some(b) if self.are_at_joint(&a, &b) => count.joint += 1,
                Some(_) => findings.other = true,
                None => missing.push(a),
            }
        }
        self.explain(&missing, |findings| &mut findings.lost, findings);
        self.explain(&rest, |findings| &mut findings.extra, findings);
    }

    /// Explains why only one engine has these hits, or blames it.
    fn explain(
        &self,
        hits: &[Hit],
        blame: impl Fn(&mut Findings) -> &mut bool,
        findings: &mut Findings,
    ) {
        if let [a, b] = hits {
            // Between them the ray is beyond the surface by less than the chord times the sine.
            let depth = self.distance(a, b) * self.sine(a).max(self.sine(b));
            if depth <= self.moved {
                let depth = depth / self.judge.oracle.size();
                findings.tangent = Some(findings.tangent.map_or(depth, |t| t.max(depth)));
                return;
            }
        }
        for hit in hits {
            match self.reason(hit) {
                Reason::End => findings.end = true,
                Reason::Tangent(distance) => {
                    findings.tangent = Some(findings.tangent.map_or(distance, |t| t.max(distance)));
                }
                Reason::None => *blame(findings) = true,
            }
        }
    }

    fn reason(&self, hit: &Hit) -> Reason {
        let slack = self.slack(hit);
        let ends = [self.ray.t_min, self.ray.t_max];
        if ends.iter().any(|&end| (hit.t - end).abs() * self.speed <= slack || hit.t == end) {
            return Reason::End;
        }
        let touches = self.sine(hit) <= TOUCHING_SINE
            || self.joint_distance(hit) <= TOUCHING_JOINT * self.judge.radius;
        if touches && self.tangency() <= TANGENCY_BAND {
            return Reason::Tangent(self.tangency());
        }
        Reason::None
    }

    fn compare_closest(
        &self,
        exact: Answers<'_>,
        found: Answers<'_>,
        count: &mut Count,
        findings: &mut Findings,
    ) {
        let inside = |h: &Hit| self.ray.t_min <= h.t && h.t <= self.ray.t_max;
        findings.outside |= !found.closest.iter().all(inside);
        let (a, b) = match (exact.closest, found.closest) {
            (None, None) => return,
            (Some(a), Some(b)) => (a, b),
            (Some(a), None) => return self.explain(&[a], |f| &mut f.lost, findings),
            (None, Some(b)) => return self.explain(&[b], |f| &mut f.extra, findings),
        };
        match self.same(&a, &b) {
            Same::Near(distance) if a.piece == b.piece => {
                count.worst = count.worst.max(distance);
            }
            Same::Grazing(distance, sine) if a.piece == b.piece => {
                count.grazing += 1;
                let [d, s] = count.grazing_worst;
                count.grazing_worst = [d.max(distance), s.max(sine)];
            }
            Same::Near(_) | Same::Grazing(..) if self.is_known(&b, exact.all) => {
                findings.tie = true;
            }
            _ if a.piece != b.piece && self.is_beside(&a, &b) => {
                if self.are_at_joint(&a, &b) {
                    count.joint += 1;
                } else {
                    findings.other = true;
                }
            }
            _ if self.is_off(&a, &b) => {
                findings.is_off(self.distance(&a, &b) / self.judge.radius);
            }
            _ if a.t < b.t => self.explain(&[a], |f| &mut f.lost, findings),
            _ => self.explain(&[b], |f| &mut f.extra, findings),
        }
    }

    /// Whether a hit is the same as one of some others.
    fn is_known(&self, hit: &Hit, all: &[Hit]) -> bool {
        all.iter().any(|h| h.piece == hit.piece && !matches!(self.same(h, hit), Same::No))
    }

    fn compare_any(&self, exact: Answers<'_>, found: Answers<'_>, findings: &mut Findings) {
        if exact.any == found.any {
            return;
        }
        // Each of the hits that one engine must have and the other must not have needs its reason.
        if exact.any {
            self.explain(exact.all, |f| &mut f.lost, findings);
        } else if let Some(hit) = found.closest {
            self.explain(&[hit], |f| &mut f.extra, findings);
        } else if found.all.is_empty() {
            // Its `any` alone claims a hit, which may be one that another engine's `all` loses at a tangency.
            if self.tangency() <= TANGENCY_BAND {
                findings.tangent.get_or_insert(self.tangency());
            } else {
                findings.any = true;
            }
        } else {
            self.explain(found.all, |f| &mut f.extra, findings);
        }
    }

    fn describe(&self, exact: Answers<'_>, found: Answers<'_>) -> String {
        let oracle: Vec<_> = self
            .oracle_hits()
            .iter()
            .map(|h| {
                format!(
                    "[t = {:e}, incidence {:.1e}, {:.1e} from a joint]",
                    h.t.hi, h.incidence, h.joint_distance
                )
            })
            .collect();
        format!(
            "{:?}, {:.1e} from a tangency\n  exact {exact:?}\n  found {found:?}\n  oracle, \
             whole line: {}",
            self.ray,
            self.tangency(),
            oracle.join(" ")
        )
    }
}

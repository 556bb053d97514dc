//! The hit of a ray on a leaf, near a place that is known already: Newton's method in f64 on the pair
//! (s, tau),
//!
//! ```text
//! f = z(s) - oz - dz tau = 0,    g = (rho(tau)^2 - r(s)^2) / 2 = 0,
//! ```
//!
//! whose determinant z' rho rho' - r r' dz vanishes only where the ray is tangent. rho^2 is summed from the
//! ray's x and y, which keeps it exact near the axis. Two steps do; what takes longer, or leads
//! elsewhere, is left to the exact engine.

use super::arithmetic::{Fused, lesser};
use super::course::Course;
use super::eight::WIDTH;
use super::quadric::Quadric;
use crate::numeric::UNIT_ROUNDOFF;
use crate::piece::{Kind, Piece};

/// A piece by powers of its parameter.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Curve {
    /// r by powers, then z. For a conic the first three of either are those of it times its denominator 1 + q s - q s^2, and the
    /// last is q.
    powers: [f64; 8],
}

/// A part of a piece.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Leaf {
    /// Between which parameters what the block says of it holds.
    valid: [f32; 2],
    /// The longest step in s that can be the last, where r is 1 or more.
    last: f32,
    /// The number of the piece times two, and 1 if that is a conic.
    piece: u32,
}

/// Where a leaf may be hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// About which parameter on the piece, and on the ray.
    pub(super) s: f64,
    pub(super) tau: f64,
    /// How far off tau may be.
    pub(super) blur: f64,
}

/// What is known of the hit at a spot.
#[derive(Clone, Copy, Debug)]
pub(super) enum Finding {
    /// There is none on the piece and in the range.
    None,
    /// There is this one: tau, s on the piece, and how far off rounding may put tau.
    Hit { tau: f64, s: f64, margin: f64 },
    /// That is for the exact engine to say.
    Unknown,
}

/// A hit for certain, as [`Finding::Hit`] has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certain {
    pub(super) tau: f64,
    pub(super) s: f64,
    pub(super) margin: f64,
}

/// A step of Newton's along the ray whose square is no more than this times r is the last, likewise one in s after which as
/// little remains. What remains of f is z'' / 2 times the square of the step in s; of g, whose own rounding shrinks with r, it is
/// a / 2 times that of the step in tau, less (r^2)'' / 4 times that of the step in s. A last step leaves no more than rounding does.
pub(super) const LAST_STEP2: f64 = LAST_STEP * LAST_STEP;
const LAST_STEP: f64 = 1.0 / (1_u64 << 26) as f64;
/// As much of the curvature is allowed for at the least, and at the most: no step in s that is longer than LAST_STEP by more than
/// the root of the former is the last.
const BEND: [f64; 2] = [1.0 / 4096.0, 1.0];
/// What part of the blur the last step in tau may be for a hit that is certain at a glance.
const LAST_PART: f64 = 1.0 / 8.0;
/// More than two are needed only near an end on the axis, and near a tangency.
const MORE_STEPS: u32 = 3;

/// How far off rounding may put a point of the curve, or of the ray, per coordinate: fewer than six
/// roundings of numbers no larger than the radius, which is at most 2, and the ray's origin.
pub(super) const ROUNDING: f64 = 6.0 * UNIT_ROUNDOFF;

impl Curve {
    pub(super) fn new(piece: &Piece, unit: f64) -> Self {
        let powers = |c: &[f64; 4]| {
            let c = c.map(|c| c * unit);
            match piece.kind {
                Kind::Line => [c[0], c[3] - c[0], 0.0, 0.0],
                Kind::Quadratic => [c[0], 2.0 * (c[1] - c[0]), (c[0] - c[1]) + (c[3] - c[1]), 0.0],
                Kind::Cubic => {
                    let (d0, d1, d2) = (c[1] - c[0], c[2] - c[1], c[3] - c[2]);
                    [c[0], 3.0 * d0, 3.0 * (d1 - d0), (d2 - d1) - (d1 - d0)]
                }
                Kind::Conic(w) => {
                    let middle = w * c[1];
                    let bend = (c[0] - middle) + (c[3] - middle);
                    [c[0], 2.0 * (middle - c[0]), bend, 2.0 * (w - 1.0)]
                }
            }
        };
        let ([r0, r1, r2, r3], [z0, z1, z2, z3]) = (powers(&piece.r), powers(&piece.z));
        Self { powers: [r0, r1, r2, r3, z0, z1, z2, z3] }
    }

    /// How much a step in s by 1 could leave of f and of g, twice, or 1 if that is less, or if it is not known.
    fn bend(&self, kind: Kind) -> f64 {
        if matches!(kind, Kind::Conic(_)) {
            return BEND[1];
        }
        let [r0, r1, r2, r3, _, _, z2, z3] = self.powers;
        let ends = |a: f64, b: f64| a.abs().max((a + b).abs());
        // The controls of r and of r'.
        let r = [r0, r0 + r1 / 3.0, r0 + (2.0 * r1 + r2) / 3.0, r0 + r1 + r2 + r3];
        let slopes = [r1, r1 + r2, r1 + 2.0 * r2 + 3.0 * r3];
        let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let (r, slope) = (most(&r), most(&slopes));
        let (r_bend, z_bend) = (ends(2.0 * r2, 6.0 * r3), ends(2.0 * z2, 6.0 * z3));
        z_bend.max(slope * slope + r * r_bend).clamp(BEND[0], BEND[1])
    }

    /// r by powers, then z.
    #[inline(always)]
    pub(super) fn powers(&self) -> &[f64; WIDTH] {
        &self.powers
    }

    /// r, r', z and z'.
    #[inline(always)]
    fn at<const CONIC: bool>(&self, fma: impl Fused, s: f64) -> [f64; 4] {
        let [r0, r1, r2, r3, z0, z1, z2, z3] = self.powers;
        let (r, z) = ([r0, r1, r2, r3], [z0, z1, z2, z3]);
        if CONIC {
            let q = r[3];
            let per = 1.0 / fma.fused(q * s, 1.0 - s, 1.0);
            let slope = fma.fused(-2.0 * s, q, q);
            let [r, dr, ..] = quadratic(fma, &r, s);
            let [z, dz, ..] = quadratic(fma, &z, s);
            let (r, z) = (r * per, z * per);
            return [r, fma.fused(-r, slope, dr) * per, z, fma.fused(-z, slope, dz) * per];
        }
        let ([r, dr], [z, dz]) = (cubic(fma, &r, s), cubic(fma, &z, s));
        [r, dr, z, dz]
    }
}

#[inline(always)]
fn quadratic(fma: impl Fused, c: &[f64; 4], s: f64) -> [f64; 2] {
    let last = c[2] * s;
    [fma.fused(last + c[1], s, c[0]), last + last + c[1]]
}

/// A cubic with its derivative.
#[inline(always)]
fn cubic(fma: impl Fused, c: &[f64; 4], s: f64) -> [f64; 2] {
    let inner = fma.fused(c[3], s, c[2]);
    let value = fma.fused(fma.fused(inner, s, c[1]), s, c[0]);
    let slope = fma.fused(fma.fused(c[3], s, inner + inner), s, c[1]);
    [value, slope]
}

impl Leaf {
    /// A leaf of the piece with this number and this curve.
    pub(super) fn new(kind: Kind, piece: u32, curve: &Curve, fit: &Quadric) -> Self {
        let piece = piece << 1 | u32::from(matches!(kind, Kind::Conic(_)));
        let last = (LAST_STEP / curve.bend(kind).sqrt()) as f32;
        Self { valid: fit.valid.map(|s| s as f32), last, piece }
    }

    /// The piece that it is a part of.
    #[inline(always)]
    pub(super) fn piece(&self) -> u32 {
        self.piece >> 1
    }

    #[inline(always)]
    pub(super) fn is_conic(&self) -> bool {
        self.piece & 1 != 0
    }

    /// Between which parameters what is known of it holds.
    #[inline(always)]
    pub(super) fn valid(&self) -> [f64; 2] {
        self.valid.map(f64::from)
    }

    /// The square of the longest step in s that can be the last, where r is 1 or more.
    #[inline(always)]
    pub(super) fn last2(&self) -> f64 {
        let last = f64::from(self.last);
        last * last
    }

    /// The hit at a spot, which is the only one that the leaf can have there.
    #[inline(always)]
    pub(super) fn hit(
        &self,
        fma: impl Fused,
        curves: &[Curve],
        course: &Course,
        spot: Spot,
    ) -> Finding {
        let curve = &curves[self.piece() as usize];
        if self.is_conic() {
            self.hit_on::<true>(fma, curve, course, spot)
        } else {
            self.hit_on::<false>(fma, curve, course, spot)
        }
    }

    #[inline(always)]
    fn hit_on<const CONIC: bool>(
        &self,
        fma: impl Fused,
        curve: &Curve,
        course: &Course,
        spot: Spot,
    ) -> Finding {
        let first = Step::new::<CONIC>(fma, curve, course, spot.s, spot.tau);
        let mut step = Step::new::<CONIC>(fma, curve, course, first.s, first.tau);
        let mut more = MORE_STEPS;
        // Also where one is not a number.
        while !step.is_last(course, self.last2()) {
            if more == 0 {
                return Finding::Unknown;
            }
            more -= 1;
            step = Step::new::<CONIC>(fma, curve, course, step.s, step.tau);
        }
        self.judge(course, spot, &step)
    }

    /// Whether the hit that was found is the one that was looked for, on the piece and in the range.
    #[inline(always)]
    fn judge(&self, course: &Course, spot: Spot, step: &Step) -> Finding {
        let (s, tau) = (step.s, step.tau);
        // Both false where one is not a number.
        let there = (tau - spot.tau).abs() <= 2.0 * spot.blur;
        let valid = s >= f64::from(self.valid[0]) && s <= f64::from(self.valid[1]);
        if !(there && valid) {
            return Finding::Unknown;
        }
        let size = 2.0 + course.far + tau.abs() * course.turn;
        let rounding = ROUNDING * size * step.per.abs();
        let off_s = rounding * step.along;
        let off = rounding * step.across + 4.0 * UNIT_ROUNDOFF * (tau.abs() + course.shift.abs());
        let [start, end] = course.range;
        if s > off_s && s < 1.0 - off_s && tau > start + off && tau < end - off {
            return Finding::Hit { tau, s, margin: off };
        }
        if s < -off_s || s > 1.0 + off_s || tau < start - off || tau > end + off {
            return Finding::None;
        }
        Finding::Unknown
    }

    /// Whether there is surely no hit at a spot, on the piece and in the range.
    #[inline(always)]
    pub(super) fn misses(
        &self,
        fma: impl Fused,
        curves: &[Curve],
        course: &Course,
        spot: Spot,
    ) -> bool {
        matches!(self.hit(fma, curves, course, spot), Finding::None)
    }

    /// The hit at a spot, if it is certain at a glance that it is there: whatever must hold of it is asked
    /// of where Newton's last step but one leads, with room for the last one, and so need not wait for that.
    #[inline(always)]
    pub(super) fn quick(
        &self,
        fma: impl Fused,
        curves: &[Curve],
        course: &Course,
        spot: Spot,
    ) -> Option<Certain> {
        let curve = &curves[self.piece() as usize];
        if self.is_conic() {
            self.quick_on::<true>(fma, curve, course, spot)
        } else {
            self.quick_on::<false>(fma, curve, course, spot)
        }
    }

    #[inline(always)]
    fn quick_on<const CONIC: bool>(
        &self,
        fma: impl Fused,
        curve: &Curve,
        course: &Course,
        spot: Spot,
    ) -> Option<Certain> {
        let first = Step::new::<CONIC>(fma, curve, course, spot.s, spot.tau);
        let (mut s, mut tau) = (first.s, first.tau);
        let mut step = Step::new::<CONIC>(fma, curve, course, s, tau);
        let mut more = MORE_STEPS;
        while !step.is_last(course, self.last2()) {
            if more == 0 {
                return None;
            }
            more -= 1;
            (s, tau) = (step.s, step.tau);
            step = Step::new::<CONIC>(fma, curve, course, s, tau);
        }
        let room = LAST_PART * spot.blur;
        let there = (tau - spot.tau).abs() <= (2.0 - LAST_PART) * spot.blur;
        let [low, high] = self.valid();
        let last = f64::from(self.last);
        let valid = s >= low + last && s <= high - last;
        // As in `judge`, times the determinant.
        let size = 2.0 + course.far + (tau.abs() + room) * course.turn;
        let (rounding, determinant) = (ROUNDING * size, step.determinant.abs());
        let on_piece = (lesser(s, 1.0 - s) - last) * determinant > rounding * step.along;
        let [start, end] = course.range;
        let off = 4.0 * UNIT_ROUNDOFF * (tau.abs() + room + course.shift.abs());
        let in_range =
            (lesser(tau - start, end - tau) - room - off) * determinant > rounding * step.across;
        let sure = there & valid & on_piece & in_range & (step.by_tau.abs() <= room);
        let margin = rounding * step.across * step.per.abs() + off;
        sure.then_some(Certain { tau: step.tau, s: step.s, margin })
    }
}

/// A step of Newton's, and where it leads.
struct Step {
    s: f64,
    tau: f64,
    by_s: f64,
    by_tau: f64,
    /// The radius before the step.
    r: f64,
    determinant: f64,
    /// One over that.
    per: f64,
    /// By how much rounding in f and g, per unit of length, moves s and tau, times the determinant.
    along: f64,
    across: f64,
}

impl Step {
    #[inline(always)]
    fn new<const CONIC: bool>(
        fma: impl Fused,
        curve: &Curve,
        course: &Course,
        s: f64,
        tau: f64,
    ) -> Self {
        let (o, d) = (course.origin, course.direction);
        let [r, dr, z, dz] = curve.at::<CONIC>(fma, s);
        let (x, y) = (fma.fused(d.x, tau, o.x), fma.fused(d.y, tau, o.y));
        let f = fma.fused(-d.z, tau, z - o.z);
        // Without fused operations, so that x and y are alike: a quarter turn changes no bit.
        let g = 0.5 * ((x * x + y * y) - r * r);
        let rho = x * d.x + y * d.y;
        let w = r * dr;
        let determinant = fma.fused(dz, rho, -(w * d.z));
        let per = 1.0 / determinant;
        let by_s = fma.fused(f, rho, d.z * g) * per;
        let by_tau = fma.fused(dz, g, w * f) * per;
        Self {
            s: s - by_s,
            tau: tau - by_tau,
            by_s,
            by_tau,
            r,
            determinant,
            per,
            along: fma.fused(d.z.abs(), r, rho.abs()),
            across: r * (dr.abs() + dz.abs()),
        }
    }

    #[inline(always)]
    fn is_last(&self, course: &Course, last2: f64) -> bool {
        let r = lesser(self.r, 1.0);
        self.by_s * self.by_s <= last2 * r
            && self.by_tau * self.by_tau * course.length2 <= LAST_STEP2 * r
    }
}

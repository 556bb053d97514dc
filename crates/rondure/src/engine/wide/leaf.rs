//! The hits of a ray on a part of a piece, fast where they can be certified.
//!
//! F = X^2 + kappa - eta w (see [`meridian`](crate::meridian); w = r^2) has the derivative
//!
//! ```text
//! F' / 2 = slope X z' - eta r r' = z' (slope X - eta m),    m = r r' / z'.
//! ```
//!
//! At a root X^2 = eta w - kappa, so that on each half of the ray, X < 0 and X > 0, the roots on a leaf
//! lie between two values of X that come from the ends of the leaf; m lies in a range that is computed
//! once. If the two ranges, times slope and eta, have nothing in common, F' has one sign at all roots
//! on that half, and since F cannot cross zero twice in one direction there is one root or none,
//! according to the signs of F and X at the ends. Leaves that meet compute the same bits there, and
//! where pieces meet those are the bits that [`root`](crate::root) sees. The root is found by a few
//! Newton steps.
//!
//! Where there is no certificate, near tangencies above all, the whole piece is left to `root`.

use super::cone::slope_range;
use super::arithmetic::{Fused, greater, lesser};
use crate::meridian::Meridian;
use crate::numeric::gamma;
use crate::piece::{Kind, Piece};

/// A part of a piece: two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Leaf {
    /// r by powers of s, which runs from 0 to 1 on the leaf; for a conic the first three are those of
    /// r times its denominator 1 + q s + p s^2, and the last is q.
    r: [f64; 4],
    /// z likewise; for a conic the last is p.
    z: [f64; 4],
    /// r and z at s = 1, exactly; those at s = 0 are the first coefficients.
    end: [f64; 2],
    /// The range of m, in units of the radius, with room for rounding.
    slopes: [f32; 2],
    /// The parameter on the piece is `first + share s`.
    first: f64,
    share: f64,
    /// The piece, times two, and whether it is a conic.
    piece_and_kind: u32,
}

/// All hits on a leaf, as (s, t), s on the piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    None,
    One((f64, f64)),
    Two([(f64, f64); 2]),
    /// There is no certificate.
    Unknown,
}

/// A Newton step shorter than this part of the leaf is the last: what remains is the square of the
/// step times half the ratio of the second to the first derivative.
const LAST_STEP: f64 = 2e-8;
/// More are needed only where F' nearly vanishes.
const MOST_STEPS: u32 = 6;
/// How far a root may leave the leaf by rounding.
const OVERSHOOT: f64 = gamma(4096);
/// The share by which ranges must differ: more than f32 and rounding can make of it.
const CERTAIN: f64 = 1.0 / 1_048_576.0;

impl Leaf {
    /// The part of a piece that begins at the parameter `first` and is `share` long, and is the
    /// curve `part` itself. `unit` is one over the surface's radius, or near it.
    pub(super) fn new(
        pieces: &[Piece],
        piece: u32,
        part: &Piece,
        [first, share]: [f64; 2],
        unit: f64,
    ) -> Self {
        let outward = |m: f64, up: bool| {
            if up == (m >= 0.0) { m * (1.0 + CERTAIN) } else { m * (1.0 - CERTAIN) }
        };
        let [low, high] = slope_range(part, unit);
        let whole = &pieces[piece as usize];
        let [r, z] = match whole.kind {
            Kind::Conic(w) => {
                let (q, p) = (2.0 * (w - 1.0), -2.0 * (w - 1.0));
                let at_first = 1.0 + first * (q + first * p);
                // From the whole piece to the part, whose denominator begins with 1.
                let on_part = |b: f64, a: f64| {
                    [share * (b + 2.0 * first * a) / at_first, share * share * a / at_first]
                };
                let numerator = |whole: &[f64; 4]| {
                    let middle = w * whole[1];
                    on_part(2.0 * (middle - whole[0]), (whole[0] - middle) + (whole[3] - middle))
                };
                let ([rb, ra], [zb, za]) = (numerator(&whole.r), numerator(&whole.z));
                let [q, p] = on_part(q, p);
                [[part.r[0], rb, ra, q], [part.z[0], zb, za, p]]
            }
            kind => [&part.r, &part.z].map(|c| match kind {
                Kind::Line => [c[0], c[3] - c[0], 0.0, 0.0],
                Kind::Quadratic => [c[0], 2.0 * (c[1] - c[0]), (c[0] - c[1]) + (c[3] - c[1]), 0.0],
                _ => {
                    let (d0, d1, d2) = (c[1] - c[0], c[2] - c[1], c[3] - c[2]);
                    [c[0], 3.0 * d0, 3.0 * (d1 - d0), (d2 - d1) - (d1 - d0)]
                }
            }),
        };
        let is_conic = matches!(whole.kind, Kind::Conic(_));
        Self {
            r,
            z,
            end: [part.r[3], part.z[3]],
            slopes: [outward(low, false) as f32, outward(high, true) as f32],
            first,
            share,
            piece_and_kind: piece * 2 + u32::from(is_conic),
        }
    }

    /// The piece that it is a part of.
    #[inline(always)]
    pub(super) fn piece(&self) -> u32 {
        self.piece_and_kind / 2
    }

    /// The range of m.
    pub(super) fn slopes(&self) -> [f32; 2] {
        self.slopes
    }

    /// The only hit on the leaf, near a place given as a share of the leaf from its lower end.
    #[inline(always)]
    pub(super) fn hit(&self, fma: impl Fused, ray: &Meridian, guess: f32, above: bool) -> Found {
        let guess = f64::from(guess);
        let guess = if self.z[0] <= self.end[1] { guess } else { 1.0 - guess };
        self.newton(fma, ray, guess, above)
    }

    /// The heights of the two ends.
    #[inline(always)]
    pub(super) fn heights(&self) -> [f64; 2] {
        [self.z[0], self.end[1]]
    }

    /// The hits on the leaf, in no particular order, if they can be certified.
    #[inline(always)]
    pub(super) fn hits(&self, fma: impl Fused, ray: &Meridian, unit: f64) -> Found {
        let x = self.heights().map(|z| ray.x(z));
        let radii = [self.r[0], self.end[0]];
        let f = [ray.form([x[0]; 2], [radii[0]; 2]), ray.form([x[1]; 2], [radii[1]; 2])];
        // |X| at roots, by w at the ends.
        let reach = radii.map(|r| greater(ray.eta * (r * r) - ray.kappa(), 0.0).sqrt());
        let scale = ray.slope() * unit;
        let [near, far] = [lesser(reach[0], reach[1]), greater(reach[0], reach[1])];
        let [near, far] = [scale * near, scale * far];
        let [low, high] = self.slopes.map(|m| ray.eta * f64::from(m));
        let (above, below) = ([x[0] >= 0.0, x[1] >= 0.0], [x[0] < 0.0, x[1] < 0.0]);
        // slope X - eta m: whether it is positive, or negative, on the half of X > 0 and of X < 0.
        let (least, most) = (lesser(near, far), greater(near, far));
        let positive = [least > high, -most > high];
        let negative = [most < low, -least < low];
        let changes = (f[0] < 0.0) != (f[1] < 0.0);
        // On which half a root lies, if there is one, and where F or, for a shallow ray, its
        // factor |X| - reach begins and ends on that half.
        let across = above[0] != above[1];
        let (wanted, certain) = if !across {
            let half = usize::from(below[0]);
            let mut wanted = [false; 2];
            wanted[half] = changes;
            (wanted, positive[half] | negative[half])
        } else if ray.steep {
            // One and the same function of s, with X of both signs.
            let certain = positive[0] & positive[1] | negative[0] & negative[1];
            ([changes, false], certain)
        } else {
            // The ray's closest approach to the axis, X = 0, lies within the heights of the leaf: both
            // halves may hit it, each between there and one end. There must be no doubt that F < 0
            // at X = 0.
            let beyond = f.map(|f| f >= 0.0);
            let wanted = if above[0] { beyond } else { [beyond[1], beyond[0]] };
            let certain = (positive[0] | negative[0]) & (positive[1] | negative[1]);
            (wanted, certain && near * near > CERTAIN * (scale * scale) * ray.magnitude(0.0, far))
        };
        if !certain {
            return Found::Unknown;
        }
        let mut found = Found::None;
        for half in 0..2 {
            if !wanted[half] {
                continue;
            }
            let sign = if half == 0 { 1.0 } else { -1.0 };
            let g = if ray.steep { f } else { [sign * x[0] - reach[0], sign * x[1] - reach[1]] };
            found = match (found, self.newton(fma, ray, g[0] / (g[0] - g[1]), half == 0)) {
                (Found::One(a), Found::One(b)) => Found::Two([a, b]),
                (_, one) => one,
            };
            if found == Found::Unknown {
                break;
            }
        }
        found
    }

    /// The root of F near a guess, on one half of the ray if that is shallow; unknown if the steps
    /// lead elsewhere.
    #[inline(always)]
    fn newton(&self, fma: impl Fused, ray: &Meridian, guess: f64, above: bool) -> Found {
        let mut s = guess - self.step(fma, ray, guess).0;
        s -= self.step(fma, ray, s).0;
        for _ in 2..MOST_STEPS {
            let (step, x, [r, dr], [z, dz]) = self.step(fma, ray, s);
            s -= step;
            if step.abs() <= LAST_STEP {
                let (r, z) = (fma.fused(-step, dr, r), fma.fused(-step, dz, z));
                let inside = s >= -OVERSHOOT && s <= 1.0 + OVERSHOOT;
                if !(inside && (ray.steep || (x >= 0.0) == above)) {
                    return Found::Unknown;
                }
                let s = greater(lesser(s, 1.0), 0.0);
                let t = ray.t(greater(r, 0.0), z, above);
                return Found::One((fma.fused(s, self.share, self.first), t));
            }
        }
        Found::Unknown
    }

    /// F / F', X, and r and z with their derivatives.
    #[inline(always)]
    fn step(
        &self,
        fma: impl Fused,
        ray: &Meridian,
        s: f64,
    ) -> (f64, f64, [f64; 2], [f64; 2]) {
        let (r, z) = self.jet(fma, s);
        let x = ray.x(z[0]);
        let value = ray.form([x; 2], [r[0]; 2]);
        let half = fma.fused(ray.slope() * x, z[1], -(ray.eta * (r[0] * r[1])));
        (0.5 * value / half, x, r, z)
    }

    /// r and z, each with its derivative by s.
    #[inline(always)]
    fn jet(&self, fma: impl Fused, s: f64) -> ([f64; 2], [f64; 2]) {
        if self.piece_and_kind & 1 == 1 {
            let (q, p) = (self.r[3], self.z[3]);
            let per = 1.0 / fma.fused(fma.fused(p, s, q), s, 1.0);
            let slope = fma.fused(2.0 * p, s, q);
            (quotient(fma, &self.r, s, per, slope), quotient(fma, &self.z, s, per, slope))
        } else {
            (polynomial(fma, &self.r, s), polynomial(fma, &self.z, s))
        }
    }
}

/// The value and the derivative of a cubic.
#[inline(always)]
fn polynomial(fma: impl Fused, c: &[f64; 4], s: f64) -> [f64; 2] {
    let inner = fma.fused(c[3], s, c[2]);
    let value = fma.fused(fma.fused(inner, s, c[1]), s, c[0]);
    let slope = fma.fused(fma.fused(c[3], s, inner + inner), s, c[1]);
    [value, slope]
}

/// The value and the derivative of a quadratic times `q`, whose inverse has the derivative `dq`.
#[inline(always)]
fn quotient(fma: impl Fused, c: &[f64; 4], s: f64, q: f64, dq: f64) -> [f64; 2] {
    let value = q * fma.fused(fma.fused(c[2], s, c[1]), s, c[0]);
    let slope = fma.fused(2.0 * c[2], s, c[1]);
    [value, q * fma.fused(-value, dq, slope)]
}

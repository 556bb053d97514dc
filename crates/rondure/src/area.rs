//! Points chosen on a surface evenly by area, and the density with which they are.
//!
//! The band that a piece sweeps up to the parameter s has the area
//!
//! ```text
//! A(s) = 2 pi ∫ r(s) |p'(s)| ds
//! ```
//!
//! A number u in [0, 1] chooses the s at which A(s) is u times the whole, another one the angle round
//! the axis. The
//! integrand is tabulated between knots so near to each other that the rule of `measure/quadrature.rs`
//! is exact there but for rounding; a bracketed Newton iteration inverts A in between. So the map from
//! the unit square is continuous on each subpath, smooth on each piece, and keeps areas in proportion
//! to rounding.
//!
//! A placement L stretches areas by |det L| / |L^T n|, with n the normal in the world. Where that is not
//! the same everywhere, points stay even by the area of the surface in its own frame, and it is
//! their density that varies.

use core::f64::consts::TAU;

use crate::interaction::{Interaction, interaction_at};
use crate::measure::quadrature::gauss;
use crate::numeric::{gamma, reciprocal_power_of_two};
use crate::piece::{Kind, Piece};
use crate::{Affine, Surface, Vec3};

/// How often a piece is halved at most in search of stretches on which its area is smooth.
const DEEPEST: u32 = 50;

/// The rounding of an area by sixteen nodes, relative to the area.
const ROUNDING: f64 = gamma(32);

/// What is needed to choose points of one surface evenly by area.
///
/// It is a table beside the surface, so that surfaces which are never sampled do not carry it. Make
/// one for each surface, for all its placements: see [`Surface::sample`],
/// [`Instance::sample`](crate::Instance::sample) and [`Instances::sample`](crate::Instances::sample).
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use rondure::{AreaSampler, Profile, Surface};
///
/// let torus = Profile::from_path_data("M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z")?;
/// let torus = Surface::new(&torus);
/// let sampler = AreaSampler::new(&torus).ok_or("it sweeps no area")?;
/// assert!((sampler.area() - 8.0 * std::f64::consts::PI.powi(2)).abs() < 1e-12);
/// let sample = torus.sample(&sampler, [0.25, 0.7]);
/// assert_eq!(sample.area_pdf, 1.0 / sampler.area());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct AreaSampler {
    /// In the order of the pieces; none is empty.
    stretches: Vec<Stretch>,
    /// The area of all of them over 2 pi.
    whole: f64,
}

/// A stretch of a piece on which the quadrature is exact but for rounding.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    piece: u32,
    s: [f64; 2],
    /// r |p'| at both ends.
    density: [f64; 2],
    /// The area over 2 pi of the stretches before this one, and of it.
    before: f64,
    own: f64,
}

/// A point chosen on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// The point, the normal and the partial derivatives there, as for a hit.
    pub surface: Interaction,
    /// The density with which the point was chosen, per unit of the surface's area in the world at the
    /// point. Its integral over the surface is 1.
    pub area_pdf: f64,
    /// The piece of the profile, as in [`Hit::piece`](crate::Hit::piece).
    pub piece: u32,
    /// The parameter on the piece, from 0 to 1.
    pub s: f64,
}

impl AreaSampler {
    /// Tabulates the area of a surface; `None` if it sweeps no area: all of its profile lies on the
    /// axis, or so near to it that its area is no positive f64.
    pub fn new(surface: &Surface) -> Option<Self> {
        let mut stretches = Vec::new();
        let mut whole = 0.0;
        for (piece, i) in surface.pieces.iter().zip(0..) {
            for (s, own) in smooth_stretches(&piece) {
                if own > 0.0 {
                    let density = s.map(|s| density(&piece, s));
                    stretches.push(Stretch { piece: i, s, density, before: whole, own });
                    whole += own;
                }
            }
        }
        let area = whole * TAU;
        (area > 0.0 && area.is_finite() && (1.0 / area).is_finite())
            .then_some(Self { stretches, whole })
    }

    /// The area of the surface in its own frame. Of what several subpaths or turns sweep in the same
    /// place each counts.
    pub fn area(&self) -> f64 {
        self.whole * TAU
    }

    /// The bytes of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.stretches)
    }

    /// The piece and the parameter below which the share `u` of the area lies, from 0 to 1, in drawing
    /// order.
    fn place(&self, surface: &Surface, u: f64) -> (u32, f64) {
        let target = u.clamp(0.0, 1.0) * self.whole;
        let after = self.stretches.partition_point(|stretch| stretch.before <= target);
        // The first stretch has nothing before it.
        let stretch = &self.stretches[after.saturating_sub(1)];
        let target = (target - stretch.before).clamp(0.0, stretch.own);
        let mut room = None;
        let piece = surface.pieces.at(stretch.piece as usize, &mut room);
        (stretch.piece, stretch.invert(piece, target))
    }

    /// The factor by which a placement stretches areas at a place whose normal in the world is `normal`.
    fn stretch(placement: &Affine, normal: Vec3) -> f64 {
        let [x, y, z] = placement.columns;
        let unit = reciprocal_power_of_two(x.max_abs().max(y.max_abs()).max(z.max_abs()));
        let scaled = Affine { columns: [x * unit, y * unit, z * unit], translation: Vec3::ZERO };
        let across = Vec3::new(
            scaled.columns[0].dot(normal),
            scaled.columns[1].dot(normal),
            scaled.columns[2].dot(normal),
        );
        scaled.determinant().abs() / across.length() / (unit * unit)
    }

    /// The density at a place of the placed surface whose unit normal is `normal`.
    pub(crate) fn placed_pdf(&self, placement: &Affine, normal: Vec3) -> f64 {
        1.0 / (self.area() * Self::stretch(placement, normal))
    }

    /// A point of the surface placed in the world; `inverse` has the rows of the placement's inverse.
    pub(crate) fn placed(
        &self,
        surface: &Surface,
        placement: &Affine,
        inverse: Option<&[Vec3; 3]>,
        rounding: f64,
        u: [f64; 2],
    ) -> SurfaceSample {
        let (piece, s) = self.place(surface, u[1]);
        let surface = interaction_at(surface, inverse, placement, rounding, u[0], (piece, s));
        let area_pdf = match inverse {
            Some(_) => self.placed_pdf(placement, surface.normal),
            None => 1.0 / self.area(),
        };
        SurfaceSample { surface, area_pdf, piece, s }
    }
}

impl Stretch {
    /// The parameter at which the area over 2 pi, from the start of the stretch, reaches `target`.
    fn invert(&self, piece: &Piece, target: f64) -> f64 {
        let [from, to] = self.s;
        let [a, b] = self.density;
        let share = target / self.own;
        // Were the density linear, as it is on a line: a x + (b - a) x^2 / 2 = share (a + b) / 2.
        let guess = share * (a + b) / (a + (a * a + share * (b - a) * (b + a)).max(0.0).sqrt());
        let guess = if guess.is_finite() { guess.clamp(0.0, 1.0) } else { share };
        let mut s = (from + (to - from) * guess).clamp(from, to);
        if piece.kind == Kind::Line || target == 0.0 || target == self.own {
            return s;
        }
        let [mut low, mut high] = self.s;
        loop {
            let [reached] = gauss(|s| [density(piece, s)], [from, s]);
            let excess = reached - target;
            if excess.abs() <= ROUNDING * target {
                return s;
            }
            if excess > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let newton = s - excess / density(piece, s);
            let next =
                if low < newton && newton < high { newton } else { low + 0.5 * (high - low) };
            // The bracket holds no other number, or the step is below rounding.
            if next == s || next <= low || next >= high {
                return next;
            }
            s = next;
        }
    }
}

/// r |p'|: the area over 2 pi by s.
fn density(piece: &Piece, s: f64) -> f64 {
    let jet = piece.jet(s);
    jet.point.r.max(0.0) * jet.tangent.length()
}

/// How far off rounding can make the area over 2 pi of a whole piece: its derivative is a difference of
/// fewer than 32 operations on coordinates, which may be much larger than it.
fn rounding(piece: &Piece) -> f64 {
    let largest = |c: &[f64; 4]| c.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let (r, z) = (largest(&piece.r), largest(&piece.z));
    gamma(32) * r * r.max(z)
}

/// The stretches of a piece on which its area is smooth, and the area over 2 pi of each.
fn smooth_stretches(piece: &Piece) -> Vec<([f64; 2], f64)> {
    if piece.kind == Kind::Line {
        let (start, end) = (piece.start(), piece.end());
        return vec![([0.0, 1.0], 0.5 * (start.r + end.r) * (end - start).length())];
    }
    let area = |s: [f64; 2]| gauss(|s| [density(piece, s)], s)[0];
    let whole = area([0.0, 1.0]);
    let enough = ROUNDING * whole + rounding(piece);
    let mut stretches = Vec::new();
    let mut stack = vec![([0.0, 1.0], whole, 0)];
    while let Some(([from, to], coarse, depth)) = stack.pop() {
        let middle = 0.5 * (from + to);
        let halves = [[from, middle], [middle, to]];
        let [left, right] = halves.map(area);
        let apart = ((left + right) - coarse).abs();
        // An area that is not finite is not made so by halves.
        if depth == DEEPEST || apart <= enough || !apart.is_finite() {
            stretches.push(([from, to], left + right));
        } else {
            stack.extend([(halves[1], right, depth + 1), (halves[0], left, depth + 1)]);
        }
    }
    stretches
}

impl Surface {
    /// A point chosen evenly by area: `u`, two numbers from 0 to 1, are the angle round the axis over
    /// 2 pi, and the share of the area that lies before the point in drawing order.
    ///
    /// Of a [polyline engine](Self::with_engine) the points lie on its frusta.
    ///
    /// # Panics
    /// As all methods that take a sampler: perhaps, if it was made for another surface.
    pub fn sample(&self, sampler: &AreaSampler, u: [f64; 2]) -> SurfaceSample {
        let placement = &Affine::IDENTITY;
        sampler.placed(self, placement, None, self.rounding(placement), u)
    }
}

impl Interaction {
    /// The density by solid angle, seen from the point `from`, of what is chosen here with the density
    /// `area_pdf` by area: d^2 area_pdf / |cos|, infinite where the surface is seen edge on.
    pub fn solid_angle_pdf(&self, area_pdf: f64, from: Vec3) -> f64 {
        let to_here = self.point - from;
        let distance = to_here.length();
        let cos = self.normal.dot(to_here / distance).abs();
        if distance > 0.0 { distance * distance * area_pdf / cos } else { 0.0 }
    }
}

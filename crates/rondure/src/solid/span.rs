//! Spans: the stretches of a ray inside a solid, made of its crossings.
//!
//! The rules, with their reasons, stand in `docs/solids.md`. Crossings at the same t, up to rounding,
//! count together, so that what comes out is ordered and disjoint, and neither a span nor a gap is
//! nothing but rounding.

use super::FillRule;
use crate::numeric::{gamma, reciprocal_power_of_two};
use crate::{Hit, Vec3};

/// A stretch of a ray inside a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<W = Wall> {
    /// Where the ray comes in.
    pub enter: Boundary<W>,
    /// Where it goes out, at a larger t.
    pub exit: Boundary<W>,
}

impl<W> Span<W> {
    /// The length of the span in units of the ray's direction.
    #[inline]
    pub fn length(&self) -> f64 {
        self.exit.t - self.enter.t
    }
}

/// One end of a span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary<W = Wall> {
    /// The ray parameter, in units of the ray's direction.
    pub t: f64,
    /// What bounds the solid there; `None` where the ray itself begins or ends inside.
    pub wall: Option<W>,
}

/// Where a ray passes the surface of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// The hit.
    pub hit: Hit,
    /// 1 if the outside is to the right of the profile's drawing direction there, -1 if to the left.
    pub outside: i32,
}

/// A hit, and by how much the winding number grows there as the ray goes on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub(crate) hit: Hit,
    pub(crate) step: i32,
}

/// Sorts the crossings of a whole line and appends its spans between two parameters. `coincide` tells
/// of two crossings in order whether they may lie at the same place.
pub(crate) fn append_spans(
    crossings: &mut [Crossing],
    rule: FillRule,
    coincide: impl Fn(&Crossing, &Crossing) -> bool,
    range: [f64; 2],
    spans: &mut Vec<Span>,
) {
    crossings.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t).then(a.hit.piece.cmp(&b.hit.piece)));
    let mut clip = Clip { range, enter: None };
    let mut winding = 0;
    for together in crossings.chunk_by(|a, b| a.hit.t == b.hit.t || coincide(a, b)) {
        let step: i32 = together.iter().map(|c| c.step).sum();
        let before = rule.is_inside(winding);
        winding += step;
        let after = rule.is_inside(winding);
        if before == after {
            continue;
        }
        // By the non-zero rule one of them goes the way of all together. A step of 1 comes from the
        // right of the profile, which is outside if the ray enters.
        let fits = |c: &&Crossing| rule == FillRule::EvenOdd || c.step == step.signum();
        let Some(&Crossing { hit, step }) = together.iter().find(fits) else { continue };
        let wall = Wall { hit, outside: if after { step } else { -step } };
        clip.boundary(Boundary { t: hit.t, wall: Some(wall) }, after, spans);
    }
    clip.finish(spans);
}

/// Cuts spans to a range while they are made: what is left of them has a positive length.
pub(crate) struct Clip<W> {
    pub(crate) range: [f64; 2],
    /// Where the span began that is not finished yet.
    pub(crate) enter: Option<Boundary<W>>,
}

impl<W> Clip<W> {
    /// The next boundary along the line.
    pub(crate) fn boundary(&mut self, at: Boundary<W>, enters: bool, spans: &mut Vec<Span<W>>) {
        if enters {
            self.enter = Some(at);
        } else if let Some(enter) = self.enter.take() {
            self.push(enter, at, spans);
        }
    }

    /// The end of the line.
    pub(crate) fn finish(&mut self, spans: &mut Vec<Span<W>>) {
        if let Some(enter) = self.enter.take() {
            self.push(enter, Boundary { t: self.range[1], wall: None }, spans);
        }
    }

    fn push(&self, enter: Boundary<W>, exit: Boundary<W>, spans: &mut Vec<Span<W>>) {
        let [low, high] = self.range;
        let enter = if enter.t < low { Boundary { t: low, wall: None } } else { enter };
        let exit = if exit.t > high { Boundary { t: high, wall: None } } else { exit };
        // A range that is not a number holds nothing.
        if low <= high && enter.t < exit.t {
            spans.push(Span { enter, exit });
        }
    }
}

/// How far apart the parameters of two hits may be found that lie at the same place.
///
/// Where a computed surface and a computed ray are off by no more than `off` each, what moves the
/// surface by that along its normal moves a hit by that over the sine of its incidence. Faces that
/// coincide have the same sine; of two that do not, the larger one says whether the hits can be told
/// apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coincidence {
    /// The length of the ray's direction.
    speed: f64,
}

/// Hits farther apart than `off` times this are told apart unasked: they could coincide only under an
/// incidence of less than its reciprocal, where nothing is known of a hit but that it is somewhere.
const GRAZING: f64 = 1e10;

impl Coincidence {
    pub(crate) fn new(direction: Vec3) -> Self {
        // The length, from coordinates brought near 1.
        let scale = reciprocal_power_of_two(direction.max_abs());
        Self { speed: (direction * scale).length() / scale }
    }

    /// The length of the ray's direction.
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }

    /// Whether two hits at t_a <= t_b may lie at the same place. `off` bounds the rounding of either
    /// surface, and of the ray beside it, as a length; `sines` tells the sine of either incidence.
    #[inline]
    pub(crate) fn holds(
        &self,
        t_a: f64,
        t_b: f64,
        off: f64,
        sines: impl FnOnce() -> [f64; 2],
    ) -> bool {
        let apart = (t_b - t_a - gamma(4) * t_a.abs().max(t_b.abs())) * self.speed;
        if apart <= 0.0 || apart > GRAZING * off {
            return apart <= 0.0;
        }
        let [a, b] = sines();
        apart * a.max(b) <= 4.0 * off
    }

    /// The sine of the incidence on a surface with this unit normal.
    pub(crate) fn sine(&self, normal: Vec3, direction: Vec3) -> f64 {
        (normal.dot(direction) / self.speed).abs()
    }
}

//! The wide engine: sixteen pieces of the profile tested at once.
//!
//! ```text
//! LocalRay -> Meridian -> Line -> boxes (f32 x 16) -> blocks (f32 x 16) -> leaves (f64) -> hits
//! ```
//!
//! [`cull`] finds the pieces that a ray may hit, in f32 with room for its rounding; [`leaf`] finds
//! the hits on them in f64 where it can certify how many there are, and otherwise leaves the piece to
//! the exact engine's [`root`]. Where rounding could decide which hit comes first, or whether one is in
//! the ray's range, the whole ray is left to it. Both engines therefore find the same hits on the same
//! pieces, t apart by rounding.
//!
//! All data is flat: one array for each kind of thing, no pointers. The instruction set is chosen at run
//! time.

mod arithmetic;
mod batch;
mod cone;
mod course;
mod cull;
mod leaf;

use arrayvec::ArrayVec;
use fearless_simd::{Level, Simd, dispatch};

use self::arithmetic::{Best, Fused};
use self::course::{Approach, Course};
use self::cull::{Block, Boxes, Hits, LANES, Line, Roots};
use self::leaf::Leaf;
use super::counters::Count;
use crate::Ray;
use crate::frame::{Frame, LocalRay};
use crate::meridian::Meridian;
use crate::numeric::{gamma, reciprocal_power_of_two};
use crate::piece::{Kind, Piece};
use crate::root;
use crate::surface::Hit;

/// A profile of so many blocks needs no boxes over them.
const FEW_BLOCKS: usize = 4;

/// Hits nearer to each other, or to an end of the ray's range, than this part of the radius come in an
/// order that is left to the exact engine to decide: t is good to about a tenth of it.
const NEAR: f64 = gamma(8192);

/// The pieces of a profile, ready to be tested sixteen at a time.
#[derive(Clone, Debug)]
pub(crate) struct Wide {
    level: Level,
    /// A power of two that brings the radius to between 1 and 2.
    unit: f64,
    radius: f64,
    /// A ray that passes the axis at a larger squared distance hits nothing.
    reach2: f64,
    /// In order of height, by and large.
    blocks: Vec<Block>,
    /// One for each piece, in the order of the blocks' lanes.
    leaves: Vec<Leaf>,
    /// The boxes round the blocks, if there are more than a few.
    boxes: Vec<Boxes>,
}

impl Wide {
    /// Builds the engine over the pieces of a profile, none of whose points is farther from the
    /// origin than `radius`.
    pub(crate) fn new(pieces: &[Piece], radius: f64, level: Level) -> Self {
        let unit = reciprocal_power_of_two(radius);
        let mut parts = parts(pieces, unit);
        arrange(&mut parts);
        let new_leaf = |p: &Part| Leaf::new(pieces, p.piece, &p.curve, p.place, unit);
        let leaves: Vec<_> = parts.iter().map(new_leaf).collect();
        let mut blocks = Vec::new();
        let mut groups = Vec::new();
        for (lanes, leaves) in parts.chunks(LANES).zip(leaves.chunks(LANES)) {
            let mut block = Block::EMPTY;
            for (lane, (part, leaf)) in lanes.iter().zip(leaves).enumerate() {
                block.set(lane, &part.curve, leaf.slopes(), unit);
            }
            blocks.push(block);
            groups.push(lanes);
        }
        let boxes = if blocks.len() <= FEW_BLOCKS {
            Vec::new()
        } else {
            let vectors = groups.chunks(LANES).map(|groups| {
                let mut vector = Boxes::EMPTY;
                for (lane, group) in groups.iter().enumerate() {
                    vector.set(lane, group.iter().map(|part| &part.curve), unit);
                }
                vector
            });
            vectors.collect()
        };
        let r_max = pieces.iter().fold(0.0_f64, |m, p| m.max(p.r[0]).max(p.r[3]));
        let reach = r_max + gamma(64) * radius;
        Self { level, unit, radius, reach2: reach * reach, blocks, leaves, boxes }
    }

    /// The number of vectors of boxes and pieces.
    pub(crate) fn node_count(&self) -> usize {
        self.blocks.len() + self.boxes.len()
    }

    pub(crate) fn closest(&self, pieces: &[Piece], frame: &Frame, ray: &Ray) -> Option<Hit> {
        dispatch!(self.level, simd => self.closest_with(simd, pieces, frame, ray))
    }

    pub(crate) fn any(&self, pieces: &[Piece], frame: &Frame, ray: &Ray) -> bool {
        dispatch!(self.level, simd => self.any_with(simd, pieces, frame, ray))
    }

    pub(crate) fn all(&self, pieces: &[Piece], frame: &Frame, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        dispatch!(self.level, simd => self.all_with(simd, pieces, frame, ray, hits));
    }

    /// Calls `visit` once for every piece that the ray may hit, as
    /// [`Engine::walk`](super::Engine::walk).
    pub(crate) fn candidates<C: Count>(
        &self,
        ray: &Meridian,
        range: [f64; 2],
        count: &mut C,
        mut visit: impl FnMut(u32) -> f64,
    ) {
        let mut line = Line::of(ray, range, self.unit);
        let mut seen = Vec::new();
        dispatch!(self.level, simd => self.walk(
            simd,
            &mut line,
            false,
            count,
            #[inline(always)]
            |line, leaf, _| {
                let piece = self.leaves[leaf].piece();
                if seen.contains(&piece) {
                    return true;
                }
                seen.push(piece);
                let end = visit(piece);
                if end < f64::INFINITY {
                    line.end_at(end);
                }
                end > f64::NEG_INFINITY
            },
        ));
    }

    #[inline(always)]
    fn closest_with<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
    ) -> Option<Hit> {
        let (approach, course) = self.approach(frame, ray);
        match approach {
            Approach::Misses => return None,
            Approach::Meets => {}
            Approach::Strange => return self.closest_exactly(pieces, frame, ray),
        }
        let range = Range::new(self, &course, ray);
        let mut closest: Option<Hit> = None;
        let mut doubt = false;
        let mut line = Line::along(&course, range.of_course, self.unit);
        self.walk(
            simd,
            &mut line,
            false,
            &mut (),
            #[inline(always)]
            |line, leaf, known| {
                let leaf = &self.leaves[leaf];
                let mut consider = |hit: Hit| {
                    if let Some(best) = closest {
                        // Rounding must not choose between pieces.
                        doubt |= (hit.t - best.t).abs() < range.near && best.piece != hit.piece;
                    }
                    if closest.is_none_or(|best| hit.t < best.t) {
                        closest = Some(hit);
                        line.end_at(hit.t - course.shift);
                    }
                };
                let piece = leaf.piece();
                let report = |s, t| consider(Hit { t, piece, s });
                if !range.hits(Best(simd), leaf, &course, known, report) {
                    self.exact_hits(pieces, frame, ray, piece).into_iter().for_each(consider);
                }
                !doubt
            },
        );
        if doubt { self.closest_exactly(pieces, frame, ray) } else { closest }
    }

    #[inline(always)]
    fn any_with<S: Simd>(&self, simd: S, pieces: &[Piece], frame: &Frame, ray: &Ray) -> bool {
        let (approach, course) = self.approach(frame, ray);
        match approach {
            Approach::Misses => return false,
            Approach::Meets => {}
            Approach::Strange => return self.closest_exactly(pieces, frame, ray).is_some(),
        }
        let range = Range::new(self, &course, ray);
        let mut line = Line::along(&course, range.of_course, self.unit);
        let mut found = false;
        let inside = self.walk(
            simd,
            &mut line,
            true,
            &mut (),
            #[inline(always)]
            |_, leaf, known| {
                let leaf = &self.leaves[leaf];
                if !range.hits(Best(simd), leaf, &course, known, |_, _| found = true) {
                    found |= !self.exact_hits(pieces, frame, ray, leaf.piece()).is_empty();
                }
                !found
            },
        );
        inside || found
    }

    #[inline(always)]
    fn all_with<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        hits: &mut Vec<Hit>,
    ) {
        let (approach, course) = self.approach(frame, ray);
        match approach {
            Approach::Misses => return,
            Approach::Meets => {}
            Approach::Strange => return self.all_exactly(pieces, frame, ray, hits),
        }
        let range = Range::new(self, &course, ray);
        let mut line = Line::along(&course, range.of_course, self.unit);
        let mut doubt = false;
        self.walk(
            simd,
            &mut line,
            false,
            &mut (),
            #[inline(always)]
            |_, leaf, known| {
                let leaf = &self.leaves[leaf];
                let piece = leaf.piece();
                let report = |s, t| hits.push(Hit { t, piece, s });
                doubt = !range.hits(Best(simd), leaf, &course, known, report);
                !doubt
            },
        );
        sort(hits);
        if doubt || hits.windows(2).any(|pair| pair[1].t - pair[0].t < range.near) {
            self.all_exactly(pieces, frame, ray, hits);
        }
    }

    #[inline(always)]
    fn approach(&self, frame: &Frame, ray: &Ray) -> (Approach, Course) {
        Course::new(frame, ray, self.radius, self.reach2)
    }

    /// The hits on one piece as the exact engine finds them.
    #[cold]
    #[inline(never)]
    fn exact_hits(&self, pieces: &[Piece], frame: &Frame, ray: &Ray, piece: u32) -> Few {
        let mut hits = Few::new();
        if let Some(query) = Query::new(frame, ray) {
            query.hits(pieces, piece, |hit| {
                // No more can come than there is room for.
                let _ = hits.try_push(hit);
            });
        }
        hits
    }

    /// The closest hit as the exact engine finds it.
    #[cold]
    #[inline(never)]
    fn closest_exactly(&self, pieces: &[Piece], frame: &Frame, ray: &Ray) -> Option<Hit> {
        if let Some((ray, scale)) = rescaled(ray) {
            let hit = self.closest(pieces, frame, &ray);
            return hit.map(|hit| Hit { t: hit.t * scale, ..hit });
        }
        let query = Query::new(frame, ray)?;
        let mut closest: Option<Hit> = None;
        let mut end = query.local.range[1];
        self.candidates(&query.meridian, query.local.range, &mut (), |piece| {
            query.hits(pieces, piece, |hit| {
                let order = |h: &Hit| (h.t, h.piece);
                if closest.is_none_or(|best| order(&hit) < order(&best)) {
                    closest = Some(hit);
                    end = query.local.local_t(hit.t);
                }
            });
            end
        });
        closest
    }

    /// All hits as the exact engine finds them.
    #[cold]
    #[inline(never)]
    fn all_exactly(&self, pieces: &[Piece], frame: &Frame, ray: &Ray, hits: &mut Vec<Hit>) {
        if let Some((ray, scale)) = rescaled(ray) {
            self.all(pieces, frame, &ray, hits);
            hits.iter_mut().for_each(|hit| hit.t *= scale);
            return;
        }
        hits.clear();
        let Some(query) = Query::new(frame, ray) else { return };
        self.candidates(&query.meridian, query.local.range, &mut (), |piece| {
            query.hits(pieces, piece, |hit| hits.push(hit));
            f64::INFINITY
        });
        sort(hits);
    }

    /// Visits the leaves that a line may hit, near ones first by and large, as long as `visit` says
    /// so; it may shorten the line. Stops with true at the first certain hit within the line if `any`
    /// is all that is asked.
    #[inline(always)]
    fn walk<S: Simd, C: Count>(
        &self,
        simd: S,
        line: &mut Line,
        any: bool,
        count: &mut C,
        mut visit: impl FnMut(&mut Line, usize, Option<Roots>) -> bool,
    ) -> bool {
        let rises = line.rises();
        let mut hits = Hits::NONE;
        let few = self.boxes.is_empty();
        // So many blocks that the boxes round them fill a mask.
        const MANY: usize = 4 * LANES;
        let chunks = self.blocks.len().div_ceil(MANY);
        for chunk in 0..chunks {
            let first = MANY * if rises { chunk } else { chunks - 1 - chunk };
            let mut waiting = 0;
            if few {
                waiting = (1_u64 << self.blocks.len()) - 1;
            } else {
                let last = self.boxes.len().min((first + MANY) / LANES);
                for (i, boxes) in self.boxes[first / LANES..last].iter().enumerate() {
                    count.test();
                    waiting |= u64::from(boxes.test(simd, line)) << (i * LANES);
                }
            }
            while let Some(block) = take(&mut waiting, rises) {
                count.enter();
                count.test();
                let block = first + block;
                self.blocks[block].test(simd, line, &mut hits);
                if any && hits.sure & hits.inside != 0 {
                    return true;
                }
                let mut lanes = u64::from(hits.sure | hits.unsure);
                while let Some(lane) = take(&mut lanes, rises) {
                    let leaf = block * LANES + lane;
                    count.positive();
                    if line.ends_before(self.leaves[leaf].heights()) {
                        continue;
                    }
                    count.solve();
                    if !visit(line, leaf, hits.roots(lane)) {
                        return false;
                    }
                }
            }
        }
        false
    }
}

/// Between which parameters hits count.
#[derive(Clone, Copy)]
struct Range {
    /// In the course's own parameter.
    of_course: [f64; 2],
    shift: f64,
    near: f64,
}

/// What is known of the hits on a leaf.
enum Finding {
    /// There are none in the range.
    Outside,
    /// This is the only one, with its place on the piece.
    Hit((f64, f64)),
    /// That is for the exact engine to say.
    Unknown,
}

impl Range {
    #[inline(always)]
    fn new(wide: &Wide, course: &Course, ray: &Ray) -> Self {
        let of_course = [ray.t_min - course.shift, ray.t_max - course.shift];
        // The direction is no shorter than 2^-10; what the shift is off, both ends are.
        let near = NEAR * 1024.0 * wide.radius + gamma(8) * course.shift.abs();
        Self { of_course, shift: course.shift, near }
    }

    /// The hit on a leaf at a root that is certain.
    #[inline(always)]
    fn find(
        &self,
        fma: impl Fused,
        leaf: &Leaf,
        course: &Course,
        guess: f32,
        above: bool,
    ) -> Finding {
        let Some((s, t)) = leaf.hit(fma, course, guess, above) else { return Finding::Unknown };
        let (after, before) = (t - self.of_course[0], self.of_course[1] - t);
        if after > self.near && before > self.near {
            Finding::Hit((s, t + self.shift))
        } else if after < -self.near || before < -self.near {
            Finding::Outside
        } else {
            Finding::Unknown
        }
    }

    /// Reports the hits on a leaf, with their places on the piece; false if that is for the exact
    /// engine to do.
    #[inline(always)]
    fn hits(
        &self,
        fma: impl Fused,
        leaf: &Leaf,
        course: &Course,
        known: Option<Roots>,
        mut report: impl FnMut(f64, f64),
    ) -> bool {
        let Some(Roots { guess, above, other, .. }) = known else { return false };
        match self.find(fma, leaf, course, guess, above) {
            Finding::Unknown => return false,
            Finding::Hit((s, t)) => report(s, t),
            Finding::Outside => {}
        }
        let Some(guess) = other else { return true };
        match self.find(fma, leaf, course, guess, !above) {
            Finding::Unknown => return false,
            Finding::Hit((s, t)) => report(s, t),
            Finding::Outside => {}
        }
        true
    }
}

/// A ray as the exact engine sees it.
struct Query<'a> {
    ray: &'a Ray,
    local: LocalRay,
    meridian: Meridian,
}

impl<'a> Query<'a> {
    fn new(frame: &Frame, ray: &'a Ray) -> Option<Self> {
        let local = frame.enter(ray)?;
        Some(Self { ray, local, meridian: Meridian::new(local.origin, local.direction) })
    }

    fn hits(&self, pieces: &[Piece], piece: u32, mut report: impl FnMut(Hit)) {
        root::hits(&pieces[piece as usize], &self.meridian, |s, local_t| {
            let t = self.local.world_t(local_t);
            if self.ray.t_min <= t && t <= self.ray.t_max {
                report(Hit { t, piece, s });
            }
        });
    }
}

/// More hits than a piece can have: two for each of the six roots of F.
const MOST_HITS: usize = 12;

type Few = ArrayVec<Hit, MOST_HITS>;

/// Takes the lowest bit of a set, or the highest.
#[inline(always)]
fn take(mask: &mut u64, lowest: bool) -> Option<usize> {
    if *mask == 0 {
        return None;
    }
    let bit = if lowest { mask.trailing_zeros() } else { 63 - mask.leading_zeros() };
    *mask ^= 1 << bit;
    Some(bit as usize)
}

/// A ray whose direction is very long or very short, with one of ordinary length, and what its parameter
/// is to be multiplied by. No number changes but in its exponent.
fn rescaled(ray: &Ray) -> Option<(Ray, f64)> {
    let largest = ray.direction.max_abs();
    let ordinary = 1.0 / 1024.0..=1024.0;
    if ordinary.contains(&largest) || !(f64::MIN_POSITIVE..f64::INFINITY).contains(&largest) {
        return None;
    }
    let scale = reciprocal_power_of_two(largest);
    let direction = ray.direction * scale;
    let per_scale = 1.0 / scale;
    let (t_min, t_max) = (ray.t_min * per_scale, ray.t_max * per_scale);
    Some((Ray { direction, t_min, t_max, ..*ray }, scale))
}

fn sort(hits: &mut [Hit]) {
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.piece.cmp(&b.piece)));
}

/// A part of a piece that becomes a leaf.
struct Part {
    curve: Piece,
    piece: u32,
    /// Where it begins on the piece, and how long it is.
    place: [f64; 2],
}

/// Into how many parts a piece is halved at the most, as a power of two.
const MOST_HALVINGS: u32 = 4;
/// A part whose tangents, in the plane (z, rho^2 / 2), turn by less than this is not halved.
const STRAIGHT: f64 = 0.08;

/// Halves curved pieces until their tangents hardly turn: the share of rays that such a part leaves
/// without a certificate is about that of the angle.
fn parts(pieces: &[Piece], unit: f64) -> Vec<Part> {
    let mut parts = Vec::new();
    for (i, piece) in (0..).zip(pieces) {
        let mut waiting = vec![Part { curve: *piece, piece: i, place: [0.0, 1.0] }];
        while let Some(part) = waiting.pop() {
            let [low, high] = cone::slope_range(&part.curve, unit);
            let turn = high.atan() - low.atan();
            let halves = part.curve.halves();
            let [first, share] = part.place;
            let fine = turn < STRAIGHT || share < 1.5 / f64::from(1 << MOST_HALVINGS);
            if fine || halves.iter().any(|h| h.start() == h.end()) {
                parts.push(part);
                continue;
            }
            let before = share * middle(piece, part.place);
            let places = [[first, before], [first + before, share - before]];
            for (curve, place) in halves.into_iter().zip(places) {
                waiting.push(Part { curve, piece: part.piece, place });
            }
        }
    }
    parts
}

/// At which share of a part of a piece it is halved. The halves of a conic have the same weight at
/// both ends, which moves their middle, by the square root of the ratio of the weights.
fn middle(piece: &Piece, [first, share]: [f64; 2]) -> f64 {
    let Kind::Conic(w) = piece.kind else { return 0.5 };
    let [a, b] = [first, first + share].map(|s| (1.0 + 2.0 * (w - 1.0) * s * (1.0 - s)).sqrt());
    a / (a + b)
}

/// Puts parts in an order in which each sixteen lie near each other: halved along the longer side of
/// the box round their middles, at a multiple of sixteen.
fn arrange(parts: &mut [Part]) {
    let middle = |part: &Part| {
        let (a, b) = (part.curve.start(), part.curve.end());
        [0.5 * (a.z + b.z), 0.5 * (a.r + b.r)]
    };
    let extent = |axis: usize| {
        let range = parts.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), part| {
            (low.min(middle(part)[axis]), high.max(middle(part)[axis]))
        });
        range.1 - range.0
    };
    let axis = usize::from(parts.len() > LANES && extent(1) > extent(0));
    parts.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let blocks = parts.len().div_ceil(LANES);
    if blocks > 1 {
        let (first, second) = parts.split_at_mut(blocks / 2 * LANES);
        arrange(first);
        arrange(second);
    }
}

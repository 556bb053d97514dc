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
mod cone;
mod cull;
mod leaf;

use arrayvec::ArrayVec;
use fearless_simd::{Level, Simd, dispatch};

use self::arithmetic::{Best, greater};
use self::cull::{Block, Boxes, LANES, Line};
use self::leaf::{Found, Leaf};
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
/// More levels of boxes than there can be: 16^8 blocks hold all that 32 bits can count.
const MOST_LEVELS: usize = 8;

/// Hits nearer to each other, or to an end of the ray's range, than this part of the radius come in an
/// order that is left to the exact engine to decide: t is good to about a tenth of it.
const NEAR: f64 = gamma(8192);

/// From so many times the radius rounding errors are still of the size of those near the surface.
const NEARBY: f64 = 16.0;
/// Squared lengths of directions, and of their parts across the axis, for which no square of what is
/// computed from them overflows or vanishes, and the parts differ by less than 2^30.
const LARGEST: f64 = (1_u64 << 60) as f64;
const SMALLEST: f64 = 1.0 / (1_u64 << 20) as f64;

/// How to go about a ray.
enum Approach {
    Misses,
    Plain(Meridian),
    /// From far away, along the axis, or not a ray.
    Difficult,
}

/// The pieces of a profile, ready to be tested sixteen at a time.
#[derive(Clone, Debug)]
pub(crate) struct Wide {
    level: Level,
    /// A power of two that brings the radius to between 1 and 2.
    unit: f64,
    radius: f64,
    /// A ray that passes the axis at a larger squared distance hits nothing.
    reach2: f64,
    /// Rays from no farther away need not be moved.
    nearby: f64,
    /// In order of height, by and large.
    blocks: Vec<Block>,
    /// One for each piece, in the order of the blocks' lanes.
    leaves: Vec<Leaf>,
    /// Boxes over the blocks, over those boxes, and so on up to a single vector of them.
    boxes: Vec<Vec<Boxes>>,
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
        let mut boxes = Vec::new();
        while groups.len() > if boxes.is_empty() { FEW_BLOCKS } else { 1 } {
            let level = groups.chunks(LANES).map(|groups| {
                let mut vector = Boxes::EMPTY;
                for (lane, group) in groups.iter().enumerate() {
                    vector.set(lane, group.iter().map(|part| &part.curve), unit);
                }
                vector
            });
            boxes.push(level.collect());
            // The groups lie one after the other in `parts`.
            let mut rest = &parts[..];
            groups = groups
                .chunks(LANES)
                .map(|groups| {
                    let (joint, after) = rest.split_at(groups.iter().map(|g| g.len()).sum());
                    rest = after;
                    joint
                })
                .collect();
        }
        let r_max = pieces.iter().fold(0.0_f64, |m, p| m.max(p.r[0]).max(p.r[3]));
        let reach = r_max + gamma(64) * radius;
        Self { level, unit, radius, reach2: reach * reach, nearby: NEARBY * radius, blocks, leaves, boxes }
    }

    /// The number of vectors of boxes and pieces.
    pub(crate) fn node_count(&self) -> usize {
        self.blocks.len() + self.boxes.iter().map(Vec::len).sum::<usize>()
    }

    pub(crate) fn closest(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
    ) -> Option<Hit> {
        dispatch!(self.level, simd => self.closest_with(simd, pieces, frame, ray))
    }

    pub(crate) fn any(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
    ) -> bool {
        dispatch!(self.level, simd => self.any_with(simd, pieces, frame, ray))
    }

    pub(crate) fn all(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        hits: &mut Vec<Hit>,
    ) {
        hits.clear();
        dispatch!(self.level, simd => self.all_carefully(simd, pieces, frame, ray, hits));
    }

    /// Calls `visit` for every piece that the ray may hit, as [`Engine::walk`](super::Engine::walk).
    pub(crate) fn candidates<C: Count>(
        &self,
        ray: &Meridian,
        range: [f64; 2],
        count: &mut C,
        mut visit: impl FnMut(u32) -> f64,
    ) {
        let line = Line::new(ray, range, self.unit);
        dispatch!(self.level, simd => self.walk(simd, line, false, count, #[inline(always)] |line, leaf, _| {
            let end = visit(leaf.piece());
            line.end_at(end);
            end > f64::NEG_INFINITY
        }));
    }

    #[inline(always)]
    fn closest_with<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
    ) -> Option<Hit> {
        let meridian = match self.approach(frame, ray) {
            Approach::Misses => return None,
            Approach::Plain(meridian) => meridian,
            Approach::Difficult => return self.closest_carefully(simd, pieces, frame, ray),
        };
        let range = [ray.t_min, ray.t_max];
        // The direction is longer than 2^-10.
        let near = NEAR * 1024.0 * self.radius;
        let mut closest: Option<Hit> = None;
        let mut doubt = false;
        let line = Line::new(&meridian, range, self.unit);
        self.walk(simd, line, false, &mut (), #[inline(always)] |line, leaf, known| {
            let mut consider = |s: f64, t: f64, line: &mut Line| {
                if let Some(best) = closest {
                    doubt |= (t - best.t).abs() < near && best.piece != leaf.piece();
                    if t > best.t {
                        return;
                    }
                }
                closest = Some(Hit { t, piece: leaf.piece(), s });
                line.end_at(t);
            };
            let found = match known {
                Some((guess, above)) => leaf.hit(Best(simd), &meridian, guess, above),
                None => Found::Unknown,
            };
            match found {
                Found::One((s, t)) if t - range[0] > near && range[1] - t > near => {
                    consider(s, t, line);
                }
                Found::One((_, t)) if t - range[0] < -near || range[1] - t < -near => {}
                _ => match self.difficult_leaf(simd, pieces, frame, ray, leaf) {
                    Some(hits) => hits.into_iter().for_each(|(s, t)| consider(s, t, line)),
                    None => doubt = true,
                },
            }
            !doubt
        });
        if doubt {
            return self.closest_carefully(simd, pieces, frame, ray);
        }
        closest
    }

    /// The hits on a leaf, or on all of its piece, in the ray's range; `None` if that is not certain.
    #[cold]
    #[inline(never)]
    fn difficult_leaf<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        leaf: &Leaf,
    ) -> Option<ArrayVec<(f64, f64), MOST_HITS>> {
        simd.vectorize(#[inline(always)] || {
            let mut found = ArrayVec::new();
            let mut doubt = false;
            let query = Query::new(self, pieces, frame, ray)?;
            query.hits(simd, leaf, None, |s, local_t| {
                let t = query.local.world_t(local_t);
                match query.within(local_t, t) {
                    Within::Yes => {
                        let _ = found.try_push((s, t));
                    }
                    Within::No => {}
                    Within::Unsure => doubt = true,
                }
            });
            (!doubt).then_some(found)
        })
    }

    #[inline(always)]
    fn any_with<S: Simd>(&self, simd: S, pieces: &[Piece], frame: &Frame, ray: &Ray) -> bool {
        let meridian = match self.approach(frame, ray) {
            Approach::Misses => return false,
            Approach::Plain(meridian) => meridian,
            Approach::Difficult => return self.any_carefully(simd, pieces, frame, ray),
        };
        let line = Line::new(&meridian, [ray.t_min, ray.t_max], self.unit);
        let range = [ray.t_min, ray.t_max];
        let near = NEAR * 1024.0 * self.radius;
        let (mut found, mut doubt) = (false, false);
        let inside = self.walk(simd, line, true, &mut (), #[inline(always)] |_, leaf, known| {
            let hit = match known {
                Some((guess, above)) => leaf.hit(Best(simd), &meridian, guess, above),
                None => Found::Unknown,
            };
            match hit {
                Found::One((_, t)) if t - range[0] > near && range[1] - t > near => found = true,
                Found::One((_, t)) if t - range[0] < -near || range[1] - t < -near => {}
                _ => match self.difficult_leaf(simd, pieces, frame, ray, leaf) {
                    Some(hits) => found = !hits.is_empty(),
                    None => doubt = true,
                },
            }
            !found
        });
        inside || found || doubt && self.any_carefully(simd, pieces, frame, ray)
    }

    /// The ray in the half plane, if that is simple.
    #[inline(always)]
    fn approach(&self, frame: &Frame, ray: &Ray) -> Approach {
        let [o, d] = frame.turn(ray);
        let a = d.x * d.x + d.y * d.y;
        let k = o.x * d.y - o.y * d.x;
        let far = greater(greater(o.x.abs(), o.y.abs()), o.z.abs());
        let length2 = a + d.z * d.z;
        let simple = far <= self.nearby && a >= SMALLEST && length2 <= LARGEST;
        if !simple {
            return Approach::Difficult;
        }
        if k * k > a * self.reach2 {
            return Approach::Misses;
        }
        Approach::Plain(Meridian::plain(o, d, a, k))
    }

    #[inline(never)]
    fn closest_carefully<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
    ) -> Option<Hit> {
        let query = Query::new(self, pieces, frame, ray)?;
        let mut closest: Option<Hit> = None;
        let mut end = query.local.range[1];
        let mut doubt = false;
        self.walk(simd, query.line(), false, &mut (), #[inline(always)] |line, leaf, known| {
            query.hits(simd, leaf, known, #[inline(always)] |s, local_t| {
                let t = query.local.world_t(local_t);
                match query.within(local_t, t) {
                    Within::Yes => {}
                    Within::No => return,
                    Within::Unsure => doubt = true,
                }
                if let Some(best) = closest {
                    doubt |= best.piece != leaf.piece() && (local_t - end).abs() < query.near;
                }
                if closest.is_none_or(|best| t < best.t) {
                    closest = Some(Hit { t, piece: leaf.piece(), s });
                    end = local_t;
                    line.end_at(local_t);
                }
            });
            true
        });
        if doubt { self.closest_exactly(simd, &query) } else { closest }
    }

    #[inline(never)]
    fn any_carefully<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
    ) -> bool {
        let Some(query) = Query::new(self, pieces, frame, ray) else { return false };
        let (mut found, mut doubt) = (false, false);
        let inside = self.walk(simd, query.line(), true, &mut (), #[inline(always)] |_, leaf, known| {
            query.hits(simd, leaf, known, #[inline(always)] |_, local_t| {
                match query.within(local_t, query.local.world_t(local_t)) {
                    Within::Yes => found = true,
                    Within::No => {}
                    Within::Unsure => doubt = true,
                }
            });
            !found
        });
        inside || found || (doubt && self.closest_exactly(simd, &query).is_some())
    }

    #[inline(always)]
    fn all_carefully<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        ray: &Ray,
        hits: &mut Vec<Hit>,
    ) {
        let Some(query) = Query::new(self, pieces, frame, ray) else { return };
        let mut doubt = false;
        self.walk(simd, query.line(), false, &mut (), #[inline(always)] |_, leaf, known| {
            // What the exact engine finds on the whole piece would be found for each of its leaves.
            doubt |= query.hits(simd, leaf, known, #[inline(always)] |s, local_t| {
                let t = query.local.world_t(local_t);
                match query.within(local_t, t) {
                    Within::Yes => hits.push(Hit { t, piece: leaf.piece(), s }),
                    Within::No => {}
                    Within::Unsure => doubt = true,
                }
            });
            true
        });
        sort(hits);
        let near = query.near * (query.local.world_t(1.0) - query.local.world_t(0.0)).abs();
        if doubt || hits.windows(2).any(|pair| pair[1].t - pair[0].t < near) {
            hits.clear();
            self.exactly(simd, &query, |hit| hits.push(hit));
            sort(hits);
        }
    }

    /// The closest hit as the exact engine finds it.
    #[cold]
    #[inline(never)]
    fn closest_exactly<S: Simd>(
        &self,
        simd: S,
        query: &Query<'_>,
    ) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let order = |h: &Hit| (h.t, h.piece);
        self.exactly(simd, query, |hit| {
            if closest.is_none_or(|best| order(&hit) < order(&best)) {
                closest = Some(hit);
            }
        });
        closest
    }

    /// All hits in the ray's range as the exact engine finds them.
    fn exactly<S: Simd>(
        &self,
        simd: S,
        query: &Query<'_>,
        mut report: impl FnMut(Hit),
    ) {
        let mut pieces = Vec::new();
        self.walk(simd, query.line(), false, &mut (), |_, leaf, _| {
            pieces.push(leaf.piece());
            true
        });
        pieces.sort_unstable();
        pieces.dedup();
        for piece in pieces {
            root::hits(&query.pieces[piece as usize], &query.meridian, |s, local_t| {
                let t = query.local.world_t(local_t);
                if query.ray.t_min <= t && t <= query.ray.t_max {
                    report(Hit { t, piece, s });
                }
            });
        }
    }

    /// Visits the leaves that a line may hit, near ones first by and large, as long as `visit` says
    /// so; it may shorten the line. Stops with true at the first certain hit within the line if `any`
    /// is all that is asked.
    #[inline(always)]
    fn walk<S: Simd, C: Count>(
        &self,
        simd: S,
        mut line: Line,
        any: bool,
        count: &mut C,
        mut visit: impl FnMut(&mut Line, &Leaf, Option<(f32, bool)>) -> bool,
    ) -> bool {
        let rises = line.rises();
        let mut stack = ArrayVec::<(usize, usize, u32), MOST_LEVELS>::new();
        // The vector of children at hand: its level, 0 for blocks; its index; those still to visit.
        let (mut level, mut vector) = (self.boxes.len(), 0);
        let mut mask = match self.boxes.last() {
            Some(top) => {
                count.test();
                top[0].test(simd, &line)
            }
            None => (1 << self.blocks.len()) - 1,
        };
        loop {
            let Some(lane) = take(&mut mask, rises) else {
                let Some(above) = stack.pop() else { return false };
                (level, vector, mask) = above;
                continue;
            };
            count.positive();
            count.test();
            let child = vector * LANES + lane;
            if level > 1 {
                stack.push((level, vector, mask));
                (level, vector) = (level - 1, child);
                mask = self.boxes[level - 1][child].test(simd, &line);
                continue;
            }
            count.enter();
            let hits = self.blocks[child].test(simd, &line);
            if hits.inside != 0 && any {
                return true;
            }
            let mut lanes = hits.sure | hits.unsure;
            while let Some(lane) = take(&mut lanes, rises) {
                let leaf = &self.leaves[child * LANES + lane];
                count.positive();
                if line.ends_before(leaf.heights()) {
                    continue;
                }
                count.solve();
                let bit = 1 << lane;
                let known = (hits.sure & bit != 0)
                    .then_some((hits.guess[lane % LANES], hits.above & bit != 0));
                if !visit(&mut line, leaf, known) {
                    return false;
                }
            }
        }
    }
}

/// A ray in all its forms, and what it is asked of.
struct Query<'a> {
    wide: &'a Wide,
    pieces: &'a [Piece],
    ray: &'a Ray,
    local: LocalRay,
    meridian: Meridian,
    /// [`NEAR`], as a difference of local parameters.
    near: f64,
}

/// Whether a hit is in the ray's range.
enum Within {
    Yes,
    No,
    Unsure,
}

impl<'a> Query<'a> {
    #[inline(always)]
    fn new(wide: &'a Wide, pieces: &'a [Piece], frame: &Frame, ray: &'a Ray) -> Option<Self> {
        let local = frame.enter(ray)?;
        let (o, d) = (local.origin, local.direction);
        let k = o.x * d.y - o.y * d.x;
        if k * k > (d.x * d.x + d.y * d.y) * wide.reach2 {
            return None;
        }
        let meridian = Meridian::new(o, d);
        Some(Self { wide, pieces, ray, local, meridian, near: NEAR * wide.radius })
    }

    #[inline(always)]
    fn line(&self) -> Line {
        Line::new(&self.meridian, self.local.range, self.wide.unit)
    }

    /// Reports all hits on a leaf as (s, t), t in the frame's own parameter, or on the whole piece if
    /// it takes the exact engine to find them; then the answer is true.
    #[inline(always)]
    fn hits<S: Simd>(
        &self,
        simd: S,
        leaf: &Leaf,
        known: Option<(f32, bool)>,
        mut report: impl FnMut(f64, f64),
    ) -> bool {
        let found = match known {
            Some((guess, above)) => leaf.hit(Best(simd), &self.meridian, guess, above),
            None => unsure_hits(simd, leaf, &self.meridian, self.wide.unit),
        };
        match found {
            Found::None => {}
            Found::One((s, t)) => report(s, t),
            Found::Two(hits) => {
                for (s, t) in hits {
                    report(s, t);
                }
            }
            Found::Unknown => {
                for (s, t) in exact_hits(&self.pieces[leaf.piece() as usize], &self.meridian) {
                    report(s, t);
                }
                return true;
            }
        }
        false
    }

    /// Whether a hit is in the ray's range, given its parameter in the frame and that of the ray.
    #[inline(always)]
    fn within(&self, local_t: f64, t: f64) -> Within {
        let [lo, hi] = self.local.range;
        if local_t - lo > self.near && hi - local_t > self.near {
            return Within::Yes;
        }
        let (t_min, t_max) = (self.ray.t_min, self.ray.t_max);
        let sure = lo - local_t > self.near || local_t - hi > self.near;
        // The range in the frame holds the ray's own, with room for rounding.
        match (sure, t_min <= t && t <= t_max) {
            (true, false) => Within::No,
            _ => Within::Unsure,
        }
    }
}

/// Rarely needed, and too long to be inlined everywhere.
#[inline(never)]
fn unsure_hits<S: Simd>(simd: S, leaf: &Leaf, ray: &Meridian, unit: f64) -> Found {
    simd.vectorize(#[inline(always)] || leaf.hits(Best(simd), ray, unit))
}

/// More hits than a piece can have: two for each of the six roots of F.
const MOST_HITS: usize = 12;

#[cold]
#[inline(never)]
fn exact_hits(piece: &Piece, ray: &Meridian) -> ArrayVec<(f64, f64), MOST_HITS> {
    let mut hits = ArrayVec::new();
    // No more can come than there is room for.
    root::hits(piece, ray, |s, t| {
        let _ = hits.try_push((s, t));
    });
    hits
}

/// Takes the lowest bit of a set, or the highest.
#[inline(always)]
fn take(mask: &mut u32, lowest: bool) -> Option<usize> {
    if *mask == 0 {
        return None;
    }
    let bit = if lowest { mask.trailing_zeros() } else { 31 - mask.leading_zeros() };
    *mask &= !(1 << bit);
    Some(bit as usize)
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

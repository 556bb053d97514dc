//! What the wide engine leaves to the exact one: pieces, or whole rays, where rounding could decide.

use arrayvec::ArrayVec;

use super::Wide;
use super::search::Question;
use crate::Ray;
use crate::frame::LocalRay;
use crate::meridian::Meridian;
use crate::pieces::Pieces;
use crate::root;
use crate::surface::Hit;

/// More hits than a piece can have: two for each of the six roots of F.
const MOST_HITS: usize = 12;

/// The hits on one piece.
pub(super) type Few = ArrayVec<Hit, MOST_HITS>;

/// A ray as the exact engine sees it.
struct Query<'a> {
    ray: &'a Ray,
    local: LocalRay,
    meridian: Meridian,
}

impl<'a> Query<'a> {
    fn new(question: &Question<'a>) -> Option<Self> {
        let (frame, ray) = (question.frame, question.ray);
        let local = frame.enter(ray)?;
        Some(Self { ray, local, meridian: Meridian::new(local.origin, local.direction) })
    }

    fn hits(&self, pieces: &Pieces, piece: u32, mut report: impl FnMut(Hit)) {
        root::hits(pieces.at(piece as usize, &mut None), &self.meridian, |s, local_t| {
            let t = self.local.world_t(local_t);
            if self.ray.t_min <= t && t <= self.ray.t_max {
                report(Hit { t, piece, s });
            }
        });
    }
}

impl Wide {
    /// The hits on one piece.
    #[cold]
    #[inline(never)]
    pub(super) fn hits_exactly(&self, question: &Question<'_>, piece: u32) -> Few {
        let mut hits = Few::new();
        if let Some(query) = Query::new(question) {
            query.hits(question.pieces, piece, |hit| {
                // No more can come than there is room for.
                let _ = hits.try_push(hit);
            });
        }
        hits
    }

    /// The closest hit.
    #[cold]
    #[inline(never)]
    pub(super) fn closest_exactly(&self, question: &Question<'_>) -> Option<Hit> {
        let query = Query::new(question)?;
        let mut closest: Option<Hit> = None;
        let mut end = query.local.range[1];
        self.candidates(&query.local, &mut (), |piece| {
            query.hits(question.pieces, piece, |hit| {
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

    /// All hits.
    #[cold]
    #[inline(never)]
    pub(super) fn all_exactly(&self, question: &Question<'_>, hits: &mut Vec<Hit>) {
        hits.clear();
        let Some(query) = Query::new(question) else { return };
        self.candidates(&query.local, &mut (), |piece| {
            query.hits(question.pieces, piece, |hit| hits.push(hit));
            f64::INFINITY
        });
        sort(hits);
    }
}

/// In order of t, then of pieces.
pub(super) fn sort(hits: &mut [Hit]) {
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.piece.cmp(&b.piece)));
}

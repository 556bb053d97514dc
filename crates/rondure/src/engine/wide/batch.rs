//! Many rays at once.

use super::Wide;
use super::search::Question;
use crate::batch::{Hits, Rays};
use crate::frame::Frame;
use crate::piece::Piece;
use fearless_simd::dispatch;

impl Wide {
    pub(crate) fn closest_of_many(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Hits,
    ) {
        hits.clear(rays.len());
        dispatch!(self.level, simd => {
            for i in 0..rays.len() {
                hits.set(i, self.closest_with::<_, true>(simd, &Question { pieces, frame, ray: &rays.get(i) }));
            }
        });
    }

    pub(crate) fn any_of_many(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut [bool],
    ) {
        dispatch!(self.level, simd => {
            for (i, hit) in hits.iter_mut().enumerate().take(rays.len()) {
                *hit = self.any_with::<_, true>(simd, &Question { pieces, frame, ray: &rays.get(i) });
            }
        });
    }
}

//! Many rays at once, sixteen after sixteen: those that are alike go together ([`packet`](super::packet)), others each
//! their own way ([`lot`](super::lot)), and what either leaves over is answered one by one.

use fearless_simd::{Simd, dispatch};

use super::Wide;
use super::lot::Lot;
use super::near::{Near, WIDTH, pass};
use super::packet::{Packet, SIXTEEN};
use crate::batch::{Hits, Rays};
use crate::frame::Frame;
use crate::piece::Piece;

/// As many rays are left over before they are answered.
const OVER: usize = 64;

impl Wide {
    pub(crate) fn closest_of_many(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Hits,
    ) {
        hits.clear(rays.len());
        dispatch!(self.level, simd => self.closest_many(simd, pieces, frame, rays, hits));
    }

    pub(crate) fn any_of_many(
        &self,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut [bool],
    ) {
        dispatch!(self.level, simd => self.any_many(simd, pieces, frame, rays, hits));
    }

    #[inline(always)]
    fn closest_many<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Hits,
    ) {
        let one = |index: usize, hits: &mut Hits| {
            hits.set(index, self.closest(pieces, frame, &rays.get(index)));
        };
        let mut lot = Lot::new();
        let whole = whole(frame, rays.len());
        for start in (0..whole).step_by(SIXTEEN) {
            if pass(simd, self, rays, start) && pass(simd, self, rays, start + WIDTH) {
                continue;
            }
            let near = [
                Near::new(simd, self, frame, rays, start),
                Near::new(simd, self, frame, rays, start + WIDTH),
            ];
            lot.refuse(&near, start);
            if near[0].meets | near[1].meets != 0 {
                match Packet::new(simd, &near) {
                    Some(packet) => {
                        self.closest_together(simd, &packet, start, hits, &mut lot.single);
                    }
                    None => {
                        lot.take(simd, &near[0], start);
                        lot.take(simd, &near[1], start + WIDTH);
                        if lot.is_full() {
                            self.closest_apart(simd, &mut lot, hits);
                        }
                    }
                }
            }
            if lot.single.len() >= OVER {
                lot.single.drain(..).for_each(|index| one(index, hits));
            }
        }
        self.closest_apart(simd, &mut lot, hits);
        lot.single.drain(..).chain(whole..rays.len()).for_each(|index| one(index, hits));
    }

    #[inline(always)]
    fn any_many<S: Simd>(
        &self,
        simd: S,
        pieces: &[Piece],
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut [bool],
    ) {
        let count = rays.len().min(hits.len());
        let hits = &mut hits[..count];
        hits.fill(false);
        let one = |index: usize, hits: &mut [bool]| {
            hits[index] = self.any(pieces, frame, &rays.get(index));
        };
        let mut lot = Lot::new();
        let whole = whole(frame, count);
        for start in (0..whole).step_by(SIXTEEN) {
            if pass(simd, self, rays, start) && pass(simd, self, rays, start + WIDTH) {
                continue;
            }
            let near = [
                Near::new(simd, self, frame, rays, start),
                Near::new(simd, self, frame, rays, start + WIDTH),
            ];
            lot.refuse(&near, start);
            if near[0].meets | near[1].meets != 0 {
                match Packet::new(simd, &near) {
                    Some(packet) => self.any_together(simd, &packet, start, hits, &mut lot.single),
                    None => {
                        lot.take(simd, &near[0], start);
                        lot.take(simd, &near[1], start + WIDTH);
                        if lot.is_full() {
                            self.any_apart(simd, &mut lot, hits);
                        }
                    }
                }
            }
            if lot.single.len() >= OVER {
                lot.single.drain(..).for_each(|index| one(index, hits));
            }
        }
        self.any_apart(simd, &mut lot, hits);
        lot.single.drain(..).chain(whole..count).for_each(|index| one(index, hits));
    }
}

/// How many of the first rays come in sixteens: none of those that have to be turned.
fn whole(frame: &Frame, len: usize) -> usize {
    if frame.inverse().is_some() { 0 } else { len - len % SIXTEEN }
}

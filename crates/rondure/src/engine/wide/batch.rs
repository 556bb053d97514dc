//! Many rays at once, sixteen after sixteen: those that are alike go together ([`packet`](super::packet)), others each
//! their own way ([`lot`](super::lot)), and what either leaves over is answered one by one.

use fearless_simd::{Simd, dispatch};

use super::Wide;
use super::bits::bits;
use super::every::Every;
use super::lot::Lot;
use super::near::{Near, WIDTH, pass};
use super::packet::{Packet, SIXTEEN};
use crate::Ray;
use crate::batch::{Gathered, Hits, Rays};
use crate::frame::Frame;
use crate::pieces::Pieces;
use crate::surface::Hit;

/// As many rays are left over before they are answered.
const OVER: usize = 64;

/// So few rays that are not alike are answered one by one: to make room for a lot takes as long.
const FEW: usize = 32;

/// What is asked about many rays: how packets, lots and single rays answer it, and where the answers go.
trait Answers {
    /// Answers the rays of a packet, from the one numbered `start` on, or leaves them to `single`; false if they should rather go each
    /// their own way, as for all hits: they would have to meet the same leaves all along.
    #[inline(always)]
    fn together<S: Simd>(
        &mut self,
        _simd: S,
        _wide: &Wide,
        _packet: &Packet<'_, S>,
        _start: usize,
        _single: &mut Vec<usize>,
    ) -> bool {
        false
    }

    /// Answers the rays of a lot, or leaves them to `single`.
    fn apart<S: Simd>(&mut self, simd: S, wide: &Wide, lot: &mut Lot, single: &mut Vec<usize>);

    /// Answers one ray.
    fn one(&mut self, target: &Target<'_>, index: usize, ray: &Ray);
}

/// All hits, and where they are worked out.
struct All<'a> {
    hits: &'a mut Gathered,
    every: Every,
    own: Vec<Hit>,
}

impl Answers for All<'_> {
    #[inline(always)]
    fn apart<S: Simd>(&mut self, simd: S, wide: &Wide, lot: &mut Lot, single: &mut Vec<usize>) {
        wide.all_apart(simd, lot, &mut self.every, self.hits, single);
    }

    fn one(&mut self, target: &Target<'_>, index: usize, ray: &Ray) {
        target.wide.all(target.pieces, target.frame, ray, &mut self.own);
        self.hits.add(index, &self.own);
    }
}

/// What the rays are shot at.
struct Target<'a> {
    wide: &'a Wide,
    pieces: &'a Pieces,
    frame: &'a Frame,
}

impl Answers for Hits {
    #[inline(always)]
    fn together<S: Simd>(
        &mut self,
        simd: S,
        wide: &Wide,
        packet: &Packet<'_, S>,
        start: usize,
        single: &mut Vec<usize>,
    ) -> bool {
        wide.closest_together(simd, packet, start, self, single);
        true
    }

    #[inline(always)]
    fn apart<S: Simd>(&mut self, simd: S, wide: &Wide, lot: &mut Lot, single: &mut Vec<usize>) {
        wide.closest_apart(simd, lot, self, single);
    }

    fn one(&mut self, target: &Target<'_>, index: usize, ray: &Ray) {
        self.set(index, target.wide.closest(target.pieces, target.frame, ray));
    }
}

impl Answers for [bool] {
    #[inline(always)]
    fn together<S: Simd>(
        &mut self,
        simd: S,
        wide: &Wide,
        packet: &Packet<'_, S>,
        start: usize,
        single: &mut Vec<usize>,
    ) -> bool {
        wide.any_together(simd, packet, start, self, single);
        true
    }

    #[inline(always)]
    fn apart<S: Simd>(&mut self, simd: S, wide: &Wide, lot: &mut Lot, single: &mut Vec<usize>) {
        wide.any_apart(simd, lot, self, single);
    }

    fn one(&mut self, target: &Target<'_>, index: usize, ray: &Ray) {
        self[index] = target.wide.any(target.pieces, target.frame, ray);
    }
}

impl Wide {
    pub(crate) fn closest_of_many(
        &self,
        pieces: &Pieces,
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Hits,
    ) {
        hits.clear(rays.len());
        let target = Target { wide: self, pieces, frame };
        dispatch!(self.level, simd => target.answer(simd, rays, rays.len(), hits));
    }

    pub(crate) fn any_of_many(
        &self,
        pieces: &Pieces,
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut [bool],
    ) {
        let count = rays.len().min(hits.len());
        let hits = &mut hits[..count];
        hits.fill(false);
        let target = Target { wide: self, pieces, frame };
        dispatch!(self.level, simd => target.answer(simd, rays, count, hits));
    }
}

impl Wide {
    pub(crate) fn all_of_many(
        &self,
        pieces: &Pieces,
        frame: &Frame,
        rays: &Rays<'_>,
        hits: &mut Gathered,
    ) {
        let target = Target { wide: self, pieces, frame };
        let mut all = All { hits, every: Every::new(), own: Vec::new() };
        dispatch!(self.level, simd => target.answer(simd, rays, rays.len(), &mut all));
    }
}

impl Target<'_> {
    /// Answers the first `count` rays.
    #[inline(always)]
    fn answer<S: Simd, A: Answers + ?Sized>(
        &self,
        simd: S,
        rays: &Rays<'_>,
        count: usize,
        answers: &mut A,
    ) {
        let &Self { wide, frame, .. } = self;
        // Where all rays go together there is no need of it.
        let mut lot: Option<Box<Lot>> = None;
        let mut single = Vec::new();
        let whole = count - count % SIXTEEN;
        let takes_lots = count > FEW && wide.takes_lots();
        for start in (0..whole).step_by(SIXTEEN) {
            if pass(simd, wide, frame, rays, start) && pass(simd, wide, frame, rays, start + WIDTH)
            {
                continue;
            }
            let near = [
                Near::new(simd, wide, frame, rays, start),
                Near::new(simd, wide, frame, rays, start + WIDTH),
            ];
            let strange = near[0].strange | near[1].strange << WIDTH;
            if strange != 0 {
                single.extend(bits(strange).map(|lane| start + lane));
            }
            if near[0].meets | near[1].meets != 0 {
                let answered = match Packet::new(simd, &near) {
                    Some(packet) => answers.together(simd, wide, &packet, start, &mut single),
                    None => false,
                };
                if !answered && takes_lots {
                    let lot = lot.get_or_insert_with(|| Box::new(Lot::new(wide.blocks.len())));
                    lot.take(simd, &near[0], start);
                    lot.take(simd, &near[1], start + WIDTH);
                    if lot.is_full() {
                        answers.apart(simd, wide, lot, &mut single);
                    }
                } else if !answered {
                    let meets = near[0].meets | near[1].meets << WIDTH;
                    single.extend(bits(meets).map(|lane| start + lane));
                }
            }
            if single.len() >= OVER {
                self.answer_one_by_one(rays, single.drain(..), answers);
            }
        }
        if let Some(lot) = &mut lot {
            answers.apart(simd, wide, lot, &mut single);
        }
        self.answer_one_by_one(rays, single.into_iter().chain(whole..count), answers);
    }

    fn answer_one_by_one<A: Answers + ?Sized>(
        &self,
        rays: &Rays<'_>,
        numbers: impl Iterator<Item = usize>,
        answers: &mut A,
    ) {
        for index in numbers {
            answers.one(self, index, &rays.get(index));
        }
    }
}

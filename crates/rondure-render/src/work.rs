//! A portion of a picture in the making: tile after tile, pass after pass, to be stopped and gone on with at any tile.

use core::ops::Range;
use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use rayon::prelude::*;
use rondure_film::{Pass, Portion, Room, Share, Spool, Statistics, Window};

use crate::{
    Progress, RenderError,
    adaptive::{Blocks, are_whole},
    job::{Job, Prepared, TileSums},
};

/// The edge of a tile, in pixels.
const TILE: u32 = 32;

/// How [`Work::run`] ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is done.
    Finished,
    /// It was asked to stop; whole tiles are kept, and another run goes on from there.
    Stopped,
}

/// A portion of a picture, as far as it is done.
#[derive(Debug)]
pub struct Work {
    portion: Portion,
    tiles: Vec<Window>,
    /// For each tile the number of the next sample.
    next: Vec<u32>,
    sums: Spool,
    statistics: Statistics,
    /// The error at which a block of pixels has enough samples.
    noise: Option<f64>,
}

/// The sums so far, in the middle of the work.
#[derive(Debug)]
pub struct Snapshot<'a> {
    portion: &'a Portion,
    tiles: &'a [Window],
    next: &'a [u32],
    /// The sums.
    pub sums: &'a Spool,
    /// The work that went into them.
    pub statistics: &'a Statistics,
}

impl Snapshot<'_> {
    /// What has been taken, tile by tile.
    pub fn covered(&self) -> Vec<Portion> {
        covered(self.portion, self.tiles, self.next)
    }

    /// The share of all samples that has been taken, from 0 to 1.
    pub fn done(&self) -> f64 {
        done(self.portion, self.tiles, self.next)
    }
}

fn covered(portion: &Portion, tiles: &[Window], next: &[u32]) -> Vec<Portion> {
    let start = portion.samples.start;
    let begun = tiles.iter().zip(next).filter(|&(_, &next)| next > start);
    begun.map(|(&window, &next)| Portion { window, samples: start..next }).collect()
}

fn done(portion: &Portion, tiles: &[Window], next: &[u32]) -> f64 {
    let start = portion.samples.start;
    let taken = |(tile, &next): (&Window, &u32)| tile.pixels() as f64 * f64::from(next - start);
    tiles.iter().zip(next).map(taken).sum::<f64>() / portion.count()
}

/// What the threads share.
struct Shared<'a> {
    sums: &'a mut Spool,
    statistics: &'a mut Statistics,
    next: &'a mut [u32],
}

/// What is to be done in a pass.
struct Todo<'a> {
    samples: &'a Range<u32>,
    /// The numbers of the tiles that have not had it.
    tiles: &'a [usize],
    /// The blocks that get it, if not all.
    blocks: Option<&'a Blocks>,
}

impl Work {
    /// A portion of the job's picture, not begun; its sums have this room.
    ///
    /// # Errors
    /// If it has nothing in it or is not in the picture, or there is not enough room.
    pub fn new(job: &Job<'_>, portion: Portion, room: &Room) -> Result<Self, RenderError> {
        Self::with_tiles(job, portion, room, TILE)
    }

    /// The same with tiles of `edge` pixels (at least 1) instead of 32. The picture does not depend on it.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_tiles(
        job: &Job<'_>,
        portion: Portion,
        room: &Room,
        edge: u32,
    ) -> Result<Self, RenderError> {
        let sums = Spool::new(job.size(), portion.window, job.layers(), room)?;
        if portion.samples.is_empty() {
            let [width, height] = job.size();
            return Err(RenderError::EmptyFilm { width, height, spp: 0 });
        }
        Ok(Self::begun(portion, edge, sums, Statistics::default()))
    }

    fn begun(portion: Portion, edge: u32, sums: Spool, statistics: Statistics) -> Self {
        let tiles: Vec<_> = portion.window.tiles(edge).collect();
        let next = vec![portion.samples.start; tiles.len()];
        Self { portion, tiles, next, sums, statistics, noise: None }
    }

    /// The work that a share was cut from, to go on with it: the share must be of the job's picture, and have been written from a
    /// [`Snapshot`] of the same portion.
    ///
    /// # Errors
    /// If it was not.
    pub fn resume(job: &Job<'_>, portion: Portion, share: Share) -> Result<Self, RenderError> {
        let Share { covered, sums, statistics, .. } = share;
        let own = sums.size() == job.size() && sums.layers() == job.layers();
        if !own || sums.window() != portion.window {
            return Err(RenderError::OtherPortion);
        }
        let mut work = Self::begun(portion, TILE, sums, statistics);
        let places: HashMap<_, _> = work.tiles.iter().copied().zip(0..).collect();
        for Portion { window, samples } in covered {
            let &tile: &usize = places.get(&window).ok_or(RenderError::OtherPortion)?;
            let all = &work.portion.samples;
            let begun = work.next[tile] > all.start;
            if begun || samples.start != all.start || samples.is_empty() || samples.end > all.end {
                return Err(RenderError::OtherPortion);
            }
            work.next[tile] = samples.end;
        }
        Ok(work)
    }

    /// The same with a limit: blocks of pixels whose relative error is estimated to be no more than `noise` get no more samples. 0.01 is all but
    /// invisible. The picture depends on the limit, but not on threads, tiles or interruptions.
    ///
    /// # Errors
    /// If the portion is not of whole blocks of [`NOISE_BLOCK`](crate::NOISE_BLOCK) pixels with all their samples, or the film does not keep the variance.
    pub fn until(mut self, job: &Job<'_>, noise: f64) -> Result<Self, RenderError> {
        let whole = are_whole(&self.portion.window, job.size());
        if !whole || self.portion.samples != job.whole().samples {
            return Err(RenderError::NoisePart);
        }
        if !job.layers().variance {
            return Err(RenderError::NoVariance);
        }
        self.noise = Some(noise);
        Ok(self)
    }

    /// The sums so far.
    pub fn sums(&self) -> &Spool {
        &self.sums
    }

    /// The work that went into them.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The state, as [`Progress::landed`] sees it.
    pub fn snapshot(&self) -> Snapshot<'_> {
        Snapshot {
            portion: &self.portion,
            tiles: &self.tiles,
            next: &self.next,
            sums: &self.sums,
            statistics: &self.statistics,
        }
    }

    /// Works until all is done, or `progress` asks to stop.
    ///
    /// # Errors
    /// If the threads cannot be started or the memory does not suffice; what is done is kept.
    pub fn run(
        &mut self,
        job: &Job<'_>,
        threads: Option<usize>,
        progress: &dyn Progress,
    ) -> Result<Outcome, RenderError> {
        let parallel = threads != Some(1);
        match threads {
            Some(threads) => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?
                .install(|| self.passes(job, parallel, progress)),
            None => self.passes(job, parallel, progress),
        }
    }

    fn passes(
        &mut self,
        job: &Job<'_>,
        parallel: bool,
        progress: &dyn Progress,
    ) -> Result<Outcome, RenderError> {
        for (pass, samples) in Pass::of_range(self.portion.samples.clone()) {
            let left: Vec<_> =
                (0..self.tiles.len()).filter(|&i| self.next[i] < samples.end).collect();
            if left.is_empty() {
                continue;
            }
            let exposure = job.scene().film.exposure;
            let blocks = |noise| Blocks::new(&self.sums, noise, exposure, samples.start);
            let blocks = self.noise.map(blocks).transpose()?;
            if blocks.as_ref().is_some_and(Blocks::is_done) {
                self.next.fill(self.portion.samples.end);
                break;
            }
            let todo = Todo { samples: &samples, tiles: &left, blocks: blocks.as_ref() };
            let prepared = job.prepare(pass, progress);
            let made = prepared.and_then(|p| self.pass(job, &p, &todo, parallel, progress));
            match made {
                Err(RenderError::Cancelled) => return Ok(Outcome::Stopped),
                other => other?,
            }
        }
        progress.advance(1.0);
        Ok(Outcome::Finished)
    }

    fn pass(
        &mut self,
        job: &Job<'_>,
        prepared: &Prepared,
        todo: &Todo<'_>,
        parallel: bool,
        progress: &dyn Progress,
    ) -> Result<(), RenderError> {
        let Todo { samples, tiles: left, blocks } = *todo;
        let (portion, tiles) = (&self.portion, self.tiles.as_slice());
        let starts = self.next.clone();
        let shared = Mutex::new(Shared {
            sums: &mut self.sums,
            statistics: &mut self.statistics,
            next: &mut self.next,
        });
        let tile = |&i: &usize| {
            if progress.is_enough() {
                return Err(RenderError::Cancelled);
            }
            let todo = starts[i].max(samples.start)..samples.end;
            let windows = blocks.map_or_else(|| vec![tiles[i]], |blocks| blocks.of_tile(tiles[i]));
            let tile_sums = windows
                .into_iter()
                .map(|window| job.tile(prepared, window, &todo, progress))
                .collect::<Result<Vec<_>, _>>()?;
            // Whoever panicked while holding the lock ends the whole work.
            let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
            for TileSums { film, statistics } in tile_sums {
                shared.sums.merge(&film)?;
                shared.statistics.add(&statistics);
            }
            shared.next[i] = todo.end;
            let Shared { sums, statistics, next } = &*shared;
            let so_far = Snapshot { portion, tiles, next, sums, statistics };
            progress.advance(so_far.done());
            progress.landed(&so_far);
            Ok(())
        };
        if parallel {
            left.par_iter().with_max_len(1).try_for_each(tile)
        } else {
            left.iter().try_for_each(tile)
        }
    }
}

//! The random numbers of samples that are followed one after the other, worked out for a [group](GROUP) of samples of one pixel at a
//! time and kept until they are asked for: the same as [`Sample`]'s, in a third of the time.

use fearless_simd::{Level, Simd, dispatch};

use crate::{
    sampler::{GROUP, Key, Sample, to_unit},
    warp,
};

/// How many keys have a slot, a power of two: more than most paths ask for.
const SLOTS: usize = 128;

/// The numbers of one sample at a time.
#[derive(Debug)]
pub(crate) struct Numbers {
    level: Level,
    sample: Sample,
    /// The first sample of its group, and its place there.
    first: Sample,
    place: usize,
    slots: Box<[Slot; SLOTS]>,
    /// The slots that were asked in this group, or are ready for it.
    listed: Vec<u32>,
}

/// The numbers of a key for a group.
#[derive(Clone, Copy, Debug)]
struct Slot {
    /// A key, and which of its children.
    tag: u64,
    /// The child.
    key: Key,
    /// How often the group asked for it.
    uses: u32,
    is_listed: bool,
    /// Whether the numbers are made.
    is_ready: bool,
    bits: [[u32; GROUP]; 2],
    /// Whether the pairs are there as points of the unit disk, too.
    is_disk: bool,
    disk: [[f64; GROUP]; 2],
}

const EMPTY: Slot = Slot {
    tag: 0,
    key: Key::ROOT,
    uses: 0,
    is_listed: false,
    is_ready: false,
    bits: [[0; GROUP]; 2],
    is_disk: false,
    disk: [[0.0; GROUP]; 2],
};

impl Slot {
    #[inline(always)]
    fn at(&self, place: usize) -> [u32; 2] {
        let [x, y] = &self.bits;
        [x[place % GROUP], y[place % GROUP]]
    }
}

impl Numbers {
    pub(crate) fn new() -> Self {
        let sample = Sample::new(0, 0, 0, 0);
        let (first, place) = sample.in_group();
        let level = Level::new();
        Self { level, sample, first, place, slots: Box::new([EMPTY; SLOTS]), listed: Vec::new() }
    }

    /// Goes on to another sample. The numbers of a group cost about as much as those of a single sample: they are made for the keys
    /// that were asked for more than once in the last group, all together, and for others when they are.
    pub(crate) fn begin(&mut self, sample: Sample) {
        self.sample = sample;
        let (first, place) = sample.in_group();
        self.place = place;
        if first == self.first {
            return;
        }
        self.first = first;
        let slots = &mut self.slots;
        self.listed.retain(|&at| {
            let slot = &mut slots[at as usize % SLOTS];
            slot.is_listed = slot.uses > 1;
            (slot.is_ready, slot.uses) = (slot.is_listed, 0);
            slot.is_listed
        });
        if !self.listed.is_empty() {
            dispatch!(self.level, simd => make(simd, &first, slots, &self.listed));
        }
    }

    /// The sample at hand.
    #[inline]
    pub(crate) fn sample(&self) -> &Sample {
        &self.sample
    }

    #[inline(always)]
    fn bits(&mut self, key: Key, child: u32) -> [u32; 2] {
        let tag = u64::from(key.0) << 32 | u64::from(child);
        let at = place_of(key, child);
        let slot = &mut self.slots[at];
        if slot.tag != tag || !slot.is_ready {
            return self.find(at, tag, key.child(child));
        }
        slot.uses += 1;
        slot.at(self.place)
    }

    #[cold]
    #[inline(never)]
    fn find(&mut self, at: usize, tag: u64, key: Key) -> [u32; 2] {
        let slot = &mut self.slots[at];
        if !slot.is_listed {
            self.listed.push(at as u32);
        }
        if slot.tag != tag || !slot.is_listed {
            *slot = Slot { tag, key, is_listed: true, ..EMPTY };
        }
        slot.uses += 1;
        if slot.uses == 1 {
            return self.sample.bits(key);
        }
        slot.is_ready = true;
        dispatch!(self.level, simd => make(simd, &self.first, &mut self.slots, &[at as u32]));
        self.slots[at].at(self.place)
    }

    /// [`Sample::pair`] for the child of a key.
    #[inline]
    pub(crate) fn pair(&mut self, key: Key, child: u32) -> (f64, f64) {
        let [x, y] = self.bits(key, child);
        (to_unit(x), to_unit(y))
    }

    /// The [`pair`](Self::pair) as a point of the unit disk; see [`warp::disk`].
    #[inline]
    pub(crate) fn disk(&mut self, key: Key, child: u32) -> (f64, f64) {
        let [x, y] = self.bits(key, child);
        let slot = &mut self.slots[place_of(key, child)];
        if !slot.is_ready {
            return warp::disk((to_unit(x), to_unit(y)));
        }
        if !slot.is_disk {
            dispatch!(self.level, simd => make_disk(simd, slot));
        }
        let [x, y] = &slot.disk;
        (x[self.place % GROUP], y[self.place % GROUP])
    }

    /// [`Sample::single`] for the child of a key.
    #[inline]
    pub(crate) fn single(&mut self, key: Key, child: u32) -> f64 {
        to_unit(self.bits(key, child)[0])
    }
}

/// The slot of a child of a key.
#[inline(always)]
fn place_of(key: Key, child: u32) -> usize {
    key.0.wrapping_add(child) as usize % SLOTS
}

/// The pairs of a key for the group that begins with a sample.
pub(crate) fn pairs(level: Level, first: &Sample, key: Key) -> [(f64, f64); GROUP] {
    let [x, y] = dispatch!(level, simd => group(simd, first, key));
    core::array::from_fn(|i| (to_unit(x[i]), to_unit(y[i])))
}

#[inline(always)]
fn group<S: Simd>(_: S, first: &Sample, key: Key) -> [[u32; GROUP]; 2] {
    first.group(key)
}

#[inline(always)]
fn make<S: Simd>(_: S, first: &Sample, slots: &mut [Slot; SLOTS], which: &[u32]) {
    for &at in which {
        let slot = &mut slots[at as usize % SLOTS];
        slot.bits = first.group(slot.key);
        slot.is_disk = false;
    }
}

/// All points of the disk at once.
#[inline(always)]
fn make_disk<S: Simd>(_: S, slot: &mut Slot) {
    let ([u, v], [x, y]) = (&slot.bits, &mut slot.disk);
    for i in 0..GROUP {
        (x[i], y[i]) = warp::disk((to_unit(u[i]), to_unit(v[i])));
    }
    slot.is_disk = true;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_a_group_are_those_of_its_samples() {
        let (first, _) = Sample::new(3, 5, 7, 16).in_group();
        for (i, pair) in (16..).zip(pairs(Level::new(), &first, Key::LENS)) {
            assert_eq!(pair, Sample::new(3, 5, 7, i).pair(Key::LENS));
        }
    }

    #[test]
    fn numbers_are_those_of_the_sample_in_any_order() {
        let mut numbers = Numbers::new();
        for i in 0..20_000_u32 {
            // Now and then another pixel, or a sample of long before; keys come again, and push each other out.
            let (x, y, n) = (i / 700 % 3, i / 2000, (i * 7 + i / 64) % 41 + i / 999 * 5000);
            let sample = Sample::new(3, x, y, n);
            numbers.begin(sample);
            let (key, child) = (Key::ROOT.child(i % 23).child(i % 3), i * i % 19);
            assert_eq!(numbers.pair(key, child), sample.pair(key.child(child)));
            assert_eq!(numbers.single(key, child), sample.single(key.child(child)));
            assert_eq!(numbers.disk(key, child), warp::disk(sample.pair(key.child(child))));
        }
    }
}

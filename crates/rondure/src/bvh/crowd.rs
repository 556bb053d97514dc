//! Which items make up the crowd, and which stand aside.
//!
//! Boxes in f32 are padded by a millionth of the whole. One sphere as large as a planet, or one far
//! away, would make that more than the size of all the rest, and every ray would meet every box.
//! Therefore a few items that reach much farther than all others are left out of the tree.

use std::collections::BTreeMap;

use crate::{Bounds, Vec3};

/// The most items that may stand aside: every ray pays for them.
const MOST_ASIDE: u64 = 16;

/// How much farther they must reach than all the others, as a power of two.
const FARTHER: i32 = 6;

/// How many items tell where the middle is.
const SAMPLES: u32 = 1023;

/// How far items reach from the middle of the crowd.
#[derive(Clone, Debug)]
pub(super) struct Crowd {
    middle: Vec3,
    /// By the power of two up to which they reach: how many do, and the box round them.
    reaching: BTreeMap<i32, (u64, Bounds)>,
    /// Those who reach farther stand aside.
    limit: i32,
}

impl Crowd {
    /// The crowd of no items yet, round the middle of those that `bounds` has: the median of some.
    pub(super) fn round_middle(count: u32, bounds: impl Fn(u32) -> Option<Bounds>) -> Self {
        let step = count.div_ceil(SAMPLES).max(1) as usize;
        let centers: Vec<_> = (0..count)
            .step_by(step)
            .filter_map(bounds)
            .map(|b| b.min * 0.5 + b.max * 0.5)
            .collect();
        let median = |axis: usize| {
            let mut along: Vec<_> = centers.iter().map(|c| c[axis]).collect();
            along.sort_by(f64::total_cmp);
            along.get(along.len() / 2).copied().unwrap_or(0.0)
        };
        let middle = Vec3::new(median(0), median(1), median(2));
        Self { middle, reaching: BTreeMap::new(), limit: i32::MAX }
    }

    fn reach(&self, bounds: &Bounds) -> i32 {
        let reach = (bounds.min - self.middle).max_abs().max((bounds.max - self.middle).max_abs());
        // The exponent's bits; 2^-1023 and less are as good as nothing.
        (reach.to_bits() >> 52) as i32
    }

    pub(super) fn add(&mut self, bounds: &Bounds) {
        let own = self.reaching.entry(self.reach(bounds)).or_insert((0, Bounds::EMPTY));
        *own = (own.0 + 1, own.1.union(bounds));
    }

    /// Both crowds, round the same middle.
    pub(super) fn union(mut self, other: Self) -> Self {
        for (reach, (count, bounds)) in other.reaching {
            let own = self.reaching.entry(reach).or_insert((0, Bounds::EMPTY));
            *own = (own.0 + count, own.1.union(&bounds));
        }
        self
    }

    /// Decides who stands aside.
    pub(super) fn decided(mut self) -> Self {
        let mut aside = 0;
        let mut farther = i32::MIN;
        for (&reach, (count, _)) in self.reaching.iter().rev() {
            if farther >= reach + FARTHER {
                self.limit = reach;
            }
            farther = reach;
            aside += count;
            if aside > MOST_ASIDE {
                break;
            }
        }
        self
    }

    pub(super) fn stands_aside(&self, bounds: &Bounds) -> bool {
        self.reach(bounds) > self.limit
    }

    /// The box round all, and the one round those who do not stand aside.
    pub(super) fn bounds(&self) -> [Bounds; 2] {
        let within = |limit| {
            let boxes = self.reaching.range(..=limit).map(|(_, (_, bounds))| bounds);
            boxes.fold(Bounds::EMPTY, |all, b| all.union(b))
        };
        [within(i32::MAX), within(self.limit)]
    }
}

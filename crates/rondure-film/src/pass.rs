//! Passes: the ranges of sample numbers in which a picture is made.
//!
//! The samples of every pixel are taken in the same ranges, whoever takes them and however many are asked for: [0, 1), [1, 2), [2, 4),
//! [4, 8), [8, 16), and from there on 16 at a time. So a rough picture is there soon, and what is made once for a pass, such as a photon map,
//! is the same on every machine that takes a share of it.

use core::ops::Range;

/// The most samples of a pixel in one pass, as a power of two.
const LARGEST_BITS: u32 = 4;

/// A pass over the picture, by its number from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pass(pub u32);

impl Pass {
    /// The pass that a sample belongs to.
    pub const fn of(sample: u32) -> Self {
        match sample.checked_ilog2() {
            None => Self(0),
            Some(log) if log < LARGEST_BITS => Self(log + 1),
            Some(_) => Self(LARGEST_BITS + (sample >> LARGEST_BITS)),
        }
    }

    /// The numbers of its samples.
    pub const fn samples(self) -> Range<u32> {
        match self.0 {
            0 => 0..1,
            n if n <= LARGEST_BITS => 1 << (n - 1)..1 << n,
            n => {
                let start = (n - LARGEST_BITS) << LARGEST_BITS;
                start..start + (1 << LARGEST_BITS)
            }
        }
    }

    /// The passes that have a share in these samples, each with its share.
    pub fn of_range(samples: Range<u32>) -> impl Iterator<Item = (Self, Range<u32>)> + Clone {
        let behind = match samples.is_empty() {
            true => 0,
            false => Self::of(samples.end - 1).0 + 1,
        };
        let numbers = Self::of(samples.start).0.min(behind)..behind;
        numbers.map(move |n| {
            let all = Self(n).samples();
            (Self(n), all.start.max(samples.start)..all.end.min(samples.end))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_follow_each_other() {
        let starts: Vec<_> = (0..9).map(|n| Pass(n).samples()).collect();
        assert_eq!(starts, [0..1, 1..2, 2..4, 4..8, 8..16, 16..32, 32..48, 48..64, 64..80]);
        for sample in (0..3000).chain([1 << 20, u32::MAX - 64]) {
            assert!(Pass::of(sample).samples().contains(&sample), "{sample}");
        }
    }

    #[test]
    fn ranges_are_cut_at_passes() {
        let cut = |range| Pass::of_range(range).map(|(p, r)| (p.0, r)).collect::<Vec<_>>();
        assert_eq!(cut(0..3), [(0, 0..1), (1, 1..2), (2, 2..3)]);
        assert_eq!(cut(5..40), [(3, 5..8), (4, 8..16), (5, 16..32), (6, 32..40)]);
        assert_eq!(cut(7..7), []);
        assert_eq!(cut(17..18), [(5, 17..18)]);
    }
}

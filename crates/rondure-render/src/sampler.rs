//! Well distributed random numbers: Owen-scrambled Sobol points, without state.
//!
//! Every number is a pure function of (seed, pixel, sample, dimension), so that no order of work
//! can change a picture. A dimension is a [`Key`]; each key has its own two-dimensional
//! Owen-scrambled (0, 2)-sequence (Burley 2020, "Practical Hash-based Owen Scrambling", with
//! Vegdahl's constants for the hash), shuffled against those of the other keys.
//!
//! The samples of all pixels come from one sequence, dealt out along the Morton curve (Ahmed and
//! Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical
//! Ordering of Pixels"): the points of a pixel are well spread, those of any 2x2, 4x4, ... pixels
//! together are too, and what error is left looks like fine grain instead of blotches.

/// The pixels across and down in a block that shares one sequence, as a power of two.
const BLOCK_BITS: u32 = 8;
/// The most parts that a sample can be split into, as a power of two.
pub(crate) const SPLIT_BITS: u32 = 2;
/// The samples of a pixel that one sequence can hold, as a power of two.
const SAMPLE_BITS: u32 = u32::BITS - 2 * BLOCK_BITS - SPLIT_BITS;

/// The name of a two-dimensional set of sample points: where on the way of the light it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key(u32);

impl Key {
    pub(crate) const FILTER: Self = Self(1);
    pub(crate) const LENS: Self = Self(2);
    /// The first surface that the eye sees; its successors are its children.
    pub(crate) const ROOT: Self = Self(3);

    /// The `n`-th of the keys that belong to this one.
    #[inline]
    pub(crate) fn child(self, n: u32) -> Self {
        Self(mix(self.0, n))
    }
}

/// One sample of one pixel: the source of all random numbers that its light needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// The place in the sequence, its bits in reverse order.
    reversed_index: u32,
    seed: u32,
}

impl Sample {
    pub(crate) fn new(seed: u64, x: u32, y: u32, sample: u32, spp: u32) -> Self {
        let per_pixel = spp.next_power_of_two().trailing_zeros().min(SAMPLE_BITS);
        let mask = (1 << BLOCK_BITS) - 1;
        let morton = spread_bits(x & mask) | spread_bits(y & mask) << 1;
        let index = morton << per_pixel | (sample & ((1 << per_pixel) - 1));
        // A sequence that is used up begins anew, scrambled in another way.
        let block = mix(mix(x >> BLOCK_BITS, y >> BLOCK_BITS), sample >> per_pixel);
        let seed = mix(mix(seed as u32, (seed >> 32) as u32), block);
        Self { reversed_index: index.reverse_bits(), seed }
    }

    /// The `part`-th of 2^`bits` samples in the place of this one, spread as well as if the pixel
    /// had had so many from the start.
    #[inline]
    pub(crate) fn part(&self, part: u32, bits: u32) -> Self {
        debug_assert!(bits <= SPLIT_BITS && part < 1 << bits);
        Self { reversed_index: self.reversed_index >> bits | part.reverse_bits(), ..*self }
    }

    /// A point of the open unit square.
    #[inline]
    pub(crate) fn pair(&self, key: Key) -> (f64, f64) {
        let seed = mix(self.seed, key.0);
        let index = laine_karras(self.reversed_index, seed).reverse_bits();
        let x = laine_karras(index, mix(seed, 1)).reverse_bits();
        let y = laine_karras(sobol_reversed(index), mix(seed, 2)).reverse_bits();
        (to_unit(x), to_unit(y))
    }

    /// A number between 0 and 1, neither included.
    #[inline]
    pub(crate) fn single(&self, key: Key) -> f64 {
        let seed = mix(self.seed, key.0);
        let index = laine_karras(self.reversed_index, seed).reverse_bits();
        to_unit(laine_karras(index, mix(seed, 1)).reverse_bits())
    }
}

#[inline]
fn to_unit(bits: u32) -> f64 {
    const STEP: f64 = 1.0 / 4_294_967_296.0;
    (f64::from(bits) + 0.5) * STEP
}

/// A hash of two words (Murmur3's finisher).
#[inline]
pub(crate) fn mix(a: u32, b: u32) -> u32 {
    let mut h = a.rotate_left(13).wrapping_mul(0x9e37_79b1) ^ b.wrapping_add(0x85eb_ca6b);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

/// The hash in which each bit depends on itself and the lower ones alone: on numbers with their
/// bits in reverse order, Owen's scrambling.
#[inline]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol dimension, bits in reverse order. Its matrix is Pascal's triangle modulo 2, bit
/// j of the result the sum of the bits k with C(k, j) odd, which by Lucas' theorem are those whose
/// k holds all binary digits of j: five steps sum over all of them.
#[inline]
fn sobol_reversed(mut index: u32) -> u32 {
    index ^= index >> 1 & 0x5555_5555;
    index ^= index >> 2 & 0x3333_3333;
    index ^= index >> 4 & 0x0f0f_0f0f;
    index ^= index >> 8 & 0x00ff_00ff;
    index ^ index >> 16
}

/// Moves bit k to bit 2 k.
fn spread_bits(mut x: u32) -> u32 {
    x = (x | x << 8) & 0x00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_dimension_has_sobol_direction_numbers() {
        let mut direction = 1_u32 << 31;
        for k in 0..32 {
            assert_eq!(sobol_reversed(1 << k).reverse_bits(), direction, "bit {k}");
            direction ^= direction >> 1;
        }
    }

    /// Every elementary interval of area 1/n holds exactly one of the n points.
    fn assert_net(points: &[(f64, f64)]) {
        let n = points.len();
        let m = n.trailing_zeros();
        for i in 0..=m {
            let (across, down) = (1 << i, 1 << (m - i));
            let mut seen = vec![false; n];
            for &(x, y) in points {
                let cell = (x * across as f64) as usize * down + (y * down as f64) as usize;
                assert!(!seen[cell], "two points in one cell of {across} x {down}");
                seen[cell] = true;
            }
        }
    }

    #[test]
    fn samples_of_a_pixel_are_a_net() {
        for (x, y) in [(0, 0), (3, 7), (255, 255), (256, 0), (4000, 3000)] {
            for key in [Key::FILTER, Key::LENS, Key::ROOT.child(5)] {
                let points: Vec<_> =
                    (0..64).map(|s| Sample::new(1, x, y, s, 64).pair(key)).collect();
                assert_net(&points);
            }
        }
    }

    #[test]
    fn samples_of_neighbours_are_a_net_together() {
        let mut points = Vec::new();
        for y in 4..8 {
            for x in 12..16 {
                points.extend((0..4).map(|s| Sample::new(9, x, y, s, 4).pair(Key::ROOT)));
            }
        }
        assert_net(&points);
    }

    #[test]
    fn parts_of_the_samples_of_a_pixel_are_a_net() {
        let part = |s, part| Sample::new(1, 700, 9, s, 16).part(part, 2).pair(Key::LENS);
        assert_net(&(0..64).map(|i| part(i / 4, i % 4)).collect::<Vec<_>>());
        let sample = Sample::new(1, 700, 9, 3, 16);
        assert_eq!(sample.part(0, 0).pair(Key::LENS), sample.pair(Key::LENS));
    }

    #[test]
    fn samples_depend_on_every_argument() {
        let base = Sample::new(1, 2, 3, 4, 16).pair(Key::LENS);
        assert_eq!(base, Sample::new(1, 2, 3, 4, 16).pair(Key::LENS));
        for other in [
            Sample::new(2, 2, 3, 4, 16).pair(Key::LENS),
            Sample::new(1 << 40 | 1, 2, 3, 4, 16).pair(Key::LENS),
            Sample::new(1, 3, 3, 4, 16).pair(Key::LENS),
            Sample::new(1, 2 + 256, 3, 4, 16).pair(Key::LENS),
            Sample::new(1, 2, 4, 4, 16).pair(Key::LENS),
            Sample::new(1, 2, 3, 5, 16).pair(Key::LENS),
            Sample::new(1, 2, 3, 4, 16).pair(Key::FILTER),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn dimensions_are_not_correlated() {
        let n = 4096;
        for (a, b) in [(Key::FILTER, Key::LENS), (Key::ROOT.child(0), Key::ROOT.child(1))] {
            let mut sum = 0.0;
            for s in 0..n {
                let sample = Sample::new(7, 1, 1, s, n);
                sum += (sample.single(a) - 0.5) * (sample.single(b) - 0.5);
            }
            let correlation = 12.0 * sum / f64::from(n);
            assert!(correlation.abs() < 0.05, "{correlation}");
        }
    }

    #[test]
    fn more_samples_than_a_sequence_holds_do_not_repeat() {
        let n = 1 << 20;
        let a = Sample::new(0, 1, 1, 5, n).pair(Key::LENS);
        let b = Sample::new(0, 1, 1, 5 + (1 << SAMPLE_BITS), n).pair(Key::LENS);
        assert_ne!(a, b);
    }
}

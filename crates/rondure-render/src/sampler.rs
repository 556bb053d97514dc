//! Well distributed random numbers: Owen-scrambled Sobol points, without state.
//!
//! Every number is a pure function of (seed, pixel, sample, dimension), so that no order of work
//! can change a picture. A dimension is a [`Key`]; each key has its own two-dimensional
//! Owen-scrambled (0, 2)-sequence (Burley 2020, "Practical Hash-based Owen Scrambling", with
//! Vegdahl's constants for the hash), shuffled against those of the other keys.
//!
//! The samples of a pixel are the first of one sequence, however many there will be, and any 2^k of them together with those of the
//! pixels of an aligned square of 2x2, 4x4, ... 256x256 are a net too: no two in an elementary interval. So what error is left looks
//! like fine grain instead of blotches (Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
//! Hierarchical Ordering of Pixels"), at every number of samples on the way. They deal out one sequence along the Morton curve, for
//! which the number of samples must be known before; here the Morton number moves the pixel's own sequence by a digital shift instead:
//! point(s, m) = Sobol(s) + [`SHIFTS`] m over the field of two elements. The columns of `SHIFTS` are such that with the first k of
//! Sobol's for each k up to 16, the first 2 j of them are generators of a net, for each j up to 8. Their bits were drawn at random row
//! by row, again where one of the square matrices in question was singular; the tests look at all of those.

/// The pixels across and down in a block that shares one sequence, as a power of two.
const BLOCK_BITS: u32 = 8;
/// The most parts that a sample can be split into, as a power of two.
pub(crate) const SPLIT_BITS: u32 = 2;
/// The samples of a pixel that one sequence can hold, as a power of two.
const SAMPLE_BITS: u32 = 16 - SPLIT_BITS;

/// For each bit of a Morton number the digital shift of (x, y), digits from the lowest bit on.
const SHIFTS: [[u32; 2]; 2 * BLOCK_BITS as usize] = [
    [0x47e3_b6db, 0x5c1b_b6db],
    [0x3c21_6db6, 0xc556_db6d],
    [0xe35f_e79e, 0xcbbf_e79e],
    [0x882b_1451, 0x89e7_4514],
    [0x1d37_ab1a, 0x879c_1dc1],
    [0x1dae_fd2f, 0xc068_3b83],
    [0x2f1d_b4fb, 0x068b_85d8],
    [0xaa10_3303, 0x7072_0220],
    [0xb07a_5d53, 0x3def_464f],
    [0x8883_ca07, 0xce37_07a6],
    [0x3ebe_0def, 0x681a_910b],
    [0x4ad2_0187, 0x8e3f_f801],
    [0x30c6_100a, 0x694b_0c11],
    [0x526c_aace, 0x9425_a3c0],
    [0x38c0_94d4, 0x1df3_beeb],
    [0xfcdc_b004, 0xb888_05dd],
];

/// The shifts of all bytes of Morton numbers, the low one and the high one.
static SHIFT_TABLE: [[[u32; 2]; 256]; 2] = {
    let mut table = [[[0; 2]; 256]; 2];
    let mut i = 0;
    while i < 2 * 256 {
        let (half, byte) = (i / 256, i % 256);
        let mut bit = 0;
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                table[half][byte][0] ^= SHIFTS[8 * half + bit][0];
                table[half][byte][1] ^= SHIFTS[8 * half + bit][1];
            }
            bit += 1;
        }
        i += 1;
    }
    table
};

/// The name of a two-dimensional set of sample points: where on the way of the light it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key(pub(crate) u32);

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

/// How many samples of a pixel that follow each other are worked out at once, as a power of two.
const GROUP_BITS: u32 = 3;
pub(crate) const GROUP: usize = 1 << GROUP_BITS;

/// One sample of one pixel: the source of all random numbers that its light needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sample {
    /// The place in the pixel's sequence, its bits in reverse order.
    reversed_index: u32,
    /// The pixel's Morton number in its block, its bits in reverse order.
    reversed_morton: u32,
    seed: u32,
}

impl Sample {
    /// The sample with this number, from 0, of the pixel in column `x` and row `y`.
    pub(crate) fn new(seed: u64, x: u32, y: u32, sample: u32) -> Self {
        let mask = (1 << BLOCK_BITS) - 1;
        let morton = spread_bits(x & mask) | spread_bits(y & mask) << 1;
        let index = sample & ((1 << SAMPLE_BITS) - 1);
        // A sequence that is used up begins anew, scrambled in another way.
        let block = mix(mix(x >> BLOCK_BITS, y >> BLOCK_BITS), sample >> SAMPLE_BITS);
        let seed = mix(mix(seed as u32, (seed >> 32) as u32), block);
        Self { reversed_index: index.reverse_bits(), reversed_morton: morton.reverse_bits(), seed }
    }

    /// The `part`-th of 2^`bits` samples in the place of this one, spread as well as if the pixel
    /// had had so many from the start.
    #[inline]
    pub(crate) fn part(&self, part: u32, bits: u32) -> Self {
        debug_assert!(bits <= SPLIT_BITS && part < 1 << bits);
        Self { reversed_index: self.reversed_index >> bits | part.reverse_bits(), ..*self }
    }

    /// The shift of the pixel in the sequence of a key. Pixels are shuffled so that aligned squares of them stay together.
    #[inline(always)]
    fn shift(&self, seed: u32) -> [u32; 2] {
        let morton = laine_karras(self.reversed_morton, mix(seed, 3)).reverse_bits();
        let low = SHIFT_TABLE[0][(morton & 0xff) as usize];
        let high = SHIFT_TABLE[1][(morton >> 8 & 0xff) as usize];
        [low[0] ^ high[0], low[1] ^ high[1]]
    }

    /// A point of the open unit square, the digits of its two numbers.
    #[inline]
    pub(crate) fn bits(&self, key: Key) -> [u32; 2] {
        let seed = mix(self.seed, key.0);
        let seeds = [mix(seed, 1), mix(seed, 2)];
        point(index(self.reversed_index, seed), self.shift(seed), seeds)
    }

    /// A point of the open unit square.
    #[inline]
    pub(crate) fn pair(&self, key: Key) -> (f64, f64) {
        let [x, y] = self.bits(key);
        (to_unit(x), to_unit(y))
    }

    /// A number between 0 and 1, neither included: the first of the [`pair`](Self::pair).
    #[inline]
    pub(crate) fn single(&self, key: Key) -> f64 {
        let seed = mix(self.seed, key.0);
        let index = index(self.reversed_index, seed) ^ self.shift(seed)[0];
        to_unit(laine_karras(index, mix(seed, 1)).reverse_bits())
    }

    /// The first of the aligned [`GROUP`] of samples of the pixel that this one is of, and its place there.
    #[inline]
    pub(crate) fn in_group(&self) -> (Self, usize) {
        let below = u32::MAX >> GROUP_BITS;
        let place = (self.reversed_index & !below).reverse_bits() as usize;
        (Self { reversed_index: self.reversed_index & below, ..*self }, place)
    }

    /// [`bits`](Self::bits) for all samples of the group that begins with this one, with one key: loops
    /// that become instructions for all at once.
    #[inline(always)]
    pub(crate) fn group(&self, key: Key) -> [[u32; GROUP]; 2] {
        let seed = mix(self.seed, key.0);
        let shift = self.shift(seed);
        let seeds = [mix(seed, 1), mix(seed, 2)];
        let (mut x, mut y) = ([0; GROUP], [0; GROUP]);
        for (i, (x, y)) in (0..).zip(x.iter_mut().zip(&mut y)) {
            let reversed_index = self.reversed_index | u32::reverse_bits(i);
            [*x, *y] = point(index(reversed_index, seed), shift, seeds);
        }
        [x, y]
    }

    /// The number of the sample, counted on from one that depends on the pixel and the key.
    #[inline]
    pub(crate) fn turn(&self, key: Key) -> u32 {
        let first = mix(mix(self.seed, key.0), self.reversed_morton);
        first.wrapping_add(self.reversed_index.reverse_bits())
    }
}

/// The place of a sample in the sequence of a key: shuffled so that aligned ranges of places stay together.
#[inline(always)]
fn index(reversed_index: u32, seed: u32) -> u32 {
    laine_karras(reversed_index, seed).reverse_bits() & 0xffff
}

/// The point at a place of the sequence, shifted and scrambled.
#[inline(always)]
fn point(index: u32, shift: [u32; 2], seeds: [u32; 2]) -> [u32; 2] {
    let x = laine_karras(index ^ shift[0], seeds[0]).reverse_bits();
    let y = laine_karras(sobol_reversed(index) ^ shift[1], seeds[1]).reverse_bits();
    [x, y]
}

/// A number between 0 and 1, neither included, of 32 random bits.
#[inline]
pub(crate) fn to_unit(bits: u32) -> f64 {
    const STEP: f64 = 1.0 / 4_294_967_296.0;
    (f64::from(bits) + 0.5) * STEP
}

/// A hash of two words (Murmur3's finisher).
#[inline(always)]
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
#[inline(always)]
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
#[inline(always)]
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

    /// Whether these rows, each a row of a square matrix over the field of two elements, are independent.
    fn independent(rows: impl Iterator<Item = u64>) -> bool {
        let mut basis = [0_u64; 64];
        for mut row in rows {
            while row != 0 && basis[row.ilog2() as usize] != 0 {
                row ^= basis[row.ilog2() as usize];
            }
            if row == 0 {
                return false;
            }
            basis[row.ilog2() as usize] = row;
        }
        true
    }

    #[test]
    fn shifts_and_any_number_of_samples_generate_nets() {
        for k in 0..=16_u32 {
            // For each digit of x and y, which bits of the sample's number and of the Morton number it is the sum of.
            let row = |digit: u32, axis: usize, n: u32| {
                let sobol = |bit: u32| if axis == 0 { 1 << bit } else { sobol_reversed(1 << bit) };
                let of_sample = (0..k).map(|b| u64::from(sobol(b) >> digit & 1) << b);
                let of_pixel =
                    (0..n).map(|c| u64::from(SHIFTS[c as usize][axis] >> digit & 1) << (k + c));
                of_sample.chain(of_pixel).sum::<u64>()
            };
            for n in (0..=16).step_by(2) {
                for across in 0..=k + n {
                    let x = (0..across).map(|digit| row(digit, 0, n));
                    let y = (0..k + n - across).map(|digit| row(digit, 1, n));
                    assert!(independent(x.chain(y)), "{k} {n} {across}");
                }
            }
        }
    }

    #[test]
    fn samples_of_a_pixel_are_a_net() {
        for (x, y) in [(0, 0), (3, 7), (255, 255), (256, 0), (4000, 3000)] {
            for key in [Key::FILTER, Key::LENS, Key::ROOT.child(5)] {
                let points: Vec<_> = (0..64).map(|s| Sample::new(1, x, y, s).pair(key)).collect();
                assert_net(&points);
            }
        }
    }

    #[test]
    fn samples_of_neighbours_are_a_net_together() {
        for samples in [1, 2, 4, 16, 32] {
            for edge in [2, 4, 8] {
                for key in [Key::FILTER, Key::ROOT.child(3)] {
                    let mut points = Vec::new();
                    for (x, y) in (0..edge * edge).map(|i| (16 + i % edge, 24 + i / edge)) {
                        points.extend((0..samples).map(|s| Sample::new(9, x, y, s).pair(key)));
                    }
                    assert_net(&points);
                }
            }
        }
    }

    #[test]
    fn parts_of_the_samples_of_a_pixel_are_a_net() {
        let part = |s, part| Sample::new(1, 700, 9, s).part(part, 2).pair(Key::LENS);
        assert_net(&(0..64).map(|i| part(i / 4, i % 4)).collect::<Vec<_>>());
        let sample = Sample::new(1, 700, 9, 3);
        assert_eq!(sample.part(0, 0).pair(Key::LENS), sample.pair(Key::LENS));
    }

    #[test]
    fn samples_depend_on_every_argument() {
        let base = Sample::new(1, 2, 3, 4).pair(Key::LENS);
        assert_eq!(base, Sample::new(1, 2, 3, 4).pair(Key::LENS));
        for other in [
            Sample::new(2, 2, 3, 4).pair(Key::LENS),
            Sample::new(1 << 40 | 1, 2, 3, 4).pair(Key::LENS),
            Sample::new(1, 3, 3, 4).pair(Key::LENS),
            Sample::new(1, 2 + 256, 3, 4).pair(Key::LENS),
            Sample::new(1, 2, 4, 4).pair(Key::LENS),
            Sample::new(1, 2, 3, 5).pair(Key::LENS),
            Sample::new(1, 2, 3, 4).pair(Key::FILTER),
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
                let sample = Sample::new(7, 1, 1, s);
                sum += (sample.single(a) - 0.5) * (sample.single(b) - 0.5);
            }
            let correlation = 12.0 * sum / f64::from(n);
            assert!(correlation.abs() < 0.05, "{correlation}");
        }
    }

    #[test]
    fn dimensions_of_neighbours_are_not_correlated() {
        for (a, b) in [(Key::FILTER, Key::LENS), (Key::ROOT.child(0), Key::ROOT.child(1))] {
            let mut sum = 0.0;
            for i in 0..4096 {
                let sample = Sample::new(7, i % 64, i / 64, 0);
                sum += (sample.single(a) - 0.5) * (sample.single(b) - 0.5);
            }
            let correlation = 12.0 * sum / 4096.0;
            assert!(correlation.abs() < 0.05, "{correlation}");
        }
    }

    #[test]
    fn more_samples_than_a_sequence_holds_do_not_repeat() {
        let a = Sample::new(0, 1, 1, 5).pair(Key::LENS);
        let b = Sample::new(0, 1, 1, 5 + (1 << SAMPLE_BITS)).pair(Key::LENS);
        assert_ne!(a, b);
    }
}

//! The sums of a pixel as bytes, little endian: so they stand in files of shares and in scratch files.

use crate::{
    Center, Film, Layers, Sum,
    film::{Count, GuideSums},
};

/// How many bytes a pixel takes.
pub(crate) const fn bytes(layers: Layers) -> u64 {
    56 + 72 * layers.variance as u64 + 72 * layers.guides as u64
}

/// Appends words.
pub(crate) fn put_words(to: &mut Vec<u8>, words: &[u32]) {
    words.iter().for_each(|word| to.extend_from_slice(&word.to_le_bytes()));
}

/// Appends the pixel of number `i` of a film.
pub(crate) fn put(to: &mut Vec<u8>, film: &Film, i: usize) {
    fn sums<const L: usize, const F: u32>(to: &mut Vec<u8>, sums: &[Sum<L, F>; 3]) {
        let limbs = sums.iter().flat_map(Sum::limbs);
        limbs.for_each(|limb| to.extend_from_slice(&limb.to_le_bytes()));
    }
    sums(to, &film.light[i]);
    put_words(to, &[film.counts[i].samples, film.counts[i].weight as u32]);
    if film.layers().variance {
        sums(to, &film.squares[i]);
    }
    if film.layers().guides {
        sums(to, &film.guides[i].albedo);
        sums(to, &film.guides[i].normal);
        let Center { depth, position: [x, y, z], object, material } = film.centers[i];
        put_words(to, &[depth, x, y, z].map(f32::to_bits));
        put_words(to, &[object, material]);
    }
}

/// Bytes that are read from the front.
pub(crate) struct Fields<'a> {
    pub(crate) rest: &'a [u8],
}

impl Fields<'_> {
    pub(crate) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*head)
    }

    pub(crate) fn word(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn long(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn sums<const L: usize, const F: u32>(&mut self) -> Option<[Sum<L, F>; 3]> {
        let mut sums = [Sum::default(); 3];
        for sum in &mut sums {
            let mut limbs = [0; L];
            for limb in &mut limbs {
                *limb = self.long()?;
            }
            *sum = Sum::from_limbs(limbs);
        }
        Some(sums)
    }

    /// The pixel of number `i` of a film; `None` if the bytes end within it.
    pub(crate) fn pixel(&mut self, film: &mut Film, i: usize) -> Option<()> {
        film.light[i] = self.sums()?;
        film.counts[i] = Count { samples: self.word()?, weight: self.word()? as i32 };
        if film.layers().variance {
            film.squares[i] = self.sums()?;
        }
        if film.layers().guides {
            film.guides[i] = GuideSums { albedo: self.sums()?, normal: self.sums()? };
            let [depth, x, y, z] =
                [self.word()?, self.word()?, self.word()?, self.word()?].map(f32::from_bits);
            let (object, material) = (self.word()?, self.word()?);
            film.centers[i] = Center { depth, position: [x, y, z], object, material };
        }
        Some(())
    }
}

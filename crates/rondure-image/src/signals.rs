//! Signals: what stands in a file and drives a screen, made of light by a [`Look`], the sRGB curve and a dither.

use std::borrow::Cow;

use crate::{Image, Look, tone};

/// How many bits a signal has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Depth {
    /// 8 bits, from 0 to 255.
    #[default]
    Eight,
    /// 16 bits, from 0 to 65535.
    Sixteen,
}

impl Depth {
    /// The depth with so many bits, 8 or 16.
    pub const fn of_bits(bits: u8) -> Option<Self> {
        match bits {
            8 => Some(Self::Eight),
            16 => Some(Self::Sixteen),
            _ => None,
        }
    }
}

/// Red, green and blue of each pixel, as signals in sRGB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Signals {
    /// From 0 to 255.
    Eight(Vec<u8>),
    /// From 0 to 65535.
    Sixteen(Vec<u16>),
}

impl Signals {
    /// How many bits each has.
    pub fn depth(&self) -> Depth {
        match self {
            Self::Eight(_) => Depth::Eight,
            Self::Sixteen(_) => Depth::Sixteen,
        }
    }

    /// The bytes that a file has, the more significant one first.
    pub(crate) fn bytes(&self) -> Cow<'_, [u8]> {
        match self {
            Self::Eight(all) => all.into(),
            Self::Sixteen(all) => all.iter().flat_map(|v| v.to_be_bytes()).collect(),
        }
    }
}

impl Look {
    /// The signals that show rows of a picture as this look has it: `pixels` in rows of `width`, the first of which has the number `y`.
    pub fn signals(&self, pixels: &[[f32; 3]], width: u32, y: u32, depth: Depth) -> Signals {
        let columns = width.max(1) as usize;
        let all = |max: f64| {
            pixels.iter().enumerate().flat_map(move |(i, pixel)| {
                let row = y.wrapping_add((i / columns) as u32);
                let threshold = tone::threshold((i % columns) as u32, row);
                self.show(*pixel).map(|v| tone::quantize(v, max, threshold))
            })
        };
        match depth {
            Depth::Eight => Signals::Eight(all(255.0).map(|v| v as u8).collect()),
            Depth::Sixteen => Signals::Sixteen(all(65535.0).map(|v| v as u16).collect()),
        }
    }
}

impl Image {
    /// The signals that show it as a look has it.
    pub fn signals(&self, look: &Look, depth: Depth) -> Signals {
        look.signals(self.pixels(), self.width(), 0, depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_the_signals_of_the_picture() {
        let pixels: Vec<_> = (0..35).map(|i| [i as f32 / 34.0, 0.4321, 0.1]).collect();
        let image = Image::new(5, 7, pixels.clone()).unwrap();
        let look = Look::default();
        for depth in [Depth::Eight, Depth::Sixteen] {
            let whole = image.signals(&look, depth);
            let rows = pixels.chunks(10).zip([0, 2, 4, 6]);
            let cut = rows.map(|(row, y)| look.signals(row, 5, y, depth).bytes().into_owned());
            assert_eq!(*whole.bytes(), cut.collect::<Vec<_>>().concat());
        }
        assert_eq!(image.signals(&look, Depth::Eight).depth(), Depth::Eight);
        assert_eq!(Depth::of_bits(16), Some(Depth::Sixteen));
        assert_eq!(Depth::of_bits(12), None);
    }
}

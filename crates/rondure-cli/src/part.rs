//! The options that choose a part of a picture: one of a number of parts, a tile, a range of samples.

use core::{ops::Range, str::FromStr};

use clap::Args;
use rondure_film::{Portion, Share, Window};
use rondure_render::NOISE_BLOCK;

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct PartArgs {
    /// Make part K of N, a band of rows, to be merged with the others
    #[arg(long, value_name = "K/N", conflicts_with_all = ["tile", "sample_range"], help_heading = PARTS)]
    part: Option<Part>,

    /// Make the pixels of a tile only: column, row, width and height
    #[arg(long, value_name = "X,Y,W,H", help_heading = PARTS)]
    tile: Option<Tile>,

    /// Take samples A to B - 1 of each pixel only, counted from 0
    #[arg(long, value_name = "A..B", help_heading = PARTS)]
    sample_range: Option<SampleRange>,
}

const PARTS: &str = "Parts of pictures";

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) number: u32,
    pub(crate) of: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Tile(Window);

#[derive(Clone, Debug, PartialEq)]
struct SampleRange(Range<u32>);

impl FromStr for Part {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (number, of) = text.split_once('/')?;
            let (number, of) = (number.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&number).then_some(Self { number, of })
        };
        parse().ok_or("a part is K/N, like 2/7, with K from 1 to N")
    }
}

impl FromStr for Tile {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Option<Vec<u32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, width, height]) if width > 0 && height > 0 => {
                Ok(Self(Window { x, y, width, height }))
            }
            _ => Err("a tile is X,Y,W,H in pixels from the upper left corner, like 0,0,100,50"),
        }
    }
}

impl FromStr for SampleRange {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (start, end) = text.split_once("..")?;
            let (start, end) = (start.parse().ok()?, end.parse().ok()?);
            (start < end).then_some(Self(start..end))
        };
        parse().ok_or("a range of samples is A..B, like 0..16, with A less than B")
    }
}

impl PartArgs {
    /// Whether only a part is to be made.
    pub(crate) fn is_some(&self) -> bool {
        self.part.is_some() || self.tile.is_some() || self.sample_range.is_some()
    }

    /// The number of the part, and of how many, if one was asked for by number.
    pub(crate) fn number(&self) -> Option<(u32, u32)> {
        self.part.map(|part| (part.number, part.of))
    }

    /// What is to be made of the whole; with a limit of noise, parts are of whole blocks.
    pub(crate) fn of(&self, whole: &Portion, limited: bool) -> Result<Portion, Failure> {
        let Window { width, height, .. } = whole.window;
        if let Some(Part { number, of }) = self.part {
            let grain = if limited { NOISE_BLOCK } else { 1 };
            return Share::portion(whole, number, of, grain).ok_or_else(|| {
                let mut title = format!("a picture of {height} rows cannot be made in {of} parts");
                if limited {
                    title += &format!(" with a limit of noise, each of {grain} rows or more");
                }
                Failure::new(
                    title,
                    "ask for fewer parts, or divide it by --tile and --sample-range",
                )
            });
        }
        let mut portion = whole.clone();
        if let Some(Tile(window)) = self.tile {
            if !whole.window.contains(&window) {
                let title =
                    format!("the tile {window} is not within the picture of {width}x{height}");
                return Err(Failure::new(title, "count columns and rows from 0 at the upper left"));
            }
            portion.window = window;
        }
        if let Some(SampleRange(samples)) = &self.sample_range {
            if samples.end > whole.samples.end {
                let title = format!("the picture has samples 0..{} only", whole.samples.end);
                return Err(Failure::new(title, "ask for more samples with --spp"));
            }
            portion.samples = samples.clone();
        }
        Ok(portion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read() {
        assert_eq!("2/7".parse(), Ok(Part { number: 2, of: 7 }));
        for bad in ["", "2", "0/7", "8/7", "1/0", "a/b", "1/2/3", "-1/2"] {
            assert!(bad.parse::<Part>().is_err(), "{bad}");
        }
        let window = Window { x: 1, y: 2, width: 3, height: 4 };
        assert_eq!("1, 2,3,4".parse(), Ok(Tile(window)));
        for bad in ["", "1,2,3", "1,2,0,4", "1,2,3,0", "1,2,3,4,5", "1,2,-3,4"] {
            assert!(bad.parse::<Tile>().is_err(), "{bad}");
        }
        assert_eq!("3..9".parse(), Ok(SampleRange(3..9)));
        for bad in ["", "3", "3..", "9..3", "3..3", "3...9", "3..=9"] {
            assert!(bad.parse::<SampleRange>().is_err(), "{bad}");
        }
    }
}

//! Portions of a picture: a rectangle of pixels and a range of the numbers of their samples.
//!
//! A box in three dimensions, so that what several portions leave of another is boxes too: that is how it is told what is missing.

use core::{fmt, ops::Range};

use crate::Window;

/// Some samples of some pixels.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Portion {
    /// The pixels.
    pub window: Window,
    /// The numbers of the samples in each of them.
    pub samples: Range<u32>,
}

impl Portion {
    /// How many samples there are.
    pub fn count(&self) -> f64 {
        self.window.pixels() as f64 * f64::from(self.samples.end.saturating_sub(self.samples.start))
    }

    /// What both have in common, if that is any sample.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let window = self.window.common(&other.window)?;
        let samples =
            self.samples.start.max(other.samples.start)..self.samples.end.min(other.samples.end);
        (!samples.is_empty()).then_some(Self { window, samples })
    }

    /// What is left without `other`, as portions that have nothing in common.
    fn without(&self, other: &Self) -> Vec<Self> {
        let Some(common) = self.common(other) else { return vec![self.clone()] };
        let (all, cut) = (self.window, common.window);
        let (right, bottom) = (cut.x + cut.width, cut.y + cut.height);
        let rest = |x, y, width, height| Self {
            window: Window { x, y, width, height },
            samples: self.samples.clone(),
        };
        let early = Self { window: cut, samples: self.samples.start..common.samples.start };
        let late = Self { window: cut, samples: common.samples.end..self.samples.end };
        let parts = [
            rest(all.x, all.y, all.width, cut.y - all.y),
            rest(all.x, bottom, all.width, all.y + all.height - bottom),
            rest(all.x, cut.y, cut.x - all.x, cut.height),
            rest(right, cut.y, all.x + all.width - right, cut.height),
            early,
            late,
        ];
        parts.into_iter().filter(|p| p.window.pixels() > 0 && !p.samples.is_empty()).collect()
    }

    /// What is left of this portion without all `others`.
    pub fn missing<'a>(&self, others: impl IntoIterator<Item = &'a Self>) -> Vec<Self> {
        others.into_iter().fold(vec![self.clone()], |left, other| {
            left.iter().flat_map(|part| part.without(other)).collect()
        })
    }

    /// Joins neighbours with the same samples, first along rows, then rows. The result is in the order of samples, rows and columns.
    pub fn joined(mut portions: Vec<Self>) -> Vec<Self> {
        let key = |p: &Self| (p.samples.start, p.samples.end);
        portions.sort_by_key(|p| (key(p), p.window.y, p.window.height, p.window.x));
        portions.dedup_by(|next, last| {
            let (a, b) = (last.window, next.window);
            let joins = key(last) == key(next)
                && (a.y, a.height) == (b.y, b.height)
                && a.x.checked_add(a.width) == Some(b.x);
            if joins {
                last.window.width += b.width;
            }
            joins
        });
        portions.sort_by_key(|p| (key(p), p.window.x, p.window.width, p.window.y));
        portions.dedup_by(|next, last| {
            let (a, b) = (last.window, next.window);
            let joins = key(last) == key(next)
                && (a.x, a.width) == (b.x, b.width)
                && a.y.checked_add(a.height) == Some(b.y);
            if joins {
                last.window.height += b.height;
            }
            joins
        });
        portions.sort_by_key(|p| (key(p), p.window.y, p.window.x));
        portions
    }
}

impl fmt::Display for Portion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, samples {}..{}", self.window, self.samples.start, self.samples.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn portion(x: u32, y: u32, width: u32, height: u32, samples: Range<u32>) -> Portion {
        Portion { window: Window { x, y, width, height }, samples }
    }

    #[test]
    fn what_is_missing_fills_the_gap() {
        let whole = portion(0, 0, 10, 8, 0..16);
        let parts =
            [portion(2, 3, 4, 5, 4..9), portion(0, 0, 10, 1, 0..16), portion(9, 0, 5, 9, 15..20)];
        let left = whole.missing(&parts);
        let mut all: Vec<_> = left.iter().collect();
        let inside: Vec<_> = parts.iter().filter_map(|p| whole.common(p)).collect();
        for (i, a) in left.iter().enumerate() {
            assert!(inside.iter().chain(&left[..i]).all(|b| a.common(b).is_none()));
        }
        all.extend(&inside);
        let overlap = inside[1].common(&inside[2]).unwrap().count();
        assert_eq!(all.iter().map(|p| p.count()).sum::<f64>() - overlap, whole.count());
        assert!(whole.missing(left.iter().chain(&parts)).is_empty());
    }

    #[test]
    fn tiles_join_to_few_portions() {
        let tiles = |samples: Range<u32>| {
            Window::whole(100, 70)
                .tiles(32)
                .map(move |window| Portion { window, samples: samples.clone() })
        };
        assert_eq!(Portion::joined(tiles(0..4).collect()), [portion(0, 0, 100, 70, 0..4)]);
        let mixed: Vec<_> = tiles(0..4).take(5).chain(tiles(0..8).skip(5)).collect();
        let joined = Portion::joined(mixed.clone());
        assert!(joined.len() <= 5, "{joined:?}");
        assert_eq!(
            joined.iter().map(Portion::count).sum::<f64>(),
            mixed.iter().map(Portion::count).sum()
        );
        assert!(mixed.iter().all(|p| p.missing(&joined).is_empty()));
    }
}

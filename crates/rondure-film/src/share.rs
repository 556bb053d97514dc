//! Shares of a picture, and how they are put together.

use crate::{Portion, Recipe, Room, Spool, SpoolError, Statistics, Window};

/// A share of a picture: sums, and which samples they are of.
#[derive(Debug)]
#[cfg_attr(test, derive(PartialEq))]
pub struct Share {
    /// What the picture is made from.
    pub recipe: Recipe,
    /// Which of how many parts it was to be, both from 1, if it was made as one of a number.
    pub part: Option<(u32, u32)>,
    /// What has been taken; no sample twice.
    pub covered: Vec<Portion>,
    /// The sums.
    pub sums: Spool,
    /// The work that went into them.
    pub statistics: Statistics,
}

impl Share {
    /// All samples of all pixels of the picture.
    pub fn whole(&self) -> Portion {
        let [width, height] = self.sums.size();
        Portion { window: Window::whole(width, height), samples: 0..self.recipe.spp }
    }

    /// What is missing to the whole picture.
    pub fn missing(&self) -> Vec<Portion> {
        self.whole().missing(&self.covered)
    }

    /// The part with number `part` of `parts` (from 1) of a picture: a band of rows, each but the last of a multiple of `grain` rows (at least 1), all bands
    /// as high as each other to within `grain` rows. `None` if there is no such part: 0, more than `parts`, or more parts than times `grain` rows.
    pub fn portion(whole: &Portion, part: u32, parts: u32, grain: u32) -> Option<Portion> {
        let (window, grain) = (whole.window, grain.max(1));
        let grains = u64::from(window.height.div_ceil(grain));
        if part == 0 || part > parts || u64::from(parts) > grains {
            return None;
        }
        let at = |k: u32| {
            let rows = grains * u64::from(k) / u64::from(parts) * u64::from(grain);
            rows.min(u64::from(window.height)) as u32
        };
        let (top, bottom) = (at(part - 1), at(part));
        let window = Window { y: window.y + top, height: bottom - top, ..window };
        Some(Portion { window, samples: whole.samples.clone() })
    }
}

/// Why shares do not make a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// A share is of another picture.
    #[error("`{name}` does not belong with `{first}`: {difference}")]
    Foreign {
        /// The share.
        name: String,
        /// The share that came first.
        first: String,
        /// In what they differ.
        difference: String,
    },
    /// Two shares have samples in common.
    #[error("`{name}` and `{other}` have {common} in common")]
    Doubled {
        /// The share.
        name: String,
        /// One that came before.
        other: String,
        /// What both have.
        common: Portion,
    },
    /// The shares do not fill the picture.
    #[error("{}", missing_text(parts, portions))]
    Missing {
        /// The numbers of the parts that are missing, and of how many, if the shares were made as parts of a number.
        parts: Option<(Vec<u32>, u32)>,
        /// What is missing.
        portions: Vec<Portion>,
    },
    /// The sums cannot be added.
    #[error("`{name}` cannot be added: {source}")]
    Sums {
        /// The share.
        name: String,
        /// Why not.
        source: SpoolError,
    },
}

fn missing_text(parts: &Option<(Vec<u32>, u32)>, portions: &[Portion]) -> String {
    const SHOWN: usize = 5;
    let list = |items: Vec<String>| {
        let more = items.len().saturating_sub(SHOWN);
        let shown = items.into_iter().take(SHOWN).collect::<Vec<_>>().join("; ");
        if more > 0 { format!("{shown}; and {more} more") } else { shown }
    };
    match parts {
        Some((missing, all)) if !missing.is_empty() => {
            let names = missing.iter().map(|k| format!("part {k}/{all}")).collect();
            format!("missing: {}", list(names))
        }
        _ => format!("missing: {}", list(portions.iter().map(Portion::to_string).collect())),
    }
}

/// Puts shares together, in any order.
#[derive(Debug, Default)]
pub struct Merge {
    sum: Option<Share>,
    added: Vec<Added>,
    room: Room,
}

/// What is known of a share that was added.
#[derive(Debug)]
struct Added {
    name: String,
    part: Option<(u32, u32)>,
    covered: Vec<Portion>,
}

impl Merge {
    /// Nothing yet; the sum has this room.
    pub fn new(room: Room) -> Self {
        Self { room, ..Self::default() }
    }

    /// Adds a share, which goes by a name in errors.
    ///
    /// # Errors
    /// If it is of another picture than those before, or has samples that one of them has; then it is not added. If its sums cannot be
    /// read, or there is no room for the whole, those before are of no more use.
    pub fn add(&mut self, name: &str, share: &Share) -> Result<(), MergeError> {
        let owned = || name.to_owned();
        if let Some(sum) = &self.sum {
            let first = &self.added[0].name;
            let foreign = |difference| MergeError::Foreign {
                name: owned(),
                first: first.clone(),
                difference,
            };
            let size = |share: &Share| share.sums.size();
            if let Some(difference) = sum.recipe.difference(&share.recipe) {
                return Err(foreign(difference));
            }
            if size(sum) != size(share) {
                let [[a, b], [c, d]] = [size(share), size(sum)];
                return Err(foreign(format!("its picture has {a}x{b} pixels, not {c}x{d}")));
            }
            if sum.sums.layers() != share.sums.layers() {
                return Err(foreign("it has other layers".to_owned()));
            }
        }
        for other in &self.added {
            for ours in &share.covered {
                if let Some(common) = other.covered.iter().find_map(|theirs| theirs.common(ours)) {
                    let other = other.name.clone();
                    return Err(MergeError::Doubled { name: owned(), other, common });
                }
            }
        }
        let no_sums = |source| MergeError::Sums { name: owned(), source };
        let sum = match &mut self.sum {
            Some(sum) => sum,
            none => {
                let size = share.sums.size();
                let whole = Window::whole(size[0], size[1]);
                let layers = share.sums.layers();
                let sums = Spool::new(size, whole, layers, &self.room).map_err(no_sums)?;
                none.insert(Share {
                    recipe: share.recipe.clone(),
                    part: None,
                    covered: Vec::new(),
                    sums,
                    statistics: Statistics::default(),
                })
            }
        };
        sum.sums.merge_all(&share.sums).map_err(no_sums)?;
        sum.statistics.add(&share.statistics);
        sum.covered.extend_from_slice(&share.covered);
        let (part, covered) = (share.part, share.covered.clone());
        self.added.push(Added { name: owned(), part, covered });
        Ok(())
    }

    /// All that was added, whether or not it is the whole picture; `None` if it was nothing.
    pub fn so_far(self) -> Option<Share> {
        let mut sum = self.sum?;
        sum.covered = Portion::joined(sum.covered);
        Some(sum)
    }

    /// The whole picture; `None` if nothing was added.
    ///
    /// # Errors
    /// If something is missing.
    pub fn finish(self) -> Result<Option<Share>, MergeError> {
        let parts = self.missing_parts();
        let Some(sum) = self.so_far() else { return Ok(None) };
        let portions = Portion::joined(sum.missing());
        if portions.is_empty() {
            Ok(Some(sum))
        } else {
            Err(MergeError::Missing { parts, portions })
        }
    }

    /// The numbers of the parts that are not there, if all that are there were made as parts of the same number.
    fn missing_parts(&self) -> Option<(Vec<u32>, u32)> {
        let mut there = Vec::new();
        let mut all = None;
        for added in &self.added {
            let (number, of) = added.part?;
            if *all.get_or_insert(of) != of {
                return None;
            }
            there.push(number);
        }
        let all = all?;
        Some(((1..=all).filter(|number| !there.contains(number)).collect(), all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Film, Layers, PixelSample, film::Guide};

    const SIZE: [u32; 2] = [9, 11];

    fn recipe() -> Recipe {
        Recipe { name: "a".to_owned(), scene: [1; 32], spp: 4, settings: Vec::new() }
    }

    fn share(part: u32, parts: u32) -> Share {
        let whole = Portion { window: Window::whole(SIZE[0], SIZE[1]), samples: 0..4 };
        let portion = Share::portion(&whole, part, parts, 1).unwrap();
        of(portion, Some((part, parts)))
    }

    fn of(portion: Portion, part: Option<(u32, u32)>) -> Share {
        let mut film = Film::new(SIZE, portion.window, Layers::default()).unwrap();
        let window = portion.window;
        for y in window.y..window.y + window.height {
            for x in window.x..window.x + window.width {
                for s in portion.samples.clone() {
                    let light = [f64::from(x), 0.1 * f64::from(y), 1e-9 * f64::from(s)];
                    let guide = Guide::default();
                    assert!(film.add(x, y, &PixelSample { light, negative: false, guide }));
                }
            }
        }
        let statistics = Statistics { camera_rays: portion.count() as u64, ..Default::default() };
        Share { recipe: recipe(), part, covered: vec![portion], sums: film.into(), statistics }
    }

    #[test]
    fn parts_divide_all_rows() {
        let whole = Portion { window: Window { x: 2, y: 5, width: 7, height: 11 }, samples: 0..3 };
        for parts in 1..=11 {
            let all: Vec<_> =
                (1..=parts).map(|k| Share::portion(&whole, k, parts, 1).unwrap()).collect();
            assert_eq!(Portion::joined(all.clone()), std::slice::from_ref(&whole));
            let heights = all.iter().map(|p| p.window.height);
            assert!(heights.clone().max().unwrap() - heights.min().unwrap() <= 1);
        }
        let bands = |grain| {
            let bands = (1..=3).map(|k| Share::portion(&whole, k, 3, grain));
            bands
                .map(|band| band.map(|band| (band.window.y, band.window.height)))
                .collect::<Vec<_>>()
        };
        assert_eq!(bands(4), [Some((5, 4)), Some((9, 4)), Some((13, 3))]);
        assert_eq!(bands(5), [Some((5, 5)), Some((10, 5)), Some((15, 1))]);
        assert_eq!(bands(6), [None; 3]);
        for (part, parts) in [(0, 3), (4, 3), (1, 0), (12, 12), (1, 12)] {
            assert_eq!(Share::portion(&whole, part, parts, 1), None);
        }
    }

    #[test]
    fn any_order_makes_the_same_share() {
        let whole = of(share(1, 1).covered[0].clone(), None);
        let mut shares: Vec<_> = (1..=7).map(|k| share(k, 7)).collect();
        for turn in 0..7 {
            shares.rotate_left(turn);
            // In memory and in scratch files.
            let memory = if turn % 2 == 0 { u64::MAX } else { 0 };
            let mut merge = Merge::new(Room { memory, ..Room::default() });
            shares.iter().for_each(|s| merge.add("x", s).unwrap());
            assert_eq!(merge.finish().unwrap().unwrap(), whole);
        }
    }

    #[test]
    fn what_does_not_fit_is_told_by_name() {
        let mut merge = Merge::default();
        merge.add("one", &share(1, 3)).unwrap();
        let told =
            |merge: &mut Merge, share: &Share| merge.add("two", share).unwrap_err().to_string();
        let other = Recipe { scene: [2; 32], ..recipe() };
        let foreign = told(&mut merge, &Share { recipe: other, ..share(2, 3) });
        assert!(
            foreign.starts_with("`two` does not belong with `one`: it is of another scene"),
            "{foreign}"
        );
        let small = Film::new([9, 10], Window::whole(9, 1), Layers::default()).unwrap();
        let sizes = told(&mut merge, &Share { sums: small.into(), ..share(2, 3) });
        assert!(sizes.contains("9x10 pixels, not 9x11"), "{sizes}");
        let layered = Film::new(SIZE, Window::whole(9, 1), Layers::ALL).unwrap();
        assert!(
            told(&mut merge, &Share { sums: layered.into(), ..share(2, 3) }).contains("layers")
        );
        let doubled = told(&mut merge, &share(1, 3));
        assert_eq!(doubled, "`two` and `one` have 9x3 at 0,0, samples 0..4 in common");
        let window = Window { x: 4, y: 2, width: 3, height: 4 };
        let overlap = told(&mut merge, &of(Portion { window, samples: 3..4 }, None));
        assert_eq!(overlap, "`two` and `one` have 3x1 at 4,2, samples 3..4 in common");
        merge.add("three", &share(3, 3)).unwrap();
        let missing = merge.finish().unwrap_err().to_string();
        assert_eq!(missing, "missing: part 2/3");
        let mut merge = Merge::default();
        let window = Window { x: 0, y: 0, width: 9, height: 10 };
        merge.add("most", &of(Portion { window, samples: 0..4 }, None)).unwrap();
        let missing = merge.finish().unwrap_err().to_string();
        assert_eq!(missing, "missing: 9x1 at 0,10, samples 0..4");
        assert!(Merge::default().finish().unwrap().is_none());
    }
}

//! Which leaves share a block: such that the boxes round the blocks are small together.
//!
//! ```text
//! leaves along the profile -> cut into rows of eight -> leaves change places
//! ```
//!
//! Rows are cut by dynamic programming, and are the best there is where a profile runs up and down once. The two walls of a vessel lie side by
//! side: there blocks of leaves from both, lower ones and higher ones, overlap less than blocks that are each all of one wall, and a ray
//! looks into fewer of them.

use arrayvec::ArrayVec;

use super::block::LANES;
use super::boxes::Extent;

/// What one more block costs, as a part of the weight of all.
const BLOCK: f64 = 1.0 / 64.0;
/// As many times all leaves may look for a better place; most stay after two.
const PASSES: usize = 8;
/// What part of the weight of all a change must save at the least.
const LEAST: f64 = 1e-6;

/// The leaves of a block, and the box round them.
struct Group {
    leaves: ArrayVec<usize, LANES>,
    around: Extent,
    weight: f64,
    /// The most that the weight can shrink when one leaf goes.
    most: f64,
}

impl Group {
    fn new(leaves: ArrayVec<usize, LANES>, extents: &[Extent]) -> Self {
        let around = around(leaves.iter().map(|&leaf| &extents[leaf]));
        let weight = weight(&around);
        let mut group = Self { leaves, around, weight, most: 0.0 };
        let gains = group.leaves.iter().map(|&leaf| group.gain(leaf, extents));
        group.most = gains.fold(0.0, f64::max);
        group
    }

    /// The box round all leaves but one.
    fn without(&self, leaf: usize, extents: &[Extent]) -> Extent {
        around(self.leaves.iter().filter(|&&own| own != leaf).map(|&own| &extents[own]))
    }

    /// By how much the weight shrinks when a leaf goes.
    fn gain(&self, leaf: usize, extents: &[Extent]) -> f64 {
        if self.leaves.len() == 1 {
            self.weight
        } else {
            self.weight - weight(&self.without(leaf, extents))
        }
    }

    /// The same leaves but for one that goes, and one that comes.
    fn changed(&self, goes: Option<usize>, comes: Option<usize>, extents: &[Extent]) -> Self {
        let stay = self.leaves.iter().copied().filter(|&leaf| Some(leaf) != goes);
        Self::new(stay.chain(comes).collect(), extents)
    }
}

/// The leaves of each block, by their numbers, in the order of the first of them.
pub(super) fn groups(extents: &[Extent]) -> Vec<ArrayVec<usize, LANES>> {
    let whole = weight(&around(extents));
    let block = BLOCK * whole;
    let mut start = 0;
    let rows = cuts(extents, block).into_iter().map(|end| {
        let row = (start..end).collect();
        start = end;
        Group::new(row, extents)
    });
    let mut groups: Vec<Group> = rows.collect();
    for _ in 0..PASSES {
        if !improve(&mut groups, extents, block, LEAST * whole) {
            break;
        }
    }
    let mut groups: Vec<_> = groups.into_iter().map(|group| group.leaves).collect();
    groups.iter_mut().for_each(|leaves| leaves.sort_unstable());
    groups.sort_unstable();
    groups
}

/// Lets each leaf go to another group, or change places with a leaf there, where that saves most; false if none did.
fn improve(groups: &mut Vec<Group>, extents: &[Extent], block: f64, least: f64) -> bool {
    let mut changed = false;
    for from in 0..groups.len() {
        for leaf in groups[from].leaves.clone() {
            if let Some((to, back)) = better(groups, from, leaf, extents, block, least) {
                groups[from] = groups[from].changed(Some(leaf), back, extents);
                groups[to] = groups[to].changed(back, Some(leaf), extents);
                changed = true;
            }
        }
    }
    groups.retain(|group| !group.leaves.is_empty());
    changed
}

/// The group that a leaf had better be in, and the leaf that had better come in its place, if any.
fn better(
    groups: &[Group],
    from: usize,
    leaf: usize,
    extents: &[Extent],
    block: f64,
    least: f64,
) -> Option<(usize, Option<usize>)> {
    let (own, extent) = (&groups[from], &extents[leaf]);
    let gain = own.gain(leaf, extents) + if own.leaves.len() == 1 { block } else { 0.0 };
    let mut best = (least, None);
    for (to, group) in groups.iter().enumerate() {
        let loss = weight(&group.around.union(extent)) - group.weight;
        if to == from || group.leaves.is_empty() || gain + group.most - loss <= best.0 {
            continue;
        }
        if group.leaves.len() < LANES {
            if gain - loss > best.0 {
                best = (gain - loss, Some((to, None)));
            }
            continue;
        }
        let rest = own.without(leaf, extents);
        for &back in &group.leaves {
            let there = weight(&group.without(back, extents).union(extent));
            let here = weight(&rest.union(&extents[back]));
            let saved = group.weight + own.weight - there - here;
            if saved > best.0 {
                best = (saved, Some((to, Some(back))));
            }
        }
    }
    best.1
}

/// About the share of lines that meet a box: its area, less that of the hole.
fn weight(extent: &Extent) -> f64 {
    let [r0, r1] = extent.w.map(|w| w.max(0.0).sqrt());
    let height = extent.z[1] - extent.z[0];
    (r1 + 0.25 * (r1 - r0)) * height + (r1 * r1 - r0 * r0)
}

fn around<'a>(extents: impl IntoIterator<Item = &'a Extent>) -> Extent {
    extents.into_iter().fold(Extent::NONE, |all, own| all.union(own))
}

/// Cuts a row of leaves into blocks of eight at the most, each of which costs its own weight and `block`. Returns where each ends.
fn cuts(extents: &[Extent], block: f64) -> Vec<usize> {
    // The least cost of the first leaves, and where their last block begins.
    let mut best = vec![(0.0, 0); extents.len() + 1];
    for end in 1..=extents.len() {
        let mut around = Extent::NONE;
        best[end].0 = f64::INFINITY;
        for start in (end.saturating_sub(LANES)..end).rev() {
            around = around.union(&extents[start]);
            let cost = best[start].0 + block + weight(&around);
            if cost < best[end].0 || start + 1 == end {
                best[end] = (cost, start);
            }
        }
    }
    let mut ends = Vec::new();
    let mut end = extents.len();
    while end > 0 {
        ends.push(end);
        end = best[end].1;
    }
    ends.reverse();
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost<'a>(groups: impl IntoIterator<Item = &'a [usize]>, extents: &[Extent]) -> f64 {
        let block = BLOCK * weight(&around(extents));
        groups.into_iter().map(|g| block + weight(&around(g.iter().map(|&i| &extents[i])))).sum()
    }

    /// Two walls of a vessel, up on the outside and down on the inside.
    fn walls(count: usize, thick: f64) -> Vec<Extent> {
        let height = |i: usize| [i as f64, (i + 1) as f64];
        let lean =
            |i: usize, r: f64| [(r + 0.1 * i as f64).powi(2), (r + 0.1 * (i + 1) as f64).powi(2)];
        let outer = (0..count).map(|i| Extent { z: height(i), w: lean(i, 5.0) });
        let inner = (0..count).rev().map(|i| Extent { z: height(i), w: lean(i, 5.0 - thick) });
        outer.chain(inner).collect()
    }

    #[test]
    fn every_leaf_is_in_one_group() {
        for count in [1, 5, 8, 30, 100] {
            let extents = walls(count, 0.2);
            let groups = groups(&extents);
            let mut leaves: Vec<_> = groups.iter().flatten().copied().collect();
            leaves.sort_unstable();
            assert!(leaves.into_iter().eq(0..2 * count));
            assert!(groups.iter().all(|leaves| !leaves.is_empty() && leaves.is_sorted()));
        }
    }

    #[test]
    fn the_walls_of_a_vessel_share_blocks() {
        let extents = walls(40, 0.2);
        let block = BLOCK * weight(&around(&extents));
        let all: Vec<usize> = (0..extents.len()).collect();
        let mut start = 0;
        let rows = cuts(&extents, block)
            .into_iter()
            .map(|end| &all[core::mem::replace(&mut start, end)..end]);
        let rows = cost(rows, &extents);
        let groups = groups(&extents);
        let found = cost(groups.iter().map(|g| &**g), &extents);
        assert!(found < 0.8 * rows, "{found} {rows}");
        let both = groups.iter().filter(|g| g[0] < 40 && g[g.len() - 1] >= 40).count();
        assert!(both > groups.len() / 2, "{both} {groups:?}");
    }
}

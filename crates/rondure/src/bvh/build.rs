//! The tree is built from the root down: the binned surface area heuristic (Wald 2007, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies") parts the items in two, again and again
//! the part with the largest box, until a node is full (Wald, Benthin, Boulos 2008, "Getting Rid of
//! Packets"). Every item has a place of its own in a node: turned shapes are dear, boxes are cheap.
//!
//! The same items give the same tree on any number of threads: how the work is dealt out depends on
//! nothing but the number of items, and bins hold counts and extrema, which no order changes.

use arrayvec::ArrayVec;

use super::node::{ITEM, Node, WIDTH};
use super::space::Slabs;

/// The depth up to which the heuristic decides. Below it the part with the most items is halved.
const HEURISTIC_DEPTH: usize = 24;
/// More nodes than that are on no path from the root: eight parts out of halves divide by eight, and
/// fewer than 2^31 items are 8 after ten divisions.
pub(super) const DEEPEST: usize = HEURISTIC_DEPTH + 12;

/// The most items: the bits of their numbers are those of finite f32.
pub(super) const MOST_ITEMS: usize = 0x7f80_0000;

const MOST_BINS: usize = 32;

/// Parts of at least so many items are worth the trouble of another thread.
const LARGE: usize = 1 << 13;

/// An item: its box, and in the fourth lane of its lower corner the bits of its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item(Slabs);

impl Item {
    pub(super) fn new(index: u32, slabs: Slabs) -> Self {
        let [x, y, z, _] = slabs.min;
        Self(Slabs { min: [x, y, z, f32::from_bits(index)], ..slabs })
    }

    fn index(&self) -> u32 {
        self.0.min[3].to_bits()
    }

    /// How wide its box is along the longest axis.
    pub(super) fn width(&self) -> f32 {
        self.0.width()
    }

    /// Twice the middle of the box.
    #[inline(always)]
    fn middle(&self) -> [f32; 4] {
        core::array::from_fn(|i| if i < 3 { self.0.min[i] + self.0.max[i] } else { 0.0 })
    }
}

/// Some of the items, the box round them, and the box round their middles.
struct Part<'a> {
    items: &'a mut [Item],
    slabs: Slabs,
    middles: Slabs,
}

fn boxes(items: &[Item]) -> [Slabs; 2] {
    let all = |items: &[Item]| {
        items.iter().fold([Slabs::EMPTY; 2], |[slabs, middles], item| {
            let middle = item.middle();
            [slabs.union(&item.0), middles.union(&Slabs { min: middle, max: middle })]
        })
    };
    chunked(items, all, |a, b| [a[0].union(&b[0]), a[1].union(&b[1])])
}

/// `all` of the items, put together from chunks where there are many.
fn chunked<T: Send>(
    items: &[Item],
    all: impl Fn(&[Item]) -> T + Sync,
    join: impl Fn(T, T) -> T + Sync + Send,
) -> T {
    #[cfg(feature = "parallel")]
    if items.len() >= 4 * LARGE {
        use rayon::prelude::*;
        let parts = items.par_chunks(LARGE).map(&all).reduce_with(&join);
        if let Some(whole) = parts {
            return whole;
        }
    }
    let _ = join;
    all(items)
}

impl<'a> Part<'a> {
    fn new(items: &'a mut [Item]) -> Self {
        let [slabs, middles] = boxes(items);
        Self { items, slabs, middles }
    }

    /// The two parts into which the heuristic cuts this one of at least two items.
    fn split(self, depth: usize) -> [Self; 2] {
        let middle = match best_cut(&self) {
            Some(cut) if depth < HEURISTIC_DEPTH => partition(self.items, |item| cut.is_left(item)),
            _ => {
                let extent = |i: usize| self.middles.max[i] - self.middles.min[i];
                let widest = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
                let middle = self.items.len() / 2;
                self.items.select_nth_unstable_by(middle, |a, b| {
                    let [a_middle, b_middle] = [a, b].map(|item| item.middle()[widest]);
                    a_middle.total_cmp(&b_middle).then(a.index().cmp(&b.index()))
                });
                middle
            }
        };
        let (left, right) = self.items.split_at_mut(middle);
        [Self::new(left), Self::new(right)]
    }
}

/// Between which bins of which axis to cut.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    border: usize,
    bins: Bins,
}

impl Cut {
    fn is_left(&self, item: &Item) -> bool {
        self.bins.of(item)[self.axis] < self.border
    }
}

/// Which bin a middle falls into, on each axis.
#[derive(Clone, Copy)]
struct Bins {
    low: [f32; 4],
    factor: [f32; 4],
    count: usize,
}

impl Bins {
    fn new(part: &Part<'_>) -> Self {
        let count = (4 + part.items.len() / 8).min(MOST_BINS);
        let low = part.middles.min;
        let factor = core::array::from_fn(|i| {
            let extent = part.middles.max[i] - low[i];
            // All in one bin: then there is no cut on this axis.
            let factor = count as f32 / extent;
            if i < 3 && extent > 0.0 && factor < f32::INFINITY { factor } else { 0.0 }
        });
        Self { low, factor, count }
    }

    #[inline(always)]
    fn of(&self, item: &Item) -> [usize; 3] {
        let middle = item.middle();
        core::array::from_fn(|i| {
            let bin = ((middle[i] - self.low[i]) * self.factor[i]) as i32 as usize;
            bin.min(self.count - 1)
        })
    }
}

#[derive(Clone, Copy)]
struct Bin {
    slabs: Slabs,
    count: usize,
}

type Table = [[Bin; MOST_BINS]; 3];

/// The cut with the least expected cost; `None` if no cut has items on both sides.
fn best_cut(part: &Part<'_>) -> Option<Cut> {
    let bins = Bins::new(part);
    let empty = Bin { slabs: Slabs::EMPTY, count: 0 };
    let fill = |items: &[Item]| {
        let mut table: Table = [[empty; MOST_BINS]; 3];
        for item in items {
            let places = bins.of(item);
            for axis in 0..3 {
                let bin = &mut table[axis][places[axis] % MOST_BINS];
                *bin = Bin { slabs: bin.slabs.union(&item.0), count: bin.count + 1 };
            }
        }
        table
    };
    let table = chunked(part.items, fill, |mut a: Table, b| {
        for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
            *a = Bin { slabs: a.slabs.union(&b.slabs), count: a.count + b.count };
        }
        a
    });
    let mut best: Option<(f32, Cut)> = None;
    for (axis, row) in table.iter().enumerate() {
        if bins.factor[axis] == 0.0 {
            continue;
        }
        let row = &row[..bins.count];
        // From the right, the cost of all that lies beyond each border; then from the left.
        let mut beyond = [(0.0_f32, 0); MOST_BINS];
        let mut right = empty;
        for i in (1..row.len()).rev() {
            right =
                Bin { slabs: right.slabs.union(&row[i].slabs), count: right.count + row[i].count };
            beyond[i] = (right.slabs.half_area() * right.count as f32, right.count);
        }
        let mut left = empty;
        for border in 1..row.len() {
            let bin = &row[border - 1];
            left = Bin { slabs: left.slabs.union(&bin.slabs), count: left.count + bin.count };
            if left.count == 0 || beyond[border].1 == 0 {
                continue;
            }
            let cost = left.slabs.half_area() * left.count as f32 + beyond[border].0;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, Cut { axis, border, bins }));
            }
        }
    }
    best.map(|(_, cut)| cut)
}

/// Moves the items for which `first` holds to the front and counts them.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(i, count);
            count += 1;
        }
    }
    count
}

/// The parts of a node that holds this one.
///
/// A part that fits into one node is not split for its own sake: that makes small nodes, and visiting
/// one costs as much as visiting a full one. But its items may take what places are left.
fn children(part: Part<'_>, depth: usize) -> ArrayVec<Part<'_>, WIDTH> {
    let mut parts = ArrayVec::new();
    parts.push(part);
    loop {
        let free = WIDTH - parts.len();
        let area = |part: &Part<'_>| part.slabs.half_area();
        let count = |part: &Part<'_>| part.items.len();
        let order = |a: &Part<'_>, b: &Part<'_>| {
            if depth < HEURISTIC_DEPTH {
                area(a).total_cmp(&area(b))
            } else {
                count(a).cmp(&count(b))
            }
        };
        let best = |fits: &dyn Fn(&Part<'_>) -> bool| {
            let numbered = parts.iter().enumerate().filter(|(_, part)| fits(part));
            numbered.max_by(|(_, a), (_, b)| order(a, b)).map(|(i, _)| i)
        };
        if let Some(i) = best(&|part| count(part) > WIDTH).filter(|_| free > 0) {
            let halves = parts.swap_remove(i).split(depth);
            parts.extend(halves);
        } else if let Some(i) = best(&|part| count(part) > 1 && count(part) <= free + 1) {
            let items = parts.swap_remove(i).items.chunks_mut(1);
            parts.extend(items.map(Part::new));
        } else {
            return parts;
        }
    }
}

/// `of` each of the parts, in their order.
fn each<'a, T: Send>(
    parts: ArrayVec<Part<'a>, WIDTH>,
    of: impl Fn(Part<'a>) -> T + Sync + Send,
) -> Vec<T> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let parts: Vec<_> = parts.into_iter().collect();
        parts.into_par_iter().with_max_len(1).map(of).collect()
    }
    #[cfg(not(feature = "parallel"))]
    parts.into_iter().map(of).collect()
}

/// The nodes of the tree over the items, the root first; none if there are no items.
pub(super) fn build(items: &mut [Item]) -> Vec<Node> {
    let mut nodes = Vec::new();
    if !items.is_empty() {
        subtree(Part::new(items), 0, &mut nodes);
    }
    nodes
}

/// Adds the tree over a part, with its children's numbers counted from the first node of `nodes`.
fn subtree(part: Part<'_>, depth: usize, nodes: &mut Vec<Node>) {
    let count = part.items.len();
    let own = nodes.len();
    nodes.push(Node::FREE);
    let parts = children(part, depth);
    if count >= LARGE {
        let mut trees = each(parts, |part| {
            let (slabs, first) = (part.slabs, part.items.first().map_or(0, Item::index));
            let mut nodes = Vec::new();
            if part.items.len() > 1 {
                subtree(part, depth + 1, &mut nodes);
            }
            (slabs, first, nodes)
        });
        nodes.reserve_exact(trees.iter().map(|(.., tree)| tree.len()).sum());
        for (place, (slabs, first, tree)) in trees.iter_mut().enumerate() {
            let child = if tree.is_empty() { *first | ITEM } else { nodes.len() as u32 };
            nodes[own].set(place, slabs, child);
            let by = nodes.len() as u32;
            nodes.extend(core::mem::take(tree).into_iter().map(|mut node| {
                node.renumber(by);
                node
            }));
        }
        return;
    }
    for (place, part) in parts.into_iter().enumerate() {
        let slabs = part.slabs;
        let child = match &*part.items {
            [item] => item.index() | ITEM,
            _ => nodes.len() as u32,
        };
        nodes[own].set(place, &slabs, child);
        if part.items.len() > 1 {
            subtree(part, depth + 1, nodes);
        }
    }
}

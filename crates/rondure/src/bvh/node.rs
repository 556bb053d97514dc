//! A node: the boxes of up to [`WIDTH`] children side by side, which one ray meets all at once.

use fearless_simd::{SimdBase, SimdFloat, SimdFrom, SimdMask};

use super::space::{LocalRay, Slabs};

/// The number of children.
pub(super) const WIDTH: usize = 8;
/// As many numbers as a node has children.
type Lanes<S> = fearless_simd::f32x8<S>;

/// In the number of a child: it is an item, not a node.
pub(super) const ITEM: u32 = 1 << 31;

/// The children's boxes and numbers. Free places have boxes that no ray meets.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// The smallest and the largest x, then y, then z.
    planes: [[f32; WIDTH]; 6],
    children: [u32; WIDTH],
}

impl Node {
    pub(super) const FREE: Self = Self {
        planes: {
            let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
            [low, high, low, high, low, high]
        },
        children: [0; WIDTH],
    };

    pub(super) fn set(&mut self, place: usize, slabs: &Slabs, child: u32) {
        for axis in 0..3 {
            self.planes[2 * axis][place] = slabs.min[axis];
            self.planes[2 * axis + 1][place] = slabs.max[axis];
        }
        self.children[place] = child;
    }

    #[inline(always)]
    pub(super) fn child(&self, place: usize) -> u32 {
        self.children[place]
    }

    /// Adds `by` to the numbers of the children that are nodes.
    pub(super) fn renumber(&mut self, by: u32) {
        for (child, low) in self.children.iter_mut().zip(self.planes[0]) {
            if *child & ITEM == 0 && low < f32::INFINITY {
                *child += by;
            }
        }
    }
}

/// A ray made ready for the nodes.
pub(super) struct Probe<S: fearless_simd::Simd> {
    reciprocal: [Lanes<S>; 3],
    /// o / d for the planes that the ray meets first, and for the others.
    shifted: [[Lanes<S>; 3]; 2],
    /// Which of a node's planes the ray meets first on each axis.
    first: [usize; 3],
    begin: Lanes<S>,
}

impl<S: fearless_simd::Simd> Probe<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &LocalRay) -> Self {
        let shifted = splat3(simd, ray.shifted);
        Self::with(simd, ray, [shifted, shifted])
    }

    /// The same for boxes that are larger by `pad` on both sides of each axis.
    #[inline(always)]
    pub(super) fn padded(simd: S, ray: &LocalRay, pad: [f32; 3]) -> Self {
        let (s, r) = (ray.shifted, ray.reciprocal);
        let by = [pad[0] * r[0].abs(), pad[1] * r[1].abs(), pad[2] * r[2].abs()];
        let early = splat3(simd, [s[0] + by[0], s[1] + by[1], s[2] + by[2]]);
        let late = splat3(simd, [s[0] - by[0], s[1] - by[1], s[2] - by[2]]);
        Self::with(simd, ray, [early, late])
    }

    #[inline(always)]
    fn with(simd: S, ray: &LocalRay, shifted: [[Lanes<S>; 3]; 2]) -> Self {
        let [a, b, c] = ray.falling;
        let first = [usize::from(a), 2 + usize::from(b), 4 + usize::from(c)];
        let begin = Lanes::splat(simd, ray.begin);
        Self { reciprocal: splat3(simd, ray.reciprocal), shifted, first, begin }
    }

    /// Which boxes the ray meets up to the parameter `end`, as a mask, and where it enters them.
    #[inline(always)]
    pub(super) fn meet(&self, simd: S, node: &Node, end: f32) -> (u32, [f32; WIDTH]) {
        let plane = |side: usize, axis: usize, index: usize| {
            let plane = Lanes::simd_from(simd, node.planes[index]);
            plane.mul_sub(self.reciprocal[axis], self.shifted[side][axis])
        };
        let [x, y, z] = self.first;
        let (least, most) = (self.begin, Lanes::splat(simd, end));
        let enter = plane(0, 0, x).max(plane(0, 1, y)).max(plane(0, 2, z).max(least));
        let leave = plane(1, 0, x ^ 1).min(plane(1, 1, y ^ 1)).min(plane(1, 2, z ^ 1).min(most));
        (enter.simd_le(leave).to_bitmask() as u32, enter.into())
    }
}

// Not by `map`, which is not always inlined.
#[inline(always)]
fn splat3<S: fearless_simd::Simd>(simd: S, v: [f32; 3]) -> [Lanes<S>; 3] {
    [Lanes::splat(simd, v[0]), Lanes::splat(simd, v[1]), Lanes::splat(simd, v[2])]
}

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
    shifted: [Lanes<S>; 3],
    /// Which of a node's planes the ray meets first on each axis.
    first: [usize; 3],
}

impl<S: fearless_simd::Simd> Probe<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &LocalRay) -> Self {
        let splat = |x: f32| Lanes::splat(simd, x);
        let (r, s) = (ray.reciprocal, ray.shifted);
        let [a, b, c] = ray.falling;
        Self {
            // Not by `map`, which is not always inlined.
            reciprocal: [splat(r[0]), splat(r[1]), splat(r[2])],
            shifted: [splat(s[0]), splat(s[1]), splat(s[2])],
            first: [usize::from(a), 2 + usize::from(b), 4 + usize::from(c)],
        }
    }

    /// Which boxes the ray meets up to the parameter `end`, as a mask, and where it enters them.
    #[inline(always)]
    pub(super) fn meet(&self, simd: S, node: &Node, end: f32) -> (u32, [f32; WIDTH]) {
        let plane = |axis: usize, index: usize| {
            let plane = Lanes::simd_from(simd, node.planes[index]);
            plane.mul_sub(self.reciprocal[axis], self.shifted[axis])
        };
        let [x, y, z] = self.first;
        let enter = plane(0, x).max(plane(1, y)).max(plane(2, z).max(Lanes::splat(simd, 0.0)));
        let leave =
            plane(0, x ^ 1).min(plane(1, y ^ 1)).min(plane(2, z ^ 1).min(Lanes::splat(simd, end)));
        (enter.simd_le(leave).to_bitmask() as u32, enter.into())
    }
}

//! A ray's way through the tree.

use arrayvec::ArrayVec;
use fearless_simd::Simd;

use super::build::DEEPEST;
use super::node::{ITEM, Node, Probe, WIDTH};

/// Every level of the tree leaves at most all children but one behind.
const STACK: usize = DEEPEST * (WIDTH - 1) + 1;

/// What waits: where the ray enters it in the upper half, its number in the lower. Parameters are
/// not negative, so their bits are in order as they are.
type Waiting = u64;

#[inline(always)]
fn waiting(enter: f32, child: u32) -> Waiting {
    u64::from(enter.to_bits()) << 32 | u64::from(child)
}

/// Visits the items whose boxes the ray meets before `end`, by and large in the order in which it enters them.
/// `visit` returns the ray's new end if it has become shorter; a negative one stops.
#[inline(always)]
pub(super) fn walk<S: Simd>(
    simd: S,
    nodes: &[Node],
    probe: &Probe<S>,
    mut end: f32,
    mut visit: impl FnMut(u32) -> Option<f32>,
) {
    let mut stack = ArrayVec::<Waiting, STACK>::new();
    let mut current = 0_u32;
    loop {
        if current & ITEM == 0 {
            let Some(node) = nodes.get(current as usize) else { return };
            let (mut mask, enter) = probe.meet(simd, node, end);
            if mask != 0 {
                let first = mask.trailing_zeros() as usize % WIDTH;
                mask &= mask - 1;
                if mask == 0 {
                    current = node.child(first);
                    continue;
                }
                let base = stack.len();
                stack.push(waiting(enter[first], node.child(first)));
                while mask != 0 {
                    let place = mask.trailing_zeros() as usize % WIDTH;
                    mask &= mask - 1;
                    let entry = waiting(enter[place], node.child(place));
                    // From far to near.
                    let mut i = stack.len();
                    stack.push(entry);
                    while i > base && stack[i - 1] < entry {
                        stack[i] = stack[i - 1];
                        i -= 1;
                    }
                    stack[i] = entry;
                }
            }
        } else if let Some(nearer) = visit(current ^ ITEM) {
            end = nearer;
        }
        loop {
            let Some(next) = stack.pop() else { return };
            if f32::from_bits((next >> 32) as u32) <= end {
                current = next as u32;
                break;
            }
        }
    }
}

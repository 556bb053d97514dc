//! A binary tree of shells, and its search.
//!
//! Nodes lie in one array in depth-first order: the first child of a node is the next node.

use arrayvec::ArrayVec;

use super::counters::Count;
use crate::meridian::Meridian;
use crate::shell::Shell;

/// The tree over the pieces of a profile.
#[derive(Clone, Debug)]
pub(crate) struct Tree<S> {
    pub(crate) nodes: Vec<Node<S>>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<S> {
    pub(crate) shell: S,
    pub(crate) link: Link,
}

/// What hangs below a node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Link {
    /// The second child; the first is the next node.
    Children {
        second: u32,
    },
    Leaf(Leaf),
}

/// The pieces of a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leaf {
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) order: Order,
}

/// By which coordinate the pieces of a leaf are in order: the one along which they are longer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Order {
    ZRising,
    ZFalling,
    RRising,
    RFalling,
}

/// Deep enough for a tree over 2^32 intervals of 2^32 pieces.
pub(crate) const DEEPEST: usize = 64;

impl<S: Shell> Tree<S> {
    /// Adds a node whose first child is the next one to be added.
    pub(crate) fn begin(&mut self, shell: S) -> usize {
        self.nodes.push(Node { shell, link: Link::Children { second: 0 } });
        self.nodes.len() - 1
    }

    /// The next node to be added is the second child of this one.
    pub(crate) fn begin_second(&mut self, node: usize) {
        self.nodes[node].link = Link::Children { second: self.nodes.len() as u32 };
    }

    pub(crate) fn leaf(&mut self, shell: S, leaf: Leaf) {
        self.nodes.push(Node { shell, link: Link::Leaf(leaf) });
    }

    /// Visits the leaves whose shells the ray meets between the parameters `range`, near ones first.
    ///
    /// `visit` is given the leaf, its shell and the stretch of the ray within, and returns up to
    /// which parameter the search goes on.
    #[inline]
    pub(crate) fn walk<C: Count>(
        &self,
        ray: &Meridian,
        range: [f64; 2],
        count: &mut C,
        mut visit: impl FnMut(&Leaf, &S, [f64; 2], &mut C) -> f64,
    ) {
        let [_, mut end] = range;
        let mut waiting = ArrayVec::<(u32, [f64; 2]), DEEPEST>::new();
        count.test();
        let Some(mut stretch) = self.nodes[0].shell.meet(ray, range) else { return };
        count.positive();
        let mut node = 0_u32;
        loop {
            count.enter();
            match &self.nodes[node as usize].link {
                Link::Leaf(leaf) => {
                    let shell = &self.nodes[node as usize].shell;
                    end = end.min(visit(leaf, shell, [stretch[0], stretch[1].min(end)], count));
                }
                Link::Children { second } => {
                    let (first, second) = (node + 1, *second);
                    let mut meet = |n: u32| {
                        let range = [stretch[0], stretch[1].min(end)];
                        count.test();
                        let met = self.nodes[n as usize].shell.meet(ray, range);
                        if met.is_some() {
                            count.positive();
                        }
                        met
                    };
                    match (meet(first), meet(second)) {
                        (Some(a), Some(b)) => {
                            let (near, far) = if b[0] < a[0] {
                                ((second, b), (first, a))
                            } else {
                                ((first, a), (second, b))
                            };
                            waiting.push(far);
                            (node, stretch) = near;
                            continue;
                        }
                        (Some(a), None) => {
                            (node, stretch) = (first, a);
                            continue;
                        }
                        (None, Some(b)) => {
                            (node, stretch) = (second, b);
                            continue;
                        }
                        (None, None) => {}
                    }
                }
            }
            loop {
                let Some(next) = waiting.pop() else { return };
                (node, stretch) = next;
                if stretch[0] <= end {
                    break;
                }
            }
        }
    }
}

//! Counting the work of a search: a generic parameter, which costs nothing where it is `()`.

use std::sync::atomic::{AtomicU64, Ordering};

/// Who is told of each step of a search.
pub(crate) trait Count {
    /// A ray is tested against a shell.
    fn test(&mut self);
    /// It meets the shell.
    fn positive(&mut self);
    /// A node is entered.
    fn enter(&mut self);
    /// The ray is tested against a piece itself.
    fn solve(&mut self);
}

impl Count for () {
    #[inline]
    fn test(&mut self) {}
    #[inline]
    fn positive(&mut self) {}
    #[inline]
    fn enter(&mut self) {}
    #[inline]
    fn solve(&mut self) {}
}

/// How much work an engine did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// The rays that came near enough to the surface for a search.
    pub rays: u64,
    /// The nodes that the searches entered: their shells were met, before any nearer hit.
    pub nodes_visited: u64,
    /// The nodes of the tree, once for each ray.
    pub nodes_there: u64,
    /// Rays tested against shells.
    pub shell_tests: u64,
    /// Those that met the shell.
    pub positive_tests: u64,
    /// Rays tested against pieces of the surface itself.
    pub leaf_solves: u64,
}

impl Statistics {
    /// The names of the numbers, in the order of [`numbers`](Self::numbers).
    pub const NAMES: [&str; 6] =
        ["rays", "nodes_visited", "nodes_there", "shell_tests", "positive_tests", "leaf_solves"];

    /// All numbers.
    pub fn numbers(&self) -> [u64; 6] {
        let Self { rays, nodes_visited, nodes_there, shell_tests, positive_tests, leaf_solves } =
            *self;
        [rays, nodes_visited, nodes_there, shell_tests, positive_tests, leaf_solves]
    }

    /// The work of two engines together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            nodes_visited: self.nodes_visited + other.nodes_visited,
            nodes_there: self.nodes_there + other.nodes_there,
            shell_tests: self.shell_tests + other.shell_tests,
            positive_tests: self.positive_tests + other.positive_tests,
            leaf_solves: self.leaf_solves + other.leaf_solves,
        }
    }
}

impl Count for Statistics {
    #[inline]
    fn test(&mut self) {
        self.shell_tests += 1;
    }
    #[inline]
    fn positive(&mut self) {
        self.positive_tests += 1;
    }
    #[inline]
    fn enter(&mut self) {
        self.nodes_visited += 1;
    }
    #[inline]
    fn solve(&mut self) {
        self.leaf_solves += 1;
    }
}

/// The sums over all threads.
#[derive(Debug, Default)]
pub(crate) struct Counters([AtomicU64; 6]);

impl Counters {
    pub(crate) fn add(&self, work: &Statistics) {
        for (sum, number) in self.0.iter().zip(work.numbers()) {
            sum.fetch_add(number, Ordering::Relaxed);
        }
    }

    pub(crate) fn read(&self) -> Statistics {
        let [rays, nodes_visited, nodes_there, shell_tests, positive_tests, leaf_solves] =
            [0, 1, 2, 3, 4, 5].map(|i: usize| self.0[i].load(Ordering::Relaxed));
        Statistics { rays, nodes_visited, nodes_there, shell_tests, positive_tests, leaf_solves }
    }
}

//! A formula in what is inside and what is not, kept up to date while its leaves change.

/// A tree of operations; its first nodes are the leaves.
#[derive(Clone, Debug)]
pub(super) struct Formula {
    nodes: Vec<Node>,
    /// The state in which no leaf is true.
    outside: State,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// The node above; the root is its own.
    parent: u32,
    /// Whether the node above takes the opposite of this one.
    negated: bool,
    /// How many of the operands must be true; not used on leaves.
    needed: u32,
}

/// The values of all nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    values: Vec<bool>,
    /// How many operands are true.
    counts: Vec<u32>,
}

/// What an operation takes to be true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Needs {
    Any,
    All,
}

impl Formula {
    /// `leaves` leaves, to be joined by operations. Every node but the last must become the operand of
    /// one that is added later.
    pub(super) fn new(leaves: usize) -> Self {
        let alone = |i| Node { parent: i as u32, negated: false, needed: 0 };
        let outside = State { values: vec![false; leaves], counts: vec![0; leaves] };
        Self { nodes: (0..leaves).map(alone).collect(), outside }
    }

    /// Adds an operation on nodes, each taken as it is or negated.
    pub(super) fn join(&mut self, needs: Needs, operands: &[(usize, bool)]) -> usize {
        let index = self.nodes.len();
        let mut count = 0;
        for &(operand, negated) in operands {
            self.nodes[operand].parent = index as u32;
            self.nodes[operand].negated = negated;
            count += u32::from(self.outside.values[operand] != negated);
        }
        let needed = if needs == Needs::Any { 1 } else { operands.len() as u32 };
        self.nodes.push(Node { parent: index as u32, negated: false, needed });
        self.outside.values.push(count >= needed);
        self.outside.counts.push(count);
        index
    }

    /// The state in which no leaf is true, in the room that another one takes.
    pub(super) fn outside(&self, mut room: State) -> State {
        room.values.clone_from(&self.outside.values);
        room.counts.clone_from(&self.outside.counts);
        room
    }

    /// Turns a leaf to its opposite, and all that follows from it.
    pub(super) fn toggle(&self, state: &mut State, leaf: usize) {
        let mut i = leaf;
        state.values[i] = !state.values[i];
        loop {
            let Node { parent, negated, .. } = self.nodes[i];
            let parent = parent as usize;
            if parent == i {
                return;
            }
            let count = &mut state.counts[parent];
            if state.values[i] != negated {
                *count += 1;
            } else {
                *count -= 1;
            }
            let value = *count >= self.nodes[parent].needed;
            if value == state.values[parent] {
                return;
            }
            state.values[parent] = value;
            i = parent;
        }
    }

    /// Whether the whole formula is true.
    pub(super) fn value(&self, state: &State) -> bool {
        state.values[self.nodes.len() - 1]
    }

    /// Whether the formula's value would be another if this leaf alone were.
    pub(super) fn depends_on(&self, state: &mut State, leaf: usize) -> bool {
        let value = self.value(state);
        self.toggle(state, leaf);
        let depends = self.value(state) != value;
        self.toggle(state, leaf);
        depends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toggling_agrees_with_the_formula() {
        // (a or b) and not (c and (a2 or not d)).
        let mut formula = Formula::new(5);
        let left = formula.join(Needs::Any, &[(0, false), (1, false)]);
        let inner = formula.join(Needs::Any, &[(3, false), (4, true)]);
        let right = formula.join(Needs::All, &[(2, false), (inner, false)]);
        formula.join(Needs::All, &[(left, false), (right, true)]);
        let mut state = formula.outside(State::default());
        let mut bits = 0_u32;
        for i in 0..1000_u32 {
            let leaf = (i.wrapping_mul(2_654_435_761) >> 20) as usize % 5;
            bits ^= 1 << leaf;
            formula.toggle(&mut state, leaf);
            let [a, b, c, a2, d] = [0, 1, 2, 3, 4].map(|n| bits >> n & 1 == 1);
            assert_eq!(formula.value(&state), (a || b) && !(c && (a2 || !d)));
        }
    }
}

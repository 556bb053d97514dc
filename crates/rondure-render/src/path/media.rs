//! The clear bodies that a path is inside of, one within the other or overlapping (Schmidt and Budge 2002,
//! "Simple Nested Dielectrics in Ray Traced Images").
//!
//! Where bodies overlap, the one of the highest priority fills the place; of several with the same, the one
//! that was entered last. A boundary at which the filling stays the same is none, and light passes it straight.

/// The most bodies within each other that a path keeps account of.
const MAX_NESTED: usize = 8;

/// A body that a path is inside of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Body {
    pub(crate) thing: u32,
    /// What fills it.
    pub(crate) finish: u32,
    pub(crate) priority: i32,
}

/// What a path does that goes through the boundary of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Crossing {
    Enters(Body),
    /// A thing, and what the face fills it with.
    Leaves(u32, u32),
}

/// The bodies that a path is inside of, in the order of entering.
#[derive(Clone, Debug, Default)]
pub(crate) struct Media {
    inside: [Body; MAX_NESTED],
    len: usize,
}

impl Media {
    /// Out of all bodies.
    #[inline]
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Goes through a boundary.
    pub(crate) fn cross(&mut self, crossing: Crossing) {
        match crossing {
            Crossing::Enters(body) => {
                if self.len < MAX_NESTED {
                    self.inside[self.len] = body;
                    self.len += 1;
                }
            }
            Crossing::Leaves(thing, finish) => {
                if let Some(i) = self.place(thing, finish) {
                    self.inside.copy_within(i + 1..self.len, i);
                    self.len -= 1;
                }
            }
        }
    }

    /// Where the body stands that is left by a face of a thing.
    fn place(&self, thing: u32, finish: u32) -> Option<usize> {
        let inside = &self.inside[..self.len];
        let same = |body: &Body| body.thing == thing && body.finish == finish;
        // A face may tell another filling than that by which the body was entered.
        let found = inside.iter().rposition(same);
        found.or_else(|| inside.iter().rposition(|body| body.thing == thing))
    }

    /// The body that fills the place.
    #[inline]
    pub(crate) fn filling(&self) -> Option<Body> {
        // Of equals, the last.
        self.inside[..self.len].iter().copied().max_by_key(|body| body.priority)
    }

    /// The one that fills it on the other side of a boundary.
    pub(crate) fn filling_beyond(&self, crossing: Crossing) -> Option<Body> {
        let inside = &self.inside[..self.len];
        match crossing {
            Crossing::Enters(body) => {
                let new = (self.len < MAX_NESTED).then_some(body);
                inside.iter().copied().chain(new).max_by_key(|body| body.priority)
            }
            Crossing::Leaves(thing, finish) => {
                let left = self.place(thing, finish);
                let rest = (0..).zip(inside).filter(|(i, _)| Some(*i) != left);
                rest.map(|(_, body)| *body).max_by_key(|body| body.priority)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Crossing::*, *};

    fn body(thing: u32, priority: i32) -> Body {
        Body { thing, finish: thing, priority }
    }

    /// The bodies after some crossings. What fills the place was foretold.
    fn after(crossings: &[Crossing]) -> Media {
        let mut media = Media::default();
        for &crossing in crossings {
            let beyond = media.filling_beyond(crossing);
            media.cross(crossing);
            assert_eq!(media.filling(), beyond);
        }
        media
    }

    #[test]
    fn highest_priority_fills_the_overlap() {
        let (glass, wine) = (body(1, 2), body(2, 1));
        let both = [Enters(glass), Enters(wine)];
        assert_eq!(after(&both).filling(), Some(glass));
        assert_eq!(after(&[both[0], both[1], Leaves(1, 1)]).filling(), Some(wine));
        assert_eq!(after(&[both[0], both[1], Leaves(1, 1), Leaves(2, 2)]).filling(), None);
    }

    #[test]
    fn of_equals_the_last_entered_fills() {
        let (a, b) = (body(1, 0), body(2, 0));
        let both = [Enters(a), Enters(b)];
        assert_eq!(after(&both).filling(), Some(b));
        assert_eq!(after(&[both[0], both[1], Leaves(2, 2)]).filling(), Some(a));
        assert_eq!(after(&[both[0], both[1], Leaves(1, 1)]).filling(), Some(b));
    }

    #[test]
    fn leaving_what_was_not_entered_changes_nothing() {
        let crossings = [Enters(body(1, 0)), Leaves(3, 3)];
        assert_eq!(after(&crossings).filling(), Some(body(1, 0)));
    }

    #[test]
    fn more_bodies_than_there_is_room_for_are_not_counted() {
        let crossings: Vec<_> =
            (0..=MAX_NESTED as i32).map(|i| Enters(body(i as u32, i))).collect();
        assert_eq!(after(&crossings).filling(), Some(body(7, 7)));
    }
}

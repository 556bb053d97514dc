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

/// What a path does that goes through the boundary of a body: not an enumeration, which would be put together in memory and be read again
/// before it is written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Whether it enters the body, or leaves it by a face that fills it so; what it leaves needs no priority.
    pub(crate) enters: bool,
    pub(crate) body: Body,
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
        let Crossing { enters, body } = crossing;
        if enters {
            if self.len < MAX_NESTED {
                self.inside[self.len] = body;
                self.len += 1;
            }
        } else if let Some(i) = self.place(body) {
            self.len -= 1;
            // Nearly always the last one.
            if i < self.len {
                self.inside.copy_within(i + 1..=self.len, i);
            }
        }
    }

    /// Where the body stands that is left.
    fn place(&self, left: Body) -> Option<usize> {
        let inside = &self.inside[..self.len];
        let same = |body: &Body| body.thing == left.thing && body.finish == left.finish;
        // A face may tell another filling than that by which the body was entered.
        let found = inside.iter().rposition(same);
        found.or_else(|| inside.iter().rposition(|body| body.thing == left.thing))
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
        let Crossing { enters, body } = crossing;
        if enters {
            let new = (self.len < MAX_NESTED).then_some(body);
            inside.iter().copied().chain(new).max_by_key(|body| body.priority)
        } else {
            let left = self.place(body);
            let rest = (0..).zip(inside).filter(|(i, _)| Some(*i) != left);
            rest.map(|(_, body)| *body).max_by_key(|body| body.priority)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(thing: u32, priority: i32) -> Body {
        Body { thing, finish: thing, priority }
    }

    fn enters(body: Body) -> Crossing {
        Crossing { enters: true, body }
    }

    fn leaves(thing: u32) -> Crossing {
        Crossing { enters: false, body: body(thing, 0) }
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
        let both = [enters(glass), enters(wine)];
        assert_eq!(after(&both).filling(), Some(glass));
        assert_eq!(after(&[both[0], both[1], leaves(1)]).filling(), Some(wine));
        assert_eq!(after(&[both[0], both[1], leaves(1), leaves(2)]).filling(), None);
    }

    #[test]
    fn of_equals_the_last_entered_fills() {
        let (a, b) = (body(1, 0), body(2, 0));
        let both = [enters(a), enters(b)];
        assert_eq!(after(&both).filling(), Some(b));
        assert_eq!(after(&[both[0], both[1], leaves(2)]).filling(), Some(a));
        assert_eq!(after(&[both[0], both[1], leaves(1)]).filling(), Some(b));
    }

    #[test]
    fn leaving_what_was_not_entered_changes_nothing() {
        let crossings = [enters(body(1, 0)), leaves(3)];
        assert_eq!(after(&crossings).filling(), Some(body(1, 0)));
    }

    #[test]
    fn more_bodies_than_there_is_room_for_are_not_counted() {
        let crossings: Vec<_> =
            (0..=MAX_NESTED as i32).map(|i| enters(body(i as u32, i))).collect();
        assert_eq!(after(&crossings).filling(), Some(body(7, 7)));
    }
}

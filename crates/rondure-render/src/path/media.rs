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

/// The bodies that a path is inside of, in the order of entering.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Media {
    inside: [Body; MAX_NESTED],
    len: usize,
}

impl Media {
    pub(crate) fn entered(mut self, body: Body) -> Self {
        if self.len < MAX_NESTED {
            self.inside[self.len] = body;
            self.len += 1;
        }
        self
    }

    pub(crate) fn left(mut self, thing: u32, finish: u32) -> Self {
        let inside = &self.inside[..self.len];
        let same = |body: &Body| body.thing == thing && body.finish == finish;
        // A face may tell another filling than that by which the body was entered.
        let found = inside.iter().rposition(same);
        if let Some(i) = found.or_else(|| inside.iter().rposition(|body| body.thing == thing)) {
            self.inside.copy_within(i + 1..self.len, i);
            self.len -= 1;
        }
        self
    }

    /// The body that fills the place.
    #[inline]
    pub(crate) fn filling(&self) -> Option<Body> {
        // Of equals, the last.
        self.inside[..self.len].iter().copied().max_by_key(|body| body.priority)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(thing: u32, priority: i32) -> Body {
        Body { thing, finish: thing, priority }
    }

    #[test]
    fn highest_priority_fills_the_overlap() {
        let (glass, wine) = (body(1, 2), body(2, 1));
        let both = Media::default().entered(glass).entered(wine);
        assert_eq!(both.filling(), Some(glass));
        assert_eq!(both.left(1, 1).filling(), Some(wine));
        assert_eq!(both.left(1, 1).left(2, 2).filling(), None);
    }

    #[test]
    fn of_equals_the_last_entered_fills() {
        let (a, b) = (body(1, 0), body(2, 0));
        let both = Media::default().entered(a).entered(b);
        assert_eq!(both.filling(), Some(b));
        assert_eq!(both.left(2, 2).filling(), Some(a));
        assert_eq!(both.left(1, 1).filling(), Some(b));
    }

    #[test]
    fn leaving_what_was_not_entered_changes_nothing() {
        let inside = Media::default().entered(body(1, 0));
        assert_eq!(inside.left(3, 3).filling(), Some(body(1, 0)));
    }
}

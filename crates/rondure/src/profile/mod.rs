//! The profile: the curve (r(s), z(s)), r >= 0, that is swept round the z axis.
//!
//! A [`Profile`] is one or more [`Subpath`]s, each a chain of [`Segment`]s; it is checked when it is
//! built and never changes. `path_data.rs` reads it from text, `builder.rs` from code, `spline.rs`
//! from points; `caps.rs` closes open ends, `thickness/` makes walls.

mod builder;
mod caps;
mod error;
pub(crate) mod monotone;
mod path_data;
mod plane_map;
mod segment;
mod spline;
mod thickness;

pub use builder::ProfileBuilder;
pub use error::{ProfileError, ProfileErrorKind};
pub use plane_map::PlaneMap;
pub use segment::{Arc, Point, Segment};
pub use spline::Spline;
pub use thickness::{ACCURACY as OFFSET_ACCURACY, Rim, Side, Thickness};

/// A profile: what is swept round the axis to make a surface of revolution.
///
/// The first coordinate of a point is r, the distance from the axis, the second is z, the height
/// along it. Every segment is finite and stays at r >= 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    subpaths: Vec<Subpath>,
}

/// A connected chain of segments: each begins where the one before it ends, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Subpath {
    segments: Vec<Segment>,
    closed: bool,
}

impl Subpath {
    /// A chain of segments that is one already.
    pub(crate) fn of(segments: Vec<Segment>, closed: bool) -> Self {
        Self { segments, closed }
    }

    /// The segments in drawing order; never empty.
    #[inline]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Whether the last segment ends where the first begins.
    #[inline]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Whether the swept surface encloses a volume: the subpath is closed, or has both ends on the
    /// axis.
    pub fn bounds_solid(&self) -> bool {
        self.closed || (self.start().r == 0.0 && self.end().r == 0.0)
    }

    /// The first point.
    #[inline]
    pub fn start(&self) -> Point {
        self.segments[0].start()
    }

    /// The last point.
    #[inline]
    pub fn end(&self) -> Point {
        self.segments[self.segments.len() - 1].end()
    }
}

impl Profile {
    /// Subpaths that have been checked already.
    pub(crate) fn of(subpaths: Vec<Subpath>) -> Self {
        Self { subpaths }
    }

    /// Starts a profile in code.
    pub fn builder() -> ProfileBuilder {
        ProfileBuilder::default()
    }

    /// The chains of segments, in drawing order; never empty.
    #[inline]
    pub fn subpaths(&self) -> &[Subpath] {
        &self.subpaths
    }

    /// All segments, in drawing order.
    pub fn segments(&self) -> impl Iterator<Item = &Segment> {
        self.subpaths.iter().flat_map(Subpath::segments)
    }

    /// Whether every subpath bounds a solid (see [`Subpath::bounds_solid`]); only then does every
    /// line cross the surface an even number of times.
    pub fn bounds_solid(&self) -> bool {
        self.subpaths.iter().all(Subpath::bounds_solid)
    }
}

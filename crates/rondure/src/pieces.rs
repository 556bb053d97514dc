//! The curves of a surface in as few numbers as they need: its profile, and the pieces that it was cut into.
//!
//! Most segments of a profile are one piece, whose control points are those of the segment, lowered. Only pieces that are a
//! part of a segment, or of an arc, have control points of their own. Curves that follow each other share their joint.

use crate::piece::{Jet, Kind, Piece};
use crate::profile::{Arc, Point, Profile, Segment, Subpath};

/// The pieces of a surface, and its profile.
#[derive(Clone, Debug)]
pub(crate) struct Pieces {
    /// As they are, for engines that walk from piece to piece.
    listed: Vec<Piece>,
    /// Otherwise the place of each.
    places: Vec<Place>,
    /// Of the profile's segments, then of pieces that are no whole segment.
    points: Vec<Point>,
    /// How many points are the profile's.
    drawn: u32,
    /// The place of each segment.
    segments: Vec<Place>,
    /// How many segments there are up to the end of each subpath, and whether it is closed.
    subpaths: Vec<(u32, bool)>,
    /// How much higher the profile lies than the pieces.
    center_z: f64,
}

/// The number of a curve's first point times eight, and the kind of curve.
#[derive(Clone, Copy, Debug)]
struct Place(u32);

const LINE: u32 = 0;
const QUADRATIC: u32 = 1;
const CUBIC: u32 = 2;
/// Between its ends are its center, its radii, its rotation and first angle, and the angle that it runs over.
const ARC: u32 = 3;
/// Pieces that are no whole segment.
const OWN_LINE: u32 = 4;
const OWN_QUADRATIC: u32 = 5;
const OWN_CUBIC: u32 = 6;
/// Its second but last point is its weight, and nothing.
const OWN_CONIC: u32 = 7;

impl Place {
    fn start(self) -> usize {
        (self.0 >> 3) as usize
    }

    fn kind(self) -> u32 {
        self.0 & 7
    }
}

impl Pieces {
    /// The pieces of a profile, lowered by `center_z`, and the number of the segment that each comes from.
    pub(crate) fn new(
        profile: &Profile,
        pieces: &[Piece],
        segments: impl Iterator<Item = u32>,
        center_z: f64,
    ) -> Self {
        let mut own = Self::without(profile, center_z);
        for (piece, segment) in pieces.iter().zip(segments) {
            let whole = own.segments[segment as usize];
            let is_whole = whole.kind() != ARC && own.piece(whole, |own| own == *piece);
            let place = if is_whole { whole } else { own.push_piece(piece) };
            own.places.push(place);
        }
        own.places.shrink_to_fit();
        own.points.shrink_to_fit();
        own
    }

    /// Pieces that are not those of the profile.
    pub(crate) fn listed(profile: &Profile, pieces: Vec<Piece>, center_z: f64) -> Self {
        let mut own = Self { listed: pieces, ..Self::without(profile, center_z) };
        own.points.shrink_to_fit();
        own
    }

    fn without(profile: &Profile, center_z: f64) -> Self {
        let mut own = Self {
            listed: Vec::new(),
            places: Vec::new(),
            points: Vec::new(),
            drawn: 0,
            segments: Vec::new(),
            subpaths: Vec::new(),
            center_z,
        };
        for subpath in profile.subpaths() {
            for segment in subpath.segments() {
                let place = own.push_segment(segment);
                own.segments.push(place);
            }
            own.subpaths.push((own.segments.len() as u32, subpath.is_closed()));
        }
        own.segments.shrink_to_fit();
        own.subpaths.shrink_to_fit();
        own.drawn = own.points.len() as u32;
        own
    }

    fn push_segment(&mut self, segment: &Segment) -> Place {
        match segment {
            Segment::Line(p) => self.push(LINE, p),
            Segment::Quadratic(p) => self.push(QUADRATIC, p),
            Segment::Cubic(p) => self.push(CUBIC, p),
            Segment::Arc(arc) => {
                let [a, b] = arc.radii;
                let turn = Point::new(arc.rotation, arc.start_angle);
                let sweep = Point::new(arc.sweep_angle, 0.0);
                self.push(ARC, &[arc.start, arc.center, Point::new(a, b), turn, sweep, arc.end])
            }
        }
    }

    fn push_piece(&mut self, piece: &Piece) -> Place {
        let [a, b, c, d] = core::array::from_fn(|i| Point::new(piece.r[i], piece.z[i]));
        match piece.kind {
            Kind::Line => self.push(OWN_LINE, &[a, d]),
            Kind::Quadratic => self.push(OWN_QUADRATIC, &[a, b, d]),
            Kind::Cubic => self.push(OWN_CUBIC, &[a, b, c, d]),
            Kind::Conic(w) => self.push(OWN_CONIC, &[a, b, Point::new(w, 0.0), d]),
        }
    }

    /// Adds a curve, of which the last one's end is the start if that is the same.
    fn push(&mut self, kind: u32, points: &[Point]) -> Place {
        let joins = self.points.len() > self.drawn as usize && self.points.last() == points.first();
        let start = self.points.len() - usize::from(joins);
        self.points.truncate(start);
        self.points.extend(points);
        Place((start as u32) << 3 | kind)
    }

    pub(crate) fn len(&self) -> usize {
        self.places.len().max(self.listed.len())
    }

    /// The pieces in drawing order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Piece> + '_ {
        (0..self.len()).map(|i| *self.at(i, &mut None))
    }

    /// A piece, in `room` if it is nowhere else.
    #[inline]
    pub(crate) fn at<'a>(&'a self, index: usize, room: &'a mut Option<Piece>) -> &'a Piece {
        match self.listed.get(index) {
            Some(piece) => piece,
            None => room.insert(self.piece(self.places[index], |piece| piece)),
        }
    }

    /// The ends of a piece.
    pub(crate) fn ends(&self, index: usize) -> [Point; 2] {
        let mut room = None;
        let piece = self.at(index, &mut room);
        [piece.start(), piece.end()]
    }

    /// The point and the derivative at s of a piece, if they are not listed.
    #[inline(always)]
    pub(crate) fn packed_jet(&self, index: usize, s: f64) -> Option<Jet> {
        let place = self.places.get(index)?;
        Some(self.piece(*place, |piece| piece.jet(s)))
    }

    /// The point and the derivative at s of a piece.
    #[inline]
    pub(crate) fn jet(&self, index: usize, s: f64) -> Jet {
        self.packed_jet(index, s).unwrap_or_else(|| self.listed[index].jet(s))
    }

    /// Calls a function with a piece whose kind the compiler knows.
    #[inline(always)]
    fn piece<T>(&self, place: Place, call: impl Fn(Piece) -> T) -> T {
        let (start, down) = (place.start(), self.center_z);
        match place.kind() {
            LINE => call(line(self.controls(start), down)),
            QUADRATIC => call(quadratic(self.controls(start), down)),
            CUBIC => call(cubic(self.controls(start), down)),
            OWN_LINE => call(line(self.controls(start), 0.0)),
            OWN_QUADRATIC => call(quadratic(self.controls(start), 0.0)),
            OWN_CUBIC => call(cubic(self.controls(start), 0.0)),
            _ => {
                let [a, b, weight, d] = self.controls(start);
                call(piece(Kind::Conic(weight.r), [a, b, d, d], 0.0))
            }
        }
    }

    #[inline(always)]
    fn controls<const N: usize>(&self, start: usize) -> [Point; N] {
        let own = &self.points[start..start + N];
        core::array::from_fn(|i| own[i])
    }

    /// The profile, as it was drawn.
    pub(crate) fn profile(&self) -> Profile {
        let mut first = 0;
        let subpath = |&(end, closed): &(u32, bool)| {
            let places = &self.segments[first..end as usize];
            first = end as usize;
            Subpath::of(places.iter().map(|place| self.segment(*place)).collect(), closed)
        };
        Profile::of(self.subpaths.iter().map(subpath).collect())
    }

    fn segment(&self, place: Place) -> Segment {
        let p = &self.points[place.start()..];
        match place.kind() {
            LINE => Segment::Line([p[0], p[1]]),
            QUADRATIC => Segment::Quadratic([p[0], p[1], p[2]]),
            CUBIC => Segment::Cubic([p[0], p[1], p[2], p[3]]),
            _ => Segment::Arc(Arc {
                start: p[0],
                center: p[1],
                radii: [p[2].r, p[2].z],
                rotation: p[3].r,
                start_angle: p[3].z,
                sweep_angle: p[4].r,
                end: p[5],
            }),
        }
    }

    /// The first subpath that bounds no solid, with its ends.
    pub(crate) fn open_subpath(&self) -> Option<(usize, [Point; 2])> {
        let mut first = 0;
        self.subpaths.iter().enumerate().find_map(|(number, &(end, closed))| {
            let [start, last] = [first, end as usize - 1].map(|i| self.segment(self.segments[i]));
            first = end as usize;
            let ends = [start.start(), last.end()];
            let solid = closed || ends.iter().all(|end| end.r == 0.0);
            (!solid).then_some((number, ends))
        })
    }
}

#[inline(always)]
fn line([a, b]: [Point; 2], down: f64) -> Piece {
    piece(Kind::Line, [a, b, b, b], down)
}

#[inline(always)]
fn quadratic([a, b, c]: [Point; 3], down: f64) -> Piece {
    piece(Kind::Quadratic, [a, b, c, c], down)
}

#[inline(always)]
fn cubic(controls: [Point; 4], down: f64) -> Piece {
    piece(Kind::Cubic, controls, down)
}

#[inline(always)]
fn piece(kind: Kind, [a, b, c, d]: [Point; 4], down: f64) -> Piece {
    let z = [a.z - down, b.z - down, c.z - down, d.z - down];
    Piece { kind, r: [a.r, b.r, c.r, d.r], z }
}

#[cfg(test)]
mod tests {
    use crate::{Profile, Surface, piece};

    #[test]
    fn profiles_and_pieces_are_kept_bit_for_bit() {
        for path in [
            include_str!("../../../profiles/column.path"),
            include_str!("../../../profiles/pawn.path"),
            "M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z",
            "M 0 7 L 1 7 Q 1.5 7.2 1.6 8 C 3 8.9 -0.1 9 1 10 A 1 2 10 0 0 0.5 11 L 0 11",
            "M 1 0 C 3 2 -0.5 2 2 0 Z M 4 1 L 5 1.0000000001 L 5 3 Q 3 2 4 1 M 0 4 A 3 1 20 1 1 0 6",
        ] {
            let profile = Profile::from_path_data(path).unwrap();
            let surface = Surface::new(&profile);
            assert_eq!(surface.profile(), &profile);
            let down = crate::profile::Point::new(0.0, -surface.center_z);
            let pieces = profile.segments().flat_map(|segment| piece::cut(&segment.moved(down)));
            let swept: Vec<_> = pieces.filter(|piece| piece.r != [0.0; 4]).collect();
            assert!(surface.pieces.iter().eq(swept.iter().copied()), "{path}");
            for (i, piece) in swept.iter().enumerate() {
                let (a, b) = (piece.jet(0.3), surface.pieces.jet(i, 0.3));
                assert_eq!([a.point, a.tangent], [b.point, b.tangent]);
            }
            let open = profile.subpaths().iter().position(|subpath| !subpath.bounds_solid());
            assert_eq!(surface.pieces.open_subpath().map(|(number, _)| number), open);
        }
    }
}

//! Many rays at once, as structures of arrays.

use crate::{Hit, Ray, Vec3};

/// Rays, each coordinate in a slice of its own; all slices are of the same length.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    pub(crate) origin: [&'a [f64]; 3],
    pub(crate) direction: [&'a [f64]; 3],
    pub(crate) range: [&'a [f64]; 2],
}

impl<'a> Rays<'a> {
    /// Rays from the coordinates of their origins and directions and the ends t_min and t_max of their
    /// ranges; `None` if the slices differ in length.
    pub fn new(
        origin: [&'a [f64]; 3],
        direction: [&'a [f64]; 3],
        t_min: &'a [f64],
        t_max: &'a [f64],
    ) -> Option<Self> {
        let slices = origin.iter().chain(&direction).chain([&t_min, &t_max]);
        let mut lengths = slices.map(|s| s.len());
        let len = t_min.len();
        lengths.all(|l| l == len).then_some(Self { origin, direction, range: [t_min, t_max] })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.range[0].len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The coordinates x, y and z of their origins.
    #[inline]
    pub fn origins(&self) -> [&'a [f64]; 3] {
        self.origin
    }

    /// The coordinates of their directions.
    #[inline]
    pub fn directions(&self) -> [&'a [f64]; 3] {
        self.direction
    }

    /// The ends t_min and t_max of their ranges.
    #[inline]
    pub fn ranges(&self) -> [&'a [f64]; 2] {
        self.range
    }

    /// Some of them.
    ///
    /// # Panics
    ///
    /// If there are not as many.
    #[inline]
    pub fn slice(&self, range: core::ops::Range<usize>) -> Self {
        let [ox, oy, oz] = self.origin;
        let [dx, dy, dz] = self.direction;
        let [t_min, t_max] = self.range;
        let of = |column: &'a [f64]| &column[range.clone()];
        Self {
            origin: [of(ox), of(oy), of(oz)],
            direction: [of(dx), of(dy), of(dz)],
            range: [of(t_min), of(t_max)],
        }
    }

    /// The same rays with other ends t_max.
    ///
    /// # Panics
    ///
    /// If there are not as many ends as rays.
    #[inline]
    pub fn with_ends<'b>(&self, t_max: &'b [f64]) -> Rays<'b>
    where
        'a: 'b,
    {
        assert_eq!(t_max.len(), self.len(), "as many ends as rays");
        Rays { range: [self.range[0], t_max], ..*self }
    }

    /// One of them.
    ///
    /// # Panics
    ///
    /// If there are no more than `index`.
    #[inline(always)]
    pub fn get(&self, index: usize) -> Ray {
        let at = |c: [&[f64]; 3]| Vec3::new(c[0][index], c[1][index], c[2][index]);
        Ray {
            origin: at(self.origin),
            direction: at(self.direction),
            t_min: self.range[0][index],
            t_max: self.range[1][index],
        }
    }
}

/// Rays as columns of their own, for those who have them one by one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayColumns {
    origin: [Vec<f64>; 3],
    direction: [Vec<f64>; 3],
    range: [Vec<f64>; 2],
}

impl RayColumns {
    /// The rays, as batches take them.
    pub fn rays(&self) -> Rays<'_> {
        let [ox, oy, oz] = &self.origin;
        let [dx, dy, dz] = &self.direction;
        let [t_min, t_max] = &self.range;
        Rays { origin: [ox, oy, oz], direction: [dx, dy, dz], range: [t_min, t_max] }
    }
}

impl RayColumns {
    /// No rays any more, but the room that they took.
    pub fn clear(&mut self) {
        for column in self.origin.iter_mut().chain(&mut self.direction).chain(&mut self.range) {
            column.clear();
        }
    }

    /// Appends rays, column by column.
    pub fn extend_from_slice(&mut self, rays: &[Ray]) {
        let [ox, oy, oz] = &mut self.origin;
        let [dx, dy, dz] = &mut self.direction;
        let [t_min, t_max] = &mut self.range;
        ox.extend(rays.iter().map(|ray| ray.origin.x));
        oy.extend(rays.iter().map(|ray| ray.origin.y));
        oz.extend(rays.iter().map(|ray| ray.origin.z));
        dx.extend(rays.iter().map(|ray| ray.direction.x));
        dy.extend(rays.iter().map(|ray| ray.direction.y));
        dz.extend(rays.iter().map(|ray| ray.direction.z));
        t_min.extend(rays.iter().map(|ray| ray.t_min));
        t_max.extend(rays.iter().map(|ray| ray.t_max));
    }

    /// Gives a ray another end t_max.
    ///
    /// # Panics
    ///
    /// If there are no more than `index`.
    pub fn set_end(&mut self, index: usize, t_max: f64) {
        self.range[1][index] = t_max;
    }
}

impl<'a> FromIterator<&'a Ray> for RayColumns {
    fn from_iter<I: IntoIterator<Item = &'a Ray>>(rays: I) -> Self {
        let mut columns = Self::default();
        rays.into_iter().for_each(|ray| columns.extend_from_slice(core::slice::from_ref(ray)));
        columns
    }
}

/// The closest hits of many rays: t, piece and s as in [`Hit`], each in a slice of its own. Where a ray
/// hits nothing t is infinite, and piece and s mean nothing.
#[derive(Clone, Debug, Default)]
pub struct Hits {
    /// The ray parameters.
    pub t: Vec<f64>,
    /// The pieces.
    pub piece: Vec<u32>,
    /// The parameters on them.
    pub s: Vec<f64>,
}

impl Hits {
    /// The hit of one ray.
    ///
    /// # Panics
    ///
    /// If there are no more than `index`.
    pub fn get(&self, index: usize) -> Option<Hit> {
        let hit = Hit { t: self.t[index], piece: self.piece[index], s: self.s[index] };
        (hit.t < f64::INFINITY).then_some(hit)
    }

    pub(crate) fn clear(&mut self, len: usize) {
        self.t.clear();
        self.t.resize(len, f64::INFINITY);
        // What is there already is left: writing it would take as long as telling which rays miss.
        self.piece.resize(len, 0);
        self.s.resize(len, 0.0);
    }

    pub(crate) fn set(&mut self, index: usize, hit: Option<Hit>) {
        if let Some(hit) = hit {
            (self.t[index], self.piece[index], self.s[index]) = (hit.t, hit.piece, hit.s);
        }
    }
}

/// All hits of many rays, those of one ray after those of the ray before it, in order of t.
#[derive(Clone, Debug, Default)]
pub struct AllHits {
    /// Where the hits of each ray begin among all of them, and behind the last where those end.
    pub starts: Vec<usize>,
    /// The ray parameters.
    pub t: Vec<f64>,
    /// The pieces.
    pub piece: Vec<u32>,
    /// The parameters on them.
    pub s: Vec<f64>,
}

impl AllHits {
    /// The hits of one ray.
    ///
    /// # Panics
    ///
    /// If there are no more rays than `index`.
    pub fn of(&self, index: usize) -> impl ExactSizeIterator<Item = Hit> + '_ {
        let own = self.starts[index]..self.starts[index + 1];
        own.map(|i| Hit { t: self.t[i], piece: self.piece[i], s: self.s[i] })
    }
}

/// The hits of rays as they are found, in any order of the rays.
#[derive(Debug)]
pub(crate) struct Gathered {
    hits: Vec<Hit>,
    /// For each ray where its hits begin, and how many there are.
    runs: Vec<(usize, usize)>,
}

impl Gathered {
    pub(crate) fn new(rays: usize) -> Self {
        Self { hits: Vec::new(), runs: vec![(0, 0); rays] }
    }

    /// The hits of a ray, by t.
    pub(crate) fn add(&mut self, ray: usize, hits: &[Hit]) {
        self.runs[ray] = (self.hits.len(), hits.len());
        self.hits.extend_from_slice(hits);
    }

    /// Puts them into the order of the rays.
    pub(crate) fn sorted(&self, all: &mut AllHits) {
        let AllHits { starts, t, piece, s } = all;
        starts.clear();
        starts.reserve(self.runs.len() + 1);
        // What is there already is written over.
        t.resize(self.hits.len(), 0.0);
        piece.resize(self.hits.len(), 0);
        s.resize(self.hits.len(), 0.0);
        let mut next = 0;
        for &(start, count) in &self.runs {
            starts.push(next);
            for hit in &self.hits[start..start + count] {
                (t[next], piece[next], s[next]) = (hit.t, hit.piece, hit.s);
                next += 1;
            }
        }
        starts.push(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_hold_their_rays() {
        let rays: Vec<_> = (0..5)
            .map(|i| {
                let x = f64::from(i);
                Ray::new(Vec3::new(x, x + 0.25, x + 0.5), Vec3::new(-x, 1.0, x))
                    .with_range(x, 9.0 + x)
            })
            .collect();
        let columns = RayColumns::from_iter(&rays);
        assert_eq!(columns.rays().len(), rays.len());
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(columns.rays().get(i), *ray);
        }
        let mut columns = columns;
        columns.set_end(3, 0.5);
        assert_eq!(columns.rays().get(3), rays[3].with_range(3.0, 0.5));
        columns.clear();
        columns.extend_from_slice(&rays[1..2]);
        assert_eq!((columns.rays().len(), columns.rays().get(0)), (1, rays[1]));
    }

    #[test]
    fn columns_of_different_lengths_are_no_rays() {
        let (two, three) = ([0.0; 2], [0.0; 3]);
        assert!(Rays::new([&two; 3], [&two; 3], &two, &two).is_some());
        assert!(Rays::new([&two, &three, &two], [&two; 3], &two, &two).is_none());
        assert!(Rays::new([&two; 3], [&two; 3], &two, &three).is_none());
    }
}

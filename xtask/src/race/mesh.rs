//! Meshes of a surface of revolution, as fine as asked for: vertices lie on the surface, and between
//! them the mesh leaves it by no more than the given error.
//!
//! Half of the error belongs to the chords along the profile, half to those round the axis: with the
//! sum given, that takes the fewest cells.

use std::f64::consts::TAU;

use rondure::Profile;
use rondure::profile::{Point, Segment};

use super::abi::Grid;

/// What Embree can make of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Triangles,
    Quads,
    Grids,
}

impl Kind {
    pub(crate) const ALL: [Self; 3] = [Self::Triangles, Self::Quads, Self::Grids];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Quads => "quads",
            Self::Grids => "grids",
        }
    }
}

/// A profile as polylines, and how often it is repeated round the axis.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    chains: Vec<Vec<Point>>,
    around: u32,
}

/// What the primitives of a mesh are.
#[derive(Clone, Debug)]
pub(crate) enum Primitives {
    Triangles(Vec<[u32; 3]>),
    /// Two triangles each; where one of them has no area, the last index is there twice.
    Quads(Vec<[u32; 4]>),
    Grids(Vec<Grid>),
}

/// Vertices and what they are joined to.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) primitives: Primitives,
}

impl Mesh {
    /// Cuts a profile, and the circle of its largest radius, into chords that leave them by no more than
    /// half of `error` each.
    pub(crate) fn new(profile: &Profile, error: f64) -> Self {
        let error = 0.5 * error;
        let mut chains = Vec::new();
        let mut widest = 0.0_f64;
        for subpath in profile.subpaths() {
            let mut chain = vec![subpath.start()];
            for segment in subpath.segments() {
                flatten(segment, error, &mut chain);
            }
            widest = chain.iter().fold(widest, |widest, p| widest.max(p.r));
            chains.push(chain);
        }
        // The sagitta r (1 - cos(half the angle)) of the largest circle.
        let half_angle = (1.0 - error / widest).clamp(-1.0, 1.0).acos();
        let around = (0.5 * TAU / half_angle).ceil().max(3.0) as u32;
        Self { chains, around }
    }

    /// How many cells the mesh has: quads, but for those that end in a point.
    pub(crate) fn cells(&self) -> usize {
        self.chains.iter().map(|chain| chain.len() - 1).sum::<usize>() * self.around as usize
    }

    /// The mesh for Embree.
    pub(crate) fn buffers(&self, kind: Kind) -> Buffers {
        match kind {
            Kind::Triangles => self.joined(Vec::new(), |cell, triangles| {
                let [a, b, c, d] = cell;
                let halves = [[a, b, c], [a, c, d]];
                let area = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
                triangles.extend(halves.into_iter().filter(area));
            }),
            Kind::Quads => self.joined(Vec::new(), |cell, quads| {
                let [a, b, c, d] = cell;
                quads.push(match () {
                    () if a == d => [a, b, c, c],
                    () if b == c => [a, b, d, d],
                    () => cell,
                });
            }),
            Kind::Grids => self.grids(),
        }
    }

    fn circle(&self) -> impl Iterator<Item = [f64; 2]> {
        let step = TAU / f64::from(self.around);
        (0..self.around).map(move |i| {
            let (sin, cos) = (step * f64::from(i)).sin_cos();
            [cos, sin]
        })
    }

    /// Vertices that all neighbours share. Cells are listed with two corners on one ring of the mesh,
    /// then two on the next.
    fn joined<T>(&self, mut list: Vec<T>, mut add: impl FnMut([u32; 4], &mut Vec<T>)) -> Buffers
    where
        Primitives: From<Vec<T>>,
    {
        let circle: Vec<_> = self.circle().collect();
        let mut vertices = Vec::new();
        for chain in &self.chains {
            // Where each ring begins, and whether it is more than a point.
            let mut below: Option<(u32, bool)> = None;
            for &p in chain {
                let (start, open) = (vertices.len() as u32, p.r > 0.0);
                let ring = if open { &circle[..] } else { &circle[..1] };
                vertices.extend(ring.iter().map(|&[x, y]| vertex(p, x, y)));
                if let Some(below) = below {
                    let at = |(start, open): (u32, bool), i| if open { start + i } else { start };
                    for i in 0..self.around {
                        let next = (i + 1) % self.around;
                        let above = (start, open);
                        add(
                            [at(below, i), at(above, i), at(above, next), at(below, next)],
                            &mut list,
                        );
                    }
                }
                below = Some((start, open));
            }
        }
        Buffers { vertices, primitives: list.into() }
    }

    /// Whole rings in a row, with the first vertex again at the end; tiles share their borders.
    fn grids(&self) -> Buffers {
        let circle: Vec<_> = self.circle().chain(self.circle().take(1)).collect();
        let mut vertices = Vec::new();
        let mut grids = Vec::new();
        for chain in &self.chains {
            let first = vertices.len() as u32;
            vertices.extend(
                chain.iter().flat_map(|&p| circle.iter().map(move |&[x, y]| vertex(p, x, y))),
            );
            let (width, height) = (self.around, chain.len() as u32 - 1);
            for y in (0..height).step_by(GRID_CELLS as usize) {
                for x in (0..width).step_by(GRID_CELLS as usize) {
                    grids.push(Grid {
                        start: first + y * (width + 1) + x,
                        stride: width + 1,
                        width: (GRID_CELLS.min(width - x) + 1) as u16,
                        height: (GRID_CELLS.min(height - y) + 1) as u16,
                    });
                }
            }
        }
        Buffers { vertices, primitives: Primitives::Grids(grids) }
    }
}

/// The edge of a grid in cells. Embree cuts grids into squares of 2 x 2 cells whatever their size.
const GRID_CELLS: u32 = 64;

fn vertex(p: Point, x: f64, y: f64) -> [f32; 3] {
    [(p.r * x) as f32, (p.r * y) as f32, p.z as f32]
}

impl From<Vec<[u32; 3]>> for Primitives {
    fn from(list: Vec<[u32; 3]>) -> Self {
        Self::Triangles(list)
    }
}

impl From<Vec<[u32; 4]>> for Primitives {
    fn from(list: Vec<[u32; 4]>) -> Self {
        Self::Quads(list)
    }
}

/// Adds the ends of chords as long as they can be.
fn flatten(segment: &Segment, error: f64, chain: &mut Vec<Point>) {
    let mut s = 0.0;
    while s < 1.0 {
        let mut end = 1.0;
        if deviation(segment, s, end) > error {
            let mut good = s;
            // Bisection to a thousandth of the step.
            while end - good > 1e-3 * (end - s) {
                let middle = 0.5 * (good + end);
                if deviation(segment, s, middle) > error { end = middle } else { good = middle }
            }
            end = good;
        }
        s = end;
        chain.push(if s < 1.0 { segment.point(s) } else { segment.end() });
    }
}

/// How far the curve leaves a chord, at seven points between its ends.
fn deviation(segment: &Segment, start: f64, end: f64) -> f64 {
    let [a, b] = [segment.point(start), segment.point(end)];
    let chord = b - a;
    let squared = chord.r * chord.r + chord.z * chord.z;
    let off = |i: i32| {
        let p = segment.point(start + (end - start) * f64::from(i) / 8.0) - a;
        let along = if squared > 0.0 { (p.r * chord.r + p.z * chord.z) / squared } else { 0.0 };
        let along = along.clamp(0.0, 1.0);
        (p.r - along * chord.r).hypot(p.z - along * chord.z)
    };
    (1..8).map(off).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(error: f64) -> Mesh {
        Mesh::new(&Profile::from_path_data("M 0 -1 A 1 1 0 0 1 0 1").unwrap(), error)
    }

    #[test]
    fn a_sphere_is_met_within_the_error() {
        for error in [1e-2, 1e-4] {
            let Buffers { vertices, primitives } = mesh(error).buffers(Kind::Triangles);
            let Primitives::Triangles(triangles) = primitives else { panic!("not triangles") };
            let mut furthest = 0.0_f64;
            for corners in triangles {
                let middle: Vec<_> = (0..3)
                    .map(|i| {
                        corners.iter().map(|&c| f64::from(vertices[c as usize][i])).sum::<f64>()
                            / 3.0
                    })
                    .collect();
                furthest = furthest.max(1.0 - middle.iter().map(|x| x * x).sum::<f64>().sqrt());
            }
            assert!(furthest < error && furthest > 0.25 * error, "{furthest} {error}");
        }
    }

    #[test]
    fn every_kind_has_the_same_cells() {
        let mesh = mesh(1e-3);
        let rings = mesh.cells() / mesh.around as usize;
        let Primitives::Triangles(triangles) = mesh.buffers(Kind::Triangles).primitives else {
            panic!("not triangles")
        };
        assert_eq!(triangles.len(), 2 * mesh.cells() - 2 * mesh.around as usize);
        let Primitives::Quads(quads) = mesh.buffers(Kind::Quads).primitives else {
            panic!("not quads")
        };
        assert_eq!(quads.len(), mesh.cells());
        let Buffers { vertices, primitives: Primitives::Grids(grids) } = mesh.buffers(Kind::Grids)
        else {
            panic!("not grids")
        };
        assert_eq!(vertices.len(), (rings + 1) * (mesh.around as usize + 1));
        let cells = grids.iter().map(|g| (g.width as usize - 1) * (g.height as usize - 1));
        assert_eq!(cells.sum::<usize>(), mesh.cells());
    }
}

//! Turned solids cut at the height of one of their own vertices, pixel for pixel.
//!
//! A camera looks at a solid cut by a level plane. What each of its 97 x 73 rays must meet follows from
//! the exact hits of the whole solid: the cut face, if the number of hits before the plane is odd, or
//! else the first hit on the side that is left. A plane through a vertex is the worst that there is: it runs
//! along level parts of the profile, touches peaks, and passes through joints.

use core::fmt;
use std::sync::Arc;

use rondure::{
    FillRule, Profile, Ray, Solid, Vec3,
    numeric::{UNIT_ROUNDOFF, gamma},
    solid::{Compound, Csg},
};

use crate::{Oracle, OracleHit, solids::known};

/// Pixels across and down.
pub const PIXELS: [u32; 2] = [97, 73];

/// Where the camera stands, seen from the solid's centre, in its radii: above, far above, below.
pub const EYES: [Vec3; 3] =
    [Vec3::new(1.6, -2.3, 1.9), Vec3::new(0.3, 0.2, 3.4), Vec3::new(-1.7, -2.2, -1.4)];

/// A hit so near to the plane, as a fraction of the distance, may lie on either side of it; so may one
/// of a line that is so near to a tangency, as a fraction of the size.
const BAND: f64 = 1e-12;

/// As many failures are told in words.
const TOLD: usize = 10;

/// What came of it.
#[derive(Clone, Debug, Default)]
pub struct Cuts {
    /// The cuts.
    pub cuts: u64,
    /// The pixels of all pictures.
    pub pixels: u64,
    /// Those that must show the cut face.
    pub faces: u64,
    /// Those within the bands, not judged.
    pub unclear: u64,
    /// Those that show something else.
    pub wrong: u64,
    /// The largest distance of a hit from where it should be, across the surface, as a fraction of the
    /// largest length there.
    pub worst: f64,
    /// The first few failures, in words.
    pub failures: Vec<String>,
}

/// What a pixel must show.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pixel {
    Nothing,
    /// The cut face, at t; `flush` if the solid's own surface lies there too.
    Face {
        t: f64,
        flush: bool,
    },
    /// The solid's surface, at t, met at an angle of this sine.
    Surface {
        t: f64,
        sine: f64,
    },
    Unclear,
}

impl Cuts {
    /// Cuts the solid of a profile at the heights of its vertices, or at `most` of them, and looks at it
    /// from so many `eyes`, as of [`EYES`].
    ///
    /// # Panics
    ///
    /// If the profile bounds no solid.
    pub fn cut(&mut self, name: &str, profile: &Profile, most: usize, eyes: &[Vec3]) {
        let oracle = Oracle::new(profile);
        // By the even-odd rule the number of hits tells what is inside.
        let solid = Arc::new(known(Solid::new(profile, FillRule::EvenOdd)));
        let mut heights: Vec<f64> =
            profile.segments().flat_map(|s| [s.start().z, s.end().z]).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let step = heights.len().div_ceil(most.max(1)).max(1);
        // The last one, the top, always.
        let heights: Vec<f64> = heights.into_iter().rev().step_by(step).collect();
        let cuts: Vec<_> = heights
            .iter()
            .map(|&z| {
                let knife = Csg::half_space(Vec3::new(0.0, 0.0, z), Vec3::Z);
                known(Csg::turned(Arc::clone(&solid)).intersection(knife).build())
            })
            .collect();
        self.cuts += cuts.len() as u64;
        let size = oracle.size();
        for &eye in eyes {
            for ray in rays(oracle.center(), 0.5 * size, eye) {
                let hits = oracle.hits(&ray);
                let grazes = oracle.tangency(&ray) < BAND;
                for (cut, &z) in cuts.iter().zip(&heights) {
                    let pixel = if grazes { Pixel::Unclear } else { expected(&ray, &hits, z) };
                    if let Some(wrong) = self.judge(cut, &ray, z, size, pixel) {
                        self.wrong += 1;
                        if self.failures.len() < TOLD {
                            self.failures.push(format!("{name} at {z:?}: {wrong} {ray:?}"));
                        }
                    }
                }
            }
        }
    }

    /// What is wrong with what a ray meets.
    fn judge(
        &mut self,
        cut: &Compound,
        ray: &Ray,
        z: f64,
        size: f64,
        pixel: Pixel,
    ) -> Option<String> {
        self.pixels += 1;
        let found = cut.closest(ray);
        let told = || format!("{pixel:?}, found {found:?}");
        let speed = ray.direction.length();
        let (t, sine) = match pixel {
            Pixel::Unclear => {
                self.unclear += 1;
                return None;
            }
            Pixel::Nothing => return found.is_some().then(told),
            Pixel::Face { t, .. } => {
                self.faces += 1;
                (t, (ray.direction.z / speed).abs())
            }
            Pixel::Surface { t, sine } => (t, sine),
        };
        let Some((end, face)) = found.and_then(|end| Some((end, end.wall?))) else {
            return Some(told());
        };
        // The longest of the lengths that are subtracted from one another.
        let reach = size + ray.origin.max_abs();
        let off = (end.t - t).abs() * speed * sine / reach;
        self.worst = self.worst.max(off);
        let mut good = off <= 64.0 * UNIT_ROUNDOFF;
        if let Pixel::Face { flush, .. } = pixel {
            let at = cut.interaction(ray, &face);
            good &= (at.normal - Vec3::Z).max_abs() <= gamma(16);
            good &= (at.point.z - z).abs() <= gamma(16) * reach;
            good &= flush || face.leaf() == 1;
        } else {
            good &= face.leaf() == 0;
        }
        (!good).then(told)
    }

    /// Whether every pixel is right.
    pub fn are_right(&self) -> bool {
        self.wrong == 0
    }
}

/// The rays of a camera at `eye`, in radii from the centre, that holds a ball of this radius.
fn rays(center: Vec3, radius: f64, eye: Vec3) -> impl Iterator<Item = Ray> {
    let origin = center + eye * radius;
    let forward = (center - origin).normalized();
    let right = forward.cross(Vec3::Z).normalized();
    let down = forward.cross(right);
    let [width, height] = PIXELS;
    // The ball from tangent to tangent, and a little more.
    let distance = (center - origin).length() / radius;
    let pixel = 2.1 / (distance * distance - 1.0).sqrt() / f64::from(height);
    let middle = move |i: u32, n: u32| pixel * (f64::from(i) + 0.5 - 0.5 * f64::from(n));
    (0..width * height).map(move |i| {
        let across = right * middle(i % width, width) + down * middle(i / width, height);
        Ray::new(origin, forward + across)
    })
}

/// What a ray from outside meets of the part below z.
fn expected(ray: &Ray, hits: &[OracleHit], z: f64) -> Pixel {
    let plane = (z - ray.origin.z) / ray.direction.z;
    let rounding = gamma(4) * plane.abs();
    // A place and the next: the same, apart, or neither for certain.
    let unclear = |a: f64, b: f64| {
        let size = a.abs().max(b.abs());
        (gamma(4) * size..BAND * size).contains(&(a - b).abs())
    };
    let is_unclear = ray.direction.z == 0.0
        || hits.iter().any(|hit| hit.changes != 1 || unclear(hit.t.hi, plane))
        || hits.windows(2).any(|pair| unclear(pair[0].t.hi, pair[1].t.hi));
    if is_unclear {
        return Pixel::Unclear;
    }
    // A face that is drawn back and forth bounds nothing.
    let same = |a: &OracleHit, b: &OracleHit| b.t.hi - a.t.hi < gamma(4) * b.t.hi.abs();
    let walls: Vec<&OracleHit> =
        hits.chunk_by(same).filter(|group| group.len() % 2 == 1).map(|group| &group[0]).collect();
    let flush = walls.iter().any(|hit| (hit.t.hi - plane).abs() < rounding);
    let first = |from: f64, to: f64| {
        let hit = walls.iter().find(|hit| from < hit.t.hi && hit.t.hi < to);
        hit.map_or(Pixel::Nothing, |hit| Pixel::Surface { t: hit.t.hi, sine: hit.incidence })
    };
    if ray.direction.z > 0.0 {
        return first(0.0, plane - rounding);
    }
    if plane <= 0.0 {
        return first(0.0, f64::INFINITY);
    }
    let passed = walls.iter().filter(|hit| hit.t.hi <= plane + rounding).count();
    if passed % 2 == 1 {
        Pixel::Face { t: plane, flush }
    } else {
        first(plane + rounding, f64::INFINITY)
    }
}

impl fmt::Display for Cuts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cuts, pixels, faces, unclear, wrong, worst, failures } = self;
        write!(
            f,
            "{cuts} cuts, {pixels} pixels: {faces} must show the cut face, {unclear} unclear, {wrong} \
             wrong; farthest off {worst:.1e}"
        )?;
        failures.iter().try_for_each(|failure| write!(f, "\n  {failure}"))
    }
}

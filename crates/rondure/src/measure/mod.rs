//! Length, area, volume, centroid, moments of inertia, and what a vessel holds.
//!
//! For an outline run round with the solid on its left (r to the right, z up), Green's theorem makes
//! line integrals of the integrals over the solid:
//!
//! ```text
//! V = pi ∮ r^2 dz,   V z_c = pi ∮ r^2 z dz,   I_zz = pi/2 ∮ r^4 dz,
//! I_xx = I_yy = I_zz / 2 + pi ∮ r^2 (z - z_c)^2 dz
//! ```
//!
//! `solid.rs` evaluates them by `quadrature.rs`, exactly but for rounding; `slabs.rs` finds out which
//! side is inside and whether the profile crosses itself, `cavity.rs` pours liquid in.

mod cavity;
pub(crate) mod quadrature;
mod slabs;
mod solid;
mod solve;

use core::fmt;

use self::quadrature::{Sum, smooth_steps};
use self::slabs::{Disorder, Slabs};
use self::solid::{Part, middle, reach, solid};
use crate::Profile;
use crate::numeric::gamma;
use crate::profile::{Point, Segment};

pub use self::cavity::Cavity;

/// What can be measured on a profile and on the surface and the solid that it sweeps; made by
/// [`Profile::measure`].
///
/// Lengths are in the unit of the profile, areas in its square, and so on. Each `_error` is a bound
/// for the absolute error, that of the coordinates aside.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let bowl = rondure::Profile::from_path_data("M 0 0 A 2 2 0 0 1 2 2 L 1.8 2 A 1.8 1.8 0 0 0 0 0.2")?;
/// let measure = bowl.measure();
/// let solid = measure.solid?;
/// assert!((solid.volume - std::f64::consts::PI * 2.0 / 3.0 * (8.0 - 5.832)).abs() < 1e-14);
/// let cavity = measure.cavity?;
/// assert_eq!(cavity.brim(), 2.0);
/// let half = cavity.level(0.5 * cavity.capacity()).ok_or("never: half of it fits")?;
/// assert!(1.2 < half && half < 1.4);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Measure {
    /// The arc length of the profile as it was drawn, lines along the axis and closing lines
    /// included.
    pub length: f64,
    /// A bound for the error of the length.
    pub length_error: f64,
    /// The area of the swept surface; that of walls, where the profile has a thickness, on both
    /// their sides.
    pub area: f64,
    /// A bound for the error of the area.
    pub area_error: f64,
    /// The largest distance from the axis.
    pub r_max: f64,
    /// The lowest and the highest z.
    pub z_range: [f64; 2],
    /// The solid that the surface encloses, or why there is none.
    pub solid: Result<Solid, NoSolid>,
    /// What the surface holds when it stands upright, z pointing up, or why it holds nothing.
    pub cavity: Result<Cavity, NoCavity>,
}

/// The solid between the surface's sheets, by the even-odd rule, of density 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// The volume.
    pub volume: f64,
    /// A bound for the error of the volume.
    pub volume_error: f64,
    /// The height of the centroid, which lies on the axis.
    pub centroid_z: f64,
    /// A bound for the error of the centroid's height.
    pub centroid_error: f64,
    /// The moment of inertia round the axis: I_zz.
    pub inertia_axial: f64,
    /// The moment of inertia round any axis across, through the centroid: I_xx = I_yy.
    pub inertia_transverse: f64,
    /// A bound for the errors of both moments of inertia.
    pub inertia_error: f64,
}

/// Why a profile encloses no solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoSolid {
    /// A subpath is open: neither closed nor with both ends on the axis.
    Open {
        /// The number of the subpath, from 0.
        subpath: usize,
        /// Its two ends.
        ends: [Point; 2],
    },
    /// The profile crosses itself, so that its inside is not defined.
    Crossing {
        /// A point near the crossing.
        near: Point,
    },
    /// More than 2^24 pairs of a monotone piece and a height at which another one ends.
    TooIntricate,
}

/// Why a profile holds no liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoCavity {
    /// Nothing stops what falls along the axis.
    Drains {
        /// The radius of the bore that is left free.
        bore: f64,
    },
    /// What falls along the axis runs off from where it lands, down the outside.
    RunsOff {
        /// The height at which it lands.
        z: f64,
    },
    /// The profile crosses itself.
    Crossing {
        /// A point near the crossing.
        near: Point,
    },
    /// More than 2^24 pairs of a monotone piece and a height at which another one ends.
    TooIntricate,
}

impl fmt::Display for NoSolid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open { subpath, ends: [a, b] } => write!(
                f,
                "the profile is open: subpath {subpath} runs from ({}, {}) to ({}, {}), and is \
                 neither closed nor has both ends on the axis",
                a.r, a.z, b.r, b.z
            ),
            Self::Crossing { near } => crossing(*near, f),
            Self::TooIntricate => too_intricate(f),
        }
    }
}

impl fmt::Display for NoCavity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drains { bore } => write!(
                f,
                "what is poured in along the axis runs out below: a bore of radius {bore} is open \
                 from top to bottom"
            ),
            Self::RunsOff { z } => write!(
                f,
                "what is poured along the axis lands at z = {z} and runs off: no wall holds it"
            ),
            Self::Crossing { near } => crossing(*near, f),
            Self::TooIntricate => too_intricate(f),
        }
    }
}

fn crossing(near: Point, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write!(
        f,
        "the profile crosses itself near (r, z) = ({}, {}), so that its inside is not defined",
        near.r, near.z
    )
}

fn too_intricate(f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str("the profile goes up and down so often that it cannot be taken apart")
}

impl std::error::Error for NoSolid {}
impl std::error::Error for NoCavity {}

impl Profile {
    /// Measures the profile, and the surface and the solid that it sweeps.
    ///
    /// Volumes, centroids and moments are exact but for rounding, which is reckoned from the middle
    /// of each closed subpath: a thin ring far from the axis, or a vase far up the axis, loses
    /// nothing. Length and area come from bisection until rounding is all that is left. A profile
    /// that crosses itself has no volume; crossings are found for certain where they change which
    /// side is inside, and otherwise if the overlap is more than 2^-10 of the height between the
    /// neighboring ends of monotone pieces.
    pub fn measure(&self) -> Measure {
        let z = middle(self.segments());
        let reach = reach(self.segments(), Point::new(0.0, z));
        let parts: Vec<Part<'_>> = self.subpaths().iter().map(Part::new).collect();
        let slabs = Slabs::new(self, z, reach);
        let solid = match &slabs {
            Err(Disorder::Crossing(p)) => Err(NoSolid::Crossing { near: raised(*p, z) }),
            Err(Disorder::TooMany) => Err(NoSolid::TooIntricate),
            Ok(slabs) => solid(&parts, &slabs.senses, z, reach),
        };
        let sum = |f: fn(&Part<'_>) -> f64| {
            let mut sum = Sum::default();
            parts.iter().for_each(|part| sum.add(f(part)));
            sum.value()
        };
        let area = sum(|part| part.area[0]);
        let cavity = match slabs {
            Err(Disorder::Crossing(p)) => Err(NoCavity::Crossing { near: raised(p, z) }),
            Err(Disorder::TooMany) => Err(NoCavity::TooIntricate),
            Ok(slabs) => Cavity::new(&slabs, z, gamma(64) * reach * area),
        };
        let extent = self.segments().flat_map(ends_and_turns);
        let mut r_max = 0.0_f64;
        let mut z_range = [f64::INFINITY, f64::NEG_INFINITY];
        for p in extent {
            r_max = r_max.max(p.r);
            z_range = [z_range[0].min(p.z), z_range[1].max(p.z)];
        }
        Measure {
            length: sum(|part| part.length[0]),
            length_error: sum(|part| part.length[1]),
            area,
            area_error: sum(|part| part.area[1]),
            r_max,
            z_range,
            solid,
            cavity,
        }
    }
}

/// The ends of a segment, and the points where r or z turns.
fn ends_and_turns(segment: &Segment) -> impl Iterator<Item = Point> {
    let turns = smooth_steps(segment).into_iter().skip(1).map(|[s, _]| segment.point(s));
    turns.chain([segment.start(), segment.end()])
}

fn raised(p: Point, z: f64) -> Point {
    Point::new(p.r, p.z + z)
}

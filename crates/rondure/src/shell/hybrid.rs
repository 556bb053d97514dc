//! The hybrid shell, HY (paper, sections 3.3 and 4.1.2): in every node CY or CO, whichever fits.

use super::cone::{between_cones, cone_intervals};
use super::cylinder::{between_cylinders, cylinder_intervals};
use super::{Cone, Cylinder, Intervals, Shell, slab};
use crate::meridian::Meridian;
use crate::piece::Piece;

/// A cylinder or a cone shell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hybrid {
    pub(crate) z: [f64; 2],
    pub(crate) wall: Wall,
}

/// What bounds a shell inwards and outwards.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wall {
    /// Two cylinders, by their squared radii.
    Cylinder { w: [f64; 2] },
    /// Two cones: rho - slope z lies between the two offsets.
    Cone { slope: f64, offsets: [f64; 2] },
}

impl From<Cylinder> for Hybrid {
    fn from(Cylinder { z, w }: Cylinder) -> Self {
        Self { z, wall: Wall::Cylinder { w } }
    }
}

impl From<Cone> for Hybrid {
    fn from(Cone { z, slope, offsets }: Cone) -> Self {
        Self { z, wall: Wall::Cone { slope, offsets } }
    }
}

impl Hybrid {
    /// The shell of the smaller area (criterion 1), where the area of a cone shell counts
    /// `cone_weight` times.
    pub(crate) fn least_area(pieces: &[Piece], radius: f64, cone_weight: f64) -> Self {
        let cylinder = Cylinder::around(pieces, radius);
        match Cone::around(pieces, radius) {
            Some(cone) if cone_weight * cone.area() < cylinder.area() => cone.into(),
            _ => cylinder.into(),
        }
    }

    /// The shell with the smaller intersection interval (criterion 2), on average over lines through
    /// the cylinder shell: their points are spread evenly over its section, their directions over
    /// the sphere, and the interval's length is measured along the axis, as the paper does.
    pub(crate) fn least_interval(pieces: &[Piece], radius: f64) -> Self {
        let cylinder = Cylinder::around(pieces, radius);
        let Some(cone) = Cone::around(pieces, radius) else { return cylinder.into() };
        let (mut of_cylinder, mut of_cone) = (0.0, 0.0);
        for ray in lines_through(&cylinder) {
            let length = |shell: &dyn Shell| -> f64 {
                let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
                let intervals = shell.meet(&ray, everywhere).map(|s| shell.intervals(&ray, s));
                intervals.iter().flat_map(Intervals::iter).map(|[a, b]| b - a).sum()
            };
            of_cylinder += length(&cylinder) * ray.dz.abs();
            of_cone += length(&cone) * ray.dz.abs();
        }
        if of_cone < of_cylinder { cone.into() } else { cylinder.into() }
    }
}

/// Lines through the section of a cylinder shell, the same at every run.
fn lines_through(shell: &Cylinder) -> impl Iterator<Item = Meridian> {
    use crate::Vec3;
    use core::f64::consts::TAU;
    /// Enough that the two sums differ by more than their sampling error where it matters.
    const LINES: u32 = 128;
    /// Roberts' R3 sequence: the powers of the inverse of the root of x^4 = x + 1.
    const STEPS: [f64; 3] =
        [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_996_9];
    let (z, r) = (shell.z, shell.w.map(|w| w.max(0.0).sqrt()));
    (1..=LINES).map(move |i| {
        let [a, b, c] = STEPS.map(|step| (f64::from(i) * step).fract());
        // The height within the section shares a coordinate with the turn; both are spread evenly.
        let d = (f64::from(i) * 0.5 / f64::from(LINES) + a * 0.5).fract();
        let origin = Vec3::new(r[0] + (r[1] - r[0]) * a, 0.0, z[0] + (z[1] - z[0]) * b);
        let up = 2.0 * c - 1.0;
        let across = (1.0 - up * up).sqrt();
        let (sin, cos) = (TAU * d).sin_cos();
        Meridian::new(origin, Vec3::new(across * cos, across * sin, up))
    })
}

impl Shell for Hybrid {
    #[inline]
    fn meet(&self, ray: &Meridian, range: [f64; 2]) -> Option<[f64; 2]> {
        let stretch = slab(self.z, ray, range)?;
        let met = match self.wall {
            Wall::Cylinder { w } => between_cylinders(w, ray, stretch),
            Wall::Cone { slope, offsets } => between_cones(slope, offsets, ray, stretch),
        };
        met.then_some(stretch)
    }

    fn intervals(&self, ray: &Meridian, stretch: [f64; 2]) -> Intervals {
        match self.wall {
            Wall::Cylinder { w } => cylinder_intervals(w, ray, stretch),
            Wall::Cone { slope, offsets } => cone_intervals(slope, offsets, ray, stretch),
        }
    }
}

//! The hybrid shell, HY (paper, sections 3.3 and 4.1.2): in every node a cylinder or a cone shell,
//! whichever fits.
//!
//! A cylinder is a cone of slope 0. With both written as cones, a search through a hybrid tree does
//! not have to find out which of the two comes next.

use core::f64::consts::TAU;

use super::{Cone, Intervals, Shell};
use crate::Vec3;
use crate::meridian::Meridian;
use crate::piece::Piece;

/// The shell of the smaller area (criterion 1), where the area of a true cone shell counts
/// `cone_weight` times.
pub(crate) fn least_area(pieces: &[Piece], radius: f64, cone_weight: f64) -> Cone {
    let upright = Cone::upright(pieces, radius);
    match Cone::around(pieces, radius) {
        Some(cone) if cone_weight * cone.area() < upright.area() => cone,
        _ => upright,
    }
}

/// The shell with the smaller intersection interval (criterion 2), on average over lines through the
/// cylinder shell: their points are spread evenly over its section, their directions over the
/// sphere, and the interval's length is measured along the axis, as the paper does.
pub(crate) fn least_interval(pieces: &[Piece], radius: f64) -> Cone {
    let upright = Cone::upright(pieces, radius);
    let Some(cone) = Cone::around(pieces, radius) else { return upright };
    let (mut of_upright, mut of_cone) = (0.0, 0.0);
    for ray in lines_through(&upright) {
        let length = |shell: &Cone| -> f64 {
            let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
            let intervals = shell.meet(&ray, everywhere).map(|s| shell.intervals(&ray, s));
            intervals.iter().flat_map(Intervals::iter).map(|[a, b]| b - a).sum()
        };
        of_upright += length(&upright) * ray.dz.abs();
        of_cone += length(&cone) * ray.dz.abs();
    }
    if of_cone < of_upright { cone } else { upright }
}

/// Lines through the section of a cylinder shell, the same at every run.
fn lines_through(shell: &Cone) -> impl Iterator<Item = Meridian> {
    /// Enough that the two sums differ by more than their sampling error where it matters.
    const LINES: u32 = 128;
    /// Roberts' R3 sequence: the powers of the inverse of the root of x^4 = x + 1.
    const STEPS: [f64; 3] =
        [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_996_9];
    let (z, r) = (shell.z, shell.offsets);
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

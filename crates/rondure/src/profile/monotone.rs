//! Where r or z turns.

use super::Segment;

pub(crate) fn turning_parameters_of_r(segment: &Segment) -> impl Iterator<Item = f64> {
    let _ = segment;
    core::iter::empty()
}

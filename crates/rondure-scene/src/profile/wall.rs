//! The thickness of a profile: its wall, or what is wrong with it.

use rondure::{
    Profile, ProfileErrorKind,
    profile::{Rim, Side, Thickness},
};

use crate::Diagnostic;

/// The sides on which a wall can be, by name.
pub(crate) const SIDES: [(&str, Side); 3] =
    [("inward", Side::Inward), ("outward", Side::Outward), ("centered", Side::Centered)];

/// The ends that a wall can have, by name.
pub(crate) const RIMS: [(&str, Rim); 2] = [("flat", Rim::Flat), ("round", Rim::Round)];

/// The wall along a profile.
pub(crate) fn thicken(profile: &Profile, wall: &Thickness) -> Result<Profile, Diagnostic> {
    profile.thickened(wall).map_err(|error| {
        let help = match error.kind {
            ProfileErrorKind::WallFolds { .. } => match wall.side {
                Side::Centered => "make the wall thinner, or the bend wider",
                _ => "make the wall thinner or the bend wider, or put the wall on the other side",
            },
            ProfileErrorKind::WallCorner { .. } => {
                "make the wall thinner or the corner flatter, or put the wall on the other side"
            }
            ProfileErrorKind::WallCrossesAxis { .. } => {
                "a wall reaches the axis only at an end of the profile; make it thinner, or draw the \
                 solid part as an outline of its own"
            }
            ProfileErrorKind::WallOverlaps { .. } => {
                "make the wall thinner, or the gap between the parts wider"
            }
            _ => "the thickness is the distance from one side of the wall to the other",
        };
        Diagnostic::error(error.to_string()).help(help)
    })
}

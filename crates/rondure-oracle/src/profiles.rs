//! The standard profiles of the repository, and the solids that some of them draw.

use rondure::Profile;

use crate::closed_form::Solid;

macro_rules! standard {
    ($($name:literal),*) => {
        /// The standard profiles as path data, by name.
        pub const STANDARD: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../profiles/", $name, ".path")))),*];
    };
}

standard!("column", "cone", "cylinder", "goblet", "pawn", "sphere", "torus", "vase");

/// A standard profile.
///
/// # Panics
///
/// If there is none of this name.
pub fn standard(name: &str) -> Profile {
    let found = STANDARD.iter().find(|(n, _)| *n == name);
    match found.map(|(_, text)| Profile::from_path_data(text)) {
        Some(Ok(profile)) => profile,
        other => unreachable!("the standard profile {name}: {other:?}"),
    }
}

/// The standard profiles that draw solids with an equation.
pub const SOLIDS: [(&str, Solid); 4] = [
    ("sphere", Solid::Sphere { radius: 1.0 }),
    ("cone", Solid::Cone { radius: 1.0, height: 2.0 }),
    ("cylinder", Solid::Cylinder { radius: 1.0, height: 2.0 }),
    ("torus", Solid::Torus { major: 2.0, minor: 1.0 }),
];

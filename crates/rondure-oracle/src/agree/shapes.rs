//! The shapes on which engines must agree: the standard profiles, and nasty ones.

use rondure::{Profile, ProfileError, profile::PlaneMap};

use crate::profiles::STANDARD;

/// A profile with a name for tables.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Without spaces.
    pub name: String,
    /// What is swept.
    pub profile: Profile,
}

/// Path data of profiles with what engines find hard.
const NASTY: &[(&str, &str)] = &[
    (
        "subpaths",
        "M 1 0 C 3 2 -0.5 2 2 0 Z M 4 1 L 5 1.0000000001 L 5 3 Q 3 2 4 1 M 0 4 A 3 1 20 1 1 0 6",
    ),
    ("crossing", "M 0 0 C 3 1 -1 1 1 0 L 0.2 1.5 L 0 1.5"),
    ("folding", "M 0 0 L 1 0 C 1 1 0.5 1.5 0.8 0.5 C 1 0 0.3 0.2 0.3 1 L 0 1"),
    ("level", "M 0 0 L 1 0 L 1 0.1 L 0.1 0.1 L 0.1 1 L 0.4 1 L 0.4 1.5 L 0 1.5"),
    ("nearly-level", "M 0 0 L 1 1e-9 L 1 1 C 0.7 1.0000001 0.4 1 0 1.00000001"),
    ("ellipses", "M 2 0 A 1 0.4 30 1 1 1.5 0.7 Z M 0 -1 A 2 1 0 0 1 0 1"),
    ("cusp", "M 0 0 C 2 1 -0.2 1 1 0 L 1 -1 L 0 -1"),
    ("poles", "M 0 0 C 0.7 0 1 0.5 1 1 C 1 1.6 0.6 2 0 2 M 0 3 L 1 4 Q 0.2 4.2 0 5"),
    ("axis-touched", "M 1 0 Q -1 1 1 2 L 1 0 Z M 0 3 L 1 3.5 L 0 4 L 1 4.5 L 0 5"),
    ("open-bowl", "M 0.2 0 Q 1 0.1 1.2 1"),
    (
        "tiny-segments",
        "M 0 0 L 1 0 L 1 1e-17 L 1 2e-17 L 1 0.5 Q 1 0.50000000000000011 0.9999999999999999 0.5 L 0 1",
    ),
];

/// How many points the polyline has.
const POINTS: u32 = 1000;

/// All shapes, the standard ones first.
///
/// # Errors
///
/// None, as long as the profiles in the repository are sound.
pub fn shapes() -> Result<Vec<Shape>, ProfileError> {
    let mut shapes = Vec::new();
    for (name, text) in STANDARD.iter().chain(NASTY) {
        shapes.push(Shape { name: (*name).into(), profile: Profile::from_path_data(text)? });
    }
    shapes.push(Shape { name: "polyline".into(), profile: polyline()? });
    for (name, base, map) in [
        ("vase-1e-6", "vase", PlaneMap::scale(1e-6, 1e-6)),
        ("goblet-1e6", "goblet", PlaneMap::scale(1e6, 1e6)),
        ("pawn-far", "pawn", PlaneMap::translate(0.0, 1e6)),
    ] {
        for (_, text) in STANDARD.iter().filter(|(name, _)| *name == base) {
            let profile = Profile::builder().path_data(text)?.map(&map).build()?;
            shapes.push(Shape { name: name.into(), profile });
        }
    }
    Ok(shapes)
}

/// A wave of many straight edges between two poles.
fn polyline() -> Result<Profile, ProfileError> {
    let mut path = Profile::builder().move_to(0.0, 0.0);
    for i in 1..POINTS - 1 {
        let z = f64::from(i) / f64::from(POINTS - 1);
        path = path.line_to(0.3 + 0.12 * (7.0 * z).sin() + 0.05 * (17.0 * z).sin(), z);
    }
    path.line_to(0.0, 1.0).build()
}

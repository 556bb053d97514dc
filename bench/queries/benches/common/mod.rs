//! The shapes and the rays of both benchmarks.

#[path = "../../../../crates/rondure/examples/rays/mod.rs"]
mod rays;

use rondure::{Profile, Ray, Surface};

/// The standard shapes, of 4, 12, 32 and 128 segments.
pub(crate) const SHAPES: [(&str, &str); 4] = [
    ("vase", include_str!("../../../../profiles/vase.path")),
    ("goblet", include_str!("../../../../profiles/goblet.path")),
    ("pawn", include_str!("../../../../profiles/pawn.path")),
    ("column", include_str!("../../../../profiles/column.path")),
];

/// The profile of a standard shape.
pub(crate) fn profile(shape: &str) -> Profile {
    let (_, path) = SHAPES.into_iter().find(|(name, _)| *name == shape).expect("a standard shape");
    Profile::from_path_data(path).expect("a good profile")
}

/// Rays of a pinhole camera that sees a standard shape, row by row, about `count` of them.
pub(crate) fn camera_rays(count: u32) -> Vec<Ray> {
    rays::camera_rays([count.isqrt(); 2])
}

/// Rays from the sphere round the surface to points in its box.
pub(crate) fn random_rays(surface: &Surface, count: u32) -> Vec<Ray> {
    rays::random_rays(&surface.bounds(), count as usize)
}

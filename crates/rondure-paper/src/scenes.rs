//! The two scenes: the same 24 turned objects on a table, matte and mirroring.

use std::path::Path;

use rondure_scene::{Report, Scene, parse_scene};

/// The head of the scene without specular reflection, its objects left out.
pub const MATTE: &str = include_str!("../scenes/matte.toml");
/// The head of the scene with specular reflection.
pub const MIRROR: &str = include_str!("../scenes/mirror.toml");
/// The objects of both.
pub const OBJECTS: &str = include_str!("../scenes/objects.toml");

/// Reads one of the scenes.
///
/// # Errors
/// What is wrong with its text; nothing is, unless the language of scenes has changed.
pub fn read(name: &str, head: &str) -> Result<Scene, Report> {
    let text = format!("{head}\n{OBJECTS}");
    parse_scene(name, &text, Path::new(".")).map(|(scene, _)| scene)
}

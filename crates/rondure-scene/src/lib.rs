//! Scene and profile files: text in, a typed [`Scene`] or a [`Report`] out.
//!
//! [`read_scene`] reads a scene with all that it refers to, [`read_profile`] a profile alone. Both
//! collect all that is wrong before they give up.

mod body;
mod color;
mod copies;
mod decode;
mod diagnostic;
mod digest;
mod engine;
mod file;
mod image;
mod journey;
mod model;
mod paint;
mod profile;
mod scene;

pub use body::{Body, Cut, Section};
pub use copies::{Area, Copies, Motion, Pattern, Series, Variation};
pub use diagnostic::{Diagnostic, Label, Report, Severity, Source};
pub use digest::scene_digest;
pub use file::LARGEST_FILE;
pub use image::Image;
pub use journey::Key;
pub use model::*;
pub use paint::*;
pub use profile::{ProfileFormat, ProfileOptions, Unit, parse_profile, read_profile};
pub use scene::{parse_scene, read_scene};

//! Scene and profile files: text in, a typed [`Scene`] or a [`Report`] out.
//!
//! [`read_scene`] reads a scene with all that it refers to, [`read_profile`] a profile alone. Both
//! collect all that is wrong before they give up.

mod diagnostic;
mod file;
mod model;
mod profile;

pub use diagnostic::{Diagnostic, Label, Report, Severity, Source};
pub use file::LARGEST_FILE;
pub use model::*;
pub use profile::{ProfileFormat, ProfileOptions, Unit, parse_profile, read_profile};

//! Scene and profile files: text in, a typed [`Scene`] or a list of diagnostics out.

mod model;

pub use model::*;

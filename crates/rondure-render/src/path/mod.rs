//! Paths.
mod media;

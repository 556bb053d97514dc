//! What is done with pictures once their light is known: plain grids of linear light in, signals,
//! figures and cleaner pictures out. Nothing here knows of scenes or rays.
//!
//! [`Look`] turns light into what a screen shows, by a [`View`]; [`png`] writes that into a file and reads it back.
//! [`error`] and [`mod@flip`] tell how far two pictures are apart.

#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "`!(a > b)` counts a NaN as no, which is what pixels need"
)]

pub mod color_map;
pub mod denoise;
pub mod error;
pub mod file;
pub mod flip;
mod image;
mod matrix;
pub mod pfm;
pub mod png;
mod signals;
pub mod tone;
mod view;
mod white;

pub use image::{Image, SizeError};
pub use signals::{Depth, Signals};
pub use view::{Look, View};
pub use white::{White, WhiteError};

//! From a [`Scene`](rondure_scene::Scene) to a [`Picture`], in the manner of Whitted: direct light
//! with shadows, highlights, reflection and refraction.
//!
//! [`render()`] takes the scene; [`Picture::write_png`] writes what comes out. A [`Job`] makes single tiles, [`Work`] a portion of a picture that can be
//! stopped and gone on with. `gather` takes the objects.
//! The light goes this way: `sampler`, `filter` and `camera` make a ray; `world` finds what it meets, through
//! `things`, `bodies` and `shape`; `integrator` adds up the light there from `light` by the laws of `finish`,
//! `coat` and `fresnel`; `job` gathers the samples of a tile, `work` the tiles,
//! and `look` and `picture` make a file of them.

#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "`!(a > b)` counts a NaN as no, which is what the numbers of rays need"
)]

mod adaptive;
mod bodies;
mod bsdf;
mod camera;
mod coat;
mod color;
mod environment;
mod features;
mod few;
mod filter;
mod finish;
mod fresnel;
mod gather;
mod integrator;
mod job;
mod light;
mod look;
mod numbers;
mod optics;
mod path;
mod picture;
mod render;
mod sampler;
mod shape;
mod texture;
mod things;
mod warp;
mod work;
mod world;

pub use adaptive::EDGE as NOISE_BLOCK;
pub use job::{Job, Prepared, TileSums};
pub use look::look;
pub use picture::{Picture, WriteError, write_png};
pub use render::{Progress, RenderError, Settings, render};
pub use rondure_film::Statistics;
pub use work::{Outcome, Snapshot, Work};

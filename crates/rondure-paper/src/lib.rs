//! The measurements of the paper, made again: Wang, Zhu, Gu 2008, "Quick Ray Tracing Algorithm Based
//! on Surfaces of Revolution".
//!
//! [`measure()`] renders two scenes of the same objects, one without and one with specular reflection,
//! with the methods KJ, CY, CO and HY, each with its monotone intervals subdivided and not, and
//! returns a [`Report`]: the paper's Tables 1 and 2, the pictures, and [`figures`] drawn from the data
//! structures. With [`Options::ablate`] it also measures, on bare rays, what single choices are worth
//! ([`ablation`]).

pub mod ablation;
pub mod figures;
mod measure;
mod published;
mod report;
pub mod scenes;
mod svg;

pub use measure::{Measured, Options, PaperError, Run, measure};
pub use report::{Report, WriteError};

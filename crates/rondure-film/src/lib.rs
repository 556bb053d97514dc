//! The film: sums of light that come out the same, bit for bit, however the work was cut up.
//!
//! A [`Film`] takes samples of the pixels in its [`Window`], and other films of parts of it. Its sums ([`Sum`]) are exact, so that no order
//! of adding changes a bit. [`Pass`] says in which ranges the samples of a picture are taken, [`Portion`] names some of them.
//! A [`Spool`] keeps the sums of a picture that may be larger than the memory. A [`Share`] knows which samples its sums have, and of what picture
//! ([`Recipe`]); it can be kept in a file, and [`Merge`] puts shares together. [`write_exr`] writes all layers.

mod exr;
mod film;
mod pass;
mod portion;
mod recipe;
mod record;
mod share;
mod share_file;
mod spool;
mod statistics;
mod sum;
mod window;

pub use exr::{ExrError, ExrPicture, write_exr};
pub use film::{Center, Film, FilmError, Guide, LARGEST, Layers, MOST_SAMPLES, PixelSample};
pub use pass::Pass;
pub use portion::Portion;
pub use recipe::Recipe;
pub use share::{Merge, MergeError, Share};
pub use share_file::{ShareError, ShareRef};
pub use spool::{Room, Spool, SpoolError};
pub use statistics::Statistics;
pub use sum::Sum;
pub use window::Window;

//! The film: sums of light that come out the same, bit for bit, however the work was cut up.
//!
//! A [`Film`] takes samples of the pixels in its [`Window`], and other films of parts of it. Its sums ([`Sum`]) are exact, so that no order
//! of adding changes a bit. [`Pass`] says in which ranges the samples of a picture are taken, [`Portion`] names some of them.

mod film;
mod pass;
mod portion;
mod statistics;
mod sum;
mod window;

pub use film::{Center, Film, FilmError, Guide, LARGEST, Layers, MOST_SAMPLES, PixelSample};
pub use pass::Pass;
pub use portion::Portion;
pub use statistics::Statistics;
pub use sum::Sum;
pub use window::Window;

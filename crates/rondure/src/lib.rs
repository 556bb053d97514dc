//! Exact ray tracing of surfaces of revolution.
//!
//! A [`Profile`] is swept round the z axis; the [`Surface`] built from it answers rays in f64:
//! closest hit, any hit, all hits, and on demand the point, the normal, the parameters and the
//! partial derivatives there. An [`Instance`] places a shared surface in the world.

mod affine;
mod bounds;
mod instance;
pub mod numeric;
pub mod profile;
mod surface;
mod vector;

pub use affine::Affine;
pub use bounds::Bounds;
pub use instance::Instance;
pub use profile::{Point, Profile, ProfileError, ProfileErrorKind, Segment, Spline};
pub use surface::{Hit, Interaction, Surface};
pub use vector::{Ray, Vec3};

//! Exact ray tracing of surfaces of revolution.
//!
//! A [`Profile`] is swept round the z axis; the [`Surface`] built from it answers rays in f64:
//! closest hit, any hit, all hits, and on demand the point, the normal, the parameters and the
//! partial derivatives there. An [`Instance`] places a shared surface in the world; an [`Assembly`]
//! holds up to millions of them. An [`AreaSampler`] chooses points evenly by area. A [`Solid`] is what a closed profile bounds: stretches of rays, inside
//! tests, signed distances.
//!
//! ```
//! # fn main() -> Result<(), rondure::ProfileError> {
//! use rondure::{Profile, Ray, Surface, Vec3};
//!
//! let torus = Profile::from_path_data("M 3 0 A 1 1 0 0 1 1 0 A 1 1 0 0 1 3 0 Z")?;
//! let torus = Surface::new(&torus);
//! let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X);
//! let mut hits = Vec::new();
//! torus.all(&ray, &mut hits);
//! assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<_>>(), [2.0, 4.0, 6.0, 8.0]);
//! # Ok(())
//! # }
//! ```

mod affine;
mod arc_length;
mod area;
mod assembly;
mod batch;
mod bounds;
pub mod bvh;
pub mod engine;
mod frame;
mod instance;
mod instances;
mod interaction;
pub mod measure;
mod meridian;
pub mod numeric;
mod orientation;
mod piece;
mod pieces;
pub mod profile;
mod rings;
mod root;
mod shell;
pub mod solid;
mod surface;
mod vector;

pub use affine::Affine;
pub use area::{AreaSampler, SurfaceSample};
pub use assembly::{Assembly, Contact, Contacts};
pub use batch::{AllHits, Hits, RayColumns, Rays};
pub use bounds::Bounds;
pub use bvh::Bvh;
pub use engine::{EngineOptions, Method};
pub use instance::Instance;
pub use instances::{Instances, PlaceError, PlaceErrorKind};
pub use interaction::{Footing, Interaction};
pub use measure::Measure;
pub use profile::{Point, Profile, ProfileError, ProfileErrorKind, Segment, Spline};
pub use solid::{FillRule, Solid};
pub use surface::{Hit, Surface};
pub use vector::{Ray, Vec3};

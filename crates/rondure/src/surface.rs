//! The surface of revolution and the questions that can be asked of it.

use crate::{Bounds, Profile, Ray, Vec3};

/// Where a ray meets a surface: the cheap answer, from which [`Surface::interaction`] makes the
/// full one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter, in units of the ray's direction.
    pub t: f64,
    /// The piece of the profile that was hit.
    pub piece: u32,
    /// The parameter on that piece, from 0 to 1.
    pub s: f64,
}

/// Everything about the surface at a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interaction {
    /// The point, on the surface to within [`error`](Self::error).
    pub point: Vec3,
    /// The geometric normal, of unit length. It points out of a solid; on an open profile to the
    /// right of the drawing direction, r to the right and z up: outwards if drawn upwards.
    pub normal: Vec3,
    /// u, the angle round the axis over 2 pi, in [0, 1), and v, the fraction of the profile's arc
    /// length, in [0, 1].
    pub uv: [f64; 2],
    /// The partial derivative of the point by u.
    pub dp_du: Vec3,
    /// The partial derivative of the point by v.
    pub dp_dv: Vec3,
    /// A bound on how far rounding can have moved [`point`](Self::point) off the surface.
    pub error: f64,
}

impl Interaction {
    /// The ray that leaves the surface here: its origin lies off the surface by the error bound, on
    /// the side to which `direction` points, so that it cannot hit the place that it leaves.
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let _ = direction;
        unimplemented!()
    }
}

/// A surface of revolution, ready for rays: built once from a [`Profile`], then immutable.
///
/// The axis of revolution is the z axis. Rays whose origin or direction is not finite, or whose
/// direction is zero, hit nothing.
#[derive(Clone, Debug)]
pub struct Surface {
    profile: Profile,
}

impl Surface {
    /// Builds the engine for a profile.
    pub fn new(profile: &Profile) -> Self {
        Self { profile: profile.clone() }
    }

    /// The profile that the surface was built from.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The hit with the smallest t in the ray's range, if there is one.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let _ = ray;
        unimplemented!()
    }

    /// Whether there is any hit in the ray's range.
    pub fn any(&self, ray: &Ray) -> bool {
        let _ = ray;
        unimplemented!()
    }

    /// All hits in the ray's range, in order of t. `hits` is cleared first.
    ///
    /// If the profile [bounds a solid](Profile::bounds_solid), a whole line has an even number of
    /// hits. A tangency counts as two hits or as none.
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        let _ = (ray, hits);
        unimplemented!()
    }

    /// The full answer for a hit that this surface reported for this ray.
    pub fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let _ = (ray, hit);
        unimplemented!()
    }

    /// The box round the surface.
    pub fn bounds(&self) -> Bounds {
        unimplemented!()
    }
}

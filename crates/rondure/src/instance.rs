//! One object in many places: a surface shared by placed instances.

use std::sync::Arc;

use crate::{Affine, Bounds, Hit, Interaction, Ray, Surface};

/// A surface placed in the world by an affine map: moved, turned, scaled, mirrored or sheared.
#[derive(Clone, Debug)]
pub struct Instance {
    surface: Arc<Surface>,
    placement: Affine,
}

impl Instance {
    /// Places a surface; `None` if the placement has no finite inverse.
    pub fn new(surface: Arc<Surface>, placement: Affine) -> Option<Self> {
        placement.inverse_rows()?;
        Some(Self { surface, placement })
    }

    /// The surface in its own frame.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// The map from the surface's frame to the world.
    pub fn placement(&self) -> &Affine {
        &self.placement
    }

    /// The hit with the smallest t in the range of a ray in the world; see [`Surface::closest`].
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let _ = ray;
        unimplemented!()
    }

    /// Whether there is any hit in the range of a ray in the world.
    pub fn any(&self, ray: &Ray) -> bool {
        let _ = ray;
        unimplemented!()
    }

    /// All hits in the range of a ray in the world, in order of t; see [`Surface::all`].
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        let _ = (ray, hits);
        unimplemented!()
    }

    /// The full answer for a hit, in the world; see [`Surface::interaction`].
    pub fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let _ = (ray, hit);
        unimplemented!()
    }

    /// The box round the placed surface, in the world.
    pub fn bounds(&self) -> Bounds {
        unimplemented!()
    }
}

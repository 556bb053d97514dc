//! One object in many places: a surface shared by placed instances.

use std::sync::Arc;

use crate::frame::Frame;
use crate::interaction::{Interaction, interaction, normal};
use crate::{
    Affine, AllHits, AreaSampler, Bounds, Hit, Hits, Ray, Rays, Surface, SurfaceSample, Vec3,
};

/// A surface placed in the world by an affine map: moved, turned, scaled, mirrored or sheared.
#[derive(Clone, Debug)]
pub struct Instance {
    surface: Arc<Surface>,
    placement: Affine,
    frame: Frame,
    rounding: f64,
}

impl Instance {
    /// Places a surface; `None` if the placement has no finite inverse.
    pub fn new(surface: Arc<Surface>, placement: Affine) -> Option<Self> {
        let frame = Frame::placed(surface.center_z, surface.radius, &placement)?;
        let rounding = surface.rounding(&placement);
        Some(Self { surface, placement, frame, rounding })
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
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.surface.closest_from(&self.frame, ray)
    }

    /// Whether there is any hit in the range of a ray in the world.
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        self.surface.any_from(&self.frame, ray)
    }

    /// All hits in the range of a ray in the world, in order of t; see [`Surface::all`].
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.surface.all_from(&self.frame, ray, hits);
    }

    /// The closest hits of many rays in the world; see [`Surface::closest_of_many`].
    pub fn closest_of_many(&self, rays: &Rays<'_>, hits: &mut Hits) {
        self.surface.closest_of_many_from(&self.frame, rays, hits);
    }

    /// Whether many rays in the world have any hit; see [`Surface::any_of_many`].
    pub fn any_of_many(&self, rays: &Rays<'_>, hits: &mut [bool]) {
        self.surface.any_of_many_from(&self.frame, rays, hits);
    }

    /// All hits of many rays in the world; see [`Surface::all_of_many`].
    pub fn all_of_many(&self, rays: &Rays<'_>, hits: &mut AllHits) {
        self.surface.all_of_many_from(&self.frame, rays, hits);
    }

    /// The full answer for a hit, in the world; see [`Surface::interaction`].
    pub fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        interaction(&self.surface, &self.frame, &self.placement, self.rounding, ray, hit)
    }

    /// The normal at a hit, in the world: that of [`interaction`](Self::interaction), alone.
    pub fn normal(&self, ray: &Ray, hit: &Hit) -> Vec3 {
        normal(&self.surface, &self.frame, ray, hit)
    }

    /// A point chosen evenly by the area of the surface in its own frame; see [`Surface::sample`]. Its
    /// density is by area in the world, and varies if the placement stretches some directions more than
    /// others: 1 / density is what each point stands for in an estimate.
    pub fn sample(&self, sampler: &AreaSampler, u: [f64; 2]) -> SurfaceSample {
        let inverse = self.frame.inverse();
        sampler.placed(&self.surface, &self.placement, inverse, self.rounding, u)
    }

    /// The density, by area in the world, with which [`sample`](Self::sample) chooses a place whose unit
    /// normal is `normal`, on whichever side.
    pub fn area_pdf(&self, sampler: &AreaSampler, normal: Vec3) -> f64 {
        sampler.placed_pdf(&self.placement, normal)
    }

    /// The box round the placed surface, in the world.
    pub fn bounds(&self) -> Bounds {
        self.surface.placed_bounds(&self.placement, self.rounding)
    }
}

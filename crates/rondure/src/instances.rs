//! Very many objects: placed surfaces in a form that takes some 200 bytes each.

use std::collections::TryReserveError;
use std::sync::Arc;

use crate::frame::Frame;
use crate::interaction::{Footing, Interaction, footing, interaction, normal};
use crate::{
    Affine, AllHits, AreaSampler, Bounds, Hit, Hits, Ray, Rays, Surface, SurfaceSample, Vec3,
};

/// Surfaces in many places, numbered in the order in which they were placed.
///
/// The same as that many [`Instance`](crate::Instance)s, in less memory. To find which of them a ray
/// meets, make an [`Assembly`](crate::Assembly) of them.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    shapes: Vec<Arc<Surface>>,
    /// What a ray needs, apart from what only a hit needs.
    places: Vec<Place>,
    placements: Vec<Affine>,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    frame: Frame,
    shape: u32,
    rounding: f64,
}

/// Why a surface cannot be placed.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceError {
    /// The number that the instance would have had.
    pub instance: usize,
    /// What is wrong with it.
    pub kind: PlaceErrorKind,
}

/// What is wrong with an instance.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlaceErrorKind {
    /// The placement has no finite inverse: it is flat, too large, too small or not finite.
    NotInvertible(Box<Affine>),
    /// There is no shape of this number.
    NoSuchShape {
        /// The number asked for.
        shape: u32,
        /// How many shapes there are.
        shapes: usize,
    },
    /// There are as many instances as a tree of boxes can have.
    TooMany,
}

impl core::fmt::Display for PlaceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "instance {}: ", self.instance)?;
        match &self.kind {
            PlaceErrorKind::NotInvertible(map) => {
                let Affine { columns: [x, y, z], translation: t } = &**map;
                write!(
                    f,
                    "the placement cannot be inverted in f64 arithmetic: it carries x to {}, y to {}, z to {} \
                 and the origin to {}; it must not be flat, and neither it nor its inverse too large",
                    Coordinates(x),
                    Coordinates(y),
                    Coordinates(z),
                    Coordinates(t)
                )
            }
            PlaceErrorKind::NoSuchShape { shape, shapes } => {
                write!(f, "there is no shape {shape}, only {shapes}, counted from 0")
            }
            PlaceErrorKind::TooMany => {
                write!(f, "at most {} instances can be placed", crate::bvh::MOST_ITEMS)
            }
        }
    }
}

impl core::error::Error for PlaceError {}

struct Coordinates<'a>(&'a Vec3);

impl core::fmt::Display for Coordinates<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "({:?}, {:?}, {:?})", self.0.x, self.0.y, self.0.z)
    }
}

impl Instances {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes a surface known and returns its number, which [`place`](Self::place) needs.
    pub fn add_shape(&mut self, surface: Arc<Surface>) -> u32 {
        self.shapes.push(surface);
        (self.shapes.len() - 1) as u32
    }

    /// Makes room for more instances.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn try_reserve(&mut self, additional: usize) -> Result<(), TryReserveError> {
        self.places.try_reserve_exact(additional)?;
        self.placements.try_reserve_exact(additional)
    }

    /// Places a surface: moved, turned, scaled, mirrored or sheared. Returns the instance's number.
    ///
    /// # Errors
    /// If the placement has no finite inverse, there is no such shape, or there are as many instances
    /// as a tree can have ([`MOST_ITEMS`](crate::bvh::MOST_ITEMS)).
    pub fn place(&mut self, shape: u32, placement: Affine) -> Result<u32, PlaceError> {
        let instance = self.places.len();
        let error = |kind| PlaceError { instance, kind };
        if instance >= crate::bvh::MOST_ITEMS {
            return Err(error(PlaceErrorKind::TooMany));
        }
        let shapes = self.shapes.len();
        let surface = self.shapes.get(shape as usize);
        let surface = surface.ok_or(error(PlaceErrorKind::NoSuchShape { shape, shapes }))?;
        let frame = Frame::placed(surface.center_z, surface.radius, &placement);
        let frame = frame.ok_or_else(|| error(PlaceErrorKind::NotInvertible(placement.into())))?;
        let rounding = surface.rounding_with(&placement, frame.inverse());
        self.places.push(Place { frame, shape, rounding });
        self.placements.push(placement);
        Ok(instance as u32)
    }

    /// The number of instances.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether nothing has been placed.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The surfaces, by their numbers.
    pub fn shapes(&self) -> &[Arc<Surface>] {
        &self.shapes
    }

    /// The bytes that the instances take, without their surfaces.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.places) + size_of_val(&*self.placements)
    }

    #[inline(always)]
    fn at(&self, instance: u32) -> (&Surface, &Frame) {
        let place = &self.places[instance as usize];
        (&self.shapes[place.shape as usize], &place.frame)
    }

    /// The surface of an instance.
    ///
    /// # Panics
    /// As all methods that take the number of an instance: if there is no such instance.
    pub fn surface(&self, instance: u32) -> &Arc<Surface> {
        &self.shapes[self.places[instance as usize].shape as usize]
    }

    /// The map from an instance's own frame to the world.
    pub fn placement(&self, instance: u32) -> &Affine {
        &self.placements[instance as usize]
    }

    /// The rows of the linear map from the world to an instance's own frame.
    pub fn inverse_rows(&self, instance: u32) -> [Vec3; 3] {
        self.at(instance).1.inverse().copied().unwrap_or(Affine::IDENTITY.columns)
    }

    /// The hit with the smallest t; see [`Surface::closest`].
    #[inline]
    pub fn closest(&self, instance: u32, ray: &Ray) -> Option<Hit> {
        let (surface, frame) = self.at(instance);
        surface.closest_from(frame, ray)
    }

    /// Whether there is any hit.
    #[inline]
    pub fn any(&self, instance: u32, ray: &Ray) -> bool {
        let (surface, frame) = self.at(instance);
        surface.any_from(frame, ray)
    }

    /// All hits in order of t; see [`Surface::all`]. `hits` is cleared first.
    pub fn all(&self, instance: u32, ray: &Ray, hits: &mut Vec<Hit>) {
        let (surface, frame) = self.at(instance);
        surface.all_from(frame, ray, hits);
    }

    /// The closest hits of many rays; see [`Surface::closest_of_many`].
    pub fn closest_of_many(&self, instance: u32, rays: &Rays<'_>, hits: &mut Hits) {
        let (surface, frame) = self.at(instance);
        surface.closest_of_many_from(frame, rays, hits);
    }

    /// Whether many rays have any hit; see [`Surface::any_of_many`].
    pub fn any_of_many(&self, instance: u32, rays: &Rays<'_>, hits: &mut [bool]) {
        let (surface, frame) = self.at(instance);
        surface.any_of_many_from(frame, rays, hits);
    }

    /// All hits of many rays; see [`Surface::all_of_many`].
    pub fn all_of_many(&self, instance: u32, rays: &Rays<'_>, hits: &mut AllHits) {
        let (surface, frame) = self.at(instance);
        surface.all_of_many_from(frame, rays, hits);
    }

    /// The full answer for a hit on an instance, in the world.
    pub fn interaction(&self, instance: u32, ray: &Ray, hit: &Hit) -> Interaction {
        let (surface, frame) = self.at(instance);
        let placement = self.placement(instance);
        interaction(surface, frame, placement, self.rounding(instance), ray, hit)
    }

    /// The place and the normal of a hit: those of [`interaction`](Self::interaction), alone.
    pub fn footing(&self, instance: u32, ray: &Ray, hit: &Hit) -> Footing {
        let (surface, frame) = self.at(instance);
        let placement = self.placement(instance);
        footing(surface, frame, placement, self.rounding(instance), ray, hit)
    }

    /// The normal at a hit: that of [`interaction`](Self::interaction), alone.
    pub fn normal(&self, instance: u32, ray: &Ray, hit: &Hit) -> Vec3 {
        let (surface, frame) = self.at(instance);
        normal(surface, frame, ray, hit)
    }

    /// A point of an instance chosen by area; see [`Instance::sample`](crate::Instance::sample).
    pub fn sample(&self, instance: u32, sampler: &AreaSampler, u: [f64; 2]) -> SurfaceSample {
        let (surface, frame) = self.at(instance);
        let (placement, rounding) = (self.placement(instance), self.rounding(instance));
        sampler.placed(surface, placement, frame.inverse(), rounding, u)
    }

    /// The density of [`sample`](Self::sample) at a place whose unit normal is `normal`; see
    /// [`Instance::area_pdf`](crate::Instance::area_pdf).
    pub fn area_pdf(&self, instance: u32, sampler: &AreaSampler, normal: Vec3) -> f64 {
        sampler.placed_pdf(self.placement(instance), normal)
    }

    /// The box round an instance, in the world.
    pub fn bounds(&self, instance: u32) -> Bounds {
        let surface = self.at(instance).0;
        surface.placed_bounds(self.placement(instance), self.rounding(instance))
    }

    #[inline]
    fn rounding(&self, instance: u32) -> f64 {
        self.places[instance as usize].rounding
    }
}

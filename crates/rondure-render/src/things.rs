//! All things that rays meet, by number: the turned ones first, then the simple shapes, in the order
//! in which they came.

use rondure::{Affine, Bounds, Footing, Hit, Hits, Instances, Interaction, Ray, Rays, Vec3};

use crate::{shape::Shape, texture::Own};

#[derive(Clone, Debug, Default)]
pub(crate) struct Things {
    pub(crate) turned: Instances,
    pub(crate) simple: Vec<Shape>,
}

/// A thing looked up.
enum Thing<'a> {
    Turned(u32),
    Simple(&'a Shape),
}

impl Things {
    pub(crate) fn len(&self) -> usize {
        self.turned.len() + self.simple.len()
    }

    #[inline(always)]
    fn at(&self, thing: u32) -> Thing<'_> {
        match (thing as usize).checked_sub(self.turned.len()) {
            None => Thing::Turned(thing),
            Some(i) => Thing::Simple(&self.simple[i]),
        }
    }

    /// Whether the thing has an inside, and its normals point out of it.
    pub(crate) fn is_solid(&self, thing: u32) -> bool {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.surface(i).bounds_solid(),
            Thing::Simple(shape) => shape.is_solid(),
        }
    }

    pub(crate) fn bounds(&self, thing: u32) -> Bounds {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.bounds(i),
            Thing::Simple(shape) => shape.bounds(),
        }
    }

    #[inline]
    pub(crate) fn closest(&self, thing: u32, ray: &Ray) -> Option<Hit> {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.closest(i, ray),
            Thing::Simple(shape) => shape.closest(ray),
        }
    }

    /// The same for many rays, if the thing is turned; says whether it is.
    pub(crate) fn closest_of_many(&self, thing: u32, rays: &Rays<'_>, hits: &mut Hits) -> bool {
        let Thing::Turned(i) = self.at(thing) else { return false };
        self.turned.closest_of_many(i, rays, hits);
        true
    }

    #[inline]
    pub(crate) fn any(&self, thing: u32, ray: &Ray) -> bool {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.any(i, ray),
            Thing::Simple(shape) => shape.closest(ray).is_some(),
        }
    }

    /// All hits in the ray's range, in order. `hits` is cleared first.
    pub(crate) fn all(&self, thing: u32, ray: &Ray, hits: &mut Vec<Hit>) {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.all(i, ray, hits),
            Thing::Simple(shape) => shape.all(ray, hits),
        }
    }

    /// The normal at a hit, alone.
    #[inline]
    pub(crate) fn normal(&self, thing: u32, ray: &Ray, hit: &Hit) -> Vec3 {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.normal(i, ray, hit),
            Thing::Simple(shape) => shape.interaction(ray, hit).normal,
        }
    }

    /// The place and the normal of a hit, alone.
    #[inline]
    pub(crate) fn footing(&self, thing: u32, ray: &Ray, hit: &Hit) -> Footing {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.footing(i, ray, hit),
            Thing::Simple(shape) => shape.footing(ray, hit),
        }
    }

    /// The full answer. On flat shapes (u, v) are lengths along the shape, from its centre.
    #[inline]
    pub(crate) fn interaction(&self, thing: u32, ray: &Ray, hit: &Hit) -> Interaction {
        match self.at(thing) {
            Thing::Turned(i) => self.turned.interaction(i, ray, hit),
            Thing::Simple(shape) => shape.interaction(ray, hit),
        }
    }

    /// The thing's own frame, at a place of it.
    #[inline]
    pub(crate) fn own(&self, thing: u32, at: &Interaction) -> Own {
        match self.at(thing) {
            Thing::Turned(i) => Own::new(*self.turned.placement(i), self.turned.inverse_rows(i)),
            Thing::Simple(Shape::Sphere(sphere)) => {
                Own::new(Affine::translate(sphere.center()), Affine::IDENTITY.columns)
            }
            Thing::Simple(_) => Own::flat(at),
        }
    }
}

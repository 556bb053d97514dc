//! What stands between a place and a lamp, and how much light it lets through.

use rondure::{Bvh, Ray};

use super::{Lists, Role, World};
use crate::{color::Rgb, fresnel};

impl World {
    /// Whether anything at all stands in the ray's range, lamps and clear glass among them.
    #[inline]
    pub(crate) fn is_occluded(&self, ray: &Ray) -> bool {
        let found = match &self.few {
            Some(Lists { all, .. }) => {
                all.flats().any(ray) || all.any(ray, |thing| self.things.any(thing, ray))
            }
            None => {
                [&self.blocking, &self.passing].into_iter().any(|tree| self.is_any_of(tree, ray))
            }
        };
        found || self.bodies.as_ref().is_some_and(|bodies| bodies.any(ray))
    }

    /// Whether the ray meets any thing of a tree.
    #[inline]
    fn is_any_of(&self, tree: &Bvh, ray: &Ray) -> bool {
        let mut found = false;
        tree.walk(ray, |thing| {
            found = self.things.any(thing, ray);
            if found { f64::NEG_INFINITY } else { ray.t_max }
        });
        found
    }

    /// The share of the light that passes along the ray's range: none if something opaque is in the
    /// way; clear glass is passed straight, without refraction, and takes what its two sides
    /// reflect and what its colour absorbs. Lamps never stand in the way. The ray's direction is of unit length.
    #[inline]
    pub(crate) fn transmittance(&self, ray: &Ray) -> Rgb {
        let Some(few) = &self.few else { return self.transmittance_by_trees(ray) };
        if few.shadows.flats().any(ray) {
            return Rgb::BLACK;
        }
        let met = few.shadows.met(ray);
        let mut blocking = few.shadows.things(met & few.blocking);
        if blocking.any(|thing| self.things.any(thing, ray)) {
            return Rgb::BLACK;
        }
        let passing = met & few.passing;
        if passing == 0 && self.bodies.is_none() {
            return Rgb::WHITE;
        }
        self.past_bodies(ray, few.shadows.things(passing))
    }

    #[inline(never)]
    fn transmittance_by_trees(&self, ray: &Ray) -> Rgb {
        if self.is_any_of(&self.blocking, ray) {
            return Rgb::BLACK;
        }
        // In the order of their numbers, so that sums do not depend on the tree.
        let mut met = Vec::new();
        if self.has_glass {
            self.passing.walk(ray, |thing| {
                if matches!(self.role(thing), Role::Surface { .. }) {
                    met.push(thing);
                }
                ray.t_max
            });
            met.sort_unstable();
        }
        self.past_bodies(ray, met.into_iter())
    }

    /// The same where no other thing blocks the light, past bodies and the things that are clear.
    #[inline(never)]
    fn past_bodies(&self, ray: &Ray, clear: impl Iterator<Item = u32>) -> Rgb {
        if self.bodies.as_ref().is_some_and(|b| b.blocks(ray, &self.finishes)) {
            return Rgb::BLACK;
        }
        if self.has_glass { self.clear_transmittance(ray, clear) } else { Rgb::WHITE }
    }

    /// All surfaces of glass count alike, in any order: no matter how bodies overlap.
    fn clear_transmittance(&self, ray: &Ray, things: impl Iterator<Item = u32>) -> Rgb {
        let mut passed = 1.0;
        // The optical depth is the sum of absorption times where a ray leaves less where it enters.
        let mut depth = Rgb::BLACK;
        let mut open = Rgb::BLACK;
        let mut hits = Vec::new();
        things.for_each(|thing| {
            self.things.all(thing, ray, &mut hits);
            if hits.is_empty() {
                return;
            }
            let Role::Surface { finish, solid } = self.role(thing) else { return };
            let (absorption, ior) = self.glass(finish);
            for hit in &hits {
                let cos = self.things.normal(thing, ray, hit).dot(ray.direction);
                // Seen from the air on both sides: straight through a pane, that is the truth.
                let reflectance = fresnel::from_air(cos.abs().min(1.0), ior);
                if solid {
                    passed *= 1.0 - reflectance;
                    let sign = 1.0_f64.copysign(cos);
                    depth += absorption * (sign * hit.t);
                    open += absorption * -sign;
                } else {
                    passed *= 1.0 - fresnel::sheet(reflectance);
                }
            }
        });
        if ray.t_max < f64::INFINITY {
            depth += open.map(|v| v.max(0.0)) * ray.t_max;
        }
        if let Some(bodies) = &self.bodies {
            let (share, more) = bodies.clear(ray, &self.finishes);
            passed *= share;
            depth = depth.map(|v| v.max(0.0)) + more;
        }
        transmitted(depth.map(|v| v.max(0.0))) * passed
    }
}

/// What an optical depth leaves of light.
#[inline]
pub(crate) fn transmitted(depth: Rgb) -> Rgb {
    if depth.is_black() { Rgb::WHITE } else { depth.map(|v| (-v).exp()) }
}

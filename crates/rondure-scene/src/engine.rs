//! Another engine for the turned objects of a scene.

use std::sync::Arc;

use rondure::engine::Statistics;
use rondure::solid::{Csg, Primitive};
use rondure::{EngineOptions, Instance, Solid, Surface};

use crate::{Scene, Shape};

impl Scene {
    /// Builds every turned object's surface anew with another engine. What shared a surface before
    /// shares one again.
    pub fn set_engine(&mut self, options: &EngineOptions) {
        let mut built: Vec<(Arc<Surface>, Arc<Surface>)> = Vec::new();
        let mut anew = |old: &Arc<Surface>| match built.iter().find(|(o, _)| Arc::ptr_eq(o, old)) {
            Some((_, new)) => Arc::clone(new),
            None => {
                let new = Arc::new(Surface::with_engine(old.profile(), options));
                built.push((Arc::clone(old), Arc::clone(&new)));
                new
            }
        };
        for object in &mut self.objects {
            match &mut object.shape {
                Shape::Turned(instance) | Shape::Swept { instance, .. } => {
                    let new = anew(instance.surface());
                    if let Some(placed) = Instance::new(new, *instance.placement()) {
                        *instance = placed;
                    }
                }
                Shape::Body(body) => {
                    let mut csg = Csg::clone(&body.csg);
                    each_solid_mut(&mut csg, &mut |solid| {
                        let new = Solid::from_surface(anew(solid.surface()), solid.fill_rule());
                        // The profile is the same, and bounds what it bounded.
                        if let Ok(new) = new {
                            *solid = Arc::new(new);
                        }
                    });
                    body.csg = Arc::new(csg);
                }
                Shape::Plane { .. }
                | Shape::Disk { .. }
                | Shape::Rectangle { .. }
                | Shape::Sphere { .. } => {}
            }
        }
    }

    /// The surfaces of the turned objects, each once.
    pub fn surfaces(&self) -> Vec<&Arc<Surface>> {
        let mut all: Vec<&Arc<Surface>> = Vec::new();
        for object in &self.objects {
            match &object.shape {
                Shape::Turned(instance) | Shape::Swept { instance, .. } => {
                    all.push(instance.surface());
                }
                Shape::Body(body) => each_solid(&body.csg, &mut |s| all.push(s.surface())),
                Shape::Plane { .. }
                | Shape::Disk { .. }
                | Shape::Rectangle { .. }
                | Shape::Sphere { .. } => {}
            }
        }
        let mut seen = std::collections::HashSet::new();
        all.retain(|surface| seen.insert(Arc::as_ptr(surface)));
        all
    }

    /// The work of all surfaces together, as far as it is [counted](EngineOptions::counted).
    pub fn engine_statistics(&self) -> Statistics {
        let counted = self.surfaces().into_iter().filter_map(|s| s.statistics());
        counted.fold(Statistics::default(), |sum, work| sum.plus(&work))
    }
}

/// Calls `f` with every turned solid of an expression.
fn each_solid<'a>(csg: &'a Csg, f: &mut impl FnMut(&'a Arc<Solid>)) {
    match csg {
        Csg::Primitive(Primitive::Turned(solid), _) => f(solid),
        Csg::Primitive(..) => {}
        Csg::Union(all) | Csg::Intersection(all) | Csg::Difference(all) => {
            all.iter().for_each(|operand| each_solid(operand, f));
        }
    }
}

fn each_solid_mut(csg: &mut Csg, f: &mut impl FnMut(&mut Arc<Solid>)) {
    match csg {
        Csg::Primitive(Primitive::Turned(solid), _) => f(solid),
        Csg::Primitive(..) => {}
        Csg::Union(all) | Csg::Intersection(all) | Csg::Difference(all) => {
            all.iter_mut().for_each(|operand| each_solid_mut(operand, f));
        }
    }
}

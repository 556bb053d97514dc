//! Another engine for the turned objects of a scene.

use std::sync::Arc;

use rondure::engine::Statistics;
use rondure::{EngineOptions, Instance, Surface};

use crate::{Scene, Shape};

impl Scene {
    /// Builds every turned object's surface anew with another engine. What shared a surface before
    /// shares one again.
    pub fn set_engine(&mut self, options: &EngineOptions) {
        let mut built: Vec<(Arc<Surface>, Arc<Surface>)> = Vec::new();
        for object in &mut self.objects {
            let Shape::Turned(instance) = &mut object.shape else { continue };
            let old = instance.surface();
            let new = match built.iter().find(|(known, _)| Arc::ptr_eq(known, old)) {
                Some((_, new)) => Arc::clone(new),
                None => {
                    let new = Arc::new(Surface::with_engine(old.profile(), options));
                    built.push((Arc::clone(old), Arc::clone(&new)));
                    new
                }
            };
            if let Some(placed) = Instance::new(new, *instance.placement()) {
                *instance = placed;
            }
        }
    }

    /// The surfaces of the turned objects, each once.
    pub fn surfaces(&self) -> Vec<&Arc<Surface>> {
        let mut all: Vec<&Arc<Surface>> = Vec::new();
        for object in &self.objects {
            let Shape::Turned(instance) = &object.shape else { continue };
            let own = instance.surface();
            if !all.iter().any(|known| Arc::ptr_eq(known, own)) {
                all.push(own);
            }
        }
        all
    }

    /// The work of all surfaces together, as far as it is [counted](EngineOptions::counted).
    pub fn engine_statistics(&self) -> Statistics {
        let counted = self.surfaces().into_iter().filter_map(|s| s.statistics());
        counted.fold(Statistics::default(), |sum, work| sum.plus(&work))
    }
}

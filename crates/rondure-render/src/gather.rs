//! Gathers what rays meet from the objects of a scene: things, and bodies where an object is a solid made of
//! others or the section crosses it.

use std::{collections::HashMap, sync::Arc};

use rondure::{
    Affine, Bounds, Surface,
    solid::{Csg, CsgError},
};
use rondure_scene::{Cut, Object, Section, Shape as Described};

use crate::{
    RenderError,
    bodies::{self, Knife, Left},
    shape::{Disk, Plane, Rectangle, Shape, Sphere},
    things::Things,
};

/// What rays meet.
#[derive(Default)]
pub(crate) struct Gathered {
    pub(crate) things: Things,
    /// The numbers of the surfaces that are known.
    surfaces: HashMap<*const Surface, u32>,
    /// For each turned thing, and each simple one, the index of its role.
    pub(crate) turned_roles: Vec<u32>,
    pub(crate) simple_roles: Vec<u32>,
    /// For each body the index of its object.
    pub(crate) body_objects: Vec<u32>,
    /// For each body where it was placed; `None` for flat shapes.
    pub(crate) body_placements: Vec<Option<Affine>>,
    pub(crate) bodies: bodies::Builder,
}

impl Gathered {
    /// Adds an object, the `role`-th of the scene.
    pub(crate) fn add(
        &mut self,
        object: &Object,
        role: u32,
        section: &[Section],
    ) -> Result<(), RenderError> {
        let knife = match object.section {
            Cut::Open { material } => Knife::new(section, material.map(|m| m as u32)),
            Cut::Whole => None,
        };
        if let (Described::Turned(instance), None) = (&object.shape, &knife) {
            let shape = self.shape(instance.surface());
            let turned = &mut self.things.turned;
            for motion in object.motions() {
                let placed = turned.place(shape, motion.map.after(instance.placement()));
                placed.map_err(|source| placement_error(object, source))?;
            }
            self.turned_roles.resize(turned.len(), role);
            return Ok(());
        }
        for shape in object.shapes().flatten() {
            self.add_shape(&shape, object, role, knife.as_ref())?;
            self.body_placements.resize(self.bodies.len(), placement(&shape));
        }
        self.body_objects.resize(self.bodies.len(), role);
        Ok(())
    }

    /// Adds one copy of an object, or what the knife leaves of it.
    fn add_shape(
        &mut self,
        shape: &Described,
        object: &Object,
        role: u32,
        knife: Option<&Knife<'_>>,
    ) -> Result<(), RenderError> {
        let finish = object.material as u32;
        let left = |bounds: &Bounds| knife.map_or(Left::All, |knife| knife.of(bounds));
        let added = match shape {
            Described::Turned(instance) => match (left(&instance.bounds()), knife) {
                (Left::Nothing, _) => Ok(()),
                (Left::Part, Some(knife)) => match self.bodies.solid(instance.surface()) {
                    Some(solid) => {
                        let csg = Csg::turned(solid).placed(instance.placement());
                        self.bodies.add_solid(csg, vec![None], finish, Some(knife))
                    }
                    None => {
                        self.bodies.add_turned_sheet(instance.clone(), None, finish, Some(knife))
                    }
                },
                _ => {
                    let number = self.shape(instance.surface());
                    let placed = self.things.turned.place(number, *instance.placement());
                    placed.map_err(|source| placement_error(object, source))?;
                    self.turned_roles.push(role);
                    Ok(())
                }
            },
            Described::Swept { instance, sweep } => {
                let knife = match left(&instance.bounds()) {
                    Left::Nothing => return Ok(()),
                    Left::All => None,
                    Left::Part => knife,
                };
                self.bodies.add_turned_sheet(instance.clone(), Some(sweep), finish, knife)
            }
            Described::Body(body) => {
                let finishes = body.materials.iter().map(|m| m.map(|m| m as u32)).collect();
                self.bodies.add_solid(body.placed(), finishes, finish, knife)
            }
            &Described::Sphere { center, radius } => {
                let sphere = Shape::Sphere(Sphere::new(center, radius));
                match (left(&sphere.bounds()), knife) {
                    (Left::Nothing, _) => Ok(()),
                    (Left::Part, Some(knife)) => {
                        let csg = Csg::sphere(center, radius);
                        self.bodies.add_solid(csg, vec![None], finish, Some(knife))
                    }
                    _ => {
                        self.add_simple(sphere, role);
                        Ok(())
                    }
                }
            }
            &Described::Plane { point, normal } => {
                self.add_flat(Shape::Plane(Plane::new(point, normal)), finish, role, knife)
            }
            &Described::Disk { center, normal, radius } => {
                self.add_flat(Shape::Disk(Disk::new(center, normal, radius)), finish, role, knife)
            }
            &Described::Rectangle { center, edges } => {
                self.add_flat(Shape::Rectangle(Rectangle::new(center, edges)), finish, role, knife)
            }
        };
        added.map_err(|source| RenderError::Solid { object: object.name.clone(), source })
    }

    fn add_flat(
        &mut self,
        shape: Shape,
        finish: u32,
        role: u32,
        knife: Option<&Knife<'_>>,
    ) -> Result<(), CsgError> {
        match knife.map(|knife| (knife, knife.of(&shape.bounds()))) {
            Some((_, Left::Nothing)) => Ok(()),
            Some((knife, Left::Part)) => self.bodies.add_simple_sheet(shape, finish, knife),
            Some((_, Left::All)) | None => {
                self.add_simple(shape, role);
                Ok(())
            }
        }
    }

    /// The number of a turned surface.
    fn shape(&mut self, surface: &Arc<Surface>) -> u32 {
        let known = self.surfaces.entry(Arc::as_ptr(surface));
        *known.or_insert_with(|| self.things.turned.add_shape(Arc::clone(surface)))
    }

    /// Makes room for so many turned things.
    pub(crate) fn reserve(&mut self, count: u64) -> Option<()> {
        let count = usize::try_from(count).ok()?;
        self.things.turned.try_reserve(count).ok()?;
        self.turned_roles.try_reserve_exact(count).ok()
    }

    pub(crate) fn add_simple(&mut self, shape: Shape, role: u32) {
        self.things.simple.push(shape);
        self.simple_roles.push(role);
    }
}

/// The map from a shape's own frame to the world; `None` for flat shapes.
fn placement(shape: &Described) -> Option<Affine> {
    match shape {
        Described::Turned(instance) | Described::Swept { instance, .. } => {
            Some(*instance.placement())
        }
        Described::Body(body) => Some(body.placement),
        Described::Sphere { center, .. } => Some(Affine::translate(*center)),
        Described::Plane { .. } | Described::Disk { .. } | Described::Rectangle { .. } => None,
    }
}

fn placement_error(object: &Object, source: rondure::PlaceError) -> RenderError {
    RenderError::Placement { object: object.name.clone(), source }
}

/// The materials that an object names.
pub(crate) fn materials(object: &Object) -> impl Iterator<Item = usize> {
    let own = match &object.shape {
        Described::Body(body) => &*body.materials,
        _ => &[],
    };
    let cut = match object.section {
        Cut::Open { material } => material,
        Cut::Whole => None,
    };
    own.iter().flatten().copied().chain(cut).chain([object.material])
}

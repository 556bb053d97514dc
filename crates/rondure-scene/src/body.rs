//! Solids made of others, and the planes that cut a scene open.

use std::sync::Arc;

use rondure::{Affine, Vec3, solid::Csg};

/// A solid made of others, placed in the world.
#[derive(Clone, Debug)]
pub struct Body {
    /// The expression, in the body's own frame.
    pub csg: Arc<Csg>,
    /// For each primitive of the expression, from left to right, the index of its material in
    /// [`Scene::materials`](crate::Scene::materials). The faces of a primitive without one have the
    /// material of the first primitive that holds the place and is not taken away, or else of the object.
    pub materials: Arc<[Option<usize>]>,
    /// The map to the world.
    pub placement: Affine,
}

impl Body {
    /// The expression in the world.
    pub fn placed(&self) -> Csg {
        Csg::clone(&self.csg).placed(&self.placement)
    }
}

/// A plane that cuts the scene open.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// A point of it.
    pub point: Vec3,
    /// The unit normal, to the side that is taken away.
    pub normal: Vec3,
    /// The index of the material of the faces where it cuts solids; if there is none, they have that of
    /// the solid.
    pub material: Option<usize>,
}

/// What the section of a scene does to an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// It is left whole.
    Whole,
    /// It is cut open.
    Open {
        /// The index of the material of the faces, before that of the section.
        material: Option<usize>,
    },
}

impl Default for Cut {
    fn default() -> Self {
        Self::Open { material: None }
    }
}

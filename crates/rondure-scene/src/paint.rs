//! Paints: colours over surfaces and through space, and reliefs, which turn normals.
//!
//! What is measured in space is measured in the object's own frame, before its placement: wood keeps its grain
//! when the object is moved, turned or scaled.

use std::sync::Arc;

use rondure::Vec3;

use crate::{Color, Image};

/// A colour over a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Paint {
    /// The same everywhere.
    Solid(Color),
    /// Squares of two colours: over the plane coordinates of planes, disks and rectangles in scene
    /// units from the object's centre; over (u, v) of turned objects and spheres.
    Checker {
        /// The two colours.
        colors: [Color; 2],
        /// The edge of a square: scene units, or fractions of u and v.
        size: [f64; 2],
    },
    /// Blocks of two colours in the object's own space.
    Blocks {
        /// The two colours.
        colors: [Color; 2],
        /// The edges of a block.
        size: Vec3,
    },
    /// A picture over the coordinates of [`Checker`](Self::Checker).
    Picture(Box<Picture>),
    /// A picture on a part of the wall.
    Label(Box<Sticker>),
    /// Wood.
    Wood(Box<Wood>),
    /// Marble.
    Marble(Box<Marble>),
}

/// A picture laid over (u, v).
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The picture; its rows run along u, its columns down v.
    pub sheet: Sheet,
    /// What is seen where the picture is not, or is not opaque.
    pub over: Paint,
}

/// An image and where it lies in (u, v).
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// The image.
    pub image: Arc<Image>,
    /// How much of u and v it takes.
    pub size: [f64; 2],
    /// Where its lower left corner lies.
    pub offset: [f64; 2],
    /// What lies beside it.
    pub wrap: Wrap,
}

/// What lies beside an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again and again.
    Repeat,
    /// Its outermost pixels.
    Clamp,
    /// Nothing.
    Once,
}

/// A picture that is stuck on a part of a wall, on its outer side.
#[derive(Clone, Debug, PartialEq)]
pub struct Sticker {
    /// The picture, upright.
    pub image: Arc<Image>,
    /// What its height is counted in.
    pub along: Along,
    /// Where its lower and its upper edge lie.
    pub range: [f64; 2],
    /// The angles round the axis of its left and right edge, counterclockwise seen from above; the second
    /// is larger, by a full turn at most.
    pub around: [f64; 2],
    /// What is seen beside it and through it.
    pub over: Paint,
}

/// A coordinate along a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// The height in the object's own frame. Walls that face the axis have no label.
    Z,
    /// The fraction of the profile's arc length.
    V,
    /// The arc length from the profile's start, in the object's own frame.
    Length,
}

/// Wood: rings round a pith, in the object's own space.
#[derive(Clone, Debug, PartialEq)]
pub struct Wood {
    /// The colour of wood grown in spring.
    pub early: Color,
    /// The colour of the dense wood at the end of a ring.
    pub late: Color,
    /// A point of the pith.
    pub pith: Vec3,
    /// The unit direction of the grain.
    pub axis: Vec3,
    /// The mean width of a ring.
    pub ring: f64,
    /// How far rings are from round and even, in widths of a ring.
    pub wobble: f64,
    /// The strength of fibres, from 0 to 1.
    pub fibre: f64,
    /// The strength of dark pores, from 0 to 1.
    pub pores: f64,
    /// The strength of bright flecks along the rays, from 0 to 1.
    pub rays: f64,
    /// If set, every copy is cut from another place; the number says which.
    pub seed: Option<u32>,
}

/// Marble: veins in the object's own space.
#[derive(Clone, Debug, PartialEq)]
pub struct Marble {
    /// The colours of the ground and of the veins.
    pub colors: [Color; 2],
    /// The distance of veins.
    pub size: f64,
    /// The unit direction across the veins.
    pub across: Vec3,
    /// How much they are folded: 0 for plane sheets.
    pub turbulence: f64,
    /// How thin they are: 1 for bands as wide as the ground.
    pub sharpness: f64,
    /// If set, every copy is cut from another place; the number says which.
    pub seed: Option<u32>,
}

/// What turns the normals that light sees. Heights are in the object's own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Relief {
    /// Heights over (u, v): black is 0.
    Bump {
        /// The heights, of which the mean of red, green and blue is taken.
        sheet: Sheet,
        /// The height of white.
        height: f64,
    },
    /// Dents and bumps of a size, in space.
    Noise {
        /// Their size.
        size: f64,
        /// How high they are.
        height: f64,
        /// If set, every copy has others; the number says which.
        seed: Option<u32>,
    },
    /// Normals over (u, v): red along u, green along v, blue outwards, one half for 0.
    Normals {
        /// The normals.
        sheet: Sheet,
        /// The factor on their slopes.
        strength: f64,
    },
}

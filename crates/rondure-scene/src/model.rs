//! The typed scene: what a scene file says, with everything looked up, checked and built.
//!
//! This tree is the border between reading and rendering. Lengths are in scene units, angles in
//! radians, colours linear Rec. 709 (sRGB primaries, no transfer curve).

use std::sync::Arc;

use rondure::{Instance, Vec3, solid::Sweep};

use crate::{Body, Copies, Cut, Image, Key, Motion, Paint, Relief, Section};

/// A linear colour or a radiance: red, green, blue.
pub type Color = [f64; 3];

/// A scene, ready to be rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The picture's size and quality.
    pub film: Film,
    /// The point of view.
    pub camera: Camera,
    /// The way of the camera for an animation, in order of time; often empty.
    pub keys: Vec<Key>,
    /// What rays see that hit nothing, and the light that comes from there.
    pub sky: Sky,
    /// The lights beside the sky.
    pub lights: Vec<Light>,
    /// The things in the scene.
    pub objects: Vec<Object>,
    /// The materials that the objects refer to.
    pub materials: Vec<Material>,
    /// The relief of each material, if it has one; those of the last ones may be missing.
    pub reliefs: Vec<Option<Relief>>,
    /// The planes that cut the scene open: what lies in front of all of them is taken away. Empty if it
    /// is not cut.
    pub section: Vec<Section>,
}

/// The picture's size and quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples in each pixel.
    pub spp: u32,
    /// How often light may be reflected or refracted on its way to the eye.
    pub depth: u32,
    /// Bits in each channel of the PNG: 8 or 16.
    pub bits: u8,
    /// The factor on the light before it is turned into a picture.
    pub exposure: f64,
    /// How light is followed.
    pub integrator: Integrator,
    /// How the light of a place in the picture counts for the pixels near it.
    pub filter: PixelFilter,
    /// How light of any strength becomes what a screen can show.
    pub view: ViewTransform,
    /// The light that shall look white; `None` if white shall.
    pub white: Option<WhiteBalance>,
}

/// What a scene has that says nothing of its film.
impl Default for Film {
    fn default() -> Self {
        Self {
            width: 800,
            height: 600,
            spp: 16,
            depth: 8,
            bits: 8,
            exposure: 1.0,
            integrator: Integrator::default(),
            filter: PixelFilter::default(),
            view: ViewTransform::Srgb,
            white: None,
        }
    }
}

/// How the light of a place in the picture counts for the pixels near it: a function of the distances across and down from the middle of the
/// pixel, the product of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelFilter {
    /// The function.
    pub kind: FilterKind,
    /// Where it ends, in pixels from the middle.
    pub radius: f64,
}

/// Blackman and Harris' window of 3 pixels.
impl Default for PixelFilter {
    fn default() -> Self {
        FilterKind::BlackmanHarris.usual()
    }
}

/// A function for a [`PixelFilter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FilterKind {
    /// The same everywhere.
    Box,
    /// A bell with a standard deviation of a third of the radius.
    Gaussian,
    /// A bell that ends without an edge (Harris 1978).
    BlackmanHarris,
    /// A bell with a dark rim, which makes edges crisp (Mitchell and Netravali 1988, B = C = 1/3).
    Mitchell,
}

impl FilterKind {
    /// All of them, with the names they have in scenes.
    pub const ALL: [(&'static str, Self); 4] = [
        ("box", Self::Box),
        ("gaussian", Self::Gaussian),
        ("blackman-harris", Self::BlackmanHarris),
        ("mitchell", Self::Mitchell),
    ];

    /// The filter with the radius that is usual for it.
    pub const fn usual(self) -> PixelFilter {
        let radius = match self {
            Self::Box => 0.5,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
        };
        PixelFilter { kind: self, radius }
    }
}

/// The name and the radius.
impl core::fmt::Display for PixelFilter {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let name = FilterKind::ALL.iter().find(|(_, kind)| *kind == self.kind);
        write!(f, "{} {}", name.map_or("", |(name, _)| name), self.radius)
    }
}

/// How light of any strength becomes what a screen can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ViewTransform {
    /// What is brighter than white is cut off.
    Srgb,
    /// AgX, as in Blender 4.
    AgX,
    /// The Khronos PBR Neutral tone mapper.
    Neutral,
}

/// The colour of a light that shall look white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhiteBalance {
    /// Its colour temperature, in kelvin.
    pub temperature: f64,
    /// How much greener it is than its temperature has it, in steps of 1/3000 in the (u, v) of CIE 1960.
    pub tint: f64,
}

/// The white of sRGB, D65.
impl Default for WhiteBalance {
    fn default() -> Self {
        Self { temperature: 6504.0, tint: 0.0 }
    }
}

/// How light is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// All ways that light can go: paths from the eye, and photons from the lamps for caustics.
    #[default]
    Path,
    /// The same by paths alone, none of which branches: without bias at any number of samples, but what comes from lamps by mirrors and
    /// glass, caustics, is found by chance, as sparks. For tests, and beside other renderers.
    Reference,
    /// Lights and their shadows, mirror images, and glass, for quick looks (Whitted 1980).
    Whitted,
}

impl Integrator {
    /// All of them, with the names they have in scenes.
    pub const ALL: [(&'static str, Self); 3] =
        [("path", Self::Path), ("reference", Self::Reference), ("whitted", Self::Whitted)];
}

/// The point of view.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub eye: Vec3,
    /// The point in the middle of the picture.
    pub look_at: Vec3,
    /// The direction that is up in the picture; not parallel to the view.
    pub up: Vec3,
    /// How space becomes a picture.
    pub projection: Projection,
    /// The lens, if things out of focus are to blur.
    pub lens: Option<Lens>,
}

/// How space becomes a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// From one point.
    Perspective {
        /// The vertical field of view, in radians.
        fov: f64,
    },
    /// Along parallel lines.
    Orthographic {
        /// The height of the picture in scene units.
        height: f64,
    },
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// The radius of the aperture.
    pub radius: f64,
    /// The distance from the eye to the plane in focus.
    pub focus: f64,
}

/// The light from all round.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same from every direction.
    Constant {
        /// The radiance.
        color: Color,
    },
    /// From the horizon to the zenith, by the sine of the height; below the horizon the third.
    Gradient {
        /// The radiance straight up.
        zenith: Color,
        /// The radiance at the horizon.
        horizon: Color,
        /// The radiance straight down.
        ground: Color,
    },
    /// A picture of all directions, twice as wide as high: the angle from straight up grows evenly
    /// with the rows from the top down, the angle round the z axis with the columns. Its middle lies at
    /// +y, and from there its right half extends over +x to -y.
    Image {
        /// The radiance.
        image: Arc<Image>,
        /// The factor on it.
        intensity: f64,
        /// The angle by which the picture is turned, counterclockwise seen from above.
        rotation: f64,
    },
}

/// A source of light. `color` times `intensity` has been multiplied out.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// A point that shines evenly in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// The radiant intensity: at distance d it lights a surface facing it with intensity / d^2.
        intensity: Color,
    },
    /// A light so far away that its rays are parallel, or nearly.
    Sun {
        /// The unit direction towards the sun.
        direction: Vec3,
        /// The irradiance of a surface facing it.
        irradiance: Color,
        /// The angular radius of the disk, in radians; 0 gives hard shadows.
        angular_radius: f64,
    },
    /// A disk that shines to the side of its normal, seen by the camera and in mirrors.
    Disk {
        /// The middle of the disk.
        center: Vec3,
        /// The unit direction to which it shines.
        normal: Vec3,
        /// The radius.
        radius: f64,
        /// The radiance.
        radiance: Color,
    },
    /// A sphere that shines, seen by the camera and in mirrors.
    Sphere {
        /// The middle of the sphere.
        center: Vec3,
        /// The radius.
        radius: f64,
        /// The radiance.
        radiance: Color,
    },
}

/// A thing in the scene, and its copies.
#[derive(Clone, Debug)]
pub struct Object {
    /// The name, for messages.
    pub name: String,
    /// What shape it has, and where it stands before it is copied.
    pub shape: Shape,
    /// The index of its material in [`Scene::materials`].
    pub material: usize,
    /// Where its copies stand; it stands only there.
    pub copies: Copies,
    /// What the section does to it.
    pub section: Cut,
}

impl Object {
    /// The motions that carry the shape to its copies.
    pub fn motions(&self) -> impl Iterator<Item = Motion> + '_ {
        let position = self.shape.position();
        (0..self.copies.count()).map(move |i| self.copies.motion(i, position))
    }

    /// The copies, each as a shape of its own; `None` for one whose placement cannot be inverted.
    pub fn shapes(&self) -> impl Iterator<Item = Option<Shape>> + '_ {
        self.motions().map(|motion| self.shape.moved(&motion))
    }
}

/// What shape a thing has.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A turned object.
    Turned(Instance),
    /// An endless plane.
    Plane {
        /// A point on it.
        point: Vec3,
        /// The unit normal.
        normal: Vec3,
    },
    /// A flat disk.
    Disk {
        /// The middle.
        center: Vec3,
        /// The unit normal.
        normal: Vec3,
        /// The radius.
        radius: f64,
    },
    /// A parallelogram: `center + a edges[0] + b edges[1]`, with a and b from -1/2 to 1/2.
    Rectangle {
        /// The middle.
        center: Vec3,
        /// The two edges, from corner to corner.
        edges: [Vec3; 2],
    },
    /// A sphere.
    Sphere {
        /// The middle.
        center: Vec3,
        /// The radius.
        radius: f64,
    },
    /// A turned surface over a part of the turn, closed by nothing.
    Swept {
        /// The whole surface.
        instance: Instance,
        /// The part, in the surface's own frame.
        sweep: Sweep,
    },
    /// A solid made of others; a solid swept over a part of the turn; a box or a half space.
    Body(Body),
}

impl Shape {
    /// The point of the shape that its object's `position` names.
    pub fn position(&self) -> Vec3 {
        match *self {
            Self::Turned(ref instance) | Self::Swept { ref instance, .. } => {
                instance.placement().translation
            }
            Self::Body(ref body) => body.placement.translation,
            Self::Plane { point, .. } => point,
            Self::Disk { center, .. }
            | Self::Rectangle { center, .. }
            | Self::Sphere { center, .. } => center,
        }
    }

    /// The shape under a motion; `None` if its placement cannot be inverted any more.
    pub fn moved(&self, &Motion { ref map, scale }: &Motion) -> Option<Self> {
        // Unit vectors stay so: the motion stretches them by the scale.
        let turned = |normal: Vec3| map.vector(normal) / scale;
        let placed = |instance: &Instance| {
            Instance::new(instance.surface().clone(), map.after(instance.placement()))
        };
        Some(match *self {
            Self::Turned(ref instance) => Self::Turned(placed(instance)?),
            Self::Swept { ref instance, sweep } => {
                Self::Swept { instance: placed(instance)?, sweep }
            }
            Self::Body(ref body) => {
                Self::Body(Body { placement: map.after(&body.placement), ..body.clone() })
            }
            Self::Plane { point, normal } => {
                Self::Plane { point: map.point(point), normal: turned(normal) }
            }
            Self::Disk { center, normal, radius } => Self::Disk {
                center: map.point(center),
                normal: turned(normal),
                radius: radius * scale,
            },
            Self::Rectangle { center, edges } => Self::Rectangle {
                center: map.point(center),
                edges: edges.map(|edge| map.vector(edge)),
            },
            Self::Sphere { center, radius } => {
                Self::Sphere { center: map.point(center), radius: radius * scale }
            }
        })
    }
}

/// What a thing is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Scatters light evenly (Lambert).
    Matte {
        /// The reflectance.
        color: Paint,
    },
    /// A coloured base under a clear coat that has highlights and reflects: china, lacquer, plastic.
    Glossy {
        /// The reflectance of the base.
        color: Paint,
        /// The strength of the highlight and of the reflection, from 0 to 1.
        specular: f64,
        /// The width of the highlight, from 0 (a mirror) to 1.
        roughness: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// The reflectance when looked at straight on.
        color: Paint,
    },
    /// Clear glass, water, wine.
    Glass(Glass),
    /// A metal whose index of refraction was measured.
    Metal {
        /// The real part of the index, by channel.
        eta: Color,
        /// The imaginary part of the index, by channel.
        k: Color,
        /// From 0 (a mirror) to 1.
        roughness: f64,
    },
    /// Anything, by the parameters that OpenPBR names.
    Principled(Box<Principled>),
}

/// A clear medium and its boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// What is left of the light after one scene unit inside.
    pub color: Color,
    /// The index of refraction, at 587.6 nm if it depends on the wavelength.
    pub ior: f64,
    /// The roughness of the boundary, from 0 (clear) to 1.
    pub roughness: f64,
    /// Abbe's number, (n_d - 1) / (n_F - n_C); `None` if all colours are refracted alike.
    pub abbe: Option<f64>,
    /// Where bodies of glass overlap, the one with the highest priority is there (Schmidt and Budge 2002,
    /// "Simple Nested Dielectrics in Ray Traced Images").
    pub priority: i32,
}

impl Glass {
    /// Clear and smooth, without dispersion, of priority 0.
    pub fn clear(color: Color, ior: f64) -> Self {
        Self { color, ior, roughness: 0.0, abbe: None, priority: 0 }
    }
}

/// A surface by the parameters of OpenPBR 1.1, of which it has a part; weights and roughnesses are from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled {
    /// The reflectance of the base, of a metal at normal incidence.
    pub base_color: Paint,
    /// The share of the base that is metal.
    pub base_metalness: f64,
    /// The factor on the reflectance of the base's gloss.
    pub specular_weight: f64,
    /// The roughness of the base's gloss and of metal.
    pub specular_roughness: f64,
    /// The index of refraction of the base.
    pub specular_ior: f64,
    /// The share of the base that is glass.
    pub transmission_weight: f64,
    /// The glass that it is.
    pub transmission: Glass,
    /// The clear coat: its weight, roughness, and index of refraction.
    pub coat_weight: f64,
    /// The roughness of the coat.
    pub coat_roughness: f64,
    /// The index of refraction of the coat.
    pub coat_ior: f64,
    /// What the coat leaves of light that goes through it and back.
    pub coat_color: Color,
    /// How much fuzz stands on the surface.
    pub fuzz_weight: f64,
    /// The colour of the fuzz.
    pub fuzz_color: Color,
    /// From little fuzz, seen edge on alone, to dust all over.
    pub fuzz_roughness: f64,
    /// The radiance that the surface sends out evenly, on both sides.
    pub emission: Color,
}

//! A place on a path where it meets a surface, from the eye or from a lamp.

use rondure::{Footing, Ray, Vec3};

use super::media::{Body, Crossing, Media};
use crate::{
    bsdf::{Boundary, Facing, Kind, Parts, Scatter, Smooth, Wavelength},
    color::Rgb,
    fresnel,
    numbers::Numbers,
    optics::{Medium, Optics},
    sampler::Key,
    warp::Frame,
    world::{Contact, World},
};

// The random numbers of a place on a path.
const DIRECTION: u32 = 1;
const LOBE: u32 = 2;
const MODEL: u32 = 5;

/// The random numbers that a place takes, made when they are asked for.
#[derive(Debug)]
pub(crate) struct Draw<'a> {
    numbers: &'a mut Numbers,
    key: Key,
    /// Where the numbers begin that choose between lobes, and what part of all they are.
    lobes: [f64; 2],
}

impl<'a> Draw<'a> {
    pub(crate) fn new(numbers: &'a mut Numbers, key: Key) -> Self {
        Self { numbers, key, lobes: [0.0, 1.0] }
    }

    /// The same for the lobes of a branch alone.
    pub(crate) fn among(self, lobes: [f64; 2]) -> Self {
        Self { lobes, ..self }
    }

    /// Between what is glass and what is not.
    #[inline]
    fn model(&mut self) -> f64 {
        self.numbers.single(self.key, MODEL)
    }

    /// Between lobes.
    #[inline]
    fn lobe(&mut self) -> f64 {
        self.lobes[0] + self.lobes[1] * self.numbers.single(self.key, LOBE)
    }

    /// [`direction`](Self::direction), as a point of the unit disk.
    #[inline]
    fn disk(&mut self) -> (f64, f64) {
        self.numbers.disk(self.key, DIRECTION)
    }

    #[inline]
    fn direction(&mut self) -> (f64, f64) {
        self.numbers.pair(self.key, DIRECTION)
    }
}

pub(crate) struct Vertex<'a> {
    pub(crate) surface: Footing,
    /// The geometric normal on the side that the path comes from.
    normal: Vec3,
    outgoing: Vec3,
    model: Model<'a>,
    /// What a path does that goes through, if it is the boundary of a body.
    pub(crate) crossing: Option<Crossing>,
}

/// What the surface does, in a frame whose z axis is the shading normal on the side that the path comes from.
enum Model<'a> {
    Opaque {
        frame: Frame,
        facing: Facing<'a>,
        /// Whether the shading normal is not the geometric one.
        is_bent: bool,
    },
    Clear(Smooth),
    Frosted {
        frame: Frame,
        wo: Vec3,
        boundary: Boundary<'a>,
    },
    /// A sheet of glass without thickness, and the cosine that it is seen at.
    Sheet {
        reflectance: f64,
        cos: f64,
    },
    /// A boundary that another body hides.
    Hidden,
}

/// How a path goes on.
pub(crate) struct Onward {
    pub(crate) direction: Vec3,
    pub(crate) weight: Rgb,
    /// The density by solid angle; infinite if the direction was the only one.
    pub(crate) pdf: f64,
    pub(crate) kind: Kind,
    /// Whether it went through to the other side.
    pub(crate) through: bool,
    /// Whether it passed a boundary that is none.
    pub(crate) straight: bool,
}

impl<'a> Vertex<'a> {
    /// `solid` tells whether the thing has an inside; `wavelength` that of a path which has met dispersion.
    pub(crate) fn new(
        world: &'a World,
        ray: &Ray,
        contact: &Contact,
        (finish, solid): (u32, bool),
        media: &Media,
        wavelength: Option<Wavelength>,
        draw: &mut Draw<'_>,
    ) -> Self {
        let surface = world.footing(ray, contact);
        let optics = world.optics(finish);
        let outgoing = -ray.direction;
        let entering = surface.normal.dot(outgoing) >= 0.0;
        let normal = if entering { surface.normal } else { -surface.normal };
        let mut crossing = None;
        let model = match &optics.glass {
            Some(medium) if optics.clarity >= 1.0 || draw.model() < optics.clarity => {
                let cos = normal.dot(outgoing).clamp(f64::MIN_POSITIVE, 1.0);
                if solid {
                    let body = Body { thing: contact.thing, finish, priority: medium.priority };
                    let through = Crossing { enters: entering, body };
                    crossing = Some(through);
                    match indices(world, medium, entering, media, through, wavelength) {
                        None => Model::Hidden,
                        Some([before, behind]) => match &medium.roughness {
                            None => Model::Clear(Smooth::new(before, behind, cos)),
                            Some(roughness) => {
                                let (frame, wo) = facing(normal, outgoing);
                                let boundary = Boundary { before, behind, roughness };
                                Model::Frosted { frame, wo, boundary }
                            }
                        },
                    }
                } else {
                    let one_side = fresnel::from_air(cos, medium.ior(wavelength));
                    Model::Sheet { reflectance: fresnel::sheet(one_side), cos }
                }
            }
            _ => {
                let (color, outwards) =
                    world.seen(ray, contact, finish, &optics.color, surface.normal);
                let shading = if entering { outwards } else { -outwards };
                let (frame, wo) = facing(shading, outgoing);
                let facing = optics.opaque.facing(wo, color);
                Model::Opaque { frame, facing, is_bent: shading != normal }
            }
        };
        Self { surface, normal, outgoing, model, crossing }
    }

    /// Whether light from a lamp can be seen in it otherwise than as a mirror image.
    #[inline]
    pub(crate) fn is_lit(&self) -> bool {
        matches!(&self.model, Model::Opaque { .. } | Model::Frosted { .. })
    }

    /// Whether some of the light that is seen comes by wide lobes.
    #[inline]
    pub(crate) fn is_wide(&self) -> bool {
        matches!(&self.model, Model::Opaque { facing, .. } if facing.is_wide())
    }

    /// The geometric normal on the side that the path comes from.
    #[inline]
    pub(crate) fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The colour of a surface that scatters evenly from its whole upper side, and does nothing else.
    #[inline]
    pub(crate) fn even_color(&self) -> Option<Rgb> {
        match &self.model {
            Model::Opaque { facing, is_bent: false, .. } => facing.even_color(),
            _ => None,
        }
    }

    /// What is sent back of the light from a direction on the viewer's side.
    #[inline]
    pub(crate) fn evaluate(&self, incoming: Vec3) -> Parts {
        if !(incoming.dot(self.normal) > 0.0) {
            return Parts::default();
        }
        let local = |frame: &Frame| Some(frame.to_local(incoming)).filter(|wi| wi.z > 0.0);
        let parts = match &self.model {
            Model::Opaque { frame, facing, .. } => local(frame).map(|wi| facing.evaluate(wi)),
            Model::Frosted { frame, wo, boundary } => local(frame)
                .map(|wi| Parts { narrow: boundary.evaluate(*wo, wi), ..Parts::default() }),
            Model::Clear(_) | Model::Sheet { .. } | Model::Hidden => None,
        };
        parts.unwrap_or_default()
    }

    /// Where the numbers that choose between lobes part in two groups, the one reflected as by a mirror.
    pub(crate) fn split(&self) -> Option<f64> {
        match &self.model {
            Model::Opaque { facing, .. } => facing.split(),
            Model::Clear(Smooth { reflectance, .. }) | Model::Sheet { reflectance, .. } => {
                Some(*reflectance)
            }
            Model::Frosted { .. } | Model::Hidden => None,
        }
        .filter(|share| *share > 0.0 && *share < 1.0)
    }

    /// How a path goes on from here.
    pub(crate) fn onward(&self, mut draw: Draw<'_>) -> Option<Onward> {
        let in_frame = |frame: &Frame, scatter: Scatter| {
            let through = scatter.direction.z < 0.0;
            (
                Scatter { direction: unit_again(frame.to_world(scatter.direction)), ..scatter },
                through,
            )
        };
        let perfect = |direction, through| {
            let (weight, pdf, kind) = (Rgb::WHITE, f64::INFINITY, Kind::Narrow);
            (Scatter { direction, weight, pdf, kind }, through)
        };
        let (Scatter { direction, weight, pdf, kind }, through) = match &self.model {
            Model::Opaque { frame, facing, .. } => {
                // A single lobe needs no number.
                let scatter = if facing.even_color().is_some() {
                    facing.sample_even(draw.disk())
                } else {
                    facing.sample(draw.lobe(), draw.direction())
                };
                in_frame(frame, scatter?)
            }
            Model::Clear(smooth) => {
                let (direction, through) = smooth.sample(self.normal, self.outgoing, draw.lobe());
                perfect(unit_again(direction), through)
            }
            Model::Frosted { frame, wo, boundary } => {
                in_frame(frame, boundary.sample(*wo, draw.lobe(), draw.direction())?)
            }
            Model::Sheet { reflectance, cos } if draw.lobe() < *reflectance => {
                perfect(unit_again(self.normal * (2.0 * cos) - self.outgoing), false)
            }
            // Straight on means to the last bit.
            Model::Sheet { .. } | Model::Hidden => perfect(-self.outgoing, true),
        };
        let side = if through { -self.normal } else { self.normal };
        // Rounding may turn a grazing direction to the wrong side, by as little as it is off.
        let off = direction.dot(side);
        let direction = if off < 0.0 { direction - side * (2.0 * off) } else { direction };
        Some(Onward {
            direction,
            weight,
            // No lamp is looked for on the other side, so what is found there counts fully.
            pdf: if through { f64::INFINITY } else { pdf },
            kind,
            through,
            straight: matches!(self.model, Model::Hidden),
        })
    }
}

/// The frame round a normal, and the viewer's direction in it.
#[inline]
fn facing(normal: Vec3, outgoing: Vec3) -> (Frame, Vec3) {
    let frame = Frame::new(normal);
    let mut wo = frame.to_local(outgoing);
    wo.z = wo.z.max(f64::MIN_POSITIVE);
    (frame, wo)
}

/// A direction of unit length but for rounding, which is taken off: one step of Newton's for the root of its length. So
/// rounding does not add up on the way.
#[inline]
fn unit_again(direction: Vec3) -> Vec3 {
    direction * (1.5 - 0.5 * direction.length_squared())
}

/// The indices of refraction before a boundary and behind it; `None` if the place is filled by the same on both sides.
fn indices(
    world: &World,
    medium: &Medium,
    entering: bool,
    media: &Media,
    crossing: Crossing,
    wavelength: Option<Wavelength>,
) -> Option<[f64; 2]> {
    let (here, there) = (media.filling(), media.filling_beyond(crossing));
    let index = |body: Option<Body>| {
        let glass = body.and_then(|body| world.optics(body.finish).glass.as_ref());
        glass.map_or(1.0, |glass| glass.ior(wavelength))
    };
    let before = match here {
        // From within glass that the path has never entered.
        None if !entering => medium.ior(wavelength),
        _ if here == there => return None,
        _ => index(here),
    };
    Some([before, index(there)])
}

/// Whether the glass on a path spreads white light out into colours.
pub(crate) fn is_dispersive(optics: &Optics) -> bool {
    optics.glass.as_ref().is_some_and(Medium::is_dispersive)
}

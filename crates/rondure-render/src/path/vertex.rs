//! A place on a path where it meets a surface, from the eye or from a lamp.

use rondure::{Footing, Ray, Vec3};

use super::media::{Body, Media};
use crate::{
    bsdf::{Boundary, Facing, Kind, Parts, Scatter, Wavelength},
    color::Rgb,
    fresnel,
    optics::{Medium, Optics},
    sampler::{Key, Sample},
    warp::Frame,
    world::{Contact, World},
};

// The random numbers of a place on a path.
const DIRECTION: u32 = 1;
const LOBE: u32 = 2;
const MODEL: u32 = 5;

/// The random numbers that a place takes, made when they are asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw<'a> {
    sample: &'a Sample,
    key: Key,
    /// Where the numbers begin that choose between lobes, and what part of all they are.
    lobes: [f64; 2],
}

impl<'a> Draw<'a> {
    pub(crate) fn new(sample: &'a Sample, key: Key) -> Self {
        Self { sample, key, lobes: [0.0, 1.0] }
    }

    /// The same for the lobes of a branch alone.
    pub(crate) fn among(self, from: f64, share: f64) -> Self {
        Self { lobes: [from, share], ..self }
    }

    /// Between what is glass and what is not.
    #[inline]
    fn model(&self) -> f64 {
        self.sample.single(self.key.child(MODEL))
    }

    /// Between lobes.
    #[inline]
    fn lobe(&self) -> f64 {
        self.lobes[0] + self.lobes[1] * self.sample.single(self.key.child(LOBE))
    }

    #[inline]
    fn direction(&self) -> (f64, f64) {
        self.sample.pair(self.key.child(DIRECTION))
    }
}

pub(crate) struct Vertex<'a> {
    pub(crate) surface: Footing,
    /// Its z axis is the shading normal on the side that the path comes from.
    frame: Frame,
    normal: Vec3,
    outgoing: Vec3,
    /// The viewer's direction; rounding may have put it below the horizon.
    wo: Vec3,
    model: Model<'a>,
    /// Whether the shading normal is not the geometric one.
    is_bent: bool,
    /// The bodies on the other side.
    beyond: Media,
}

enum Model<'a> {
    Opaque(Facing<'a>),
    Clear(Boundary<'a>),
    /// A sheet of glass without thickness.
    Sheet {
        ior: f64,
    },
    /// A boundary that another body hides.
    Hidden,
}

/// How a path goes on.
pub(crate) struct Onward {
    pub(crate) ray: Ray,
    pub(crate) weight: Rgb,
    /// The density by solid angle; infinite if the direction was the only one.
    pub(crate) pdf: f64,
    pub(crate) kind: Kind,
    pub(crate) media: Media,
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
        draw: &Draw<'_>,
    ) -> Self {
        let surface = world.footing(ray, contact);
        let optics = world.optics(finish);
        let outgoing = -ray.direction;
        let entering = surface.normal.dot(outgoing) >= 0.0;
        let normal = if entering { surface.normal } else { -surface.normal };
        let mut beyond = *media;
        let mut shading = normal;
        let (mut frame, mut wo) = facing(normal, outgoing);
        let model = match &optics.glass {
            Some(medium) if optics.clarity >= 1.0 || draw.model() < optics.clarity => {
                if solid {
                    let body = Body { thing: contact.thing, finish, priority: medium.priority };
                    beyond = if entering {
                        media.entered(body)
                    } else {
                        media.left(contact.thing, finish)
                    };
                    boundary(world, medium, entering, media, &beyond, wavelength)
                } else {
                    Model::Sheet { ior: medium.ior(wavelength) }
                }
            }
            _ => {
                let color = match optics.color.plain() {
                    Some(color) if !world.has_relief(finish) => color,
                    _ => {
                        let surface = world.interaction(ray, contact);
                        let spot = world.spot(contact, &surface, outgoing);
                        let outwards =
                            world.shading_normal(finish, contact, &surface, &spot, outgoing);
                        shading = if entering { outwards } else { -outwards };
                        optics.color.at(&spot)
                    }
                };
                (frame, wo) = facing(shading, outgoing);
                Model::Opaque(optics.opaque.facing(wo, color))
            }
        };
        Self { surface, frame, normal, outgoing, wo, model, is_bent: shading != normal, beyond }
    }

    /// Whether light from a lamp can be seen in it otherwise than as a mirror image.
    #[inline]
    pub(crate) fn is_lit(&self) -> bool {
        match &self.model {
            Model::Opaque(_) => true,
            Model::Clear(boundary) => boundary.roughness.is_some(),
            Model::Sheet { .. } | Model::Hidden => false,
        }
    }

    /// Whether some of the light that is seen comes by wide lobes.
    #[inline]
    pub(crate) fn is_wide(&self) -> bool {
        matches!(&self.model, Model::Opaque(facing) if facing.is_wide())
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
            Model::Opaque(facing) if !self.is_bent => facing.even_color(),
            _ => None,
        }
    }

    /// What is sent back of the light from a direction on the viewer's side.
    #[inline]
    pub(crate) fn evaluate(&self, incoming: Vec3) -> Parts {
        let wi = self.frame.to_local(incoming);
        if !(wi.z > 0.0 && incoming.dot(self.normal) > 0.0) {
            return Parts::default();
        }
        match &self.model {
            Model::Opaque(facing) => facing.evaluate(wi),
            Model::Clear(boundary) => {
                Parts { narrow: boundary.evaluate(self.wo, wi), ..Parts::default() }
            }
            Model::Sheet { .. } | Model::Hidden => Parts::default(),
        }
    }

    /// Where the numbers that choose between lobes part in two groups, the one reflected as by a mirror.
    pub(crate) fn split(&self) -> Option<f64> {
        let cos = self.wo.z.min(1.0);
        match &self.model {
            Model::Opaque(facing) => facing.split(),
            Model::Clear(boundary) => boundary.split(cos),
            Model::Sheet { ior } => Some(fresnel::sheet(fresnel::from_air(cos, *ior))),
            Model::Hidden => None,
        }
        .filter(|share| *share > 0.0 && *share < 1.0)
    }

    /// A ray that goes on from here; `media` are the bodies that the path is in.
    pub(crate) fn onward(&self, media: &Media, draw: &Draw<'_>) -> Option<Onward> {
        let perfect = |direction, pdf| {
            Some(Scatter { direction, weight: Rgb::WHITE, pdf, kind: Kind::Narrow })
        };
        let wo = self.wo;
        let scatter = match &self.model {
            Model::Opaque(facing) => {
                // A single lobe needs no number.
                let lobe = if facing.even_color().is_some() { 0.0 } else { draw.lobe() };
                facing.sample(lobe, draw.direction())
            }
            Model::Clear(boundary) => boundary.sample(wo, draw.lobe(), draw.direction()),
            Model::Sheet { ior } => {
                let reflected =
                    draw.lobe() < fresnel::sheet(fresnel::from_air(wo.z.min(1.0), *ior));
                let direction = if reflected { Vec3::new(-wo.x, -wo.y, wo.z) } else { -wo };
                perfect(direction, f64::INFINITY)
            }
            Model::Hidden => perfect(-wo, f64::INFINITY),
        }?;
        let through = scatter.direction.z < 0.0;
        let direction = match self.model {
            // Straight on means to the last bit.
            Model::Sheet { .. } | Model::Hidden if through => -self.outgoing,
            _ => self.frame.to_world(scatter.direction).normalized(),
        };
        let side = if through { -self.normal } else { self.normal };
        // Rounding may turn a grazing direction to the wrong side, by as little as it is off.
        let off = direction.dot(side);
        let direction = if off < 0.0 { direction - side * (2.0 * off) } else { direction };
        Some(Onward {
            ray: self.surface.spawn(direction),
            weight: scatter.weight,
            // No lamp is looked for on the other side, so what is found there counts fully.
            pdf: if through { f64::INFINITY } else { scatter.pdf },
            kind: scatter.kind,
            media: if through { self.beyond } else { *media },
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

fn boundary<'a>(
    world: &World,
    medium: &'a Medium,
    entering: bool,
    media: &Media,
    beyond: &Media,
    wavelength: Option<Wavelength>,
) -> Model<'a> {
    let (here, there) = (media.filling(), beyond.filling());
    let index = |body: Option<Body>| {
        let glass = body.and_then(|body| world.optics(body.finish).glass.as_ref());
        glass.map_or(1.0, |glass| glass.ior(wavelength))
    };
    let before = match here {
        // From within glass that the path has never entered.
        None if !entering => medium.ior(wavelength),
        _ if here == there => return Model::Hidden,
        _ => index(here),
    };
    Model::Clear(Boundary { before, behind: index(there), roughness: medium.roughness.as_ref() })
}

/// Whether the glass on a path spreads white light out into colours.
pub(crate) fn is_dispersive(optics: &Optics) -> bool {
    optics.glass.as_ref().is_some_and(Medium::is_dispersive)
}

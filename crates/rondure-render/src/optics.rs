//! Materials made ready for the path tracer: tables built, colours looked up fast.

use rondure_scene::{Glass, Material, Principled};

use crate::{
    bsdf::{Dispersion, Fuzz, Gloss, Kind, Layered, Layers, Lobe, Metal, Roughness, Wavelength},
    color::Rgb,
    texture::Pattern,
};

/// The index of refraction of the coat of a glossy material: that of glaze, lacquer and most plastics.
const GLAZE: f64 = 1.5;

/// What a surface is made of.
#[derive(Clone, Debug)]
pub(crate) struct Optics {
    pub(crate) color: Pattern,
    pub(crate) opaque: Layered,
    /// The glass that shares the surface with what is opaque, if any.
    pub(crate) glass: Option<Medium>,
    /// The share of the surface that is glass.
    pub(crate) clarity: f64,
    /// The radiance that it sends out.
    pub(crate) emission: Rgb,
}

/// A clear medium.
#[derive(Clone, Debug)]
pub(crate) struct Medium {
    /// The absorption coefficient by channel, per scene unit.
    absorption: Rgb,
    ior: f64,
    dispersion: Option<Dispersion>,
    pub(crate) roughness: Option<Roughness>,
    pub(crate) priority: i32,
}

impl Medium {
    fn new(glass: &Glass) -> Self {
        Self {
            // A channel of 0 lets nothing through; its logarithm must stay finite, so that
            // nothing is absorbed on a way of length 0.
            absorption: Rgb::from(glass.color).map(|c| -c.clamp(f64::MIN_POSITIVE, 1.0).ln()),
            ior: glass.ior,
            dispersion: glass.abbe.map(|abbe| Dispersion::new(glass.ior, abbe)),
            roughness: Roughness::new(glass.roughness, glass.ior),
            priority: glass.priority,
        }
    }

    /// The index of refraction for a wavelength, or for white light.
    #[inline]
    pub(crate) fn ior(&self, wavelength: Option<Wavelength>) -> f64 {
        match (self.dispersion, wavelength) {
            (Some(dispersion), Some(wavelength)) => dispersion.ior(wavelength),
            _ => self.ior,
        }
    }

    /// What is left of light after a way in it.
    #[inline]
    pub(crate) fn faded(&self, light: Rgb, distance: f64) -> Rgb {
        // The exponential takes as long as a quarter of a ray.
        if self.absorption.is_black() {
            return light;
        }
        light * self.absorption.map(|a| (-a * distance).exp())
    }

    pub(crate) fn is_dispersive(&self) -> bool {
        self.dispersion.is_some()
    }
}

/// A base that scatters evenly and has no gloss.
const MATTE: Layers = Layers {
    fuzz: None,
    coat: None,
    coat_color: Rgb::WHITE,
    gloss: Gloss { strength: 0.0, ior: GLAZE, lobe: Lobe::Smooth },
    metalness: 0.0,
    metal: Metal::Tinted,
};

impl Optics {
    pub(crate) fn new(material: &Material) -> Self {
        let plain = |color, layers| Self {
            color,
            opaque: Layered::new(layers),
            glass: None,
            clarity: 0.0,
            emission: Rgb::BLACK,
        };
        let white = Pattern::Solid(Rgb::WHITE);
        match material {
            Material::Matte { color } => plain(Pattern::new(color), MATTE),
            Material::Glossy { color, specular, roughness } => {
                let lobe = Lobe::new(*roughness);
                let gloss = Gloss { strength: *specular, ior: GLAZE, lobe };
                plain(Pattern::new(color), Layers { gloss, ..MATTE })
            }
            Material::Mirror { color } => {
                plain(Pattern::new(color), Layers { metalness: 1.0, ..MATTE })
            }
            Material::Metal { eta, k, roughness } => {
                let gloss = Gloss { lobe: Lobe::new(*roughness), ..MATTE.gloss };
                let metal = Metal::Measured { eta: (*eta).into(), k: (*k).into() };
                plain(white, Layers { gloss, metalness: 1.0, metal, ..MATTE })
            }
            Material::Glass(glass) => {
                Self { glass: Some(Medium::new(glass)), clarity: 1.0, ..plain(white, MATTE) }
            }
            Material::Principled(principled) => Self::principled(principled),
        }
    }

    fn principled(p: &Principled) -> Self {
        let fuzz = (p.fuzz_weight > 0.0).then(|| Fuzz {
            color: p.fuzz_color.into(),
            weight: p.fuzz_weight,
            roughness: p.fuzz_roughness,
        });
        let coat = (p.coat_weight > 0.0).then(|| Gloss {
            strength: p.coat_weight,
            ior: p.coat_ior,
            lobe: Lobe::new(p.coat_roughness),
        });
        let coat_color = Rgb::WHITE.mix(p.coat_color.into(), p.coat_weight);
        let lobe = Lobe::new(p.specular_roughness);
        let gloss = Gloss { strength: p.specular_weight, ior: p.specular_ior, lobe };
        let (metalness, metal) = (p.base_metalness, Metal::Tinted);
        // What is metal is not clear.
        let clarity = p.transmission_weight * (1.0 - metalness);
        Self {
            color: Pattern::new(&p.base_color),
            opaque: Layered::new(Layers { fuzz, coat, coat_color, gloss, metalness, metal }),
            glass: (clarity > 0.0).then(|| Medium::new(&p.transmission)),
            clarity,
            emission: p.emission.into(),
        }
    }

    /// The share of light that narrow lobes send on, about.
    pub(crate) fn focus(&self) -> f64 {
        self.clarity + (1.0 - self.clarity) * self.opaque.narrow_albedo()
    }

    /// Whether photons can come to rest on it.
    pub(crate) fn is_wide(&self) -> bool {
        self.clarity < 1.0 && self.opaque.has(Kind::Wide)
    }
}

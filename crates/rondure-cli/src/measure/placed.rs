//! Measures of things in their places.
//!
//! Volume, centroid and inertia follow every affine map. Length, area and capacity are measured
//! anew, on the profile stretched as the placement stretches it; that takes a placement that leaves
//! the object a surface of revolution, and for the capacity one that leaves it upright.

use std::{collections::HashMap, sync::Arc};

use rondure::{
    Affine, Instance, Measure, Point, Profile, Vec3,
    measure::{Cavity, NoCavity, NoSolid},
    numeric::gamma,
    profile::PlaneMap,
};

use rondure_scene::Shape;

use super::units::digits;

/// What is known about a thing. In place of what is not, stands the reason.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) name: String,
    pub(super) sheet: Result<Sheet, String>,
    pub(super) solid: Result<Solid, String>,
    pub(super) cavity: Result<PlacedCavity, String>,
}

/// The surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    pub(super) length: f64,
    pub(super) length_error: f64,
    pub(super) area: f64,
    pub(super) area_error: f64,
    pub(super) diameter: f64,
    pub(super) height: f64,
}

/// The solid, of density 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    pub(super) volume: f64,
    pub(super) volume_error: f64,
    pub(super) centroid: [f64; 3],
    pub(super) centroid_error: f64,
    /// The tensor of inertia about the centroid.
    pub(super) inertia: [[f64; 3]; 3],
    pub(super) inertia_error: f64,
}

/// A cavity in the world: enlarged by `scale`, then raised by `z`.
#[derive(Clone, Debug)]
pub(super) struct PlacedCavity {
    cavity: Cavity,
    scale: f64,
    z: f64,
}

impl Measured {
    /// A thing of which nothing is known, and why.
    fn unknown(name: &str, reason: &str) -> Self {
        Self {
            name: name.into(),
            sheet: Err(reason.into()),
            solid: Err(reason.into()),
            cavity: Err(reason.into()),
        }
    }
}

impl PlacedCavity {
    pub(super) fn bottom(&self) -> f64 {
        self.scale * self.cavity.bottom() + self.z
    }

    pub(super) fn brim(&self) -> f64 {
        self.scale * self.cavity.brim() + self.z
    }

    pub(super) fn capacity(&self) -> f64 {
        self.scale.powi(3) * self.cavity.capacity()
    }

    pub(super) fn trapped(&self) -> f64 {
        self.scale.powi(3) * self.cavity.trapped()
    }

    pub(super) fn error(&self) -> f64 {
        self.scale.powi(3) * (self.cavity.error() + gamma(8) * self.cavity.capacity())
    }

    pub(super) fn volume(&self, z: f64) -> Option<f64> {
        // The way back to the profile rounds; the brim is the brim.
        if z == self.brim() {
            return Some(self.capacity());
        }
        let own = self.cavity.volume((z - self.z) / self.scale)?;
        Some(self.scale.powi(3) * own)
    }

    pub(super) fn level(&self, volume: f64) -> Option<f64> {
        if volume == self.capacity() {
            return Some(self.brim());
        }
        let own = self.cavity.level(volume / self.scale.powi(3))?;
        Some(self.scale * own + self.z)
    }
}

impl Measured {
    /// A profile that stands nowhere but in its own frame.
    pub(super) fn alone(name: String, measure: &Measure) -> Self {
        Self {
            name,
            sheet: Ok(sheet(measure, 1.0)),
            solid: solid(measure, &Affine::IDENTITY),
            cavity: cavity(measure, 1.0, 0.0),
        }
    }
}

fn sheet(measure: &Measure, scale: f64) -> Sheet {
    let [low, high] = measure.z_range;
    let square = scale * scale;
    Sheet {
        length: scale * measure.length,
        length_error: scale * (measure.length_error + gamma(2) * measure.length),
        area: square * measure.area,
        area_error: square * (measure.area_error + gamma(4) * measure.area),
        diameter: scale * (2.0 * measure.r_max),
        height: scale * (high - low),
    }
}

fn cavity(measure: &Measure, scale: f64, z: f64) -> Result<PlacedCavity, String> {
    match &measure.cavity {
        Ok(cavity) => Ok(PlacedCavity { cavity: cavity.clone(), scale, z }),
        Err(reason) => Err(placed_reason(reason, scale, z).to_string()),
    }
}

/// The reason with its heights and radii in the world, rounded to the digits that are shown.
fn placed_reason(reason: &NoCavity, scale: f64, height: f64) -> NoCavity {
    match *reason {
        NoCavity::Drains { bore } => NoCavity::Drains { bore: shown(scale * bore) },
        NoCavity::RunsOff { z } => NoCavity::RunsOff { z: shown(scale * z + height) },
        NoCavity::Crossing { near } => NoCavity::Crossing { near: shown_point(near) },
        NoCavity::TooIntricate => NoCavity::TooIntricate,
    }
}

fn shown(x: f64) -> f64 {
    digits(x).parse().unwrap_or(x)
}

fn shown_point(p: Point) -> Point {
    Point::new(shown(p.r), shown(p.z))
}

/// The image of the solid. With C the matrix of the second moments about the centroid and L the
/// linear part, that of the image is |det L| L C L^T, and its tensor of inertia is trace(C) 1 - C.
fn solid(measure: &Measure, placement: &Affine) -> Result<Solid, String> {
    let own = measure.solid.map_err(|reason| match reason {
        NoSolid::Crossing { near } => NoSolid::Crossing { near: shown_point(near) }.to_string(),
        other => other.to_string(),
    })?;
    let factor = placement.determinant().abs();
    let centroid = placement.point(Vec3::new(0.0, 0.0, own.centroid_z));
    let across = 0.5 * own.inertia_axial;
    let along = own.inertia_transverse - across;
    let [x, y, z] = placement.columns.map(|column| [column.x, column.y, column.z]);
    let second = |i: usize, j: usize| {
        factor * (across * (x[i] * x[j] + y[i] * y[j]) + along * (z[i] * z[j]))
    };
    let trace = second(0, 0) + second(1, 1) + second(2, 2);
    let entry = |i, j| if i == j { trace - second(i, j) } else { 0.0 - second(i, j) };
    let stretch = placement.columns.iter().map(|column| column.length_squared()).sum::<f64>();
    Ok(Solid {
        volume: factor * own.volume,
        volume_error: factor * (own.volume_error + gamma(16) * own.volume),
        centroid: [centroid.x, centroid.y, centroid.z],
        centroid_error: stretch.sqrt() * own.centroid_error + gamma(8) * centroid.max_abs(),
        inertia: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
        inertia_error: factor * stretch * (own.inertia_error + gamma(16) * trace),
    })
}

/// Measures the objects of a scene, and each profile once for each shape that placements give it.
#[derive(Default)]
pub(super) struct Measurer {
    known: HashMap<(*const Profile, u64), Result<Arc<Measure>, String>>,
}

impl Measurer {
    pub(super) fn shape(&mut self, name: &str, shape: &Shape) -> Measured {
        match shape {
            Shape::Turned(instance) => self.object(name, instance),
            Shape::Swept { .. } => Measured::unknown(name, NO_WHOLE_TURN),
            _ => Measured::unknown(name, MADE_OF_OTHERS),
        }
    }

    fn object(&mut self, name: &str, instance: &Instance) -> Measured {
        let profile = instance.surface().profile();
        let placement = instance.placement();
        let own = self.measure(profile, 1.0);
        let stretched = Stretch::of(placement)
            .ok_or_else(|| String::from(NOT_OF_REVOLUTION))
            .and_then(|stretch| Ok((stretch, self.measure(profile, stretch.ratio)?)));
        Measured {
            name: name.into(),
            sheet: match &stretched {
                Ok((stretch, measure)) => Ok(sheet(measure, stretch.scale)),
                Err(reason) => Err(reason.clone()),
            },
            solid: own.and_then(|measure| solid(&measure, placement)),
            cavity: match &stretched {
                Ok((stretch, measure)) if stretch.upright => {
                    cavity(measure, stretch.scale, placement.translation.z)
                }
                Ok(_) => Err("it does not stand upright".into()),
                Err(reason) => Err(reason.clone()),
            },
        }
    }

    /// Measures a profile whose heights are multiplied by a factor.
    fn measure(&mut self, profile: &Profile, ratio: f64) -> Result<Arc<Measure>, String> {
        let measure = || match profile.mapped(&PlaneMap::scale(1.0, ratio)) {
            Ok(stretched) => Ok(Arc::new(stretched.measure())),
            Err(error) => Err(error.to_string()),
        };
        let key = (std::ptr::from_ref(profile), ratio.to_bits());
        self.known.entry(key).or_insert_with(measure).clone()
    }
}

const NO_WHOLE_TURN: &str = "only whole turns are measured, and its sweep is a part of one";
const MADE_OF_OTHERS: &str =
    "only turned objects are measured, and this is a part of one, or made of several solids";
const NOT_OF_REVOLUTION: &str =
    "as it is placed it is no surface of revolution: it is stretched unevenly round its axis";

/// How a placement changes a profile that stays one.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    /// The factor on r.
    scale: f64,
    /// The factor on z, over that on r; negative if the object stands on its head.
    ratio: f64,
    /// Whether the axis is vertical.
    upright: bool,
}

impl Stretch {
    /// `None` if the placement does not turn circles round the axis into circles round its image.
    fn of(placement: &Affine) -> Option<Self> {
        // Placements are products of a few maps, each rounded.
        let rounding = gamma(64);
        let [x, y, z] = placement.columns;
        let [across, other, along] = [x, y, z].map(Vec3::length);
        let same = |a: f64, b: f64| (a - b).abs() <= rounding * a;
        let round = same(across, other)
            && x.dot(y).abs() <= rounding * across * across
            && x.dot(z).abs().max(y.dot(z).abs()) <= rounding * across * along;
        let upright = z.x.abs().max(z.y.abs()) <= rounding * along;
        let ratio = if same(across, along) { 1.0 } else { along / across };
        let sign = if upright && z.z < 0.0 { -1.0 } else { 1.0 };
        round.then_some(Self { scale: across, ratio: sign * ratio, upright })
    }
}

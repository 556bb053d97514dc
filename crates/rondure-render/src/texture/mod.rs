//! Colours over surfaces and through space, and what turns normals.
//!
//! Each kind is looked up at a [`Spot`]. Nothing is filtered: many samples in a pixel do that.

mod label;
mod marble;
mod noise;
mod relief;
mod sheet;
#[cfg(test)]
mod tests;
mod wood;

use rondure::{Affine, Interaction, Vec3};
use rondure_scene::Paint;

pub(crate) use self::relief::Relief;
use self::{label::Label, marble::Marble, sheet::Sheet, wood::Wood};
use crate::color::Rgb;

/// A thing's own frame: as it was before it was placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Own {
    /// The rows of the linear map from the world.
    rows: [Vec3; 3],
    placement: Affine,
}

impl Own {
    /// `rows` are those of the placement's inverse.
    pub(crate) fn new(placement: Affine, rows: [Vec3; 3]) -> Self {
        Self { rows, placement }
    }

    /// Of a placement; the world's own frame if it has no inverse.
    pub(crate) fn of(placement: &Affine) -> Self {
        match placement.inverse_rows() {
            Some(rows) => Self::new(*placement, rows),
            None => Self::new(Affine::IDENTITY, Affine::IDENTITY.columns),
        }
    }

    /// Of a flat shape whose coordinates u and v are lengths: they are x and y, and 0 is z.
    pub(crate) fn flat(at: &Interaction) -> Self {
        let [u, v] = at.uv;
        let translation = at.point - at.dp_du * u - at.dp_dv * v;
        Self::of(&Affine { columns: [at.dp_du, at.dp_dv, at.normal], translation })
    }

    fn point(&self, p: Vec3) -> Vec3 {
        self.vector(p - self.placement.translation)
    }

    fn vector(&self, v: Vec3) -> Vec3 {
        let [x, y, z] = self.rows;
        Vec3::new(x.dot(v), y.dot(v), z.dot(v))
    }

    fn normal(&self, n: Vec3) -> Vec3 {
        let [x, y, z] = self.placement.columns;
        Vec3::new(x.dot(n), y.dot(n), z.dot(n)).normalized()
    }

    /// The spot at a place of the surface, seen from the direction `outgoing`; `copy` is the thing's number
    /// among those that are alike.
    pub(crate) fn spot(&self, at: &Interaction, outgoing: Vec3, copy: u32) -> Spot {
        Spot {
            uv: at.uv,
            point: self.point(at.point),
            normal: self.normal(at.normal),
            length: self.vector(at.dp_dv).length(),
            front: at.normal.dot(outgoing) >= 0.0,
            copy,
        }
    }

    /// The normal that light sees at a spot: of unit length, and on the side of the surface's own, on which
    /// `outgoing` goes off from it too, if it goes off from the surface's.
    pub(crate) fn shading_normal(
        &self,
        relief: &Relief,
        spot: &Spot,
        at: &Interaction,
        outgoing: Vec3,
    ) -> Vec3 {
        let own = relief.normal(spot, [at.dp_du, at.dp_dv].map(|v| self.vector(v)));
        let [x, y, z] = self.rows;
        let normal = (x * own.x + y * own.y + z * own.z).normalized();
        // The other way if the placement mirrors and the surface's own normal did not turn with it.
        let normal = if normal.dot(at.normal) < 0.0 { -normal } else { normal };
        let (cos, side) = (normal.dot(outgoing), at.normal.dot(outgoing));
        // A slope that faces away from where it is seen from is seen as if it were as much towards it.
        if cos * side < 0.0 { (normal - outgoing * (2.0 * cos)).normalized() } else { normal }
    }
}

/// A place on a thing, as patterns see it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spot {
    pub(crate) uv: [f64; 2],
    /// The point and the unit normal in the thing's own frame.
    pub(crate) point: Vec3,
    pub(crate) normal: Vec3,
    /// The arc length of the profile in that frame; 1 where v is a length.
    pub(crate) length: f64,
    /// Whether it is seen from the side of the normal.
    pub(crate) front: bool,
    /// The thing's number among those that are alike.
    pub(crate) copy: u32,
}

impl Spot {
    /// A seed for this copy.
    fn seed(&self, own: u32) -> u32 {
        noise::mixed(self.copy, own)
    }
}

/// A colour over a surface, or through space.
#[derive(Clone, Debug)]
pub(crate) enum Pattern {
    Solid(Rgb),
    Checker { colors: [Rgb; 2], per_unit: [f64; 2] },
    Blocks { colors: [Rgb; 2], size: Vec3 },
    Picture(Box<Picture>),
    Label(Box<Label>),
    Wood(Box<Wood>),
    Marble(Box<Marble>),
}

/// A picture, and what lies under it.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    sheet: Sheet,
    /// `None` if it is not seen.
    over: Option<Pattern>,
}

impl Pattern {
    pub(crate) fn new(paint: &Paint) -> Self {
        match paint {
            Paint::Solid(color) => Self::Solid((*color).into()),
            Paint::Checker { colors, size } => {
                Self::Checker { colors: colors.map(Rgb::from), per_unit: size.map(|s| 1.0 / s) }
            }
            Paint::Blocks { colors, size } => {
                Self::Blocks { colors: colors.map(Rgb::from), size: *size }
            }
            Paint::Picture(picture) => {
                let sheet = Sheet::new(&picture.sheet);
                let over = (!sheet.covers()).then(|| Self::new(&picture.over));
                Self::Picture(Box::new(Picture { sheet, over }))
            }
            Paint::Label(label) => Self::Label(Box::new(Label::new(label))),
            Paint::Wood(wood) => Self::Wood(Box::new(Wood::new(wood))),
            Paint::Marble(marble) => Self::Marble(Box::new(Marble::new(marble))),
        }
    }

    /// The colour that it has everywhere, if it is only one.
    #[inline]
    pub(crate) fn plain(&self) -> Option<Rgb> {
        match self {
            Self::Solid(color) => Some(*color),
            _ => None,
        }
    }

    #[inline]
    pub(crate) fn at(&self, spot: &Spot) -> Rgb {
        match self {
            Self::Solid(color) => *color,
            Self::Checker { colors, per_unit } => {
                let [u, v] = spot.uv;
                alternate(colors, (u * per_unit[0]).floor() + (v * per_unit[1]).floor())
            }
            Self::Blocks { colors, size } => {
                let Vec3 { x, y, z } = spot.point;
                let block = (x / size.x).floor() + (y / size.y).floor() + (z / size.z).floor();
                alternate(colors, block)
            }
            Self::Picture(picture) => {
                let below = picture.over.as_ref().map_or(Rgb::BLACK, |over| over.at(spot));
                picture.sheet.at(spot.uv).over(below)
            }
            Self::Label(label) => label.at(spot),
            Self::Wood(wood) => wood.at(spot),
            Self::Marble(marble) => marble.at(spot),
        }
    }
}

/// The first colour for even numbers, the second for odd ones.
fn alternate(colors: &[Rgb; 2], square: f64) -> Rgb {
    colors[usize::from(square.rem_euclid(2.0) == 1.0)]
}

#[cfg(test)]
mod own_tests {
    use super::*;

    #[test]
    fn squares_alternate_across_zero() {
        let paint = Paint::Checker { colors: [[0.0; 3], [1.0; 3]], size: [0.5, 2.0] };
        let pattern = Pattern::new(&paint);
        for (uv, expected) in [
            ([0.1, 0.1], 0.0),
            ([-0.1, 0.1], 1.0),
            ([-0.1, -0.1], 0.0),
            ([0.6, 1.9], 1.0),
            ([0.6, 2.1], 0.0),
        ] {
            assert_eq!(pattern.at(&Spot { uv, ..Spot::default() }).r, expected, "{uv:?}");
        }
    }

    #[test]
    fn blocks_alternate_in_space() {
        let size = Vec3::new(1.0, 2.0, 0.5);
        let pattern = Pattern::new(&Paint::Blocks { colors: [[0.0; 3], [1.0; 3]], size });
        for (x, y, z, expected) in [
            (0.5, 1.0, 0.2, 0.0),
            (0.5, 1.0, 0.7, 1.0),
            (-0.5, -1.0, 0.2, 0.0),
            (1.5, 3.0, -0.1, 1.0),
        ] {
            let point = Vec3::new(x, y, z);
            assert_eq!(pattern.at(&Spot { point, ..Spot::default() }).r, expected, "{point:?}");
        }
    }

    /// What is looked up stays where it is on the thing, however that is placed.
    #[test]
    fn spots_are_in_the_frame_of_the_thing() {
        let placement = Affine::translate(Vec3::new(3.0, 4.0, 5.0))
            .after(&Affine::rotate(Vec3::new(1.0, -1.0, 0.4), 2.0))
            .after(&Affine::scale(Vec3::new(2.0, -0.5, 3.0)));
        let own = Own::of(&placement);
        let (point, du, dv) =
            (Vec3::new(0.3, 0.2, 0.9), Vec3::new(0.1, 0.5, 0.0), Vec3::new(0.0, 0.0, 4.0));
        let normal = du.cross(dv).normalized();
        let [x, y, z] = own.rows;
        let at = Interaction {
            point: placement.point(point),
            normal: (x * normal.x + y * normal.y + z * normal.z).normalized(),
            uv: [0.25, 0.5],
            dp_du: placement.vector(du),
            dp_dv: placement.vector(dv),
            error: 0.0,
        };
        let spot = own.spot(&at, at.normal, 7);
        assert!((spot.point - point).max_abs() < 1e-14);
        assert!((spot.normal - normal).max_abs() < 1e-14);
        assert!((spot.length - 4.0).abs() < 1e-14 && spot.front && spot.copy == 7);
        assert!(!own.spot(&at, -at.normal, 7).front);
    }

    #[test]
    fn shading_normals_look_to_the_viewer() {
        let own = Own::of(&Affine::IDENTITY);
        let at = Interaction {
            point: Vec3::ZERO,
            normal: Vec3::Z,
            uv: [0.0; 2],
            dp_du: Vec3::X,
            dp_dv: Vec3::Y,
            error: 0.0,
        };
        let relief = Relief::Noise { per_size: 1.0, height: 3.0, seed: None };
        let mut bent = 0;
        for i in 0..200 {
            let outgoing = Vec3::new((f64::from(i)).cos(), (f64::from(i)).sin(), 0.2).normalized();
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let outgoing = Vec3::new(outgoing.x, outgoing.y, side * outgoing.z);
            let mut at = at;
            at.point = Vec3::new(f64::from(i) * 0.31, 0.4, 0.0);
            let spot = own.spot(&at, outgoing, 0);
            let normal = own.shading_normal(&relief, &spot, &at, outgoing);
            assert!((normal.length() - 1.0).abs() < 1e-12);
            assert!(normal.dot(outgoing) * side >= 0.0, "{i}");
            bent += u32::from((normal - at.normal).max_abs() > 0.01);
        }
        assert!(bent > 150);
    }
}

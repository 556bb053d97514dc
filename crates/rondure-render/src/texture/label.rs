//! Labels: a picture with its own window on a wall, seen from outside alone.

use core::f64::consts::TAU;

use rondure_scene::{Along, Sticker};

use super::{Pattern, Spot, sheet::Sheet};
use crate::color::Rgb;

/// A label, ready to be looked up.
#[derive(Clone, Debug)]
pub(crate) struct Label {
    sheet: Sheet,
    along: Along,
    from: f64,
    per_height: f64,
    /// The angle of the left edge, and turns to the width.
    left: f64,
    per_width: f64,
    over: Pattern,
}

impl Label {
    pub(super) fn new(sticker: &Sticker) -> Self {
        let ([from, to], [left, right]) = (sticker.range, sticker.around);
        Self {
            sheet: Sheet::once(&sticker.image),
            along: sticker.along,
            from,
            per_height: 1.0 / (to - from),
            left: left / TAU,
            per_width: TAU / (right - left),
            over: Pattern::new(&sticker.over),
        }
    }

    pub(super) fn at(&self, spot: &Spot) -> Rgb {
        let below = self.over.at(spot);
        match self.window(spot) {
            Some(place) => self.sheet.at(place).over(below),
            None => below,
        }
    }

    /// Where in the picture a spot lies, from the lower left corner.
    fn window(&self, spot: &Spot) -> Option<[f64; 2]> {
        if !spot.front {
            return None;
        }
        let along = match self.along {
            Along::V => spot.uv[1],
            Along::Length => spot.uv[1] * spot.length,
            // The inner wall has the same heights, but faces the axis.
            Along::Z if spot.normal.x * spot.point.x + spot.normal.y * spot.point.y > 0.0 => {
                spot.point.z
            }
            Along::Z => return None,
        };
        let turn = spot.uv[0] - self.left;
        let x = (turn - turn.floor()) * self.per_width;
        let y = (along - self.from) * self.per_height;
        ((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y)).then_some([x, y])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rondure::Vec3;
    use rondure_scene::{Image, Paint};

    use super::*;

    fn label(along: Along, range: [f64; 2], around: [f64; 2]) -> Label {
        // White above, black below.
        let image = Arc::new(Image::new(1, 2, 1, vec![1.0, 0.0]).unwrap());
        let over = Paint::Solid([0.3; 3]);
        Label::new(&Sticker { image, along, range, around: around.map(f64::to_radians), over })
    }

    /// On a wall that faces outwards, at an angle in degrees.
    fn wall(degrees: f64, z: f64, v: f64) -> Spot {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Spot {
            uv: [(degrees / 360.0).rem_euclid(1.0), v],
            point: Vec3::new(2.0 * cos, 2.0 * sin, z),
            normal: Vec3::new(cos, sin, 0.0),
            length: 10.0,
            front: true,
            copy: 0,
        }
    }

    #[test]
    fn it_is_upright_in_its_window_and_nowhere_else() {
        let label = label(Along::Z, [1.0, 2.0], [-120.0, -60.0]);
        let at = |degrees, z| label.at(&wall(degrees, z, 0.5)).g;
        assert_eq!((at(-90.0, 1.9), at(-90.0, 1.1)), (1.0, 0.0));
        assert_eq!((at(-119.0, 1.9), at(-61.0, 1.9), at(299.0, 1.9)), (1.0, 1.0, 1.0));
        for (degrees, z) in [(-121.0, 1.5), (-59.0, 1.5), (90.0, 1.5), (-90.0, 0.9), (-90.0, 2.1)] {
            assert_eq!(at(degrees, z), 0.3, "{degrees} {z}");
        }
    }

    #[test]
    fn it_is_not_seen_from_behind_nor_on_the_inner_wall() {
        for along in [Along::Z, Along::V, Along::Length] {
            let range = if along == Along::Length { [4.0, 6.0] } else { [0.4, 0.6] };
            let label = label(along, range, [-180.0, 180.0]);
            let outside = wall(20.0, 0.55, 0.55);
            assert_eq!(label.at(&outside).g, 1.0);
            assert_eq!(label.at(&Spot { front: false, ..outside }).g, 0.3);
        }
        let label = label(Along::Z, [0.0, 1.0], [-180.0, 180.0]);
        let outside = wall(20.0, 0.9, 0.5);
        assert_eq!(label.at(&Spot { normal: -outside.normal, ..outside }).g, 0.3);
    }

    #[test]
    fn windows_go_over_the_seam() {
        let label = label(Along::V, [0.0, 1.0], [330.0, 390.0]);
        for degrees in [331.0, 0.0, 29.0] {
            assert_eq!(label.at(&wall(degrees, 0.0, 0.9)).g, 1.0, "{degrees}");
        }
        assert_eq!(label.at(&wall(40.0, 0.0, 0.9)).g, 0.3);
    }
}

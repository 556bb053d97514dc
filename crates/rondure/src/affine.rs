//! Affine maps, which place an object in the world.

use crate::{Vec3, numeric::difference_of_products};

/// An affine map p -> L p + translation; L is given by its columns, the images of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The images of the directions x, y and z.
    pub columns: [Vec3; 3],
    /// The image of the origin.
    pub translation: Vec3,
}

impl Default for Affine {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Affine {
    /// The map that leaves everything where it is.
    pub const IDENTITY: Self =
        Self { columns: [Vec3::X, Vec3::Y, Vec3::Z], translation: Vec3::ZERO };

    /// A shift.
    pub const fn translate(by: Vec3) -> Self {
        Self { columns: Self::IDENTITY.columns, translation: by }
    }

    /// A stretch along each axis; a negative factor mirrors.
    pub const fn scale(factors: Vec3) -> Self {
        Self {
            columns: [
                Vec3::new(factors.x, 0.0, 0.0),
                Vec3::new(0.0, factors.y, 0.0),
                Vec3::new(0.0, 0.0, factors.z),
            ],
            translation: Vec3::ZERO,
        }
    }

    /// The right-handed turn by `angle` radians round the direction `axis` through the origin
    /// (Rodrigues' formula). `axis` need not have unit length, but must not be zero.
    pub fn rotate(axis: Vec3, angle: f64) -> Self {
        let axis = axis.normalized();
        let (sin, cos) = angle.sin_cos();
        let turn = |v: Vec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
        Self { columns: [turn(Vec3::X), turn(Vec3::Y), turn(Vec3::Z)], translation: Vec3::ZERO }
    }

    /// A turn that carries the z axis to the direction `axis` the shortest way; where that is
    /// straight down, round the x axis.
    pub fn align_z(axis: Vec3) -> Self {
        let axis = axis.normalized();
        let across = Vec3::Z.cross(axis);
        if across.max_abs() == 0.0 {
            let sign = 1.0_f64.copysign(axis.z);
            return Self::scale(Vec3::new(1.0, sign, sign));
        }
        Self::rotate(across, across.length().atan2(axis.z))
    }

    /// The map "first `inner`, then this one".
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            columns: inner.columns.map(|c| self.vector(c)),
            translation: self.point(inner.translation),
        }
    }

    /// The image of a point.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.vector(p) + self.translation
    }

    /// The image of a direction: the linear part only.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.columns[0] * v.x + self.columns[1] * v.y + self.columns[2] * v.z
    }

    /// The determinant of the linear part: the factor by which volumes grow, negative if mirrored.
    pub fn determinant(&self) -> f64 {
        let [x, y, z] = self.columns;
        x.dot(cross_exactly(y, z))
    }

    /// The inverse of the linear part, by its rows; `None` if the map flattens space, is not
    /// finite, or is so large or small that its inverse is not.
    ///
    /// The rows are those of the adjugate over the determinant, each entry a difference of
    /// products that keeps what cancels.
    pub fn inverse_rows(&self) -> Option<[Vec3; 3]> {
        let [x, y, z] = self.columns;
        let determinant = self.determinant();
        let rows = [cross_exactly(y, z), cross_exactly(z, x), cross_exactly(x, y)]
            .map(|row| row / determinant);
        let flat = determinant == 0.0;
        (!flat && self.translation.is_finite() && rows.iter().all(|r| r.is_finite()))
            .then_some(rows)
    }
}

fn cross_exactly(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        difference_of_products(a.y, b.z, a.z, b.y),
        difference_of_products(a.z, b.x, a.x, b.z),
        difference_of_products(a.x, b.y, a.y, b.x),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes_the_map() {
        let map = Affine::rotate(Vec3::new(1.0, -2.0, 0.5), 0.7)
            .after(&Affine::scale(Vec3::new(2.0, -3.0, 0.25)));
        let rows = map.inverse_rows().unwrap();
        let v = Vec3::new(0.3, -0.4, 0.9);
        let image = map.vector(v);
        let back = Vec3::new(rows[0].dot(image), rows[1].dot(image), rows[2].dot(image));
        assert!((back - v).max_abs() < 1e-15);
        assert!((map.determinant() + 1.5).abs() < 1e-15);
    }

    #[test]
    fn align_z_reaches_every_direction() {
        for axis in
            [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(1e-9, 0.0, -1.0), Vec3::new(1.0, 2.0, 3.0)]
        {
            let map = Affine::align_z(axis);
            assert!((map.vector(Vec3::Z) - axis.normalized()).max_abs() < 1e-15);
            assert!((map.determinant() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn flat_maps_have_no_inverse() {
        assert!(Affine::scale(Vec3::new(1.0, 0.0, 1.0)).inverse_rows().is_none());
        assert!(Affine::scale(Vec3::splat(f64::NAN)).inverse_rows().is_none());
    }
}

//! Reliefs: normals turned as if the surface had bumps (Blinn 1978, "Simulation of Wrinkled Surfaces").
//!
//! A surface that is raised along its normal n by a small height h has, to the first order, the normal
//! n - grad h, with the gradient along the surface,
//!
//! ```text
//! grad h = (h_u p_v x n - h_v p_u x n) / n . (p_u x p_v)
//! ```
//!
//! All of it is done in the object's own frame, so that bumps look the same at any size.

use rondure::Vec3;
use rondure_scene::Relief as Described;

use super::{
    Spot,
    noise::{noise, random},
    sheet::Sheet,
};

/// A relief, ready to be looked up.
#[derive(Clone, Debug)]
pub(crate) enum Relief {
    Bump { sheet: Sheet, height: f64 },
    Noise { per_size: f64, height: f64, seed: Option<u32> },
    Normals { sheet: Sheet, strength: f64 },
}

impl Relief {
    pub(crate) fn new(relief: &Described) -> Self {
        match relief {
            Described::Bump { sheet, height } => {
                Self::Bump { sheet: Sheet::new(sheet), height: *height }
            }
            Described::Noise { size, height, seed } => {
                Self::Noise { per_size: 1.0 / size, height: *height, seed: *seed }
            }
            Described::Normals { sheet, strength } => {
                Self::Normals { sheet: Sheet::new(sheet), strength: *strength }
            }
        }
    }

    /// The turned normal, of unit length, on the side of the surface's own; all in the object's own frame.
    pub(crate) fn normal(&self, spot: &Spot, [dp_du, dp_dv]: [Vec3; 2]) -> Vec3 {
        let n = spot.normal;
        // Negative where the object is drawn so that its outside is to the left.
        let area = n.dot(dp_du.cross(dp_dv));
        let turned = match self {
            Self::Bump { sheet, height } => {
                let [h_u, h_v] = sheet.slopes(spot.uv).map(|slope| slope * height);
                n - (dp_dv.cross(n) * h_u - dp_du.cross(n) * h_v) / area
            }
            Self::Noise { per_size, height, seed } => {
                let mut p = spot.point * *per_size;
                let seed = seed.map_or(0, |seed| spot.seed(seed));
                p += Vec3::new(random(1, seed), random(2, seed), random(3, seed)) * 100.0;
                // Central differences over a thousandth of a grain: six digits are left.
                let step = 1e-3;
                let slope = |along: Vec3| {
                    (noise(p + along * step, seed) - noise(p - along * step, seed)) / (2.0 * step)
                };
                let slopes = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
                let slopes = slopes * (height * per_size);
                n - (slopes - n * n.dot(slopes))
            }
            Self::Normals { sheet, strength } => {
                let [x, y, z] = sheet.data(spot.uv).map(|c| 2.0 * c - 1.0);
                let along = dp_du.normalized();
                let up = n.cross(along) * 1.0_f64.copysign(area);
                along * (strength * x) + up * (strength * y) + n * z
            }
        };
        let turned = turned.normalized();
        // At a pole u has no direction; a normal map may hold any normal.
        if turned.is_finite() && turned.dot(n) > 0.0 { turned } else { n }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rondure_scene::{Image, Sheet as Lain, Wrap};

    use super::*;

    fn spot() -> Spot {
        Spot { uv: [0.5, 0.5], normal: Vec3::Z, ..Spot::default() }
    }

    fn lain(samples: Vec<f32>, channels: u32) -> Lain {
        let image = Image::new(8, 8, channels, samples).unwrap();
        Lain { image: Arc::new(image), size: [1.0; 2], offset: [0.0; 2], wrap: Wrap::Clamp }
    }

    /// A ramp of slope 1 along u, on a surface that u stretches by 2: a slope of 1/2.
    #[test]
    fn a_ramp_leans_the_normal_down_its_slope() {
        let samples = (0..64).map(|i| ((i % 8) as f32 + 0.5) / 8.0).collect();
        let relief = Relief::new(&Described::Bump { sheet: lain(samples, 1), height: 1.0 });
        let skewed = [Vec3::X * 2.0, Vec3::new(0.7, 3.0, 0.0)];
        for axes in [[Vec3::X * 2.0, Vec3::Y * 3.0], skewed] {
            let found = relief.normal(&spot(), axes);
            // The plane z = h(p) through p_u with h_u = 1 and h_v = 0.
            let lifted = [axes[0] + Vec3::Z, axes[1]];
            let expected = lifted[0].cross(lifted[1]).normalized();
            assert!((found - expected).max_abs() < 1e-7, "{found:?} {expected:?}");
        }
        // Seen by the partial derivatives of the other orientation the normal leans the same way.
        let found = relief.normal(&spot(), [Vec3::X * 2.0, -Vec3::Y]);
        assert!(found.x < 0.0 && found.z > 0.0, "{found:?}");
    }

    #[test]
    fn normals_come_from_the_map() {
        let samples = [1.0, 0.5, 1.0].repeat(64);
        let relief = Relief::new(&Described::Normals { sheet: lain(samples, 3), strength: 1.0 });
        let found = relief.normal(&spot(), [Vec3::Y, -Vec3::X]);
        let expected = Vec3::new(0.0, 1.0, 1.0).normalized();
        assert!((found - expected).max_abs() < 1e-7, "{found:?}");
        let flat = [0.5, 0.5, 1.0].repeat(64);
        let relief = Relief::new(&Described::Normals { sheet: lain(flat, 3), strength: 1.0 });
        assert!((relief.normal(&spot(), [Vec3::X, Vec3::Y]) - Vec3::Z).max_abs() < 1e-12);
    }

    #[test]
    fn noise_is_the_slope_of_what_is_raised() {
        let relief = Relief::Noise { per_size: 2.0, height: 0.1, seed: Some(4) };
        let mut turned = 0.0_f64;
        for i in 0..500 {
            let point = Vec3::new(f64::from(i) * 0.37, f64::from(i % 17) * 0.21, 0.0);
            let found = relief.normal(&Spot { point, ..spot() }, [Vec3::X, Vec3::Y]);
            assert!((found.length() - 1.0).abs() < 1e-12 && found.z > 0.5);
            turned = turned.max(found.x.hypot(found.y));
        }
        assert!(turned > 0.1);
    }

    #[test]
    fn where_u_has_no_direction_the_normal_stays() {
        let samples = (0..64).map(|i| i as f32 / 64.0).collect();
        let relief = Relief::new(&Described::Bump { sheet: lain(samples, 1), height: 1.0 });
        assert_eq!(relief.normal(&spot(), [Vec3::ZERO, Vec3::Y]), Vec3::Z);
    }
}

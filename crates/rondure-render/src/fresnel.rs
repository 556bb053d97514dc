//! How much light a boundary reflects, and where the rest goes.

use rondure::Vec3;

/// The reflectance of a smooth boundary for unpolarised light that comes at the cosine `cos_i`
/// (from 0 to 1) out of a medium of index `n_i` into one of index `n_t`, and the cosine on the
/// other side; `None` where all is reflected (Fresnel's equations; Born and Wolf, section 1.5.2).
#[inline]
pub(crate) fn dielectric(cos_i: f64, n_i: f64, n_t: f64) -> Option<(f64, f64)> {
    let eta = n_i / n_t;
    let sin2_t = eta * eta * (1.0 - cos_i) * (1.0 + cos_i);
    if sin2_t >= 1.0 {
        return None;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t);
    let across = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t);
    Some((0.5 * (parallel * parallel + across * across), cos_t))
}

/// The reflectance seen from outside of something with index `n` in air.
#[inline]
pub(crate) fn from_air(cos: f64, n: f64) -> f64 {
    dielectric(cos, 1.0, n).map_or(1.0, |(reflectance, _)| reflectance)
}

/// The reflectance of a thin sheet whose two sides each reflect `r`: all the ways to and fro added
/// up, r + (1 - r)^2 r (1 + r^2 + r^4 + ...) = 2 r / (1 + r).
#[inline]
pub(crate) fn sheet(r: f64) -> f64 {
    2.0 * r / (1.0 + r)
}

/// The direction mirrored at a surface with this normal, on either side of it.
#[inline]
pub(crate) fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// The direction beyond a boundary: `normal` faces the unit `direction`, whose cosine with it is
/// `cos_i`; `eta` is the index before over that behind (Snell's law).
#[inline]
pub(crate) fn refract(direction: Vec3, normal: Vec3, eta: f64, cos_i: f64, cos_t: f64) -> Vec3 {
    (direction * eta + normal * (eta * cos_i - cos_t)).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_on_and_grazing_are_the_closed_forms() {
        let (straight, cos_t) = dielectric(1.0, 1.0, 1.5).unwrap();
        assert!((straight - 0.04).abs() < 1e-15 && cos_t == 1.0);
        assert_eq!(from_air(0.0, 1.5), 1.0);
    }

    #[test]
    fn reflectance_at_sixty_degrees_is_the_closed_form() {
        // n = 3/2: cos_t = sqrt(2/3), r_s = (1 - sqrt 6) / (1 + sqrt 6).
        let (r, _) = dielectric(0.5, 1.0, 1.5).unwrap();
        let (root6, root) = (6.0_f64.sqrt(), (2.0_f64 / 3.0).sqrt());
        let across = ((1.0 - root6) / (1.0 + root6)).powi(2);
        let parallel = ((0.75 - root) / (0.75 + root)).powi(2);
        assert!((r - 0.5 * (across + parallel)).abs() < 1e-15);
    }

    #[test]
    fn polarised_light_vanishes_at_brewsters_angle() {
        let cos = (1.5_f64.atan()).cos();
        let (r, cos_t) = dielectric(cos, 1.0, 1.5).unwrap();
        let r_s = ((cos - 1.5 * cos_t) / (cos + 1.5 * cos_t)).powi(2);
        assert!((r - 0.5 * r_s).abs() < 1e-16);
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle() {
        let critical = (1.0_f64 / 1.5).asin();
        assert!(dielectric((critical - 1e-6).cos(), 1.5, 1.0).is_some());
        assert!(dielectric((critical + 1e-6).cos(), 1.5, 1.0).is_none());
    }

    #[test]
    fn both_ways_reflect_the_same() {
        for cos in [0.1, 0.5, 0.9] {
            let (there, cos_t) = dielectric(cos, 1.0, 1.7).unwrap();
            let (back, cos_i) = dielectric(cos_t, 1.7, 1.0).unwrap();
            assert!((there - back).abs() < 1e-14 && (cos - cos_i).abs() < 1e-14);
        }
    }

    #[test]
    fn refraction_obeys_snells_law() {
        let direction = Vec3::new(0.6, 0.0, -0.8);
        let (_, cos_t) = dielectric(0.8, 1.0, 1.5).unwrap();
        let refracted = refract(direction, Vec3::Z, 1.0 / 1.5, 0.8, cos_t);
        assert!((refracted - Vec3::new(0.4, 0.0, -0.84_f64.sqrt())).max_abs() < 1e-15);
    }
}

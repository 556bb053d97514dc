//! Gradient noise (Perlin 2002, "Improving Noise"): smooth, of no direction, the same on every machine.
//!
//! At each corner of a cubic lattice a hash of its coordinates chooses one of twelve gradients; in between
//! the corners' planes are blended by 6 t^5 - 15 t^4 + 10 t^3. The table of permutations is replaced by a
//! hash of 32 bits, so that nothing repeats.

use rondure::Vec3;

/// Noise with the grain size 1: between -1 and 1, 0 at the corners of the lattice.
pub(crate) fn noise(p: Vec3, seed: u32) -> f64 {
    let floor = [p.x.floor(), p.y.floor(), p.z.floor()];
    let [x, y, z] = [p.x - floor[0], p.y - floor[1], p.z - floor[2]];
    // Far out the lattice begins anew.
    let [i, j, k] = floor.map(|f| f as i64 as u32);
    let corner = |dx: u32, dy: u32, dz: u32| {
        let hash = hash([i.wrapping_add(dx), j.wrapping_add(dy), k.wrapping_add(dz)], seed);
        gradient(hash, x - f64::from(dx), y - f64::from(dy), z - f64::from(dz))
    };
    let [u, v, w] = [x, y, z].map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
    let edge = |dy, dz| mix(corner(0, dy, dz), corner(1, dy, dz), u);
    let face = |dz| mix(edge(0, dz), edge(1, dz), v);
    mix(face(0), face(1), w)
}

/// Noise of several sizes, each half as large and half as strong as the one before: between -2 and 2.
pub(crate) fn turbulence(mut p: Vec3, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut strength) = (0.0, 1.0);
    for octave in 0..octaves {
        sum += strength * noise(p, seed.wrapping_add(octave));
        strength *= 0.5;
        // Moved too, so that the corners of the lattices do not meet.
        p = p * 2.0 + Vec3::new(0.37, 0.71, 0.13);
    }
    sum
}

/// A number from 0 to 1 that belongs to a whole number.
pub(crate) fn random(of: u32, seed: u32) -> f64 {
    f64::from(hash([of, 0, 0], seed)) / f64::from(u32::MAX)
}

/// Two whole numbers made one.
pub(crate) fn mixed(a: u32, b: u32) -> u32 {
    hash([a, 0, 1], b)
}

/// Three numbers and a seed made one (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering": PCG).
fn hash([x, y, z]: [u32; 3], seed: u32) -> u32 {
    let step = |v: u32| {
        let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    step(x.wrapping_add(step(y.wrapping_add(step(z.wrapping_add(step(seed)))))))
}

/// The plane through a corner along one of the twelve directions to the middles of a cube's edges.
fn gradient(hash: u32, x: f64, y: f64, z: f64) -> f64 {
    let h = hash & 15;
    let u = if h < 8 { x } else { y };
    let v = match h {
        0..4 => y,
        12 | 14 => x,
        _ => z,
    };
    let sign = |bit: u32, value: f64| if h & bit == 0 { value } else { -value };
    sign(1, u) + sign(2, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> impl Iterator<Item = Vec3> {
        (0..20_000).map(|i| {
            let at = |k: u32| 40.0 * (random(i, k) - 0.5);
            Vec3::new(at(1), at(2), at(3))
        })
    }

    #[test]
    fn noise_is_centred_bounded_and_smooth() {
        let (mut sum, mut squares, mut steepest) = (0.0, 0.0, 0.0_f64);
        for p in places() {
            let value = noise(p, 5);
            assert!(value.abs() <= 1.0, "{p:?}: {value}");
            sum += value;
            squares += value * value;
            let step = Vec3::new(1e-6, -1e-6, 2e-6);
            steepest = steepest.max((noise(p + step, 5) - value).abs() / step.length());
        }
        assert!((sum / 20_000.0).abs() < 0.01 && (0.05..0.12).contains(&(squares / 20_000.0)));
        assert!(steepest < 4.0, "{steepest}");
        assert_eq!(noise(Vec3::new(3.0, -4.0, 7.0), 1), 0.0);
    }

    #[test]
    fn noise_goes_over_the_edges_of_the_lattice_without_a_step() {
        for p in places().take(2000) {
            let edge = Vec3::new(p.x.floor(), p.y, p.z);
            let before = noise(edge - Vec3::new(1e-9, 0.0, 0.0), 0);
            assert!((noise(edge, 0) - before).abs() < 1e-7);
        }
    }

    /// The same numbers on every machine.
    #[test]
    fn noise_is_what_it_was() {
        let found = noise(Vec3::new(0.5, 1.25, -2.75), 7);
        assert_eq!(found, noise(Vec3::new(0.5, 1.25, -2.75), 7));
        assert!(noise(Vec3::new(0.5, 1.25, -2.75), 8) != found);
        assert_eq!(hash([1, 2, 3], 4), hash([1, 2, 3], 4));
        assert!((noise(Vec3::splat(1e300), 0)).abs() <= 1.0);
    }
}

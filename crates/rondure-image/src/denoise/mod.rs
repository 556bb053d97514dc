//! Takes the noise out of a picture: nonlinearly weighted first-order regression (Bitterli, Rousselle, Moon, Iglesias-Guitián, Adler,
//! Mitchell, Jarosz and Novák 2016).
//!
//! Around every pixel, light is taken for a linear function of what is known without noise, or with less: albedo, normal, place in the
//! picture. It is fitted to the pixels whose surroundings look alike but for noise (`patch`), by least squares (`fit`), and what it says of the
//! pixel in the middle is the result. At a silhouette albedo and normal of a pixel are the mixture of both sides' that its light is, too: the
//! function is linear there of itself, and the edge stays what it was, antialiased, with nothing of either side in the other.

mod fit;
mod patch;
mod spark;

use rayon::prelude::*;

use self::{fit::Fit, patch::Distances};

/// How far from a pixel others are looked at.
const REACH: i32 = 9;
/// Weights below this are not worth the work: together they count less than one alike pixel.
const LEAST_WEIGHT: f32 = 0.01;
/// The weight of pixels that are quite unlike: they are what is left for one that is unknown and has nobody alike. It counts for nothing
/// beside any other, and is far from the least that f32 holds with all digits, 1e-38.
const HARDLY: f32 = 1e-20;
/// What a step of one pixel counts as a feature: the window is then as wide as the range of a channel of the albedo, or less.
const STEP: f32 = 0.02;
/// The edge of what a thread takes at once, in pixels. The result does not depend on it.
const TILE: i32 = 32;

/// A picture with what is known about its pixels, rows from the top.
#[derive(Clone, Copy, Debug)]
pub struct Layers<'a> {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The light.
    pub light: &'a [[f32; 3]],
    /// The variance of the light, of each channel.
    pub variance: &'a [[f32; 3]],
    /// The mean albedo of what is seen.
    pub albedo: &'a [[f32; 3]],
    /// The mean normal of what is seen; shorter than 1 where there are several.
    pub normal: &'a [[f32; 3]],
}

/// Why a picture cannot be denoised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DenoiseError {
    /// The layers have different numbers of pixels.
    #[error("the layer of {layer} has {found} pixels, not {expected}")]
    Size {
        /// Which.
        layer: &'static str,
        /// How many it has.
        found: usize,
        /// How many the picture has.
        expected: u64,
    },
    /// The variance says nothing anywhere: less than two samples.
    #[error("the variance of no pixel is known; it takes two samples of each")]
    NoVariance,
}

/// The picture without its noise. Pixels whose light or variance is no number, or infinite, are made from the others around.
///
/// # Errors
/// If a layer has another number of pixels, or no variance is known.
pub fn denoise(layers: &Layers<'_>) -> Result<Vec<[f32; 3]>, DenoiseError> {
    let expected = u64::from(layers.width) * u64::from(layers.height);
    let all = [
        ("the light", layers.light),
        ("the variance", layers.variance),
        ("the albedo", layers.albedo),
        ("the normal", layers.normal),
    ];
    for (layer, pixels) in all {
        if pixels.len() as u64 != expected {
            return Err(DenoiseError::Size { layer, found: pixels.len(), expected });
        }
    }
    let scene = Scene::new(layers);
    if expected > 0 && !scene.known.iter().any(|known| *known) {
        return Err(DenoiseError::NoVariance);
    }
    let [width, height] = scene.size;
    let starts = |length: i32| (0..length).step_by(TILE as usize);
    let corners: Vec<_> = starts(height).flat_map(|y| starts(width).map(move |x| [x, y])).collect();
    let window = |[x, y]: [i32; 2]| Window {
        corner: [x, y],
        size: [TILE.min(width - x), TILE.min(height - y)],
    };
    let tiles: Vec<_> = corners
        .into_par_iter()
        .map(|corner| (window(corner), scene.tile(&window(corner))))
        .collect();
    let mut result = vec![[0.0; 3]; scene.light.len()];
    for (window, pixels) in tiles {
        for (i, pixel) in window.pixels().zip(pixels) {
            result[scene.index(i)] = pixel;
        }
    }
    Ok(result)
}

/// A rectangle of the picture.
#[derive(Clone, Copy, Debug)]
struct Window {
    corner: [i32; 2],
    size: [i32; 2],
}

impl Window {
    fn pixels(&self) -> impl Iterator<Item = [i32; 2]> + use<> {
        let ([x, y], [width, height]) = (self.corner, self.size);
        (y..y + height).flat_map(move |y| (x..x + width).map(move |x| [x, y]))
    }
}

/// The layers, as they are used.
struct Scene {
    size: [i32; 2],
    light: Vec<[f32; 3]>,
    variance: Vec<[f32; 3]>,
    /// Albedo and normal.
    features: Vec<[f32; 6]>,
    /// Whether light and variance of a pixel are numbers, and more than one stray sample.
    known: Vec<bool>,
}

impl Scene {
    fn new(layers: &Layers<'_>) -> Self {
        let number = |v: f32| if v.is_finite() { v } else { 0.0 };
        let finite = |pixel: &[f32; 3]| pixel.iter().all(|v| v.is_finite());
        let both = layers.light.iter().zip(layers.variance);
        let features = layers
            .albedo
            .iter()
            .zip(layers.normal)
            .map(|(a, n)| [a[0], a[1], a[2], n[0], n[1], n[2]].map(number));
        let mut scene = Self {
            size: [layers.width as i32, layers.height as i32],
            light: layers.light.iter().map(|pixel| pixel.map(number)).collect(),
            variance: layers.variance.iter().map(|p| p.map(|v| number(v).max(0.0))).collect(),
            features: features.collect(),
            known: both.map(|(light, variance)| finite(light) && finite(variance)).collect(),
        };
        let sparks = spark::sparks(&scene);
        for (known, spark) in scene.known.iter_mut().zip(sparks) {
            *known &= !spark;
        }
        scene
    }

    fn index(&self, [x, y]: [i32; 2]) -> usize {
        (y * self.size[0] + x) as usize
    }

    fn is_inside(&self, [x, y]: [i32; 2]) -> bool {
        (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y)
    }

    /// The pixels of a window without their noise.
    fn tile(&self, window: &Window) -> Vec<[f32; 3]> {
        let mut fits: Vec<_> = window.pixels().map(|_| Fit::default()).collect();
        let mut distances = Distances::new(self, window);
        for dy in -REACH..=REACH {
            for dx in -REACH..=REACH {
                let distances = distances.of([dx, dy]);
                for ((p, fit), distance) in window.pixels().zip(&mut fits).zip(distances) {
                    let q = [p[0] + dx, p[1] + dy];
                    if !self.is_inside(q) {
                        continue;
                    }
                    let (p, q) = (self.index(p), self.index(q));
                    let alike = (-distance.max(0.0)).exp();
                    // Of what is unknown, what is least unlike is the best there is.
                    let (weight, least) = if self.known[p] {
                        (alike, LEAST_WEIGHT)
                    } else {
                        (alike.max(HARDLY), HARDLY)
                    };
                    if !self.known[q] || weight < least {
                        continue;
                    }
                    let (a, b) = (&self.features[p], &self.features[q]);
                    let place = [STEP * dx as f32, STEP * dy as f32];
                    let features = core::array::from_fn(|i| match i {
                        0..6 => b[i] - a[i],
                        _ => place[i - 6],
                    });
                    fit.add(weight, &features, &self.light[q], &self.variance[q]);
                }
            }
        }
        fits.iter().map(Fit::center).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture without noise: a sphere of one albedo before a checkered wall of two, lit from the left, with antialiased edges.
    struct Study {
        size: u32,
        light: Vec<[f32; 3]>,
        albedo: Vec<[f32; 3]>,
        normal: Vec<[f32; 3]>,
    }

    fn study() -> Study {
        let size = 64;
        let mut study = Study { size, light: Vec::new(), albedo: Vec::new(), normal: Vec::new() };
        for i in 0..size * size {
            let (x, y) = (f64::from(i % size), f64::from(i / size));
            let (mut light, mut albedo, mut normal) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            for s in 0..64 {
                let (u, v) = (x + f64::from(s % 8) / 8.0, y + f64::from(s / 8) / 8.0);
                let (a, b) = ((u - 32.0) / 20.0, (v - 32.0) / 20.0);
                let r = a * a + b * b;
                let (base, n) = if r < 1.0 {
                    ([0.7, 0.3, 0.2], [a, b, (1.0 - r).sqrt()])
                } else if ((u / 16.0) as u32 + (v / 16.0) as u32).is_multiple_of(2) {
                    ([0.8, 0.8, 0.7], [0.0, 0.0, 1.0])
                } else {
                    ([0.2, 0.3, 0.4], [0.0, 0.0, 1.0])
                };
                let shade = 0.3 + (0.6 * n[2] - 0.5 * n[0]).max(0.0) + 0.002 * u;
                for c in 0..3 {
                    light[c] += base[c] * shade / 64.0;
                    albedo[c] += base[c] / 64.0;
                    normal[c] += n[c] / 64.0;
                }
            }
            study.light.push(light.map(|v| v as f32));
            study.albedo.push(albedo.map(|v| v as f32));
            study.normal.push(normal.map(|v| v as f32));
        }
        study
    }

    /// Normally distributed numbers, by Box and Muller of a congruential generator.
    fn normals() -> impl FnMut() -> f32 {
        let mut state = 7_u64;
        let mut uniform = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as f64 + 0.5) / (1_u64 << 31) as f64
        };
        move || {
            let (a, b) = (uniform(), uniform());
            ((-2.0 * a.ln()).sqrt() * (core::f64::consts::TAU * b).cos()) as f32
        }
    }

    /// The picture with noise of this share of its light, and the variance of that.
    fn noisy(study: &Study, share: f32) -> [Vec<[f32; 3]>; 2] {
        let mut normal = normals();
        let light = study.light.iter().map(|p| p.map(|v| (v * (1.0 + share * normal())).max(0.0)));
        let variance = study.light.iter().map(|p| p.map(|v| (v * share).powi(2)));
        [light.collect(), variance.collect()]
    }

    fn layers<'a>(study: &'a Study, [light, variance]: &'a [Vec<[f32; 3]>; 2]) -> Layers<'a> {
        let (width, height) = (study.size, study.size);
        Layers { width, height, light, variance, albedo: &study.albedo, normal: &study.normal }
    }

    fn error(a: &[[f32; 3]], b: &[[f32; 3]], counts: impl Fn(usize) -> bool) -> f64 {
        let pairs = a.iter().zip(b).enumerate().filter(|(i, _)| counts(*i));
        let one = |(a, b): (&[f32; 3], &[f32; 3])| -> f64 {
            a.iter()
                .zip(b)
                .map(|(a, b)| f64::from(a - b).powi(2) / (f64::from(*b).powi(2) + 0.01))
                .sum()
        };
        pairs.clone().map(|(_, pair)| one(pair)).sum::<f64>() / (3 * pairs.count()) as f64
    }

    /// Whether a pixel is a mixture of the sphere and the wall.
    fn is_silhouette(study: &Study, i: usize) -> bool {
        let (x, y) = (i as u32 % study.size, i as u32 / study.size);
        let r = (f64::from(x) + 0.5 - 32.0).hypot(f64::from(y) + 0.5 - 32.0);
        (r - 20.0).abs() < 0.7
    }

    #[test]
    fn noise_goes_and_silhouettes_stay() {
        let study = study();
        let noisy = noisy(&study, 0.25);
        let clean = denoise(&layers(&study, &noisy)).unwrap();
        let gain = |counts: &dyn Fn(usize) -> bool| {
            error(&noisy[0], &study.light, counts) / error(&clean, &study.light, counts)
        };
        let all = gain(&|_| true);
        assert!(all > 15.0, "{all}");
        let silhouette = gain(&|i| is_silhouette(&study, i));
        assert!(silhouette > 2.0, "{silhouette}");
    }

    #[test]
    fn what_has_no_noise_stays() {
        let study = study();
        let clean = [study.light.clone(), vec![[0.0; 3]; study.light.len()]];
        let result = denoise(&layers(&study, &clean)).unwrap();
        for (a, b) in result.iter().flatten().zip(study.light.iter().flatten()) {
            assert!((a - b).abs() < 2e-5, "{a} {b}");
        }
    }

    #[test]
    fn a_pixel_that_is_no_number_is_made_from_the_others() {
        let study = study();
        let mut noisy = noisy(&study, 0.1);
        noisy[0][700] = [f32::NAN; 3];
        noisy[1][900] = [f32::INFINITY; 3];
        noisy[0][900] = [1e6; 3];
        let result = denoise(&layers(&study, &noisy)).unwrap();
        for (i, pixel) in result.iter().enumerate() {
            for (a, b) in pixel.iter().zip(study.light[i]) {
                assert!(a.is_finite() && (a - b).abs() < 0.3, "{i}: {a} {b}");
            }
        }
    }

    /// The slanted edge of a shadow on paper, with little noise, of which albedo and normals know nothing: along it every second pixel looks
    /// alike. One pixel there has a stray sample, which must not be drawn along the edge in dots.
    #[test]
    fn a_spark_is_not_drawn_along_an_edge() {
        let size = 40;
        let mut normal = normals();
        let mut study = Study { size, light: Vec::new(), albedo: Vec::new(), normal: Vec::new() };
        for i in 0..size * size {
            let (x, y) = (f64::from(i % size), f64::from(i / size));
            let lit = (0.5 * x + y - 30.0 + 0.5).clamp(0.0, 1.0) as f32;
            study.light.push([0.2 + 0.4 * lit; 3]);
            study.albedo.push([0.7; 3]);
            study.normal.push([0.0, 0.0, 1.0]);
        }
        let deviation = 0.005;
        let light = study.light.iter().map(|p| p.map(|v| v + deviation * normal())).collect();
        let mut noisy = [light, vec![[deviation * deviation; 3]; study.light.len()]];
        let spark = (20 * size + 20) as usize;
        noisy[0][spark] = noisy[0][spark].map(|v| v + 2.0);
        noisy[1][spark] = [4.0; 3];
        let clean = denoise(&layers(&study, &noisy)).unwrap();
        for (i, (a, b)) in clean.iter().zip(&study.light).enumerate() {
            let limit = if i == spark { 0.1 } else { 0.03 };
            assert!((a[0] - b[0]).abs() < limit, "{i}: {} {}", a[0], b[0]);
        }
    }

    #[test]
    fn layers_must_fit() {
        let study = study();
        let noisy = noisy(&study, 0.1);
        let bad = Layers { albedo: &study.albedo[1..], ..layers(&study, &noisy) };
        let error = denoise(&bad).unwrap_err();
        assert_eq!(error.to_string(), "the layer of the albedo has 4095 pixels, not 4096");
        let unknown = [noisy[0].clone(), vec![[f32::INFINITY; 3]; 4096]];
        assert_eq!(denoise(&layers(&study, &unknown)), Err(DenoiseError::NoVariance));
        // A picture of one pixel, and one of a row.
        for (width, height) in [(1, 1), (40, 1)] {
            let n = (width * height) as usize;
            let small = Layers {
                width,
                height,
                light: &noisy[0][..n],
                variance: &noisy[1][..n],
                albedo: &study.albedo[..n],
                normal: &study.normal[..n],
            };
            assert_eq!(denoise(&small).unwrap().len(), n);
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let study = study();
        let noisy = noisy(&study, 0.25);
        let layers = layers(&study, &noisy);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one.install(|| denoise(&layers)), denoise(&layers));
    }
}

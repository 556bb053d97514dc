//! FLIP: how different two pictures look to somebody who flips between them (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and
//! Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images").
//!
//! 0 is no difference, 1 the largest there is. Colours are blurred as the eye does at a viewing distance, then compared in a perceptually
//! even space (color difference dc); edges and points are found by derivatives of Gaussians, and what one picture has and
//! the other has not (df) makes the difference there stand out: dc^(1 - df).

use core::f64::consts::{FRAC_1_SQRT_2, PI};

use rayon::prelude::*;

use crate::{matrix, matrix::Matrix};

/// Pixels in a degree of the field of view: a monitor 0.7 m wide with 3840 pixels, 0.7 m away, as in the paper.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// The exponent of colour differences, the share of the largest difference from which they are compressed, and what that is mapped to.
const COLOR_POWER: f64 = 0.7;
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;
/// The width of edges that the eye sees best, in degrees, and the exponent of feature differences.
const FEATURE: f64 = 0.082;
const FEATURE_POWER: f64 = 0.5;

/// The contrast sensitivity of the eye as Gaussians in frequency, a sqrt(pi / b) exp(-pi^2 x^2 / b): of luminance, of red against
/// green, and two that are added for blue against yellow.
const LUMINANCE: [f64; 2] = [1.0, 0.0047];
const RED_GREEN: [f64; 2] = [1.0, 0.0053];
const BLUE_YELLOW: [[f64; 2]; 2] = [[34.1, 0.04], [13.5, 0.025]];

/// From linear Rec. 709 to XYZ, with the fractions of the paper's code.
const TO_XYZ: Matrix = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The difference of each pixel, from 0 to 1, of two pictures of this size in linear light that lies
/// between 0 and 1; what lies outside is cut off.
///
/// # Panics
/// Never; pictures that are not of this size give no pixels.
pub fn flip(
    a: &[[f64; 3]],
    b: &[[f64; 3]],
    [width, height]: [u32; 2],
    pixels_per_degree: f64,
) -> Vec<f64> {
    let (width, height) = (width as usize, height as usize);
    if a.len() != width * height || b.len() != a.len() || a.is_empty() {
        return Vec::new();
    }
    let [a, b] = [a, b].map(|pixels| Seen::new(pixels, width, pixels_per_degree));
    let largest = difference(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0]));
    let knee = KNEE * largest;
    (0..width * height)
        .into_par_iter()
        .map(|i| {
            let color = difference(a.colors[i], b.colors[i]);
            let color = if color < knee {
                color * KNEE_VALUE / knee
            } else {
                KNEE_VALUE + (color - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
            };
            let (edges, points) = (a.edges[i] - b.edges[i], a.points[i] - b.points[i]);
            let feature = (FRAC_1_SQRT_2 * edges.abs().max(points.abs())).powf(FEATURE_POWER);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// A picture as it is seen: its blurred colours in Hunt-adjusted CIELAB, and how much of an edge and of a point each pixel is.
struct Seen {
    colors: Vec<[f64; 3]>,
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Seen {
    fn new(pixels: &[[f64; 3]], width: usize, pixels_per_degree: f64) -> Self {
        let white = TO_XYZ.map(|row| row.iter().sum::<f64>());
        // YCxCz: CIELAB without the cube roots, so that it may be blurred.
        let opponent: Vec<[f64; 3]> = pixels
            .par_iter()
            .map(|pixel| {
                let xyz = matrix::apply(&TO_XYZ, pixel.map(|v| v.clamp(0.0, 1.0)));
                let [x, y, z] = [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]];
                [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
            })
            .collect();
        let plane = |channel: usize| Plane {
            width,
            values: opponent.iter().map(|color| color[channel]).collect(),
        };
        let radius = {
            let widest = BLUE_YELLOW[0][1];
            (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32
        };
        let gaussian = |[a, b]: [f64; 2]| -> Vec<f64> {
            // Both directions take half of the factor.
            let height = (a * (PI / b).sqrt()).sqrt();
            let value = |i: i32| {
                let x = f64::from(i) / pixels_per_degree;
                height * (-PI * PI * x * x / b).exp()
            };
            (-radius..=radius).map(value).collect()
        };
        let normalized = |kernel: Vec<f64>| scaled(&kernel, 1.0 / kernel.iter().sum::<f64>());
        let luminance = plane(0);
        let (across, along) = (normalized(gaussian(LUMINANCE)), normalized(gaussian(RED_GREEN)));
        let (y, cx) = (luminance.filtered(&across, &across), plane(1).filtered(&along, &along));
        let [first, second] = BLUE_YELLOW.map(gaussian);
        let [s, t] = [&first, &second].map(|kernel| kernel.iter().sum::<f64>());
        let norm = 1.0 / s.hypot(t);
        let [first, second] = [scaled(&first, norm), scaled(&second, norm)];
        let blue = plane(2);
        let cz = [blue.filtered(&first, &first), blue.filtered(&second, &second)];
        let back = matrix::inverse(&TO_XYZ);
        let colors = (0..pixels.len())
            .into_par_iter()
            .map(|i| {
                let y = (y.values[i] + 16.0) / 116.0;
                let x = y + cx.values[i] / 500.0;
                let z = y - (cz[0].values[i] + cz[1].values[i]) / 200.0;
                let rgb = matrix::apply(&back, [x * white[0], y * white[1], z * white[2]]);
                hunt(rgb.map(|v| v.clamp(0.0, 1.0)))
            })
            .collect();
        let [flat, first, second] = derivatives(pixels_per_degree);
        let grey = Plane {
            values: luminance.values.iter().map(|y| (y + 16.0) / 116.0).collect(),
            ..luminance
        };
        let size = |kernel: &[f64]| -> Vec<f64> {
            let (x, y) = (grey.filtered(kernel, &flat), grey.filtered(&flat, kernel));
            x.values.iter().zip(&y.values).map(|(x, y)| x.hypot(*y)).collect()
        };
        Self { colors, edges: size(&first), points: size(&second) }
    }
}

/// A Gaussian and its first two derivatives, as wide as the eye sees edges best. The Gaussian has the sum 1, of the others the positive
/// part 1 and the negative part -1.
fn derivatives(pixels_per_degree: f64) -> [Vec<f64>; 3] {
    let deviation = 0.5 * FEATURE * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i32;
    let kernel = |value: fn(f64) -> f64| -> Vec<f64> {
        let scaled = |i| {
            let x = f64::from(i) / deviation;
            value(x) * (-0.5 * x * x).exp()
        };
        let kernel: Vec<f64> = (-radius..=radius).map(scaled).collect();
        let part = |sign: f64| kernel.iter().map(|v| (sign * v).max(0.0)).sum::<f64>();
        let (above, below) = (part(1.0), part(-1.0));
        let one = |v: &f64| match *v {
            v if v > 0.0 => v / above,
            v if v < 0.0 => v / below,
            _ => 0.0,
        };
        kernel.iter().map(one).collect()
    };
    [kernel(|_| 1.0), kernel(|x| -x), kernel(|x| x * x - 1.0)]
}

fn scaled(kernel: &[f64], factor: f64) -> Vec<f64> {
    kernel.iter().map(|v| v * factor).collect()
}

/// CIELAB of linear Rec. 709, with colourfulness in proportion to lightness, as Hunt found.
fn hunt(rgb: [f64; 3]) -> [f64; 3] {
    let white = TO_XYZ.map(|row| row.iter().sum::<f64>());
    let xyz = matrix::apply(&TO_XYZ, rgb);
    let [x, y, z] = [0, 1, 2].map(|i| {
        const DELTA: f64 = 6.0 / 29.0;
        let t: f64 = xyz[i] / white[i];
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The HyAB distance of two colours (Abasi et al. 2020), to the power of colour differences.
fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])).powf(COLOR_POWER)
}

/// One channel.
struct Plane {
    width: usize,
    values: Vec<f64>,
}

impl Plane {
    /// Convolved with one kernel across and one down; beyond the edges the last pixel goes on.
    fn filtered(&self, across: &[f64], down: &[f64]) -> Self {
        let width = self.width;
        let reach = across.len() / 2;
        let rows: Vec<f64> = self
            .values
            .par_chunks(width)
            .flat_map_iter(|row| {
                let padded: Vec<f64> = (0..width + 2 * reach)
                    .map(|x| row[x.saturating_sub(reach).min(width - 1)])
                    .collect();
                (0..width).map(move |x| {
                    padded[x..x + across.len()].iter().zip(across).map(|(v, k)| v * k).sum()
                })
            })
            .collect();
        let height = rows.len() / width;
        let reach = down.len() / 2;
        let column = |y: usize| {
            let mut sums = vec![0.0; width];
            for (i, k) in down.iter().enumerate() {
                let from = (y + i).saturating_sub(reach).min(height - 1) * width;
                for (sum, v) in sums.iter_mut().zip(&rows[from..from + width]) {
                    *sum += k * v;
                }
            }
            sums
        };
        Self { width, values: (0..height).into_par_iter().flat_map_iter(column).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [40, 30];

    /// Two pictures in linear light, one with a patch, a line and a ripple.
    fn pictures() -> [Vec<[f64; 3]>; 2] {
        let mut pictures = [Vec::new(), Vec::new()];
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let (fx, fy) = (f64::from(x), f64::from(y));
                let a = [fx / 40.0, fy / 30.0, 0.5 + 0.4 * (fx * fy / 30.0).sin()];
                let b = match (x, y) {
                    (5, _) => [0.1; 3],
                    (15..30, 10..20) => [0.9, 0.2, 0.1],
                    _ => a,
                };
                let b = b.map(|v| v + 0.05 * (fx * 1.7 + fy).cos());
                pictures[0].push(a.map(crate::tone::linear));
                pictures[1].push(b.map(|v| crate::tone::linear(v.clamp(0.0, 1.0))));
            }
        }
        pictures
    }

    /// What the authors' package flip-evaluator 1.7 gives, in f32.
    #[test]
    fn the_authors_figures() {
        let [a, b] = pictures();
        let all = flip(&a, &b, SIZE, PIXELS_PER_DEGREE);
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
        assert!((mean(&all) - 0.218_786_8).abs() < 2e-5, "{}", mean(&all));
        let known = [
            (0, 0, 0.111_216_2),
            (5, 3, 0.237_777_8),
            (15, 10, 0.645_432_0),
            (22, 15, 0.887_140_5),
            (39, 29, 0.175_158_9),
            (30, 12, 0.298_820_3),
        ];
        for (x, y, expected) in known {
            let value = all[y * 40 + x];
            assert!((value - expected).abs() < 2e-4, "({x}, {y}): {value} {expected}");
        }
        let near = flip(&a, &b, SIZE, 30.0);
        assert!((mean(&near) - 0.282_294_5).abs() < 2e-5, "{}", mean(&near));
    }

    #[test]
    fn nothing_and_everything() {
        let [a, b] = pictures();
        assert!(flip(&a, &a, SIZE, PIXELS_PER_DEGREE).iter().all(|v| *v == 0.0));
        let (ab, ba) = (flip(&a, &b, SIZE, 67.0), flip(&b, &a, SIZE, 67.0));
        assert_eq!(ab, ba);
        assert!(ab.iter().all(|v| (0.0..=1.0).contains(v)));
        let plain = |color| vec![color; 1200];
        let most = flip(&plain([0.0, 1.0, 0.0]), &plain([0.0, 0.0, 1.0]), SIZE, 67.0);
        assert!(most.iter().all(|v| (v - 1.0).abs() < 1e-9));
        assert!(flip(&a, &b[1..], SIZE, 67.0).is_empty());
    }
}

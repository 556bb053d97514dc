//! Makes `scenes/studio.exr`, the light of a photographer's studio as a picture of all directions: a large
//! soft box from the left, a smaller one from the right, a strip behind for the rim, a lamp above, before
//! walls that fade from a pale floor to a dark ceiling.
//!
//! ```text
//! cargo run --release -p rondure-scene --example studio -- scenes/studio.exr
//! ```

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use exr::prelude::{
    Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels, Vec2,
    WritableImage, f16,
};
use rondure::Vec3;

const SIZE: Vec2<usize> = Vec2(1024, 512);

/// A lit rectangle.
struct SoftBox {
    /// The direction of its middle.
    toward: Vec3,
    /// Half its width and height at the distance 1.
    half: [f64; 2],
    radiance: [f64; 3],
}

impl SoftBox {
    /// The radiance from a direction: a little less towards the edges, which are soft.
    fn light(&self, direction: Vec3) -> [f64; 3] {
        let toward = self.toward.normalized();
        let ahead = direction.dot(toward);
        if ahead <= 0.0 {
            return [0.0; 3];
        }
        let across =
            if toward.z.abs() > 0.99 { Vec3::X } else { toward.cross(Vec3::Z).normalized() };
        let up = across.cross(toward);
        let x = direction.dot(across) / ahead / self.half[0];
        let y = direction.dot(up) / ahead / self.half[1];
        let edge = |x: f64, half: f64| {
            let inside = ((1.0 - x.abs()) * half / 0.02 + 0.5).clamp(0.0, 1.0);
            inside * inside * (3.0 - 2.0 * inside)
        };
        let bright = edge(x, self.half[0]) * edge(y, self.half[1]);
        self.radiance.map(|c| c * bright * (1.0 - 0.25 * (x * x + y * y).min(1.0)))
    }
}

fn radiance(direction: Vec3, boxes: &[SoftBox]) -> [f64; 3] {
    let height = 0.5 * (1.0 + direction.z);
    let wall = [0.34, 0.33, 0.32].map(|c| c * (1.0 - height).powi(2) + 0.02);
    boxes
        .iter()
        .map(|soft| soft.light(direction))
        .fold(wall, |sum, light| [sum[0] + light[0], sum[1] + light[1], sum[2] + light[2]])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("which file shall be written?")?;
    let boxes = [
        SoftBox {
            toward: Vec3::new(-1.0, -0.45, 0.65),
            half: [0.55, 0.75],
            radiance: [9.0, 8.8, 8.4],
        },
        SoftBox { toward: Vec3::new(1.0, -0.2, 0.3), half: [0.3, 0.7], radiance: [3.0, 3.1, 3.3] },
        SoftBox {
            toward: Vec3::new(0.55, 1.0, 0.45),
            half: [0.12, 0.8],
            radiance: [7.0, 7.0, 7.2],
        },
        SoftBox { toward: Vec3::Z, half: [0.5, 0.35], radiance: [2.5, 2.5, 2.5] },
    ];
    let pixel = |at: Vec2<usize>| {
        let u = (at.x() as f64 + 0.5) / SIZE.x() as f64;
        let v = (at.y() as f64 + 0.5) / SIZE.y() as f64;
        let (sin, cos) = (PI * v).sin_cos();
        let (y, x) = (FRAC_PI_2 - TAU * (u - 0.5)).sin_cos();
        let [r, g, b] = radiance(Vec3::new(sin * x, sin * y, cos), &boxes).map(f16::from_f64);
        (r, g, b)
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        line_order: LineOrder::Increasing,
        ..Encoding::default()
    };
    let layer =
        Layer::new(SIZE, LayerAttributes::default(), encoding, SpecificChannels::rgb(pixel));
    Image::from_layer(layer).write().to_file(path)?;
    Ok(())
}

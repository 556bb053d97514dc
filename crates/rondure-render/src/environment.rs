//! Light from a picture of all directions (equirectangular, z up), and directions chosen by how much light
//! comes from them.
//!
//! The radiance is interpolated between the middles of pixels, round the seam and as the outermost rows
//! have it at the poles. A direction is chosen by pixel (Pharr, Jakob and Humphreys, "Physically Based
//! Rendering", 4th ed., 12.5): a row by its share of the light, a column by its share of the row,
//! and a place in the pixel evenly by solid angle. With L the luminance of a pixel, a mean over it
//! of what is interpolated, and W its solid angle, the density by solid angle is
//!
//! ```text
//! pdf = L / sum(L W)
//! ```
//!
//! without a sine that vanishes at the poles. In one dimension the mean over a pixel is 1/8 of its
//! neighbours and 3/4 of itself: so no direction that light comes from has the density 0.

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use rondure::Vec3;
use rondure_scene::Image;

use crate::{color::Rgb, light::Incoming};

/// A picture of all directions that gives light.
#[derive(Clone, Debug)]
pub(crate) struct Environment {
    image: Arc<Image>,
    intensity: f64,
    /// The cosine and the sine of the angle by which the picture is turned about z.
    turn: [f64; 2],
    /// The light of the rows before each, and of all.
    rows: Vec<f64>,
    /// For each row the light of the pixels before each, and of all of them: W + 1 numbers a row.
    pixels: Vec<f64>,
    brightest: Rgb,
}

impl Environment {
    pub(crate) fn new(image: Arc<Image>, intensity: f64, rotation: f64) -> Self {
        let (width, height) = (image.width(), image.height());
        let luminance = |x: u32, y: u32| {
            let [r, g, b, _] = image.pixel(x, y).map(f64::from);
            Rgb { r, g, b }.luminance()
        };
        let mut rows = Vec::with_capacity(height as usize + 1);
        let mut pixels = Vec::with_capacity(height as usize * (width as usize + 1));
        let (mut light, mut brightest) = (0.0, Rgb::BLACK);
        rows.push(light);
        // The means across the row above, in this one and below.
        let across = |y: u32| -> Vec<f64> {
            let at = |x: u32| luminance(x % width, y);
            (0..width).map(|x| mean(at(x + width - 1), at(x), at(x + 1))).collect()
        };
        let mut around = [across(0), across(0), across(1.min(height - 1))];
        for y in 0..height {
            let solid_angle = band(y, height) * TAU / f64::from(width);
            let mut sum = 0.0;
            pixels.push(sum);
            for ((above, own), below) in around[0].iter().zip(&around[1]).zip(&around[2]) {
                sum += mean(*above, *own, *below) * solid_angle;
                pixels.push(sum);
            }
            light += sum;
            rows.push(light);
            around.rotate_left(1);
            around[2] = across((y + 2).min(height - 1));
            for x in 0..width {
                let [r, g, b, _] = image.pixel(x, y).map(f64::from);
                brightest =
                    Rgb { r: brightest.r.max(r), g: brightest.g.max(g), b: brightest.b.max(b) };
            }
        }
        let (sin, cos) = rotation.sin_cos();
        let brightest = brightest * intensity;
        Self { image, intensity, turn: [cos, sin], rows, pixels, brightest }
    }

    /// The largest value of each channel.
    pub(crate) fn brightest(&self) -> Rgb {
        self.brightest
    }

    /// The radiance from a unit direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> Rgb {
        let (width, height) = (self.image.width(), self.image.height());
        let [u, v] = self.place(direction);
        let (x, y) = (u * f64::from(width) - 0.5, v * f64::from(height) - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let column = |x: f64| (x.rem_euclid(f64::from(width)) as u32).min(width - 1);
        let row = |y: f64| (y.max(0.0) as u32).min(height - 1);
        let at = |x: u32, y: u32| {
            let [r, g, b, _] = self.image.pixel(x, y).map(f64::from);
            Rgb { r, g, b }
        };
        let [a, b] = [left, left + 1.0].map(column);
        let [above, below] = [top, top + 1.0].map(row);
        let across = |y: u32| at(a, y).mix(at(b, y), fx);
        across(above).mix(across(below), fy) * self.intensity
    }

    /// Light from a direction chosen by `u`; `None` if no light comes from anywhere.
    pub(crate) fn sample(&self, u: (f64, f64)) -> Option<Incoming> {
        let (width, height) = (self.image.width(), self.image.height());
        let (y, fy) = choose(&self.rows, u.1)?;
        let (x, fx) = choose(self.row(y), u.0)?;
        let top = (PI * y as f64 / f64::from(height)).cos();
        let z = (top - fy * band(y as u32, height)).clamp(-1.0, 1.0);
        let rho = ((1.0 - z) * (1.0 + z)).sqrt();
        let turn = FRAC_PI_2 - TAU * ((x as f64 + fx) / f64::from(width) - 0.5);
        let (sin, cos) = turn.sin_cos();
        let direction = self.turned(Vec3::new(rho * cos, rho * sin, z), 1.0);
        let pdf = self.pdf_of(x, y);
        let light = self.radiance(direction) / pdf;
        Some(Incoming { direction, distance: f64::INFINITY, light, pdf })
    }

    /// The density by solid angle with which [`sample`](Self::sample) finds a direction.
    pub(crate) fn pdf(&self, direction: Vec3) -> f64 {
        let [u, v] = self.place(direction);
        let cell =
            |share: f64, count: u32| ((share * f64::from(count)) as usize).min(count as usize - 1);
        self.pdf_of(cell(u, self.image.width()), cell(v, self.image.height()))
    }

    fn pdf_of(&self, x: usize, y: usize) -> f64 {
        let row = self.row(y);
        let solid_angle = band(y as u32, self.image.height()) * TAU / f64::from(self.image.width());
        let light = self.rows[self.rows.len() - 1];
        if light > 0.0 { (row[x + 1] - row[x]) / (light * solid_angle) } else { 0.0 }
    }

    /// The light of the pixels before each one of a row.
    fn row(&self, y: usize) -> &[f64] {
        let width = self.image.width() as usize + 1;
        &self.pixels[y * width..(y + 1) * width]
    }

    /// Where a direction lies in the picture: from the left, and from the top, from 0 to 1.
    fn place(&self, direction: Vec3) -> [f64; 2] {
        let d = self.turned(direction, -1.0);
        let turn = (FRAC_PI_2 - d.y.atan2(d.x)) / TAU + 0.5;
        // A tiny negative turn rounds to a whole one, which is none.
        let u = turn - turn.floor();
        [if u < 1.0 { u } else { 0.0 }, d.x.hypot(d.y).atan2(d.z) / PI]
    }

    /// A direction turned with the picture, or back.
    fn turned(&self, d: Vec3, sign: f64) -> Vec3 {
        let [cos, sin] = [self.turn[0], self.turn[1] * sign];
        Vec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z)
    }
}

/// The mean over a pixel of what is interpolated between it and its neighbours, in one dimension.
fn mean(before: f64, own: f64, after: f64) -> f64 {
    0.125 * before + 0.75 * own + 0.125 * after
}

/// The height in z of a row of the sphere: the difference of the cosines at its edges.
fn band(y: u32, height: u32) -> f64 {
    let half = FRAC_PI_2 / f64::from(height);
    2.0 * (f64::from(2 * y + 1) * half).sin() * half.sin()
}

/// The step of a growing sum that the share `u` of the whole falls into, and where in it; `None` if the
/// whole is nothing.
fn choose(sums: &[f64], u: f64) -> Option<(usize, f64)> {
    let last = sums.len() - 1;
    let whole = sums[last];
    if !(whole > 0.0) {
        return None;
    }
    let target = u * whole;
    // The last step that begins at or before the target; of empty ones the one after them.
    let mut step = sums.partition_point(|sum| *sum <= target).saturating_sub(1);
    while step >= last || sums[step + 1] <= sums[step] {
        // Only when the target is the whole.
        step -= 1;
    }
    let own = sums[step + 1] - sums[step];
    Some((step, ((target - sums[step]) / own).clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        sampler::{Key, Sample},
        warp,
    };

    /// Bright and dark spots, some of them black.
    fn spotted(width: u32, rotation: f64) -> Environment {
        let height = width / 2;
        let value = |i: u32| {
            let hash = i.wrapping_mul(0x9e37_79b9).rotate_left(13).wrapping_mul(0x85eb_ca6b) >> 8;
            let share = f64::from(hash) / f64::from(1 << 24);
            if share < 0.3 { 0.0 } else { (8.0 * share * share * share) as f32 }
        };
        let samples = (0..3 * width * height).map(value).collect();
        let image = Image::new(width, height, 3, samples).unwrap();
        Environment::new(Arc::new(image), 2.0, rotation)
    }

    fn directions(count: u32) -> impl Iterator<Item = (Vec3, (f64, f64))> {
        (0..count).map(move |i| {
            let u = Sample::new(7, 1, 0, i).pair(Key::ROOT);
            (warp::cap(u, 2.0), u)
        })
    }

    #[test]
    fn densities_integrate_to_one_and_samples_have_them() {
        let sky = spotted(16, 0.7);
        let count = 1 << 16;
        let mean = |f: &dyn Fn(Vec3) -> f64| {
            4.0 * PI * directions(count).map(|(d, _)| f(d)).sum::<f64>() / f64::from(count)
        };
        let whole = mean(&|d| sky.pdf(d));
        assert!((whole - 1.0).abs() < 2e-3, "{whole}");
        // The estimate of the light from everywhere is that of even directions, with less noise.
        let even = mean(&|d| sky.radiance(d).g);
        let samples = directions(count).map(|(_, u)| sky.sample(u).unwrap());
        let chosen = samples.map(|s| s.light.g).sum::<f64>() / f64::from(count);
        assert!((chosen - even).abs() < 5e-3 * even, "{chosen} {even}");
        for (_, u) in directions(2000) {
            let found = sky.sample(u).unwrap();
            assert!((found.direction.length() - 1.0).abs() < 1e-14);
            assert!((found.pdf - sky.pdf(found.direction)).abs() < 1e-12 * found.pdf, "{u:?}");
        }
    }

    #[test]
    fn light_comes_only_from_where_there_is_a_density() {
        // Two bright pixels, one of them at a pole.
        let mut samples = vec![0.0; 128];
        (samples[5], samples[70]) = (1.0, 3.0);
        let image = Image::new(16, 8, 1, samples).unwrap();
        let sky = Environment::new(Arc::new(image), 1.0, 0.3);
        let mut dark = 0;
        for (direction, _) in directions(20_000) {
            let light = sky.radiance(direction);
            if sky.pdf(direction) == 0.0 {
                assert!(light.is_black(), "{direction:?}");
                dark += 1;
            }
        }
        assert!((10_000..20_000).contains(&dark), "{dark}");
    }

    /// Counts of samples by pixel against the luminance looked up, summed over each pixel.
    #[test]
    fn counts_agree_with_the_light_looked_up() {
        let sky = spotted(16, -0.4);
        let (width, height, parts) = (16, 8, 24);
        let mut shares = vec![0.0; width * height];
        for (i, share) in shares.iter_mut().enumerate() {
            let (x, y) = (i % width, i / width);
            for k in 0..parts * parts {
                let at = |k: usize, cell: usize| cell as f64 + (k as f64 + 0.5) / parts as f64;
                let (u, v) = (at(k % parts, x) / width as f64, at(k / parts, y) / height as f64);
                let (sin, cos) = (PI * v).sin_cos();
                let (up, across) = (FRAC_PI_2 - TAU * (u - 0.5)).sin_cos();
                let d = sky.turned(Vec3::new(sin * across, sin * up, cos), 1.0);
                *share += sin * sky.radiance(d).luminance();
            }
        }
        let whole: f64 = shares.iter().sum();
        let count = 20_000_u32;
        let mut counts = vec![0.0; shares.len()];
        for i in 0..count {
            // Not stratified, or the counts would be better than chance.
            let u = Sample::new(3, i, 0, 0).pair(Key::ROOT);
            let [u, v] = sky.place(sky.sample(u).unwrap().direction);
            counts[(v * height as f64) as usize * width + (u * width as f64) as usize] += 1.0;
        }
        let (mut sum, mut cells) = (0.0, 0.0);
        for (found, share) in counts.iter().zip(&shares) {
            let expected = f64::from(count) * share / whole;
            if expected > 5.0 {
                sum += (found - expected) * (found - expected) / expected;
                cells += 1.0;
            }
        }
        // Wilson and Hilferty 1931: nearly normal.
        let k: f64 = cells - 1.0;
        let found = ((sum / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
        assert!(cells > 60.0 && found.abs() < 4.0, "{found} standard deviations, {cells} cells");
    }

    #[test]
    fn the_picture_hangs_the_right_way_round() {
        // Columns from the left: behind, left, ahead, right; the upper row brighter.
        let levels = [0.1, 0.2, 0.3, 0.4, 1.1, 1.2, 1.3, 1.4];
        let samples = levels.iter().rev().map(|x| *x as f32).collect();
        let image = Arc::new(Image::new(4, 2, 1, samples).unwrap());
        let look = |rotation, x, y, z| {
            let sky = Environment::new(Arc::clone(&image), 1.0, rotation);
            sky.radiance(Vec3::new(x, y, z).normalized()).g
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        // The middle of the third pixel of the upper row: 45 degrees to the right of +y, and up.
        near(look(0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt(), 1.0), 1.2);
        near(look(0.0, -(0.5_f64.sqrt()), 0.5_f64.sqrt(), 1.0), 1.3);
        near(look(0.0, -(0.5_f64.sqrt()), -(0.5_f64.sqrt()), -1.0), 0.4);
        // Between +x and -y is the last one, and the seam at -y joins it to the first.
        near(look(0.0, 0.0, -1.0, 1.0), 0.5 * (1.4 + 1.1));
        // Turned by a quarter counterclockwise, what was at +x is at +y.
        near(look(FRAC_PI_2, 0.0, 1.0, 1.0), look(0.0, 1.0, 0.0, 1.0));
        near(look(0.0, 0.0, 1.0, 0.0), 0.25 * (1.3 + 1.2 + 0.3 + 0.2));
    }

    #[test]
    fn an_even_sky_is_sampled_evenly_and_a_black_one_never() {
        let even = Image::new(8, 4, 1, vec![0.5; 32]).unwrap();
        let sky = Environment::new(Arc::new(even), 3.0, 0.0);
        for (direction, u) in directions(1000) {
            assert!((sky.pdf(direction) * 4.0 * PI - 1.0).abs() < 1e-12);
            assert!((sky.radiance(direction).g - 1.5).abs() < 1e-12);
            assert!(sky.sample(u).is_some());
        }
        for u in [0.0, 0.5, 1.0 - 1e-16, 1.0] {
            assert!(sky.sample((u, u)).unwrap().direction.is_finite());
        }
        let black = Image::new(8, 4, 1, vec![0.0; 32]).unwrap();
        let sky = Environment::new(Arc::new(black), 3.0, 0.0);
        assert!(sky.sample((0.3, 0.3)).is_none());
        assert_eq!(sky.pdf(Vec3::X), 0.0);
    }
}

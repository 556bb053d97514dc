//! How different the surroundings of two pixels are, beyond their noise (Rousselle, Knaus and Zwicker 2012, "Adaptive Rendering with Non-Local
//! Means Filtering", section 5).
//!
//! The squared difference of two pixels, less what the noise of both makes of it on average, in units of that noise,
//!
//! ```text
//! d(p, q) = ((u_p - u_q)^2 - (v_p + min(v_p, v_q))) / (SENSITIVITY^2 (v_p + v_q)),
//! ```
//!
//! is averaged over the channels and over the pixels of two squares around them.

use super::{Scene, Window};

/// Half the edge of the squares, without the middle.
const PATCH: i32 = 2;
/// How many standard deviations of noise make a difference that counts.
const SENSITIVITY: f32 = 0.7;
/// A variance that is as good as none beside light of strength 1: the square of half of what the eye tells apart in white. It
/// keeps pixels without noise, whose differences are whole numbers over nothing, from infinity.
const NO_VARIANCE: f32 = 1e-10;

/// The distances of all pixels of a window from others.
pub(super) struct Distances<'a> {
    scene: &'a Scene,
    window: Window,
    /// Of single pixels, the window and [`PATCH`] around it.
    single: Vec<f32>,
    /// Summed across.
    rows: Vec<f32>,
    /// Averaged over the squares.
    all: Vec<f32>,
}

impl<'a> Distances<'a> {
    pub(super) fn new(scene: &'a Scene, window: &Window) -> Self {
        let [width, height] = window.size;
        let zeros = |w: i32, h: i32| vec![0.0; (w * h) as usize];
        Self {
            scene,
            window: *window,
            single: zeros(width + 2 * PATCH, height + 2 * PATCH),
            rows: zeros(width, height + 2 * PATCH),
            all: zeros(width, height),
        }
    }

    /// The distance of each pixel of the window from the one that lies so far from it. Beyond the edge of the picture its last pixel goes on.
    pub(super) fn of(&mut self, [dx, dy]: [i32; 2]) -> &[f32] {
        let ([x, y], [width, _]) = (self.window.corner, self.window.size);
        let [last_x, last_y] = self.scene.size.map(|size| size - 1);
        let at = |x: i32, y: i32| self.scene.index([x.clamp(0, last_x), y.clamp(0, last_y)]);
        let wide = (width + 2 * PATCH) as usize;
        for (row, line) in (y - PATCH..).zip(self.single.chunks_mut(wide)) {
            for (column, distance) in (x - PATCH..).zip(line) {
                *distance = self.scene.distance(at(column, row), at(column + dx, row + dy));
            }
        }
        let edge = 2 * PATCH as usize + 1;
        for (line, sums) in self.single.chunks(wide).zip(self.rows.chunks_mut(width as usize)) {
            for (sum, part) in sums.iter_mut().zip(line.windows(edge)) {
                *sum = part.iter().sum();
            }
        }
        let width = width as usize;
        for (i, mean) in self.all.iter_mut().enumerate() {
            let sum: f32 = (0..edge).map(|k| self.rows[i + k * width]).sum();
            *mean = sum / (edge * edge) as f32;
        }
        &self.all
    }
}

impl Scene {
    /// The distance of two pixels alone; 0 if one of them is not known.
    #[inline]
    fn distance(&self, p: usize, q: usize) -> f32 {
        if !(self.known[p] && self.known[q]) {
            return 0.0;
        }
        let mut sum = 0.0;
        for c in 0..3 {
            let (v, w) = (self.variance[p][c], self.variance[q][c]);
            let d = self.light[p][c] - self.light[q][c];
            sum += (d * d - (v + w.min(v))) / (NO_VARIANCE + SENSITIVITY * SENSITIVITY * (v + w));
        }
        sum / 3.0
    }
}

//! Where a picture has noise still, and where it has enough samples.
//!
//! The picture is cut into blocks of 8 by 8 pixels, whoever makes which tiles of it. Before each pass the error of every block is estimated from the
//! film's sums over its pixels,
//!
//! ```text
//! error^2 = mean of v / (l^2 + 0.01)
//! ```
//!
//! over pixels and channels, l being the mean light and v its variance, both times the exposure: the relative mean square error of Rousselle, Knaus and
//! Zwicker 2011. A block whose error is small enough gets no more samples, then or later. The sums are exact and those of whole passes, so that this
//! does not depend on threads, tiles, or how often the work was stopped and gone on with: a block of which a pixel has samples of the
//! pass already was not good enough when the pass began.

use rondure_film::{Film, Spool, SpoolError, Window};

/// The edge of the blocks of pixels that a limit of noise goes by.
pub const EDGE: u32 = 8;
/// How many samples each pixel gets before the variance is believed.
const FIRST: u32 = 16;
/// What keeps black pixels from counting without bound, as the square of a light that is shown.
const FLOOR: f64 = 0.01;

/// The blocks that get more samples.
#[derive(Debug)]
pub(crate) struct Blocks {
    columns: u32,
    active: Vec<bool>,
}

/// Whether a window of a picture of `size` consists of whole blocks.
pub(crate) fn are_whole(window: &Window, [width, height]: [u32; 2]) -> bool {
    let good = |first: u32, count: u32, all: u32| {
        let end = first.saturating_add(count);
        first.is_multiple_of(EDGE) && (end.is_multiple_of(EDGE) || end == all)
    };
    good(window.x, window.width, width) && good(window.y, window.height, height)
}

impl Blocks {
    /// Those whose error is above `noise`, before the pass that begins with the sample of number `start`.
    pub(crate) fn new(
        sums: &Spool,
        noise: f64,
        exposure: f64,
        start: u32,
    ) -> Result<Self, SpoolError> {
        let [width, height] = sums.size();
        let columns = width.div_ceil(EDGE);
        let mut active = Vec::new();
        for y in (0..height).step_by(EDGE as usize) {
            let row = Window { x: 0, y, width, height: EDGE.min(height - y) };
            let film = sums.view(row)?;
            active.extend((0..columns).map(|column| {
                let x = column * EDGE;
                let block = Window { x, width: EDGE.min(width - x), ..row };
                let most = pixels(&block).map(|(x, y)| film.samples(x, y)).max().unwrap_or(0);
                most > start
                    || start < FIRST
                    || (most == start && error(&film, &block, exposure) > noise)
            }));
        }
        Ok(Self { columns, active })
    }

    /// Whether none gets more.
    pub(crate) fn is_done(&self) -> bool {
        !self.active.contains(&true)
    }

    /// What of a tile gets more samples: the tile itself, or parts of it.
    pub(crate) fn of_tile(&self, tile: Window) -> Vec<Window> {
        let cut = |first: u32, length: u32| {
            (first / EDGE..(first + length).div_ceil(EDGE)).map(move |i| {
                let start = first.max(i * EDGE);
                (i, start, (first + length).min((i + 1) * EDGE) - start)
            })
        };
        let mut parts = Vec::new();
        let mut all = true;
        for (row, y, height) in cut(tile.y, tile.height) {
            for (column, x, width) in cut(tile.x, tile.width) {
                if self.active[(row * self.columns + column) as usize] {
                    parts.push(Window { x, y, width, height });
                } else {
                    all = false;
                }
            }
        }
        if all { vec![tile] } else { parts }
    }
}

fn pixels(window: &Window) -> impl Iterator<Item = (u32, u32)> + use<> {
    let Window { x, y, width, height } = *window;
    (y..y + height).flat_map(move |y| (x..x + width).map(move |x| (x, y)))
}

/// The estimated error of a block.
fn error(film: &Film, block: &Window, exposure: f64) -> f64 {
    let square = exposure * exposure;
    let one = |(x, y)| {
        let (light, variance) = (film.light(x, y), film.variance(x, y));
        let channel = |(l, v): (f64, f64)| square * v / (square * l * l + FLOOR);
        light.into_iter().zip(variance).map(channel).sum::<f64>() / 3.0
    };
    let sum: f64 = pixels(block).map(one).sum();
    (sum / block.pixels() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use rondure_film::{Guide, Layers, PixelSample};

    use super::*;

    /// A film of 20x12 pixels with 16 samples in each: noise where x < 8.
    fn film() -> Film {
        let mut film = Film::new([20, 12], Window::whole(20, 12), Layers::ALL).unwrap();
        for (x, y) in pixels(&Window::whole(20, 12)) {
            for s in 0..16 {
                let noise = if x < 8 { 0.5 - f64::from(s % 2) } else { 0.0 };
                let light = [1.0 + noise; 3];
                let sample = PixelSample { light, negative: false, guide: Guide::default() };
                assert!(film.add(x, y, &sample));
            }
        }
        film
    }

    fn blocks(film: &Film, noise: f64, exposure: f64, start: u32) -> Blocks {
        Blocks::new(&film.clone().into(), noise, exposure, start).unwrap()
    }

    #[test]
    fn blocks_with_noise_get_more() {
        let film = film();
        // Before the first 16 samples are taken everything does.
        assert_eq!(blocks(&film, 0.01, 1.0, 8).active, [true; 6]);
        let found = blocks(&film, 0.01, 1.0, 16);
        assert_eq!(found.active, [true, false, false, true, false, false]);
        // The standard deviation 0.5 over the root of 15, to 1.
        let error = error(&film, &Window { x: 0, y: 0, width: 8, height: 8 }, 1.0);
        assert!((error - 0.5 / 15.0_f64.sqrt() / 1.01_f64.sqrt()).abs() < 1e-12, "{error}");
        assert!(blocks(&film, 0.13, 1.0, 16).is_done());
        // In a picture that is darker by the exposure, the noise is less in relation to the floor.
        assert!(blocks(&film, 0.01, 1e-3, 16).is_done());
        // What was left out once stays out.
        assert!(blocks(&film, 0.01, 1.0, 32).is_done());
    }

    #[test]
    fn a_block_that_was_begun_is_finished() {
        let mut film = film();
        let sample = PixelSample { light: [1.0; 3], negative: false, guide: Guide::default() };
        assert!(film.add(19, 0, &sample));
        let found = blocks(&film, 0.01, 1.0, 16);
        assert_eq!(found.active, [true, false, true, true, false, false]);
    }

    #[test]
    fn tiles_are_cut_at_blocks() {
        let found = blocks(&film(), 0.01, 1.0, 16);
        let window = |x, y, width, height| Window { x, y, width, height };
        assert_eq!(found.of_tile(window(0, 0, 8, 12)), [window(0, 0, 8, 12)]);
        assert_eq!(found.of_tile(window(8, 0, 12, 12)), []);
        let parts = found.of_tile(window(5, 5, 7, 7));
        assert_eq!(parts, [window(5, 5, 3, 3), window(5, 8, 3, 4)]);
    }
}

//! The film: what the samples of every pixel add up to.
//!
//! Range and precision, by layer (steps of the grid, largest sample that is taken):
//! * light: 2^-64 = 5e-20, up to [`LARGEST`] = 2^40 = 1.1e12 in each channel. Samples beyond are refused, and who adds them is told.
//!   With [`MOST_SAMPLES`] = 2^22 samples a sum stays below 2^62, and its range is 2^63.
//! * squares of light, for the variance: 2^-80 = 8e-25; sums stay below 2^102, the range is 2^111.
//! * albedo and normal: 2^-40 = 9e-13, cut off at 0 to 1 and -1 to 1; sums stay below 2^22, the range is 2^23.
//!
//! Depth, position and numbers of things are not averaged, which would invent things between two others: they are what the ray through the
//! middle of the pixel meets.
//!
//! A pixel takes 56 bytes, 72 more with the variance and 72 more with the guides: 8K with all layers (7680x4320) takes 6.6 GB, which
//! a [`Spool`](crate::Spool) need not have in memory.

use crate::{Sum, Window};

/// The largest value of a channel of a sample that a film takes, on either side of 0.
pub const LARGEST: f64 = (1_u64 << 40) as f64;
/// The most samples that a pixel takes.
pub const MOST_SAMPLES: u32 = 1 << 22;

/// What a film keeps beside the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// The variance of the light.
    pub variance: bool,
    /// Albedo, normal, depth, position, and the numbers of object and material.
    pub guides: bool,
}

impl Layers {
    /// All there are.
    pub const ALL: Self = Self { variance: true, guides: true };
}

/// What a ray from the camera meets first, as far as it is averaged over a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guide {
    /// The share of light that the surface returns, from 0 to 1; white for mirrors, clear glass and lamps, black for the sky.
    pub albedo: [f64; 3],
    /// The unit normal towards the viewer, in scene coordinates; 0 for the sky.
    pub normal: [f64; 3],
}

/// What the ray through the middle of a pixel, and of the lens, meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Center {
    /// The distance from the eye, measured along the direction of view, in scene units; infinite for the sky.
    pub depth: f32,
    /// The place, in scene units; 0 for the sky.
    pub position: [f32; 3],
    /// The number of the object, from 1 in the order of the scene; 0 for the sky and for lamps.
    pub object: u32,
    /// The number of the material, from 1 in the order of the scene; 0 for the sky and for lamps.
    pub material: u32,
}

impl Center {
    /// Nothing but sky.
    pub const SKY: Self = Self { depth: f32::INFINITY, position: [0.0; 3], object: 0, material: 0 };
}

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSample {
    /// The light: linear red, green, blue.
    pub light: [f64; 3],
    /// Whether the filter counts it as negative there.
    pub negative: bool,
    /// What was met first, where the film keeps that.
    pub guide: Guide,
}

/// Why films cannot be made or put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The film does not fit into memory.
    #[error("a film of {0} pixels does not fit into memory")]
    TooLarge(u64),
    /// The window has no pixels, or some that are not in the picture.
    #[error("the window of {window} is not within a picture of {}x{}", size[0], size[1])]
    Outside {
        /// The window.
        window: Window,
        /// The size of the picture.
        size: [u32; 2],
    },
    /// The films are not of one picture.
    #[error("the films are of different sizes, or have different layers")]
    Different,
    /// A pixel would have more than [`MOST_SAMPLES`] samples.
    #[error("a pixel would have more than {MOST_SAMPLES} samples")]
    TooManySamples,
}

pub(crate) type Light = [Sum<2, 64>; 3];
pub(crate) type Squares = [Sum<3, 80>; 3];
type Small = [Sum<1, 40>; 3];

/// How many samples a pixel took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Count {
    pub(crate) samples: u32,
    /// The samples less twice those that count as negative.
    pub(crate) weight: i32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct GuideSums {
    pub(crate) albedo: Small,
    pub(crate) normal: Small,
}

/// Sums over the samples of the pixels in a window of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    size: [u32; 2],
    window: Window,
    layers: Layers,
    pub(crate) light: Vec<Light>,
    pub(crate) counts: Vec<Count>,
    pub(crate) squares: Vec<Squares>,
    pub(crate) guides: Vec<GuideSums>,
    pub(crate) centers: Vec<Center>,
}

/// So many values, if there is memory for them.
pub(crate) fn vec_of<T: Clone>(value: T, count: usize) -> Option<Vec<T>> {
    let mut all = Vec::new();
    all.try_reserve_exact(count).ok()?;
    all.resize(count, value);
    Some(all)
}

impl Film {
    /// A film without light for a `window` of a picture of `size` (width and height) pixels.
    ///
    /// # Errors
    /// If the window is empty or not within the picture, or there is not enough memory.
    pub fn new(size: [u32; 2], window: Window, layers: Layers) -> Result<Self, FilmError> {
        Self::check(size, window)?;
        let pixels = window.pixels();
        let make = || {
            let count = usize::try_from(pixels).ok()?;
            let only = |wanted: bool| if wanted { count } else { 0 };
            Some(Self {
                size,
                window,
                layers,
                light: vec_of(Light::default(), count)?,
                counts: vec_of(Count::default(), count)?,
                squares: vec_of(Squares::default(), only(layers.variance))?,
                guides: vec_of(GuideSums::default(), only(layers.guides))?,
                centers: vec_of(Center::SKY, only(layers.guides))?,
            })
        };
        make().ok_or(FilmError::TooLarge(pixels))
    }

    /// Whether a window has pixels, all of them in the picture.
    pub(crate) fn check(size: [u32; 2], window: Window) -> Result<(), FilmError> {
        let within = Window::whole(size[0], size[1]).contains(&window);
        let good = window.pixels() > 0 && within;
        if good { Ok(()) } else { Err(FilmError::Outside { window, size }) }
    }

    /// A film of no pixel.
    pub(crate) fn without_pixels(size: [u32; 2], layers: Layers) -> Self {
        let window = Window { x: 0, y: 0, width: 0, height: 0 };
        let (light, counts, squares) = (Vec::new(), Vec::new(), Vec::new());
        let (guides, centers) = (Vec::new(), Vec::new());
        Self { size, window, layers, light, counts, squares, guides, centers }
    }

    /// The size of the whole picture, width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The part of the picture that this film has.
    pub fn window(&self) -> Window {
        self.window
    }

    /// What it keeps beside the light.
    pub fn layers(&self) -> Layers {
        self.layers
    }

    /// The place of a pixel of the picture; `None` outside the window.
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let (x, y) = (x.checked_sub(self.window.x)?, y.checked_sub(self.window.y)?);
        let inside = x < self.window.width && y < self.window.height;
        inside.then_some(y as usize * self.window.width as usize + x as usize)
    }

    /// Adds a sample of a pixel. Says whether it was taken: it is refused, and nothing changes, if a channel is not a number or beyond
    /// [`LARGEST`], the pixel is not in the window, or it has [`MOST_SAMPLES`] already.
    #[must_use]
    pub fn add(&mut self, x: u32, y: u32, sample: &PixelSample) -> bool {
        let Some(i) = self.index(x, y) else { return false };
        if !sample.light.iter().all(|v| v.abs() <= LARGEST) {
            return false;
        }
        let count = &mut self.counts[i];
        if count.samples >= MOST_SAMPLES {
            return false;
        }
        count.samples += 1;
        count.weight += if sample.negative { -1 } else { 1 };
        let sign = if sample.negative { -1.0 } else { 1.0 };
        for (sum, v) in self.light[i].iter_mut().zip(sample.light) {
            sum.add(sign * v);
        }
        if let Some(squares) = self.squares.get_mut(i) {
            for (sum, v) in squares.iter_mut().zip(sample.light) {
                sum.add(v * v);
            }
        }
        if let Some(sums) = self.guides.get_mut(i) {
            let within = |v: f64, least: f64| if v.is_nan() { 0.0 } else { v.clamp(least, 1.0) };
            for (sum, v) in sums.albedo.iter_mut().zip(sample.guide.albedo) {
                sum.add(sign * within(v, 0.0));
            }
            for (sum, v) in sums.normal.iter_mut().zip(sample.guide.normal) {
                sum.add(sign * within(v, -1.0));
            }
        }
        true
    }

    /// Says what the middle of a pixel shows, if the film keeps that and has the pixel.
    pub fn set_center(&mut self, x: u32, y: u32, center: Center) {
        if let Some(to) = self.index(x, y).and_then(|i| self.centers.get_mut(i)) {
            *to = center;
        }
    }

    /// Adds the samples of another film of the same picture, whose window lies in this one's. What middles show is taken over where `other` has it.
    ///
    /// # Errors
    /// If that is not so, or a pixel would have too many samples; nothing is added then.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if self.size != other.size || self.layers != other.layers {
            return Err(FilmError::Different);
        }
        let window = other.window;
        if !self.window.contains(&window) {
            return Err(FilmError::Outside { window, size: self.size });
        }
        let rows: Vec<_> = (0..window.height as usize)
            .filter_map(|row| Some((self.index(window.x, window.y + row as u32)?, row)))
            .collect();
        let width = window.width as usize;
        for &(start, row) in &rows {
            let theirs = &other.counts[row * width..][..width];
            let too_many = |(a, b): (&Count, &Count)| a.samples + b.samples > MOST_SAMPLES;
            if self.counts[start..][..width].iter().zip(theirs).any(too_many) {
                return Err(FilmError::TooManySamples);
            }
        }
        for (start, row) in rows {
            let from = row * width;
            for i in 0..width {
                let (to, i) = (start + i, from + i);
                merge(&mut self.light[to], &other.light[i]);
                self.counts[to].samples += other.counts[i].samples;
                self.counts[to].weight += other.counts[i].weight;
                if self.layers.variance {
                    merge(&mut self.squares[to], &other.squares[i]);
                }
                if self.layers.guides {
                    merge(&mut self.guides[to].albedo, &other.guides[i].albedo);
                    merge(&mut self.guides[to].normal, &other.guides[i].normal);
                    if other.centers[i] != Center::SKY {
                        self.centers[to] = other.centers[i];
                    }
                }
            }
        }
        Ok(())
    }

    /// How many samples a pixel took; 0 outside the window.
    pub fn samples(&self, x: u32, y: u32) -> u32 {
        self.index(x, y).map_or(0, |i| self.counts[i].samples)
    }

    /// The mean light of a pixel: linear red, green, blue; black if it took no sample.
    pub fn light(&self, x: u32, y: u32) -> [f64; 3] {
        self.index(x, y).map_or([0.0; 3], |i| self.mean(i, &self.light[i]))
    }

    /// The variance of [`light`](Self::light) as far as the samples tell: their variance, over their number. It is an upper bound on average, since
    /// samples are spread better than at random. 0 where it is not known, infinite with less than two samples.
    pub fn variance(&self, x: u32, y: u32) -> [f64; 3] {
        let Some(i) = self.index(x, y).filter(|_| self.layers.variance) else { return [0.0; 3] };
        let n = f64::from(self.counts[i].samples);
        if n < 2.0 {
            return [f64::INFINITY; 3];
        }
        let divisor = self.counts[i].divisor();
        core::array::from_fn(|c| {
            let (sum, squares) = (self.light[i][c].to_f64(), self.squares[i][c].to_f64());
            (n / (n - 1.0) * (squares - sum * sum / n)).max(0.0) / (divisor * divisor)
        })
    }

    /// The mean of what was met first; `None` if the film does not keep it or does not have the pixel.
    pub fn guide(&self, x: u32, y: u32) -> Option<Guide> {
        let i = self.index(x, y)?;
        let sums = self.guides.get(i)?;
        let albedo = self.mean(i, &sums.albedo).map(|v| v.clamp(0.0, 1.0));
        Some(Guide { albedo, normal: self.mean(i, &sums.normal) })
    }

    /// What the middle of a pixel shows; `None` if the film does not keep it or does not have the pixel.
    pub fn center(&self, x: u32, y: u32) -> Option<Center> {
        self.centers.get(self.index(x, y)?).copied()
    }

    fn mean<const L: usize, const F: u32>(&self, i: usize, sums: &[Sum<L, F>; 3]) -> [f64; 3] {
        let count = self.counts[i];
        if count.samples == 0 {
            return [0.0; 3];
        }
        sums.map(|sum| sum.to_f64() / count.divisor())
    }
}

impl Count {
    /// What a sum of signed samples is divided by: the weights where they are well known, else at least half of the number. Filters with negative
    /// lobes count an eighth of the samples as negative or less; a pixel with more of them was unlucky, and shall not blow up.
    fn divisor(self) -> f64 {
        f64::from(self.weight).max(0.5 * f64::from(self.samples))
    }
}

#[inline]
fn merge<const L: usize, const F: u32>(to: &mut [Sum<L, F>; 3], from: &[Sum<L, F>; 3]) {
    for (to, from) in to.iter_mut().zip(from) {
        to.merge(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(light: [f64; 3]) -> PixelSample {
        let guide = Guide { albedo: [0.5, 0.25, 1.0], normal: [0.0, -1.0, 0.0] };
        PixelSample { light, negative: false, guide }
    }

    #[test]
    fn means_and_variances() {
        let mut film = Film::new([4, 3], Window::whole(4, 3), Layers::ALL).unwrap();
        assert_eq!(film.light(1, 2), [0.0; 3]);
        assert_eq!(film.variance(1, 2), [f64::INFINITY; 3]);
        for v in [1.0, 2.0, 4.0, 5.0] {
            assert!(film.add(1, 2, &sample([v, 2.0 * v, 0.1])));
        }
        assert_eq!(film.samples(1, 2), 4);
        assert_eq!(film.samples(2, 1), 0);
        let light = film.light(1, 2);
        assert_eq!([light[0], light[1]], [3.0, 6.0]);
        assert!((light[2] - 0.1).abs() < 1e-16);
        // The samples' variance is 10/3, that of their mean a quarter of it.
        let variance = film.variance(1, 2);
        assert!((variance[0] - 10.0 / 12.0).abs() < 1e-15, "{variance:?}");
        assert!((variance[1] - 40.0 / 12.0).abs() < 1e-15);
        assert!(variance[2] < 1e-17);
        assert_eq!(film.guide(1, 2).unwrap(), sample([0.0; 3]).guide);
    }

    #[test]
    fn what_cannot_be_added_is_refused() {
        let window = Window { x: 1, y: 1, width: 2, height: 2 };
        let mut film = Film::new([4, 4], window, Layers::default()).unwrap();
        let untouched = film.clone();
        for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1.1e12, -1e300] {
            assert!(!film.add(1, 1, &sample([0.0, bad, 0.0])), "{bad}");
        }
        for (x, y) in [(0, 1), (1, 0), (3, 1), (1, 3), (u32::MAX, 1)] {
            assert!(!film.add(x, y, &sample([1.0; 3])));
        }
        assert_eq!(film, untouched);
        assert!(film.add(2, 2, &sample([LARGEST, -LARGEST, 0.0])));
        assert_eq!(film.light(2, 2), [LARGEST, -LARGEST, 0.0]);
        assert!(film.guide(2, 2).is_none() && film.center(2, 2).is_none());
    }

    #[test]
    fn films_of_other_pictures_are_not_merged() {
        let whole = Window::whole(4, 4);
        let mut film = Film::new([4, 4], whole, Layers::ALL).unwrap();
        let before = film.clone();
        let other = |size, window, layers| Film::new(size, window, layers).unwrap();
        let few = Layers { variance: true, guides: false };
        assert_eq!(film.merge(&other([4, 4], whole, few)), Err(FilmError::Different));
        assert_eq!(film.merge(&other([5, 4], whole, Layers::ALL)), Err(FilmError::Different));
        let small = Window::whole(3, 3);
        let mut part = other([4, 4], small, Layers::ALL);
        assert!(matches!(part.merge(&film), Err(FilmError::Outside { .. })));
        let mut full = other([4, 4], small, Layers::ALL);
        full.counts[4].samples = MOST_SAMPLES;
        film.merge(&full).unwrap();
        let filled = film.clone();
        part.counts[4].samples = 1;
        assert_eq!(film.merge(&part), Err(FilmError::TooManySamples));
        assert_eq!(film, filled);
        assert_ne!(film, before);
        assert!(Film::new([4, 4], Window { x: 2, ..whole }, Layers::ALL).is_err());
        assert!(Film::new([0, 4], Window::whole(0, 4), Layers::ALL).is_err());
        let huge = Window::whole(u32::MAX, u32::MAX);
        let error = Film::new([u32::MAX; 2], huge, Layers::ALL).unwrap_err();
        assert_eq!(error, FilmError::TooLarge(huge.pixels()));
    }

    #[test]
    fn parts_in_any_order_make_the_whole() {
        let size = [5, 3];
        let mut whole = Film::new(size, Window::whole(5, 3), Layers::ALL).unwrap();
        let mut parts = Vec::new();
        // Light of wildly different sizes, so that f64 sums would depend on the order.
        let value = |x: u32, y: u32, s: u32| {
            let bits = (x * 7919 + y * 104_729 + s * 1_299_709).wrapping_mul(2_654_435_761);
            f64::from(bits) * 10_f64.powi(s as i32 % 9 - 8)
        };
        for tile in Window::whole(5, 3).tiles(2) {
            for samples in [0..3, 3..11, 11..20] {
                let mut part = Film::new(size, tile, Layers::ALL).unwrap();
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        for s in samples.clone() {
                            let negative = s % 10 == 7;
                            let v = [value(x, y, s), value(y, s, x), 1.0];
                            let sample = PixelSample { negative, ..sample(v) };
                            assert!(part.add(x, y, &sample) && whole.add(x, y, &sample));
                        }
                        if samples.start == 0 {
                            let object = 1 + x;
                            let center = Center { object, depth: 3.0, ..Center::SKY };
                            part.set_center(x, y, center);
                            whole.set_center(x, y, center);
                        }
                    }
                }
                parts.push(part);
            }
        }
        for turn in 0..parts.len() {
            let mut film = Film::new(size, Window::whole(5, 3), Layers::ALL).unwrap();
            parts.rotate_left(turn);
            parts.swap(0, turn / 2);
            for part in &parts {
                film.merge(part).unwrap();
            }
            assert!(film == whole);
        }
    }

    #[test]
    fn negative_samples_count_as_such() {
        let mut film = Film::new([1, 1], Window::whole(1, 1), Layers::ALL).unwrap();
        for i in 0..10 {
            assert!(film.add(0, 0, &PixelSample { negative: i == 4, ..sample([3.0, 0.5, 0.0]) }));
        }
        // A constant comes out as itself.
        let light = film.light(0, 0);
        assert!((light[0] - 3.0).abs() < 1e-15 && (light[1] - 0.5).abs() < 1e-15);
        assert_eq!(film.guide(0, 0).unwrap().albedo, [0.5, 0.25, 1.0]);
    }
}

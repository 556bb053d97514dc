//! A grid of colours.

/// A picture in linear light, Rec. 709 primaries, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

/// The number of pixels is not width times height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{pixels} pixels are no picture of {width}x{height}")]
pub struct SizeError {
    width: u32,
    height: u32,
    pixels: usize,
}

impl Image {
    /// A picture of these pixels.
    ///
    /// # Errors
    /// If there are not as many as `width` times `height`.
    pub fn new(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Result<Self, SizeError> {
        if pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(SizeError { width, height, pixels: pixels.len() });
        }
        Ok(Self { width, height, pixels })
    }

    /// A picture of the pixels that `pixel` gives by column and row.
    pub fn from_pixels(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Self {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, pixels: places.map(|(x, y)| pixel(x, y)).collect() }
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The light of each pixel.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }
}

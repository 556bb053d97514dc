//! How much two pictures differ.

use std::{error::Error, fs::File, io::BufReader, path::Path};

/// The edge of the blocks whose means are compared, in pixels: random places of the samples in
/// their pixels then count little.
const BLOCK: usize = 8;

/// An 8-bit picture in RGB.
pub(crate) struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    pub(crate) fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let in_file = |e: &dyn Error| format!("{}: {e}", path.display());
        let mut decoder =
            png::Decoder::new(BufReader::new(File::open(path).map_err(|e| in_file(&e))?));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().map_err(|e| in_file(&e))?;
        let size = reader.output_buffer_size().ok_or("the picture is too large")?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes).map_err(|e| in_file(&e))?;
        let channels = info.color_type.samples();
        if channels < 3 {
            return Err(in_file(&*Box::<dyn Error>::from("not in colour")).into());
        }
        bytes.truncate(info.buffer_size());
        let pixels = bytes.chunks_exact(channels).map(|p| [p[0], p[1], p[2]]).collect();
        Ok(Self { width: info.width as usize, height: info.height as usize, pixels })
    }

    /// The mean difference of the means of blocks, over the mean of both pictures.
    pub(crate) fn difference(&self, other: &Self) -> Option<f64> {
        if (self.width, self.height) != (other.width, other.height) {
            return None;
        }
        let (mut difference, mut sum) = (0.0, 0.0);
        for top in (0..self.height).step_by(BLOCK) {
            for left in (0..self.width).step_by(BLOCK) {
                for channel in 0..3 {
                    let block = |picture: &Self| picture.block_sum(left, top, channel);
                    let (a, b) = (block(self), block(other));
                    difference += (a - b).abs();
                    sum += 0.5 * (a + b);
                }
            }
        }
        Some(if sum > 0.0 { difference / sum } else { 0.0 })
    }

    fn block_sum(&self, left: usize, top: usize, channel: usize) -> f64 {
        let rows = top..(top + BLOCK).min(self.height);
        let columns = left..(left + BLOCK).min(self.width);
        rows.flat_map(|y| columns.clone().map(move |x| y * self.width + x))
            .map(|i| f64::from(self.pixels[i][channel]))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_within_a_block_does_not_count() {
        let picture = |pixels: [u8; 4]| Picture {
            width: 2,
            height: 2,
            pixels: pixels.map(|v| [v; 3]).to_vec(),
        };
        let a = picture([10, 0, 10, 0]);
        assert_eq!(a.difference(&picture([0, 10, 0, 10])), Some(0.0));
        assert_eq!(a.difference(&picture([15, 0, 15, 0])), Some(0.4));
    }
}

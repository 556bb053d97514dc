//! The contact sheet: small pictures of frames, in rows.

use std::path::PathBuf;

use rondure_image::{Image, Signals, png, tone};

use super::{Sequence, product};
use crate::{failure::Failure, picture::cannot_write};

/// The most frames on a sheet, and in a row.
const FRAMES: usize = 24;
const ROW: usize = 6;
/// The width of a small picture, and of the space round it, in pixels.
const WIDTH: usize = 160;
const GAP: usize = 4;
const PAPER: u8 = 24;

/// Makes the sheet, of all frames or of some that are evenly apart.
pub(super) fn make(sequence: &Sequence<'_>) -> Result<PathBuf, Failure> {
    let all = sequence.cameras.len();
    let count = all.min(FRAMES);
    let [width, height] = sequence.size().map(|v| v as usize);
    let small = [WIDTH.min(width), (WIDTH.min(width) * height / width).max(1)];
    let columns = count.min(ROW);
    let rows = count.div_ceil(ROW);
    let side = |cells: usize, edge: usize| cells * (edge + GAP) + GAP;
    let sheet = [side(columns, small[0]), side(rows, small[1])];
    let mut paper = vec![PAPER; sheet[0] * sheet[1] * 3];
    for k in 0..count {
        let frame = sequence.frame(k * all / count)?;
        let corner = [side(k % ROW, small[0]), side(k / ROW, small[1])];
        for (row, line) in shrunk(&frame, small).chunks(small[0] * 3).enumerate() {
            let start = ((corner[1] + row) * sheet[0] + corner[0]) * 3;
            paper[start..start + line.len()].copy_from_slice(line);
        }
    }
    let path = product(sequence, "contact-sheet.png");
    png::write(&path, sheet.map(|v| v as u32), &Signals::Eight(paper), &[])
        .map_err(|error| cannot_write(&path, error))?;
    Ok(path)
}

/// The signals of a picture made smaller: the mean light of the pixels that fall on each.
fn shrunk(image: &Image, [width, height]: [usize; 2]) -> Vec<u8> {
    let (w, h) = (image.width() as usize, image.height() as usize);
    let mut signals = Vec::with_capacity(width * height * 3);
    let part = |i: usize, small: usize, large: usize| {
        let (start, end) = (i * large / small, (i + 1) * large / small);
        start..end.max(start + 1)
    };
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for row in part(y, height, h) {
                for pixel in &image.pixels()[row * w..][part(x, width, w)] {
                    sum = [0, 1, 2].map(|c| sum[c] + f64::from(pixel[c]));
                    count += 1.0;
                }
            }
            signals.extend(sum.map(|v| (255.0 * tone::srgb(v / count)).round() as u8));
        }
    }
    signals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_kept_when_a_picture_shrinks() {
        let pixels: Vec<[f32; 3]> =
            (0..70).map(|i| if i % 2 == 0 { [1.0; 3] } else { [0.0; 3] }).collect();
        let image = Image::new(10, 7, pixels).unwrap();
        // Half of the light is 188 of the signal.
        let small = shrunk(&image, [5, 3]);
        assert_eq!(small.len(), 45);
        assert!(small.iter().all(|v| v.abs_diff(188) < 3), "{small:?}");
        assert_eq!(shrunk(&image, [10, 7])[..6], [255, 255, 255, 0, 0, 0]);
    }
}

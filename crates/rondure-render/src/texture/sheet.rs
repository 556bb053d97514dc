//! Images over (u, v): looked up between the middles of pixels.

use std::sync::Arc;

use rondure_scene::{Image, Sheet as Described, Wrap};

use crate::color::Rgb;

/// A colour and how opaque it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ink {
    pub(crate) color: Rgb,
    pub(crate) alpha: f64,
}

impl Ink {
    const NONE: Self = Self { color: Rgb::BLACK, alpha: 0.0 };

    /// The ink over a colour.
    pub(crate) fn over(self, below: Rgb) -> Rgb {
        below.mix(self.color, self.alpha)
    }
}

/// An image in its place.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    image: Arc<Image>,
    /// How many images there are to a unit of u and v.
    per_unit: [f64; 2],
    offset: [f64; 2],
    wrap: Wrap,
}

impl Sheet {
    pub(super) fn new(sheet: &Described) -> Self {
        Self {
            image: Arc::clone(&sheet.image),
            per_unit: sheet.size.map(|size| 1.0 / size),
            offset: sheet.offset,
            wrap: sheet.wrap,
        }
    }

    /// The image once over the unit square.
    pub(super) fn once(image: &Arc<Image>) -> Self {
        let (image, per_unit) = (Arc::clone(image), [1.0; 2]);
        Self { image, per_unit, offset: [0.0; 2], wrap: Wrap::Once }
    }

    /// Whether something can be seen through or beside the image.
    pub(super) fn covers(&self) -> bool {
        self.wrap != Wrap::Once && self.image.channels() != 4
    }

    /// The share of the width and of the height, from the lower left corner.
    fn place(&self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (uv[i] - self.offset[i]) * self.per_unit[i])
    }

    pub(super) fn at(&self, uv: [f64; 2]) -> Ink {
        let [x, y] = self.place(uv);
        let within = |x: f64| (0.0..=1.0).contains(&x);
        if self.wrap == Wrap::Once && !(within(x) && within(y)) {
            return Ink::NONE;
        }
        let [r, g, b, alpha] = self.blend(x, y, |corners, weights| {
            // Colours count as much as they are opaque.
            let mut sum = [0.0; 4];
            for (pixel, weight) in corners.iter().zip(weights) {
                for c in 0..3 {
                    sum[c] += weight * pixel[3] * pixel[c];
                }
                sum[3] += weight * pixel[3];
            }
            sum
        });
        if alpha > 0.0 {
            Ink { color: Rgb { r, g, b } / alpha, alpha: alpha.min(1.0) }
        } else {
            Ink::NONE
        }
    }

    /// Red, green and blue as they are.
    pub(super) fn data(&self, uv: [f64; 2]) -> [f64; 3] {
        let [x, y] = self.place(uv);
        let [r, g, b, _] = self.blend(x, y, weighted);
        [r, g, b]
    }

    /// The derivatives by u and v of the mean of red, green and blue: over a pixel, so that they do not
    /// jump from pixel to pixel.
    pub(super) fn slopes(&self, uv: [f64; 2]) -> [f64; 2] {
        let size = [f64::from(self.image.width()), f64::from(self.image.height())];
        let mean = |uv: [f64; 2]| self.data(uv).iter().sum::<f64>() / 3.0;
        [0, 1].map(|i| {
            let half = 0.5 / (size[i] * self.per_unit[i].abs());
            let (mut before, mut after) = (uv, uv);
            before[i] -= half;
            after[i] += half;
            (mean(after) - mean(before)) / (2.0 * half)
        })
    }

    /// What is made of the four pixels round a place and their weights.
    fn blend(&self, x: f64, y: f64, f: impl Fn(&[[f64; 4]; 4], [f64; 4]) -> [f64; 4]) -> [f64; 4] {
        let (width, height) = (self.image.width(), self.image.height());
        // Rows count from the top.
        let (x, y) = (x * f64::from(width) - 0.5, (1.0 - y) * f64::from(height) - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let index = |i: f64, count: u32| {
            let i = match self.wrap {
                Wrap::Repeat => i.rem_euclid(f64::from(count)),
                Wrap::Clamp | Wrap::Once => i.max(0.0),
            };
            (i as u32).min(count - 1)
        };
        let [left, right] = [left, left + 1.0].map(|i| index(i, width));
        let [top, bottom] = [top, top + 1.0].map(|i| index(i, height));
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)]
            .map(|(x, y)| self.image.pixel(x, y).map(f64::from));
        let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
        f(&corners, weights)
    }
}

fn weighted(corners: &[[f64; 4]; 4], weights: [f64; 4]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (pixel, weight) in corners.iter().zip(weights) {
        for c in 0..4 {
            sum[c] += weight * pixel[c];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two by two: red and green above, blue and a half clear white below.
    fn image() -> Arc<Image> {
        let samples = vec![
            1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, //
            0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.5,
        ];
        Arc::new(Image::new(2, 2, 4, samples).unwrap())
    }

    fn sheet(size: [f64; 2], offset: [f64; 2], wrap: Wrap) -> Sheet {
        Sheet::new(&Described { image: image(), size, offset, wrap })
    }

    #[test]
    fn rows_run_along_u_from_the_top_of_v_down() {
        let sheet = sheet([2.0, 4.0], [1.0, -2.0], Wrap::Once);
        assert_eq!(sheet.at([1.5, 1.0]).color, Rgb { r: 1.0, g: 0.0, b: 0.0 });
        assert_eq!(sheet.at([2.5, 1.0]).color, Rgb { r: 0.0, g: 1.0, b: 0.0 });
        assert_eq!(sheet.at([1.5, -1.0]).color, Rgb { r: 0.0, g: 0.0, b: 1.0 });
        assert_eq!(sheet.at([2.5, -1.0]), Ink { color: Rgb::WHITE, alpha: 0.5 });
        assert_eq!(sheet.at([0.99, 0.0]), Ink::NONE);
        assert_eq!(sheet.at([2.0, 2.01]), Ink::NONE);
        assert_eq!(sheet.at([2.5, -1.0]).over(Rgb::BLACK), Rgb::splat(0.5));
    }

    #[test]
    fn pixels_are_blended_by_how_opaque_they_are() {
        let ink = sheet([1.0; 2], [0.0; 2], Wrap::Clamp).at([0.5, 0.25]);
        assert_eq!(ink.alpha, 0.75);
        assert!((ink.color.r - 0.25 / 0.75).abs() < 1e-15 && ink.color.b == 1.0);
    }

    #[test]
    fn images_repeat_or_go_on_as_they_end() {
        let repeated = sheet([1.0; 2], [0.0; 2], Wrap::Repeat);
        for uv in [[0.1, 0.2], [0.7, 0.9], [0.0, 0.5]] {
            let far = [uv[0] - 3.0, uv[1] + 4.0];
            let (near, far) = (repeated.at(uv), repeated.at(far));
            assert!((near.color.r - far.color.r).abs() < 1e-12);
            assert!((near.alpha - far.alpha).abs() < 1e-12);
        }
        // The seam lies between the right column and the left one.
        assert!((repeated.at([0.0, 0.75]).color.r - 0.5).abs() < 1e-15);
        let clamped = sheet([1.0; 2], [0.0; 2], Wrap::Clamp);
        assert_eq!(clamped.at([-5.0, 9.0]).color, Rgb { r: 1.0, g: 0.0, b: 0.0 });
    }

    #[test]
    fn slopes_are_those_of_a_ramp() {
        let samples = (0..64).map(|i| (i % 8) as f32 / 8.0).collect();
        let image = Arc::new(Image::new(8, 8, 1, samples).unwrap());
        let sheet =
            Sheet::new(&Described { image, size: [2.0, 1.0], offset: [0.0; 2], wrap: Wrap::Clamp });
        let [du, dv] = sheet.slopes([1.0, 0.5]);
        assert!((du - 0.5).abs() < 1e-12 && dv.abs() < 1e-12, "{du} {dv}");
    }
}

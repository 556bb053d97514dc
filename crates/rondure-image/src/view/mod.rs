//! From the light of a scene to the light of a screen: exposure, white balance and a view transform.

mod agx;
mod neutral;

use crate::{White, matrix, matrix::Matrix};

/// How light that may be of any strength becomes light between 0 and 1 that a screen can show. Linear
/// Rec. 709 on both sides; the sRGB curve of [`tone`](crate::tone) comes after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// What is brighter than white is cut off, channel by channel.
    #[default]
    Srgb,
    /// AgX, as in Blender 4: bright colours go over into white the way film does, the picture has soft contrast.
    AgX,
    /// The Khronos PBR Neutral tone mapper: colours stay what the materials say, only what comes near white or is brighter is
    /// compressed.
    Neutral,
}

impl View {
    /// The light on the screen, each channel from 0 to 1.
    pub fn show(self, light: [f64; 3]) -> [f64; 3] {
        let shown = match self {
            Self::Srgb => light,
            Self::AgX => agx::form(light),
            Self::Neutral => neutral::compress(light),
        };
        shown.map(|v| if v > 0.0 { v.min(1.0) } else { 0.0 })
    }
}

/// Everything between the light of a picture and the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    view: View,
    grade: Matrix,
}

impl Look {
    /// The light is multiplied by `exposure`, then `white` is made white, then the view is applied.
    pub fn new(view: View, exposure: f64, white: &White) -> Self {
        let grade = matrix::product(&matrix::diagonal([exposure; 3]), white.adaptation());
        Self { view, grade }
    }

    /// The light that the screen shall show, each channel from 0 to 1, for light of any strength.
    pub fn show(&self, light: [f32; 3]) -> [f64; 3] {
        self.view.show(matrix::apply(&self.grade, light.map(f64::from)))
    }
}

impl Default for Look {
    fn default() -> Self {
        Self::new(View::Srgb, 1.0, &White::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWS: [View; 3] = [View::Srgb, View::AgX, View::Neutral];

    #[test]
    fn every_view_shows_anything_within_the_screen() {
        let values = [-1e30, -0.1, 0.0, 1e-30, 0.18, 1.0, 7.0, 1e30, f64::INFINITY, f64::NAN];
        for view in VIEWS {
            for r in values {
                for g in values {
                    for b in values {
                        let shown = view.show([r, g, b]);
                        let good = shown.iter().all(|v| (0.0..=1.0).contains(v));
                        assert!(good, "{view:?} {r} {g} {b}: {shown:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn greys_stay_grey_and_in_order() {
        for view in VIEWS {
            let mut last = -1.0;
            for stop in -160..=112 {
                let grey = 0.18 * (f64::from(stop) / 16.0).exp2();
                let [r, g, b] = view.show([grey; 3]);
                assert!(
                    (r - g).abs() < 1e-12 && (b - g).abs() < 1e-12,
                    "{view:?} {grey}: {r} {g} {b}"
                );
                assert!(g >= last, "{view:?} {grey}");
                last = g;
            }
            assert!(last > 0.99, "{view:?}");
        }
    }

    #[test]
    fn exposure_comes_before_the_view() {
        for view in VIEWS {
            let look = Look::new(view, 4.0, &White::default());
            let shown = look.show([0.1, 0.25, 0.05]);
            let expected = view.show([0.1_f32, 0.25, 0.05].map(|v| 4.0 * f64::from(v)));
            for (a, b) in shown.iter().zip(expected) {
                assert!((a - b).abs() < 1e-12);
            }
        }
    }
}

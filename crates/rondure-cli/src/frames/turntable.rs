//! `rondure turntable`: the camera goes round what it looks at.

use clap::Args;

use super::{FrameArgs, Sequence};
use crate::failure::Failure;

/// Go round what the camera looks at, and make frames, a contact sheet and an animation
#[derive(Debug, Args)]
#[command(after_help = "\
The camera turns round the axis through `look_at` along `up`. In the folder (SCENE-turntable, if no
other is named) are then frame-0001.png and so on, contact-sheet.png, animation.png, which browsers
show as a film, and animation.mp4 if ffmpeg is installed.

Frames that are there already, made from the same scene with the same settings, are kept: a command
that was stopped can be given again.

Examples:
  rondure turntable scenes/rook.toml --frames 72
  rondure turntable vase.toml -o vase --size 320x320 --spp 16 --degrees -90")]
pub(crate) struct Turntable {
    #[command(flatten)]
    args: FrameArgs,

    /// How many frames
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,

    /// How far to go, against the clock as seen from above; less than 0 goes the other way
    #[arg(long, value_name = "ANGLE", default_value_t = 360.0, allow_negative_numbers = true, value_parser = angle)]
    degrees: f64,
}

fn angle(text: &str) -> Result<f64, String> {
    let good = |x: &f64| x.abs() <= 36_000.0;
    text.parse().ok().filter(good).ok_or_else(|| "expected an angle from -36000 to 36000".into())
}

impl Turntable {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let scene = self.args.scene.read()?;
        // The frame that would close the circle is the first again; of an arc, the last is its end.
        let whole = self.degrees % 360.0 == 0.0;
        let steps = if whole { self.frames } else { self.frames.saturating_sub(1).max(1) };
        let turn = self.degrees.to_radians();
        let camera = |i| scene.camera.turned(turn * f64::from(i) / f64::from(steps));
        let cameras = (0..self.frames).map(camera).collect();
        Sequence::new(&self.args, "turntable", scene, cameras)?.run()
    }
}

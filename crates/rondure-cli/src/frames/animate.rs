//! `rondure animate`: the camera goes along its keyframes.

use clap::Args;
use rondure_scene::Camera;

use super::{FrameArgs, Sequence, check_number};
use crate::failure::Failure;

/// Move the camera along its keyframes, and make frames, a contact sheet and an animation
#[derive(Debug, Args)]
#[command(after_help = "\
The keyframes are tables [[camera.key]] in the scene, each with a `time` in seconds and what changes:
eye, look_at, up, fov or height, lens_radius, focus. In the folder (SCENE-animation, if no other is
named) are then frame-0001.png and so on, contact-sheet.png, animation.png, which browsers show as a
film, and animation.mp4 if ffmpeg is installed.

Frames that are there already, made from the same scene with the same settings, are kept: a command
that was stopped can be given again.

Examples:
  rondure animate flight.toml
  rondure animate flight.toml --fps 6 --size 320x180 --spp 4")]
pub(crate) struct Animate {
    #[command(flatten)]
    args: FrameArgs,
}

impl Animate {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let scene = self.args.scene.read()?;
        let (Some(first), Some(last)) = (scene.keys.first(), scene.keys.last()) else {
            return Err(Failure::new(
                format!(
                    "the camera of `{}` has no keys to move along",
                    self.args.scene.path.display()
                ),
                "write [[camera.key]] tables with `time` and `eye`, or use rondure turntable",
            ));
        };
        let (start, fps) = (first.time, self.args.fps);
        // The half is for the last key to have its frame whatever the rounding.
        let frames = check_number(((last.time - start) * fps + 0.5).floor() + 1.0)?;
        let cameras = (0..frames)
            .filter_map(|i| Camera::between(&scene.keys, start + i as f64 / fps))
            .collect();
        Sequence::new(&self.args, "animation", scene, cameras)?.run()
    }
}

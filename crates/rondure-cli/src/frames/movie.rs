//! Films of the frames: animated PNG without any tool, MP4 with ffmpeg.

use std::{fs, io, path::PathBuf, process::Command};

use rondure_image::{png, tone};

use super::{Sequence, product};
use crate::{failure::Failure, picture::cannot_write};

/// What stops an animation: a frame, or the file that it goes to.
enum Stop {
    Frame(Failure),
    File(png::WriteError),
}

impl From<png::WriteError> for Stop {
    fn from(error: png::WriteError) -> Self {
        Self::File(error)
    }
}

/// Makes the animated PNG.
pub(super) fn make_animation(sequence: &Sequence<'_>) -> Result<PathBuf, Failure> {
    let path = product(sequence, "animation.png");
    let frames = (0..sequence.cameras.len()).map(|i| {
        let frame = sequence.frame(i).map_err(Stop::Frame)?;
        let signal = |v: &f32| (255.0 * tone::srgb(f64::from(*v))).round() as u8;
        Ok(frame.pixels().iter().flatten().map(signal).collect())
    });
    match png::write_animation(&path, sequence.size(), sequence.args.fps, frames) {
        Ok(()) => Ok(path),
        Err(Stop::Frame(failure)) => Err(failure),
        Err(Stop::File(error)) => Err(cannot_write(&path, error)),
    }
}

/// Makes the MP4; `None` without ffmpeg.
pub(super) fn make_film(sequence: &Sequence<'_>) -> Result<Option<PathBuf>, Failure> {
    let path = product(sequence, "animation.mp4");
    // The name it has until it is whole must end in .mp4: by that ffmpeg knows what to write.
    let unfinished = product(sequence, ".unfinished.mp4");
    let frames = format!("frame-%0{}d.png", sequence.digits());
    let output = Command::new("ffmpeg")
        .args(["-y", "-nostdin", "-loglevel", "error", "-framerate"])
        .arg(sequence.args.fps.to_string())
        .arg("-i")
        .arg(product(sequence, &frames))
        .arg("-frames:v")
        .arg(sequence.cameras.len().to_string())
        // Players want even sides, and four bits of colour for eight of light.
        .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv"])
        .args(["-c:v", "libx264", "-crf", "16", "-preset", "slow", "-pix_fmt", "yuv420p"])
        .args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"])
        .args(["-movflags", "+faststart"])
        .arg(&unfinished)
        .output();
    match output {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Failure::new(
            format!("ffmpeg cannot be started: {error}"),
            "the frames and the animation are made; make an MP4 of them by other means",
        )),
        Ok(output) if !output.status.success() => {
            drop(fs::remove_file(&unfinished));
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().last().unwrap_or("it says nothing");
            Err(Failure::new(
                format!("ffmpeg made no MP4: {last}"),
                "the frames and the animation are made; make an MP4 of them by other means",
            ))
        }
        Ok(_) => {
            fs::rename(&unfinished, &path).map_err(|error| Failure::unwritable(&path, &error))?;
            Ok(Some(path))
        }
    }
}

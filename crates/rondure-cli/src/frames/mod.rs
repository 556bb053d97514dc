//! Pictures in a row: frames that are kept when the work is taken up again, and what is made of them.
//!
//! Each frame carries, as a text, the hash of everything that it depends on. A frame that is there, whole, with the right hash is not made again.

mod animate;
mod movie;
mod sheet;
mod turntable;

use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use rondure_image::{Depth, Image, png};
use rondure_render::{Progress, render};
use rondure_scene::{Camera, Scene};
use sha2::{Digest, Sha256};

pub(crate) use self::{animate::Animate, turntable::Turntable};
use crate::{
    failure::Failure,
    interrupt,
    picture::cannot_write,
    progress::{Watcher, seconds},
    render::cannot_render,
    scene::SceneArgs,
};

/// What turntables and animations have in common.
#[derive(Debug, Args)]
pub(crate) struct FrameArgs {
    /// The folder for the frames and what is made of them; made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// How many frames are shown in a second
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = rate)]
    fps: f64,

    #[command(flatten)]
    scene: SceneArgs,
}

fn rate(text: &str) -> Result<f64, String> {
    let good = |x: &f64| (0.1..=600.0).contains(x);
    text.parse().ok().filter(good).ok_or_else(|| "expected a number from 0.1 to 600".into())
}

/// The key of the text in a frame's file.
const MARK: &str = "Rondure frame";
/// The most frames, more than an hour of them.
const MOST_FRAMES: usize = 100_000;

impl FrameArgs {
    /// The folder that was asked for, or one in the current folder called after the scene.
    fn folder(&self, kind: &str) -> Result<PathBuf, Failure> {
        let name = self.scene.name(self.output.as_ref(), format!("-{kind}").as_ref());
        name.ok_or_else(|| Failure::new("the frames have no folder", "give one with -o FOLDER"))
    }
}

/// Frames to be made of a scene, one for each camera.
struct Sequence<'a> {
    args: &'a FrameArgs,
    folder: PathBuf,
    scene: Scene,
    cameras: Vec<Camera>,
    /// The hash of what the frames have in common.
    common: String,
}

impl<'a> Sequence<'a> {
    fn new(
        args: &'a FrameArgs,
        kind: &str,
        mut scene: Scene,
        cameras: Vec<Camera>,
    ) -> Result<Self, Failure> {
        let folder = args.folder(kind)?;
        if let Some(i) = cameras.iter().position(|camera| !camera.has_view()) {
            return Err(Failure::new(
                format!("the camera looks nowhere, or along its own `up`, in frame {}", i + 1),
                "move `eye`, `look_at` or `up`",
            ));
        }
        // What the frames have in common; a camera of each comes to it.
        scene.keys.clear();
        if let Some(camera) = cameras.first() {
            scene.camera = camera.clone();
        }
        let version = env!("CARGO_PKG_VERSION");
        let common = hash(&format!("{version} {} {scene:?}", args.scene.seed));
        Ok(Self { args, folder, scene, cameras, common })
    }

    fn run(mut self) -> Result<(), Failure> {
        self.make_folder()?;
        let missing: Vec<usize> =
            (0..self.cameras.len()).filter(|i| self.kept(*i).is_none()).collect();
        let kept = self.cameras.len() - missing.len();
        if kept > 0 && !self.args.scene.quiet {
            anstream::eprintln!("{kept} of {} frames are there already", self.cameras.len());
        }
        let cancelled = interrupt::flag();
        let watcher = Watcher::new(self.args.scene.quiet, &cancelled);
        let start = Instant::now();
        for (done, i) in missing.iter().enumerate() {
            let progress = Part { inner: &watcher, done, all: missing.len() };
            if let Err(failure) = self.make(*i, &progress) {
                watcher.finish();
                return Err(match failure {
                    Failure::Interrupted => Failure::InterruptedAfter(format!(
                        "stopped; {} of {} frames are in {} and will be kept",
                        kept + done,
                        self.cameras.len(),
                        self.folder.display()
                    )),
                    other => other,
                });
            }
        }
        watcher.finish();
        let time = start.elapsed().as_secs_f64();
        let mut made = vec![sheet::make(&self)?, movie::make_animation(&self)?];
        let film = movie::make_film(&self)?;
        made.extend(film.clone());
        if !self.args.scene.quiet {
            anstream::eprintln!(
                "{}: {} frames, {} made in {}",
                self.folder.display(),
                self.cameras.len(),
                missing.len(),
                seconds(time)
            );
            let names: Vec<_> = made.iter().map(|path| path.display().to_string()).collect();
            anstream::eprintln!("{}", names.join(", "));
            if film.is_none() {
                anstream::eprintln!("no MP4 was made: the program ffmpeg is not installed");
            }
        }
        Ok(())
    }

    /// Makes sure, before hours of work, that frames can be written.
    fn make_folder(&self) -> Result<(), Failure> {
        let unwritable = |error| Failure::unwritable(&self.folder, &error);
        fs::create_dir_all(&self.folder).map_err(unwritable)?;
        tempfile::Builder::new()
            .prefix(".rondure-")
            .tempfile_in(&self.folder)
            .and_then(tempfile::NamedTempFile::close)
            .map_err(unwritable)
    }

    fn size(&self) -> [u32; 2] {
        [self.scene.film.width, self.scene.film.height]
    }

    /// The digits of a frame's number.
    fn digits(&self) -> usize {
        self.cameras.len().to_string().len().max(4)
    }

    fn path(&self, i: usize) -> PathBuf {
        self.folder.join(format!("frame-{:0width$}.png", i + 1, width = self.digits()))
    }

    fn mark(&self, i: usize) -> String {
        hash(&format!("{} {:?}", self.common, self.cameras[i]))
    }

    /// The frame, if it is there, whole, and of this scene with these settings.
    fn kept(&self, i: usize) -> Option<Image> {
        let decoded = png::read(self.path(i)).ok()?;
        let mark = decoded.texts.iter().find(|(key, _)| key == MARK)?;
        let fits = [decoded.image.width(), decoded.image.height()] == self.size();
        (fits && mark.1 == self.mark(i)).then_some(decoded.image)
    }

    /// A frame that has been made.
    fn frame(&self, i: usize) -> Result<Image, Failure> {
        self.kept(i).ok_or_else(|| {
            let path = self.path(i);
            Failure::new(
                format!("`{}` was changed while the frames were made", path.display()),
                "run the command again; the other frames are kept",
            )
        })
    }

    fn make(&mut self, i: usize, progress: &dyn Progress) -> Result<(), Failure> {
        self.scene.camera = self.cameras[i].clone();
        let picture =
            render(&self.scene, &self.args.scene.settings(), progress).map_err(cannot_render)?;
        let path = self.path(i);
        let texts = [(MARK.to_owned(), self.mark(i))];
        let depth = Depth::of_bits(self.scene.film.bits).unwrap_or_default();
        let signals = picture.image().signals(picture.look(), depth);
        png::write(&path, self.size(), &signals, &texts).map_err(|error| cannot_write(&path, error))
    }
}

fn hash(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The progress of one frame as a part of that of all.
struct Part<'a> {
    inner: &'a dyn Progress,
    done: usize,
    all: usize,
}

impl Progress for Part<'_> {
    fn advance(&self, done: f64) {
        self.inner.advance((self.done as f64 + done) / self.all as f64);
    }

    fn preparing(&self, done: f64) {
        self.inner.preparing(done);
    }

    fn is_cancelled(&self) -> bool {
        self.inner.is_cancelled()
    }
}

/// Too many frames, told before the work.
fn check_number(frames: f64) -> Result<usize, Failure> {
    if frames <= MOST_FRAMES as f64 {
        return Ok(frames as usize);
    }
    Err(Failure::new(
        format!("{frames:.0} frames are too many; {MOST_FRAMES} can be made"),
        "take a lower --fps, or cut the way in pieces",
    ))
}

/// The path of something made of the frames.
fn product(sequence: &Sequence<'_>, name: &str) -> PathBuf {
    Path::new(&sequence.folder).join(name)
}

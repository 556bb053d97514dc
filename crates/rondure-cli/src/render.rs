//! `rondure render`: from a scene to a picture.

use std::{
    path::PathBuf,
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use clap::Args;
use rondure_film::{Portion, Recipe, Room, ShareRef, Statistics};
use rondure_render::{Job, Outcome, RenderError, Work};
use rondure_scene::{Scene, scene_digest};

use crate::{
    checkpoint::Checkpoint,
    failure::Failure,
    interrupt,
    look::settings_of,
    output::{self, Kind, Output, Shown},
    part::PartArgs,
    progress::{Watcher, seconds},
    room::{RoomArgs, cannot_keep},
    scene::SceneArgs,
    watch::{self, Watch},
};

/// Render a scene into a picture, or a part of one
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rondure render scenes/still-life.toml                       make still-life.png, here
  rondure render chess.toml -o chess.exr                      with layers, for compositing
  rondure render chess.toml -o draft.png --size 320x240 --spp 4
  rondure render chess.toml --checkpoint chess.rdf --resume   go on where it was stopped
  rondure render chess.toml --part 2/7 -o part-2.rdf          a part, for `rondure merge`

The picture is the same, bit for bit, for any number of threads, in however many parts it was made, and
however often it was stopped. It appears under its name only when it is whole; Ctrl-C writes what
there is.")]
pub(crate) struct Render {
    /// Where to write the picture, a PNG or OpenEXR file, or the part of one, an .rdf file; the scene's name with .png in the
    /// current folder if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Take no more samples where the relative noise is below this, like 0.01; --spp is the most then
    #[arg(long, value_name = "X", value_parser = noise)]
    noise: Option<f64>,

    #[command(flatten)]
    scene: SceneArgs,

    #[command(flatten)]
    long: LongArgs,

    #[command(flatten)]
    part: PartArgs,

    #[command(flatten)]
    room: RoomArgs,
}

/// The least relative noise that can be asked for: it takes some 1e12 samples a pixel to come there, more than
/// `--spp` allows.
const LEAST_NOISE: f64 = 1e-6;

fn noise(text: &str) -> Result<f64, &'static str> {
    let good = |x: &f64| (LEAST_NOISE..=1.0).contains(x);
    text.parse().ok().filter(good).ok_or("expected a number from 0.000001 to 1")
}

#[derive(Debug, Args)]
struct LongArgs {
    /// Show the picture so far in this PNG file, every few seconds
    #[arg(long, value_name = "FILE.png", help_heading = LONG)]
    preview: Option<PathBuf>,

    /// Stop after this time, like 90s or 1h30m, with the samples that there are
    #[arg(long, value_name = "TIME", value_parser = watch::duration, help_heading = LONG)]
    time: Option<Duration>,

    /// Keep the work in this file, so that it can be gone on with; it is deleted when all is done
    #[arg(long, value_name = "FILE", help_heading = LONG)]
    checkpoint: Option<PathBuf>,

    /// How often the checkpoint is written
    #[arg(long, value_name = "TIME", value_parser = watch::duration, default_value = "1m", requires = "checkpoint", help_heading = LONG)]
    every: Duration,

    /// Go on from the checkpoint, if it is there
    #[arg(long, requires = "checkpoint", help_heading = LONG)]
    resume: bool,
}

const LONG: &str = "Long work";

impl Render {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let scene = self.scene.read()?;
        let output = self.output()?;
        let recipe = self.recipe(&scene)?;
        let shown = Shown::of(&scene.film)?;
        let settings = self.scene.settings();
        let job = Job::new(&scene, &settings, output.layers()).map_err(cannot_render)?;
        let portion = self.part.of(&job.whole(), self.noise.is_some())?;
        let pixels = portion.window.pixels();
        output.check(pixels)?;
        let preview = self.long.preview.clone().map(watch::preview).transpose()?;
        if let Some(preview) = &preview {
            preview.check(pixels)?;
        }
        if let Some(checkpoint) = &self.long.checkpoint {
            let checkpoint = ("the checkpoint", checkpoint.as_path(), "--checkpoint");
            output::check_apart(("the picture", &output.path), checkpoint)?;
            if let Some(preview) = &preview {
                output::check_apart(("the preview", &preview.path), checkpoint)?;
            }
        }
        let checkpoint = self.long.checkpoint.as_deref().map(Checkpoint::new).transpose()?;
        let room = self.room.of(&output.path);
        let mut work = match &checkpoint {
            Some(checkpoint) => self.begin(&job, &recipe, &portion, checkpoint, &room)?,
            None => Work::new(&job, portion.clone(), &room).map_err(cannot_render)?,
        };
        if let Some(noise) = self.noise {
            work = work.until(&job, noise).map_err(cannot_render)?;
        }

        let cancelled = interrupt::flag();
        let before = work.snapshot().done();
        let (rays, start) = (*work.statistics(), Instant::now());
        let watcher = Watcher::new(self.scene.quiet, &cancelled).after(before);
        let mut watch = Watch::new(&watcher, &recipe, self.part.number(), &shown, self.long.every);
        watch.checkpoint = checkpoint.as_ref();
        watch.preview = preview.as_ref();
        watch.end = self.long.time.and_then(|time| start.checked_add(time));
        if let Some(checkpoint) = &checkpoint {
            // There and then it shows whether there is room for it.
            let state = work.snapshot();
            checkpoint.write(&watch.share(&state, &state.covered()))?;
        }
        let outcome = work.run(&job, settings.threads, &watch);
        let time = start.elapsed().as_secs_f64();
        watcher.finish();
        let outcome = outcome.map_err(cannot_render)?;

        let state = work.snapshot();
        let covered = Portion::joined(state.covered());
        let share = watch.share(&state, &covered);
        self.tell_invalid(share.statistics);
        if outcome == Outcome::Finished {
            self.write(&output, &share, &shown, checkpoint.as_ref())?;
            if let Some(checkpoint) = &checkpoint {
                checkpoint.remove();
            }
            self.scene.tell(|| {
                format!(
                    "{}: {}",
                    output.path.display(),
                    summary(&share, &rays, time, self.noise.is_some())
                )
            });
            return Ok(());
        }
        let mut written = Vec::new();
        if let Some(checkpoint) = &checkpoint {
            checkpoint.write(&watch.share(&state, &state.covered()))?;
            written.push(format!("the checkpoint {}", checkpoint.path().display()));
        }
        // A picture with holes is none; a part may have them.
        let least = covered.iter().map(|p| p.samples.end - portion.samples.start).min();
        let whole = portion.samples.start..portion.samples.start + least.unwrap_or(0);
        let first = Portion { window: portion.window, samples: whole };
        let shows = first.samples.end > first.samples.start && first.missing(&covered).is_empty();
        if shows || (output.kind == Kind::Share && !covered.is_empty()) {
            self.write(&output, &share, &shown, checkpoint.as_ref())?;
            written.push(format!("{}, unfinished", output.path.display()));
        }
        let done = (100.0 * state.done()).floor();
        let text = match written.as_slice() {
            [] if cancelled.load(Ordering::Relaxed) => return Err(Failure::Interrupted),
            [] => format!("stopped after {}; nothing has been written", seconds(time)),
            written => format!("stopped at {done} %; written: {}", written.join("; ")),
        };
        if cancelled.load(Ordering::Relaxed) {
            return Err(Failure::InterruptedAfter(text));
        }
        self.scene.tell(|| text);
        Ok(())
    }

    /// Everything that decides a bit of the sums.
    fn recipe(&self, scene: &Scene) -> Result<Recipe, Failure> {
        let file = &self.scene.path;
        let path = file.display().to_string();
        let digest = scene_digest(file).map_err(|e| Failure::unreadable(&path, &e))?;
        // Without its folder, which is nobody's business whom the picture is given to.
        let name = file.file_name().map_or(path, |name| name.to_string_lossy().into_owned());
        let film = &scene.film;
        let settings = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("seed", self.scene.seed.to_string()),
            ("depth", film.depth.to_string()),
            ("filter", film.filter.to_string()),
            ("integrator", format!("{:?}", film.integrator)),
            ("noise", self.noise.map_or("any".to_owned(), |noise| noise.to_string())),
            ("engine", self.scene.engine.describe()),
        ];
        let shown = settings_of(film).map(|(key, value)| (key.to_owned(), value));
        let settings = settings.map(|(key, value)| (key.to_owned(), value));
        let settings = settings.into_iter().chain(shown).collect();
        Ok(Recipe { name, scene: digest, spp: film.spp, settings })
    }

    /// The work that a checkpoint holds, or new work if it holds none.
    fn begin(
        &self,
        job: &Job<'_>,
        recipe: &Recipe,
        portion: &Portion,
        checkpoint: &Checkpoint,
        room: &Room,
    ) -> Result<Work, Failure> {
        let new = || Work::new(job, portion.clone(), room).map_err(cannot_render);
        if !self.long.resume {
            if checkpoint.path().exists() {
                let path = checkpoint.path().display();
                let title = format!("there is a checkpoint `{path}` already");
                return Err(Failure::new(title, "add --resume to go on from it, or delete it"));
            }
            return new();
        }
        let Some(share) = checkpoint.read(job, recipe, portion, room)? else { return new() };
        Work::resume(job, portion.clone(), share).map_err(|e| checkpoint.refused(&e.to_string()))
    }

    /// Writes the result. If that fails it is kept elsewhere.
    fn write(
        &self,
        output: &Output,
        share: &ShareRef<'_>,
        shown: &Shown,
        checkpoint: Option<&Checkpoint>,
    ) -> Result<(), Failure> {
        output.write(share, shown).map_err(|failure| {
            let kept = match checkpoint {
                Some(checkpoint) if checkpoint.write(share).is_ok() => {
                    Some(checkpoint.path().to_owned())
                }
                _ => output::rescue(&output.path, share),
            };
            match kept {
                Some(path) => failure.with_note(&format!(
                    "nothing is lost: `rondure merge {} -o FILE` makes the picture",
                    path.display()
                )),
                None => failure.with_note("there was no other place either, and the work is lost"),
            }
        })
    }

    fn output(&self) -> Result<Output, Failure> {
        let end = match self.part.number() {
            Some((number, of)) => format!(".part-{number}-of-{of}.rdf"),
            None if self.part.is_some() => ".part.rdf".to_owned(),
            None => ".png".to_owned(),
        };
        let path = self.scene.name(self.output.as_ref(), end.as_ref()).ok_or_else(|| {
            Failure::new("the picture has no name", "give it one with -o OUT.png")
        })?;
        let output = Output::new(path, "-o")?;
        if self.part.is_some() && output.kind != Kind::Share {
            let title = format!("cannot write a part of a picture to `{}`", output.path.display());
            return Err(Failure::new(
                title,
                "give it a name that ends in .rdf, and merge the parts",
            ));
        }
        Ok(output)
    }

    fn tell_invalid(&self, statistics: &Statistics) {
        let invalid = statistics.invalid_samples;
        if invalid > 0 {
            anstream::eprintln!(
                "warning: {invalid} samples came out as no light and were left out"
            );
        }
    }
}

pub(crate) fn cannot_render(error: RenderError) -> Failure {
    let help = match error {
        RenderError::Cancelled => return Failure::Interrupted,
        RenderError::Sums(error) => return cannot_keep(error),
        RenderError::TooLarge { .. } | RenderError::Film(_) => "choose a smaller --size",
        RenderError::NoisePart => "leave away --noise, or what makes it a part",
        RenderError::Threads(_) => "ask for fewer with --threads",
        _ => "change the scene",
    };
    Failure::new(error, help)
}

/// What was done since `before`, in how many seconds.
fn summary(share: &ShareRef<'_>, before: &Statistics, time: f64, adaptive: bool) -> String {
    let rays = |s: &Statistics| s.camera_rays + s.secondary_rays + s.shadow_rays;
    let samples = share.statistics.camera_rays - before.camera_rays;
    let rays = rays(share.statistics) - rays(before);
    let window = share.sums.window();
    let mean = share.statistics.camera_rays as f64 / window.pixels() as f64;
    let spp = if adaptive {
        format!("{mean:.1} of {}", share.recipe.spp)
    } else {
        share.recipe.spp.to_string()
    };
    format!(
        "{}x{}, {spp} spp, {} ({}samples/s, {}rays/s)",
        window.width,
        window.height,
        seconds(time),
        rate(samples, time),
        rate(rays, time)
    )
}

/// How many a second, in front of a unit.
fn rate(number: u64, time: f64) -> String {
    match number as f64 / time {
        r if r >= 1e6 => format!("{:.1} M ", r / 1e6),
        r if r >= 1e3 => format!("{:.1} k ", r / 1e3),
        r => format!("{r:.1} "),
    }
}

//! What happens while a picture is made: progress is shown, a preview and a checkpoint are written now and then, and the time is kept.

use std::{
    path::PathBuf,
    sync::Mutex,
    time::{Duration, Instant},
};

use rondure_film::{Portion, Recipe, ShareRef};
use rondure_render::{Progress, Snapshot};

use crate::{
    checkpoint::Checkpoint,
    output::{Kind, Output, Shown},
    progress::Watcher,
};

/// How long after a preview there is another.
const BETWEEN_PREVIEWS: Duration = Duration::from_secs(3);
/// The first one comes sooner.
const FIRST_PREVIEW: Duration = Duration::from_millis(200);
/// Writing takes at most this part of the time.
const SHARE_OF_TIME: u32 = 10;

/// Something that is written again and again.
#[derive(Debug)]
struct Chore {
    due: Instant,
    every: Duration,
    failed: bool,
}

impl Chore {
    fn new(first: Duration, every: Duration) -> Self {
        Self { due: Instant::now() + first, every, failed: false }
    }

    /// Does it if it is due. The first failure in a row is told; then it is tried again when it is due again.
    fn run(&mut self, what: &str, mut write: impl FnMut() -> Result<(), crate::failure::Failure>) {
        let start = Instant::now();
        if start < self.due {
            return;
        }
        match write() {
            Ok(()) => self.failed = false,
            Err(failure) if !self.failed => {
                self.failed = true;
                let going_on = format!("the work goes on without {what}, which is tried again");
                failure.with_note(&going_on).tell();
            }
            Err(_) => {}
        }
        self.due = Instant::now() + self.every.max(start.elapsed() * SHARE_OF_TIME);
    }
}

/// Who waits for a picture, and what they want meanwhile.
pub(crate) struct Watch<'a> {
    pub(crate) watcher: &'a Watcher<'a>,
    pub(crate) recipe: &'a Recipe,
    pub(crate) part: Option<(u32, u32)>,
    pub(crate) checkpoint: Option<&'a Checkpoint>,
    pub(crate) preview: Option<&'a Output>,
    pub(crate) shown: &'a Shown,
    pub(crate) end: Option<Instant>,
    checkpoints: Mutex<Chore>,
    previews: Mutex<Chore>,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(
        watcher: &'a Watcher<'a>,
        recipe: &'a Recipe,
        part: Option<(u32, u32)>,
        shown: &'a Shown,
        every: Duration,
    ) -> Self {
        Self {
            watcher,
            recipe,
            part,
            checkpoint: None,
            preview: None,
            shown,
            end: None,
            checkpoints: Chore::new(every, every).into(),
            previews: Chore::new(FIRST_PREVIEW, BETWEEN_PREVIEWS).into(),
        }
    }

    /// A share of what is done.
    pub(crate) fn share<'s>(
        &'s self,
        so_far: &Snapshot<'s>,
        covered: &'s [Portion],
    ) -> ShareRef<'s> {
        ShareRef {
            recipe: self.recipe,
            part: self.part,
            covered,
            sums: so_far.sums,
            statistics: so_far.statistics,
        }
    }
}

impl Progress for Watch<'_> {
    fn advance(&self, done: f64) {
        self.watcher.advance(done);
    }

    fn preparing(&self, done: f64) {
        self.watcher.preparing(done);
    }

    fn is_cancelled(&self) -> bool {
        self.watcher.is_cancelled()
    }

    fn is_enough(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() >= end)
    }

    fn landed(&self, so_far: &Snapshot<'_>) {
        self.watcher.landed(so_far);
        // One thread at a time comes here.
        if let (Some(checkpoint), Ok(mut chore)) = (self.checkpoint, self.checkpoints.try_lock()) {
            chore.run("a new checkpoint", || {
                checkpoint.write(&self.share(so_far, &so_far.covered()))
            });
        }
        if let (Some(preview), Ok(mut chore)) = (self.preview, self.previews.try_lock()) {
            chore.run("a new preview", || preview.write(&self.share(so_far, &[]), self.shown));
        }
    }
}

/// Where a preview goes: a picture that everything can show.
pub(crate) fn preview(path: PathBuf) -> Result<Output, crate::failure::Failure> {
    let output = Output::new(path, "--preview")?;
    if output.kind == Kind::Png {
        return Ok(output);
    }
    let title =
        format!("cannot write the preview `{}`: previews are PNG files", output.path.display());
    Err(crate::failure::Failure::new(title, "give it a name that ends in .png"))
}

/// A time like 90, 90s, 10m or 1h30m.
pub(crate) fn duration(text: &str) -> Result<Duration, &'static str> {
    const EXPECTED: &str = "a time is a number of seconds, or like 90s, 10m, 1h30m";
    let seconds = |number: &str, unit: f64| {
        number.parse::<f64>().ok().filter(|n| *n >= 0.0).map(|n| n * unit).ok_or(EXPECTED)
    };
    let mut total = 0.0;
    let mut rest = text.trim();
    if rest.is_empty() {
        return Err(EXPECTED);
    }
    let mut last = f64::INFINITY;
    while let Some(end) = rest.find(|c: char| c.is_ascii_alphabetic()) {
        let unit = match &rest[end..=end] {
            "h" => 3600.0,
            "m" => 60.0,
            "s" => 1.0,
            _ => return Err(EXPECTED),
        };
        if unit >= last {
            return Err(EXPECTED);
        }
        last = unit;
        total += seconds(&rest[..end], unit)?;
        rest = &rest[end + 1..];
    }
    if !rest.is_empty() {
        if last < f64::INFINITY {
            return Err(EXPECTED);
        }
        total = seconds(rest, 1.0)?;
    }
    Duration::try_from_secs_f64(total).map_err(|_| EXPECTED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        for (text, seconds) in
            [("90", 90.0), ("1.5s", 1.5), ("10m", 600.0), ("1h30m", 5400.0), ("2h0m5s", 7205.0)]
        {
            assert_eq!(duration(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for bad in ["", "h", "-1", "5x", "5m2h", "5m5m", "1h30", "nan", "1e400", "ß"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }
}

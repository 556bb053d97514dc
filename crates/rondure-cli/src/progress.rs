//! Progress while a picture is rendered: a bar on a terminal, lines elsewhere, or silence.

use std::{
    io::{IsTerminal, Write, stderr},
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Instant,
};

use indicatif::{ProgressBar, ProgressStyle};
use rondure_render::Progress;

/// Shows how far the work is, and passes on the wish to stop.
pub(crate) struct Watcher<'a> {
    display: Display,
    /// The largest share that was reported, in steps of 1 / [`STEPS`].
    reached: AtomicU64,
    cancelled: &'a AtomicBool,
}

enum Display {
    Bar(ProgressBar),
    Lines(Instant),
    None,
}

/// How finely progress is shown by a bar.
const STEPS: u64 = 1000;
/// After how many steps there is another line.
const STEPS_PER_LINE: u64 = 100;

impl<'a> Watcher<'a> {
    pub(crate) fn new(quiet: bool, cancelled: &'a AtomicBool) -> Self {
        let display = if quiet {
            Display::None
        } else if stderr().is_terminal() {
            let bar = ProgressBar::new(STEPS);
            let template = "{bar:40.cyan} {percent:>3} %  {elapsed} passed, {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            Display::Lines(Instant::now())
        };
        Self { display, reached: AtomicU64::new(0), cancelled }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Watcher<'_> {
    fn advance(&self, done: f64) {
        let now = (done * STEPS as f64) as u64;
        let before = self.reached.fetch_max(now, Ordering::Relaxed);
        if now <= before {
            return;
        }
        match &self.display {
            Display::Bar(bar) => bar.set_position(now),
            Display::Lines(start) => {
                if now / STEPS_PER_LINE > before / STEPS_PER_LINE && now < STEPS {
                    let left = start.elapsed().as_secs_f64() * (1.0 - done) / done;
                    let percent = (100.0 * done).floor();
                    // Whoever does not want to read it need not.
                    drop(writeln!(stderr(), "{percent} %, {} left", seconds(left)));
                }
            }
            Display::None => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// A time for people.
pub(crate) fn seconds(time: f64) -> String {
    if time < 60.0 {
        return format!("{time:.1} s");
    }
    let whole = time.round() as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 {
        format!("{hours} h {minutes} min")
    } else {
        format!("{minutes} min {seconds} s")
    }
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn times_are_readable() {
        let found = [0.0123, 59.94, 61.0, 3599.4, 7290.0].map(seconds);
        assert_eq!(found, ["0.0 s", "59.9 s", "1 min 1 s", "59 min 59 s", "2 h 1 min"]);
    }
}

//! Progress while a picture is rendered: a bar on a terminal, lines elsewhere, or silence.

use std::{
    io::{IsTerminal, Write, stderr},
    sync::{
        Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use rondure_render::{Progress, Snapshot};

/// Shows how far the work is, and passes on the wish to stop.
pub(crate) struct Watcher<'a> {
    display: Display,
    /// The largest share that was reported, in steps of 1 / [`STEPS`].
    reached: AtomicU64,
    /// The share that was done before.
    before: f64,
    noise: Mutex<Noise>,
    /// Whether the bar speaks of photons.
    prepares: AtomicBool,
    cancelled: &'a AtomicBool,
}

enum Display {
    Bar(ProgressBar),
    Lines(Mutex<Lines>),
    None,
}

struct Lines {
    start: Instant,
    latest: Instant,
}

impl Lines {
    /// Whether it is time for another.
    fn are_due(&mut self) -> bool {
        let due = self.latest.elapsed() >= BETWEEN_LINES;
        if due {
            self.latest = Instant::now();
        }
        due
    }

    fn advance(&mut self, before: f64, done: f64, noise: Option<f64>) {
        if !self.are_due() {
            return;
        }
        let left = self.start.elapsed().as_secs_f64() * (1.0 - done) / (done - before);
        let noise = noise.map(|noise| format!(", {}", noise_text(noise))).unwrap_or_default();
        // Whoever does not want to read it need not.
        drop(writeln!(stderr(), "{} %{noise}, {} left", (100.0 * done).floor(), seconds(left)));
    }
}

/// The noise of the picture, as it was last looked at.
#[derive(Default)]
struct Noise {
    level: Option<f64>,
    looked: Option<Instant>,
}

/// How long after a look at the noise there is another.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);

fn noise_text(noise: f64) -> String {
    format!("noise {:.2} %", 100.0 * noise)
}

/// How finely progress is shown by a bar.
const STEPS: u64 = 1000;
/// How long after a line there is another.
const BETWEEN_LINES: Duration = Duration::from_secs(2);

impl<'a> Watcher<'a> {
    pub(crate) fn new(quiet: bool, cancelled: &'a AtomicBool) -> Self {
        let display = if quiet {
            Display::None
        } else if stderr().is_terminal() {
            let bar = ProgressBar::new(STEPS);
            let template = "{bar:40.cyan} {percent:>3} %  {msg}{elapsed} passed, {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            let start = Instant::now();
            Display::Lines(Mutex::new(Lines { start, latest: start }))
        };
        let reached = AtomicU64::new(0);
        let (noise, prepares) = (Mutex::default(), AtomicBool::new(false));
        Self { display, reached, before: 0.0, noise, prepares, cancelled }
    }

    /// The same, for work of which a share has been done before.
    pub(crate) fn after(mut self, done: f64) -> Self {
        self.before = done;
        let steps = (done * STEPS as f64) as u64;
        self.reached.store(steps, Ordering::Relaxed);
        if let Display::Bar(bar) = &self.display {
            bar.set_position(steps);
            bar.reset_eta();
        }
        self
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
            Display::Lines(lines) => {
                if let Ok(mut lines) = lines.try_lock() {
                    let noise = self.noise.try_lock().ok().and_then(|noise| noise.level);
                    lines.advance(self.before, done, noise);
                }
            }
            Display::None => {}
        }
    }

    fn preparing(&self, done: f64) {
        let text = || format!("photons {:.0} %", (100.0 * done).floor());
        match &self.display {
            Display::Bar(bar) => {
                self.prepares.store(true, Ordering::Relaxed);
                bar.set_message(text() + "  ");
            }
            Display::Lines(lines) => {
                if let Ok(mut lines) = lines.try_lock()
                    && lines.are_due()
                {
                    drop(writeln!(stderr(), "{}", text()));
                }
            }
            Display::None => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    fn landed(&self, so_far: &Snapshot<'_>) {
        if matches!(self.display, Display::None) {
            return;
        }
        let Ok(mut noise) = self.noise.try_lock() else { return };
        let known = noise.looked.is_some_and(|looked| looked.elapsed() < BETWEEN_LOOKS);
        if !known {
            noise.looked = Some(Instant::now());
            noise.level = so_far.sums.noise().ok().flatten();
        }
        let prepared = self.prepares.swap(false, Ordering::Relaxed);
        if let Display::Bar(bar) = &self.display
            && (prepared || !known)
        {
            bar.set_message(noise.level.map_or_else(String::new, |n| noise_text(n) + "  "));
        }
    }
}

/// A time for people.
pub(crate) fn seconds(time: f64) -> String {
    if time < 0.9995 {
        return format!("{:.0} ms", 1e3 * time);
    }
    if time < 59.95 {
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
        let found = [0.0123, 0.9994, 59.94, 59.96, 61.0, 3599.4, 7290.0].map(seconds);
        assert_eq!(
            found,
            ["12 ms", "999 ms", "59.9 s", "1 min 0 s", "1 min 1 s", "59 min 59 s", "2 h 1 min"]
        );
    }
}

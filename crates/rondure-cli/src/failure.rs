//! How a command fails: what is printed, and with which exit code.

use std::{fmt::Display, io, path::Path, process::ExitCode};

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// Why a command stopped before its end.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Something is wrong, and this text says what; it is printed as it is.
    Report(String),
    /// Everything has been said already.
    Reported,
    /// Stopped by Ctrl-C, with nothing to show for it.
    Interrupted,
    /// Stopped by Ctrl-C, with what there is written.
    InterruptedAfter(String),
    /// Two things that were compared differ by more than was allowed; which, has been said already.
    Differ,
    /// Whoever reads our output has read enough, as `| head` does: no failure of ours.
    NobodyReads,
}

/// The exit code when what was compared differs by more than was allowed.
const DIFFER: u8 = 3;
/// The exit code after Ctrl-C, as shells have it: 128 and the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

impl Failure {
    /// A failure with one sentence, and another that says what would be right.
    pub(crate) fn new(title: impl Display, help: &str) -> Self {
        let title = Group::with_title(Level::ERROR.primary_title(title.to_string()));
        let help = Group::with_title(Level::HELP.secondary_title(help));
        Self::Report(renderer().render(&[title]) + "\n" + &renderer().render(&[help]))
    }

    /// Prints what there is to say.
    pub(crate) fn tell(&self) {
        match self {
            Self::Report(text) => anstream::eprintln!("{text}"),
            Self::Interrupted => anstream::eprintln!("stopped; nothing has been written"),
            Self::InterruptedAfter(text) => anstream::eprintln!("{text}"),
            Self::Reported | Self::Differ | Self::NobodyReads => {}
        }
    }

    /// The same failure with a remark at its end.
    pub(crate) fn with_note(self, note: &str) -> Self {
        match self {
            Self::Report(text) => {
                let note = Group::with_title(Level::NOTE.secondary_title(note));
                Self::Report(text + "\n" + &renderer().render(&[note]))
            }
            other => other,
        }
    }

    /// A file or stream that cannot be read.
    pub(crate) fn unreadable(name: &str, error: &io::Error) -> Self {
        let help = match error.kind() {
            io::ErrorKind::NotFound => "check the name and the folder",
            io::ErrorKind::IsADirectory => "give the name of a file in it",
            io::ErrorKind::PermissionDenied => "check the file's permissions",
            _ => "check the disk or the device that it is on",
        };
        Self::new(format!("cannot read `{name}`: {}", plain(error)), help)
    }

    /// A file that cannot be written.
    pub(crate) fn unwritable(path: &Path, error: &io::Error) -> Self {
        Self::unwritable_by("-o", path, error)
    }

    /// A file, named by this option, that cannot be written.
    pub(crate) fn unwritable_by(option: &str, path: &Path, error: &io::Error) -> Self {
        let help = match error.kind() {
            io::ErrorKind::NotFound => {
                format!("make the folder first, or choose another with {option}")
            }
            _ => format!("choose another place with {option}"),
        };
        Self::new(format!("cannot write `{}`: {}", path.display(), plain(error)), &help)
    }

    /// Standard output that cannot be written.
    pub(crate) fn output(error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Self::NobodyReads;
        }
        Self::new(
            format!("cannot write to standard output: {}", plain(error)),
            "check the place that the output goes to",
        )
    }
}

/// The message of the operating system without its number.
pub(crate) fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error ") {
        Some(end) => text[..end].to_lowercase(),
        None => text,
    }
}

/// A place in a text, shown by its line.
#[derive(Debug)]
pub(crate) struct Excerpt<'a> {
    /// The name of the file.
    pub(crate) name: &'a str,
    /// The number of the line, from 1.
    pub(crate) line: usize,
    /// The line.
    pub(crate) text: &'a str,
    /// The bytes of the line that are at fault.
    pub(crate) span: std::ops::Range<usize>,
    /// What is the matter with them.
    pub(crate) label: &'a str,
}

/// A failure at a place in a text, as a compiler would show it, with what would be right.
pub(crate) fn report(
    title: &str,
    excerpt: &Excerpt<'_>,
    help: &str,
    note: Option<&str>,
) -> Failure {
    let annotation = AnnotationKind::Primary.span(excerpt.span.clone()).label(excerpt.label);
    let snippet = Snippet::source(excerpt.text)
        .line_start(excerpt.line)
        .path(excerpt.name)
        .annotation(annotation);
    let group = Level::ERROR
        .primary_title(title)
        .element(snippet)
        .element(Level::HELP.message(help))
        .elements(note.map(|note| Level::NOTE.message(note)));
    Failure::Report(renderer().render(&[group]))
}

/// Prints what there is to say, and turns the outcome into the exit code.
pub(crate) fn exit_code(outcome: Result<(), Failure>) -> ExitCode {
    let Err(failure) = outcome else { return ExitCode::SUCCESS };
    failure.tell();
    match failure {
        Failure::NobodyReads => ExitCode::SUCCESS,
        Failure::Interrupted | Failure::InterruptedAfter(_) => ExitCode::from(INTERRUPTED),
        Failure::Differ => ExitCode::from(DIFFER),
        Failure::Report(_) | Failure::Reported => ExitCode::FAILURE,
    }
}

/// In colour; `anstream` takes the colours out where they cannot be seen.
fn renderer() -> Renderer {
    Renderer::styled()
}

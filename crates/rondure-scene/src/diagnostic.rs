//! What is wrong with a text, and where: shown like a compiler's messages, all of them at once.
//!
//! A [`Report`] owns the texts that its [`Diagnostic`]s point into, so that it can be shown
//! wherever it ends up. annotate-snippets draws it.

use std::{borrow::Cow, fmt, ops::Range};

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Severity {
    /// Nothing can be built from the text.
    Error,
    /// Something can be built, but perhaps not what was meant.
    Warning,
}

/// A place in one of the texts of a [`Report`], and a word about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The index of the text in [`Report::sources`].
    pub source: usize,
    /// The bytes of the text; `None` for the text as a whole.
    pub span: Option<Range<usize>>,
    /// What stands beside the underlined text; may be empty.
    pub text: String,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in one line.
    pub message: String,
    /// Where: first the place at fault, then others that have to do with it.
    pub labels: Vec<Label>,
    /// What would be right.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without a place.
    pub fn error(message: impl Into<String>) -> Self {
        let message = one_line(message.into());
        Self { severity: Severity::Error, message, labels: Vec::new(), help: None }
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// With the place at fault, in the first text of the report.
    #[must_use]
    pub fn at(mut self, span: Range<usize>, text: impl Into<String>) -> Self {
        self.labels.insert(0, Label { source: 0, span: Some(span), text: one_line(text.into()) });
        self
    }

    /// With another place, in the first text of the report.
    #[must_use]
    pub fn and_at(mut self, span: Range<usize>, text: impl Into<String>) -> Self {
        self.labels.push(Label { source: 0, span: Some(span), text: one_line(text.into()) });
        self
    }

    /// With a word on what would be right.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(one_line(help.into()));
        self
    }
}

/// The text with visible signs for line breaks and all that could command a terminal.
fn one_line(text: String) -> String {
    let visible = |c: char| match c {
        '\0'..='\x1f' => {
            char::from_u32(0x2400 + u32::from(c)).unwrap_or(char::REPLACEMENT_CHARACTER)
        }
        '\x7f' => '\u{2421}',
        c if c.is_control() => char::REPLACEMENT_CHARACTER,
        c => c,
    };
    if text.contains(char::is_control) { text.chars().map(visible).collect() } else { text }
}

/// The text with another character of two bytes for each control character from U+0080 on, which some
/// terminals obey: annotate-snippets replaces the others.
fn without_c1(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| c.is_control() && !c.is_ascii();
    if text.contains(obeyed) { text.replace(obeyed, "\u{b7}").into() } else { text.into() }
}

/// A text, and the name under which it is shown: a path, or something like `<inline>`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The name.
    pub name: String,
    /// The text that spans count the bytes of.
    pub text: String,
}

/// Everything that is wrong with a file and with the files that it refers to.
///
/// [`Display`](fmt::Display) shows it without colour; [`Report::colored`] with colour for a terminal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    sources: Vec<Source>,
    diagnostics: Vec<Diagnostic>,
}

/// How many diagnostics are shown; the rest is counted.
const SHOWN: usize = 40;

impl Report {
    /// A report on one text, with nothing in it yet.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let source = Source { name: name.into(), text: text.into() };
        Self { sources: vec![source], diagnostics: Vec::new() }
    }

    /// A report of one error without a text.
    pub(crate) fn only(diagnostic: Diagnostic) -> Self {
        Self { sources: Vec::new(), diagnostics: vec![diagnostic] }
    }

    /// Adds a diagnostic; one without a place is about the first text as a whole.
    pub fn push(&mut self, mut diagnostic: Diagnostic) {
        if diagnostic.labels.is_empty() && !self.sources.is_empty() {
            diagnostic.labels.push(Label { source: 0, span: None, text: String::new() });
        }
        self.diagnostics.push(diagnostic);
    }

    /// Takes over what is wrong with a file that the first text refers to at `span`.
    pub(crate) fn absorb(&mut self, other: Self, span: Range<usize>) {
        let offset = self.sources.len();
        self.sources.extend(other.sources);
        let here = |text: &str| Label { source: 0, span: Some(span.clone()), text: text.into() };
        for mut diagnostic in other.diagnostics {
            for label in &mut diagnostic.labels {
                label.source += offset;
            }
            let words =
                if diagnostic.labels.is_empty() { "" } else { "the scene refers to it here" };
            diagnostic.labels.push(here(words));
            self.diagnostics.push(diagnostic);
        }
    }

    /// Sorts by place: the order in which a reader of the first text comes upon them.
    pub(crate) fn sort(&mut self) {
        let start = |d: &Diagnostic| {
            d.labels.iter().filter(|l| l.source == 0).find_map(|l| Some(l.span.as_ref()?.start))
        };
        self.diagnostics.sort_by_key(start);
    }

    /// The texts that labels refer to.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// What is wrong.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// The number of errors.
    pub fn errors(&self) -> usize {
        self.diagnostics.iter().filter(|d| d.severity == Severity::Error).count()
    }

    /// The number of warnings.
    pub fn warnings(&self) -> usize {
        self.diagnostics.len() - self.errors()
    }

    /// Whether there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.diagnostics.is_empty()
    }

    /// The text to show on a terminal with colours.
    pub fn colored(&self) -> String {
        self.render(&Renderer::styled())
    }

    /// The text to show where there are no colours.
    pub fn plain(&self) -> String {
        self.render(&Renderer::plain())
    }

    fn render(&self, renderer: &Renderer) -> String {
        let shown = self.diagnostics.iter().take(SHOWN).map(|d| self.render_one(renderer, d));
        let mut text = shown.collect::<Vec<_>>().join("\n\n");
        if let Some(more) = self.diagnostics.len().checked_sub(SHOWN).filter(|n| *n > 0) {
            text += &format!("\n\n... and {more} more");
        }
        text
    }

    fn render_one(&self, renderer: &Renderer, diagnostic: &Diagnostic) -> String {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let labels = |i: usize| diagnostic.labels.iter().filter(move |l| l.source == i);
        // What is drawn borrows the texts.
        let mut shown = Vec::new();
        for (i, source) in self.sources.iter().enumerate() {
            let window = lines_round(&source.text, labels(i).filter_map(|l| l.span.as_ref()));
            shown.push(window.map(|w| (without_c1(&source.text[w.clone()]), w)));
        }
        let mut group = Group::with_title(level.primary_title(&*diagnostic.message));
        let mut drawn = Vec::new();
        for label in &diagnostic.labels {
            if drawn.contains(&label.source) {
                continue;
            }
            drawn.push(label.source);
            let Some(source) = self.sources.get(label.source) else { continue };
            let here = diagnostic.labels.iter().enumerate();
            let here = here.filter(|(_, l)| l.source == label.source);
            let Some((text, window)) = &shown[label.source] else {
                group = group.element(Origin::path(&*source.name));
                continue;
            };
            let first_line = 1 + source.text[..window.start].matches('\n').count();
            let mut snippet = Snippet::source(&**text).line_start(first_line).path(&*source.name);
            for (i, label) in here {
                let Some(span) = &label.span else { continue };
                let kind = if i == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
                let span = span.start - window.start..span.end - window.start;
                let words = Some(&*label.text).filter(|t| !t.is_empty());
                snippet = snippet.annotation(kind.span(span).label(words));
            }
            group = group.element(snippet);
        }
        if let Some(help) = &diagnostic.help {
            group = group.element(Level::HELP.message(&**help));
        }
        renderer.render(&[group])
    }
}

/// The whole lines that the spans touch, so that a large text is not gone through for a small
/// message; `None` without a span.
fn lines_round<'a>(
    text: &str,
    spans: impl Iterator<Item = &'a Range<usize>>,
) -> Option<Range<usize>> {
    let all = spans.cloned().reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))?;
    let start = text[..all.start].rfind('\n').map_or(0, |i| i + 1);
    let rest = &text[all.end..];
    let rest = rest.find('\n').map_or(rest, |i| &rest[..i]);
    let end = all.end + rest.strip_suffix('\r').unwrap_or(rest).len();
    Some(start..end)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.plain())
    }
}

impl std::error::Error for Report {}

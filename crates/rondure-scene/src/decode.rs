//! From a TOML tree to typed values: every value with its place, and every error kept.
//!
//! A decoder asks a [`Table`] for its keys one by one. A key that is missing or has a bad value
//! gives `None` and, if need be, a diagnostic; decoding goes on. What was never asked for is
//! unknown: [`Table::finish`] reports it, with the nearest key that was.

use std::{cell::RefCell, ops::Range, path::Path};

use rondure::Vec3;
use toml::{Spanned, de::DeTable, de::DeValue};

use crate::{Color, Diagnostic, Report, color, image::Images};

/// The text that is decoded and what has been found wrong with it.
pub(crate) struct Context<'t> {
    pub(crate) text: &'t str,
    report: RefCell<Report>,
    /// The pictures that the text refers to.
    pub(crate) images: Images,
}

/// The largest number of a scene: fourth powers of it, as in the area of a rectangle squared, and
/// sixth powers of what a million copies make of it, stay far from the largest f64.
const LARGEST: f64 = 1e60;
/// The smallest length and factor, for the same reason.
pub(crate) const SMALLEST: f64 = 1e-60;

/// Which numbers are allowed.
#[derive(Clone, Copy)]
pub(crate) struct Bounds {
    holds: fn(f64) -> bool,
    words: &'static str,
    /// The least absolute value of a number other than 0.
    smallest: f64,
}

impl Bounds {
    pub(crate) const ANY: Self = Self::new(|_| true, "finite");
    pub(crate) const POSITIVE: Self =
        Self { smallest: SMALLEST, ..Self::new(|x| x > 0.0, "positive") };
    pub(crate) const NOT_NEGATIVE: Self = Self::new(|x| x >= 0.0, "0 or more");
    pub(crate) const NOT_ZERO: Self =
        Self { smallest: SMALLEST, ..Self::new(|x| x != 0.0, "other than 0") };
    pub(crate) const FRACTION: Self = Self::new(|x| (0.0..=1.0).contains(&x), "from 0 to 1");

    pub(crate) const fn new(holds: fn(f64) -> bool, words: &'static str) -> Self {
        Self { holds, words, smallest: 0.0 }
    }
}

/// A value and its place.
#[derive(Clone, Copy)]
pub(crate) struct Value<'a> {
    inner: &'a Spanned<DeValue<'a>>,
    /// The key that it is the value of, or part of the value of.
    key: &'a str,
    cx: &'a Context<'a>,
}

/// A table, and which of its keys have been asked for.
pub(crate) struct Table<'a> {
    entries: &'a DeTable<'a>,
    span: Range<usize>,
    /// What it is, with its article: `a camera`.
    what: String,
    cx: &'a Context<'a>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'t> Context<'t> {
    /// Pictures are looked for in `folder`.
    pub(crate) fn new(text: &'t str, report: Report, folder: &Path) -> Self {
        Self { text, report: RefCell::new(report), images: Images::new(folder) }
    }

    pub(crate) fn push(&self, diagnostic: Diagnostic) {
        self.report.borrow_mut().push(diagnostic);
    }

    pub(crate) fn absorb(&self, report: Report, span: Range<usize>) {
        self.report.borrow_mut().absorb(report, span);
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.report.borrow().errors() > 0
    }

    pub(crate) fn into_report(self) -> Report {
        self.report.into_inner()
    }
}

impl<'a> Table<'a> {
    pub(crate) fn root(cx: &'a Context<'a>, entries: &'a DeTable<'a>) -> Self {
        Self::new(cx, entries, 0..0, "a scene".into())
    }

    fn new(
        cx: &'a Context<'a>,
        entries: &'a DeTable<'a>,
        span: Range<usize>,
        what: String,
    ) -> Self {
        Self { entries, span, what, cx, asked: RefCell::default() }
    }

    pub(crate) fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    pub(crate) fn context(&self) -> &'a Context<'a> {
        self.cx
    }

    /// Says more precisely what the table is, once its type is known.
    pub(crate) fn call(&mut self, what: impl Into<String>) {
        self.what = what.into();
    }

    /// All entries in the order of the text, where the keys are names.
    pub(crate) fn named(&self) -> Vec<(&'a str, Range<usize>, Value<'a>)> {
        let entry = |(key, inner): (&'a Spanned<_>, &'a Spanned<_>)| {
            let name: &'a str = toml::de::DeString::as_ref(key.get_ref());
            (name, key.span(), Value { inner, key: name, cx: self.cx })
        };
        let mut all: Vec<_> = self.entries.iter().map(entry).collect();
        all.sort_by_key(|(_, span, _)| span.start);
        all
    }

    pub(crate) fn get(&self, key: &'static str) -> Option<Value<'a>> {
        self.asked.borrow_mut().push(key);
        let (_, inner) = self.entries.iter().find(|(k, _)| k.get_ref() == key)?;
        Some(Value { inner, key, cx: self.cx })
    }

    /// The place of a key, if the table has it.
    pub(crate) fn key_span(&self, key: &str) -> Option<Range<usize>> {
        self.entries.iter().find(|(k, _)| k.get_ref() == key).map(|(k, _)| k.span())
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.key_span(key).is_some()
    }

    /// A key that must be there.
    pub(crate) fn require(&self, key: &'static str) -> Option<Value<'a>> {
        let value = self.get(key);
        if value.is_none() {
            self.missing(key);
        }
        value
    }

    pub(crate) fn missing(&self, key: &str) {
        let message = format!("{} needs the key `{key}`", self.what);
        self.cx.push(Diagnostic::error(message).at(self.span(), format!("`{key}` is missing")));
    }

    pub(crate) fn number(&self, key: &'static str, bounds: Bounds) -> Option<f64> {
        self.get(key)?.number(bounds)
    }

    /// Reports two keys that exclude each other; `Some` if both are there.
    pub(crate) fn exclude(&self, key: &str, other: &str) -> Option<()> {
        let (a, b) = (self.key_span(key)?, self.key_span(other)?);
        let message = format!("{} has either `{key}` or `{other}`, not both", self.what);
        self.cx.push(Diagnostic::error(message).at(b, "").and_at(a, ""));
        Some(())
    }

    /// Reports the keys that were never asked for.
    pub(crate) fn finish(self) {
        let asked = self.asked.borrow();
        for (key, span, _) in self.named() {
            if asked.contains(&key) {
                continue;
            }
            let message = format!("{} has no key `{key}`", self.what);
            let error = Diagnostic::error(message).at(span, "unknown key");
            self.cx.push(match nearest(key, asked.iter().copied()) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => {
                    let mut known = asked.clone();
                    known.sort_unstable();
                    known.dedup();
                    error.help(format!("the keys are {}", list(known.into_iter())))
                }
            });
        }
    }
}

impl<'a> Value<'a> {
    pub(crate) fn span(&self) -> Range<usize> {
        self.inner.span()
    }

    pub(crate) fn context(&self) -> &'a Context<'a> {
        self.cx
    }

    /// Reports something about this value.
    pub(crate) fn fail<T>(&self, message: impl Into<String>) -> Option<T> {
        self.cx.push(Diagnostic::error(message).at(self.span(), ""));
        None
    }

    pub(crate) fn fail_with_help<T>(&self, message: impl Into<String>, help: String) -> Option<T> {
        self.cx.push(Diagnostic::error(message).at(self.span(), "").help(help));
        None
    }

    fn wrong_type<T>(&self, expected: &str) -> Option<T> {
        self.fail(format!("`{}`: expected {expected}, found {}", self.key, self.type_name()))
    }

    fn type_name(&self) -> &'static str {
        match self.inner.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        }
    }

    /// The string itself, without a word if it is something else.
    pub(crate) fn as_str(&self) -> Option<&'a str> {
        self.inner.get_ref().as_str()
    }

    pub(crate) fn is_array(&self) -> bool {
        self.inner.get_ref().is_array()
    }

    pub(crate) fn is_boolean(&self) -> bool {
        self.inner.get_ref().is_bool()
    }

    pub(crate) fn is_table(&self) -> bool {
        self.inner.get_ref().is_table()
    }

    pub(crate) fn string(&self) -> Option<&'a str> {
        self.as_str().or_else(|| self.wrong_type("a string"))
    }

    pub(crate) fn number(&self, bounds: Bounds) -> Option<f64> {
        let number = match self.inner.get_ref() {
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            DeValue::Integer(i) => integer(i).map(|i| i as f64),
            _ => return self.wrong_type("a number"),
        };
        match number {
            Some(x) if !x.is_finite() => {
                self.fail(format!("`{}` must be finite, not {x}", self.key))
            }
            Some(x) if !(bounds.holds)(x) => {
                self.fail(format!("`{}` must be {}, not {}", self.key, bounds.words, short(x)))
            }
            Some(x) if x.abs() > LARGEST => {
                self.fail(format!("`{}` is {x:e}; at most {LARGEST:e} can be handled", self.key))
            }
            Some(x) if x != 0.0 && x.abs() < bounds.smallest => {
                let message = format!("`{}` is {x:e}; at least {SMALLEST:e} is needed", self.key);
                self.fail(message)
            }
            Some(x) => Some(x),
            None => self.fail(format!("`{}` is too large a number", self.key)),
        }
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&self) -> Option<bool> {
        match self.inner.get_ref() {
            DeValue::Boolean(b) => Some(*b),
            _ => self.wrong_type("true or false"),
        }
    }

    /// A whole number from `least` to `most`.
    pub(crate) fn whole(&self, least: u32, most: u32) -> Option<u32> {
        let words = format!("a whole number from {least} to {most}");
        let DeValue::Integer(i) = self.inner.get_ref() else { return self.wrong_type(&words) };
        let number = integer(i).and_then(|i| u32::try_from(i).ok());
        let good = number.filter(|n| (least..=most).contains(n));
        good.or_else(|| self.fail(format!("`{}` must be {words}", self.key)))
    }

    /// The items of an array.
    pub(crate) fn items(&self, expected: &str) -> Option<Vec<Self>> {
        let Some(array) = self.inner.get_ref().as_array() else { return self.wrong_type(expected) };
        Some(array.iter().map(|inner| Self { inner, ..*self }).collect())
    }

    /// An array of N numbers.
    pub(crate) fn numbers<const N: usize>(&self, bounds: Bounds) -> Option<[f64; N]> {
        let expected = format!("an array of {N} numbers");
        let items = self.items(&expected)?;
        if items.len() != N {
            return self.fail(format!(
                "`{}`: expected {expected}, found {}",
                self.key,
                items.len()
            ));
        }
        let mut numbers = [0.0; N];
        let mut good = true;
        for (number, item) in numbers.iter_mut().zip(items) {
            match item.number(bounds) {
                Some(x) => *number = x,
                None => good = false,
            }
        }
        good.then_some(numbers)
    }

    pub(crate) fn vector(&self) -> Option<Vec3> {
        self.numbers::<3>(Bounds::ANY).map(|[x, y, z]| Vec3::new(x, y, z))
    }

    /// A vector as a direction: not zero, and made a unit vector.
    pub(crate) fn direction(&self) -> Option<Vec3> {
        let v = self.vector()?;
        // By its largest coordinate first, so that no square overflows or vanishes.
        let size = v.max_abs();
        if size == 0.0 {
            return self.fail(format!("`{}` is a direction and must not be zero", self.key));
        }
        Some((v / size).normalized())
    }

    /// A colour: a name, a hex code, or [r, g, b], linear.
    pub(crate) fn color(&self, bounds: Bounds) -> Option<Color> {
        if let Some(text) = self.as_str() {
            return color::from_text(text).or_else(|| {
                self.fail_with_help(format!("`{text}` is no colour"), color::help(text))
            });
        }
        if !self.is_array() {
            return self.wrong_type("a colour: a name, \"#rrggbb\" or [r, g, b]");
        }
        self.numbers(bounds)
    }

    /// One of several words.
    pub(crate) fn choice<T: Copy>(&self, kind: &str, choices: &[(&'static str, T)]) -> Option<T> {
        let word = self.string()?;
        let found = choices.iter().find(|(name, _)| *name == word);
        let names = || choices.iter().map(|(name, _)| *name);
        found.map(|(_, value)| *value).or_else(|| {
            self.fail_with_help(format!("`{word}` is no {kind}"), suggest(word, names()))
        })
    }

    pub(crate) fn table(&self, what: &str) -> Option<Table<'a>> {
        match self.inner.get_ref().as_table() {
            Some(entries) => Some(Table::new(self.cx, entries, self.span(), what.into())),
            None => self.wrong_type("a table"),
        }
    }

    /// An array of tables.
    pub(crate) fn tables(&self, key: &str, what: &str) -> Vec<Table<'a>> {
        if !self.is_array() {
            let message =
                format!("`{key}`: expected an array of tables, found {}", self.type_name());
            let help = format!("write [[{key}]] above each");
            self.fail_with_help::<()>(message, help);
            return Vec::new();
        }
        let items = self.items("an array of tables").unwrap_or_default();
        items.iter().filter_map(|item| item.table(what)).collect()
    }

    /// Where a string's bytes stand in the text; `None` if escapes hide it.
    pub(crate) fn string_content(&self) -> Option<Range<usize>> {
        let (content, span) = (self.as_str()?, self.span());
        let literal = self.cx.text.get(span.clone())?;
        let opening = ["\"\"\"\r\n", "\"\"\"\n", "'''\r\n", "'''\n", "\"\"\"", "'''", "\"", "'"];
        let opening = opening.iter().find(|o| literal.starts_with(**o))?;
        let start = span.start + opening.len();
        let place = start..start + content.len();
        (self.cx.text.get(place.clone()) == Some(content)).then_some(place)
    }
}

/// A number without a long tail of zeros.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-6..1e16).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

fn integer(integer: &toml::de::DeInteger<'_>) -> Option<i64> {
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

/// The word that is most like `word`, if any is near: at most a third of its letters, and one,
/// changed.
pub(crate) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let distance = |k: &str| strsim::damerau_levenshtein(&word.to_lowercase(), &k.to_lowercase());
    let best = known.map(|k| (distance(k), k)).min()?;
    (best.0 <= 1 + word.chars().count() / 3 && best.0 < best.1.len()).then_some(best.1)
}

/// What to say about a word that is none of the known ones.
pub(crate) fn suggest<'a>(word: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(word, known.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("known are {}", list(known)),
    }
}

fn list<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
}

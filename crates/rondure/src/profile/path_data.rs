//! A profile from SVG path data: `M L H V C S Q T A Z`, absolute and relative.
//!
//! The grammar is that of SVG 2, section 9.3, with one difference in meaning: the first coordinate
//! is r, the second is z and grows upwards. Nothing is dropped: what SVG viewers skip with a shrug
//! (a path cut short by an error) is an error here, with its place in the text.

use core::ops::Range;

use svgtypes::stream::Stream;

use super::{Point, Profile, ProfileBuilder, ProfileError, ProfileErrorKind};

impl Profile {
    /// Reads a profile from SVG path data, e.g. `M 0 -1 A 1 1 0 0 1 0 1`: the first coordinate of a
    /// point is r, the second is z, upwards.
    ///
    /// # Errors
    ///
    /// [`ProfileError`], with the bytes of the text at fault, if the text is no path data, or the
    /// profile would fail [`ProfileBuilder::build`].
    pub fn from_path_data(text: &str) -> Result<Self, ProfileError> {
        let mut parser = Parser {
            stream: Stream::from(text),
            text,
            builder: Self::builder(),
        };
        parser.path()?;
        parser.builder.build()
    }
}

struct Parser<'a> {
    stream: Stream<'a>,
    text: &'a str,
    builder: ProfileBuilder,
}

/// The control point that a following `S` or `T` reflects, by kind of curve.
#[derive(Clone, Copy)]
enum Smooth {
    None,
    Cubic(Point),
    Quadratic(Point),
}

impl Parser<'_> {
    fn path(&mut self) -> Result<(), ProfileError> {
        let mut smooth = Smooth::None;
        let mut first = true;
        self.stream.skip_spaces();
        while !self.stream.at_end() {
            let begin = self.stream.pos();
            let command = self.command(first)?;
            first = false;
            let mut kind = command;
            loop {
                let item = if kind == command {
                    begin
                } else {
                    self.stream.pos()
                };
                smooth = self.segment(kind, item, smooth)?;
                self.stream.skip_spaces();
                if kind.eq_ignore_ascii_case(&b'Z') || !self.another_item() {
                    break;
                }
                // Further pairs after a `moveto` are lines (SVG 2, 9.3.3).
                kind = match kind {
                    b'M' => b'L',
                    b'm' => b'l',
                    other => other,
                };
            }
        }
        Ok(())
    }

    fn command(&mut self, first: bool) -> Result<u8, ProfileError> {
        let begin = self.stream.pos();
        let rest = &self.text[begin..];
        let found = rest.chars().next().unwrap_or(' ');
        let span = begin..begin + found.len_utf8();
        if !"MmLlHhVvCcSsQqTtAaZz".contains(found) {
            let message = format!(
                "`{}` is no path command; the commands are M L H V C S Q T A Z",
                word(rest)
            );
            return Err(syntax(message, begin..begin + word(rest).len()));
        }
        if first && !found.eq_ignore_ascii_case(&'M') {
            return Err(syntax(
                format!("a path begins with M, not with `{found}`"),
                span,
            ));
        }
        self.stream.advance(1);
        self.stream.skip_spaces();
        Ok(found as u8)
    }

    /// Whether the next thing is a number, so that the command repeats.
    fn another_item(&self) -> bool {
        let next = self
            .stream
            .slice_tail()
            .trim_start_matches(|c: char| c == ',' || c.is_ascii_whitespace());
        next.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
    }

    fn segment(&mut self, kind: u8, begin: usize, smooth: Smooth) -> Result<Smooth, ProfileError> {
        let (at, start) = self.builder.position();
        let origin = if kind.is_ascii_lowercase() {
            at
        } else {
            Point::default()
        };
        let mut next_smooth = Smooth::None;
        let draw: Box<dyn FnOnce(ProfileBuilder) -> ProfileBuilder> =
            match kind.to_ascii_uppercase() {
                b'M' => {
                    let p = self.point(kind, origin)?;
                    Box::new(move |b| b.move_to(p.r, p.z))
                }
                b'L' => {
                    let p = self.point(kind, origin)?;
                    Box::new(move |b| b.line_to(p.r, p.z))
                }
                b'H' => {
                    let r = self.number(kind)? + origin.r;
                    Box::new(move |b| b.line_to(r, at.z))
                }
                b'V' => {
                    let z = self.number(kind)? + origin.z;
                    Box::new(move |b| b.line_to(at.r, z))
                }
                b'C' | b'S' => {
                    let c1 = match (kind.to_ascii_uppercase(), smooth) {
                        (b'C', _) => self.point(kind, origin)?,
                        (_, Smooth::Cubic(c)) => at + (at - c),
                        _ => at,
                    };
                    let c2 = self.point(kind, origin)?;
                    let p = self.point(kind, origin)?;
                    next_smooth = Smooth::Cubic(c2);
                    Box::new(move |b| b.cubic_to([c1.r, c1.z], [c2.r, c2.z], p.r, p.z))
                }
                b'Q' | b'T' => {
                    let c = match (kind.to_ascii_uppercase(), smooth) {
                        (b'Q', _) => self.point(kind, origin)?,
                        (_, Smooth::Quadratic(c)) => at + (at - c),
                        _ => at,
                    };
                    let p = self.point(kind, origin)?;
                    next_smooth = Smooth::Quadratic(c);
                    Box::new(move |b| b.quad_to([c.r, c.z], p.r, p.z))
                }
                b'A' => {
                    let radii = [self.number(kind)?, self.number(kind)?];
                    let rotation = self.number(kind)?.to_radians();
                    let (large, sweep) = (self.flag()?, self.flag()?);
                    let p = self.point(kind, origin)?;
                    Box::new(move |b| b.arc_to(radii, rotation, large, sweep, p.r, p.z))
                }
                _ => {
                    // A drawing that came back to its start by relative steps closes without a
                    // segment as long as rounding.
                    let _ = start;
                    Box::new(ProfileBuilder::close)
                }
            };
        let end = self.text[begin..self.stream.pos()].trim_end().len() + begin;
        self.builder.at(begin..end);
        self.builder = draw(core::mem::take(&mut self.builder));
        Ok(next_smooth)
    }

    fn point(&mut self, command: u8, origin: Point) -> Result<Point, ProfileError> {
        Ok(Point::new(
            self.number(command)? + origin.r,
            self.number(command)? + origin.z,
        ))
    }

    fn number(&mut self, command: u8) -> Result<f64, ProfileError> {
        self.stream.skip_spaces();
        let begin = self.stream.pos();
        self.stream.parse_list_number().map_err(|_| {
            let rest = &self.text[begin..];
            let found = word(rest);
            let command = command as char;
            let message = if found.is_empty() {
                format!("the path ends in the middle of `{command}`; a number is missing")
            } else if found.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
                format!("`{found}` is no finite number")
            } else {
                format!("expected a number for `{command}`, found `{found}`")
            };
            syntax(message, begin..begin + found.len().max(1).min(rest.len()))
        })
    }

    fn flag(&mut self) -> Result<bool, ProfileError> {
        self.stream.skip_spaces();
        let begin = self.stream.pos();
        let flag = match self.stream.slice_tail().as_bytes().first() {
            Some(b'0') => false,
            Some(b'1') => true,
            _ => {
                let found = word(&self.text[begin..]);
                let message = format!("an arc's flag is 0 or 1, not `{found}`");
                return Err(syntax(message, begin..begin + found.len()));
            }
        };
        self.stream.advance(1);
        self.stream.skip_spaces();
        if self.stream.slice_tail().starts_with(',') {
            self.stream.advance(1);
        }
        Ok(flag)
    }
}

/// What stands at the beginning of the text, up to the next space or comma: at most 24 characters.
fn word(text: &str) -> &str {
    let end = text
        .char_indices()
        .enumerate()
        .find(|(n, (_, c))| *n == 24 || c.is_whitespace() || *c == ',')
        .map_or(text.len(), |(_, (i, _))| i);
    &text[..end.max(text.chars().next().map_or(0, char::len_utf8))]
}

fn syntax(message: String, span: Range<usize>) -> ProfileError {
    ProfileError {
        kind: ProfileErrorKind::Syntax { message },
        segment: None,
        span: Some(span),
    }
}

//! A profile from SVG path data: `M L H V C S Q T A Z`, absolute and relative.
//!
//! The grammar is that of SVG 2, section 9.3, with one difference in meaning: the first coordinate
//! is r, the second is z and grows upwards. Nothing is dropped: what SVG viewers skip with a shrug
//! (a path cut short by an error) is an error here, with its place in the text.

use core::ops::Range;

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
        Self::builder().path_data(text)?.build()
    }
}

impl ProfileBuilder {
    /// Appends what SVG path data draws; see [`Profile::from_path_data`]. The points are checked
    /// when the profile is built, so that the path may lie anywhere until then.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] with the bytes at fault if the text is no path data.
    pub fn path_data(self, text: &str) -> Result<Self, ProfileError> {
        let mut parser = Parser { text, next: 0, comma: None, builder: self };
        parser.path()?;
        Ok(parser.builder)
    }
}

struct Parser<'a> {
    text: &'a str,
    /// The byte that comes next.
    next: usize,
    /// Where the comma stands that was read last, if nothing but spaces followed it.
    comma: Option<usize>,
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
        self.skip_spaces();
        while !self.rest().is_empty() {
            let begin = self.next;
            let command = self.command(first)?;
            first = false;
            let mut kind = command;
            loop {
                let item = if kind == command { begin } else { self.next };
                smooth = self.segment(kind, item, smooth)?;
                self.skip_spaces();
                if kind.eq_ignore_ascii_case(&b'Z') || !self.another_item() {
                    if let Some(comma) = self.comma.take() {
                        let message = "no number follows this comma".into();
                        return Err(syntax(message, comma..comma + 1));
                    }
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

    fn rest(&self) -> &str {
        &self.text[self.next..]
    }

    fn skip_spaces(&mut self) {
        let rest = self.rest();
        self.next += rest.len() - rest.trim_ascii_start().len();
    }

    /// The optional comma after a number or a flag.
    fn skip_comma(&mut self) {
        self.skip_spaces();
        self.comma = self.rest().starts_with(',').then_some(self.next);
        self.next += usize::from(self.comma.is_some());
    }

    fn command(&mut self, first: bool) -> Result<u8, ProfileError> {
        let begin = self.next;
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
            return Err(syntax(format!("a path begins with M, not with `{found}`"), span));
        }
        self.next += 1;
        self.skip_spaces();
        Ok(found as u8)
    }

    /// Whether the next thing is a number, so that the command repeats.
    fn another_item(&self) -> bool {
        self.rest().starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
    }

    fn segment(&mut self, kind: u8, begin: usize, smooth: Smooth) -> Result<Smooth, ProfileError> {
        let at = self.builder.position();
        let origin = if kind.is_ascii_lowercase() { at } else { Point::default() };
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
                _ => Box::new(ProfileBuilder::close),
            };
        let end = self.text[begin..self.next].trim_end().len() + begin;
        self.builder.at(begin..end);
        self.builder = draw(core::mem::take(&mut self.builder));
        Ok(next_smooth)
    }

    fn point(&mut self, command: u8, origin: Point) -> Result<Point, ProfileError> {
        Ok(Point::new(self.number(command)? + origin.r, self.number(command)? + origin.z))
    }

    fn number(&mut self, command: u8) -> Result<f64, ProfileError> {
        self.skip_spaces();
        let begin = self.next;
        let length = number_length(self.rest());
        if length == 0 {
            let found = word(self.rest());
            let command = command as char;
            if found.is_empty() {
                let message =
                    format!("the path ends in the middle of `{command}`; a number is missing");
                let end = self.text.trim_ascii_end().len();
                return Err(syntax(message, end..end));
            }
            let message = format!("expected a number for `{command}`, found `{found}`");
            return Err(syntax(message, begin..begin + found.len()));
        }
        self.next += length;
        let literal = &self.text[begin..self.next];
        match literal.parse() {
            Ok(number) if f64::is_finite(number) => {
                self.skip_comma();
                Ok(number)
            }
            _ => Err(syntax(format!("`{literal}` is not a finite number"), begin..self.next)),
        }
    }

    fn flag(&mut self) -> Result<bool, ProfileError> {
        self.skip_spaces();
        let begin = self.next;
        let flag = match self.rest().as_bytes().first() {
            Some(b'0') => false,
            Some(b'1') => true,
            _ => {
                let found = word(&self.text[begin..]);
                let message = format!("an arc's flag is 0 or 1, not `{found}`");
                return Err(syntax(message, begin..begin + found.len()));
            }
        };
        self.next += 1;
        self.skip_comma();
        Ok(flag)
    }
}

/// The length of the number at the beginning of the text, by the grammar of SVG (which allows `.5`,
/// `5.` and `1e3`, and ends a number where the next one begins: `1-2`, `.5.5`); 0 if there is none.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return 0;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits((end + 1 + sign).min(bytes.len()));
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    end
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
    ProfileError { kind: ProfileErrorKind::Syntax { message }, segment: None, span: Some(span) }
}

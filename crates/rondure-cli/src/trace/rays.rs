//! Rays from CSV text: the header, the rows, and what can be wrong with them.
//!
//! The format is the numeric core of RFC 4180: numbers separated by commas, one ray a line. A value
//! may have spaces or one pair of quotes round it. As no value can hold a comma or a line break, a
//! file can be cut at any line end and its parts read by themselves.

use std::ops::Range;

use rondure::{Ray, Vec3};

/// The columns that are known, in the order of a row's values; the first six must be there.
const NAMES: [&str; 8] = ["ox", "oy", "oz", "dx", "dy", "dz", "tmin", "tmax"];
const REQUIRED: usize = 6;
const T_MIN: usize = 6;
const T_MAX: usize = 7;

/// The shortest direction: the t of a point of any profile, which has coordinates up to 1e100, is
/// finite from an origin anywhere near.
const SHORTEST: f64 = 1e-200;

/// Which column holds what, as the header says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Columns {
    /// For each column of the file, its place in [`NAMES`].
    meaning: Vec<usize>,
}

/// The rays of some lines, up to the first that is wrong.
#[derive(Debug, Default)]
pub(crate) struct Parsed {
    /// The rays, in order.
    pub(crate) rays: Vec<Ray>,
    /// How many lines were read, with empty ones, and without the bad one.
    pub(crate) lines: usize,
    /// What is wrong with the next line.
    pub(crate) error: Option<LineError>,
}

/// What is wrong with a line.
#[derive(Debug, PartialEq)]
pub(crate) struct LineError {
    /// The line as text.
    pub(crate) text: String,
    /// The bytes of `text` at fault.
    pub(crate) span: Range<usize>,
    /// What is wrong.
    pub(crate) title: String,
    /// Which column it is about, or another short remark.
    pub(crate) label: String,
    /// What would be right.
    pub(crate) help: String,
}

impl Columns {
    /// Reads the header.
    pub(crate) fn from_header(line: &[u8]) -> Result<Self, LineError> {
        if line.starts_with(b"\xff\xfe") || line.starts_with(b"\xfe\xff") {
            let help = "save it as UTF-8, not as UTF-16";
            return Err(whole_line(line, "the file is not UTF-8 text", help));
        }
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        if line.trim_ascii().is_empty() {
            return Err(whole_line(line, "the first line is empty", &expected_header()));
        }
        let mut meaning = Vec::with_capacity(NAMES.len());
        for (column, (span, field)) in fields(line).enumerate() {
            let fail = |title: String, help: String| {
                let label = format!("column {}", column + 1);
                Err(LineError::new(line, span.clone(), title, label, help))
            };
            let Ok(name) = str::from_utf8(field) else {
                return fail("the header is not UTF-8 text".into(), expected_header());
            };
            let Some(i) = NAMES.iter().position(|known| *known == name) else {
                return fail(format!("unknown column `{}`", shown(name)), advice(name, line));
            };
            if meaning.contains(&i) {
                let help = "name every column once".into();
                return fail(format!("the column `{name}` is there twice"), help);
            }
            meaning.push(i);
        }
        let missing: Vec<_> = (0..REQUIRED).filter(|i| !meaning.contains(i)).collect();
        if !missing.is_empty() {
            let list: Vec<_> = missing.iter().map(|&i| format!("`{}`", NAMES[i])).collect();
            let s = if list.len() == 1 { "" } else { "s" };
            let title = format!("the header lacks the column{s} {}", list.join(", "));
            return Err(whole_line(line, &title, &expected_header()));
        }
        Ok(Self { meaning })
    }

    /// Reads the rays of a block of whole lines. Lines with nothing but spaces are no rays.
    pub(crate) fn parse(&self, block: &[u8]) -> Parsed {
        let mut parsed = Parsed::default();
        parsed.rays.reserve(block.len() / 64);
        let block = block.strip_suffix(b"\n").unwrap_or(block);
        for line in block.split(|&b| b == b'\n') {
            if !line.trim_ascii().is_empty() {
                match self.ray(line) {
                    Ok(ray) => parsed.rays.push(ray),
                    Err(error) => {
                        parsed.error = Some(error);
                        break;
                    }
                }
            }
            parsed.lines += 1;
        }
        parsed
    }

    fn ray(&self, line: &[u8]) -> Result<Ray, LineError> {
        let mut v = [0.0; NAMES.len()];
        v[T_MAX] = f64::INFINITY;
        let mut found = 0;
        for (span, field) in fields(line) {
            if let Some(&i) = self.meaning.get(found) {
                v[i] = number(field, i >= T_MIN).map_err(|(title, help)| {
                    let label = format!("column `{}`", NAMES[i]);
                    LineError::new(line, span, title, label, help)
                })?;
            }
            found += 1;
        }
        let columns = self.meaning.len();
        if found != columns {
            let s = if found == 1 { "" } else { "s" };
            let title =
                format!("this row has {found} value{s}, but the header has {columns} columns");
            return Err(whole_line(line, &title, &self.row()));
        }
        let ray = Ray {
            origin: Vec3::new(v[0], v[1], v[2]),
            direction: Vec3::new(v[3], v[4], v[5]),
            t_min: v[T_MIN],
            t_max: v[T_MAX],
        };
        if ray.direction == Vec3::ZERO {
            let title = "the direction is zero";
            return Err(whole_line(line, title, "one of dx, dy and dz must not be 0"));
        }
        if ray.direction.max_abs() < SHORTEST {
            let title = format!("the direction is shorter than {SHORTEST:e}");
            let help = "t is in units of the direction, and would be too large a number";
            return Err(whole_line(line, &title, help));
        }
        if ray.t_min > ray.t_max {
            let title = format!("tmin = {} is larger than tmax = {}", ray.t_min, ray.t_max);
            let help = "a ray runs from tmin up to tmax; without these columns from 0 to infinity";
            return Err(whole_line(line, &title, help));
        }
        Ok(ray)
    }

    /// What a row should look like.
    fn row(&self) -> String {
        let names: Vec<_> = self.meaning.iter().map(|&i| NAMES[i]).collect();
        format!("a row must have the values of {}", names.join(","))
    }
}

impl LineError {
    fn new(line: &[u8], span: Range<usize>, title: String, label: String, help: String) -> Self {
        /// Enough for any row of numbers; of a line that is something else, the part at fault.
        const LONGEST: usize = 80;
        let line = line.trim_ascii_end();
        let (start, end) = if line.len() <= LONGEST {
            (0, line.len())
        } else {
            let start = span.start.saturating_sub(LONGEST / 4);
            (start, line.len().min(start + LONGEST))
        };
        let visible = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            text.replace(|c: char| c.is_control(), "\u{fffd}")
        };
        let at = |i: usize| i.clamp(start, end);
        let before = visible(&line[start..at(span.start)]);
        let fault = visible(&line[at(span.start)..at(span.end)]);
        let after = visible(&line[at(span.end)..end]);
        let span = before.len()..before.len() + fault.len();
        Self { text: before + &fault + &after, span, title, label, help }
    }
}

fn whole_line(line: &[u8], title: &str, help: &str) -> LineError {
    let end = line.trim_ascii_end().len();
    LineError::new(line, 0..end, title.into(), String::new(), help.into())
}

fn expected_header() -> String {
    "the first line must name the columns: ox,oy,oz,dx,dy,dz, in any order, and tmin and tmax if \
     wanted"
        .into()
}

/// What to do about a column name that is not known.
fn advice(name: &str, line: &[u8]) -> String {
    if name.parse::<f64>().is_ok() {
        return expected_header();
    }
    if !line.contains(&b',') && line.iter().any(|b| b";\t ".contains(b)) {
        return "separate the columns by commas".into();
    }
    let near = NAMES
        .iter()
        .map(|known| (strsim::damerau_levenshtein(&name.to_lowercase(), known), known))
        .min();
    match near {
        Some((0 | 1, known)) => format!("did you mean `{known}`?"),
        _ => "the columns are ox,oy,oz,dx,dy,dz and, if wanted, tmin and tmax; take others out"
            .into(),
    }
}

/// The values of a line, without spaces and quotes round them, each with the bytes it stands at.
fn fields(line: &[u8]) -> impl Iterator<Item = (Range<usize>, &[u8])> {
    let mut next = 0;
    line.split(|&b| b == b',').map(move |field| {
        let start = next + (field.len() - field.trim_ascii_start().len());
        next += field.len() + 1;
        let field = field.trim_ascii();
        let span = start..start + field.len();
        match field {
            [b'"', inner @ .., b'"'] => (span, inner.trim_ascii()),
            _ => (span, field),
        }
    })
}

/// A number; an infinite one only where it `may_be_infinite`. On failure what is wrong, and what
/// would be right.
fn number(field: &[u8], may_be_infinite: bool) -> Result<f64, (String, String)> {
    let right = if may_be_infinite {
        "a number is expected, like 0.25, 1e-3, inf or -inf"
    } else {
        "a finite number is expected, like 0.25 or -1e-3"
    };
    let fail = |title: String| Err((title, right.into()));
    let Ok(text) = str::from_utf8(field) else {
        return fail("this value is not UTF-8 text".into());
    };
    if text.is_empty() {
        return fail("a value is missing".into());
    }
    let Ok(value) = text.parse::<f64>() else {
        return fail(format!("`{}` is not a number", shown(text)));
    };
    if value.is_nan() {
        return fail("this value must not be NaN".into());
    }
    if value.is_infinite() {
        if text.contains(|c: char| c.is_ascii_digit()) {
            return fail(format!("`{}` is beyond the largest number, 1.8e308", shown(text)));
        }
        if !may_be_infinite {
            return fail("this value must not be infinite".into());
        }
    }
    Ok(value)
}

/// The beginning of a text that may be long.
fn shown(text: &str) -> String {
    const LONGEST: usize = 40;
    let visible = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut shown: String = text.chars().take(LONGEST).map(visible).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_may_have_spaces_and_quotes() {
        let line = b" \"ox\" ,1.5,\t-2 ";
        let found: Vec<_> = fields(line).collect();
        assert_eq!(found, [(1..5, &b"ox"[..]), (7..10, &b"1.5"[..]), (12..14, &b"-2"[..])]);
    }

    #[test]
    fn blocks_count_their_lines() {
        let columns = Columns::from_header(b"ox,oy,oz,dx,dy,dz\r").unwrap();
        let parsed = columns.parse(b"0,0,1,0,0,1\r\n\n \r\n0,0,2,0,0,1\n1,2\n0,0,3,0,0,1");
        assert_eq!(parsed.rays.iter().map(|r| r.origin.z).collect::<Vec<_>>(), [1.0, 2.0]);
        assert_eq!(parsed.lines, 4);
        assert_eq!(parsed.error.unwrap().text, "1,2");
    }

    #[test]
    fn the_fault_in_a_long_line_is_shown() {
        let mut line = vec![b'0'; 10_000];
        line.extend(b",x\xff,");
        line.extend([b'1'; 10_000]);
        let error =
            LineError::new(&line, 10_001..10_003, String::new(), String::new(), String::new());
        assert_eq!(&error.text[error.span.clone()], "x\u{fffd}");
        assert!(error.text.len() < 300);
    }
}

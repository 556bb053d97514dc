//! Points in a CSV file: a line r,z for each, with or without a header, `#` comments.

use std::ops::Range;

use rondure::{Point, Profile, ProfileErrorKind, Spline};

use super::explain;
use crate::Diagnostic;

/// A point and the bytes that it stands in.
pub(crate) struct Row {
    pub(crate) point: Point,
    pub(crate) span: Range<usize>,
}

pub(super) fn parse(text: &str, spline: Spline, scale: f64) -> Result<Profile, Vec<Diagnostic>> {
    through(&read(text)?, spline, scale).map_err(|e| vec![e])
}

/// The profile through the points of the rows, times `scale`.
pub(crate) fn through(rows: &[Row], spline: Spline, scale: f64) -> Result<Profile, Diagnostic> {
    let points: Vec<_> = rows.iter().map(|row| row.point * scale).collect();
    Profile::through_points(&points, spline).map_err(|e| {
        let (diagnostic, label) = explain(&e);
        let Some(segment) = e.segment else { return diagnostic };
        let [from, to] = segment_rows(rows, segment);
        let crosses = matches!(e.kind, ProfileErrorKind::NegativeRadius { .. });
        match [from, to].into_iter().find(|row| row.point.r < 0.0) {
            Some(row) if crosses => diagnostic.at(row.span.clone(), label),
            _ => {
                let diagnostic = diagnostic.at(from.span.start..to.span.end, label);
                if !crosses {
                    return diagnostic;
                }
                diagnostic.help(
                    "the points are at r >= 0, but the smooth curve between them swings beyond the \
                     axis; give a point twice to make a corner there, or add points",
                )
            }
        }
    })
}

/// The rows between which a segment runs; see [`Profile::through_points`].
fn segment_rows(rows: &[Row], segment: usize) -> [&Row; 2] {
    let mut steps = rows.windows(2).filter(|pair| pair[0].point != pair[1].point);
    match steps.nth(segment) {
        Some([from, to]) => [from, to],
        _ => [&rows[0], &rows[rows.len() - 1]],
    }
}

fn read(text: &str) -> Result<Vec<Row>, Vec<Diagnostic>> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut rows = Vec::new();
    let mut errors = Vec::new();
    // Which column is r and which is z.
    let mut columns = [0, 1];
    let mut first = true;
    let mut record = csv::StringRecord::new();
    loop {
        match reader.read_record(&mut record) {
            Ok(false) => break,
            Ok(true) => {}
            Err(e) => {
                errors.push(Diagnostic::error(format!("not a CSV file: {e}")));
                break;
            }
        }
        let begin = record.position().map_or(0, |p| p.byte() as usize);
        let span = line_at(text, begin, reader.position().byte() as usize);
        let fields = Fields { text, span: span.clone(), record: &record };
        let is_first = std::mem::take(&mut first);
        if is_first && record.iter().all(|f| f.parse::<f64>().is_err()) {
            match header(&fields) {
                Ok(found) => columns = found,
                Err(e) => errors.push(e),
            }
            continue;
        }
        match point(&fields, columns) {
            Ok(point) => rows.push(Row { point, span }),
            Err(found) => errors.extend(found),
        }
    }
    if errors.is_empty() && rows.is_empty() {
        errors.push(Diagnostic::error("there are no points").help("write a line `r,z` for each"));
    }
    if errors.is_empty() { Ok(rows) } else { Err(errors) }
}

/// The first line at or after `begin` that is neither empty nor a comment, without its line break:
/// a record's position may lie before what was skipped on the way to it.
fn line_at(text: &str, mut begin: usize, end: usize) -> Range<usize> {
    let end = end.min(text.len());
    while begin < end {
        let rest = &text[begin..end];
        let line = rest.find('\n').map_or(rest, |n| &rest[..n]);
        if !line.trim().is_empty() && !line.starts_with('#') {
            break;
        }
        begin += line.len() + 1;
    }
    let begin = begin.min(end);
    let trimmed = text[begin..end].trim_end();
    begin..begin + trimmed.len()
}

struct Fields<'a> {
    text: &'a str,
    span: Range<usize>,
    record: &'a csv::StringRecord,
}

impl Fields<'_> {
    /// The bytes of a field; of the whole line if quotes hide it.
    fn span(&self, column: usize) -> Range<usize> {
        let line = &self.text[self.span.clone()];
        let pieces: Vec<_> = line.split(',').collect();
        if pieces.len() != self.record.len() || line.contains('"') {
            return self.span.clone();
        }
        let before: usize = pieces[..column].iter().map(|p| p.len() + 1).sum();
        let piece = pieces[column];
        let start = self.span.start + before + (piece.len() - piece.trim_start().len());
        start..start + piece.trim().len()
    }
}

fn header(fields: &Fields<'_>) -> Result<[usize; 2], Diagnostic> {
    let find = |name: &str| fields.record.iter().position(|f| f.eq_ignore_ascii_case(name));
    match (find("r"), find("z"), fields.record.len()) {
        (Some(r), Some(z), 2) => Ok([r, z]),
        _ => Err(Diagnostic::error("the header does not name the two columns r and z")
            .at(fields.span.clone(), "")
            .help("the header is `r,z` or `z,r`; a file without a header has r first")),
    }
}

fn point(fields: &Fields<'_>, columns: [usize; 2]) -> Result<Point, Vec<Diagnostic>> {
    let count = fields.record.len();
    if count != 2 {
        let columns = if count == 1 { "column" } else { "columns" };
        let line = &fields.text[fields.span.clone()];
        let mut error = Diagnostic::error(format!("expected two columns, r and z; found {count}"))
            .at(fields.span.clone(), format!("{count} {columns}"));
        if count == 1 && line.contains([';', '\t', ' ']) {
            error = error.help("columns are separated by a comma, and decimals by a point");
        }
        return Err(vec![error]);
    }
    let mut errors = Vec::new();
    let mut number = |axis: usize| {
        let column = columns[axis];
        let field = &fields.record[column];
        let name = ["r", "z"][axis];
        let place =
            |e: Diagnostic| e.at(fields.span(column), format!("column {}, {name}", column + 1));
        match field.parse::<f64>() {
            Ok(x) if x.is_finite() => return x,
            Ok(_) => {
                errors.push(place(Diagnostic::error(format!("`{field}` is not a finite number"))));
            }
            Err(_) if field.is_empty() => {
                errors.push(place(Diagnostic::error(format!("the value of {name} is missing"))));
            }
            Err(_) => errors.push(place(Diagnostic::error(format!("`{field}` is not a number")))),
        }
        f64::NAN
    };
    let point = Point::new(number(0), number(1));
    if errors.is_empty() { Ok(point) } else { Err(errors) }
}

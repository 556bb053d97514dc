//! Profile files: path data, drawings and tables of points, told apart by their extension.

pub(crate) mod liquid;
pub(crate) mod path;
pub(crate) mod points;
mod svg;
mod unit;
pub(crate) mod wall;

use std::{ops::Range, path::Path};

use rondure::{Profile, ProfileError, ProfileErrorKind, Spline, profile::Thickness};

use crate::{Diagnostic, Report, file::read_text};

pub use unit::Unit;

/// What a profile file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileFormat {
    /// SVG path data alone, the first coordinate r, the second z, upwards; lines may end in a `#`
    /// comment.
    PathData,
    /// An SVG drawing, of which one shape is the profile.
    Svg,
    /// Comma-separated values: a point (r, z) a line.
    Csv,
}

impl ProfileFormat {
    /// By the file's extension: `.path` or `.txt`, `.svg`, `.csv`.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "path" | "txt" => Some(Self::PathData),
            "svg" => Some(Self::Svg),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

/// How a profile is taken from its file. An option that has no meaning for the file's format is an
/// error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProfileOptions {
    /// SVG: the id of the shape; needed if there are several.
    pub id: Option<String>,
    /// SVG: the x of the axis in user units of the document; 0 if not given.
    pub axis: Option<f64>,
    /// SVG: the y that becomes z = 0, in user units of the document. If not given, the bottom of the
    /// page; if the document has no size, y = 0.
    pub base: Option<f64>,
    /// SVG: the distance, in user units of the document, within which points are put on the axis. If
    /// not given, no more than rounding can have moved them.
    pub snap: Option<f64>,
    /// SVG: the unit in which the profile is measured, by the document's width; user units if not
    /// given.
    pub unit: Option<Unit>,
    /// A factor on r and z, after everything else; 1 if not given.
    pub scale: Option<f64>,
    /// CSV: how the curve runs through the points; a polyline if not given.
    pub spline: Option<Spline>,
    /// The wall along the curve, if it has one; measured after `scale`.
    pub thickness: Option<Thickness>,
}

/// Reads a profile file; what it is is told by its extension.
///
/// # Errors
///
/// A [`Report`] of everything that is wrong: the file cannot be read, is larger than
/// [`LARGEST_FILE`](crate::LARGEST_FILE), is not UTF-8 or not of its format, or the profile fails
/// its checks.
pub fn read_profile(path: &Path, options: &ProfileOptions) -> Result<Profile, Report> {
    let name = path.display().to_string();
    let Some(format) = ProfileFormat::from_path(path) else {
        let message = match path.extension() {
            Some(e) => format!("`{name}`: `.{}` is no kind of profile file", e.display()),
            None => format!("`{name}` has no extension to tell what kind of profile file it is"),
        };
        let help = "profiles are .path or .txt (path data), .svg (a drawing), or .csv (points)";
        return Err(Report::only(Diagnostic::error(message).help(help)));
    };
    parse_profile(&name, &read_text(path)?, format, options)
}

/// Takes a profile from text in memory; `name` stands in messages where the path would.
///
/// # Errors
///
/// As for [`read_profile`].
pub fn parse_profile(
    name: &str,
    text: &str,
    format: ProfileFormat,
    options: &ProfileOptions,
) -> Result<Profile, Report> {
    let mut report = Report::new(name, text);
    check_options(format, options, &mut report);
    if !report.is_empty() {
        return Err(report);
    }
    let scale = options.scale.unwrap_or(1.0);
    let result = if text.trim().is_empty() {
        Err(vec![Diagnostic::error("the file is empty").help(match format {
            ProfileFormat::PathData => "path data looks like `M 0 0 L 1 0 L 1 2`",
            ProfileFormat::Svg => "an SVG file with a path is expected",
            ProfileFormat::Csv => "a line `r,z` for each point is expected",
        })])
    } else {
        match format {
            ProfileFormat::PathData => path::parse(text, scale).map_err(|e| vec![e]),
            ProfileFormat::Svg => svg::parse(text, options, scale).map_err(|e| vec![e]),
            ProfileFormat::Csv => {
                points::parse(text, options.spline.unwrap_or(Spline::Polyline), scale)
            }
        }
    };
    let result = result.and_then(|profile| match &options.thickness {
        Some(wall) => wall::thicken(&profile, wall).map_err(|e| vec![e]),
        None => Ok(profile),
    });
    result.map_err(|diagnostics| {
        diagnostics.into_iter().for_each(|d| report.push(d));
        report
    })
}

fn check_options(format: ProfileFormat, options: &ProfileOptions, report: &mut Report) {
    let svg = format == ProfileFormat::Svg;
    for (given, name) in [
        (options.id.is_some(), "id"),
        (options.axis.is_some(), "axis"),
        (options.base.is_some(), "base"),
        (options.snap.is_some(), "snap"),
        (options.unit.is_some(), "unit"),
    ] {
        if given && !svg {
            report.push(Diagnostic::error(format!("`{name}` is for SVG files only")));
        }
    }
    if options.spline.is_some() && format != ProfileFormat::Csv {
        report.push(Diagnostic::error("`spline` is for points only"));
    }
    for (value, name, least) in [
        (options.axis, "axis", f64::NEG_INFINITY),
        (options.base, "base", f64::NEG_INFINITY),
        (options.snap, "snap", 0.0),
        (options.scale, "scale", f64::MIN_POSITIVE),
    ] {
        if value.is_some_and(|v| !v.is_finite() || v < least) {
            let kind = match name {
                "scale" => "positive",
                "snap" => "finite and not negative",
                _ => "finite",
            };
            report.push(Diagnostic::error(format!("`{name}` must be {kind}")));
        }
    }
}

/// A profile's error, with its place in the text that `locate` finds for bytes of the path data.
pub(crate) fn diagnose(
    error: &ProfileError,
    locate: impl Fn(Range<usize>) -> Range<usize>,
) -> Diagnostic {
    let (diagnostic, label) = explain(error);
    match error.span.clone() {
        Some(span) => diagnostic.at(locate(span), label),
        None => diagnostic,
    }
}

/// A profile's error without its place, and the words to put there.
pub(crate) fn explain(error: &ProfileError) -> (Diagnostic, String) {
    let plain = ProfileError { segment: None, ..error.clone() }.to_string();
    let segment = error.segment.map_or_else(String::new, |i| format!("segment {i}: "));
    match &error.kind {
        ProfileErrorKind::NegativeRadius { point, s } => (
            Diagnostic::error("the profile crosses the axis")
                .help("r must not be negative: a profile is the half of the outline at r >= 0"),
            format!("{segment}it reaches r = {} at z = {} (s = {s})", point.r, point.z),
        ),
        ProfileErrorKind::Syntax { .. } => (Diagnostic::error(plain), String::new()),
        _ => (Diagnostic::error(plain), segment.trim_end_matches(": ").into()),
    }
}

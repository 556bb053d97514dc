//! Path data in a file of its own: SVG's syntax, (r, z) with z upwards, and `#` comments.

use rondure::{
    Profile,
    profile::{PlaneMap, ProfileBuilder},
};

use super::diagnose;
use crate::Diagnostic;

pub(crate) fn parse(text: &str, scale: f64) -> Result<Profile, Diagnostic> {
    let text = blank_comments(text);
    let scaled = |b: ProfileBuilder| match scale {
        1.0 => b,
        _ => b.map(&PlaneMap::scale(scale, scale)),
    };
    let builder = Profile::builder().path_data(&text).map(scaled);
    builder.and_then(ProfileBuilder::build).map_err(|e| diagnose(&e, |span| span))
}

/// The text with every comment, from `#` to the end of its line, replaced by as many spaces as it
/// has bytes: all else stays in its place.
fn blank_comments(text: &str) -> String {
    let mut blank = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let end = line.trim_end_matches(['\n', '\r']).len();
        let comment = line[..end].find('#').unwrap_or(end);
        blank.push_str(&line[..comment]);
        blank.extend(std::iter::repeat_n(' ', end - comment));
        blank.push_str(&line[end..]);
    }
    blank
}

//! The outlines of SVG's shapes (SVG 2, chapters 9 and 10), in their own coordinates.

use rondure::{Profile, ProfileError, profile::ProfileBuilder};
use roxmltree::{Attribute, Node};
use svgtypes::{Length, NumberListParser};

use super::{length_in_px, tag};
use crate::Diagnostic;

/// The elements that have an outline.
pub(super) const NAMES: [&str; 7] =
    ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon"];

/// What an element draws, or what is wrong with its path data; and the attribute that the path data
/// stands in.
type Outline<'a, 'i> = (Option<Attribute<'a, 'i>>, Result<ProfileBuilder, ProfileError>);

pub(super) fn outline<'a, 'i>(node: Node<'a, 'i>) -> Result<Outline<'a, 'i>, Diagnostic> {
    let builder = match node.tag_name().name() {
        "path" => {
            let Some(data) = node.attribute_node("d") else {
                return Err(Diagnostic::error("the path has no path data")
                    .at(tag(node), "the attribute `d` is missing"));
            };
            return Ok((Some(data), Profile::builder().path_data(data.value())));
        }
        "rect" => rectangle(node)?,
        "circle" => {
            let r = required(node, "r")?;
            ellipse(length(node, "cx")?, length(node, "cy")?, r, r)
        }
        "ellipse" => {
            let (x, y) = (required(node, "rx")?, required(node, "ry")?);
            ellipse(length(node, "cx")?, length(node, "cy")?, x, y)
        }
        "line" => Profile::builder()
            .move_to(length(node, "x1")?, length(node, "y1")?)
            .line_to(length(node, "x2")?, length(node, "y2")?),
        "polyline" => polyline(node)?,
        _ => polyline(node)?.close(),
    };
    Ok((None, Ok(builder)))
}

/// From the rightmost point, by quarters: so that a circle that touches the axis does it in an end.
fn ellipse(x: f64, y: f64, rx: f64, ry: f64) -> ProfileBuilder {
    let quarter = |b: ProfileBuilder, x, y| b.arc_to([rx, ry], 0.0, false, true, x, y);
    [(x, y + ry), (x - rx, y), (x, y - ry), (x + rx, y)]
        .into_iter()
        .fold(Profile::builder().move_to(x + rx, y), |b, (x, y)| quarter(b, x, y))
        .close()
}

fn rectangle(node: Node<'_, '_>) -> Result<ProfileBuilder, Diagnostic> {
    let (x, y) = (length(node, "x")?, length(node, "y")?);
    let (w, h) = (required(node, "width")?, required(node, "height")?);
    let given = |name| match node.attribute(name) {
        None | Some("auto") => Ok(None),
        Some(_) => length(node, name).map(Some),
    };
    let (rx, ry) = (given("rx")?, given("ry")?);
    let corner = [rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0)];
    for (name, radius) in [("rx", rx), ("ry", ry)] {
        if radius.is_some_and(|r| r < 0.0) {
            return Err(negative(node, name));
        }
    }
    let [rx, ry] = [corner[0].min(w / 2.0), corner[1].min(h / 2.0)];
    if rx == 0.0 || ry == 0.0 {
        return Ok(Profile::builder()
            .move_to(x, y)
            .line_to(x + w, y)
            .line_to(x + w, y + h)
            .line_to(x, y + h)
            .close());
    }
    let round = |b: ProfileBuilder, x, y| b.arc_to([rx, ry], 0.0, false, true, x, y);
    let mut b = Profile::builder().move_to(x + rx, y).line_to(x + w - rx, y);
    b = round(b, x + w, y + ry).line_to(x + w, y + h - ry);
    b = round(b, x + w - rx, y + h).line_to(x + rx, y + h);
    b = round(b, x, y + h - ry).line_to(x, y + ry);
    Ok(round(b, x + rx, y).close())
}

fn polyline(node: Node<'_, '_>) -> Result<ProfileBuilder, Diagnostic> {
    let Some(attribute) = node.attribute_node("points") else {
        let name = node.tag_name().name();
        return Err(Diagnostic::error(format!("the {name} has no points"))
            .at(tag(node), "the attribute `points` is missing"));
    };
    let fail = |message: String| Diagnostic::error(message).at(attribute.range_value(), "");
    let numbers = NumberListParser::from(attribute.value())
        .collect::<Result<Vec<_>, _>>()
        .map_err(|e| fail(format!("the points cannot be read: {e}")))?;
    if numbers.len() % 2 == 1 {
        return Err(fail(format!("{} coordinates do not make points", numbers.len())));
    }
    let mut builder = Profile::builder();
    for (i, point) in numbers.chunks_exact(2).enumerate() {
        builder = if i == 0 {
            builder.move_to(point[0], point[1])
        } else {
            builder.line_to(point[0], point[1])
        };
    }
    Ok(builder)
}

/// A length in user units; 0 if the attribute is missing.
fn length(node: Node<'_, '_>, name: &str) -> Result<f64, Diagnostic> {
    let Some(attribute) = node.attribute_node(name) else { return Ok(0.0) };
    let parsed = attribute.value().trim().parse::<Length>().ok();
    parsed.and_then(length_in_px).filter(|x| x.is_finite()).ok_or_else(|| {
        Diagnostic::error(format!("the length `{name}` cannot be read"))
            .at(attribute.range_value(), "")
            .help("it is a number, with or without one of the units px, pt, pc, mm, cm, in")
    })
}

/// A length that must be positive.
fn required(node: Node<'_, '_>, name: &str) -> Result<f64, Diagnostic> {
    match length(node, name)? {
        x if x > 0.0 => Ok(x),
        x if x < 0.0 => Err(negative(node, name)),
        _ => {
            let shape = node.tag_name().name();
            let message = format!("the <{shape}> has no size: `{name}` is missing or zero");
            Err(Diagnostic::error(message).at(tag(node), ""))
        }
    }
}

fn negative(node: Node<'_, '_>, name: &str) -> Diagnostic {
    let span = node.attribute_node(name).map_or_else(|| tag(node), |a| a.range_value());
    Diagnostic::error(format!("`{name}` must not be negative")).at(span, "")
}

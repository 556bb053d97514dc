//! A profile in an SVG drawing, as Inkscape writes it.
//!
//! One shape of the drawing is taken, by its id or because there is only one. Its points are
//! brought into user units of the document (those of the outermost `viewBox`) through the
//! `transform`s of the shape and all its groups, then
//!
//! ```text
//! r = (x - axis) k,   z = (base - y) k
//! ```
//!
//! so that z points up, as y does not. Lines, Bézier curves and arcs stay what they are.

mod shape;

use std::ops::Range;

use rondure::{
    Profile, ProfileErrorKind,
    profile::{PlaneMap, ProfileBuilder},
};
use roxmltree::{Attribute, Document, Node, ParsingOptions};
use svgtypes::{Length, LengthUnit, TransformListParser, TransformListToken, ViewBox};

use super::{ProfileOptions, Unit, diagnose, explain};
use crate::Diagnostic;

const SVG: &str = "http://www.w3.org/2000/svg";

/// What may be nested in a document; Inkscape writes a few thousand elements.
const MOST_NODES: u32 = 4_000_000;

pub(super) fn parse(
    text: &str,
    options: &ProfileOptions,
    scale: f64,
) -> Result<Profile, Diagnostic> {
    let limits = ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..Default::default() };
    let document = Document::parse_with_options(text, limits).map_err(|e| malformed(text, &e))?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        let found = root.tag_name().name();
        let message = format!("this is not an SVG drawing: its root is <{found}>, not <svg>");
        return Err(Diagnostic::error(message).at(tag(root), ""));
    }
    let element = choose(root, options.id.as_deref())?;
    let page = Page::read(root)?;
    let axis = options.axis.unwrap_or(0.0);
    let base = options.base.or(page.bottom).unwrap_or(0.0);
    let factor = match options.unit {
        Some(unit) => page.px_per_user_unit(root)? / unit.in_px(),
        None => 1.0,
    };
    let upright = PlaneMap::scale(factor, -factor).after(&PlaneMap::translate(-axis, -base));
    let to_document = transforms(element)?;
    let map = PlaneMap::scale(scale, scale).after(&upright.after(&to_document));
    let snap = options.snap.unwrap_or(0.0) * factor * scale;
    let (data, builder) = shape::outline(element)?;
    let whole = data.as_ref().map_or_else(|| tag(element), |a| a.range_value());
    let locate = |span| data.as_ref().map_or(whole.clone(), |a| inside(text, a, span));
    let placed = builder.map(|builder| place(builder, &map, snap));
    placed.and_then(ProfileBuilder::build).map_err(|error| {
        let diagnostic = match diagnose(&error, locate) {
            d if d.labels.is_empty() => d.at(whole.clone(), explain(&error).1),
            d => d,
        };
        if matches!(error.kind, ProfileErrorKind::NegativeRadius { .. }) {
            diagnostic.help(format!(
                "the axis is at x = {axis} of the document, and the profile is the half of the \
                 outline to the right of it; `axis` puts the axis elsewhere, `snap` puts points \
                 that are within a distance of it on it"
            ))
        } else {
            diagnostic
        }
    })
}

fn place(builder: ProfileBuilder, map: &PlaneMap, snap: f64) -> ProfileBuilder {
    let reach = builder.map_rounding(map).max(snap);
    builder.map(map).snap_to_axis(reach)
}

fn malformed(text: &str, error: &roxmltree::Error) -> Diagnostic {
    let at = error.pos();
    let message = error.to_string();
    // The position stands in the margin.
    let message = message.split(" at ").next().unwrap_or(&message);
    let message = format!("the file is not well-formed XML: {message}");
    let line = text.split_inclusive('\n').nth(at.row.saturating_sub(1) as usize);
    let Some(line) = line else { return Diagnostic::error(message) };
    let start = line.as_ptr() as usize - text.as_ptr() as usize;
    let column = line.char_indices().nth(at.col.saturating_sub(1) as usize);
    let offset = column.map_or(line.trim_end().len(), |(i, _)| i);
    let width = column.map_or(0, |(_, c)| if c.is_whitespace() { 0 } else { c.len_utf8() });
    Diagnostic::error(message).at(start + offset..start + offset + width, "")
}

/// The element's name in its start tag.
fn tag(node: Node<'_, '_>) -> Range<usize> {
    let start = node.range().start;
    let text = node.document().input_text();
    let name = text[start..].find(|c: char| c.is_whitespace() || matches!(c, '>' | '/'));
    start..start + name.unwrap_or(text.len() - start)
}

/// The bytes of a stretch of an attribute's value; the whole value if references hide the place.
fn inside(text: &str, attribute: &Attribute<'_, '_>, span: Range<usize>) -> Range<usize> {
    let whole = attribute.range_value();
    if text.get(whole.clone()) == Some(attribute.value()) {
        whole.start + span.start..whole.start + span.end
    } else {
        whole
    }
}

fn is_svg(node: Node<'_, '_>) -> bool {
    node.is_element() && matches!(node.tag_name().namespace(), None | Some(SVG))
}

fn is_shape(node: Node<'_, '_>) -> bool {
    is_svg(node) && shape::NAMES.contains(&node.tag_name().name())
}

/// Whether an element is only drawn where something refers to it.
fn is_definition(node: Node<'_, '_>) -> bool {
    const NAMES: [&str; 6] = ["defs", "clipPath", "mask", "symbol", "marker", "pattern"];
    NAMES.contains(&node.tag_name().name())
}

fn choose<'a, 'i>(root: Node<'a, 'i>, id: Option<&str>) -> Result<Node<'a, 'i>, Diagnostic> {
    let shapes = || {
        root.descendants().filter(|n| is_shape(*n)).filter(|n| !n.ancestors().any(is_definition))
    };
    let ids = || {
        let ids: Vec<_> = shapes().map(|n| n.attribute("id").unwrap_or("(no id)")).collect();
        let (shown, more) = ids.split_at(ids.len().min(20));
        let more =
            if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
        if ids.is_empty() {
            "the drawing has no shapes".to_owned()
        } else {
            format!("the drawing's shapes are: {}{more}", shown.join(", "))
        }
    };
    let Some(id) = id else {
        let mut all = shapes();
        return match (all.next(), all.next()) {
            (Some(only), None) => Ok(only),
            (None, _) => Err(Diagnostic::error("the drawing has no path").at(tag(root), "").help(
                "texts and images have no outline; Inkscape's Path > Object to Path makes one",
            )),
            _ => Err(Diagnostic::error("the drawing has several shapes; choose one by its `id`")
                .help(ids())),
        };
    };
    let mut found = root.descendants().filter(|n| n.is_element() && n.attribute("id") == Some(id));
    let Some(element) = found.next() else {
        return Err(Diagnostic::error(format!("no element has the id `{id}`")).help(ids()));
    };
    if let Some(second) = found.next() {
        return Err(Diagnostic::error(format!("two elements have the id `{id}`"))
            .at(tag(element), "")
            .and_at(tag(second), ""));
    }
    if is_shape(element) {
        return Ok(element);
    }
    let mut inner = element.descendants().filter(|n| is_shape(*n));
    match (inner.next(), inner.next()) {
        (Some(only), None) => Ok(only),
        (first, _) => {
            let name = element.tag_name().name();
            let several = if first.is_some() { "several shapes" } else { "no outline" };
            let message = format!("`{id}` is a <{name}> with {several}");
            Err(Diagnostic::error(message).at(tag(element), "").help(ids()))
        }
    }
}

/// How much the ratio of two lengths is off that were written with six digits each, as Inkscape
/// does.
const WRITTEN_ROUNDING: f64 = 1e-5;

/// What moves an element where it stands in a style.
const MOTION: [&str; 5] = ["transform", "transform-origin", "translate", "rotate", "scale"];
/// What shapes an element where it stands in a style.
const GEOMETRY: [&str; 10] = ["d", "x", "y", "width", "height", "cx", "cy", "r", "rx", "ry"];

/// The map from the element's own coordinates to user units of the document.
fn transforms(element: Node<'_, '_>) -> Result<PlaneMap, Diagnostic> {
    let mut map = PlaneMap::IDENTITY;
    for node in element.ancestors().filter(|n| n.is_element()) {
        let is_root = node.parent_element().is_none();
        if node.tag_name().name() == "svg" && !is_root {
            return Err(Diagnostic::error("a drawing nested in a drawing is not supported")
                .at(tag(node), "this <svg> is not the outermost")
                .help("move the shape out of it"));
        }
        let own: &[&str] = if node == element { &GEOMETRY } else { &[] };
        if let Some(style) = node.attribute_node("style") {
            let declared = |d: &str| {
                let name = d.split(':').next().map_or("", str::trim);
                MOTION.iter().chain(own).copied().find(|known| *known == name)
            };
            if let Some(name) = style.value().split(';').find_map(declared) {
                return Err(Diagnostic::error(format!("a `{name}` in a style is not supported"))
                    .at(style.range_value(), "")
                    .help(match MOTION.contains(&name) {
                        true => "write the attribute `transform` instead".to_owned(),
                        false => format!("write it as the attribute `{name}`"),
                    }));
            }
        }
        if let Some(attribute) = node.attribute_node("transform") {
            if let Some(origin) = node.attribute_node("transform-origin") {
                return Err(Diagnostic::error("a `transform-origin` is not supported")
                    .at(origin.range_value(), "")
                    .help("write the shifts to it and back into the `transform`"));
            }
            map = transform_list(&attribute)?.after(&map);
        }
    }
    Ok(map)
}

fn transform_list(attribute: &Attribute<'_, '_>) -> Result<PlaneMap, Diagnostic> {
    let fail = |message: String| Diagnostic::error(message).at(attribute.range_value(), "");
    let mut map = PlaneMap::IDENTITY;
    for token in TransformListParser::from(attribute.value()) {
        let token = token.map_err(|e| fail(format!("the transform cannot be read: {e}")))?;
        map = map.after(&match token {
            TransformListToken::Matrix { a, b, c, d, e, f } => PlaneMap::new([a, b, c, d, e, f]),
            TransformListToken::Translate { tx, ty } => PlaneMap::translate(tx, ty),
            TransformListToken::Scale { sx, sy } => PlaneMap::scale(sx, sy),
            TransformListToken::Rotate { angle } => PlaneMap::rotate_degrees(angle),
            TransformListToken::SkewX { angle } => PlaneMap::skew_r_degrees(angle),
            TransformListToken::SkewY { angle } => PlaneMap::skew_z_degrees(angle),
        });
    }
    if map.determinant() == 0.0 || !map.determinant().is_finite() {
        return Err(fail("the transform flattens the drawing".into()));
    }
    Ok(map)
}

/// The page: what the root says about sizes.
struct Page {
    view_box: Option<ViewBox>,
    width: Option<Length>,
    height: Option<Length>,
    /// The y of the bottom of the page, in user units.
    bottom: Option<f64>,
}

impl Page {
    fn read(root: Node<'_, '_>) -> Result<Self, Diagnostic> {
        let bad = |a: &Attribute<'_, '_>, help: &str| {
            Diagnostic::error(format!("the drawing's `{}` cannot be read", a.name()))
                .at(a.range_value(), "")
                .help(help)
        };
        let view_box = root.attribute_node("viewBox").map(|a| {
            let good = |b: &ViewBox| [b.x, b.y, b.w, b.h].iter().all(|x| x.is_finite());
            let parsed = a.value().parse::<ViewBox>().ok().filter(good);
            parsed.ok_or_else(|| {
                bad(&a, "it is four numbers, x y width height, the last two positive")
            })
        });
        let length = |name| {
            let attribute = root.attribute_node(name)?;
            if attribute.value().trim() == "auto" {
                return None;
            }
            let parsed = attribute.value().trim().parse::<Length>().ok();
            let good = parsed.filter(|l| l.number.is_finite() && l.number > 0.0);
            Some(good.ok_or_else(|| bad(&attribute, "it is a positive length, such as `210mm`")))
        };
        let (view_box, width, height) =
            (view_box.transpose()?, length("width").transpose()?, length("height").transpose()?);
        let bottom = match view_box {
            Some(b) => Some(b.y + b.h),
            None => height.and_then(length_in_px),
        };
        Ok(Self { view_box, width, height, bottom })
    }

    fn px_per_user_unit(&self, root: Node<'_, '_>) -> Result<f64, Diagnostic> {
        let Some(view_box) = self.view_box else { return Ok(1.0) };
        let ratio = |length: Option<Length>, units| Some(length_in_px(length?)? / units);
        // `preserveAspectRatio`: the drawing fits into the page both ways.
        let ratios = [ratio(self.width, view_box.w), ratio(self.height, view_box.h)];
        if let ([Some(across), Some(down)], Some(fit)) =
            (ratios, root.attribute_node("preserveAspectRatio"))
        {
            let stretched = fit.value().contains("none") || fit.value().contains("slice");
            if stretched && (across - down).abs() > WRITTEN_ROUNDING * across {
                return Err(Diagnostic::error("the drawing is stretched or cut to fit its page")
                    .at(fit.range_value(), "")
                    .help("give `scale` instead of `unit`"));
            }
        }
        ratios.into_iter().flatten().reduce(f64::min).ok_or_else(|| {
            Diagnostic::error(
                "the drawing does not say how large it is; `unit` has no meaning here",
            )
            .at(tag(root), "neither `width` nor `height` is an absolute length")
            .help("give `scale` instead of `unit`")
        })
    }
}

/// A length in CSS pixels, which are the user units where nothing else is said; `None` for the
/// units that depend on a font or on the window.
fn length_in_px(length: Length) -> Option<f64> {
    let unit = match length.unit {
        LengthUnit::None | LengthUnit::Px => Unit::Px,
        LengthUnit::In => Unit::In,
        LengthUnit::Cm => Unit::Cm,
        LengthUnit::Mm => Unit::Mm,
        LengthUnit::Pt => Unit::Pt,
        LengthUnit::Pc => Unit::Pc,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return None,
    };
    Some(length.number * unit.in_px())
}

//! Paints and reliefs.

use rondure::Vec3;

use crate::{
    Along, Color, Diagnostic, Marble, Paint, Picture, Relief, Sheet, Sticker, Wood, Wrap,
    decode::{Bounds, Table, Value},
    image::Content,
};

/// The keys of a table that give a paint, of which it has one.
const KEYS: [&str; 6] = ["color", "checker", "image", "wood", "marble", "label"];

/// The paint that a table describes by one of its keys.
pub(super) fn paint(table: &Table<'_>, default: Color) -> Option<Paint> {
    let values = KEYS.map(|key| table.get(key));
    let mut given = KEYS.iter().zip(&values).filter(|(_, v)| v.is_some());
    if let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) {
        table.exclude(first, second);
        return None;
    }
    let [color, checker, image, wood, marble, label] = values;
    if let Some(v) = color {
        return paint_value(&v, default);
    }
    if let Some(v) = checker {
        return squares(v.table("a checker")?);
    }
    if let Some(v) = image {
        return picture(&v, default);
    }
    if let Some(v) = wood {
        return self::wood(v.table("wood")?);
    }
    if let Some(v) = marble {
        return self::marble(v.table("marble")?);
    }
    match label {
        Some(v) => labels(&v, default),
        None => Some(Paint::Solid(default)),
    }
}

/// The same under other keys: a colour or a paint, or a checker.
pub(super) fn paint_of(
    table: &Table<'_>,
    color_key: &'static str,
    checker_key: &'static str,
    default: Color,
) -> Option<Paint> {
    let (color, checker) = (table.get(color_key), table.get(checker_key));
    match (color, checker) {
        (Some(_), Some(_)) => {
            table.exclude(color_key, checker_key);
            None
        }
        (Some(v), None) => paint_value(&v, default),
        (None, Some(v)) => squares(v.table("a checker")?),
        (None, None) => Some(Paint::Solid(default)),
    }
}

/// A colour, or a table that describes a paint.
fn paint_value(value: &Value<'_>, default: Color) -> Option<Paint> {
    if !value.is_table() {
        return value.color(Bounds::FRACTION).map(Paint::Solid);
    }
    let table = value.table("a paint")?;
    let paint = paint(&table, default);
    table.finish();
    paint
}

fn two_colors(table: &Table<'_>, what: &str, default: Option<[Color; 2]>) -> Option<[Color; 2]> {
    let value = match default {
        None => table.require("colors")?,
        Some(default) => match table.get("colors") {
            Some(value) => value,
            None => return Some(default),
        },
    };
    let items = value.items("an array of two colours")?;
    match items.as_slice() {
        [a, b] => {
            let (a, b) = (a.color(Bounds::FRACTION), b.color(Bounds::FRACTION));
            Some([a?, b?])
        }
        _ => value.fail(format!("{what} has two colours, not {}", items.len())),
    }
}

fn squares(table: Table<'_>) -> Option<Paint> {
    let colors = two_colors(&table, "a checker", None);
    let in_space = match table.get("space") {
        Some(v) => v.boolean(),
        None => Some(false),
    };
    let size = table.get("size");
    let paint = if in_space? {
        let size = match size {
            None => Some([1.0; 3]),
            Some(v) if v.is_array() => v.numbers(Bounds::POSITIVE),
            Some(v) => v.number(Bounds::POSITIVE).map(|x| [x; 3]),
        };
        colors
            .zip(size)
            .map(|(colors, [x, y, z])| Paint::Blocks { colors, size: Vec3::new(x, y, z) })
    } else {
        let size = pair(size, Bounds::POSITIVE, 1.0);
        colors.zip(size).map(|(colors, size)| Paint::Checker { colors, size })
    };
    table.finish();
    paint
}

/// Two numbers, or one for both.
fn pair(value: Option<Value<'_>>, bounds: Bounds, default: f64) -> Option<[f64; 2]> {
    match value {
        None => Some([default; 2]),
        Some(v) if v.is_array() => v.numbers(bounds),
        Some(v) => v.number(bounds).map(|x| [x, x]),
    }
}

fn number(table: &Table<'_>, key: &'static str, bounds: Bounds, default: f64) -> Option<f64> {
    match table.get(key) {
        Some(v) => v.number(bounds),
        None => Some(default),
    }
}

fn color(table: &Table<'_>, key: &'static str, default: Color) -> Option<Color> {
    match table.get(key) {
        Some(v) => v.color(Bounds::FRACTION),
        None => Some(default),
    }
}

fn direction(table: &Table<'_>, key: &'static str, default: Vec3) -> Option<Vec3> {
    match table.get(key) {
        Some(v) => v.direction(),
        None => Some(default),
    }
}

fn seed(table: &Table<'_>) -> Option<Option<u32>> {
    match table.get("seed") {
        Some(v) => v.whole(0, u32::MAX).map(Some),
        None => Some(None),
    }
}

/// What is below: a paint, or the colour of a material that does not say.
fn over(table: &Table<'_>, default: Color) -> Option<Paint> {
    match table.get("over") {
        Some(v) => paint_value(&v, default),
        None => Some(Paint::Solid(default)),
    }
}

/// The name of a file, or a table that says where the picture lies.
fn picture(value: &Value<'_>, default: Color) -> Option<Paint> {
    if !value.is_table() {
        let sheet = plain_sheet(value, Content::Color)?;
        return Some(Paint::Picture(Box::new(Picture { sheet, over: Paint::Solid(default) })));
    }
    let table = value.table("a picture")?;
    let (sheet, over) = (sheet(&table, Content::Color), over(&table, default));
    table.finish();
    Some(Paint::Picture(Box::new(Picture { sheet: sheet?, over: over? })))
}

fn plain_sheet(value: &Value<'_>, content: Content) -> Option<Sheet> {
    let image = value.image(content)?;
    Some(Sheet { image, size: [1.0; 2], offset: [0.0; 2], wrap: Wrap::Repeat })
}

const WRAPS: [(&str, Wrap); 3] =
    [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("once", Wrap::Once)];

fn sheet(table: &Table<'_>, content: Content) -> Option<Sheet> {
    let image = table.require("file").and_then(|v| v.image(content));
    let size = pair(table.get("size"), Bounds::NOT_ZERO, 1.0);
    let offset = pair(table.get("offset"), Bounds::ANY, 0.0);
    let wrap = match table.get("wrap") {
        Some(v) => v.choice("way to go on beside a picture", &WRAPS),
        None => Some(Wrap::Repeat),
    };
    Some(Sheet { image: image?, size: size?, offset: offset?, wrap: wrap? })
}

/// One label, or several, the last on top.
fn labels(value: &Value<'_>, default: Color) -> Option<Paint> {
    if !value.is_array() {
        return label(value.table("a label")?, None, default);
    }
    let mut paint = Paint::Solid(default);
    let mut good = true;
    for (i, item) in value.items("an array of labels")?.into_iter().enumerate() {
        let below = (i > 0).then_some(&paint);
        match item.table("a label").and_then(|table| label(table, below, default)) {
            Some(found) => paint = found,
            None => good = false,
        }
    }
    good.then_some(paint)
}

/// A label; only one that lies on no other says what it is stuck on.
fn label(table: Table<'_>, below: Option<&Paint>, default: Color) -> Option<Paint> {
    let image = table.require("file").and_then(|v| v.image(Content::Color));
    let (z, v, length) = (table.get("z"), table.get("v"), table.get("length"));
    let given: Vec<_> = [(Along::Z, "z", z), (Along::V, "v", v), (Along::Length, "length", length)]
        .into_iter()
        .filter_map(|(along, key, value)| Some((along, key, value?)))
        .collect();
    let range = match given.as_slice() {
        [] => {
            let error = Diagnostic::error("a label needs one of the keys `z`, `v` and `length`");
            table.context().push(error.at(table.span(), "all three are missing"));
            None
        }
        [(along, _, value)] => value.numbers::<2>(Bounds::ANY).and_then(|range| {
            if range[0] < range[1] {
                return Some((*along, range));
            }
            value.fail("a label goes from its lower edge to its upper one, which is higher")
        }),
        [(_, a, _), (_, b, _), ..] => {
            table.exclude(a, b);
            None
        }
    };
    let around = match table.get("around") {
        None => Some([-180.0, 180.0]),
        Some(value) => value.numbers::<2>(Bounds::ANY).and_then(|[from, to]| {
            if from < to && to - from <= 360.0 {
                return Some([from, to]);
            }
            value.fail_with_help(
                "a label goes round from its left edge to its right one, by 360 degrees at most",
                "the second angle is the larger one; `[330, 390]` goes over 0".into(),
            )
        }),
    };
    let over = match below {
        Some(paint) => Some(paint.clone()),
        None => over(&table, default),
    };
    table.finish();
    let (along, range) = range?;
    let around = around?.map(f64::to_radians);
    Some(Paint::Label(Box::new(Sticker { image: image?, along, range, around, over: over? })))
}

/// Oak, about.
const EARLY: Color = [0.50, 0.30, 0.14];
const LATE: Color = [0.26, 0.12, 0.045];

fn wood(table: Table<'_>) -> Option<Paint> {
    let (early, late) = (color(&table, "early", EARLY), color(&table, "late", LATE));
    let pith = match table.get("pith") {
        Some(v) => v.vector(),
        None => Some(Vec3::ZERO),
    };
    let axis = direction(&table, "axis", Vec3::Z);
    let ring = number(&table, "ring", Bounds::POSITIVE, 0.1);
    let wobble = number(&table, "wobble", Bounds::NOT_NEGATIVE, 1.0);
    let fraction = |key, default| number(&table, key, Bounds::FRACTION, default);
    let (fibre, pores, rays) =
        (fraction("fibre", 0.4), fraction("pores", 0.3), fraction("rays", 0.2));
    let seed = seed(&table);
    table.finish();
    Some(Paint::Wood(Box::new(Wood {
        early: early?,
        late: late?,
        pith: pith?,
        axis: axis?,
        ring: ring?,
        wobble: wobble?,
        fibre: fibre?,
        pores: pores?,
        rays: rays?,
        seed: seed?,
    })))
}

fn marble(table: Table<'_>) -> Option<Paint> {
    let colors = two_colors(&table, "marble", Some([[0.85, 0.84, 0.81], [0.22, 0.23, 0.26]]));
    let size = number(&table, "size", Bounds::POSITIVE, 1.0);
    let across = direction(&table, "across", Vec3::new(0.6, 0.0, 0.8));
    let turbulence = number(&table, "turbulence", Bounds::NOT_NEGATIVE, 1.0);
    let sharpness = number(&table, "sharpness", Bounds::POSITIVE, 4.0);
    let seed = seed(&table);
    table.finish();
    Some(Paint::Marble(Box::new(Marble {
        colors: colors?,
        size: size?,
        across: across?,
        turbulence: turbulence?,
        sharpness: sharpness?,
        seed: seed?,
    })))
}

/// The relief of a material; the inner `None` if it has none.
pub(super) fn relief(table: &Table<'_>) -> Option<Option<Relief>> {
    match (table.get("bump"), table.get("normal_map")) {
        (None, None) => Some(None),
        (Some(_), Some(_)) => {
            table.exclude("bump", "normal_map");
            None
        }
        (Some(v), None) => bump(v.table("a bump")?).map(Some),
        (None, Some(v)) => normals(&v).map(Some),
    }
}

fn bump(table: Table<'_>) -> Option<Relief> {
    let height = table.require("height").and_then(|v| v.number(Bounds::ANY));
    let relief = if let Some(size) = table.get("noise") {
        if let Some(key) = ["file", "offset", "size", "wrap"].into_iter().find(|k| table.has(k)) {
            table.exclude("noise", key);
            return None;
        }
        let (size, seed) = (size.number(Bounds::POSITIVE), seed(&table));
        Some(Relief::Noise { size: size?, height: height?, seed: seed? })
    } else {
        let sheet = sheet(&table, Content::Data);
        Some(Relief::Bump { sheet: sheet?, height: height? })
    };
    table.finish();
    relief
}

fn normals(value: &Value<'_>) -> Option<Relief> {
    if !value.is_table() {
        let sheet = plain_sheet(value, Content::Data)?;
        return Some(Relief::Normals { sheet, strength: 1.0 });
    }
    let table = value.table("a normal map")?;
    let sheet = sheet(&table, Content::Data);
    let strength = number(&table, "strength", Bounds::NOT_NEGATIVE, 1.0);
    table.finish();
    Some(Relief::Normals { sheet: sheet?, strength: strength? })
}

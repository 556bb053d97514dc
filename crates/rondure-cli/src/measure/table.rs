//! Measures as text.

use std::fmt::Write;

use super::{
    Query,
    placed::{Measured, Solid},
    units::{Units, digits},
};

/// All that is known about one thing, a line for each quantity.
pub(super) fn in_full(measured: &Measured, units: &Units, queries: &[Query]) -> String {
    let mut lines: Vec<(String, String)> = Vec::new();
    let mut line = |name: &str, text: String| lines.push((name.into(), text));
    match &measured.sheet {
        Ok(sheet) => {
            line("diameter", units.powered(sheet.diameter, 1));
            line("height", units.powered(sheet.height, 1));
            line("length", units.powered(sheet.length, 1));
            line("area", units.powered(sheet.area, 2));
        }
        Err(reason) => line("area", format!("none: {reason}")),
    }
    match &measured.solid {
        Ok(solid) => {
            line("volume", units.powered(solid.volume, 3));
            if let Some(mass) = units.mass(solid.volume) {
                line("mass", mass);
            }
            line("centroid", position(solid));
            let t = &solid.inertia;
            let largest = t.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (name, i, j) in
                [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)]
            {
                // Products that are but rounding say nothing.
                if i == j || t[i][j].abs() > solid.inertia_error.min(largest) {
                    line(&format!("inertia {name}"), units.inertia(t[i][j]));
                }
            }
        }
        Err(reason) => line("volume", format!("none: {reason}")),
    }
    match &measured.cavity {
        Ok(placed) => {
            let [bottom, brim] = [placed.bottom(), placed.brim()].map(digits);
            let capacity = units.liquid(placed.capacity());
            line("capacity", format!("{capacity}, from z = {bottom} to the brim at z = {brim}"));
            if placed.trapped() > 0.0 {
                let air = units.liquid(placed.trapped());
                line("trapped air", format!("{air} more, under overhangs"));
            }
            for query in queries {
                let (name, text) = match *query {
                    Query::Level(z) => {
                        let volume = placed.volume(z).map(|v| units.liquid(v));
                        (format!("to z = {}", digits(z)), volume)
                    }
                    Query::Volume(v) => {
                        let level = placed.level(v).map(|z| format!("z = {}", digits(z)));
                        (units.liquid(v), level)
                    }
                };
                line(&name, text.unwrap_or_else(|| OVERFLOW.into()));
            }
        }
        Err(reason) => line("capacity", format!("none: {reason}")),
    }
    let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let mut text = measured.name.clone();
    for (name, value) in &lines {
        let _ = write!(text, "\n  {name:width$}  {value}");
    }
    text
}

const OVERFLOW: &str = "more than it holds";

/// The centroid; coordinates that are but rounding are zero.
fn position(solid: &Solid) -> String {
    let shown = |x: f64| if x.abs() <= solid.centroid_error { 0.0 } else { x };
    let [x, y, z] = solid.centroid.map(shown);
    if x == 0.0 && y == 0.0 {
        format!("z = {}", digits(z))
    } else {
        format!("({}, {}, {})", digits(x), digits(y), digits(z))
    }
}

/// Several things, a line for each, and below why something is missing.
pub(super) fn side_by_side(objects: &[Measured], units: &Units, queries: &[Query]) -> String {
    let mut header: Vec<String> =
        ["object", "area", "volume", "centroid", "capacity", "brim"].map(Into::into).into();
    if units.density.is_some() {
        header.insert(3, "mass".into());
    }
    header.extend(queries.iter().map(|query| match *query {
        Query::Level(z) => format!("to z = {}", digits(z)),
        Query::Volume(v) => format!("{} at", units.liquid(v)),
    }));
    let mut rows = vec![header];
    for object in objects {
        let none = || String::from("-");
        let mut row = vec![object.name.clone()];
        row.push(object.sheet.as_ref().map_or_else(|_| none(), |s| units.powered(s.area, 2)));
        let solid = object.solid.as_ref().ok();
        row.push(solid.map_or_else(none, |s| units.powered(s.volume, 3)));
        if units.density.is_some() {
            row.push(solid.and_then(|s| units.mass(s.volume)).unwrap_or_else(none));
        }
        row.push(solid.map_or_else(none, position));
        let cavity = object.cavity.as_ref().ok();
        row.push(cavity.map_or_else(none, |c| units.liquid(c.capacity())));
        row.push(cavity.map_or_else(none, |c| format!("z = {}", digits(c.brim()))));
        row.extend(queries.iter().map(|query| {
            let answer = match *query {
                Query::Level(z) => cavity.and_then(|c| c.volume(z)).map(|v| units.liquid(v)),
                Query::Volume(v) => {
                    cavity.and_then(|c| c.level(v)).map(|z| format!("z = {}", digits(z)))
                }
            };
            answer.unwrap_or_else(none)
        }));
        rows.push(row);
    }
    let width =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<_> = (0..rows[0].len()).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        let line: Vec<_> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        text += line.join("  ").trim_end();
        text.push('\n');
    }
    for (what, reasons) in [
        ("no area", reasons(objects, |object| object.sheet.as_ref().err())),
        ("no volume", reasons(objects, |object| object.solid.as_ref().err())),
        ("no capacity", reasons(objects, |object| object.cavity.as_ref().err())),
    ] {
        for (names, reason) in reasons {
            let _ = write!(text, "\n{what}: {names}: {reason}");
        }
    }
    text.trim_end().into()
}

/// The reasons for what is missing, and whom each concerns.
fn reasons<'a>(
    objects: &'a [Measured],
    of: impl Fn(&'a Measured) -> Option<&'a String>,
) -> Vec<(String, &'a str)> {
    const NAMES: usize = 3;
    let mut groups: Vec<(Vec<&str>, &str)> = Vec::new();
    for object in objects {
        let Some(reason) = of(object) else { continue };
        match groups.iter_mut().find(|(_, known)| known == reason) {
            Some((names, _)) => names.push(&object.name),
            None => groups.push((vec![&object.name], reason)),
        }
    }
    let listed = |(names, reason): (Vec<&str>, &'a str)| {
        let (first, rest) = names.split_at(names.len().min(NAMES));
        let others = match rest.len() {
            0 => String::new(),
            1 => " and another".into(),
            more => format!(" and {more} others"),
        };
        (first.join(", ") + &others, reason)
    };
    groups.into_iter().map(listed).collect()
}

//! The section: planes that cut the scene open, and what they do to each object.

use rondure::Vec3;

use super::material::Materials;
use crate::{
    Cut, Section,
    decode::{Table, Value},
};

/// The most planes that cut a scene.
const MOST_PLANES: usize = 16;

/// The key `section` of a scene: a table, or one for each plane.
pub(super) fn planes(value: Option<Value<'_>>, materials: &mut Materials) -> Vec<Section> {
    let Some(value) = value else { return Vec::new() };
    let tables = if value.is_table() {
        value.table("a section").into_iter().collect()
    } else {
        value.tables("section", "a section")
    };
    if tables.len() > MOST_PLANES {
        value.fail::<()>(format!(
            "{} planes; a scene can be cut by at most {MOST_PLANES}",
            tables.len()
        ));
    }
    tables.into_iter().filter_map(|table| plane(table, materials)).collect()
}

fn plane(table: Table<'_>, materials: &mut Materials) -> Option<Section> {
    let point = table.get("position").map_or(Some(Vec3::ZERO), |v| v.vector());
    let normal = table.require("normal").and_then(|v| v.direction());
    let material = face(&table, materials);
    table.finish();
    Some(Section { point: point?, normal: normal?, material: material? })
}

/// The key `material`, if it is there; `None` after an error.
fn face(table: &Table<'_>, materials: &mut Materials) -> Option<Option<usize>> {
    match table.get("material") {
        Some(v) => materials.find(Some(v)).map(Some),
        None => Some(None),
    }
}

/// The key `section` of an object.
pub(super) fn of_object(table: &Table<'_>, materials: &mut Materials) -> Option<Cut> {
    let Some(value) = table.get("section") else { return Some(Cut::default()) };
    if value.is_boolean() {
        return Some(if value.boolean()? { Cut::default() } else { Cut::Whole });
    }
    if !value.is_table() {
        return value.fail_with_help(
            "`section`: expected true, false or a table",
            "false leaves the object whole; {material = ..} says what its cut faces are made of"
                .into(),
        );
    }
    let table = value.table("an object's section")?;
    let material = face(&table, materials);
    table.finish();
    Some(Cut::Open { material: material? })
}

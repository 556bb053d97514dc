//! Sweeps over a part of the turn, and caps.

use std::{ops::Range, sync::Arc};

use rondure::{Surface, solid::Sweep};

use super::{material::Materials, shared::Profiles};
use crate::{
    Diagnostic,
    decode::{Bounds, Table, Value},
};

/// What the key `sweep` says.
pub(super) struct Sweeping {
    pub(super) sweep: Sweep,
    /// Where it says that the sweep is to be left open, if it does.
    pub(super) open: Option<Range<usize>>,
    /// The material of the plane faces, if they have one of their own.
    pub(super) faces: Option<usize>,
}

/// The key `caps`: the surface with its ends joined to the axis, if it asks for that.
pub(super) fn capped(
    table: &Table<'_>,
    surface: Option<Arc<Surface>>,
    profiles: &mut Profiles,
) -> Option<Arc<Surface>> {
    let Some(value) = table.get("caps") else { return surface };
    let (surface, wanted) = (surface, value.boolean()?);
    let surface = surface?;
    if !wanted {
        return Some(surface);
    }
    if surface.bounds_solid() {
        let warning =
            Diagnostic::warning("`caps` changes nothing: the profile bounds a solid already");
        table.context().push(warning.at(value.span(), ""));
        return Some(surface);
    }
    Some(profiles.capped(&surface))
}

/// The key `sweep`, if it is there; `None` after an error.
pub(super) fn sweeping(table: &Table<'_>, materials: &mut Materials) -> Option<Option<Sweeping>> {
    match table.get("sweep") {
        None => Some(None),
        Some(value) => read(&value, materials).map(Some),
    }
}

fn read(value: &Value<'_>, materials: &mut Materials) -> Option<Sweeping> {
    let ([from, to], open, faces) = if value.is_array() {
        (value.numbers::<2>(Bounds::ANY)?, None, None)
    } else if value.is_table() {
        let table = value.table("a sweep")?;
        let [from, to] = ["from", "to"].map(|key| table.require(key)?.number(Bounds::ANY));
        let open = match table.get("open") {
            None => Some(None),
            Some(v) => v.boolean().map(|open| open.then(|| v.span())),
        };
        // What is open has no faces.
        let faces = match open {
            Some(Some(_)) => Some(None),
            _ => table.get("material").map_or(Some(None), |v| materials.find(Some(v)).map(Some)),
        };
        table.finish();
        ([from?, to?], open?, faces?)
    } else {
        return value.fail_with_help(
            "`sweep`: expected two angles or a table",
            "write sweep = [0, 180], in degrees, or sweep = {from = 0, to = 180, open = true}"
                .into(),
        );
    };
    match Sweep::degrees(from, to) {
        Ok(sweep) => Some(Sweeping { sweep, open, faces }),
        Err(_) => value.fail_with_help(
            format!("a sweep cannot run from {from} to {to} degrees"),
            "the second angle must be larger than the first, by at most 360".into(),
        ),
    }
}

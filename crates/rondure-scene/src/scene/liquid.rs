//! What a vessel is filled with: the key `liquid` of a turned object.

use std::sync::Arc;

use rondure::{Surface, measure::Cavity};

use super::material::Materials;
use crate::{
    decode::{Bounds, Table, Value},
    profile::liquid::{NoLiquid, liquid},
};

/// A liquid in the frame of its vessel.
pub(super) struct Liquid {
    pub(super) surface: Arc<Surface>,
    pub(super) material: usize,
}

/// The key `liquid`, if it is there; `None` after an error. `vessel` is the material of the wall.
pub(super) fn filled(
    table: &Table<'_>,
    surface: Option<&Arc<Surface>>,
    vessel: Option<usize>,
    materials: &mut Materials,
) -> Option<Option<Liquid>> {
    let Some(value) = table.get("liquid") else { return Some(None) };
    if !value.is_table() {
        return value.fail_with_help(
            "`liquid`: expected a table",
            "write liquid = {material = \"wine\", level = 1.2}, or volume in place of level".into(),
        );
    }
    let own = value.table("a liquid")?;
    let material = own.require("material").and_then(|v| materials.find(Some(v)));
    let (level, volume) = (own.get("level"), own.get("volume"));
    let amount = match (level, volume) {
        (Some(_), Some(_)) => {
            own.exclude("level", "volume");
            None
        }
        (Some(level), None) => level.number(Bounds::ANY).map(|z| (level, Amount::Level(z))),
        (None, Some(volume)) => {
            volume.number(Bounds::POSITIVE).map(|v| (volume, Amount::Volume(v)))
        }
        (None, None) => {
            own.missing("level");
            None
        }
    };
    own.finish();
    if table.has("sweep") {
        table.exclude("sweep", "liquid");
        return None;
    }
    let ((at, amount), material, vessel, surface) = (amount?, material?, vessel?, surface?);
    let cavity = match surface.profile().measure().cavity {
        Ok(cavity) => cavity,
        Err(why) => {
            return value.fail_with_help(
                format!("this object holds no liquid: {why}"),
                "a vessel stands upright in its own frame, open at the top".into(),
            );
        }
    };
    let level = level_of(&at, amount, &cavity)?;
    match liquid(surface, &cavity, level) {
        Ok(profile) => Some(Some(Liquid {
            surface: Arc::new(Surface::new(&profile)),
            material: materials.giving_way(material, vessel),
        })),
        Err(NoLiquid::NoWall) => value.fail_with_help(
            "the vessel has no wall that a liquid could lie against",
            "draw the inside of the wall too, or give the profile a `thickness`".into(),
        ),
        Err(NoLiquid::Intricate) => at.fail_with_help(
            "up to this level the wall is too intricate: what is wetted does not run from the axis, or from \
             the liquid's surface, to its surface",
            "draw the liquid as an object of its own".into(),
        ),
        Err(NoLiquid::Profile(error)) => {
            value.fail(format!("the liquid's outline is no profile: {error}"))
        }
    }
}

enum Amount {
    Level(f64),
    Volume(f64),
}

/// The height at which the liquid stands.
fn level_of(at: &Value<'_>, amount: Amount, cavity: &Cavity) -> Option<f64> {
    let (bottom, brim, capacity) = (cavity.bottom(), cavity.brim(), cavity.capacity());
    match amount {
        Amount::Level(z) if z > brim => at.fail_with_help(
            format!("the level {z} lies above the brim"),
            format!("the vessel is full at z = {brim}; it then holds {capacity:.6}"),
        ),
        Amount::Level(z) if z <= bottom => at.fail_with_help(
            format!("the level {z} does not lie above the vessel's bottom"),
            format!("its inside reaches from z = {bottom} to z = {brim}"),
        ),
        Amount::Level(z) => Some(z),
        Amount::Volume(volume) => cavity.level(volume).filter(|z| *z > bottom).or_else(|| {
            at.fail_with_help(
                format!("the vessel does not hold the volume {volume}"),
                format!(
                    "up to its brim at z = {brim} it holds {capacity:.6}, in the profile's unit"
                ),
            )
        }),
    }
}

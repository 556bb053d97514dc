//! Where an object stands, and its copies.

use rondure::{Affine, Vec3};

use crate::{
    Area, Copies, Pattern, Series, Variation,
    decode::{Bounds, Table, Value},
};

/// The most copies that one object may have.
const MOST_COPIES: u32 = 100_000_000;

/// The copies of an object, which is the `number`-th of the scene.
pub(super) fn copies(table: &Table<'_>, number: usize) -> Option<Copies> {
    let (at, repeat, vary) = (table.get("at"), table.get("repeat"), table.get("vary"));
    let at = match &at {
        None => Some(Vec::new()),
        Some(v) => {
            let items = v.items("an array of positions [x, y, z]")?;
            if items.is_empty() {
                return v.fail("`at` has no positions, so the object is nowhere");
            }
            let shifts: Vec<_> = items.iter().map(Value::vector).collect();
            shifts.into_iter().collect::<Option<Vec<_>>>()
        }
    };
    let all_series: Option<Vec<_>> = match &repeat {
        None => Some(Vec::new()),
        Some(v) => {
            let tables = if v.is_array() { v.items("an array of tables")? } else { vec![*v] };
            let all: Vec<_> = tables.iter().map(|v| series(v, number)).collect();
            all.into_iter().collect()
        }
    };
    let variation = match vary {
        None => Some(None),
        Some(v) => variation(&v, number).map(Some),
    };
    let copies = Copies { at: at?, series: all_series?, variation: variation? };
    if let Some(repeat) = repeat.filter(|_| copies.count() > u64::from(MOST_COPIES)) {
        return repeat.fail(format!("these are more than {MOST_COPIES} copies"));
    }
    Some(copies)
}

/// A row, a ring or a scattering of copies.
fn series(value: &Value<'_>, number: usize) -> Option<Series> {
    let table = value.table("a repetition")?;
    let count = table.require("count").and_then(|v| v.whole(1, MOST_COPIES));
    let (step, scatter) = (table.get("step"), table.get("scatter"));
    let (turn, about) = (table.get("turn"), table.get("about"));
    let kinds = [("step", "turn"), ("step", "about"), ("step", "scatter")];
    let others = [("scatter", "turn"), ("scatter", "about")];
    if kinds.iter().chain(&others).any(|(a, b)| table.exclude(a, b).is_some()) {
        return None;
    }
    let pattern = if let Some(v) = step {
        v.vector().map(|step| Pattern::Row { step })
    } else if let Some(v) = scatter {
        let seed = seed(&table, number);
        area(&v).zip(seed).map(|(area, seed)| Pattern::Scatter { area, seed })
    } else {
        let center = about.map_or(Some(Vec3::ZERO), |v| v.vector());
        let axis = table.get("axis").map_or(Some(Vec3::Z), |v| v.direction());
        let angle = match turn {
            Some(v) => v.number(Bounds::ANY),
            None if table.has("about") => count.map(|n| 360.0 / f64::from(n)),
            None => value
                .fail("a repetition needs one of the keys `step`, `about`, `turn` and `scatter`"),
        };
        let ring = center.zip(axis).zip(angle);
        ring.map(|((center, axis), angle)| Pattern::Ring { center, axis, turn: angle.to_radians() })
    };
    table.finish();
    Some(Series { count: count?, pattern: pattern? })
}

/// The size of a box, or the radius of a disk.
fn area(value: &Value<'_>) -> Option<Area> {
    if value.is_array() {
        let [x, y, z] = value.numbers(Bounds::NOT_NEGATIVE)?;
        return Some(Area::Box(Vec3::new(x, y, z)));
    }
    value.number(Bounds::POSITIVE).map(Area::Disk)
}

/// What chooses the random numbers; if nothing is given, others for each object.
fn seed(table: &Table<'_>, number: usize) -> Option<u64> {
    match table.get("seed") {
        Some(v) => v.whole(0, u32::MAX).map(u64::from),
        // Beyond all seeds that can be given.
        None => Some((number as u64) << 32),
    }
}

fn variation(value: &Value<'_>, number: usize) -> Option<Variation> {
    let table = value.table("a variation")?;
    let shift = match table.get("move") {
        None => Some(Vec3::ZERO),
        Some(v) => v.numbers(Bounds::NOT_NEGATIVE).map(|[x, y, z]| Vec3::new(x, y, z)),
    };
    let angle = |key, bounds| match table.get(key) {
        None => Some(0.0),
        Some(v) => v.number(bounds).map(f64::to_radians),
    };
    let (turn, tilt) = (angle("turn", HALF_TURN), angle("tilt", HALF_TURN));
    let scale = match table.get("scale") {
        None => Some([1.0; 2]),
        Some(v) => {
            let [least, most] = v.numbers(Bounds::POSITIVE)?;
            if least > most {
                return v
                    .fail("`scale` is [least, most], and the least must not be the larger one");
            }
            Some([least, most])
        }
    };
    let seed = seed(&table, number);
    if !["move", "turn", "tilt", "scale"].iter().any(|key| table.has(key)) {
        return value.fail_with_help(
            "`vary` varies nothing",
            "it needs at least one of `move`, `turn`, `tilt` and `scale`".into(),
        );
    }
    table.finish();
    Some(Variation { shift: shift?, turn: turn?, tilt: tilt?, scale: scale?, seed: seed? })
}

const HALF_TURN: Bounds =
    Bounds::new(|x| (0.0..=180.0).contains(&x), "from 0 to 180 degrees either way");

/// The map from a turned object's own frame to the world: scale, rotation, axis, position.
pub(super) fn placement(table: &Table<'_>) -> Option<Affine> {
    let position = table.get("position").map_or(Some(Vec3::ZERO), |v| v.vector());
    let axis = match table.get("axis") {
        Some(v) => v.direction().map(Affine::align_z),
        None => Some(Affine::IDENTITY),
    };
    let rotation = table.get("rotation").map_or(Some(Affine::IDENTITY), |v| rotation(&v));
    let scale = match table.get("scale") {
        None => Some(Vec3::splat(1.0)),
        Some(v) if v.is_array() => {
            v.numbers::<3>(Bounds::NOT_ZERO).map(|[x, y, z]| Vec3::new(x, y, z))
        }
        Some(v) => v.number(Bounds::NOT_ZERO).map(Vec3::splat),
    };
    let turned = axis?.after(&rotation?);
    Some(Affine::translate(position?).after(&turned.after(&Affine::scale(scale?))))
}

/// A number of degrees about z, or about x, then y, then z.
fn rotation(value: &Value<'_>) -> Option<Affine> {
    let turn = |axis, degrees: f64| Affine::rotate(axis, degrees.to_radians());
    if value.is_array() {
        let [x, y, z] = value.numbers(Bounds::ANY)?;
        return Some(turn(Vec3::Z, z).after(&turn(Vec3::Y, y).after(&turn(Vec3::X, x))));
    }
    value.number(Bounds::ANY).map(|degrees| turn(Vec3::Z, degrees))
}

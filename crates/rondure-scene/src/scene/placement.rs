//! Where an object stands, and its copies.

use rondure::{Affine, Vec3};

use crate::decode::{Bounds, Table, Value};

/// The most copies that one object may have.
const MOST_COPIES: usize = 1_000_000;

/// The motions that carry an object to its copies; one that leaves it in place if there are none.
pub(super) fn copies(table: &Table<'_>) -> Option<Vec<Affine>> {
    let (at, repeat) = (table.get("at"), table.get("repeat"));
    let moved = match &at {
        None => Some(vec![Affine::IDENTITY]),
        Some(v) => {
            let items = v.items("an array of positions [x, y, z]")?;
            if items.is_empty() {
                return v.fail("`at` has no positions, so the object is nowhere");
            }
            let moves: Vec<_> = items.iter().map(|i| i.vector().map(Affine::translate)).collect();
            moves.into_iter().collect::<Option<Vec<_>>>()
        }
    };
    let Some(repeat) = repeat else { return moved };
    let series: Vec<_> = if repeat.is_array() {
        repeat.items("an array of tables")?.iter().map(series).collect()
    } else {
        vec![series(&repeat)]
    };
    let series = series.into_iter().collect::<Option<Vec<_>>>()?;
    let mut all = moved?;
    for steps in series {
        if all.len().saturating_mul(steps.len()) > MOST_COPIES {
            return repeat.fail(format!("these are more than {MOST_COPIES} copies"));
        }
        all = all.iter().flat_map(|copy| steps.iter().map(|step| step.after(copy))).collect();
    }
    Some(all)
}

/// A row or a circle of copies: the i-th is i steps, or i turns, from the first.
fn series(value: &Value<'_>) -> Option<Vec<Affine>> {
    let table = value.table("a repetition")?;
    let count = table.require("count").and_then(|v| v.whole(1, MOST_COPIES as u32));
    let (step, turn) = (table.get("step"), table.get("turn"));
    let about = table.get("about");
    let series = match (step, turn, about) {
        (Some(v), None, None) => count.zip(v.vector()).map(|(count, step)| {
            (0..count).map(|i| Affine::translate(step * f64::from(i))).collect()
        }),
        (Some(_), _, _) => {
            table.exclude("step", "turn").or_else(|| table.exclude("step", "about"));
            None
        }
        (None, turn, about) => {
            let center = about.map_or(Some(Vec3::ZERO), |v| v.vector());
            let axis = table.get("axis").map_or(Some(Vec3::Z), |v| v.direction());
            let angle = match turn {
                Some(v) => v.number(Bounds::ANY),
                None if table.has("about") => count.map(|n| 360.0 / f64::from(n)),
                None => {
                    table.missing("step");
                    None
                }
            };
            let turns = count.zip(center).zip(axis).zip(angle);
            turns.map(|(((count, center), axis), angle)| {
                (0..count)
                    .map(|i| {
                        let turn = Affine::rotate(axis, (f64::from(i) * angle).to_radians());
                        about_point(&turn, center)
                    })
                    .collect()
            })
        }
    };
    table.finish();
    series
}

fn about_point(map: &Affine, center: Vec3) -> Affine {
    let back = Affine::translate(Vec3::ZERO - center);
    Affine::translate(center).after(&map.after(&back))
}

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

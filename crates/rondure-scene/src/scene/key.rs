//! The keyframes of the camera, `[[camera.key]]`: moments at which it is told anew.

use crate::{
    Camera, Diagnostic, Key, Lens, Projection,
    decode::{Bounds, Table, Value},
};

use super::view::FIELD_OF_VIEW;

/// The keys of a camera; what one does not tell is as in the one before it, and in the first as in the `camera` itself. `focus` is the distance
/// that the camera was told, if it was.
pub(super) fn keys(value: Option<Value<'_>>, camera: &Camera, focus: Option<f64>) -> Vec<Key> {
    let Some(value) = value else { return Vec::new() };
    let (mut camera, mut focus) = (camera.clone(), focus);
    let mut keys: Vec<Key> = Vec::new();
    for table in value.tables("camera.key", "a key of the camera") {
        let Some(time) = key(table, &mut camera, &mut focus, keys.last()) else { continue };
        keys.push(Key { time, camera: camera.clone() });
    }
    keys
}

fn key(
    table: Table<'_>,
    camera: &mut Camera,
    focus: &mut Option<f64>,
    before: Option<&Key>,
) -> Option<f64> {
    let cx = table.context();
    let time = table.require("time").and_then(|v| {
        let time = v.number(Bounds::NOT_NEGATIVE)?;
        match before {
            Some(key) if time <= key.time => {
                v.fail(format!("`time` must be later than that of the key before, {}", key.time))
            }
            _ => Some(time),
        }
    });
    let vector = |key| table.get(key).and_then(|v| v.vector());
    camera.eye = vector("eye").unwrap_or(camera.eye);
    camera.look_at = vector("look_at").unwrap_or(camera.look_at);
    camera.up = table.get("up").and_then(|v| v.direction()).unwrap_or(camera.up);
    match &mut camera.projection {
        Projection::Perspective { fov } => {
            let given = table.number("fov", FIELD_OF_VIEW);
            *fov = given.map_or(*fov, f64::to_radians);
        }
        Projection::Orthographic { height } => {
            *height = table.number("height", Bounds::POSITIVE).unwrap_or(*height);
        }
    }
    let radius = table.number("lens_radius", Bounds::NOT_NEGATIVE);
    let radius = radius.unwrap_or(camera.lens.map_or(0.0, |lens| lens.radius));
    *focus = table.number("focus", Bounds::POSITIVE).or(*focus);
    let distance = (camera.look_at - camera.eye).length();
    camera.lens = (radius > 0.0).then_some(Lens { radius, focus: focus.unwrap_or(distance) });
    // What is as before has been told before.
    let told = ["eye", "look_at", "up"].iter().any(|key| table.has(key));
    if told && !camera.has_view() {
        let error =
            Diagnostic::error("the camera looks nowhere, or along its own `up`, at this key");
        cx.push(error.at(table.span(), ""));
    }
    table.finish();
    time
}

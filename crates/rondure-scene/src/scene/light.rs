//! The sky and the lights.

use rondure::Vec3;

use crate::{
    Color, Light, Sky,
    decode::{Bounds, Table},
};

const WHITE: Color = [1.0; 3];
const BLACK: Color = [0.0; 3];

/// The sun as seen from the earth, in degrees across.
const ANGLE_OF_THE_SUN: f64 = 0.53;

pub(super) fn sky(table: Option<Table<'_>>) -> Sky {
    let Some(table) = table else { return Sky::Constant { color: BLACK } };
    let intensity = table.number("intensity", Bounds::NOT_NEGATIVE).unwrap_or(1.0);
    let color = |key| {
        let value = table.get(key)?;
        Some(scaled(value.color(Bounds::NOT_NEGATIVE).unwrap_or(WHITE), intensity))
    };
    let (constant, zenith) = (color("color"), color("zenith"));
    let (horizon, ground) = (color("horizon"), color("ground"));
    let gradient = zenith.is_some() || horizon.is_some() || ground.is_some();
    let sky = if let (Some(_), true) = (constant, gradient) {
        for key in ["zenith", "horizon", "ground"] {
            if table.exclude("color", key).is_some() {
                break;
            }
        }
        Sky::Constant { color: BLACK }
    } else if gradient {
        let given = |color: Option<Color>, key| {
            if color.is_none() {
                table.missing(key);
            }
            color.unwrap_or(BLACK)
        };
        let (zenith, horizon) = (given(zenith, "zenith"), given(horizon, "horizon"));
        Sky::Gradient { zenith, horizon, ground: ground.unwrap_or(horizon) }
    } else {
        Sky::Constant { color: constant.unwrap_or_else(|| scaled(WHITE, intensity)) }
    };
    table.finish();
    sky
}

/// Whether neither the sky nor any light gives light.
pub(super) fn is_dark(sky: &Sky, lights: &[Light]) -> bool {
    let sky_is_black = match *sky {
        Sky::Constant { color } => color == BLACK,
        Sky::Gradient { zenith, horizon, ground } => [zenith, horizon, ground] == [BLACK; 3],
    };
    let is_black = |light: &Light| match *light {
        Light::Point { intensity: color, .. }
        | Light::Sun { irradiance: color, .. }
        | Light::Disk { radiance: color, .. }
        | Light::Sphere { radiance: color, .. } => color == BLACK,
    };
    sky_is_black && lights.iter().all(is_black)
}

#[derive(Clone, Copy)]
enum Kind {
    Point,
    Sun,
    Disk,
    Sphere,
}

const KINDS: [(&str, Kind); 4] =
    [("point", Kind::Point), ("sun", Kind::Sun), ("disk", Kind::Disk), ("sphere", Kind::Sphere)];

pub(super) fn light(mut table: Table<'_>) -> Option<Light> {
    let value = table.require("type")?;
    let kind = value.choice("light", &KINDS)?;
    table.call(format!("a {} light", value.as_str().unwrap_or_default()));
    let color = match table.get("color") {
        Some(v) => v.color(Bounds::NOT_NEGATIVE),
        None => Some(WHITE),
    };
    let intensity = match table.get("intensity") {
        Some(v) => v.number(Bounds::NOT_NEGATIVE),
        None => Some(1.0),
    };
    let power = color.zip(intensity).map(|(c, i)| scaled(c, i));
    let position = || table.require("position").and_then(|v| v.vector());
    let radius = || table.require("radius").and_then(|v| v.number(Bounds::POSITIVE));
    let light = match kind {
        Kind::Point => {
            position().zip(power).map(|(position, intensity)| Light::Point { position, intensity })
        }
        Kind::Sun => {
            let direction = table.require("direction").and_then(|v| v.direction());
            let across = Bounds::new(|x| (0.0..=90.0).contains(&x), "from 0 to 90 degrees");
            let angle = match table.get("angle") {
                Some(v) => v.number(across),
                None => Some(ANGLE_OF_THE_SUN),
            };
            direction.zip(power).zip(angle).map(|((direction, irradiance), angle)| Light::Sun {
                direction,
                irradiance,
                angular_radius: 0.5 * angle.to_radians(),
            })
        }
        Kind::Disk => {
            let (center, radius) = (position(), radius());
            let normal = disk_normal(&table, center);
            center.zip(normal).zip(radius).zip(power).map(
                |(((center, normal), radius), radiance)| Light::Disk {
                    center,
                    normal,
                    radius,
                    radiance,
                },
            )
        }
        Kind::Sphere => {
            let (center, radius) = (position(), radius());
            center.zip(radius).zip(power).map(|((center, radius), radiance)| Light::Sphere {
                center,
                radius,
                radiance,
            })
        }
    };
    table.finish();
    light
}

/// Where a disk shines: a direction, or towards a point.
fn disk_normal(table: &Table<'_>, center: Option<Vec3>) -> Option<Vec3> {
    let (direction, look_at) = (table.get("direction"), table.get("look_at"));
    match (direction, look_at) {
        (Some(_), Some(_)) => {
            table.exclude("direction", "look_at");
            None
        }
        (Some(v), None) => v.direction(),
        (None, Some(v)) => {
            let away = v.vector()? - center?;
            let size = away.max_abs();
            if size == 0.0 || !size.is_finite() {
                return v.fail("the light stands where it shall shine to");
            }
            Some((away / size).normalized())
        }
        (None, None) => {
            table.missing("direction");
            None
        }
    }
}

fn scaled(color: Color, factor: f64) -> Color {
    color.map(|c| c * factor)
}

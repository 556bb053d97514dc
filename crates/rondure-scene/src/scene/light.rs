//! The sky and the lights.

use std::sync::Arc;

use rondure::Vec3;

use crate::{
    Color, Image, Light, Sky,
    decode::{Bounds, Table, Value},
    image::Content,
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
    let sky = if let Some(value) = table.get("image") {
        let image = picture(&value);
        let rotation = table.number("rotate", Bounds::ANY).unwrap_or(0.0).to_radians();
        for key in ["color", "zenith", "horizon", "ground"] {
            if table.exclude("image", key).is_some() {
                break;
            }
        }
        match image {
            Some(image) => Sky::Image { image, intensity, rotation },
            None => Sky::Constant { color: WHITE },
        }
    } else if let (Some(_), true) = (constant, gradient) {
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

/// A picture of all directions.
fn picture(value: &Value<'_>) -> Option<Arc<Image>> {
    let image = value.image(Content::Light)?;
    let (width, height) = (image.width(), image.height());
    if u64::from(width) != 2 * u64::from(height) {
        return value.fail_with_help(
            format!("the picture of a sky is twice as wide as high, not {width} x {height}"),
            "it shows all directions: 360 degrees from left to right, 180 from top to bottom \
             (equirectangular, or latitude-longitude)"
                .into(),
        );
    }
    Some(image)
}

/// Whether neither the sky nor any light gives light.
pub(super) fn is_dark(sky: &Sky, lights: &[Light]) -> bool {
    let sky_is_black = match *sky {
        Sky::Constant { color } => color == BLACK,
        Sky::Gradient { zenith, horizon, ground } => [zenith, horizon, ground] == [BLACK; 3],
        Sky::Image { ref image, intensity, .. } => {
            let channels = image.channels() as usize;
            let dark = |pixel: &[f32]| pixel.iter().take(3).all(|x| *x == 0.0);
            intensity == 0.0 || image.samples().chunks_exact(channels).all(dark)
        }
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

//! A scene that both programs can draw, made from one that only Rondure can.
//!
//! What is left is light from points and parallel light, with sharp shadows, and materials that
//! need no random numbers: lights with area shrink to points of the same intensity, suns to points
//! of no width, the sky becomes parallel light from above of the same irradiance, lenses and the
//! blur of glossy reflections go. Glass loses its colour: where bodies of glass overlap, as a glass
//! and the wine in it do, POV-Ray absorbs in neither. The result is a scene file again, which
//! Rondure itself renders.

use std::{error::Error, f64::consts::PI, path::Path};

use toml::{Table, Value};

/// The scene without what POV-Ray cannot do alike. `scene` is the same file, read.
pub(crate) fn level(
    text: &str,
    folder: &Path,
    scene: &rondure_scene::Scene,
) -> Result<String, Box<dyn Error>> {
    if matches!(scene.sky, rondure_scene::Sky::Image { .. }) {
        return Err("POV-Ray is not given skies from pictures; choose another scene".into());
    }
    let mut root: Table = text.parse()?;
    absolute_files(&mut root, &folder.canonicalize()?);
    if let Some(Value::Table(camera)) = root.get_mut("camera") {
        camera.remove("lens_radius");
        camera.remove("focus");
    }
    film(&mut root)?;
    root.insert("sky".into(), table([("color", black())]));
    let lights: Vec<_> = scene.lights.iter().map(point_light).chain(daylight(&scene.sky)).collect();
    root.insert("light".into(), Value::Array(lights));
    simplify(&mut root);
    Ok(root.to_string())
}

fn film(root: &mut Table) -> Result<(), Box<dyn Error>> {
    let film = root.entry("film").or_insert_with(|| Value::Table(Table::new()));
    let film = film.as_table_mut().ok_or("`film` is not a table")?;
    film.insert("bits".into(), 8.into());
    Ok(())
}

/// Makes the names of profile files independent of where the scene file stands.
fn absolute_files(table: &mut Table, folder: &Path) {
    for (key, value) in table.iter_mut() {
        match value {
            Value::String(file) if key == "file" => {
                *file = folder.join(&*file).to_string_lossy().into_owned();
            }
            other => each_table(other, &mut |inner| absolute_files(inner, folder)),
        }
    }
}

/// Makes all coats mirrors and all glass clear.
fn simplify(table: &mut Table) {
    match table.get("type").and_then(Value::as_str) {
        Some("glossy") => drop(table.insert("roughness".into(), 0.0.into())),
        Some("glass") => drop(table.insert("color".into(), numbers([1.0; 3]))),
        _ => {}
    }
    for (_, value) in table.iter_mut() {
        each_table(value, &mut simplify);
    }
}

fn each_table(value: &mut Value, apply: &mut dyn FnMut(&mut Table)) {
    match value {
        Value::Table(table) => apply(table),
        Value::Array(items) => items.iter_mut().for_each(|item| each_table(item, apply)),
        _ => {}
    }
}

fn point_light(light: &rondure_scene::Light) -> Value {
    use rondure_scene::Light;
    let point = |position: rondure::Vec3, intensity: [f64; 3]| {
        table([
            ("type", "point".into()),
            ("position", numbers([position.x, position.y, position.z])),
            ("color", numbers(intensity)),
        ])
    };
    match *light {
        Light::Point { position, intensity } => point(position, intensity),
        Light::Sun { direction, irradiance, .. } => sun(direction, irradiance),
        Light::Disk { center, radius, radiance, .. }
        | Light::Sphere { center, radius, radiance } => {
            point(center, radiance.map(|c| c * PI * radius * radius))
        }
    }
}

/// Where the parallel light comes from that stands for the sky: not straight from above, which is
/// a special case for rays.
const FROM_THE_SKY: rondure::Vec3 = rondure::Vec3::new(0.3, -0.4, 1.0);

/// Parallel light that gives a level ground the irradiance of the sky.
fn daylight(sky: &rondure_scene::Sky) -> Option<Value> {
    use rondure_scene::Sky;
    let irradiance = match *sky {
        Sky::Constant { color } => color.map(|c| c * PI),
        // The radiance is mixed by the cosine c with the zenith; 2 c^2 has the mean 2/3.
        Sky::Gradient { zenith, horizon, .. } => {
            [0, 1, 2].map(|i| PI * (2.0 * zenith[i] + horizon[i]) / 3.0)
        }
        Sky::Image { .. } => return None,
    };
    let direction = FROM_THE_SKY.normalized();
    (irradiance != [0.0; 3]).then(|| sun(direction, irradiance.map(|c| c / direction.z)))
}

fn sun(direction: rondure::Vec3, irradiance: [f64; 3]) -> Value {
    table([
        ("type", "sun".into()),
        ("direction", numbers([direction.x, direction.y, direction.z])),
        ("angle", 0.0.into()),
        ("color", numbers(irradiance)),
    ])
}

fn table<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::Table(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

fn numbers(values: [f64; 3]) -> Value {
    Value::Array(values.map(Value::Float).to_vec())
}

fn black() -> Value {
    numbers([0.0; 3])
}

#[cfg(test)]
mod tests {
    use rondure_scene::{Light, Material, Sky};

    use super::*;

    #[test]
    fn what_is_left_is_sharp() {
        let text = r#"
            camera = {eye = [0, -5, 1], look_at = [0, 0, 1], lens_radius = 0.1}
            sky = {color = [0.5, 0.5, 0.5]}
            light = [{type = "sphere", position = [1, 2, 3], radius = 2, intensity = 10}]
            object = [
                {profile = {path = "M 0 0 L 1 0 L 0 1"}, material = {type = "glossy"}},
                {type = "sphere", radius = 1, material = {type = "glass", color = "red"}},
            ]
        "#;
        let (scene, _) = rondure_scene::parse_scene("a", text, Path::new("")).unwrap();
        let leveled = level(text, Path::new("."), &scene).unwrap();
        let (scene, _) = rondure_scene::parse_scene("b", &leveled, Path::new("")).unwrap();
        assert!(scene.camera.lens.is_none());
        assert_eq!(scene.sky, Sky::Constant { color: [0.0; 3] });
        assert!(matches!(scene.materials[0], Material::Glossy { roughness: 0.0, .. }));
        assert!(matches!(scene.materials[1], Material::Glass(glass) if glass.color == [1.0; 3]));
        let [Light::Point { intensity, .. }, Light::Sun { irradiance, angular_radius, direction }] =
            scene.lights[..]
        else {
            panic!("{:?}", scene.lights);
        };
        assert!((intensity[0] - 40.0 * PI).abs() < 1e-12);
        assert!((irradiance[0] * direction.z - 0.5 * PI).abs() < 1e-12 && angular_radius == 0.0);
    }
}

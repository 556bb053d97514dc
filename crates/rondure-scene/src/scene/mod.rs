//! Scene files: TOML to a typed [`Scene`]. `docs/scene.md` is the reference of the format.

mod key;
mod light;
mod liquid;
mod material;
mod object;
mod paint;
mod placement;
mod section;
mod shared;
mod solid;
mod sweep;
mod view;

use std::path::Path;

use toml::de::DeTable;

use crate::{
    Diagnostic, Report, Scene,
    decode::{Context, Table, Value},
    file::read_text,
};

/// Reads a scene file and all that it refers to. Files are looked for beside the scene file.
///
/// With the scene comes a report of warnings, often empty.
///
/// # Errors
///
/// A [`Report`] of everything that is wrong with the scene and with its profiles. Where the file is
/// no TOML at all, only that is reported.
pub fn read_scene(path: &Path) -> Result<(Scene, Report), Report> {
    let text = read_text(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse_scene(&path.display().to_string(), &text, folder)
}

/// Takes a scene from text in memory; `name` stands in messages where the path would, and files
/// are looked for in `folder`.
///
/// # Errors
///
/// As for [`read_scene`].
pub fn parse_scene(name: &str, text: &str, folder: &Path) -> Result<(Scene, Report), Report> {
    let mut report = Report::new(name, text);
    let (document, errors) = DeTable::parse_recoverable(text);
    // What follows the first error in the syntax is often only its consequence.
    let first = errors.iter().min_by_key(|e| e.span().map(|span| span.start));
    if let Some(error) = first {
        let diagnostic = Diagnostic::error(format!("not a TOML file: {}", error.message()));
        report.push(match error.span() {
            Some(span) => diagnostic.at(span, ""),
            None => diagnostic,
        });
        return Err(report);
    }
    let cx = Context::new(text, report, folder);
    let scene = decode(&cx, document.get_ref(), folder);
    let mut report = cx.into_report();
    report.sort();
    match scene {
        Some(scene) if report.errors() == 0 => Ok((scene, report)),
        _ => Err(report),
    }
}

fn decode<'a>(cx: &'a Context<'a>, document: &'a DeTable<'a>, folder: &Path) -> Option<Scene> {
    let root = Table::root(cx, document);
    let film = view::film(part(&root, "film", "a film"));
    let camera = view::camera(root.get("camera"), cx);
    let sky = light::sky(part(&root, "sky", "a sky"));
    let lights: Vec<_> = match root.get("light") {
        Some(v) => v.tables("light", "a light").into_iter().filter_map(light::light).collect(),
        None => Vec::new(),
    };
    let mut materials = material::Materials::read(part(&root, "materials", "the materials"));
    let mut profiles = shared::Profiles::read(part(&root, "profiles", "the profiles"), folder);
    let section = section::planes(root.get("section"), &mut materials);
    let objects = root.get("object").map_or_else(Vec::new, |v| v.tables("object", "an object"));
    let objects = object::objects(objects, &mut materials, &mut profiles);
    let dark = light::is_dark(&sky, &lights);
    root.finish();
    // Where there are errors, what is unused may be meant by them.
    if !cx.has_errors() {
        profiles.warn_unused(cx);
        materials.warn_unused(cx);
        if dark {
            let warning =
                Diagnostic::warning("nothing lights the scene; the picture will be black");
            cx.push(warning.help("add a [sky] or a [[light]]"));
        }
    }
    let (materials, reliefs) = materials.finish();
    let (camera, keys) = camera?;
    Some(Scene { film, camera, keys, sky, lights, objects, materials, reliefs, section })
}

/// A table of the scene that may be missing.
fn part<'a>(root: &Table<'a>, key: &'static str, what: &str) -> Option<Table<'a>> {
    root.get(key).as_ref().and_then(|v: &Value<'a>| v.table(what))
}

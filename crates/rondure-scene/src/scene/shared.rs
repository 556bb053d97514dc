//! Profiles, by name and inline, each built once into a surface that all its copies share.

use std::{
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};

use rondure::{
    Point, Profile, Spline, Surface,
    profile::{Rim, Side, Thickness},
};

use crate::{
    Diagnostic, ProfileFormat, ProfileOptions, Unit,
    decode::{Bounds, Context, Table, Value, suggest},
    profile::{path, points, read_profile, wall},
};

/// The profiles of a scene.
pub(super) struct Profiles {
    named: Vec<Named>,
    /// Surfaces that were capped, and what came of them.
    capped: Vec<[Arc<Surface>; 2]>,
    folder: PathBuf,
}

struct Named {
    name: String,
    span: Range<usize>,
    /// `None` if it had errors.
    surface: Option<Arc<Surface>>,
    used: bool,
}

impl Profiles {
    pub(super) fn read(table: Option<Table<'_>>, folder: &Path) -> Self {
        let mut named = Vec::new();
        for (name, span, value) in table.iter().flat_map(Table::named) {
            let surface = profile(&value, folder).map(|p| Arc::new(Surface::new(&p)));
            named.push(Named { name: name.into(), span, surface, used: false });
        }
        Self { named, capped: Vec::new(), folder: folder.into() }
    }

    /// The surface of the same profile with its ends joined to the axis.
    pub(super) fn capped(&mut self, surface: &Arc<Surface>) -> Arc<Surface> {
        if let Some([_, known]) = self.capped.iter().find(|[own, _]| Arc::ptr_eq(own, surface)) {
            return Arc::clone(known);
        }
        let capped = Arc::new(Surface::new(&surface.profile().capped()));
        self.capped.push([Arc::clone(surface), Arc::clone(&capped)]);
        capped
    }

    /// The surface of the profile that a value names or describes.
    pub(super) fn find(&mut self, value: &Value<'_>) -> Option<Arc<Surface>> {
        if value.is_table() {
            return profile(value, &self.folder).map(|p| Arc::new(Surface::new(&p)));
        }
        let Some(name) = value.as_str() else {
            return value.fail("expected the name of a profile, or a table {path = ..}");
        };
        if let Some(named) = self.named.iter_mut().find(|n| n.name == name) {
            named.used = true;
            return named.surface.clone();
        }
        let message = format!("there is no profile `{name}`");
        let help = if ProfileFormat::from_path(Path::new(name)).is_some() {
            format!("a file is given as {{file = \"{name}\"}}")
        } else if self.named.is_empty() {
            format!("describe it in a table [profiles.{name}]")
        } else {
            suggest(name, self.named.iter().map(|n| &*n.name))
        };
        value.fail_with_help(message, help)
    }

    pub(super) fn warn_unused(&self, cx: &Context<'_>) {
        for named in self.named.iter().filter(|n| !n.used) {
            let message = format!("the profile `{}` is never used", named.name);
            cx.push(Diagnostic::warning(message).at(named.span.clone(), ""));
        }
    }
}

const SPLINES: [(&str, Spline); 3] = [
    ("polyline", Spline::Polyline),
    ("natural", Spline::Natural),
    ("catmull-rom", Spline::CatmullRom),
];

fn profile(value: &Value<'_>, folder: &Path) -> Option<Profile> {
    let table = value.table("a profile")?;
    let (inline, file, points) = (table.get("path"), table.get("file"), table.get("points"));
    let scale = match table.get("scale") {
        Some(v) => v.number(Bounds::POSITIVE),
        None => Some(1.0),
    };
    let wall = thickness(&table);
    let profile = match (inline, file, points) {
        (Some(v), None, None) => from_path_data(&v, scale),
        (None, Some(v), None) => from_file(&v, &table, scale, folder),
        (None, None, Some(v)) => from_points(&v, &table, scale),
        (None, None, None) => {
            table.context().push(
                Diagnostic::error("a profile needs one of the keys `path`, `file` and `points`")
                    .at(table.span(), "all three are missing"),
            );
            None
        }
        _ => {
            let pairs = [("path", "file"), ("path", "points"), ("file", "points")];
            pairs.iter().find_map(|(a, b)| table.exclude(a, b));
            return None;
        }
    };
    table.finish();
    match wall? {
        Some((value, wall)) => match wall::thicken(&profile?, &wall) {
            Ok(profile) => Some(profile),
            Err(error) => {
                value.context().push(error.at(value.span(), "the thickness"));
                None
            }
        },
        None => profile,
    }
}

/// The thickness of the profile and where it stands, if it has one; `None` if that is wrong.
fn thickness<'a>(table: &Table<'a>) -> Option<Option<(Value<'a>, Thickness)>> {
    let (side, rim) = (table.get("side"), table.get("rim"));
    let Some(value) = table.get("thickness") else {
        let Some(key) = ["side", "rim"].into_iter().find(|key| table.has(key)) else {
            return Some(None);
        };
        let error = Diagnostic::error(format!("`{key}` is for a wall, which needs a `thickness`"));
        table.context().push(error.at(table.key_span(key).unwrap_or(table.span()), ""));
        return None;
    };
    let thickness = value.number(Bounds::POSITIVE);
    let side = side.map_or(Some(Side::default()), |v| v.choice("side of a wall", &wall::SIDES));
    let rim = rim.map_or(Some(Rim::default()), |v| v.choice("rim of a wall", &wall::RIMS));
    Some(Some((value, Thickness { thickness: thickness?, side: side?, rim: rim? })))
}

fn spline(table: &Table<'_>) -> Option<Option<Spline>> {
    match table.get("spline") {
        Some(v) => v.choice("spline", &SPLINES).map(Some),
        None => Some(None),
    }
}

fn from_path_data(value: &Value<'_>, scale: Option<f64>) -> Option<Profile> {
    let text = value.string()?;
    let result = path::parse(text, scale?);
    result.map_err(|error| place(error, value)).ok()
}

/// Reports an error in path data where the data stands in the scene.
fn place(mut error: Diagnostic, value: &Value<'_>) {
    let label = error.labels.pop();
    let inside = label.as_ref().and_then(|l| l.span.clone()).zip(value.string_content());
    let span = inside.map(|(span, content)| content.start + span.start..content.start + span.end);
    let words = label.map_or_else(String::new, |l| l.text);
    value.context().push(error.at(span.unwrap_or(value.span()), words));
}

fn from_file(
    value: &Value<'_>,
    table: &Table<'_>,
    scale: Option<f64>,
    folder: &Path,
) -> Option<Profile> {
    let name = value.string()?;
    let path = folder.join(name);
    let format = ProfileFormat::from_path(&path);
    let mut options = ProfileOptions { scale: scale.filter(|s| *s != 1.0), ..Default::default() };
    let mut good = scale.is_some();
    // Asking only for what has a meaning makes the rest unknown keys. In a file of an unknown kind
    // everything may have one.
    if matches!(format, Some(ProfileFormat::Svg) | None) {
        let mut number = |key, bounds| {
            let value = table.get(key)?;
            let number = value.number(bounds);
            good &= number.is_some();
            number
        };
        options.axis = number("axis", Bounds::ANY);
        options.base = number("base", Bounds::ANY);
        options.snap = number("snap", Bounds::NOT_NEGATIVE);
        if let Some(value) = table.get("id") {
            options.id = value.string().map(Into::into);
            good &= options.id.is_some();
        }
        if let Some(value) = table.get("unit") {
            options.unit = value.choice("unit of length", &Unit::NAMES);
            good &= options.unit.is_some();
        }
    }
    if matches!(format, Some(ProfileFormat::Csv) | None) {
        let found = spline(table);
        good &= found.is_some();
        options.spline = found.flatten();
    }
    if !good {
        return None;
    }
    let read = read_profile(&path, &options);
    read.map_err(|report| value.context().absorb(report, value.span())).ok()
}

fn from_points(value: &Value<'_>, table: &Table<'_>, scale: Option<f64>) -> Option<Profile> {
    let spline = spline(table);
    let rows = value
        .items("an array of points [r, z]")?
        .iter()
        .map(|item| {
            let [r, z] = item.numbers(Bounds::ANY)?;
            Some(points::Row { point: Point::new(r, z), span: item.span() })
        })
        // Through a list first: all bad points are reported, not the first.
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Option<Vec<_>>>()?;
    points::through(&rows, spline?.unwrap_or(Spline::Polyline), scale?)
        .map_err(|error| {
            let whole = error.labels.is_empty();
            value.context().push(if whole { error.at(value.span(), "") } else { error });
        })
        .ok()
}

//! The film and the camera.

use rondure::Vec3;

use crate::{
    Camera, Diagnostic, Film, FilterKind, Integrator, Key, Lens, PixelFilter, Projection,
    ViewTransform, WhiteBalance,
    decode::{Bounds, Context, SMALLEST, Table, Value},
    journey::is_parallel,
};

use super::key;

/// The most reflections and refractions: as many as the renderer follows.
const DEEPEST: u32 = 200;

/// The most pixels along an edge: the number of pixels still fits a u32.
const LARGEST_EDGE: u32 = 65_535;

pub(super) fn film(table: Option<Table<'_>>) -> Film {
    let mut film = Film::default();
    let Some(table) = table else { return film };
    if let Some((width, height)) = table.get("size").and_then(|v| size(&v)) {
        (film.width, film.height) = (width, height);
    }
    let whole = |key, least, most, default| {
        table.get(key).and_then(|v| v.whole(least, most)).unwrap_or(default)
    };
    film.spp = whole("spp", 1, 1 << 20, film.spp);
    film.depth = whole("depth", 0, DEEPEST, film.depth);
    film.bits = table.get("bits").and_then(|v| bits(&v)).unwrap_or(film.bits);
    film.exposure = table.number("exposure", Bounds::POSITIVE).unwrap_or(film.exposure);
    let integrator = table.get("integrator").and_then(|v| v.choice("integrator", &Integrator::ALL));
    film.integrator = integrator.unwrap_or_default();
    film.filter = filter(&table);
    film.view = table.get("view").and_then(|v| v.choice("view", &VIEWS)).unwrap_or(film.view);
    film.white = white(&table);
    table.finish();
    film
}

/// From a point to a blur over a hundred pixels.
const RADII: Bounds = Bounds::new(|x| (0.0..=50.0).contains(&x), "from 0 to 50 pixels");

fn filter(table: &Table<'_>) -> PixelFilter {
    let kind = table.get("filter").and_then(|v| v.choice("filter", &FilterKind::ALL));
    let filter = kind.map_or_else(PixelFilter::default, FilterKind::usual);
    let radius = table.get("filter_radius").and_then(|v| v.number(RADII));
    PixelFilter { radius: radius.unwrap_or(filter.radius), ..filter }
}

const VIEWS: [(&str, ViewTransform); 3] = [
    ("srgb", ViewTransform::Srgb),
    ("agx", ViewTransform::AgX),
    ("neutral", ViewTransform::Neutral),
];

/// Colour temperatures that the loci of daylight and black bodies are known for.
const TEMPERATURES: Bounds =
    Bounds::new(|x| (1000.0..=25_000.0).contains(&x), "from 1000 to 25000 kelvin");
const TINTS: Bounds = Bounds::new(|x| (-150.0..=150.0).contains(&x), "from -150 to 150");

fn white(table: &Table<'_>) -> Option<WhiteBalance> {
    let (temperature, tint) = (table.get("white_balance"), table.get("tint"));
    if temperature.is_none() && tint.is_none() {
        return None;
    }
    let white = WhiteBalance::default();
    let temperature = temperature.map_or(Some(white.temperature), |v| v.number(TEMPERATURES));
    let tint = tint.map_or(Some(white.tint), |v| v.number(TINTS));
    Some(WhiteBalance { temperature: temperature?, tint: tint? })
}

fn size(value: &Value<'_>) -> Option<(u32, u32)> {
    let items = value.items("an array of width and height")?;
    let [width, height] = items.as_slice() else {
        return value.fail(format!("`size` is [width, height], not {} numbers", items.len()));
    };
    let (width, height) = (width.whole(1, LARGEST_EDGE), height.whole(1, LARGEST_EDGE));
    Some((width?, height?))
}

fn bits(value: &Value<'_>) -> Option<u8> {
    match value.whole(0, u32::MAX)? {
        8 => Some(8),
        16 => Some(16),
        _ => value.fail("`bits` must be 8 or 16"),
    }
}

/// Degrees between which the field of view lies.
pub(super) const FIELD_OF_VIEW: Bounds =
    Bounds::new(|x| x > 0.0 && x < 180.0, "more than 0 and less than 180 degrees");

pub(super) fn camera(value: Option<Value<'_>>, cx: &Context<'_>) -> Option<(Camera, Vec<Key>)> {
    let Some(value) = value else {
        let help = "write a table [camera] with `eye = [x, y, z]` and `look_at = [x, y, z]`";
        cx.push(Diagnostic::error("the scene has no camera").help(help));
        return None;
    };
    let table = value.table("a camera")?;
    let eye = table.require("eye").and_then(|v| v.vector());
    let look_at = table.require("look_at").and_then(|v| v.vector());
    let up = match table.get("up") {
        Some(v) => v.direction(),
        None => Some(Vec3::Z),
    };
    #[derive(Clone, Copy)]
    enum Kind {
        Perspective,
        Orthographic,
    }
    const KINDS: [(&str, Kind); 2] =
        [("perspective", Kind::Perspective), ("orthographic", Kind::Orthographic)];
    let kind = match table.get("projection") {
        Some(v) => v.choice("projection", &KINDS),
        None => Some(Kind::Perspective),
    };
    // With an unknown projection, the keys of both are known.
    let fov = match kind {
        Some(Kind::Orthographic) => None,
        _ => match table.get("fov") {
            Some(v) => v.number(FIELD_OF_VIEW),
            None => Some(40.0),
        },
    };
    let height = match kind {
        Some(Kind::Perspective) => None,
        Some(Kind::Orthographic) => {
            table.require("height").and_then(|v| v.number(Bounds::POSITIVE))
        }
        None => table.number("height", Bounds::POSITIVE),
    };
    let radius = table.number("lens_radius", Bounds::NOT_NEGATIVE);
    let focus = table.number("focus", Bounds::POSITIVE);
    if let (true, Some(key)) = (!table.has("lens_radius"), table.key_span("focus")) {
        let warning = Diagnostic::warning("`focus` has no meaning without a `lens_radius`");
        cx.push(warning.at(key, "all distances are in focus"));
    }
    check_view(&table, eye, look_at, up, cx);
    let keys = table.get("key");
    table.finish();
    let (eye, look_at) = (eye?, look_at?);
    let projection = match kind? {
        Kind::Perspective => Projection::Perspective { fov: fov?.to_radians() },
        Kind::Orthographic => Projection::Orthographic { height: height? },
    };
    let lens = radius
        .filter(|r| *r > 0.0)
        .map(|radius| Lens { radius, focus: focus.unwrap_or((look_at - eye).length()) });
    let camera = Camera { eye, look_at, up: up?, projection, lens };
    let keys = key::keys(keys, &camera, focus);
    Some((camera, keys))
}

fn check_view(
    table: &Table<'_>,
    eye: Option<Vec3>,
    look_at: Option<Vec3>,
    up: Option<Vec3>,
    cx: &Context<'_>,
) {
    let (Some(eye), Some(look_at)) = (eye, look_at) else { return };
    let view = look_at - eye;
    let span = |key: &'static str| table.get(key).map_or_else(|| table.span(), |v| v.span());
    if view.max_abs() == 0.0 || !view.is_finite() {
        let error =
            Diagnostic::error("the camera looks nowhere: `eye` and `look_at` are one point");
        cx.push(error.at(span("look_at"), "").and_at(span("eye"), ""));
        return;
    }
    if view.max_abs() < SMALLEST {
        let message = format!("`eye` and `look_at` are less than {SMALLEST:e} apart");
        let error = Diagnostic::error(message).at(span("look_at"), "").and_at(span("eye"), "");
        cx.push(error.help("measure the scene in a smaller unit of length"));
        return;
    }
    let Some(up) = up else { return };
    if is_parallel((view / view.max_abs()).normalized(), up) {
        let error = Diagnostic::error("the camera looks along its own `up`");
        let error = match table.get("up") {
            Some(v) => error.at(v.span(), "parallel to the view"),
            None => error.at(span("look_at"), "the view is parallel to the z axis"),
        };
        cx.push(
            error.help("give an `up` that is not parallel to the line from `eye` to `look_at`"),
        );
    }
}

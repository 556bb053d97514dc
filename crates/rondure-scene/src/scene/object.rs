//! The things in the scene.

use std::{collections::HashMap, ops::Range};

use rondure::{Affine, Instance, Vec3};

use super::{
    liquid::{self, Liquid},
    material::Materials,
    placement, section,
    shared::Profiles,
    solid::{self, Sources},
    sweep,
};
use crate::{
    Copies, Cut, Diagnostic, Material, Motion, Object, Shape,
    decode::{Bounds, Context, Table},
};

pub(super) fn objects(
    tables: Vec<Table<'_>>,
    materials: &mut Materials,
    profiles: &mut Profiles,
) -> Vec<Object> {
    let mut all = Vec::new();
    let mut names = HashMap::new();
    for (i, table) in tables.into_iter().enumerate() {
        let cx = table.context();
        let name = table.get("name").and_then(|v| Some((v.string()?.to_owned(), v.span())));
        if let Some((name, span)) = &name {
            check_name(cx, &mut names, name, span.clone());
        }
        let name = name.map_or_else(|| format!("object {}", i + 1), |(name, _)| name);
        all.extend(object(table, i + 1, name, materials, profiles).into_iter().flatten());
    }
    all
}

fn check_name(
    cx: &Context<'_>,
    names: &mut HashMap<String, Range<usize>>,
    name: &str,
    span: Range<usize>,
) {
    match names.get(name) {
        Some(first) => cx.push(
            Diagnostic::error(format!("two objects have the name `{name}`"))
                .at(span, "the second")
                .and_at(first.clone(), "the first"),
        ),
        None => {
            names.insert(name.into(), span);
        }
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Turned,
    Plane,
    Disk,
    Rectangle,
    Sphere,
    Solid(solid::Kind),
}

const KINDS: [(&str, Kind); 7] = [
    ("turned", Kind::Turned),
    ("plane", Kind::Plane),
    ("disk", Kind::Disk),
    ("rectangle", Kind::Rectangle),
    ("sphere", Kind::Sphere),
    ("box", Kind::Solid(solid::Kind::Box)),
    ("half-space", Kind::Solid(solid::Kind::HalfSpace)),
];

/// An object, the `number`-th of the scene, and the liquid in it as another.
fn object(
    mut table: Table<'_>,
    number: usize,
    name: String,
    materials: &mut Materials,
    profiles: &mut Profiles,
) -> Option<Vec<Object>> {
    let is_named = table.has("material");
    let material = materials.find(table.get("material"));
    // What a solid's own parts inherit.
    let named = material.filter(|_| is_named);
    let kind = match table.get("type") {
        Some(v) => {
            let kind = v.choice("type of object", &KINDS)?;
            table.call(format!("a {}", v.as_str().unwrap_or_default()));
            if matches!(kind, Kind::Turned) {
                table.call("a turned object");
            }
            kind
        }
        None => match solid::operation(&table)? {
            Some(operation) => {
                table.call("a compound solid");
                Kind::Solid(solid::Kind::Compound(operation))
            }
            None => {
                table.call("a turned object");
                Kind::Turned
            }
        },
    };
    let copies = placement::copies(&table, number);
    let mut liquid = None;
    let shape = match kind {
        Kind::Turned => turned(&table, [material, named], materials, profiles).map(|turned| {
            liquid = turned.1;
            turned.0
        }),
        Kind::Solid(kind) => {
            let mut sources = Sources { number, materials, profiles };
            solid::body(&table, kind, named, &mut sources).map(Shape::Body)
        }
        _ => flat_or_round(&table, kind),
    };
    let section = section::of_object(&table, materials);
    if let (Some(shape), Some(copies)) = (&shape, &copies) {
        check_sizes(&table, shape, copies);
    }
    if let (Some(shape), Some(material)) = (&shape, material) {
        warn_about_open_glass(&table, shape, materials.get(material));
    }
    table.finish();
    let (shape, material, copies) = (shape?, material?, copies?);
    let section = section?;
    let mut all = Vec::new();
    if let (Some(Liquid { surface, material }), Shape::Turned(vessel)) = (liquid, &shape) {
        // Its cut face is its own.
        let section = match section {
            Cut::Open { .. } => Cut::Open { material: None },
            Cut::Whole => Cut::Whole,
        };
        let shape = Shape::Turned(Instance::new(surface, *vessel.placement())?);
        let (name, copies) = (format!("liquid in {name}"), copies.clone());
        all.push(Object { name, shape, material, copies, section });
    }
    all.insert(0, Object { name, shape, material, copies, section });
    Some(all)
}

/// A turned object and what it is filled with. `named` is the material that the object names, if it does.
fn turned(
    table: &Table<'_>,
    [material, named]: [Option<usize>; 2],
    materials: &mut Materials,
    profiles: &mut Profiles,
) -> Option<(Shape, Option<Liquid>)> {
    let surface = table.require("profile").and_then(|v| profiles.find(&v));
    let surface = sweep::capped(table, surface, profiles);
    let sweeping = sweep::sweeping(table, materials);
    let liquid = liquid::filled(table, surface.as_ref(), material, materials);
    let (surface, placement) = (surface, placement::placement(table)?);
    let (surface, sweeping, liquid) = (surface?, sweeping?, liquid?);
    if let Some(closed) = sweeping.as_ref().filter(|s| s.open.is_none()) {
        let body = solid::swept(table, &surface, closed, named, placement)?;
        return Some((Shape::Body(body), None));
    }
    let instance = Instance::new(surface, placement);
    if instance.is_none() {
        report_extreme_placement(table);
    }
    let instance = instance?;
    Some(match sweeping {
        Some(open) => (Shape::Swept { instance, sweep: open.sweep }, None),
        None => (Shape::Turned(instance), liquid),
    })
}

/// Whether the largest and the smallest copy, too, can be placed.
fn check_sizes(table: &Table<'_>, shape: &Shape, copies: &Copies) {
    let sizes = copies.variation.map_or([1.0; 2], |v| v.scale);
    let position = shape.position();
    let first = copies.motion(0, position);
    let fits = |scale: f64| {
        let map = first.map.after(&Affine::scale(Vec3::splat(scale / first.scale)));
        match shape.moved(&Motion { map, scale }) {
            Some(Shape::Body(body)) => body.placed().build().is_ok(),
            moved => moved.is_some(),
        }
    };
    if let Shape::Body(body) = shape {
        check_number(table, solid::primitives(&body.csg), copies);
    }
    if !sizes.into_iter().all(fits) {
        report_extreme_placement(table);
    }
}

/// Whether there are not too many copies of a solid made of others.
fn check_number(table: &Table<'_>, primitives: usize, copies: &Copies) {
    let count = copies.count().saturating_mul(primitives as u64);
    if count > solid::MOST_IN_COPIES {
        let span = table.key_span("repeat").unwrap_or(table.span());
        table.context().push(
            Diagnostic::error(format!("the copies of this solid have {count} primitives"))
                .at(span, "")
                .help(format!("at most {} can be handled", solid::MOST_IN_COPIES)),
        );
    }
}

fn report_extreme_placement(table: &Table<'_>) {
    let span = ["scale", "vary", "position"].iter().find_map(|key| table.key_span(key));
    table.context().push(
        Diagnostic::error("the placement cannot be inverted in f64 arithmetic")
            .at(span.unwrap_or(table.span()), "")
            .help("the object is too large, too small, too flat or too far away"),
    );
}

fn flat_or_round(table: &Table<'_>, kind: Kind) -> Option<Shape> {
    let position = table.get("position").map_or(Some(Vec3::ZERO), |v| v.vector());
    let normal = || table.get("normal").map_or(Some(Vec3::Z), |v| v.direction());
    let radius = || table.require("radius").and_then(|v| v.number(Bounds::POSITIVE));
    match kind {
        Kind::Turned | Kind::Solid(_) => None,
        Kind::Plane => position.zip(normal()).map(|(point, normal)| Shape::Plane { point, normal }),
        Kind::Disk => {
            let (normal, radius) = (normal(), radius());
            let (center, normal, radius) = (position?, normal?, radius?);
            Some(Shape::Disk { center, normal, radius })
        }
        Kind::Rectangle => {
            let normal = normal();
            let size = table.require("size").and_then(|v| v.numbers::<2>(Bounds::POSITIVE));
            let rotation = match table.get("rotation") {
                Some(v) => v.number(Bounds::ANY),
                None => Some(0.0),
            };
            let (center, normal, [width, height]) = (position?, normal?, size?);
            let frame =
                Affine::align_z(normal).after(&Affine::rotate(Vec3::Z, rotation?.to_radians()));
            let edges = [frame.vector(Vec3::X) * width, frame.vector(Vec3::Y) * height];
            Some(Shape::Rectangle { center, edges })
        }
        Kind::Sphere => {
            let radius = radius();
            Some(Shape::Sphere { center: position?, radius: radius? })
        }
    }
}

fn warn_about_open_glass(table: &Table<'_>, shape: &Shape, material: Option<&Material>) {
    let (Some(Material::Glass(_)), Shape::Turned(instance) | Shape::Swept { instance, .. }) =
        (material, shape)
    else {
        return;
    };
    if !instance.surface().bounds_solid() {
        let span = table.key_span("profile").unwrap_or(table.span());
        table.context().push(
            Diagnostic::warning("this glass has no inside: its profile is open")
                .at(span, "neither closed nor with both ends on the axis")
                .help("draw the thickness of the glass too, or close the profile with Z"),
        );
    } else if matches!(shape, Shape::Swept { .. }) {
        let span = table.key_span("sweep").unwrap_or(table.span());
        table.context().push(
            Diagnostic::warning("this glass has no inside: its sweep is left open")
                .at(span, "")
                .help("without `open` the sweep is closed by its two plane faces"),
        );
    }
}

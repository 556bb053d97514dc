//! Solids made of others: `union`, `intersection` and `difference`, and what they are made of.

use std::{ops::Range, sync::Arc};

use rondure::{
    Affine, Bounds as Extent, FillRule, Solid, Surface, Vec3,
    solid::{Compound, Csg, CsgError},
};

use super::{
    material::Materials,
    placement,
    shared::Profiles,
    sweep::{self, Sweeping},
};
use crate::{
    Body, Copies, Diagnostic,
    decode::{Bounds, Table, Value},
};

/// The most primitives in one solid: a ray that comes near asks all of them.
const MOST_PRIMITIVES: u64 = 1000;
/// The most primitives in all copies of one solid.
pub(super) const MOST_IN_COPIES: u64 = 1_000_000;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    Union,
    Intersection,
    Difference,
}

const OPERATIONS: [(&str, Operation); 3] = [
    ("union", Operation::Union),
    ("intersection", Operation::Intersection),
    ("difference", Operation::Difference),
];

/// The solids that are not described by a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Box,
    HalfSpace,
    Compound(Operation),
}

/// The operation of a table without a `type`, if it has one; `None` after an error.
pub(super) fn operation(table: &Table<'_>) -> Option<Option<Operation>> {
    let mut found = None;
    let mut good = true;
    let mut first = table.has("profile").then_some("profile");
    for (key, operation) in OPERATIONS {
        if table.get(key).is_some() {
            good &= first.is_none_or(|first| table.exclude(first, key).is_none());
            first.get_or_insert(key);
            found.get_or_insert(operation);
        }
    }
    good.then_some(found)
}

/// What names an object's or an operand's materials and profiles, and its random numbers.
pub(super) struct Sources<'a> {
    /// The number of the object in the scene.
    pub(super) number: usize,
    pub(super) materials: &'a mut Materials,
    pub(super) profiles: &'a mut Profiles,
}

/// An expression, and what is known about each of its primitives.
struct Part {
    csg: Csg,
    materials: Vec<Option<usize>>,
    spans: Vec<Range<usize>>,
}

impl Part {
    /// An expression whose primitives all have the same material.
    fn uniform(csg: Csg, material: Option<usize>, span: Range<usize>) -> Self {
        let count = primitives(&csg);
        Self { csg, materials: vec![material; count], spans: vec![span; count] }
    }
}

/// A solid as an object: `material` is the one that it names.
pub(super) fn body(
    table: &Table<'_>,
    kind: Kind,
    material: Option<usize>,
    sources: &mut Sources<'_>,
) -> Option<Body> {
    let part = part(table, kind, material, sources);
    let placement = place(table, kind);
    finish(table, part?, placement?)
}

/// A turned solid swept over a part of the turn, as an object.
pub(super) fn swept(
    table: &Table<'_>,
    surface: &Arc<Surface>,
    sweeping: &Sweeping,
    material: Option<usize>,
    placement: Affine,
) -> Option<Body> {
    let part = turned(table, surface, Some(sweeping), material)?;
    finish(table, part, placement)
}

/// The body, if it can be built.
fn finish(table: &Table<'_>, part: Part, placement: Affine) -> Option<Body> {
    let Part { csg, materials, spans } = part;
    match csg.clone().placed(&placement).build() {
        Err(error) => {
            refuse(table, &error, &spans);
            None
        }
        Ok(compound) => {
            if is_empty(&compound) {
                let span = table.key_span("intersection").unwrap_or(table.span());
                let warning = Diagnostic::warning("there is nothing in this solid");
                table.context().push(
                    warning
                        .at(span, "the boxes round its operands do not meet")
                        .help("a half space is the side to which its normal does not point"),
                );
            }
            Some(Body { csg: Arc::new(csg), materials: materials.into(), placement })
        }
    }
}

fn is_empty(compound: &Compound) -> bool {
    let Extent { min, max } = compound.bounds();
    min.x > max.x || min.y > max.y || min.z > max.z
}

fn refuse(table: &Table<'_>, error: &CsgError, spans: &[Range<usize>]) {
    let leaf = match error {
        CsgError::Placement { leaf }
        | CsgError::HalfSpace { leaf, .. }
        | CsgError::Cuboid { leaf, .. } => Some(*leaf),
        _ => None,
    };
    let span = leaf.and_then(|leaf| spans.get(leaf).cloned()).unwrap_or(table.span());
    table.context().push(
        Diagnostic::error("the placement cannot be inverted in f64 arithmetic")
            .at(span, "")
            .help("the solid is too large, too small, too flat or too far away"),
    );
}

/// Where a solid that is no turned one stands.
fn place(table: &Table<'_>, kind: Kind) -> Option<Affine> {
    match kind {
        Kind::HalfSpace => match table.get("position") {
            Some(v) => v.vector().map(Affine::translate),
            None => Some(Affine::IDENTITY),
        },
        _ => placement::placement(table),
    }
}

/// The solid in its own frame.
fn part(
    table: &Table<'_>,
    kind: Kind,
    material: Option<usize>,
    sources: &mut Sources<'_>,
) -> Option<Part> {
    let primitive = |csg| Part::uniform(csg, material, table.span());
    match kind {
        Kind::Box => {
            let size = table.require("size").and_then(|v| v.numbers::<3>(Bounds::POSITIVE));
            let half = size.map(|[x, y, z]| Vec3::new(x, y, z) * 0.5)?;
            let bounds = Extent { min: half * -1.0, max: half };
            Some(primitive(Csg::cuboid(bounds)))
        }
        Kind::HalfSpace => {
            let normal = table.get("normal").map_or(Some(Vec3::Z), |v| v.direction());
            Some(primitive(Csg::half_space(Vec3::ZERO, normal?)))
        }
        Kind::Compound(operation) => compound(table, operation, material, sources),
    }
}

fn compound(
    table: &Table<'_>,
    operation: Operation,
    material: Option<usize>,
    sources: &mut Sources<'_>,
) -> Option<Part> {
    let (key, _) = OPERATIONS.into_iter().find(|(_, o)| *o == operation)?;
    let value = table.get(key)?;
    let items = value.items("an array of solids")?;
    if items.is_empty() {
        let help = "write each as a table, as in [{profile = \"vase\"}, {type = \"box\", size = [1, 1, 1]}]";
        return value.fail_with_help(format!("`{key}` has no operands"), help.into());
    }
    let parts: Vec<_> = items.iter().map(|item| operand(item, material, sources)).collect();
    let parts: Vec<Part> = parts.into_iter().collect::<Option<_>>()?;
    let count: usize = parts.iter().map(|part| part.materials.len()).sum();
    if count as u64 > MOST_PRIMITIVES {
        return too_many(&value, count as u64);
    }
    let mut whole = Part { csg: Csg::Union(Vec::new()), materials: Vec::new(), spans: Vec::new() };
    let mut operands = Vec::with_capacity(parts.len());
    for part in parts {
        operands.push(part.csg);
        whole.materials.extend(part.materials);
        whole.spans.extend(part.spans);
    }
    whole.csg = match operation {
        Operation::Union => Csg::Union(operands),
        Operation::Intersection => Csg::Intersection(operands),
        Operation::Difference => Csg::Difference(operands),
    };
    Some(whole)
}

fn too_many<T>(value: &Value<'_>, count: u64) -> Option<T> {
    value.fail_with_help(
        format!("{count} primitives in one solid"),
        format!(
            "a solid can be made of {MOST_PRIMITIVES}, each copy counted; what needs not be cut can be an \
             object of its own"
        ),
    )
}

/// What an operand can be.
#[derive(Clone, Copy)]
enum Operand {
    Turned,
    Sphere,
    Other(Kind),
}

const OPERANDS: [(&str, Operand); 4] = [
    ("turned", Operand::Turned),
    ("sphere", Operand::Sphere),
    ("box", Operand::Other(Kind::Box)),
    ("half-space", Operand::Other(Kind::HalfSpace)),
];

/// The types of objects that bound no solid.
const FLAT: [&str; 3] = ["plane", "disk", "rectangle"];

/// An operand in the frame of the solid that it belongs to; `inherited` is that solid's material.
fn operand(value: &Value<'_>, inherited: Option<usize>, sources: &mut Sources<'_>) -> Option<Part> {
    let mut table = value.table("an operand")?;
    let material = match table.get("material") {
        Some(v) => sources.materials.find(Some(v)).map(Some),
        None => Some(inherited),
    };
    let kind = match table.get("type") {
        Some(v) => {
            let name = v.as_str().unwrap_or_default();
            if FLAT.contains(&name) {
                return v.fail_with_help(
                    format!("a {name} bounds no solid"),
                    "a half space ends at a plane: type = \"half-space\"".into(),
                );
            }
            let kind = v.choice("type of solid", &OPERANDS)?;
            table.call(format!("a {name}"));
            kind
        }
        None => match operation(&table)? {
            Some(operation) => {
                table.call("a compound solid");
                Operand::Other(Kind::Compound(operation))
            }
            None => Operand::Turned,
        },
    };
    if matches!(kind, Operand::Turned) {
        table.call("a turned operand");
    }
    let copies = placement::copies(&table, sources.number);
    // What cannot be read has been told; to read on finds what else is wrong.
    let inherits = material.unwrap_or(inherited);
    let (part, placement) = match kind {
        Operand::Turned => {
            let surface = table.require("profile").and_then(|v| sources.profiles.find(&v));
            let surface = sweep::capped(&table, surface, sources.profiles);
            let sweeping = sweep::sweeping(&table, sources.materials);
            let placement = placement::placement(&table);
            let part = surface.zip(sweeping).and_then(|(surface, sweeping)| {
                turned(&table, &surface, sweeping.as_ref(), inherits)
            });
            (part, placement)
        }
        Operand::Sphere => {
            let position = table.get("position").map_or(Some(Vec3::ZERO), |v| v.vector());
            let radius = table.require("radius").and_then(|v| v.number(Bounds::POSITIVE));
            let part = radius.map(|radius| {
                Part::uniform(Csg::sphere(Vec3::ZERO, radius), inherits, table.span())
            });
            (part, position.map(Affine::translate))
        }
        Operand::Other(kind) => (part(&table, kind, inherits, sources), place(&table, kind)),
    };
    table.finish();
    material?;
    copied(value, part?, placement?, &copies?)
}

/// All copies of an operand, as one.
fn copied(value: &Value<'_>, part: Part, placement: Affine, copies: &Copies) -> Option<Part> {
    let each = part.materials.len();
    let count = copies.count().saturating_mul(each as u64);
    if count > MOST_PRIMITIVES {
        return too_many(value, count);
    }
    let copy = |i| {
        let motion = copies.motion(i, placement.translation);
        part.csg.clone().placed(&motion.map.after(&placement))
    };
    if copies.count() == 1 {
        return Some(Part { csg: copy(0), ..part });
    }
    let times = copies.count() as usize;
    Some(Part {
        csg: Csg::Union((0..copies.count()).map(copy).collect()),
        materials: part.materials.repeat(times),
        spans: part.spans.iter().cloned().cycle().take(each * times).collect(),
    })
}

/// The solid that a profile bounds, or a part of its turn.
fn turned(
    table: &Table<'_>,
    surface: &Arc<Surface>,
    sweeping: Option<&Sweeping>,
    material: Option<usize>,
) -> Option<Part> {
    if let Some(span) = sweeping.and_then(|s| s.open.clone()) {
        table.context().push(
            Diagnostic::error("a sweep that is left open bounds no solid")
                .at(span, "")
                .help("an operand of a union, an intersection or a difference must be closed"),
        );
        return None;
    }
    match Solid::from_surface(Arc::clone(surface), FillRule::NonZero) {
        Ok(solid) => {
            let whole = Csg::turned(Arc::new(solid));
            let Some(sweeping) = sweeping else {
                return Some(Part::uniform(whole, material, table.span()));
            };
            let mut part = Part::uniform(whole.swept(&sweeping.sweep), material, table.span());
            // The solid itself is the first primitive, the faces are the others.
            for face in &mut part.materials[1..] {
                *face = sweeping.faces.or(material);
            }
            Some(part)
        }
        Err(_) => {
            let span = table.key_span("profile").unwrap_or(table.span());
            let caps = "close it with Z, let both ends lie on the axis, or add caps = true";
            let help = match sweeping {
                Some(_) => format!("{caps}; sweep = {{.., open = true}} leaves it open"),
                None => caps.into(),
            };
            table.context().push(
                Diagnostic::error("this profile bounds no solid")
                    .at(span, "neither closed nor with both ends on the axis")
                    .help(help),
            );
            None
        }
    }
}

/// How many primitives an expression has.
pub(super) fn primitives(csg: &Csg) -> usize {
    match csg {
        Csg::Primitive(..) => 1,
        Csg::Union(all) | Csg::Intersection(all) | Csg::Difference(all) => {
            all.iter().map(primitives).sum()
        }
    }
}

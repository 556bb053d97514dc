//! Materials, by name and inline.

use std::ops::Range;

use crate::{
    Color, Diagnostic, Material, Paint,
    decode::{Bounds, Context, Table, Value, suggest},
};

/// What an object is made of that does not say: light grey, matte.
const DEFAULT: Material = Material::Matte { color: Paint::Solid([0.8; 3]) };

/// The materials of a scene.
pub(super) struct Materials {
    /// In the order of the text; `None` if it had errors.
    named: Vec<Named>,
    all: Vec<Material>,
    default: Option<usize>,
}

struct Named {
    name: String,
    span: Range<usize>,
    index: Option<usize>,
    used: bool,
}

impl Materials {
    pub(super) fn read(table: Option<Table<'_>>) -> Self {
        let mut materials = Self { named: Vec::new(), all: Vec::new(), default: None };
        for (name, span, value) in table.iter().flat_map(Table::named) {
            let index = material(&value).map(|m| materials.add(m));
            materials.named.push(Named { name: name.into(), span, index, used: false });
        }
        materials
    }

    fn add(&mut self, material: Material) -> usize {
        self.all.push(material);
        self.all.len() - 1
    }

    /// The index of the material that a value names or describes.
    pub(super) fn find(&mut self, value: Option<Value<'_>>) -> Option<usize> {
        let Some(value) = value else {
            let next = self.all.len();
            let default = *self.default.get_or_insert(next);
            if default == next {
                self.all.push(DEFAULT);
            }
            return Some(default);
        };
        if value.is_table() {
            return material(&value).map(|m| self.add(m));
        }
        let Some(name) = value.as_str() else {
            return value.fail("expected the name of a material, or a table {type = ..}");
        };
        if let Some(named) = self.named.iter_mut().find(|n| n.name == name) {
            named.used = true;
            return named.index;
        }
        let message = format!("there is no material `{name}`");
        value.fail_with_help(
            message,
            match self.named.is_empty() {
                true => format!("describe it in a table [materials.{name}]"),
                false => suggest(name, self.named.iter().map(|n| &*n.name)),
            },
        )
    }

    pub(super) fn get(&self, index: usize) -> Option<&Material> {
        self.all.get(index)
    }

    pub(super) fn warn_unused(&self, cx: &Context<'_>) {
        for named in self.named.iter().filter(|n| !n.used) {
            let message = format!("the material `{}` is never used", named.name);
            cx.push(Diagnostic::warning(message).at(named.span.clone(), ""));
        }
    }

    pub(super) fn finish(self) -> Vec<Material> {
        self.all
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Matte,
    Glossy,
    Mirror,
    Glass,
}

const KINDS: [(&str, Kind); 4] = [
    ("matte", Kind::Matte),
    ("glossy", Kind::Glossy),
    ("mirror", Kind::Mirror),
    ("glass", Kind::Glass),
];

fn material(value: &Value<'_>) -> Option<Material> {
    let mut table = value.table("a material")?;
    let kind = match table.get("type") {
        Some(v) => {
            let kind = v.choice("material", &KINDS)?;
            table.call(format!("a {} material", v.as_str().unwrap_or_default()));
            kind
        }
        None => {
            table.call("a matte material");
            Kind::Matte
        }
    };
    let fraction = |key, default| match table.get(key) {
        Some(v) => v.number(Bounds::FRACTION),
        None => Some(default),
    };
    let material = match kind {
        Kind::Matte => paint(&table, [0.8; 3]).map(|color| Material::Matte { color }),
        Kind::Glossy => {
            let (specular, roughness) = (fraction("specular", 1.0), fraction("roughness", 0.1));
            paint(&table, [0.8; 3]).zip(specular).zip(roughness).map(
                |((color, specular), roughness)| Material::Glossy { color, specular, roughness },
            )
        }
        Kind::Mirror => paint(&table, [0.95; 3]).map(|color| Material::Mirror { color }),
        Kind::Glass => {
            let color = match table.get("color") {
                Some(v) => v.color(Bounds::FRACTION),
                None => Some([1.0; 3]),
            };
            let index = Bounds::new(|x| (1.0..=10.0).contains(&x), "from 1 to 10");
            let ior = match table.get("ior") {
                Some(v) => v.number(index),
                None => Some(1.5),
            };
            color.zip(ior).map(|(color, ior)| Material::Glass { color, ior })
        }
    };
    table.finish();
    material
}

/// One colour, or a checker of two.
fn paint(table: &Table<'_>, default: Color) -> Option<Paint> {
    let (color, checker) = (table.get("color"), table.get("checker"));
    match (color, checker) {
        (Some(_), Some(_)) => {
            table.exclude("color", "checker");
            None
        }
        (Some(v), None) => v.color(Bounds::FRACTION).map(Paint::Solid),
        (None, Some(v)) => squares(v.table("a checker")?),
        (None, None) => Some(Paint::Solid(default)),
    }
}

fn squares(table: Table<'_>) -> Option<Paint> {
    let colors = table.require("colors").and_then(|v| {
        let items = v.items("an array of two colours")?;
        match items.as_slice() {
            [a, b] => {
                let (a, b) = (a.color(Bounds::FRACTION), b.color(Bounds::FRACTION));
                Some([a?, b?])
            }
            _ => v.fail(format!("a checker has two colours, not {}", items.len())),
        }
    });
    let size = match table.get("size") {
        None => Some([1.0; 2]),
        Some(v) if v.is_array() => v.numbers(Bounds::POSITIVE),
        Some(v) => v.number(Bounds::POSITIVE).map(|x| [x, x]),
    };
    table.finish();
    Some(Paint::Checker { colors: colors?, size: size? })
}

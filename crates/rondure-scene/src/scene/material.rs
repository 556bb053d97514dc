//! Materials, by name and inline.

use std::ops::Range;

use super::paint::{paint, paint_of, relief};
use crate::{
    Color, Diagnostic, Glass, Material, Paint, Principled, Relief,
    decode::{Bounds, Context, Table, Value, suggest},
};

/// What an object is made of that does not say: light grey, matte.
const DEFAULT: Material = Material::Matte { color: Paint::Solid([0.8; 3]) };

/// The materials of a scene.
pub(super) struct Materials {
    /// In the order of the text; `None` if it had errors.
    named: Vec<Named>,
    all: Vec<(Material, Option<Relief>)>,
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

    fn add(&mut self, material: (Material, Option<Relief>)) -> usize {
        self.all.push(material);
        self.all.len() - 1
    }

    /// The index of the material that a value names or describes.
    pub(super) fn find(&mut self, value: Option<Value<'_>>) -> Option<usize> {
        let Some(value) = value else {
            let next = self.all.len();
            let default = *self.default.get_or_insert(next);
            if default == next {
                self.all.push((DEFAULT, None));
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
        self.all.get(index).map(|(material, _)| material)
    }

    /// The material of a liquid for which the wall of its vessel stands fast: the liquid's own, or a copy that
    /// gives way where both are clear.
    pub(super) fn giving_way(&mut self, liquid: usize, vessel: usize) -> usize {
        let Some(wall) = self.get(vessel).and_then(clear).map(|glass| glass.priority) else {
            return liquid;
        };
        let Some((mut material, relief)) = self.all.get(liquid).cloned() else { return liquid };
        let priority = match &mut material {
            Material::Glass(glass) => &mut glass.priority,
            Material::Principled(principled) => &mut principled.transmission.priority,
            _ => return liquid,
        };
        if *priority < wall {
            return liquid;
        }
        *priority = wall - 1;
        self.add((material, relief))
    }

    pub(super) fn warn_unused(&self, cx: &Context<'_>) {
        for named in self.named.iter().filter(|n| !n.used) {
            let message = format!("the material `{}` is never used", named.name);
            cx.push(Diagnostic::warning(message).at(named.span.clone(), ""));
        }
    }

    /// The materials, and the relief of each.
    pub(super) fn finish(self) -> (Vec<Material>, Vec<Option<Relief>>) {
        self.all.into_iter().unzip()
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Matte,
    Glossy,
    Mirror,
    Glass,
    Metal,
    Principled,
}

const KINDS: [(&str, Kind); 6] = [
    ("matte", Kind::Matte),
    ("glossy", Kind::Glossy),
    ("mirror", Kind::Mirror),
    ("glass", Kind::Glass),
    ("metal", Kind::Metal),
    ("principled", Kind::Principled),
];

/// The index of refraction of something clear.
const INDEX: Bounds = Bounds::new(|x| (1.0..=10.0).contains(&x), "from 1 to 10");
/// Abbe's number: that of real glass is from 20 to 90.
const ABBE: Bounds = Bounds::new(|x| (5.0..=1000.0).contains(&x), "from 5 to 1000");

/// A metal of which the index of refraction is known: its name, eta and k for red, green and blue.
type Measured = (Color, Color);

/// Indices of refraction at the primaries of Rec. 709, from the measurements in refractiveindex.info (Johnson
/// and Christy 1972 for the noble metals) as they go round among renderers.
const METALS: [(&str, Measured); 6] = [
    ("gold", ([0.143_119, 0.374_957, 1.442_479], [3.983_160, 2.385_721, 1.603_215])),
    ("silver", ([0.155_265, 0.116_723, 0.138_381], [4.828_343, 3.122_246, 2.147_050])),
    ("copper", ([0.200_438, 0.924_033, 1.102_212], [3.912_949, 2.452_848, 2.142_188])),
    ("aluminium", ([1.657_460, 0.880_369, 0.521_229], [9.223_869, 6.269_523, 4.837_001])),
    ("chromium", ([4.369_683, 2.916_702, 1.654_701], [5.206_434, 4.231_364, 3.754_947])),
    ("brass", ([0.444, 0.527, 1.094], [3.695, 2.765, 1.829])),
];

fn material(value: &Value<'_>) -> Option<(Material, Option<Relief>)> {
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
    let fraction = |key, default| number(&table, key, Bounds::FRACTION, default);
    let material = match kind {
        Kind::Matte => paint(&table, [0.8; 3]).map(|color| Material::Matte { color }),
        Kind::Glossy => {
            let (specular, roughness) = (fraction("specular", 1.0), fraction("roughness", 0.1));
            paint(&table, [0.8; 3]).zip(specular).zip(roughness).map(
                |((color, specular), roughness)| Material::Glossy { color, specular, roughness },
            )
        }
        Kind::Mirror => paint(&table, [0.95; 3]).map(|color| Material::Mirror { color }),
        Kind::Glass => glass(&table).map(Material::Glass),
        Kind::Metal => metal(&table),
        Kind::Principled => principled(&table).map(|p| Material::Principled(Box::new(p))),
    };
    let relief = relief(&table);
    table.finish();
    Some((material?, relief?))
}

/// What a material is as glass, if it is clear.
fn clear(material: &Material) -> Option<&Glass> {
    match material {
        Material::Glass(glass) => Some(glass),
        Material::Principled(principled) => {
            (principled.transmission_weight > 0.0).then_some(&principled.transmission)
        }
        _ => None,
    }
}

/// A number that may be missing; `None` if it is wrong.
fn number(table: &Table<'_>, key: &'static str, bounds: Bounds, default: f64) -> Option<f64> {
    match table.get(key) {
        Some(v) => v.number(bounds),
        None => Some(default),
    }
}

fn color(table: &Table<'_>, key: &'static str, bounds: Bounds, default: Color) -> Option<Color> {
    match table.get(key) {
        Some(v) => v.color(bounds),
        None => Some(default),
    }
}

fn abbe(table: &Table<'_>, key: &'static str) -> Option<Option<f64>> {
    match table.get(key) {
        Some(v) => v.number(ABBE).map(Some),
        None => Some(None),
    }
}

fn priority(table: &Table<'_>) -> Option<i32> {
    match table.get("priority") {
        Some(v) => v.whole(0, 1000).map(|priority| priority as i32),
        None => Some(0),
    }
}

fn glass(table: &Table<'_>) -> Option<Glass> {
    let color = color(table, "color", Bounds::FRACTION, [1.0; 3]);
    let ior = number(table, "ior", INDEX, 1.5);
    let roughness = number(table, "roughness", Bounds::FRACTION, 0.0);
    let (abbe, priority) = (abbe(table, "abbe"), priority(table));
    Some(Glass {
        color: color?,
        ior: ior?,
        roughness: roughness?,
        abbe: abbe?,
        priority: priority?,
    })
}

/// A metal by its name, or by its index of refraction.
fn metal(table: &Table<'_>) -> Option<Material> {
    let roughness = number(table, "roughness", Bounds::FRACTION, 0.0);
    let (name, eta) = (table.get("metal"), table.get("eta"));
    let measured = match (name, eta) {
        (Some(_), Some(_)) => {
            table.exclude("metal", "eta");
            None
        }
        (Some(name), None) => {
            if table.get("k").is_some() {
                table.exclude("metal", "k");
            }
            name.choice("metal", &METALS)
        }
        (None, Some(eta)) => {
            let eta = eta.numbers::<3>(Bounds::POSITIVE);
            eta.zip(table.require("k").and_then(|k| k.numbers::<3>(Bounds::NOT_NEGATIVE)))
        }
        (None, None) => {
            table.missing("metal");
            None
        }
    };
    let (eta, k) = measured?;
    Some(Material::Metal { eta, k, roughness: roughness? })
}

fn principled(table: &Table<'_>) -> Option<Principled> {
    let fraction = |key, default| number(table, key, Bounds::FRACTION, default);
    let base_color = paint_of(table, "base_color", "base_checker", [0.8; 3]);
    let (base_metalness, specular_weight) =
        (fraction("base_metalness", 0.0), fraction("specular_weight", 1.0));
    let (specular_roughness, specular_ior) =
        (fraction("specular_roughness", 0.3), number(table, "specular_ior", INDEX, 1.5));
    let transmission_weight = fraction("transmission_weight", 0.0);
    let transmission_color = color(table, "transmission_color", Bounds::FRACTION, [1.0; 3]);
    let depth = number(table, "transmission_depth", Bounds::POSITIVE, 1.0);
    let abbe = abbe(table, "transmission_dispersion_abbe_number");
    let priority = priority(table);
    let coat_weight = fraction("coat_weight", 0.0);
    let (coat_roughness, coat_ior) =
        (fraction("coat_roughness", 0.0), number(table, "coat_ior", INDEX, 1.6));
    let coat_color = color(table, "coat_color", Bounds::FRACTION, [1.0; 3]);
    let (fuzz_weight, fuzz_roughness) =
        (fraction("fuzz_weight", 0.0), number(table, "fuzz_roughness", FUZZ, 0.5));
    let fuzz_color = color(table, "fuzz_color", Bounds::FRACTION, [1.0; 3]);
    let emission_color = color(table, "emission_color", Bounds::NOT_NEGATIVE, [1.0; 3]);
    let luminance = number(table, "emission_luminance", Bounds::NOT_NEGATIVE, 0.0)?;
    let depth = depth?;
    Some(Principled {
        base_color: base_color?,
        base_metalness: base_metalness?,
        specular_weight: specular_weight?,
        specular_roughness: specular_roughness?,
        specular_ior: specular_ior?,
        transmission_weight: transmission_weight?,
        transmission: Glass {
            color: transmission_color?.map(|c| c.powf(1.0 / depth)),
            ior: specular_ior?,
            roughness: specular_roughness?,
            abbe: abbe?,
            priority: priority?,
        },
        coat_weight: coat_weight?,
        coat_roughness: coat_roughness?,
        coat_ior: coat_ior?,
        coat_color: coat_color?,
        fuzz_weight: fuzz_weight?,
        fuzz_color: fuzz_color?,
        fuzz_roughness: fuzz_roughness?,
        emission: emission_color?.map(|c| c * luminance),
    })
}

/// The roughness of fuzz, which as a smooth lobe would be infinitely narrow.
const FUZZ: Bounds = Bounds::new(|x| (0.1..=1.0).contains(&x), "from 0.1 to 1");

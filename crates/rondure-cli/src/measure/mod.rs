//! `rondure measure`: length, area, volume, centroid, inertia and capacity of a profile or of the
//! turned objects of a scene.

mod placed;
mod table;
mod units;

use std::io::{self, Write};

use clap::Args;
use rondure_scene::{Object, Shape};

use self::{
    placed::{Measured, Measurer, PlacedCavity},
    units::{LengthUnit, Units, Volume},
};
use crate::{failure::Failure, json::Json, profile::ProfileArgs, scene};

/// Print the length, area, volume, centroid and inertia of a profile or of the turned objects of a
/// scene, and what they hold
#[derive(Debug, Args)]
#[command(
    after_help = HELP,
    mut_arg("profile", |a| a
        .value_name("PROFILE|SCENE")
        .help("A profile (.path or .txt, .svg, .csv) or a scene (.toml)"))
)]
pub(crate) struct Measure {
    #[command(flatten)]
    profile: ProfileArgs,

    /// Scenes: measure this object alone, in full
    #[arg(long, value_name = "NAME")]
    object: Option<String>,

    /// The unit that lengths are in, so that litres and grams can be told
    #[arg(long = "in", value_name = "UNIT", value_enum)]
    length_unit: Option<LengthUnit>,

    /// The mass of the cubic unit; with --in, in g/cm³
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = positive)]
    density: Option<f64>,

    /// Print how much liquid stands at this height; may be repeated
    #[arg(long = "level", value_name = "Z", allow_negative_numbers = true, value_parser = finite)]
    levels: Vec<f64>,

    /// Print at which height this much liquid stands, in cubic units, ml, cl or l (as in 250ml); may
    /// be repeated
    #[arg(long = "volume", value_name = "V", allow_hyphen_values = true, value_parser = units::volume)]
    volumes: Vec<Volume>,

    /// Print JSON, with all digits and bounds for the errors
    #[arg(long)]
    json: bool,
}

const HELP: &str = "\
What is measured:
  length     of the profile as it was drawn
  area       of the surface that it sweeps; of walls with a thickness, both sides
  volume     of the solid that the surface encloses
  centroid   of the solid
  inertia    about axes through the centroid parallel to x, y and z; of density 1 if none is given
  capacity   of a vessel that stands upright: what it holds when liquid is poured in along its axis,
             up to the brim. Pockets of air that cannot escape stay empty.

  Of scenes: turned objects that go all the way round, whole, even where a section cuts them.

Units:
  Everything is in the unit of the profile or the scene. With --in, liquid is told in ml or l, mass
  in g or kg. In JSON all lengths and volumes stay in that unit; mass is in g, if there is --in.

Examples:
  rondure measure goblet.path
  rondure measure goblet.svg --svg-id goblet --axis 60 --unit cm --density 2.5 --volume 200ml
  rondure measure bowl.csv --spline natural --in mm --level 40 --level 50
  rondure measure still-life.toml --in cm
  rondure measure still-life.toml --object bottle --json";

fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("expected a number".into()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|x| *x > 0.0).ok_or_else(|| "expected a positive number".into())
}

impl Measure {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let units = self.units()?;
        let is_scene = self.profile.path().extension().is_some_and(|e| e == "toml");
        let text = if is_scene { self.scene(&units)? } else { self.alone(&units)? };
        writeln!(io::stdout().lock(), "{text}").map_err(|error| Failure::output(&error))
    }

    /// The unit of length and what follows from it.
    fn units(&self) -> Result<Units, Failure> {
        let drawn = self.profile.unit().and_then(LengthUnit::of);
        if let (Some(drawn), Some(given)) = (self.profile.unit(), self.length_unit)
            && LengthUnit::of(drawn) != Some(given)
        {
            return Err(Failure::new(
                "--unit and --in name different units",
                "with --unit mm, cm, m or in, lengths are in that unit, and --in is not needed",
            ));
        }
        let units = Units { length: self.length_unit.or(drawn), density: self.density };
        if let Some(volume) = self.volumes.iter().find(|v| v.in_units(&units).is_none()) {
            return Err(Failure::new(
                format!("`{volume}` cannot be told in cubic units"),
                "say with --in mm, cm, m or in which unit lengths are in",
            ));
        }
        Ok(units)
    }

    fn alone(&self, units: &Units) -> Result<String, Failure> {
        if self.object.is_some() {
            return Err(Failure::new(
                "--object is for scenes",
                "a profile file has but one profile; leave --object away",
            ));
        }
        let profile = self.profile.read()?;
        let name = self.profile.path().display().to_string();
        let measured = Measured::alone(name, &profile.measure());
        Ok(if self.json {
            let mut fields = vec![("profile", measured.name.as_str().into())];
            fields.extend(self.json(&measured, units));
            Json::Object(fields).to_string()
        } else {
            table::in_full(&measured, units, &self.queries(units))
        })
    }

    fn scene(&self, units: &Units) -> Result<String, Failure> {
        if let Some(option) = self.profile.any_option() {
            return Err(Failure::new(
                format!("{option} is for profiles, and this is a scene"),
                "in a scene each profile says itself how it is read",
            ));
        }
        let path = self.profile.path();
        let scene = scene::read(path)?;
        let turned = scene.objects.iter().flat_map(copies);
        let turned: Vec<_> = match &self.object {
            None => turned.collect(),
            Some(name) => {
                let all: Vec<_> = turned.collect();
                let found = all.iter().find(|(own, _)| own == name).cloned();
                vec![found.ok_or_else(|| unknown(name, all.iter().map(|(own, _)| own.as_str())))?]
            }
        };
        let mut measurer = Measurer::default();
        let objects: Vec<_> =
            turned.iter().map(|(name, shape)| measurer.shape(name, shape)).collect();
        if self.json {
            let objects = objects.iter().map(|measured| {
                let mut fields = vec![("name", measured.name.as_str().into())];
                fields.extend(self.json(measured, units));
                Json::Object(fields)
            });
            let fields = vec![
                ("scene", path.display().to_string().as_str().into()),
                ("objects", Json::List(objects.collect())),
            ];
            return Ok(Json::Object(fields).to_string());
        }
        Ok(match (&self.object, objects.first()) {
            (Some(_), Some(measured)) => table::in_full(measured, units, &self.queries(units)),
            (_, None) => format!("{}: no turned objects", path.display()),
            _ => table::side_by_side(&objects, units, &self.queries(units)),
        })
    }

    /// What is asked about levels, in the order: levels, volumes.
    fn queries(&self, units: &Units) -> Vec<Query> {
        let levels = self.levels.iter().map(|z| Query::Level(*z));
        let volumes = self.volumes.iter().filter_map(|v| v.in_units(units).map(Query::Volume));
        levels.chain(volumes).collect()
    }

    fn json(&self, measured: &Measured, units: &Units) -> Vec<(&'static str, Json)> {
        let density = units.in_cubic_units();
        let solid = measured.solid.as_ref();
        let cavity = measured.cavity.as_ref();
        let sheet = measured.sheet.as_ref();
        let inertia = |t: [[f64; 3]; 3]| {
            let names = [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2)];
            let products = [("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)];
            let entry = |(name, i, j): (_, usize, usize)| (name, (density * t[i][j]).into());
            Json::Object(names.into_iter().chain(products).map(entry).collect())
        };
        let queries = self.queries(units).into_iter().map(|query| {
            let (level, volume) = match query {
                Query::Level(z) => (Some(z), cavity.ok().and_then(|c| c.volume(z))),
                Query::Volume(v) => (cavity.ok().and_then(|c| c.level(v)), Some(v)),
            };
            Json::Object(vec![("level", level.into()), ("volume", volume.into())])
        });
        let reason = |text: Option<&String>| text.map(String::as_str).into();
        vec![
            ("unit", units.length.map(|unit| unit.name()).into()),
            ("density", self.density.into()),
            ("diameter", sheet.ok().map(|s| s.diameter).into()),
            ("height", sheet.ok().map(|s| s.height).into()),
            ("length", sheet.ok().map(|s| s.length).into()),
            ("area", sheet.ok().map(|s| s.area).into()),
            ("volume", solid.ok().map(|s| s.volume).into()),
            ("mass", self.density.and_then(|_| solid.ok().map(|s| density * s.volume)).into()),
            ("centroid", solid.ok().map(|s| s.centroid).into()),
            ("inertia", solid.map_or(Json::Null, |s| inertia(s.inertia))),
            ("capacity", cavity.ok().map(PlacedCavity::capacity).into()),
            ("bottom", cavity.ok().map(PlacedCavity::bottom).into()),
            ("brim", cavity.ok().map(PlacedCavity::brim).into()),
            ("trapped_air", cavity.ok().map(PlacedCavity::trapped).into()),
            ("levels", Json::List(queries.collect())),
            (
                "errors",
                Json::Object(vec![
                    ("length", sheet.ok().map(|s| s.length_error).into()),
                    ("area", sheet.ok().map(|s| s.area_error).into()),
                    ("volume", solid.ok().map(|s| s.volume_error).into()),
                    ("centroid", solid.ok().map(|s| s.centroid_error).into()),
                    ("inertia", solid.ok().map(|s| density * s.inertia_error).into()),
                    ("capacity", cavity.ok().map(PlacedCavity::error).into()),
                ]),
            ),
            (
                "reasons",
                Json::Object(vec![
                    ("area", reason(sheet.err())),
                    ("volume", reason(solid.err())),
                    ("capacity", reason(cavity.err())),
                ]),
            ),
        ]
    }
}

/// A question about the liquid in a vessel, in units of length and their cubes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Query {
    /// How much stands at this height?
    Level(f64),
    /// At which height does this much stand?
    Volume(f64),
}

fn unknown<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Failure {
    let names: Vec<_> = names.collect();
    let nearest = names
        .iter()
        .max_by(|a, b| strsim::jaro_winkler(name, a).total_cmp(&strsim::jaro_winkler(name, b)));
    let help = match nearest {
        Some(nearest) => {
            format!("the nearest name is `{nearest}`; without --object all are listed")
        }
        None => "there are no turned objects in the scene".into(),
    };
    Failure::new(format!("no turned object is called `{name}`"), &help)
}

/// The copies of an object, if it is a turned one or made of such, numbered if there are several.
fn copies(object: &Object) -> impl Iterator<Item = (String, Shape)> + '_ {
    let several = object.copies.count() > 1;
    let name = move |i| if several { format!("{} #{i}", object.name) } else { object.name.clone() };
    (1..).zip(object.shapes()).filter_map(move |(i, shape)| match shape {
        Some(shape @ (Shape::Turned(_) | Shape::Swept { .. } | Shape::Body(_))) => {
            Some((name(i), shape))
        }
        _ => None,
    })
}

//! The argument `PROFILE`, the options that say how to read it, and the reading.

use std::path::{Path, PathBuf};

use clap::{
    Args, ValueEnum,
    builder::{PossibleValuesParser, TypedValueParser},
};
use rondure::{
    Profile, Spline,
    profile::{Rim, Side, Thickness},
};
use rondure_scene::{ProfileOptions, Unit, read_profile};

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct ProfileArgs {
    /// The profile: path data (.path or .txt), a drawing (.svg) or points (.csv)
    profile: PathBuf,

    /// SVG: the id of the shape, if the drawing has several
    #[arg(long, value_name = "ID", help_heading = SHAPE)]
    svg_id: Option<String>,

    /// SVG: the x of the axis in the drawing's user units; 0 if not given
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = SHAPE)]
    axis: Option<f64>,

    /// SVG: the y that becomes z = 0; the bottom of the page if not given
    #[arg(long, value_name = "Y", allow_negative_numbers = true, help_heading = SHAPE)]
    base: Option<f64>,

    /// SVG: put points that are no farther from the axis than this onto it
    #[arg(long, value_name = "DISTANCE", help_heading = SHAPE)]
    snap: Option<f64>,

    /// SVG: the unit in which the profile is measured; the drawing's user units if not given
    #[arg(long, help_heading = SHAPE, value_parser = unit_parser())]
    unit: Option<Unit>,

    /// CSV: how the curve runs through the points; polyline if not given
    #[arg(long, value_name = "KIND", value_enum, help_heading = SHAPE)]
    spline: Option<SplineName>,

    /// Give the curve a wall of this thickness, measured after scaling
    #[arg(long, value_name = "T", allow_negative_numbers = true, help_heading = SHAPE)]
    thickness: Option<f64>,

    /// The side of the curve on which the wall is; inward if not given
    #[arg(long, value_enum, requires = "thickness", help_heading = SHAPE)]
    side: Option<SideName>,

    /// How the wall ends off the axis; flat if not given
    #[arg(long, value_enum, requires = "thickness", help_heading = SHAPE)]
    rim: Option<RimName>,

    /// A factor on r and z, after everything else but the wall
    #[arg(long, value_name = "F", allow_negative_numbers = true, help_heading = SHAPE)]
    scale: Option<f64>,
}

const SHAPE: &str = "How to read the profile";

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum SplineName {
    /// Straight from point to point
    Polyline,
    /// Natural cubic spline
    Natural,
    /// Catmull-Rom spline
    CatmullRom,
}

impl From<SplineName> for Spline {
    fn from(name: SplineName) -> Self {
        match name {
            SplineName::Polyline => Self::Polyline,
            SplineName::Natural => Self::Natural,
            SplineName::CatmullRom => Self::CatmullRom,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum SideName {
    /// Towards the inside: the curve is the outer face
    Inward,
    /// Towards the outside: the curve is the inner face
    Outward,
    /// Half on either side
    Centered,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum RimName {
    /// Straight across
    Flat,
    /// Half a circle
    Round,
}

fn unit_parser() -> impl TypedValueParser<Value = Unit> {
    PossibleValuesParser::new(Unit::NAMES.map(|(name, _)| name))
        .try_map(|name| Unit::from_name(&name).ok_or("no such unit"))
}

impl ProfileArgs {
    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.profile
    }

    /// The unit in which an SVG profile is to be measured.
    pub(crate) fn unit(&self) -> Option<Unit> {
        self.unit
    }

    /// The first option that was given.
    pub(crate) fn any_option(&self) -> Option<&'static str> {
        [
            (self.svg_id.is_some(), "--svg-id"),
            (self.axis.is_some(), "--axis"),
            (self.base.is_some(), "--base"),
            (self.snap.is_some(), "--snap"),
            (self.unit.is_some(), "--unit"),
            (self.spline.is_some(), "--spline"),
            (self.thickness.is_some(), "--thickness"),
            (self.scale.is_some(), "--scale"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }

    fn wall(&self) -> Option<Thickness> {
        let side = match self.side {
            Some(SideName::Outward) => Side::Outward,
            Some(SideName::Centered) => Side::Centered,
            Some(SideName::Inward) | None => Side::Inward,
        };
        let rim = if self.rim == Some(RimName::Round) { Rim::Round } else { Rim::Flat };
        self.thickness.map(|thickness| Thickness { thickness, side, rim })
    }

    /// Reads the profile.
    pub(crate) fn read(&self) -> Result<Profile, Failure> {
        let options = ProfileOptions {
            id: self.svg_id.clone(),
            axis: self.axis,
            base: self.base,
            snap: self.snap,
            unit: self.unit,
            scale: self.scale,
            spline: self.spline.map(Spline::from),
            thickness: self.wall(),
        };
        read_profile(&self.profile, &options).map_err(|report| Failure::Report(report.colored()))
    }
}

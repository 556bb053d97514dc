//! The argument `PROFILE`, the options that say how to read it, and the reading.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use rondure::{Profile, Spline};

use crate::failure::{Excerpt, Failure, report};

#[derive(Debug, Args)]
pub(crate) struct ProfileArgs {
    /// The profile: path data (.path), a drawing (.svg) or points (.csv)
    profile: PathBuf,

    /// SVG: the id of the path, if the drawing has several
    #[arg(long, value_name = "ID", help_heading = "Profile")]
    svg_id: Option<String>,

    /// SVG: where the axis is, as an x in the drawing's units
    #[arg(
        long,
        value_name = "X",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        help_heading = "Profile"
    )]
    axis: f64,

    /// SVG: the length of one unit of the drawing
    #[arg(long, value_name = "F", default_value_t = 1.0, help_heading = "Profile")]
    scale: f64,

    /// CSV: how the curve runs through the points
    #[arg(long, value_enum, default_value_t = SplineName::Polyline, help_heading = "Profile")]
    spline: SplineName,
}

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

impl ProfileArgs {
    /// Reads the profile.
    pub(crate) fn read(&self) -> Result<Profile, Failure> {
        let name = self.profile.display().to_string();
        let text = std::fs::read_to_string(&self.profile)
            .map_err(|error| Failure::unreadable(&name, &error))?;
        Profile::from_path_data(&text).map_err(|error| {
            let title = error.to_string();
            let excerpt = Excerpt {
                name: &name,
                line: 1,
                text: &text,
                span: error.span.unwrap_or(0..0),
                label: "",
            };
            report(&title, &excerpt, "", None)
        })
    }
}

//! `rondure merge`: from parts of a picture to the picture.

use std::path::PathBuf;

use clap::Args;
use rondure_film::{Merge as Sum, MergeError, Share, ShareError};

use crate::{
    failure::Failure,
    look::{LookArgs, film_of},
    output::{Kind, Output, Shown},
    room::{RoomArgs, cannot_keep},
};

/// Put parts of a picture together
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rondure merge part-*.rdf -o picture.exr
  rondure merge picture.rescued-123.rdf -o picture.png

The order of the parts does not matter: the picture is the same, bit for bit, as one made in one go.
Parts that are missing, doubled, or of another picture are told by name. Into an .rdf file some parts
can be merged without the others.")]
pub(crate) struct Merge {
    /// The parts, as `rondure render --part` writes them
    #[arg(value_name = "PART.rdf", required = true)]
    parts: Vec<PathBuf>,

    /// Where to write the picture, a PNG or OpenEXR file, or the sum of the parts, an .rdf file
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    #[command(flatten)]
    look: LookArgs,

    #[command(flatten)]
    room: RoomArgs,

    /// Bits in each channel of a PNG file
    #[arg(long, value_name = "N", default_value = "8", value_parser = bits)]
    bits: u8,
}

fn bits(text: &str) -> Result<u8, &'static str> {
    text.parse().ok().filter(|bits| matches!(bits, 8 | 16)).ok_or("a PNG file has 8 or 16 bits")
}

impl Merge {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let output = Output::new(self.output.clone(), "-o")?;
        let room = self.room.of(&output.path);
        let mut sum = Sum::new(room.clone());
        for (i, path) in self.parts.iter().enumerate() {
            let share = Share::read(path, &room).map_err(unreadable)?;
            if i == 0 {
                let [width, height] = share.sums.size();
                output.check(u64::from(width) * u64::from(height))?;
            }
            sum.add(&path.display().to_string(), &share).map_err(unfit)?;
        }
        let sum = match output.kind {
            Kind::Share => sum.so_far(),
            Kind::Png | Kind::Exr => sum.finish().map_err(unfit)?,
        };
        // At least one part was asked for.
        let Some(sum) = sum else { return Ok(()) };
        let mut film = film_of(&sum.recipe.settings);
        film.bits = self.bits;
        self.look.apply(&mut film);
        output.write(&sum.as_ref(), &Shown::of(&film)?)
    }
}

fn unreadable(error: ShareError) -> Failure {
    match error {
        ShareError::Io { path, source } => {
            Failure::unreadable(&path.display().to_string(), &source)
        }
        ShareError::Version { .. } => {
            Failure::new(error, "merge it with the version of Rondure that made it")
        }
        ShareError::Sums { source, .. } => cannot_keep(source),
        ShareError::NotAShare(_) => {
            Failure::new(error, "give files that `rondure render --part` has written")
        }
        other => Failure::new(other, "make this part again, or copy it again"),
    }
}

fn unfit(error: MergeError) -> Failure {
    let help = match error {
        MergeError::Sums { source, .. } => return cannot_keep(source),
        MergeError::Foreign { .. } => "merge parts of one picture only",
        MergeError::Doubled { .. } => "leave one of them out",
        MergeError::Missing { .. } => "add what is missing, or merge into an .rdf file for now",
        _ => "make a smaller picture",
    };
    Failure::new(error, help)
}

//! The options that say where the sums of a picture are kept.

use std::path::{Path, PathBuf};

use clap::Args;
use rondure_film::{Room, SpoolError};

use crate::{
    failure::{Failure, plain},
    output::folder_of,
};

#[derive(Debug, Args)]
pub(crate) struct RoomArgs {
    /// The most memory for the sums of the picture, like 500M or 8G; a larger picture lies in a scratch file
    #[arg(long, value_name = "SIZE", value_parser = bytes, default_value = "2G", help_heading = ROOM)]
    memory: u64,

    /// The folder for the scratch file, where the picture goes if not given
    #[arg(long, value_name = "FOLDER", help_heading = ROOM)]
    scratch: Option<PathBuf>,
}

const ROOM: &str = "Large pictures";

impl RoomArgs {
    /// The room for the sums of a picture that goes to a file.
    pub(crate) fn of(&self, output: &Path) -> Room {
        let folder = self.scratch.clone().unwrap_or_else(|| folder_of(output).to_owned());
        Room { memory: self.memory, folder }
    }
}

/// Why there are no sums.
pub(crate) fn cannot_keep(error: SpoolError) -> Failure {
    match error {
        SpoolError::Io { folder, source } => Failure::new(
            format!(
                "cannot keep the sums of the picture in `{}`: {}",
                folder.display(),
                plain(&source)
            ),
            "choose another folder with --scratch, or allow more --memory",
        ),
        other => Failure::new(other, "choose a smaller --size, or allow less --memory"),
    }
}

/// A number of bytes, like 500M or 1.5G, or plain.
fn bytes(text: &str) -> Result<u64, &'static str> {
    let (number, unit) = match text.char_indices().next_back() {
        Some((end, 'k' | 'K')) => (&text[..end], 1e3),
        Some((end, 'M')) => (&text[..end], 1e6),
        Some((end, 'G')) => (&text[..end], 1e9),
        Some((end, 'T')) => (&text[..end], 1e12),
        _ => (text, 1.0),
    };
    let good = |n: &f64| *n >= 0.0 && n * unit < 1e18;
    let number = number.parse::<f64>().ok().filter(good);
    number.map(|n| (n * unit) as u64).ok_or("a size is a number of bytes, or like 500M or 8G")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_memory() {
        for (text, size) in [
            ("0", 0),
            ("70000", 70_000),
            ("12k", 12_000),
            ("1.5M", 1_500_000),
            ("2G", 2_000_000_000),
        ] {
            assert_eq!(bytes(text), Ok(size), "{text}");
        }
        for bad in ["", "G", "-1", "-1G", "1g", "2GB", "nan", "infG", "1e30", "ß"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }
}

//! Scene files for the commands: read, with what is wrong with them told.

use std::path::Path;

use rondure_scene::{Scene, read_scene};

use crate::failure::Failure;

/// Reads a scene with all that it refers to. Warnings are printed, errors are the failure.
pub(crate) fn read(path: &Path) -> Result<Scene, Failure> {
    match read_scene(path) {
        Ok((scene, warnings)) => {
            if !warnings.is_empty() {
                anstream::eprintln!("{}\n", warnings.colored());
            }
            Ok(scene)
        }
        Err(report) => Err(Failure::Report(report.colored())),
    }
}

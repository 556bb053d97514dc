//! Intel's Open Image Denoise, by its own program `oidnDenoise`, to which pictures go as PFM files.

use std::{
    io,
    path::Path,
    process::{Command, Output},
};

use rondure_image::pfm;

use crate::{failure::Failure, output::folder_of};

const PROGRAM: &str = "oidnDenoise";
const INSTEAD: &str = "leave away `--method oidn`";

/// The light of a picture with what it first met.
pub(crate) struct Noisy<'a> {
    pub(crate) size: [u32; 2],
    pub(crate) light: &'a [[f32; 3]],
    pub(crate) albedo: &'a [[f32; 3]],
    pub(crate) normal: &'a [[f32; 3]],
}

/// Makes sure that the program is there, before a large picture is read.
pub(crate) fn check() -> Result<(), Failure> {
    start(Command::new(PROGRAM).arg("--help")).map(|_| ())
}

/// The light without noise. What goes to the program and comes from it lies beside `output` meanwhile.
pub(crate) fn denoise(
    noisy: &Noisy<'_>,
    output: &Path,
    threads: Option<usize>,
) -> Result<Vec<[f32; 3]>, Failure> {
    let unwritable = |error: io::Error| Failure::unwritable(output, &error);
    let folder = tempfile::Builder::new()
        .prefix(".rondure-")
        .tempdir_in(folder_of(output))
        .map_err(unwritable)?;
    let path = |name: &str| folder.path().join(name);
    let [color, albedo, normal, clean] =
        ["color.pfm", "albedo.pfm", "normal.pfm", "clean.pfm"].map(path);
    for (path, pixels) in [(&color, noisy.light), (&albedo, noisy.albedo), (&normal, noisy.normal)]
    {
        pfm::write(path, noisy.size, pixels).map_err(unwritable)?;
    }
    let mut command = Command::new(PROGRAM);
    command.arg("--hdr").arg(&color).arg("--alb").arg(&albedo).arg("--nrm").arg(&normal);
    command.arg("-o").arg(&clean);
    if let Some(threads) = threads {
        command.arg("--threads").arg(threads.to_string());
    }
    let ended = start(&mut command)?;
    let useless = |why: &str| Failure::new(format!("{PROGRAM} gave no picture: {why}"), INSTEAD);
    if !ended.status.success() {
        let said = [ended.stderr, ended.stdout].concat();
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().map(str::trim).rfind(|line| !line.is_empty());
        return Err(useless(last.unwrap_or("it says nothing")));
    }
    let image = pfm::read(&clean).map_err(|error| match error {
        pfm::ReadError::Io { source, .. } => useless(&source.to_string()),
        _ => useless("its file is not whole"),
    })?;
    if [image.width(), image.height()] != noisy.size {
        return Err(useless("it has another size"));
    }
    Ok(image.pixels().to_vec())
}

fn start(command: &mut Command) -> Result<Output, Failure> {
    command.output().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Failure::new(
            format!(
                "Intel's Open Image Denoise was not found: no program {PROGRAM} is in the PATH"
            ),
            &format!("install it from https://www.openimagedenoise.org, or {INSTEAD}"),
        ),
        _ => Failure::new(format!("{PROGRAM} cannot be started: {error}"), INSTEAD),
    })
}

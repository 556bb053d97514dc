//! Embree from the wheel `embreex` of the Python Package Index, unpacked into a folder of its own.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Embree 4.4, and which CPython the wheel is for: any will do, as none of its Python is run.
const WHEEL: [&str; 8] = [
    "embreex==4.4.*",
    "--no-deps",
    "--only-binary=:all:",
    "--platform=manylinux_2_28_x86_64",
    "--python-version=3.11",
    "--implementation=cp",
    "--quiet",
    "--disable-pip-version-check",
];

/// Embree's library, and those it needs.
#[derive(Debug)]
pub(crate) struct Libraries {
    pub(crate) embree: PathBuf,
    pub(crate) needs: Vec<PathBuf>,
}

/// Finds Embree in a folder, where it is installed if it is missing.
pub(crate) fn embree(folder: &Path) -> Result<Libraries, Box<dyn Error>> {
    if let Some(found) = find(folder) {
        return Ok(found);
    }
    eprintln!("installing Embree 4.4 (the wheel `embreex`) into {}", folder.display());
    fs::create_dir_all(folder)?;
    let mut said = Vec::new();
    for pip in [&["python3", "-m", "pip"][..], &["pip3"], &["pip"], &["python", "-m", "pip"]] {
        let mut command = Command::new(pip[0]);
        command.args(&pip[1..]).arg("install").args(WHEEL).arg("--target").arg(folder);
        match command.stdin(Stdio::null()).output() {
            Ok(output) if output.status.success() => {
                return find(folder).ok_or_else(|| {
                    format!("the wheel in {} has no libembree4", folder.display()).into()
                });
            }
            Ok(output) => said.push(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
            Err(error) => said.push(format!("{}: {error}", pip.join(" "))),
        }
    }
    Err(format!(
        "Embree could not be installed with pip: give the folder of libembree4.so.4 and libtbb.so.12 \
         with --embree\n{}",
        said.join("\n")
    )
    .into())
}

/// Looks for the libraries in a folder and in the one in which wheels keep them.
pub(crate) fn find(folder: &Path) -> Option<Libraries> {
    [folder.to_owned(), folder.join("embreex.libs")].iter().find_map(|folder| {
        let files = fs::read_dir(folder).ok()?;
        let mut files: Vec<_> = files.flatten().map(|entry| entry.path()).collect();
        files.sort();
        let begins = |file: &PathBuf, with: &str| {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned());
            name.is_some_and(|name| name.starts_with(with) && name.contains(".so"))
        };
        let embree = files.iter().find(|file| begins(file, "libembree4"))?.clone();
        let needs = files.into_iter().filter(|file| begins(file, "libtbb")).collect();
        Some(Libraries { embree, needs })
    })
}

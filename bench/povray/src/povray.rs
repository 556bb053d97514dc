//! POV-Ray itself: how it comes onto the machine, how it is called and what it tells.

use std::{
    error::Error,
    path::Path,
    process::{Command, Stdio},
};

/// The version of the POV-Ray on this machine, which is installed if it is missing.
pub(crate) fn version() -> Result<String, Box<dyn Error>> {
    if let Some(version) = installed() {
        return Ok(version);
    }
    install()?;
    installed().ok_or_else(|| "POV-Ray was installed, but `povray --version` does not run".into())
}

fn installed() -> Option<String> {
    let output = Command::new("povray").arg("--version").stdin(Stdio::null()).output().ok()?;
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    said.lines().find(|line| line.starts_with("POV-Ray ")).map(str::to_owned)
}

fn install() -> Result<(), Box<dyn Error>> {
    let apt = || Command::new("apt-get");
    if apt().arg("--version").stdout(Stdio::null()).status().is_err() {
        return Err("POV-Ray is missing, and this is not Debian: install POV-Ray 3.7 so that \
                    `povray` runs, then try again"
            .into());
    }
    eprintln!("POV-Ray is missing; installing Debian's package `povray`");
    let as_root = nix::unistd::geteuid().is_root();
    let command = || {
        if as_root {
            return apt();
        }
        let mut command = Command::new("sudo");
        command.arg("apt-get");
        command
    };
    let steps: [&[&str]; 2] =
        [&["update", "-q"], &["install", "-y", "-q", "--no-install-recommends", "povray"]];
    for step in steps {
        let status = command().args(step).stdout(Stdio::null()).status();
        if !status.as_ref().is_ok_and(|s| s.success()) {
            let step = step.join(" ");
            return Err(format!("`apt-get {step}` failed: install POV-Ray 3.7 by hand").into());
        }
    }
    Ok(())
}

/// The call that renders a scene on one thread, with 1 sample in each pixel or a square and one.
pub(crate) fn command(scene: &Path, picture: &Path, size: (u32, u32), spp: u32) -> Command {
    let mut command = Command::new("povray");
    command
        .arg(format!("+I{}", scene.display()))
        .arg(format!("+O{}", picture.display()))
        .args([format!("+W{}", size.0), format!("+H{}", size.1)])
        .args(["+FN8", "-D", "+WT1", "+MB1", "-P", "-V"]);
    if spp > 1 {
        // After the first sample, a regular grid in every pixel that has not exactly its
        // neighbours' colour.
        let grid = (spp - 1).isqrt();
        command.args(["+AM1".into(), "+A0.0".into(), "-J".into(), format!("+R{grid}")]);
    } else {
        command.arg("-A");
    }
    command
}

/// The CPU seconds of the tracing alone, without reading the scene and writing the picture.
pub(crate) fn trace_seconds(said: &str) -> Option<f64> {
    let after = said.split("Trace Time:").nth(1)?;
    let words: Vec<_> = after.split_whitespace().collect();
    let at = words.iter().position(|word| *word == "CPU-seconds")?;
    words.get(at.checked_sub(1)?)?.parse().ok()
}

/// How many rays were followed: those from the camera, reflected and refracted ones.
pub(crate) fn rays(said: &str) -> Option<f64> {
    let counts = ray_counts(said);
    let words = counts.iter().find_map(|line| line.strip_prefix("Rays: "))?;
    words.split(' ').next()?.parse().ok()
}

/// The lines of its statistics that count rays.
pub(crate) fn ray_counts(said: &str) -> Vec<String> {
    const COUNTS: [&str; 6] = [
        "Rays:",
        "Shadow Ray Tests:",
        "Reflected Rays:",
        "Refracted Rays:",
        "Transmitted Rays:",
        "Total Internal:",
    ];
    let squeezed = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    said.lines()
        .map(str::trim)
        .filter(|line| COUNTS.iter().any(|count| line.starts_with(count)))
        .map(squeezed)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_are_found() {
        let said = "  Trace Time:       0 hours  0 minutes  3 seconds (3.141 seconds)\n              \
                    using 1 thread(s) with 3.125 CPU-seconds total\nRays:   12   Saved: 0\n";
        assert_eq!(trace_seconds(said), Some(3.125));
        assert_eq!(ray_counts(said), ["Rays: 12 Saved: 0"]);
        assert_eq!(rays(said), Some(12.0));
        assert_eq!(trace_seconds("nothing"), None);
    }
}

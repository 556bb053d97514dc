//! Files that appear under their name only when they are whole.

use std::{
    fs,
    io::{self, BufWriter, Write},
    path::Path,
};

/// Writes a file beside its place, brings it to the disk, and gives it its name then. Whenever the process or the machine stops, there is the old file
/// or the new one. If that fails nothing is left behind, and a file that was there before stays as it was.
///
/// # Errors
/// What `fill` or the disk says; of a folder, that it is one.
pub fn write_whole<E: From<io::Error>>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut fs::File>) -> Result<(), E>,
) -> Result<(), E> {
    if path.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory).into());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rondure-");
    #[cfg(unix)]
    {
        // As for any new file; the process' mask takes its share.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    let mut out = BufWriter::new(file.as_file_mut());
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    // The name too must reach the disk; elsewhere folders cannot be opened.
    #[cfg(unix)]
    fs::File::open(folder)?.sync_all()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn errors_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let (taken, old) = (folder.path().join("taken"), folder.path().join("old"));
        fs::create_dir(&taken).unwrap();
        fs::write(&old, "old").unwrap();
        assert!(write_whole::<io::Error>(&taken, |_| Ok(())).is_err());
        assert!(write_whole::<io::Error>(&folder.path().join("no/such"), |_| Ok(())).is_err());
        let fails = write_whole(&old, |out| {
            out.write_all(b"new")?;
            Err(io::Error::other("no more"))
        });
        assert_eq!(fails.unwrap_err().to_string(), "no more");
        assert_eq!(fs::read_to_string(&old).unwrap(), "old");
        assert_eq!(names(folder.path()), ["old", "taken"]);
        write_whole::<io::Error>(&old, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&old).unwrap(), "new");
    }

    #[cfg(unix)]
    #[test]
    fn files_can_be_read_by_others() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, usual) = (folder.path().join("a"), folder.path().join("usual"));
        write_whole::<io::Error>(&ours, |_| Ok(())).unwrap();
        fs::write(&usual, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&usual));
    }
}

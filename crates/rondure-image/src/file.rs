//! Files that appear under their name only when they are whole.

use std::{
    fs,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
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
    let folder = folder_of(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rondure-");
    #[cfg(unix)]
    {
        // As for any new file; the process' mask takes its share.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    fill_whole(file.as_file_mut(), fill)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(sync_name(path)?)
}

/// The same for a file that nobody else writes: what is not whole has its name with `.new` behind it, so that a process that is killed time and again
/// leaves one such file at most.
///
/// # Errors
/// As [`write_whole`].
pub fn write_whole_alone<E: From<io::Error>>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut fs::File>) -> Result<(), E>,
) -> Result<(), E> {
    if path.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory).into());
    }
    let new = new_name(path);
    let write = || {
        fill_whole(&mut fs::File::create(&new)?, fill)?;
        fs::rename(&new, path)?;
        Ok(sync_name(path)?)
    };
    write().inspect_err(|_| drop(fs::remove_file(&new)))
}

/// The name of a file before it is whole, if nobody else writes it.
pub fn new_name(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    name.into()
}

/// Fills a file, to the disk.
fn fill_whole<E: From<io::Error>>(
    file: &mut fs::File,
    fill: impl FnOnce(&mut BufWriter<&mut fs::File>) -> Result<(), E>,
) -> Result<(), E> {
    let mut out = BufWriter::new(&mut *file);
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    Ok(file.sync_all()?)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Brings a name to the disk.
#[cfg(unix)]
fn sync_name(path: &Path) -> io::Result<()> {
    fs::File::open(folder_of(path))?.sync_all()
}

/// Folders cannot be opened elsewhere.
#[cfg(not(unix))]
fn sync_name(_: &Path) -> io::Result<()> {
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

    #[test]
    fn files_are_whole_or_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let fails = |out: &mut BufWriter<&mut fs::File>| {
            out.write_all(b"new")?;
            Err(io::Error::other("no more"))
        };
        fs::write(&path, "old").unwrap();
        assert_eq!(write_whole(&path, fails).unwrap_err().to_string(), "no more");
        assert_eq!(write_whole_alone(&path, fails).unwrap_err().to_string(), "no more");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        write_whole_alone(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        fs::write(new_name(&path), "left by a process that was killed").unwrap();
        write_whole_alone(&path, |out| out.write_all(b"newer")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "newer");
        write_whole(&path, |out| out.write_all(b"newest")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "newest");
        assert!(write_whole_alone(folder.path(), |out| out.write_all(b"x")).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

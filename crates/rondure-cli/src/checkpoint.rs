//! Checkpoints: the sums so far in a file, and a lock so that no two processes work on one.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{self, Read, Seek, Write},
    path::{Path, PathBuf},
};

use rondure_film::{Portion, Recipe, Room, Share, ShareError, ShareRef};
use rondure_render::Job;

use crate::{failure::Failure, output, room::cannot_keep};

/// The option that names it.
const OPTION: &str = "--checkpoint";

/// A checkpoint file that this process alone works on.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    lock_path: PathBuf,
    /// The lock is let go when this is closed, however the process ends.
    _lock: File,
}

impl Checkpoint {
    /// Takes hold of a checkpoint.
    pub(crate) fn new(path: &Path) -> Result<Self, Failure> {
        output::check_place(OPTION, path, 0)?;
        let mut lock_path = path.as_os_str().to_owned();
        lock_path.push(".lock");
        let lock_path = PathBuf::from(lock_path);
        let unwritable = |error: io::Error| Failure::unwritable_by(OPTION, &lock_path, &error);
        let lock = loop {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&lock_path)
                .map_err(unwritable)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(taken(path, &mut file)),
                Err(TryLockError::Error(error)) => return Err(unwritable(error)),
            }
            // Whoever had it may have taken the name away since it was opened.
            if !is_at(&file, &lock_path).map_err(unwritable)? {
                continue;
            }
            file.set_len(0).map_err(unwritable)?;
            file.rewind().map_err(unwritable)?;
            write!(file, "{}", std::process::id()).map_err(unwritable)?;
            break file;
        };
        Ok(Self { path: path.to_owned(), lock_path, _lock: lock })
    }

    /// What is there of the picture's portion; `None` if nothing is.
    pub(crate) fn read(
        &self,
        job: &Job<'_>,
        recipe: &Recipe,
        portion: &Portion,
        room: &Room,
    ) -> Result<Option<Share>, Failure> {
        let share = match Share::read(&self.path, room) {
            Err(ShareError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(None);
            }
            Err(ShareError::Sums { source, .. }) => return Err(cannot_keep(source)),
            read => read.map_err(|error| self.refused(&error.to_string()))?,
        };
        let difference = recipe.difference(&share.recipe).or_else(|| {
            let ([a, b], [c, d]) = (share.sums.size(), job.size());
            let window = share.sums.window();
            if [a, b] != [c, d] {
                Some(format!("its picture has {a}x{b} pixels, not {c}x{d}"))
            } else if window != portion.window {
                Some(format!("it is of another part of the picture, {window}"))
            } else if share.sums.layers() != job.layers() {
                Some("it has other layers; -o asked for another kind of file".to_owned())
            } else {
                None
            }
        });
        match difference {
            Some(difference) => Err(self.refused(&difference)),
            None => Ok(Some(share)),
        }
    }

    /// An error that says why this checkpoint is not gone on with.
    pub(crate) fn refused(&self, reason: &str) -> Failure {
        let title = format!("cannot go on from the checkpoint `{}`: {reason}", self.path.display());
        Failure::new(title, "delete it to begin anew, or give another with --checkpoint")
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the sums so far.
    pub(crate) fn write(&self, share: &ShareRef<'_>) -> Result<(), Failure> {
        share.write_alone(&self.path).map_err(|error| output::unwritten(OPTION, error))
    }

    /// Takes the checkpoint away: it has done its service.
    pub(crate) fn remove(&self) {
        drop(std::fs::remove_file(&self.path));
    }
}

/// The name of the lock is of no use to anybody else; it goes while the lock is still held.
impl Drop for Checkpoint {
    fn drop(&mut self) {
        drop(std::fs::remove_file(&self.lock_path));
    }
}

fn taken(path: &Path, lock: &mut File) -> Failure {
    let mut id = String::new();
    // An unreadable number is no reason to say nothing.
    drop(lock.take(20).read_to_string(&mut id));
    let who = match id.trim().parse::<u32>() {
        Ok(id) => format!("process {id}"),
        Err(_) => "another process".to_owned(),
    };
    let title = format!("{who} is working on the checkpoint `{}`", path.display());
    Failure::new(title, "wait for it to end, or give another with --checkpoint")
}

/// Whether an open file is still the one with this name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let own = file.metadata()?;
    match std::fs::metadata(path) {
        Ok(there) => Ok((own.dev(), own.ino()) == (there.dev(), there.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Open files cannot be taken away elsewhere.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> io::Result<bool> {
    Ok(true)
}

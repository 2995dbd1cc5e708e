//! The files of a checkpoint: the newest generation, the one before, and a lock.
//!
//! `FILE` is replaced as a whole, and what it was becomes `FILE.1`. Whoever writes them holds `FILE.lock`, which the
//! system lets go of when its holder ends, however that is.

use super::{Checkpoint, Damage};
use crate::atomic_file::{self, FileError, Output, reason};
use scene::Resumable;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

/// A checkpoint by its name, whether there is one or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Store {
    path: PathBuf,
}

/// A checkpoint that can be gone on from.
#[derive(Debug)]
pub struct Loaded {
    /// Which file it is.
    pub path: PathBuf,
    /// What it holds.
    pub checkpoint: Checkpoint,
    /// Why it is not the newest, if that could not be used.
    pub fallback: Option<FileError>,
    file: BufReader<File>,
}

impl Store {
    /// The checkpoint at `path`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Its newest generation.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its older generation.
    pub fn previous(&self) -> PathBuf {
        with_suffix(&self.path, ".1")
    }

    /// Whether there is a generation, whole or not.
    pub fn exists(&self) -> bool {
        self.path.exists() || self.previous().exists()
    }

    /// Writes a new generation by `fill`, and keeps what is now the newest as the older one.
    ///
    /// # Errors
    /// As [`atomic_file::replace`]; then all files are as they were.
    pub fn save(&self, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), FileError> {
        atomic_file::replace_and_keep(&self.path, Some(&self.previous()), fill)
    }

    /// Removes all generations.
    ///
    /// # Errors
    /// If one is there and cannot be removed.
    pub fn remove(&self) -> Result<(), FileError> {
        for path in [&self.path, &self.previous()] {
            match fs::remove_file(path) {
                Err(e) if e.kind() != ErrorKind::NotFound => {
                    return Err(FileError::new(path, format!("cannot be removed: {}", reason(&e))));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads the newest generation that is whole; `None` if there is not one file.
    ///
    /// # Errors
    /// If there are files, and none is whole: what is wrong with the newest.
    pub fn load(&self) -> Result<Option<Loaded>, FileError> {
        let problem = |damage: &dyn ToString| FileError::new(&self.path, damage.to_string());
        let newest = match load(&self.path) {
            Ok(Some(loaded)) => return Ok(Some(loaded)),
            Ok(None) => None,
            // Nothing is wrong with it, and others may want it.
            Err(version @ Damage::Version { .. }) => return Err(problem(&version)),
            Err(damage) => Some(problem(&damage)),
        };
        match (load(&self.previous()), newest) {
            (Ok(None), None) => Ok(None),
            (Ok(None), Some(newest)) => Err(newest),
            (Ok(Some(loaded)), newest) => {
                let fallback = Some(newest.unwrap_or_else(|| problem(&"is missing")));
                Ok(Some(Loaded { fallback, ..loaded }))
            }
            (Err(older), newest) => {
                let newest = newest.map_or_else(|| "is missing".into(), |newest| newest.problem);
                Err(problem(&format!("{newest}; and the older generation {older}")))
            }
        }
    }

    /// Puts the older generation in the place of a newest that is damaged or missing, so that there is always one that
    /// is whole.
    ///
    /// # Errors
    /// If it cannot be renamed.
    pub fn fall_back(&self) -> Result<(), FileError> {
        fs::rename(self.previous(), &self.path).map_err(|e| {
            FileError::new(&self.path, format!("cannot be replaced by the older: {}", reason(&e)))
        })
    }

    /// Takes the checkpoint for oneself.
    ///
    /// # Errors
    /// If another process has it, or no file can be made beside it. Where the file system knows no locks, it is had.
    pub fn lock(&self) -> Result<Lock, FileError> {
        let path = with_suffix(&self.path, ".lock");
        loop {
            let failed = |e: io::Error| FileError::new(&path, format!("cannot be made: {}", reason(&e)));
            let options = &mut File::options();
            let mut file =
                options.read(true).write(true).create(true).truncate(false).open(&path).map_err(failed)?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    let _ = file.take(20).read_to_string(&mut holder); // who it is serves the message alone
                    let who =
                        holder.trim().parse().map_or(String::new(), |id: u32| format!(", process {id}"));
                    let problem =
                        format!("is in use by another render{who}; wait for it, or name another file");
                    return Err(FileError::new(&self.path, problem));
                }
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // Its last holder may have removed it between our opening and locking it.
            if is_still(&file, &path) {
                let _ = file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id()));
                return Ok(Lock { path, _file: file });
            }
        }
    }
}

fn load(path: &Path) -> Result<Option<Loaded>, Damage> {
    // Asked before opening, as opening a pipe waits for a writer.
    let status = match fs::metadata(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        status => status?,
    };
    if !status.is_file() {
        return Err(Damage::NoCheckpoint);
    }
    let mut file = BufReader::new(File::open(path)?);
    let checkpoint = Checkpoint::read(&mut file, status.len())?;
    Ok(Some(Loaded { path: path.into(), checkpoint, fallback: None, file }))
}

impl Loaded {
    /// As [`Checkpoint::restore`].
    ///
    /// # Errors
    /// Like that.
    pub fn restore(&mut self, engine: &mut dyn Resumable) -> Result<(), FileError> {
        let restored = self.checkpoint.restore(&mut self.file, engine);
        restored.map_err(|damage| FileError::new(&self.path, damage.to_string()))
    }
}

/// The right to write a checkpoint; given back when dropped.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    _file: File,
}

impl Drop for Lock {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path); // the file does no harm
    }
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Whether `path` is the name of `file`.
#[cfg(unix)]
fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |m: fs::Metadata| (m.dev(), m.ino());
    let (ours, there) = (file.metadata().map(identity), fs::metadata(path).map(identity));
    matches!((ours, there), (Ok(ours), Ok(there)) if ours == there)
}

#[cfg(not(unix))]
fn is_still(_: &File, _: &Path) -> bool {
    true // a file that is open cannot be removed
}

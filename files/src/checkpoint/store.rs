//! The files of a checkpoint: the newest generation and the previous one.
//!
//! `FILE` is replaced atomically, and its previous content becomes `FILE.1`. A process takes the [`crate::lock::Lock`] of
//! `FILE` before it writes them. If `FILE` is a symbolic link, the link stays, and both are where it leads: they may be
//! on another file system than the link, and files are renamed within one only.

use super::damage::Damage;
use super::read::Checkpoint;
use crate::atomic_file::{self, FileError, Output, reason};
use crate::{input, paths};
use scene::Resumable;
use std::fs::{self, File};
use std::io::{self, BufReader, ErrorKind};
use std::path::{Path, PathBuf};

/// The files of a checkpoint, which need not exist yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Store {
    path: PathBuf,
}

/// A checkpoint that can be resumed.
#[derive(Debug)]
pub struct Loaded {
    /// The file that it was read from.
    pub path: PathBuf,
    /// Its content.
    pub checkpoint: Checkpoint,
    /// Why the newest generation could not be used, if this is the older one.
    pub fallback: Option<FileError>,
    file: BufReader<File>,
}

impl Store {
    /// The checkpoint at `path`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// The newest generation.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The older generation.
    pub fn previous(&self) -> PathBuf {
        paths::around(&followed(&self.path), "", ".1")
    }

    /// Whether a generation exists, valid or not.
    pub fn exists(&self) -> bool {
        self.path.exists() || self.previous().exists()
    }

    /// Writes a new generation with `fill`. The current newest becomes the older one.
    ///
    /// # Errors
    /// As [`atomic_file::replace`]. All files are then unchanged.
    pub fn save(&self, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), FileError> {
        atomic_file::replace_and_keep(&self.path, Some(&self.previous()), fill)
    }

    /// Removes both generations.
    ///
    /// # Errors
    /// If one exists and cannot be removed.
    pub fn remove(&self) -> Result<(), FileError> {
        for path in [&self.path, &self.previous()] {
            match fs::remove_file(followed(path)) {
                Err(e) if e.kind() != ErrorKind::NotFound => {
                    return Err(FileError::new(path, format!("cannot be removed: {}", reason(&e))));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads the newest valid generation; `None` if no file exists.
    ///
    /// # Errors
    /// If files exist but none is valid, or if the newest has another format version.
    pub fn load(&self) -> Result<Option<Loaded>, FileError> {
        let problem = |damage: &dyn ToString| FileError::new(&self.path, damage.to_string());
        let newest = match load(&self.path) {
            Ok(Some(loaded)) => return Ok(Some(loaded)),
            Ok(None) => None,
            // Another version of sppm can read the newest generation, so do not fall back to the older one.
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
            // A file of particles that is missing is so for both.
            (Err(older), Some(newest)) if newest.problem == older.to_string() => Err(newest),
            (Err(older), newest) => {
                let newest = newest.map_or_else(|| "is missing".into(), |newest| newest.problem);
                Err(problem(&format!("{newest}; and the older generation {older}")))
            }
        }
    }

    /// Renames the older generation to the newest, which is damaged or missing. The next save then keeps a valid
    /// generation rather than the damaged one.
    ///
    /// # Errors
    /// If it cannot be renamed.
    pub fn fall_back(&self) -> Result<(), FileError> {
        fs::rename(self.previous(), followed(&self.path)).map_err(|e| {
            FileError::new(&self.path, format!("cannot be replaced by the older: {}", reason(&e)))
        })
    }
}

/// The file that `path` leads to if it is a symbolic link, else `path` itself.
fn followed(path: &Path) -> PathBuf {
    paths::follow(path).unwrap_or_else(|_| path.to_owned())
}

fn load(path: &Path) -> Result<Option<Loaded>, Damage> {
    if fs::metadata(path).is_err_and(|e| e.kind() == ErrorKind::NotFound) {
        return Ok(None);
    }
    let (file, length) = input::open(path, "name a checkpoint").map_err(Damage::Unopened)?;
    let mut file = BufReader::new(file);
    let checkpoint = Checkpoint::read_in(&mut file, length, path.parent().unwrap_or(Path::new("")))?;
    Ok(Some(Loaded { path: path.into(), checkpoint, fallback: None, file }))
}

impl Loaded {
    /// Loads the checkpoint into `engine`; see [`Checkpoint::restore`].
    ///
    /// # Errors
    /// As [`Checkpoint::restore`].
    pub fn restore(&mut self, engine: &mut dyn Resumable) -> Result<(), FileError> {
        let restored = self.checkpoint.restore(&mut self.file, engine);
        restored.map_err(|damage| FileError::new(&self.path, damage.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_removed_is_told_and_what_is_not_there_is_fine() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path().join("a.sppm"));
        assert_eq!((store.remove(), store.exists()), (Ok(()), false));
        for path in [store.path().to_owned(), store.previous()] {
            fs::write(&path, "").unwrap();
            assert!(store.exists());
            assert_eq!((store.remove(), path.exists()), (Ok(()), false));
            fs::create_dir(&path).unwrap();
            let problem = store.remove().unwrap_err().to_string();
            assert!(problem.starts_with(&format!("{}: cannot be removed: ", path.display())), "{problem}");
            fs::remove_dir(&path).unwrap();
        }
    }

    #[test]
    fn the_older_generation_takes_the_place_of_the_newest() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path().join("a.sppm"));
        assert_eq!(store.previous(), folder.path().join("a.sppm.1"));
        let problem = store.fall_back().unwrap_err().to_string();
        assert!(problem.contains("a.sppm: cannot be replaced by the older: "), "{problem}");
        fs::write(store.previous(), "older").unwrap();
        store.fall_back().unwrap();
        assert_eq!((fs::read(store.path()).unwrap(), store.previous().exists()), (b"older".to_vec(), false));
    }
}

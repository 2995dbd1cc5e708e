//! Remembers the warnings of a render, so that what fails again and again, as on a full disk, is told once.

use files::atomic_file::FileError;
use std::collections::HashMap;
use std::mem::take;
use std::path::{Path, PathBuf};

/// The warnings that were given.
#[derive(Default)]
pub(crate) struct Told {
    problems: HashMap<PathBuf, String>,
    /// Whether the last checkpoint could not be written.
    pub(crate) is_unsaved: bool,
}

impl Told {
    /// Whether `error` is another than the last one of the same `subject`.
    pub(crate) fn is_new(&mut self, subject: &Path, error: &FileError) -> bool {
        let last = self.problems.insert(subject.to_owned(), error.problem.clone());
        last.is_none_or(|last| last != error.problem)
    }

    /// Whether a checkpoint was written after one that could not be. What fails after that is told anew.
    pub(crate) fn is_mended(&mut self) -> bool {
        let is_mended = take(&mut self.is_unsaved);
        if is_mended {
            self.problems.clear();
        }
        is_mended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_given_once_until_something_changes() {
        let mut told = Told::default();
        let (path, error) = (Path::new("a"), |problem: &str| FileError::new(Path::new("a"), problem));
        assert!(told.is_new(path, &error("full")) && !told.is_new(path, &error("full")));
        assert!(told.is_new(Path::new("b"), &error("full")));
        assert!(told.is_new(path, &error("gone")) && told.is_new(path, &error("full")));
        assert!(!told.is_mended() && !told.is_new(path, &error("full")));
        told.is_unsaved = true;
        assert!(told.is_mended() && !told.is_mended() && told.is_new(path, &error("full")));
    }
}

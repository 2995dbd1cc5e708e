//! The errors of a search.

use files::atomic_file::FileError;
use plots::PlotError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a search failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// The optimiser's process could not be run, ended early, or gave an invalid answer.
    #[error("{}: {problem}", .python.display())]
    Optimiser {
        /// The Python that runs it.
        python: PathBuf,
        /// What went wrong.
        problem: String,
    },
    /// Python lacks the library that the optimiser needs.
    #[error("{} has no scikit-optimize ({problem})", .python.display())]
    NoLibrary {
        /// The Python that runs the optimiser.
        python: PathBuf,
        /// The message of Python.
        problem: String,
    },
    /// Anything else.
    #[error("{0}")]
    Failed(String),
}

impl From<FileError> for Error {
    fn from(error: FileError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<PlotError> for Error {
    fn from(error: PlotError) -> Self {
        Self::Failed(error.to_string())
    }
}

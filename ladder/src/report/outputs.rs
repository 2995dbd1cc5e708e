//! The output files of a report.

use crate::error::{Error, Field};
use files::atomic_file;
use std::path::{Path, PathBuf};

/// The output files of a report, besides its text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// A table of all times and counts.
    pub csv: Option<PathBuf>,
    /// A folder for plots and for the tables behind them.
    pub plots: Option<PathBuf>,
}

impl Outputs {
    /// Checks that the files can be written, before anything is measured.
    ///
    /// # Errors
    /// If the table cannot be written at its path, or if the folder does not exist.
    pub fn check(&self) -> Result<(), Error> {
        if let Some(path) = &self.csv {
            atomic_file::check(path).map_err(|error| Error::input(Field::Csv, error.to_string()))?;
        }
        self.plots.as_deref().map_or(Ok(()), |folder| check_folder(folder, Field::Plots))
    }
}

/// Checks that a folder exists.
pub(crate) fn check_folder(folder: &Path, field: Field) -> Result<(), Error> {
    if folder.is_dir() {
        return Ok(());
    }
    Err(Error::input(field, format!("{} is not a folder; make it first", folder.display())))
}

//! The account of a finished search: the profile, the table of all tried points, the plot, and a summary.

mod outcome;
mod plot;
mod profile;
mod subject;
mod table;
mod text;

pub(crate) use outcome::Outcome;
pub(crate) use subject::Subject;

use crate::error::Error;
use std::path::Path;

/// The account of a finished search.
pub struct Account {
    outcome: Outcome,
}

impl Account {
    pub(crate) fn new(outcome: Outcome) -> Self {
        Self { outcome }
    }

    /// What was tried and the result, in two lines of text.
    pub fn text(&self) -> String {
        text::text(&self.outcome)
    }

    /// Writes the profile, with a record of the search. It holds the best point if that is a gain or was not measured
    /// again, else the defaults.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_profile(&self, path: &Path) -> Result<(), Error> {
        profile::write(path, &self.outcome)
    }

    /// Writes all tried points as a table of comma-separated values. The last line is the best point, measured again.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), Error> {
        table::write(path, &self.outcome)
    }

    /// Draws the ratio of every point, the least ratio so far, and the best point with its interval, as an SVG file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_plot(&self, path: &Path) -> Result<(), Error> {
        plot::write(path, &self.outcome)
    }
}

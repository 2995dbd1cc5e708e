//! What a search leaves: the profile with its record, the table of all that was tried, the plot, and some lines.

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

/// A search that is over, to be written and told.
pub struct Account {
    outcome: Outcome,
}

impl Account {
    pub(crate) fn new(outcome: Outcome) -> Self {
        Self { outcome }
    }

    /// What was tried and what came of it, in two lines for people.
    pub fn text(&self) -> String {
        text::text(&self.outcome)
    }

    /// Writes the profile, with a record of the search. It holds the best point if that is a gain or the search was
    /// interrupted, else the defaults.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_profile(&self, path: &Path) -> Result<(), Error> {
        profile::write(path, &self.outcome)
    }

    /// Writes all points that were tried as a table of comma-separated values; the last line is the best, measured
    /// again.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), Error> {
        table::write(path, &self.outcome)
    }

    /// Draws the ratio of every point, the least so far, and the best with its interval, as an SVG file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_plot(&self, path: &Path) -> Result<(), Error> {
        plot::write(path, &self.outcome)
    }
}

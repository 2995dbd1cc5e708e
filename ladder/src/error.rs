//! The errors of a measurement, with the input at fault.

use compare::CompareError;
use files::atomic_file::FileError;
use plots::PlotError;
use std::fmt;

/// An input that can be at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// The table of comma-separated values.
    Csv,
    /// The folder for plots.
    Plots,
    /// The folder for images.
    Images,
    /// The comparison of images over iterations.
    Similarity,
    /// The parameter that is varied.
    Sweep,
    /// A sweep over spheres, in a scene that does not allow it.
    SweepSpheres,
}

impl Field {
    /// The name of the input; that of `SweepSpheres` is `sweep spheres`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Plots => "plots",
            Self::Images => "images",
            Self::Similarity => "similarity",
            Self::Sweep => "sweep",
            Self::SweepSpheres => "sweep spheres",
        }
    }
}

/// Why rows were not measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The request is invalid. Nothing was run or written.
    Input {
        /// The input at fault.
        field: Field,
        /// What is wrong with it, in a sentence.
        problem: String,
    },
    /// Something failed while running or writing.
    Failed(String),
}

impl Error {
    /// An error of the input `field`.
    pub(crate) fn input(field: Field, problem: impl Into<String>) -> Self {
        Self::Input { field, problem: problem.into() }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input { field, problem } => write!(f, "{}: {problem}", field.name()),
            Self::Failed(problem) => f.write_str(problem),
        }
    }
}

impl std::error::Error for Error {}

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

impl From<CompareError> for Error {
    fn from(error: CompareError) -> Self {
        Self::Failed(error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_the_input_at_fault() {
        let names = [
            (Field::Csv, "csv"),
            (Field::Plots, "plots"),
            (Field::Images, "images"),
            (Field::Similarity, "similarity"),
            (Field::Sweep, "sweep"),
            (Field::SweepSpheres, "sweep spheres"),
        ];
        for (field, name) in names {
            assert_eq!(field.name(), name);
            assert_eq!(Error::input(field, "is wrong").to_string(), format!("{name}: is wrong"));
        }
        assert_eq!(Error::Failed("the disk is full".into()).to_string(), "the disk is full");
    }
}

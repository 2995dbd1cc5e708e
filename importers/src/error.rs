//! Errors in files of particles, displayed as one line.

use scene::text::one_line;
use std::fmt;
use thiserror::Error;

/// An error in a file. Displays as one line: `melt.xyz:12:5: what is wrong and what would be right`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}{}: {}", one_line(.name), .place, one_line(.problem))]
pub struct Error {
    /// The path of the file as the caller gave it.
    pub name: String,
    /// Where in the file.
    pub place: Place,
    /// What is wrong, and what would be right.
    pub problem: String,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, from 1, of the decompressed text.
    Line(u64),
    /// A line and a column in bytes, both from 1, of the decompressed text.
    Column(u64, u64),
    /// A byte, from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Column(line, column) => write!(f, ":{line}:{column}"),
            Self::Byte(byte) => write!(f, ": byte {byte}"),
        }
    }
}

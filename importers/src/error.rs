//! Errors in files of particles, displayed as one line.

use scene::text::one_line;
use std::{fmt, io};
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

/// An error before the name of the file is added.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) place: Place,
    pub(crate) problem: String,
}

impl Fault {
    /// A fault of the file as a whole.
    pub(crate) fn file(problem: impl Into<String>) -> Self {
        Self { place: Place::File, problem: problem.into() }
    }

    pub(crate) fn line(line: u64, problem: impl Into<String>) -> Self {
        Self { place: Place::Line(line), problem: problem.into() }
    }

    pub(crate) fn byte(byte: u64, problem: impl Into<String>) -> Self {
        Self { place: Place::Byte(byte), problem: problem.into() }
    }

    /// A failure to read the file.
    pub(crate) fn unread(error: &io::Error) -> Self {
        Self::file(format!("cannot be read: {}", reason(error)))
    }

    pub(crate) fn named(self, name: &str) -> Error {
        Error { name: name.into(), place: self.place, problem: self.problem }
    }
}

/// The error for a frame beyond the last.
pub(crate) fn no_such_frame(number: usize, count: usize) -> Fault {
    Fault::file(match count {
        0 => "has no frame: the file is empty".to_owned(),
        1 => format!("has no frame {number}; it has one frame, number 0"),
        _ => format!("has no frame {number}; it has {count} frames, 0 to {}", count - 1),
    })
}

/// The message of an I/O error, without the error number that Rust appends.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

/// `text` in double quotes for a message: cut after 40 characters, control characters escaped.
pub(crate) fn quote(text: &[u8]) -> String {
    const MOST: usize = 40;
    let cut = &text[..text.len().min(4 * MOST + 4)];
    let shown: String = String::from_utf8_lossy(cut).chars().take(MOST).collect();
    let more = if shown.len() < text.len() { "..." } else { "" };
    format!("\"{}{more}\"", shown.escape_debug())
}

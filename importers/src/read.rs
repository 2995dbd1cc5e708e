//! Reads files of all formats.

use crate::error::{Error, Place};
use crate::format::Format;
use crate::particles::Particles;
use crate::request::Request;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// Reads the particles of one frame of a file.
///
/// The format is told by the name and, where that is doubtful, by the content. Uses the threads of the current rayon
/// pool.
///
/// # Errors
/// If the file cannot be read, is in no format of [`Format`], is damaged, has no such frame, or does not fit the memory.
pub fn read(path: &Path, _request: &Request) -> Result<Particles, Error> {
    Err(unfinished(&path.display().to_string()))
}

/// Like [`read`], from an input that is in memory or open already. `name` stands in errors.
///
/// # Errors
/// Like [`read`].
pub fn read_from(
    name: &str,
    _input: impl Read + Seek,
    _format: Format,
    _request: &Request,
) -> Result<Particles, Error> {
    Err(unfinished(name))
}

/// The number of frames of a file. Reads all of a text file, quickly.
///
/// # Errors
/// Like [`read`].
pub fn frames(path: &Path) -> Result<usize, Error> {
    Err(unfinished(&path.display().to_string()))
}

/// A file of several frames with an index of where they start, so that each is found at once. (In compressed files all
/// that is before a frame has to be decompressed again.)
#[derive(Debug)]
pub struct Trajectory {
    path: PathBuf,
    format: Format,
}

impl Trajectory {
    /// Opens a file and looks where its frames start.
    ///
    /// # Errors
    /// Like [`read`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        Err(unfinished(&path.display().to_string()))
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        0
    }

    /// The format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// Like [`read`].
    pub fn read(&self, _request: &Request) -> Result<Particles, Error> {
        Err(unfinished(&self.path.display().to_string()))
    }
}

fn unfinished(name: &str) -> Error {
    Error { name: name.into(), place: Place::File, problem: "cannot be read yet".into() }
}

//! The result of a render.

use crate::job::Job;
use crate::report::Report;
use crate::snapshot::Snapshot;
use files::atomic_file::FileError;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// The result of a render.
#[derive(Debug)]
pub struct Outcome {
    /// Why the render ended.
    pub end: End,
    /// Times, counts and settings of the render.
    pub report: Report,
    /// The relative error of the image as far as it is noise, estimated as [`crate::Estimate`] does, from a sample of the
    /// pixels; `None` before the second iteration of this session.
    pub noise: Option<f64>,
    /// Time spent developing images and writing files.
    pub writing: Duration,
    /// The last checkpoint written or resumed, if any. If the render was completed, it may have been removed since.
    pub saved: Option<Saved>,
    /// Why the last checkpoint could not be written at its path, or not be removed.
    pub unsaved: Option<FileError>,
    /// The files that were written.
    pub written: Vec<PathBuf>,
    /// The files that could not be written.
    pub failed: Vec<Unwritten>,
    /// The last image, if [`Job::live`] is set and an iteration was completed.
    pub last: Option<Arc<Snapshot>>,
    /// The job, which can be changed and started again, with a new [`Job::stop`]. It keeps its thread pool and reusable
    /// parts of the engine.
    pub job: Job,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All iterations are done.
    Iterations,
    /// The time limit is reached.
    Time,
    /// The estimated error is small enough.
    Error,
    /// A stop was requested.
    Stopped,
}

/// A checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// Iterations in it.
    pub iterations: u32,
}

/// A file that could not be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unwritten {
    /// The file, and why it could not be written.
    pub error: FileError,
    /// Where its content was written instead, if that was possible.
    pub refuge: Option<PathBuf>,
}

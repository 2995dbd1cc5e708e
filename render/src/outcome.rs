//! How a render ended, and what it left.

use crate::job::Job;
use crate::report::Report;
use crate::snapshot::Snapshot;
use files::atomic_file::FileError;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// How a render ended, and what it left.
#[derive(Debug)]
pub struct Outcome {
    /// What ended it.
    pub end: End,
    /// What was done.
    pub report: Report,
    /// Time spent developing and writing files.
    pub writing: Duration,
    /// The checkpoint that is there.
    pub saved: Option<Saved>,
    /// Why the last checkpoint could not be written where it should be, or not be removed.
    pub unsaved: Option<FileError>,
    /// The files that were written.
    pub written: Vec<PathBuf>,
    /// The files that were not.
    pub failed: Vec<Unwritten>,
    /// The last image, if [`Job::live`] asked for images and an iteration was done.
    pub last: Option<Arc<Snapshot>>,
    /// The job, to be changed and started again, with a new [`Job::stop`]. Threads and what the engine prepared are kept
    /// with it.
    pub job: Job,
}

/// What ended a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All iterations are done.
    Iterations,
    /// Time is up.
    Time,
    /// The estimated error is small enough.
    Error,
    /// Somebody asked it to stop.
    Stopped,
}

/// A checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// Iterations that it holds.
    pub iterations: u32,
}

/// A file that could not be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unwritten {
    /// Which file, and why.
    pub error: FileError,
    /// Where its content is instead, if there was a place.
    pub refuge: Option<PathBuf>,
}

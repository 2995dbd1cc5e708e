//! What `--stats` writes: settings, seconds per pass and counted work, as one JSON object.

use crate::names::{EngineName, LanesName};
use scene::{Settings, Stats};
use serde::Serialize;
use std::io::{self, Write};

/// A render, for people who measure.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Of this command.
    pub version: &'static str,
    /// The scene's own name.
    pub scene: String,
    /// What rendered.
    pub engine: EngineName,
    /// The lanes that it ran on, if it has any.
    pub lanes: Option<LanesName>,
    /// How many threads worked.
    pub threads: usize,
    /// What was asked for.
    pub settings: Settings,
    /// Iterations that the image holds; fewer than asked for if the render was interrupted.
    pub iterations: u32,
    /// True if a request to end came before the last iteration did.
    pub interrupted: bool,
    /// What ended the render.
    pub ended_by: &'static str,
    /// Iterations that were taken over from a checkpoint.
    pub resumed_after: u32,
    /// The last estimate of the relative error, if one was asked for.
    pub estimated_error: Option<f64>,
    /// From the first iteration's start to the last one's end; of this session alone.
    pub wall_seconds: f64,
    /// Developing and writing images; of this session alone. Only the last ones are not part of `wall_seconds`.
    pub write_seconds: f64,
    /// The figure that was told before the start.
    pub bytes_at_most: u64,
    /// The most memory that the process held, where the system tells.
    pub peak_bytes: Option<u64>,
    /// The engine's own account, of all sessions.
    #[serde(flatten)]
    pub stats: Stats,
}

impl Report {
    /// Writes the object as JSON for programs and people.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        out.write_all(b"\n")
    }
}

//! What `--stats` writes: settings, seconds per pass and counted work, as one JSON object.

use crate::engines::EngineName;
use scene::{Settings, Stats};
use serde::Serialize;
use std::io::{self, Write};

/// A render, for people who measure.
#[derive(Serialize)]
pub(crate) struct Report {
    /// Of this command.
    pub version: &'static str,
    /// The scene's own name.
    pub scene: String,
    /// What rendered.
    pub engine: EngineName,
    /// How many threads worked.
    pub threads: usize,
    /// What was asked for.
    pub settings: Settings,
    /// Iterations that the image holds; fewer than asked for if the render was interrupted.
    pub iterations: u32,
    /// True if a request to end came before the last iteration did.
    pub interrupted: bool,
    /// From the first iteration's start to the last one's end, developing included.
    pub wall_seconds: f64,
    /// Developing, once per iteration.
    pub develop_seconds: f64,
    /// The engine's own account.
    #[serde(flatten)]
    pub stats: Stats,
}

impl Report {
    /// Writes the object as JSON for programs and people.
    pub(crate) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        out.write_all(b"\n")
    }
}

//! Who follows a render.

use crate::names::{EngineName, LanesName};
use crate::step::Step;
use files::atomic_file::FileError;
use scene::{Resumable, Settings};
use std::path::PathBuf;

/// Follows a render from the thread that it runs on. What takes long here holds the render up.
pub trait Observer: Send + 'static {
    /// Whether [`Self::after`] is of use. Asked before every iteration's end, as a step costs a look at every pixel.
    fn follows(&self) -> bool {
        true
    }

    /// Called after each iteration, with the render as it stands.
    fn after(&mut self, _step: &Step, _render: &dyn Resumable) {}

    /// Called when there is something else to tell.
    fn notice(&mut self, _notice: &Notice) {}

    /// What [`crate::Report::ended_by`] says if the render was stopped.
    fn stopped_by(&self) -> &'static str {
        "stop"
    }
}

/// Nobody follows.
impl Observer for () {
    fn follows(&self) -> bool {
        false
    }
}

/// Something that happens beside the iterations.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// All is checked, and the render begins.
    Begun {
        /// The scene's own name.
        scene: String,
        /// The settings.
        settings: Settings,
        /// What renders.
        engine: EngineName,
        /// On which lanes, if it has any.
        lanes: Option<LanesName>,
        /// How many threads work.
        threads: usize,
        /// The most memory that it will take.
        bytes_at_most: u64,
    },
    /// The render was resumed from a checkpoint.
    Resumed {
        /// The checkpoint.
        path: PathBuf,
        /// Iterations that it holds.
        iterations: u32,
        /// Iterations that are asked for.
        of: u32,
        /// Why this is the older generation, if it is.
        fallback: Option<FileError>,
    },
    /// A checkpoint was written.
    Saved {
        /// Iterations that it holds.
        iterations: u32,
    },
    /// A checkpoint could not be written. The render goes on.
    NotSaved(FileError),
    /// An image could not be refreshed. The render goes on.
    NotRefreshed(FileError),
    /// The snapshot of an iteration could not be written. The render goes on.
    NoSnapshot(FileError),
}

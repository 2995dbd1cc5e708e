//! The interface through which a front end follows a render.

use crate::image::Image;
use crate::names::{LanesName, Renderer};
use crate::step::Step;
use files::atomic_file::FileError;
use scene::{Automatic, Resumable, Settings};
use std::path::PathBuf;

/// Follows a render. The methods are called on the render's thread and delay it while they run.
pub trait Observer: Send + 'static {
    /// Whether [`Self::after`] is to be called. Asked after every iteration; if not, the mean radius, which takes a
    /// pass over all pixels, is not computed.
    fn follows(&self) -> bool {
        true
    }

    /// Called after each iteration, with the state of the render.
    fn after(&mut self, _step: &Step, _render: &dyn Resumable) {}

    /// Whether [`Self::image`] is to be called. Asked after every iteration, and once more when the render has ended with
    /// an image.
    fn wants_image(&mut self, _is_last: bool) -> bool {
        false
    }

    /// Called with the image and its planes after an iteration, if [`Self::wants_image`].
    fn image(&mut self, _image: Image) {}

    /// Called on events other than iterations.
    fn notice(&mut self, _notice: &Notice) {}

    /// The value of [`crate::Report::ended_by`] if the render was stopped.
    fn stopped_by(&self) -> &'static str {
        "stop"
    }
}

/// No observer.
impl Observer for () {
    fn follows(&self) -> bool {
        false
    }
}

/// An event other than an iteration.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// The job is validated, and the render starts.
    Begun {
        /// The scene's own name.
        scene: String,
        /// The settings.
        settings: Settings,
        /// Which of the settings were chosen.
        chosen: Automatic,
        /// How many iterations are asked for: of a part of a render, its own.
        wanted: u32,
        /// The method and the engine.
        renderer: Renderer,
        /// The lanes that it runs on, if it has any.
        lanes: Option<LanesName>,
        /// Number of threads.
        threads: usize,
        /// Upper bound of the memory that the render takes.
        bytes_at_most: u64,
    },
    /// The render was resumed from a checkpoint.
    Resumed {
        /// The checkpoint.
        path: PathBuf,
        /// Iterations in the checkpoint.
        iterations: u32,
        /// Total iterations of the render.
        of: u32,
        /// Why the newest generation could not be used, if this is the older one.
        fallback: Option<FileError>,
    },
    /// The render to repeat was made by another version of the light transport, so that the image will be another.
    OtherTransport {
        /// The file whose render is repeated.
        path: PathBuf,
        /// The version that made it.
        transport: u32,
    },
    /// A checkpoint was written.
    Saved {
        /// Iterations in the checkpoint.
        iterations: u32,
    },
    /// A file that the render will write could not be locked, as its file system has no locks. Nothing keeps another
    /// render from writing it too.
    NotLocked(FileError),
    /// A checkpoint could not be written. The render continues.
    NotSaved(FileError),
    /// An image could not be refreshed. The render continues.
    NotRefreshed(FileError),
    /// The snapshot of an iteration could not be written. The render continues.
    NoSnapshot(FileError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_follows_nothing() {
        assert!(!().follows() && !().wants_image(true) && !().wants_image(false));
        assert_eq!(().stopped_by(), "stop");
    }

    #[test]
    fn an_observer_follows_unless_it_says_otherwise() {
        struct Usual;
        impl Observer for Usual {}
        assert!(Usual.follows() && !Usual.wants_image(true));
    }
}

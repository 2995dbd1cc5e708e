//! Runs renders for any front end: takes a scene and goals, and produces images, checkpoints and a report.
//!
//! ```
//! use render::Job;
//!
//! let mut scene = files::builtin::scene("cornell").unwrap();
//! (scene.settings.width, scene.settings.height, scene.settings.iterations) = (32, 24, 3);
//! let running = Job::new(scene).start(())?;
//! let outcome = running.wait()?;
//! assert_eq!(outcome.last.unwrap().iterations, 3);
//! # Ok::<(), render::Error>(())
//! ```
//!
//! A [`Job`] describes a render. [`Job::start`] validates it and returns a [`Running`] render, which any thread can ask
//! for its newest image or stop. [`Running::wait`] returns the [`Outcome`], including the job, which can be changed and
//! started again. An [`Observer`] is notified of every iteration and of other events.
//!
//! The library owns its threads and prints nothing. It has no global state, installs no signal handlers, and never
//! exits the process. An [`Error`] names the [`Field`] at fault, so that each front end can use its own names in
//! messages.

#![forbid(unsafe_code)]

mod automatic;
mod backdrop;
mod choice;
mod error;
mod estimate;
mod goals;
mod image;
mod job;
mod keeper;
mod locks;
mod made;
mod memory;
pub mod merge;
mod metadata;
mod names;
mod noise;
mod observer;
mod outcome;
mod outputs;
mod pool;
mod prepare;
mod profile;
mod report;
mod running;
mod save;
mod session;
mod snapshot;
mod step;
mod stream;
mod trace;
mod warm;
mod writer;

pub use choice::EngineChoice;
pub use error::{Error, Field, Problem};
pub use estimate::Estimate;
pub use goals::Goals;
pub use image::Image;
pub use job::Job;
pub use made::Made;
pub use metadata::Metadata;
pub use names::{EngineName, LanesName, MethodName, Renderer, available_lanes};
pub use observer::{Notice, Observer};
pub use outcome::{End, Outcome, Saved, Unwritten};
pub use outputs::{Outputs, is_exposed};
pub use pool::{cores, pool};
pub use profile::Profile;
pub use report::Report;
pub use running::Running;
pub use save::{Every, Note, Save};
pub use snapshot::Snapshot;
pub use step::Step;
pub use stream::Stream;
pub use trace::trace;

//! The fast engine: the reference's image, bit for bit, in AVX2 or AVX-512.
//!
//! ```
//! use files::builtin;
//! use scene::{Engine, Settings};
//!
//! let scene = builtin::scene("cornell").unwrap();
//! let settings =
//!     Settings { width: 32, height: 24, photons_per_iteration: 1000, iterations: 2, ..scene.settings };
//! let mut engine = fast::Sppm::new(&scene, &settings);
//! for _ in 0..settings.iterations {
//!     engine.iterate();
//! }
//! let film = engine.develop();
//! assert_eq!(film.pixels.len(), 32 * 24);
//!
//! // The image does not depend on the vectors that it is computed on.
//! let mut plain = fast::Sppm::with_lanes(&scene, &settings, fast::LaneKind::Emulated);
//! plain.iterate();
//! plain.iterate();
//! assert_eq!(plain.develop(), film);
//! ```
//!
//! [`Sppm`] runs the passes of an iteration over all threads of the current rayon pool, each pass in jobs of whole
//! batches. [`LaneKind`] names the vectors that it may run on, [`Parameters`] what else is free; [`Intersector`]
//! gives its ray queries by themselves.
//!
//! To read the code, begin with `lanes/mod.rs` (the operations that all kernels are written in) and `dispatch.rs`
//! (where a back end is chosen); then `sppm.rs` (the passes in order), and per pass `camera_pass.rs`,
//! `photon_pass.rs`, `join/mod.rs` and `consolidate.rs`. Each of them opens with its loop as pseudo code and with how
//! it differs from the reference's, and why. `ARCHITECTURE.md` says what bounds each pass and what was tried.

// Without it the processor's features do not reach the operations, see `lanes`.
#![allow(clippy::inline_always)]
// Iterators take closures, and closures do not inherit the features: loops over lanes count.
#![allow(clippy::needless_range_loop)]

pub(crate) mod camera_pass;
mod consolidate;
mod direct_light;
pub mod dispatch;
mod hierarchy;
mod intersect;
mod intersector;
mod jobs;
mod join;
#[doc(hidden)]
pub mod kernels;
pub mod lanes;
mod light_choice;
mod pages;
mod parameters;
mod paths;
mod photon_pass;
mod pool;
mod sampling;
mod scatter;
mod sppm;
mod tables;
mod trace;
mod vec3;

pub use dispatch::LaneKind;
pub use hierarchy::{Search, Work, ball_count};
pub use intersector::{Intersector, Met};
pub use parameters::{Parameter, ParameterError, Parameters, Values};
pub use sppm::{DEPOSITS_AT_ONCE, Sppm};

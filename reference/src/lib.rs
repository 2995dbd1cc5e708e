//! The scalar reference engine. It defines the correct image, in code short enough to check against the equations in
//! one sitting.
//!
//! ```
//! use files::builtin;
//! use scene::{Engine, Settings};
//!
//! let scene = builtin::scene("cornell").unwrap();
//! let settings = Settings { width: 32, height: 24, photons_per_iteration: 1000, ..scene.settings };
//! let mut engine = reference::Sppm::new(&scene, &settings);
//! engine.iterate();
//! assert_eq!(engine.iterations(), 1);
//! assert_eq!(engine.develop().pixels.len(), 32 * 24);
//! ```
//!
//! Read it in this order: [`intersect`] (what a ray hits), [`sampling`] and [`scatter`] (where light goes),
//! [`light_choice`] and [`direct_light`], then the passes of an iteration as [`Sppm`] runs them: [`camera_pass`] (with [`glints`]),
//! [`grid`], [`survey`](mod@survey) and [`emission`], [`photon_pass`], [`consolidate`]. [`PathTracer`] computes the same image by another algorithm, without bias.
//!
//! Every formula is part of the contract: the fast engine evaluates the same operations in the same order, so that
//! both give the same bits. So comparisons are written out where a library's minimum or maximum would leave the result
//! for NaN open, and no multiplication is fused with an addition.

#![forbid(unsafe_code)]

pub mod camera_pass;
pub mod consolidate;
pub mod direct_light;
pub mod emission;
pub mod glints;
pub mod grid;
pub mod intersect;
pub mod light_choice;
mod path_tracer;
pub mod photon_numbers;
pub mod photon_pass;
pub mod sampling;
pub mod scatter;
mod sppm;
pub mod survey;

pub use path_tracer::PathTracer;
pub use sppm::{Sppm, contributes};

/// Path tracing with photons for caustics: both renders must be of the same scene and settings, with radii per pixel, and must
/// not have begun.
pub fn hybrid<'a>(paths: PathTracer<'a>, photons: Sppm<'a>) -> scene::Hybrid<PathTracer<'a>, Sppm<'a>> {
    scene::Hybrid::new(paths.without_caustics(), photons.of_caustics())
}

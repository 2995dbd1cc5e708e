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
//! [`Sppm`] is photon mapping; [`PathTracer`] renders the same scenes by path tracing. Both render on the threads of the
//! current rayon pool. [`LaneKind`] names the vectors that they run on, [`Parameters`] what else their speed depends on.
//! [`Intersector`] answers ray queries without a render.
//!
//! To read the code, begin with the crate `lanes`, whose operations all kernels are written in. Then follow an iteration:
//! `sppm/render.rs` runs the passes in order, and each pass has a folder or file that opens with its loop as pseudo code,
//! with how it differs from the reference's, and why: `camera_pass`, `photon_pass`, `join`, `consolidate`. So does
//! `path_tracer`.
//! `ARCHITECTURE.md` says what bounds each pass and what was tried.

#![forbid(unsafe_code)]
// Features reach the operations of lanes by inlining only, see `lanes`.
#![allow(clippy::inline_always)]
// Iterators take closures, and closures do not inherit the features: loops over lanes count.
#![allow(clippy::needless_range_loop)]

mod camera_pass;
mod consolidate;
mod direct_light;
mod eye;
mod glints;
mod global;
mod hierarchy;
mod intersect;
mod intersector;
mod join;
#[doc(hidden)]
pub mod kernels;
mod light_choice;
mod light_tree;
mod lit_points;
mod material;
mod pages;
mod parameters;
mod path_tracer;
mod paths;
mod photon_pass;
mod pixels;
mod pool;
mod prepared;
mod rays;
mod rows;
mod sampling;
mod scatter;
mod search;
mod shaft;
mod shape_list;
mod shapes;
mod sppm;
mod surface;
mod survey;
mod tables;
mod trace;
mod work_items;

pub use intersector::{Intersector, Met};
pub use lanes::LaneKind;
pub use parameters::{Parameter, ParameterError, Parameters, Values};
pub use path_tracer::PathTracer;
pub use search::{Search, Work, ball_count};
pub use sppm::{DEPOSITS_AT_ONCE, DEPOSITS_OF_PILOTS, Parts, Sppm, first_radii, first_radii_for};

/// Path tracing with photons for caustics: both renders must be of the same scene and settings, with radii per pixel, and must
/// not have begun.
pub fn hybrid<'a>(paths: PathTracer<'a>, photons: Sppm<'a>) -> scene::Hybrid<PathTracer<'a>, Sppm<'a>> {
    scene::Hybrid::new(paths.without_caustics(), photons.of_caustics())
}

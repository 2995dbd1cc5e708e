//! The path tracer: `reference::path_tracer`, over batches of paths.
//!
//! ```text
//! for each work item of 1024 pixels, on any thread:
//!     until no path is left:
//!         fill the batch up to 256 paths with rays through the next pixels
//!         intersect all
//!         for each packet:
//!             if the list of diffuse hits is full: direct light for all on it, in full packets; add it to the samples
//!             add the emission of lamps that count; fetch surface and material
//!             diffuse hits that receive direct light go to the list, once for each of their shadow rays
//!             scatter; roulette; paths that go on to the front of the batch
//!         direct light for the rest of the list
//! add the samples to the sums of the pixels
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. Stages over a batch: see [`crate::paths`]. The list of diffuse hits does for shadow rays what the front of the
//!    batch does for paths: lanes stay full, whatever mirrors and glass there are.
//! 2. Batches are filled up after every stage. Paths end early and late: a batch that ran dry would spend most of its
//!    stages on a few paths, which keep neither lanes nor memory busy.
//! 3. Radiance does not travel with the path. It is added to the pixel's sample, in the reference's order: a stage adds
//!    emission and then direct light, and only then follows the next hit.
//! 4. All lanes compute the next random number, and those that do not need one keep their old stream ([`batch`]): as in the
//!    reference, which numbers a path gets depends on what it hits.
//! 5. Pixels are in tile order: see [`crate::pixels`].

mod batch;
mod engine;
mod memory;
mod numbers;
mod workers;

pub use engine::PathTracer;

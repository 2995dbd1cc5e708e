//! The path tracer: `reference::path_tracer`, over batches of pixels.
//!
//! ```text
//! for each work item of 1024 pixels, on any thread:
//!     for each batch of 256 pixels (four tiles of 8x8):
//!         make the rays
//!         until no path is left:
//!             intersect all
//!             for each packet:
//!                 add the emission of lamps that count; fetch surface and material
//!                 diffuse hits that count direct light go to a list
//!                 scatter; roulette; paths that go on to the front of the batch
//!             direct light for all on the list, in full packets; add it to the samples
//! add the samples to the sums of the pixels
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. Stages over a batch: see [`crate::paths`]. The list of diffuse hits does for shadow rays what the front of the
//!    batch does for paths: lanes stay full, whatever mirrors and glass there are.
//! 2. Radiance does not travel with the path. It is added to the pixel's sample, in the reference's order: a stage adds
//!    emission and then direct light, and only then follows the next hit.
//! 3. All lanes compute the next random number, and those that do not need one keep their old stream ([`batch`]): as in the
//!    reference, which numbers a path gets depends on what it hits.
//! 4. Pixels are in tile order: see [`crate::pixels`].

mod batch;
mod engine;
mod memory;
mod workers;

pub use engine::PathTracer;

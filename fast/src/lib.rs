//! The fast engine: the reference's image, bit for bit, in AVX2 or AVX-512.

// Without it the processor's features do not reach the operations, see `lanes`.
#![allow(clippy::inline_always)]
// Iterators take closures, and closures do not inherit the features: loops over lanes count.
#![allow(clippy::needless_range_loop)]

pub(crate) mod camera_pass;
mod consolidate;
mod direct_light;
mod dispatch;
mod hierarchy;
mod intersect;
mod intersector;
mod join;
mod lanes;
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
pub use hierarchy::Search;
pub use intersector::Intersector;
pub use sppm::{DEPOSITS_AT_ONCE, Sppm};

//! The ladder compares the stages of a published optimisation of stochastic progressive photon mapping, including its
//! failed attempts and what it proposes for future work.
//!
//! There is one pipeline and one table of rows ([`ROWS`]). A row names the parts that differ: the generator of random
//! numbers, the memory layout of pixels and visible points, the spatial index, the calls of vector math, and the number
//! of rays and candidates processed at a time. All rows render the physics of the `reference` crate, without the faults
//! of the published program. With keyed random numbers and integer flux ([`Options::exact`]) every row gives the
//! reference's image bit for bit, so rows differ only in time. As in the paper, direct light comes from lights chosen by
//! power; the reference does the same after `reference::Sppm::lit_by_power`.
//!
//! [`report`] runs and measures rows, and makes the tables and plots of `sppm ladder`.
//!
//! The rows exist only to be measured; renders use the `fast` crate. Kernels are written once, generic over vectors of
//! one or of eight lanes; on one lane a mask is a `bool` and a blend is a branch.

#![forbid(unsafe_code)]
// Without `inline(always)` the operations are compiled without the processor's features, see `lanes`.
#![allow(clippy::inline_always)]
// Iterators take closures, which do not inherit the processor's features; so loops over lanes use indices.
#![allow(clippy::needless_range_loop)]

mod camera_pass;
mod counted;
mod direct_light;
mod error;
mod flux;
mod index;
mod intersect;
mod join;
mod machine;
mod numbers;
mod one;
mod options;
mod photon_pass;
mod pipeline;
mod pixels;
pub mod report;
mod rung;
mod sampling;
mod scatter;
mod table;
mod tables;
mod vector;

pub use counted::Operations;
pub use error::{Error, Field};
pub use index::Tuning;
pub use machine::{Bandwidth, Clock, CycleCounter, CycleSource, Level, Peaks};
pub use numbers::timing::{NumberTimes, time_numbers};
pub use numbers::words::Words;
pub use options::{Options, Random, Sums};
pub use rung::Rung;
pub use table::{Description, ROWS, Row, find};

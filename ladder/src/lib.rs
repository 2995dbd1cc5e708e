//! The ladder: the stages of a published optimisation of stochastic progressive photon mapping, its failed attempts
//! and what it proposed for the future, side by side.
//!
//! There is one pipeline and one table ([`ROWS`]). A row names the parts that differ: the generator of random numbers,
//! how pixels and visible points lie in memory, the spatial index, how vector math is called, and how many rays and
//! candidates are followed at a time. All rows render the physics of the `reference` crate, whose faults are none of
//! the published program's: with keyed random numbers and integer flux ([`Options::exact`]) every row gives the
//! reference's image bit for bit, and so what differs between rows is time alone.
//!
//! [`report`] runs rows, measures them, and makes tables and plots of that, as `sppm ladder` shows them.
//!
//! Nothing here is for use in a product: the rows are there to be measured. Kernels are written once, generic over
//! vectors of one or of eight lanes; on one lane a mask is a `bool` and a blend is a branch.

#![forbid(unsafe_code)]
// Without it the processor's features do not reach the operations, see `lanes`.
#![allow(clippy::inline_always)]
// Iterators take closures, and closures do not inherit the features: loops over lanes count.
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

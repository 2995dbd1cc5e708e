//! The peaks of one thread.

use super::bandwidth::{self, Bandwidth};
use super::clock::Clock;
use super::flops;

/// The peaks of one thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Peaks {
    /// Cycles in a second, while the peaks were measured.
    pub clock: Clock,
    /// Operations a second by fused multiply-adds of single floats; a multiply-add counts as two.
    pub scalar_flops: f64,
    /// The same by vectors of eight floats.
    pub vector_flops: f64,
    /// Reading from the caches and from memory, the nearest first.
    pub bandwidths: Vec<Bandwidth>,
}

impl Peaks {
    /// Measures them, which takes about a second. Nothing else should run.
    pub fn measure() -> Self {
        Self {
            clock: Clock::measure(),
            scalar_flops: flops::scalar(),
            vector_flops: flops::vector(),
            bandwidths: bandwidth::measure(),
        }
    }
}

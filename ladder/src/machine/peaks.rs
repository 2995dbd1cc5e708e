//! The measured peaks of one thread: clock, floating-point operations and memory bandwidth.

use super::bandwidth::{self, Bandwidth};
use super::clock::Clock;
use super::flops;

/// The measured peaks of one thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Peaks {
    /// The clock while the peaks were measured.
    pub clock: Clock,
    /// FLOPs per second with fused multiply-adds of single floats; a multiply-add counts as two.
    pub scalar_flops: f64,
    /// FLOPs per second with vectors of eight floats.
    pub vector_flops: f64,
    /// Read bandwidths of the caches and of memory, the nearest level first.
    pub bandwidths: Vec<Bandwidth>,
}

impl Peaks {
    /// Measures the peaks, which takes about a second. Nothing else should run on the machine.
    pub fn measure() -> Self {
        Self {
            clock: Clock::measure(),
            scalar_flops: flops::scalar(),
            vector_flops: flops::vector(),
            bandwidths: bandwidth::measure(),
        }
    }
}

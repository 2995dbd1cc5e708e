//! What the machine can do at most, measured: floating-point operations and memory traffic of one thread, and cycles.

mod bandwidth;
mod clock;
mod flops;

pub use bandwidth::{Bandwidth, Level};
pub use clock::{Clock, CycleCounter, CycleSource};

use std::time::Instant;

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

/// How often a measurement is repeated; the best counts, as whatever disturbs it makes it slower.
const TRIALS: usize = 25;

/// Seconds of what `run` does, at best.
pub(crate) fn best_seconds(mut run: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..TRIALS {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

/// The most of `work` done in a second, by `run` doing it.
fn best_rate(work: f64, run: impl FnMut()) -> f64 {
    work / best_seconds(run)
}

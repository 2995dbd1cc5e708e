//! Measuring at best: what disturbs a measurement makes it slower.

use std::time::Instant;

/// How often a measurement is repeated; the best counts.
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
pub(crate) fn best_rate(work: f64, run: impl FnMut()) -> f64 {
    work / best_seconds(run)
}

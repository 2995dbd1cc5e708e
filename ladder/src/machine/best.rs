//! Measures by the best of several trials, as disturbances only ever make a trial slower.

use std::time::Instant;

/// The number of trials, of which the best counts.
const TRIALS: usize = 25;

/// The least seconds that `run` took.
pub(crate) fn best_seconds(mut run: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..TRIALS {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

/// The highest rate of work per second, if `run` does `work`.
pub(crate) fn best_rate(work: f64, run: impl FnMut()) -> f64 {
    work / best_seconds(run)
}

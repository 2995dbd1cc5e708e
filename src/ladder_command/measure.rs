//! Interleaved runs, and what comes of them.

use super::cases::Case;
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use ladder::{CycleCounter, Options, Row};
use render::pool;
use scene::Stats;
use std::time::Instant;

/// One run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// Wall-clock seconds from the start to the developed image.
    pub seconds: f64,
    /// Cycles of all of it, where the machine lends a counter.
    pub cycles: Option<u64>,
    pub stats: Stats,
}

/// All runs of one row in one case.
#[derive(Clone, Debug)]
pub(crate) struct Runs {
    /// By increasing time.
    sorted: Vec<Run>,
}

impl Runs {
    fn new(mut runs: Vec<Run>) -> Self {
        runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        Self { sorted: runs }
    }
    /// The run in the middle (of two, the faster).
    pub(crate) fn median(&self) -> &Run {
        &self.sorted[(self.sorted.len() - 1) / 2]
    }
    /// Seconds of the fastest run.
    pub(crate) fn least(&self) -> f64 {
        self.sorted[0].seconds
    }
    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.sorted.len()
    }
}

/// Runs every row in every case, `repeat` times over. Gives, for each case, the runs of each row.
pub(crate) fn measure(
    cases: &[Case],
    rows: &[&Row],
    options: &Options,
    repeat: u32,
) -> Result<Vec<Vec<Runs>>, Error> {
    let total = repeat as usize * cases.len() * rows.len();
    let progress = Bar::of(total as u32, "runs");
    let one_thread = pool(Some(1))?;
    let mut runs = vec![vec![Vec::new(); rows.len()]; cases.len()];
    let mut done = 0;
    for _ in 0..repeat {
        for (case, of_case) in cases.iter().zip(&mut runs) {
            for (row, of_row) in rows.iter().zip(of_case) {
                progress.step(done, &format!("{} row {}", case.name, row.name));
                of_row.push(one_thread.install(|| run(case, row, options)));
                done += 1;
            }
        }
    }
    progress.clear();
    Ok(runs.into_iter().map(|of_case| of_case.into_iter().map(Runs::new).collect()).collect())
}

fn run(case: &Case, row: &Row, options: &Options) -> Run {
    let mut counter = CycleCounter::open();
    if let Some(counter) = &mut counter {
        counter.start();
    }
    let began = Instant::now();
    let mut rung = row.start(&case.scene, &case.settings, options);
    for _ in 0..case.settings.iterations {
        rung.iterate();
    }
    let film = rung.develop();
    let seconds = began.elapsed().as_secs_f64();
    let cycles = counter.and_then(|mut counter| counter.stop());
    // So that developing is not optimised away.
    std::hint::black_box(&film);
    Run { seconds, cycles, stats: *rung.stats() }
}

/// The exponent with which `y` grows as a power of `x`: the slope of the line of least squares through the logarithms.
pub(crate) fn exponent(points: &[(f64, f64)]) -> f64 {
    let logarithms: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logarithms.len() as f64;
    let (mean_x, mean_y) = logarithms.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (x, y) in logarithms {
        covariance += (x - mean_x) * (y - mean_y);
        variance += (x - mean_x) * (x - mean_x);
    }
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_of_the_run_in_the_middle() {
        let run = |seconds| Run { seconds, cycles: None, stats: Stats::default() };
        let median = |all: &[f64]| Runs::new(all.iter().copied().map(run).collect()).median().seconds;
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0]), 1.0);
        assert_eq!(median(&[5.0]), 5.0);
    }

    #[test]
    fn exponents_of_powers_are_found() {
        let points = |p: f64| [1.0_f64, 2.0, 8.0].map(|x| (x, 3.0 * x.powf(p)));
        for power in [0.0, 1.0, 1.5] {
            approx::assert_abs_diff_eq!(exponent(&points(power)), power, epsilon = 1e-12);
        }
    }
}

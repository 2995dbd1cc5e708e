//! Times all rows in interleaved runs.

use super::case::Case;
use super::progress::Progress;
use crate::error::Error;
use crate::machine::CycleCounter;
use crate::options::Options;
use crate::table::Row;
use files::atomic_file::reason;
use rayon::ThreadPoolBuilder;
use scene::Stats;
use std::time::Instant;

/// One run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// Wall-clock seconds from the start to the developed image.
    pub(crate) seconds: f64,
    /// Cycles of the whole run, if the system gives access to a counter.
    pub(crate) cycles: Option<u64>,
    /// Seconds and counts by pass.
    pub(crate) stats: Stats,
}

/// All runs of one row in one case.
#[derive(Clone, Debug)]
pub(crate) struct Runs {
    /// Sorted by increasing time.
    sorted: Vec<Run>,
}

impl Runs {
    fn new(mut runs: Vec<Run>) -> Self {
        runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        Self { sorted: runs }
    }

    /// The median run; of an even number, the faster of the two in the middle.
    pub(crate) fn median(&self) -> &Run {
        &self.sorted[(self.sorted.len() - 1) / 2]
    }

    /// Seconds of the fastest run.
    pub(crate) fn least(&self) -> f64 {
        self.sorted[0].seconds
    }

    /// The number of runs.
    pub(crate) fn count(&self) -> usize {
        self.sorted.len()
    }
}

/// Runs every row in every case on one thread, `repeat` times. Returns the runs of each row, for each case.
pub(crate) fn measure(
    cases: &[Case],
    rows: &[&Row],
    options: &Options,
    repeat: u32,
    progress: &mut dyn Progress,
) -> Result<Vec<Vec<Runs>>, Error> {
    let one_thread = ThreadPoolBuilder::new().num_threads(1).build();
    let one_thread =
        one_thread.map_err(|error| Error::Failed(format!("cannot start a thread: {}", reason(&error))))?;
    progress.begin((repeat as usize * cases.len() * rows.len()) as u32, "runs");
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
    progress.end();
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
    // Keeps the optimiser from removing the development of the image.
    std::hint::black_box(&film);
    Run { seconds, cycles, stats: *rung.stats() }
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
}

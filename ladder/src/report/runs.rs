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
impl Runs {
    /// Three runs, of which the one in the middle takes so long, half of it in the camera pass. Nothing was counted in the others.
    pub(crate) fn example(seconds: f64, cycles: Option<u64>) -> Self {
        let stats = Stats {
            camera_seconds: seconds / 2.0,
            build_grid_seconds: seconds / 8.0,
            photon_seconds: seconds / 4.0,
            consolidate_seconds: 0.0625,
            camera_segments: 1,
            shadow_rays: 2,
            visible_points: 11,
            photons: 3,
            photon_segments: 12,
            deposits: 13,
            candidates: 14,
            contributions: 15,
            bytes: 16,
        };
        let other = |share: f64| Run { seconds: share * seconds, cycles: None, stats: Stats::default() };
        Self::new(vec![other(3.0), Run { seconds, cycles, stats }, other(0.75)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;
    use crate::report::measured::Measured;

    /// Keeps all that it is told.
    struct Told(Vec<String>);

    impl Progress for Told {
        fn begin(&mut self, count: u32, noun: &'static str) {
            self.0.push(format!("{count} {noun}"));
        }
        fn step(&mut self, done: u32, what: &str) {
            self.0.push(format!("{done} {what}"));
        }
        fn end(&mut self) {
            self.0.push("end".into());
        }
    }

    /// What slows the machine down for a while then hits all rows alike.
    #[test]
    fn rows_take_turns_and_run_all_iterations() {
        let (example, mut told) = (Example::of_scenes(), Told(Vec::new()));
        let Measured { rows, cases, .. } = example.measured();
        let runs = measure(cases, rows, &Options::paper(), 2, &mut told).unwrap();
        let round = ["a row 0", "a row 6", "a row fast", "b row 0", "b row 6", "b row fast"];
        let steps = round.iter().cycle().take(12).enumerate().map(|(done, what)| format!("{done} {what}"));
        let expected: Vec<String> =
            ["12 runs".to_owned()].into_iter().chain(steps).chain(["end".to_owned()]).collect();
        assert_eq!(told.0, expected);
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        for runs in runs.iter().flatten() {
            let Run { seconds, stats, .. } = *runs.median();
            assert_eq!((runs.count(), stats.photons), (2, 3 * 50));
            let passes = [
                stats.camera_seconds,
                stats.build_grid_seconds,
                stats.photon_seconds,
                stats.consolidate_seconds,
            ];
            assert!(
                passes.iter().sum::<f64>() <= seconds && runs.least() <= seconds,
                "{seconds} and {stats:?}"
            );
        }
    }

    #[test]
    fn medians_are_of_the_run_in_the_middle() {
        let run = |seconds| Run { seconds, cycles: None, stats: Stats::default() };
        let median = |all: &[f64]| Runs::new(all.iter().copied().map(run).collect()).median().seconds;
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0]), 1.0);
        assert_eq!(median(&[5.0]), 5.0);
    }
}

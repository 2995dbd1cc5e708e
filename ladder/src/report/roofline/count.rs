//! Counts operations and bytes, and combines them with measured times.

use crate::counted::Operations;
use crate::machine::Peaks;
use crate::options::Options;
use crate::report::case::Case;
use crate::report::measured::Measured;
use crate::report::passes::PASSES;
use crate::report::progress::Progress;
use crate::report::runs::Run;
use crate::report::sweep::Sweep;
use crate::table::Row;

/// The operations of each pass, if the row counts them.
type Counted = Option<[Operations; 4]>;

/// The counted operations, and the peaks of the machine.
pub(crate) struct Roofline {
    pub(crate) peaks: Peaks,
    /// The operations of each row, for each case.
    counted: Vec<Vec<Counted>>,
}

/// A row or one of its passes, as a point of the plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    pub(crate) seconds: f64,
    pub(crate) cycles: f64,
    pub(crate) operations: Operations,
}

impl Point {
    /// FLOPs per second.
    pub(crate) fn performance(&self) -> f64 {
        self.operations.flops() as f64 / self.seconds
    }

    /// FLOPs per cycle.
    pub(crate) fn flops_per_cycle(&self) -> f64 {
        self.operations.flops() as f64 / self.cycles
    }

    /// FLOPs per byte loaded or stored.
    pub(crate) fn intensity(&self) -> f64 {
        self.operations.flops() as f64 / self.operations.bytes() as f64
    }
}

/// Measures the peaks, and runs every row in every case once more with counting.
pub(crate) fn count(
    cases: &[Case],
    rows: &[&Row],
    options: &Options,
    sweep: Option<Sweep>,
    progress: &mut dyn Progress,
) -> Roofline {
    let peaks = Peaks::measure();
    let options = Options { counts_operations: true, ..*options };
    let mut counted = vec![vec![None; rows.len()]; cases.len()];
    progress.begin((cases.len() * rows.len()) as u32, "counted runs");
    let mut done = 0;
    let mut first = 0;
    while first < cases.len() {
        // A render of fewer iterations is the beginning of a longer one, so both are counted in one run.
        let is_longer = |pair: &[Case]| sweep == Some(Sweep::Iterations) && pair[0].name == pair[1].name;
        let more = cases[first..].windows(2).take_while(|pair| is_longer(pair)).count();
        let together = first..=first + more;
        for (number, row) in rows.iter().enumerate() {
            progress.step(done, &format!("{} row {}", cases[first].name, row.name));
            done += 1 + more as u32;
            let last = &cases[first + more];
            let mut rung = row.start(&last.scene, &last.settings, &options);
            // Rows that do not count operations are not run.
            if rung.operations().is_none() {
                continue;
            }
            for case in together.clone() {
                while rung.iterations() < cases[case].settings.iterations {
                    rung.iterate();
                }
                counted[case][number] = rung.operations();
            }
        }
        first += more + 1;
    }
    progress.end();
    Roofline { peaks, counted }
}

impl Roofline {
    /// The point of all passes together, and that of each pass; `None` if the row does not count operations.
    pub(crate) fn points(&self, measured: &Measured, case: usize, row: usize) -> Option<(Point, [Point; 4])> {
        let operations = self.counted[case][row]?;
        let run = measured.runs[case][row].median();
        let clock = self.clock(run);
        let point = |seconds: f64, operations| Point { seconds, cycles: seconds * clock, operations };
        let passes: [Point; 4] =
            std::array::from_fn(|pass| point((PASSES[pass].seconds)(&run.stats), operations[pass]));
        let mut all = Operations::default();
        for one in operations {
            all += one;
        }
        Some((point(passes.iter().map(|pass| pass.seconds).sum(), all), passes))
    }

    /// Cycles per second during the run.
    fn clock(&self, run: &Run) -> f64 {
        run.cycles.map_or(self.peaks.clock.hertz, |cycles| cycles as f64 / run.seconds)
    }
}

#[cfg(test)]
impl Roofline {
    /// Every row but fast counts in each case 5, 6, 7 and 8 billions of FLOPs in its passes, and 4, 5, 6 and 7 billions of bytes.
    pub(crate) fn example(cases: usize) -> Self {
        use crate::machine::{Bandwidth, Clock, CycleSource, Level};
        const BILLION: u64 = 1_000_000_000;
        let pass = |number: usize| Operations {
            additions: (1 + number as u64) * BILLION,
            multiplications: 2 * BILLION,
            divisions: BILLION / 2,
            square_roots: 3 * BILLION / 2,
            comparisons: 7 * BILLION,
            bytes_loaded: 3 * BILLION,
            bytes_stored: (1 + number as u64) * BILLION,
        };
        let counted = Some(std::array::from_fn(pass));
        let bandwidth = |level, bytes, bytes_per_second| Bandwidth { level, bytes, bytes_per_second };
        let peaks = Peaks {
            clock: Clock { hertz: 4e9, source: CycleSource::Chain },
            scalar_flops: 16e9,
            vector_flops: 128e9,
            bandwidths: vec![bandwidth(Level::L1, 16 << 10, 400e9), bandwidth(Level::Dram, 64 << 20, 20e9)],
        };
        Self { peaks, counted: vec![vec![counted, counted, None]; cases] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    /// Of row 0 cycles are counted, at 2 GHz. Else they are time at the measured clock.
    #[test]
    fn cycles_are_those_of_the_run_where_they_are_counted() {
        let (example, roofline) = (Example::of_scenes(), Roofline::example(2));
        let measured = example.measured();
        for (row, seconds, hertz) in [(0, 8.0, 2e9), (1, 2.0, 4e9)] {
            let (all, passes) = roofline.points(&measured, 0, row).unwrap();
            let expected = [seconds / 2.0, seconds / 8.0, seconds / 4.0, 0.0625];
            assert_eq!(passes.map(|pass| pass.seconds), expected);
            assert_eq!(passes.map(|pass| pass.cycles), expected.map(|seconds| seconds * hertz));
            assert_eq!(passes.map(|pass| pass.operations.flops()), [5, 6, 7, 8].map(|n| n * 1_000_000_000));
            let sum: f64 = expected.iter().sum();
            assert_eq!((all.seconds, all.cycles), (sum, sum * hertz));
            assert_eq!((all.operations.flops(), all.operations.bytes()), (26_000_000_000, 22_000_000_000));
        }
        assert_eq!(roofline.points(&measured, 0, 2), None);
    }

    #[test]
    fn performance_is_per_second_per_cycle_and_per_byte() {
        let operations =
            Operations { additions: 12, bytes_loaded: 2, bytes_stored: 4, ..Operations::default() };
        let point = Point { seconds: 0.5, cycles: 3.0, operations };
        assert_eq!([point.performance(), point.flops_per_cycle(), point.intensity()], [24.0, 4.0, 2.0]);
    }
}

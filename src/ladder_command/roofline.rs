//! Counted operations and bytes beside measured times: FLOPs per cycle and operational intensity, against the peaks of
//! the machine.

use super::args::Sweep;
use super::cases::Case;
use super::measure::Run;
use super::passes::PASSES;
use super::{Measured, plots, rooflines};
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use files::atomic_file;
use ladder::{CycleSource, Operations, Options, Peaks, Row};
use serde::Serialize;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// Operations by pass, if the row counts them.
type Counted = Option<[Operations; 4]>;

/// What has been counted, and what the machine can do.
pub(crate) struct Roofline {
    pub peaks: Peaks,
    /// For each case, the operations of each row.
    counted: Vec<Vec<Counted>>,
}

/// A row, or a pass of it, as a point of the plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    pub seconds: f64,
    pub cycles: f64,
    pub operations: Operations,
}

impl Point {
    /// FLOPs in a second.
    pub(crate) fn performance(&self) -> f64 {
        self.operations.flops() as f64 / self.seconds
    }
    pub(crate) fn flops_per_cycle(&self) -> f64 {
        self.operations.flops() as f64 / self.cycles
    }
    /// FLOPs for every byte that is loaded or stored.
    pub(crate) fn intensity(&self) -> f64 {
        self.operations.flops() as f64 / self.operations.bytes() as f64
    }
}

/// Measures the peaks, and runs every row in every case once more, counting.
pub(super) fn count(cases: &[Case], rows: &[&Row], options: &Options, sweep: Option<Sweep>) -> Roofline {
    let peaks = Peaks::measure();
    let options = Options { counts_operations: true, ..*options };
    let mut counted = vec![vec![None; rows.len()]; cases.len()];
    let progress = Bar::of((cases.len() * rows.len()) as u32, "counted runs");
    let mut done = 0;
    let mut first = 0;
    while first < cases.len() {
        // Fewer iterations are the beginning of more, so they are counted on the way.
        let is_longer = |pair: &[Case]| sweep == Some(Sweep::Iterations) && pair[0].name == pair[1].name;
        let more = cases[first..].windows(2).take_while(|pair| is_longer(pair)).count();
        let together = first..=first + more;
        for (number, row) in rows.iter().enumerate() {
            progress.step(done, &format!("{} row {}", cases[first].name, row.name));
            done += 1 + more as u32;
            let last = &cases[first + more];
            let mut rung = row.start(&last.scene, &last.settings, &options);
            // None of those that do not count.
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
    progress.clear();
    Roofline { peaks, counted }
}

impl Roofline {
    /// All passes together, and each by itself; none if the row does not count.
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

    /// Cycles in a second of the run.
    fn clock(&self, run: &Run) -> f64 {
        run.cycles.map_or(self.peaks.clock.hertz, |cycles| cycles as f64 / run.seconds)
    }

    /// The clock, the peaks, and for every case and row what has come of them.
    pub(super) fn report(&self, measured: &Measured) -> String {
        let Peaks { clock, scalar_flops, vector_flops, ref bandwidths } = self.peaks;
        let mut text = String::new();
        let _ = writeln!(text, "\n{:.2} GHz; {}", clock.hertz / 1e9, clock.source.about());
        for (name, flops) in [("one float", scalar_flops), ("8 floats", vector_flops)] {
            let (rate, each) = (flops / 1e9, flops / clock.hertz);
            let _ = writeln!(text, "peak by FMA of {name}: {rate:.1} GFLOP/s, {each:.2} FLOPs/cycle");
        }
        for bandwidth in bandwidths {
            let (level, rate) = (bandwidth.level.name(), bandwidth.bytes_per_second / 1e9);
            let each = bandwidth.bytes_per_second / clock.hertz;
            let _ = writeln!(text, "peak reading {level}: {rate:.1} GB/s, {each:.2} bytes/cycle");
        }
        let widest = measured.rows.iter().map(|row| row.name.len()).max().unwrap_or(0).max(3);
        for (number, case) in measured.cases.iter().enumerate() {
            let value =
                measured.sweep.map_or(String::new(), |sweep| format!(", {} {}", case.value, sweep.noun()));
            let passes = PASSES.map(|pass| format!("{:>12}", pass.name)).concat();
            let _ = writeln!(
                text,
                "\n{}{value}: FLOPs, FLOPs/byte, and FLOPs/cycle of all and of each pass",
                case.name
            );
            let _ = writeln!(
                text,
                "  {:widest$}  {:>10}{:>12}{:>12}{passes}",
                "row", "GFLOPs", "FLOPs/byte", "all"
            );
            for (place, row) in measured.rows.iter().enumerate() {
                let _ = match self.points(measured, number, place) {
                    None => writeln!(text, "  {:widest$}  {:>10}", row.name, "not counted"),
                    Some((all, passes)) => {
                        let each = passes.map(|pass| format!("{:>12.3}", pass.flops_per_cycle())).concat();
                        let (flops, intensity) = (all.operations.flops() as f64 / 1e9, all.intensity());
                        let whole = all.flops_per_cycle();
                        let name = row.name;
                        writeln!(text, "  {name:widest$}  {flops:>10.3}{intensity:>12.3}{whole:>12.3}{each}")
                    }
                };
            }
        }
        text
    }

    /// Writes plots, points and peaks into a folder.
    pub(super) fn write(&self, folder: &Path, measured: &Measured) -> Result<(), Error> {
        table(&folder.join("peaks.csv"), &self.peak_records())?;
        table(&folder.join("roofline.csv"), &self.records(measured))?;
        match measured.sweep {
            Some(sweep) => plots::flops(folder, measured, sweep, self),
            None => rooflines::write(folder, measured, self),
        }
    }

    fn peak_records(&self) -> Vec<Peak> {
        let hertz = self.peaks.clock.hertz;
        let record = |what, bytes, per_second, unit| Peak {
            what,
            bytes,
            per_second,
            per_cycle: per_second / hertz,
            unit,
        };
        let mut records = vec![
            record("clock", None, hertz, "cycles"),
            record("fma of one float", None, self.peaks.scalar_flops, "FLOPs"),
            record("fma of 8 floats", None, self.peaks.vector_flops, "FLOPs"),
        ];
        let levels = self.peaks.bandwidths.iter();
        records.extend(levels.map(|b| record(b.level.name(), Some(b.bytes), b.bytes_per_second, "bytes")));
        records
    }

    fn records<'a>(&self, measured: &'a Measured) -> Vec<Record<'a>> {
        let mut records = Vec::new();
        for (case, of_case) in measured.cases.iter().enumerate() {
            for (row, of_row) in measured.rows.iter().enumerate() {
                let Some((all, passes)) = self.points(measured, case, row) else { continue };
                let has_counter = measured.runs[case][row].median().cycles.is_some();
                let source = if has_counter { CycleSource::Counter } else { self.peaks.clock.source };
                let named = PASSES.iter().map(|pass| pass.name).zip(passes);
                for (pass, point) in std::iter::once(("all", all)).chain(named) {
                    records.push(Record {
                        scene: &of_case.name,
                        row: of_row.name,
                        sweep: measured.sweep,
                        value: measured.sweep.map(|_| of_case.value),
                        pass,
                        seconds: point.seconds,
                        cycles: point.cycles,
                        cycles_from: source,
                        flops: point.operations.flops(),
                        divisions: point.operations.divisions,
                        square_roots: point.operations.square_roots,
                        bytes_loaded: point.operations.bytes_loaded,
                        bytes_stored: point.operations.bytes_stored,
                        flops_per_second: point.performance(),
                        flops_per_cycle: point.flops_per_cycle(),
                        flops_per_byte: point.intensity(),
                    });
                }
            }
        }
        records
    }
}

/// A peak as a line of a table.
#[derive(Serialize)]
struct Peak {
    what: &'static str,
    bytes: Option<usize>,
    per_second: f64,
    per_cycle: f64,
    unit: &'static str,
}

/// A point as a line of a table.
#[derive(Serialize)]
struct Record<'a> {
    scene: &'a str,
    row: &'a str,
    sweep: Option<Sweep>,
    value: Option<u64>,
    pass: &'static str,
    seconds: f64,
    cycles: f64,
    cycles_from: CycleSource,
    flops: u64,
    divisions: u64,
    square_roots: u64,
    bytes_loaded: u64,
    bytes_stored: u64,
    flops_per_second: f64,
    flops_per_cycle: f64,
    flops_per_byte: f64,
}

/// Writes records as comma-separated values.
pub(super) fn table(path: &Path, records: &[impl Serialize]) -> Result<(), Error> {
    let fill = |out: &mut atomic_file::Output| {
        let mut csv = csv::Writer::from_writer(out);
        for record in records {
            csv.serialize(record).map_err(io::Error::other)?;
        }
        csv.flush()
    };
    atomic_file::replace(path, fill).map_err(|error| Error::Failed(error.to_string()))
}

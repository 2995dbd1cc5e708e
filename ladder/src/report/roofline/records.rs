//! Writes peaks and points as tables of comma-separated values.

use super::count::{Point, Roofline};
use crate::error::Error;
use crate::machine::{CycleSource, Peaks};
use crate::report::case::Case;
use crate::report::csv;
use crate::report::measured::Measured;
use crate::report::passes::PASSES;
use crate::report::sweep::Sweep;
use serde::Serialize;
use std::path::Path;

/// A line of the table of peaks.
#[derive(Serialize)]
struct PeakRecord {
    what: &'static str,
    bytes: Option<usize>,
    per_second: f64,
    per_cycle: f64,
    unit: &'static str,
}

/// A line of the table of points.
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

/// Writes `peaks.csv` and `roofline.csv` into a folder.
pub(crate) fn write(folder: &Path, roofline: &Roofline, measured: &Measured) -> Result<(), Error> {
    csv::write(&folder.join("peaks.csv"), &peak_records(&roofline.peaks))?;
    csv::write(&folder.join("roofline.csv"), &records(roofline, measured))
}

fn peak_records(peaks: &Peaks) -> Vec<PeakRecord> {
    let hertz = peaks.clock.hertz;
    let record = |what, bytes, per_second, unit| PeakRecord {
        what,
        bytes,
        per_second,
        per_cycle: per_second / hertz,
        unit,
    };
    let mut records = vec![
        record("clock", None, hertz, "cycles"),
        record("fma of one float", None, peaks.scalar_flops, "FLOPs"),
        record("fma of 8 floats", None, peaks.vector_flops, "FLOPs"),
    ];
    let levels = peaks.bandwidths.iter();
    records.extend(levels.map(|b| record(b.level.name(), Some(b.bytes), b.bytes_per_second, "bytes")));
    records
}

fn records<'a>(roofline: &Roofline, measured: &'a Measured) -> Vec<Record<'a>> {
    let mut records = Vec::new();
    for (case, of_case) in measured.cases.iter().enumerate() {
        for (row, of_row) in measured.rows.iter().enumerate() {
            let Some((all, passes)) = roofline.points(measured, case, row) else { continue };
            let has_counter = measured.runs[case][row].median().cycles.is_some();
            let source = if has_counter { CycleSource::Counter } else { roofline.peaks.clock.source };
            let named = PASSES.iter().map(|pass| pass.name).zip(passes);
            for (pass, point) in std::iter::once(("all", all)).chain(named) {
                records.push(record(of_case, of_row.name, measured.sweep, source, pass, &point));
            }
        }
    }
    records
}

fn record<'a>(
    case: &'a Case,
    row: &'a str,
    sweep: Option<Sweep>,
    cycles_from: CycleSource,
    pass: &'static str,
    point: &Point,
) -> Record<'a> {
    Record {
        scene: &case.name,
        row,
        sweep,
        value: sweep.map(|_| case.value),
        pass,
        seconds: point.seconds,
        cycles: point.cycles,
        cycles_from,
        flops: point.operations.flops(),
        divisions: point.operations.divisions,
        square_roots: point.operations.square_roots,
        bytes_loaded: point.operations.bytes_loaded,
        bytes_stored: point.operations.bytes_stored,
        flops_per_second: point.performance(),
        flops_per_cycle: point.flops_per_cycle(),
        flops_per_byte: point.intensity(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    #[test]
    fn peaks_are_told_per_second_and_per_cycle() {
        let table = "what,bytes,per_second,per_cycle,unit\n\
                     clock,,4000000000.0,1.0,cycles\n\
                     fma of one float,,16000000000.0,4.0,FLOPs\n\
                     fma of 8 floats,,128000000000.0,32.0,FLOPs\n\
                     L1,16384,400000000000.0,100.0,bytes\n\
                     DRAM,67108864,20000000000.0,5.0,bytes\n";
        assert_eq!(csv::text(&peak_records(&Roofline::example(2).peaks)), table);
    }

    /// A line for the row and one for each of its passes; rows that count nothing have none.
    #[test]
    fn every_column_of_the_points_holds_what_it_is_called() {
        let (roofline, scenes, sweep) = (Roofline::example(4), Example::of_scenes(), Example::of_sweep());
        let table = csv::text(&records(&roofline, &scenes.measured()));
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 1 + 2 * 2 * 5, "{table}");
        assert_eq!(
            lines[0],
            "scene,row,sweep,value,pass,seconds,cycles,cycles_from,flops,divisions,square_roots,bytes_loaded,bytes_stored,\
             flops_per_second,flops_per_cycle,flops_per_byte"
        );
        assert_eq!(
            lines[2],
            "a,0,,,camera pass,4.0,8000000000.0,counter,5000000000,500000000,1500000000,3000000000,1000000000,\
             1250000000.0,0.625,1.25"
        );
        assert_eq!(
            lines[8],
            "a,6,,,index,0.25,1000000000.0,chain,6000000000,500000000,1500000000,3000000000,2000000000,\
             24000000000.0,6.0,1.2"
        );
        let passes = ["all", "camera pass", "index", "photon pass", "consolidate"];
        for (line, pass) in lines[1..].iter().zip(passes.iter().cycle()) {
            assert!(line.contains(&format!(",,{pass},")), "no {pass} in {line}");
        }
        let table = csv::text(&records(&roofline, &sweep.measured()));
        assert!(table.lines().nth(11).unwrap().starts_with("a,0,photons,40,all,"), "{table}");
    }
}

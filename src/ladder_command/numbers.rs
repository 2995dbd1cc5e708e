//! The table of random-number generators (section 3.4 of the paper): what a number costs.

use super::roofline::table;
use crate::terminal::error::Error;
use crate::terminal::text::print;
use ladder::{Clock, CycleSource, time_numbers};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// A generator as a line of the table.
#[derive(Serialize)]
struct Record {
    generator: String,
    latency_ns: Option<f64>,
    latency_cycles: Option<f64>,
    throughput_ns: f64,
    throughput_cycles: f64,
    taken_ns: Option<f64>,
    cycles_from: CycleSource,
}

/// Times all generators, reports, and writes the table if wanted.
pub(super) fn run(csv: Option<&Path>) -> Result<(), Error> {
    let clock = Clock::measure();
    let cycles = |nanoseconds: f64| nanoseconds * 1e-9 * clock.hertz;
    let record = |times: ladder::NumberTimes| Record {
        generator: times.name,
        latency_ns: times.latency,
        latency_cycles: times.latency.map(cycles),
        throughput_ns: times.throughput,
        throughput_cycles: cycles(times.throughput),
        taken_ns: times.taken,
        cycles_from: clock.source,
    };
    let records: Vec<Record> = time_numbers().into_iter().map(record).collect();
    let mut text = format!("{:.2} GHz; {}\n", clock.hertz / 1e9, clock.source.about());
    let widest = records.iter().map(|record| record.generator.len()).max().unwrap_or(0);
    let _ = writeln!(text, "{:widest$}  {:^17}  {:^17}  taken one by", "", "latency", "throughput");
    let _ = writeln!(
        text,
        "{:widest$}  {:>8}{:>9}  {:>8}{:>9}  one, ns each",
        "generator", "ns", "cycles", "ns", "cycles"
    );
    for Record {
        generator, latency_ns, latency_cycles, throughput_ns, throughput_cycles, taken_ns, ..
    } in &records
    {
        let told = |value: &Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
        let (latency, in_cycles) = (told(latency_ns), told(latency_cycles));
        let each = format!("{throughput_ns:>8.3}{throughput_cycles:>9.2}");
        let _ =
            writeln!(text, "{generator:widest$}  {latency:>8}{in_cycles:>9}  {each}  {:>12}", told(taken_ns));
    }
    if let Some(csv) = csv {
        table(csv, &records)?;
    }
    print(text.as_bytes())
}

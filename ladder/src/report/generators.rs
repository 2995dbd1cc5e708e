//! The table of random-number generators (section 3.4 of the paper), with their times per number.

use super::csv;
use crate::error::Error;
use crate::machine::{Clock, CycleSource};
use crate::numbers::timing::{NumberTimes, time_numbers};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// A line of the table: one generator.
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

/// The times of all generators.
pub struct Generators {
    clock: Clock,
    records: Vec<Record>,
}

impl Generators {
    /// Times all generators.
    pub fn measure() -> Self {
        let clock = Clock::measure();
        let records = time_numbers().into_iter().map(|times| Record::new(times, &clock)).collect();
        Self { clock, records }
    }

    /// The times as a table of text.
    pub fn text(&self) -> String {
        let Self { clock, records } = self;
        let mut text = format!("{:.2} GHz; {}\n", clock.hertz / 1e9, clock.source.about());
        let widest = records.iter().map(|record| record.generator.len()).max().unwrap_or(0);
        let _ = writeln!(text, "{:widest$}  {:^17}  {:^17}  taken one by", "", "latency", "throughput");
        let _ = writeln!(
            text,
            "{:widest$}  {:>8}{:>9}  {:>8}{:>9}  one, ns each",
            "generator", "ns", "cycles", "ns", "cycles"
        );
        for record in records {
            let Record { generator, throughput_ns, throughput_cycles, .. } = record;
            let told = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
            let (latency, in_cycles) = (told(record.latency_ns), told(record.latency_cycles));
            let (each, taken) =
                (format!("{throughput_ns:>8.3}{throughput_cycles:>9.2}"), told(record.taken_ns));
            let _ = writeln!(text, "{generator:widest$}  {latency:>8}{in_cycles:>9}  {each}  {taken:>12}");
        }
        text
    }

    /// Writes the table as comma-separated values.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        csv::write(path, &self.records)
    }
}

impl Record {
    fn new(times: NumberTimes, clock: &Clock) -> Self {
        let cycles = |nanoseconds: f64| nanoseconds * 1e-9 * clock.hertz;
        Self {
            generator: times.name,
            latency_ns: times.latency,
            latency_cycles: times.latency.map(cycles),
            throughput_ns: times.throughput,
            throughput_cycles: cycles(times.throughput),
            taken_ns: times.taken,
            cycles_from: clock.source,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 4 GHz a nanosecond is four cycles.
    #[test]
    fn numbers_are_told_in_nanoseconds_and_in_cycles() {
        let clock = Clock { hertz: 4e9, source: CycleSource::Counter };
        let times = |name: &str, latency, throughput, taken| NumberTimes {
            name: name.into(),
            latency,
            throughput,
            taken,
        };
        let records = [times("one", Some(2.5), 0.25, Some(1.5)), times("all other", None, 2.0, None)];
        let records = records.map(|times| Record::new(times, &clock)).into();
        let told = "\
4.00 GHz; cycles from the hardware counter
                latency          throughput      taken one by
generator        ns   cycles        ns   cycles  one, ns each
one            2.50    10.00     0.250     1.00          1.50
all other         -        -     2.000     8.00             -
";
        let generators = Generators { clock, records };
        assert_eq!(generators.text(), told);
        let table = "generator,latency_ns,latency_cycles,throughput_ns,throughput_cycles,taken_ns,cycles_from\n\
                     one,2.5,10.0,0.25,1.0,1.5,counter\nall other,,,2.0,8.0,,counter\n";
        assert_eq!(csv::text(&generators.records), table);
    }
}

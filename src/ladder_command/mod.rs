//! The command `ladder`: the rows of the ladder side by side.

pub(crate) mod args;
pub(crate) mod cases;
mod measure;
pub(crate) mod plots;
mod records;

use crate::error::Error;
use crate::text::print;
use args::{LadderArgs, Sweep};
use cases::Case;
use ladder::{Options, ROWS, Row};
use measure::{Runs, exponent, measure};
use scene::atomic_file;
use std::fmt::Write;

/// What has been measured.
pub(crate) struct Measured<'a> {
    pub rows: &'a [&'static Row],
    pub cases: &'a [Case],
    /// For each case, the runs of each row.
    pub runs: &'a [Vec<Runs>],
    pub sweep: Option<Sweep>,
}

/// Runs the ladder. Everything that can be refused is refused before.
pub(crate) fn run(args: &LadderArgs) -> Result<(), Error> {
    let cases = cases::cases(args)?;
    if let Some(csv) = &args.csv {
        atomic_file::check(csv).map_err(|error| Error::BadInput(format!("--csv: {error}")))?;
    }
    if let Some(folder) = args.plots.as_ref().filter(|folder| !folder.is_dir()) {
        let folder = folder.display();
        return Err(Error::BadInput(format!("--plots: {folder} is not a folder; make it first")));
    }
    let rows = rows(args);
    let options = Options { random: args.rng.into(), ..Options::paper() };
    let repeat = args.repeat.unwrap_or(if args.quick { 1 } else { 3 });
    let runs = measure(&cases, &rows, &options, repeat)?;
    let measured = Measured { rows: &rows, cases: &cases, runs: &runs, sweep: args.sweep };
    if let Some(csv) = &args.csv {
        records::write(csv, &measured, args.rng)?;
    }
    if let Some(folder) = &args.plots {
        plots::write(folder, &measured)?;
    }
    print(report(&measured).as_bytes())
}

fn rows(args: &LadderArgs) -> Vec<&'static Row> {
    if !args.rows.is_empty() {
        return args.rows.clone();
    }
    let is_wanted = |row: &&Row| args.sweep.is_none() || row.is_stage || row.is_always_exact();
    ROWS.iter().filter(is_wanted).collect()
}

impl Measured<'_> {
    /// How many times as fast as the first row a row is in a case.
    pub(crate) fn speedup(&self, case: usize, row: usize) -> f64 {
        let seconds = |row: usize| self.runs[case][row].median().seconds;
        seconds(0) / seconds(row)
    }

    /// The scenes, each with the numbers of its cases.
    pub(crate) fn scenes(&self) -> Vec<(&str, Vec<usize>)> {
        let mut scenes: Vec<(&str, Vec<usize>)> = Vec::new();
        for (number, case) in self.cases.iter().enumerate() {
            match scenes.last_mut() {
                Some((name, cases)) if *name == case.name => cases.push(number),
                _ => scenes.push((&case.name, vec![number])),
            }
        }
        scenes
    }

    /// How a row's time grows with what is varied.
    fn growth(&self, cases: &[usize], row: usize) -> f64 {
        let point = |case: &usize| (self.cases[*case].value as f64, self.runs[*case][row].median().seconds);
        exponent(&cases.iter().map(point).collect::<Vec<_>>())
    }
}

/// Median seconds and speedups as a table for people, scene by scene.
fn report(measured: &Measured) -> String {
    let mut text = String::new();
    let widest = measured.rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    for (name, cases) in measured.scenes() {
        let header = match measured.sweep {
            None => format!("{:>10}  {:>8}", "seconds", "speedup"),
            Some(sweep) => {
                let values: Vec<String> =
                    cases.iter().map(|case| format!("{:>10}", measured.cases[*case].value)).collect();
                format!("{}  grows as {} to the", values.concat(), sweep.noun())
            }
        };
        let _ = writeln!(text, "{name}\n  {:widest$}  {header}", "row");
        for (number, row) in measured.rows.iter().enumerate() {
            let _ = write!(text, "  {:widest$}  ", row.name);
            for &case in &cases {
                let _ = write!(text, "{:>10.3}", measured.runs[case][number].median().seconds);
            }
            let _ = match measured.sweep {
                None => writeln!(text, "  {:>8.2}", measured.speedup(cases[0], number)),
                Some(_) => writeln!(text, "  {:.2}", measured.growth(&cases, number)),
            };
        }
    }
    text
}

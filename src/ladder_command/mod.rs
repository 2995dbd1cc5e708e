//! The command `ladder`: the rows of the ladder side by side.

pub(crate) mod args;
pub(crate) mod cases;
mod films;
mod measure;
mod numbers;
mod passes;
pub(crate) mod plots;
mod quality;
mod records;
mod roofline;
mod rooflines;
mod similarity;

use crate::terminal::error::Error;
use crate::terminal::text::print;
use args::{LadderArgs, Sweep};
use cases::Case;
use files::atomic_file;
use ladder::{Options, ROWS, Row};
use measure::{Runs, exponent, measure};
use passes::PASSES;
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
    if let Some(csv) = &args.csv {
        atomic_file::check(csv).map_err(|error| Error::BadInput(format!("--csv: {error}")))?;
    }
    for (option, folder) in [("--plots", &args.plots), ("--images", &args.also.images)] {
        if let Some(folder) = folder.as_ref().filter(|folder| !folder.is_dir()) {
            let folder = folder.display();
            return Err(Error::BadInput(format!("{option}: {folder} is not a folder; make it first")));
        }
    }
    if args.also.numbers {
        return numbers::run(args.csv.as_deref());
    }
    if args.also.similarity && args.sweep != Some(Sweep::Iterations) {
        return Err(Error::BadInput("--similarity: goes with --sweep iterations only".into()));
    }
    let cases = cases::cases(args)?;
    let rows = rows(args);
    let options = Options { random: args.rng.into(), ..Options::paper() };
    if let Some(folder) = &args.also.images {
        return films::write(folder, &cases, &rows, &options);
    }
    let repeat = args.repeat.unwrap_or(if args.quick { 1 } else { 3 });
    let runs = measure(&cases, &rows, &options, repeat)?;
    let measured = Measured { rows: &rows, cases: &cases, runs: &runs, sweep: args.sweep };
    if let Some(csv) = &args.csv {
        records::write(csv, &measured, args.rng)?;
    }
    if let Some(folder) = &args.plots {
        plots::write(folder, &measured)?;
    }
    let mut text = report(&measured);
    if args.also.roofline {
        let roofline = roofline::count(&cases, &rows, &options, args.sweep);
        if let Some(folder) = &args.plots {
            roofline.write(folder, &measured)?;
        }
        text += &roofline.report(&measured);
    }
    if args.also.similarity {
        let similarity = similarity::compared(&measured, &options)?;
        if let Some(folder) = &args.plots {
            similarity.write(folder, &measured)?;
        }
        text += &similarity.report(&measured);
    }
    if args.also.quality {
        let quality = quality::compared(&measured, &options, repeat);
        if let Some(folder) = &args.plots {
            quality.write(folder, &measured)?;
        }
        text += &quality.report(&measured);
    }
    print(text.as_bytes())
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

    /// Median seconds of a row's pass.
    pub(crate) fn pass_seconds(&self, cases: &[usize], row: usize, pass: usize) -> Vec<f64> {
        cases.iter().map(|&case| (PASSES[pass].seconds)(&self.runs[case][row].median().stats)).collect()
    }

    /// Seconds over the work that the paper's analysis predicts of a pass.
    pub(crate) fn cost_of_work(&self, cases: &[usize], row: usize, pass: usize, sweep: Sweep) -> Vec<f64> {
        let times = self.pass_seconds(cases, row, pass).into_iter();
        times.zip(cases).map(|(t, &case)| t / PASSES[pass].predicted(sweep, self.cases[case].value)).collect()
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
        if let Some(sweep) = measured.sweep {
            let _ =
                writeln!(text, "  seconds over the work that the paper's analysis predicts, most over least");
            let names = PASSES.map(|pass| format!("{:>13}", pass.name)).concat();
            let _ = writeln!(text, "  {:widest$}  {names}", "row");
            for (number, row) in measured.rows.iter().enumerate() {
                let spread = |pass| {
                    let costs = measured.cost_of_work(&cases, number, pass, sweep);
                    let most = costs.iter().copied().fold(0.0, f64::max);
                    format!("{:>13.2}", most / costs.into_iter().fold(f64::INFINITY, f64::min))
                };
                let _ = writeln!(text, "  {:widest$}  {}", row.name, [0, 1, 2, 3].map(spread).concat());
            }
        }
    }
    text
}

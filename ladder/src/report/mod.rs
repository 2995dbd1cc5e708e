//! Measures rows and makes the tables and plots of `sppm ladder`.
//!
//! | module | what |
//! | --- | --- |
//! | `sweep`, `case` | what is rendered |
//! | `runs`, `measured` | interleaved runs of all rows, timed |
//! | `times` | seconds and speedups: text, table, plots |
//! | `roofline` | counted operations against the machine's peaks: text, tables, plots |
//! | `similarity`, `quality` | how similar the rows' images are, and what equal quality costs |
//! | [`films`] | writes images of all rows instead of times |
//! | [`generators`] | times random numbers instead of rows |
//!
//! Nothing is printed: [`run`] returns the text, and [`Progress`] is called at each step.

mod case;
mod csv;
#[cfg(test)]
mod example;
pub mod films;
pub mod generators;
mod measured;
mod outputs;
mod passes;
mod progress;
mod quality;
mod roofline;
mod runs;
mod similarity;
mod sweep;
mod times;

pub use case::Case;
pub use outputs::Outputs;
pub use progress::Progress;
pub use sweep::Sweep;

use crate::error::{Error, Field};
use crate::options::Options;
use crate::table::Row;
use measured::Measured;

/// The plan of a measurement.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The rows. Speedups are relative to the first.
    pub rows: Vec<&'static Row>,
    /// The renders that each row runs.
    pub cases: Vec<Case>,
    /// The varied parameter, if the cases form a sweep.
    pub sweep: Option<Sweep>,
    /// The options for running rows.
    pub options: Options,
    /// Runs of every row in every case, of which the median counts; at least 1.
    pub repeat: u32,
}

/// The reports to make besides times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// Operations and bytes, counted in an extra run, against the peaks of the machine.
    pub roofline: bool,
    /// The similarity of images to those of the first row; for a sweep over iterations.
    pub similarity: bool,
    /// The errors against a converged image, and the cost of equal quality.
    pub quality: bool,
}

impl Extras {
    /// Checks that these reports are possible for a sweep.
    ///
    /// # Errors
    /// If similarity is requested and iterations are not varied.
    pub fn check(&self, sweep: Option<Sweep>) -> Result<(), Error> {
        if self.similarity && sweep != Some(Sweep::Iterations) {
            return Err(Error::input(Field::Similarity, "goes with a sweep over iterations only"));
        }
        Ok(())
    }
}

/// Measures the rows, writes tables and plots, and returns the report as text.
///
/// # Errors
/// If the extras do not fit the sweep, or a file cannot be written. See also [`Outputs::check`].
pub fn run(
    plan: &Plan,
    extras: Extras,
    outputs: &Outputs,
    progress: &mut dyn Progress,
) -> Result<String, Error> {
    extras.check(plan.sweep)?;
    let Plan { rows, cases, sweep, options, repeat } = plan;
    let runs = runs::measure(cases, rows, options, *repeat, progress)?;
    let measured = Measured { rows, cases, runs: &runs, sweep: *sweep };
    if let Some(path) = &outputs.csv {
        times::records::write(path, &measured, options.random)?;
    }
    let folder = outputs.plots.as_deref();
    if let Some(folder) = folder {
        times::plots::write(folder, &measured)?;
    }
    let mut text = times::text::text(&measured);
    if extras.roofline {
        let roofline = roofline::count(cases, rows, options, *sweep, progress);
        if let Some(folder) = folder {
            roofline::write(folder, &roofline, &measured)?;
        }
        text += &roofline::text(&roofline, &measured);
    }
    if extras.similarity {
        let similarity = similarity::compared(&measured, options, progress)?;
        if let Some(folder) = folder {
            similarity.write(folder, &measured)?;
        }
        text += &similarity.text(&measured);
    }
    if extras.quality {
        let quality = quality::compared(&measured, options, *repeat, progress);
        if let Some(folder) = folder {
            quality.write(folder, &measured)?;
        }
        text += &quality.text(&measured);
    }
    Ok(text)
}

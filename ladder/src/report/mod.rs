//! Rows side by side: runs, and the tables and plots that come of them, as `sppm ladder` shows them.
//!
//! | module | what |
//! | --- | --- |
//! | `sweep`, `case` | what is rendered |
//! | `runs`, `measured` | interleaved runs of all rows, timed |
//! | `times` | seconds and speedups: text, table, plots |
//! | `roofline` | counted operations against the machine's peaks: text, tables, plots |
//! | `similarity`, `quality` | how alike the rows' images are, and what equal quality costs |
//! | [`films`] | images of all rows, in place of times |
//! | [`generators`] | what random numbers cost, in place of rows |
//!
//! Nothing is printed: [`run`] returns the text, and [`Progress`] is told of each step.

mod case;
mod csv;
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

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The rows; speedups are over the first.
    pub rows: Vec<&'static Row>,
    /// What each of them renders.
    pub cases: Vec<Case>,
    /// What the cases differ in, if they are those of a sweep.
    pub sweep: Option<Sweep>,
    /// How rows are run.
    pub options: Options,
    /// Runs of every row in every case, of which the median counts; at least 1.
    pub repeat: u32,
}

/// What is reported besides times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// Operations and bytes, counted in one more run, against the peaks of the machine.
    pub roofline: bool,
    /// How alike images are to the first row's; for a sweep over iterations.
    pub similarity: bool,
    /// Errors against a converged image, and what equal quality costs.
    pub quality: bool,
}

impl Extras {
    /// Checks that all of this can be reported of a sweep.
    ///
    /// # Errors
    /// If similarity is asked for and iterations are not what is varied.
    pub fn check(&self, sweep: Option<Sweep>) -> Result<(), Error> {
        if self.similarity && sweep != Some(Sweep::Iterations) {
            return Err(Error::input(Field::Similarity, "goes with a sweep over iterations only"));
        }
        Ok(())
    }
}

/// Measures the rows, writes tables and plots, and returns what there is to tell people.
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

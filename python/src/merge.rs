//! Adds up parts of a render.

use crate::errors::of_render;
use crate::work::work;
use pyo3::prelude::*;
use render::Error;
use render::merge::Merge;
use scene::Iterations;
use std::ffi::OsString;
use std::path::PathBuf;

/// Ranges of iterations, each from the first to before the second.
type Ranges = Vec<(u32, u32)>;

/// Adds the `parts` up, and writes the sum to `output` if it is given. Returns the iterations in the parts, those that are
/// missing, and the files that were not needed.
#[pyfunction]
pub(crate) fn merge(
    py: Python,
    parts: Vec<PathBuf>,
    output: Option<PathBuf>,
) -> PyResult<(Ranges, Ranges, Vec<OsString>)> {
    let merged = work(py, || {
        let merge = Merge::open(&parts)?;
        if let Some(output) = &output {
            merge.write(output)?;
        }
        let repeated = merge.repeated().map(OsString::from).collect();
        Ok::<_, Error>((ranges(merge.done()), ranges(&merge.missing()), repeated))
    })?;
    merged.map_err(|error| of_render(&error))
}

fn ranges(iterations: &Iterations) -> Ranges {
    iterations.ranges().map(|range| (range.start, range.end)).collect()
}

//! Roofline analysis: FLOPs per cycle and operational intensity of all rows, against the peaks of the machine.

mod count;
mod flops;
mod plots;
mod records;
mod text;

pub(crate) use count::{Roofline, count};
pub(crate) use text::text;

use crate::error::Error;
use crate::report::measured::Measured;
use std::path::Path;

/// Writes plots, points and peaks into a folder.
pub(crate) fn write(folder: &Path, roofline: &Roofline, measured: &Measured) -> Result<(), Error> {
    records::write(folder, roofline, measured)?;
    match measured.sweep {
        Some(sweep) => flops::write(folder, roofline, measured, sweep),
        None => plots::write(folder, roofline, measured),
    }
}

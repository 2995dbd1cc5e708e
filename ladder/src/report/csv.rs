//! Writes tables of comma-separated values.

use crate::error::Error;
use files::atomic_file::{self, Output};
use serde::Serialize;
use std::io;
use std::path::Path;

/// Writes a table with a column for each field of the records.
pub(crate) fn write(path: &Path, records: &[impl Serialize]) -> Result<(), Error> {
    let fill = |out: &mut Output| {
        let mut csv = csv::Writer::from_writer(out);
        for record in records {
            csv.serialize(record).map_err(io::Error::other)?;
        }
        csv.flush()
    };
    Ok(atomic_file::replace(path, fill)?)
}

/// The same as text.
#[cfg(test)]
pub(crate) fn text(records: &[impl Serialize]) -> String {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for record in records {
        csv.serialize(record).unwrap();
    }
    String::from_utf8(csv.into_inner().unwrap()).unwrap()
}

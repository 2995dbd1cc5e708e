//! Checks that the files given to a command are distinct.

use crate::terminal::error::Error;
use files::paths;
use std::path::Path;

/// A file, with the option or name that messages call it by.
pub(crate) type Named<'a> = (&'a str, &'a Path);

/// Checks that no output is also an input or another output.
pub(crate) fn check_distinct(inputs: &[Named], outputs: &[Named]) -> Result<(), Error> {
    let [all_inputs, all_outputs] =
        [inputs, outputs].map(|named| named.iter().map(|(_, path)| *path).collect::<Vec<_>>());
    let Some((index, other)) = paths::first_clash(&all_inputs, &all_outputs) else { return Ok(()) };
    let (what, path) = outputs[index];
    let other = inputs.iter().chain(outputs).nth(other).map_or("another file", |(what, _)| what);
    Err(Error::BadInput(format!("{what}: {} is also {other}; name another file", path.display())))
}

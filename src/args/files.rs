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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_that_is_the_same_file_is_named() {
        let (a, b) = (Path::new("/a/b.toml"), Path::new("/a/c.png"));
        let check = |outputs: &[Named]| {
            check_distinct(&[("the scene", a)], outputs).map_err(|error| error.to_string())
        };
        assert_eq!(check(&[("--output", b)]), Ok(()));
        let told = |what, path, other| Err(format!("{what}: {path} is also {other}; name another file"));
        assert_eq!(check(&[("--output", b), ("--csv", a)]), told("--csv", "/a/b.toml", "the scene"));
        assert_eq!(check(&[("--output", b), ("--csv", b)]), told("--csv", "/a/c.png", "--output"));
    }
}

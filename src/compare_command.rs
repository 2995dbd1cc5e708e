//! The command `compare`.

use crate::args::CompareArgs;
use crate::compare::{Bounds, CompareError, compare, difference_image};
use crate::error::Error;
use crate::outputs::check_distinct;
use crate::text::{complain, print};
use files::image_file::{self, Encoding, Format};
use scene::Film;
use std::path::Path;

/// Prints how alike two images are; fails if a bound does not hold.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Error> {
    if let Some(path) = &args.difference {
        check_difference(args, path)?;
    }
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let metrics = compare(&a, &b).map_err(|error| incomparable(args, &error))?;
    let text = if args.json { json(&metrics)? } else { metrics.to_string() };
    print(text.as_bytes())?;
    if let Some(path) = &args.difference {
        write_difference(args, path, &a, &b)?;
    }
    let broken = Bounds::from(&args.bounds).broken(&metrics);
    if broken.is_empty() { Ok(()) } else { Err(Error::Failed(broken.join("; "))) }
}

fn read(path: &Path) -> Result<Film, Error> {
    image_file::read(path).map_err(|error| Error::BadInput(error.to_string()))
}

fn check_difference(args: &CompareArgs, path: &Path) -> Result<(), Error> {
    let bad = |error: &dyn ToString| Error::BadInput(format!("--difference: {}", error.to_string()));
    check_distinct(&[("image A", &args.a), ("image B", &args.b)], &[("--difference", path)])?;
    match Format::from_path(path) {
        Ok(Format::Png) | Err(_) => image_file::check_writable(path).map_err(|error| bad(&error)),
        Ok(_) => Err(bad(&format!("{} is a picture in false colours; name a .png file", path.display()))),
    }
}

fn write_difference(args: &CompareArgs, path: &Path, a: &Film, b: &Film) -> Result<(), Error> {
    let difference = difference_image(a, b).map_err(|error| incomparable(args, &error))?;
    image_file::write(path, &difference.film, &Encoding::default())
        .map_err(|error| Error::Failed(error.to_string()))?;
    complain(&format!("wrote {}; its brightest colour stands for {:e}", path.display(), difference.scale));
    Ok(())
}

fn incomparable(args: &CompareArgs, error: &CompareError) -> Error {
    Error::BadInput(format!("{} and {} cannot be compared: {error}", args.a.display(), args.b.display()))
}

fn json(metrics: &impl serde::Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(metrics);
    text.map(|text| text + "\n").map_err(|error| Error::Failed(format!("cannot make JSON: {error}")))
}

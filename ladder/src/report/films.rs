//! Renders the images of rows after increasing numbers of iterations, and writes them to files.

use super::case::Case;
use super::outputs::check_folder;
use super::progress::Progress;
use crate::error::{Error, Field};
use crate::options::Options;
use crate::table::Row;
use files::image_file::{self, Encoding};
use scene::Film;
use std::path::Path;

/// The images of a row after each of the numbers of iterations in `counts`, which must increase. The row renders only
/// once, up to the last.
pub(crate) fn films<'a>(
    case: &'a Case,
    row: &Row,
    options: &Options,
    counts: impl Iterator<Item = u32> + 'a,
) -> impl Iterator<Item = Film> + 'a {
    let mut rung = row.start(&case.scene, &case.settings, options);
    counts.map(move |count| {
        while rung.iterations() < count {
            rung.iterate();
        }
        rung.develop()
    })
}

/// Checks that the folder for images exists.
///
/// # Errors
/// If the folder does not exist.
pub fn check(folder: &Path) -> Result<(), Error> {
    check_folder(folder, Field::Images)
}

/// Writes every row's image after 2, 4, 8, ... and after all iterations, as `SCENE-ROW-ITERATIONS.pfm`.
///
/// # Errors
/// If a file cannot be written.
pub fn write(
    folder: &Path,
    cases: &[Case],
    rows: &[&Row],
    options: &Options,
    progress: &mut dyn Progress,
) -> Result<(), Error> {
    let total: usize = cases.iter().map(|case| rows.len() * counts(case).count()).sum();
    progress.begin(total as u32, "images");
    let mut done = 0;
    for case in cases {
        for row in rows {
            for (count, film) in counts(case).zip(films(case, row, options, counts(case))) {
                let path = folder.join(format!("{}-{}-{count}.pfm", case.name, row.name));
                image_file::write(&path, &film, &Encoding::default())
                    .map_err(|error| Error::Failed(error.to_string()))?;
                done += 1;
                progress.step(done, &format!("{} row {}, {count} iterations", case.name, row.name));
            }
        }
    }
    progress.end();
    Ok(())
}

/// The numbers of iterations after which images are written.
fn counts(case: &Case) -> impl Iterator<Item = u32> + use<> {
    let all = case.settings.iterations;
    (1..u32::BITS).map(|k| 1 << k).take_while(move |&count| count < all).chain([all])
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Settings;

    #[test]
    fn images_are_of_powers_of_two_and_of_all_iterations() {
        let of = |iterations| {
            let scene = files::builtin::scene("cornell").unwrap();
            let settings = Settings { iterations, ..scene.settings };
            counts(&Case { name: String::new(), scene, settings, value: 0 }).collect::<Vec<_>>()
        };
        assert_eq!(of(1), [1]);
        assert_eq!(of(2), [2]);
        assert_eq!(of(8), [2, 4, 8]);
        assert_eq!(of(9), [2, 4, 8, 9]);
    }
}

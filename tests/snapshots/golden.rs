//! Compares renders with the stored snapshots. Only the reference may update the snapshots, and only on request.

use crate::difference;
use crate::rows::Row;
use crate::summary::summary;
use compare::differing_pixels;
use files::image_file::{self, Encoding};
use scene::{Engine, Film};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The folder of texts, next to this file.
const TEXT_FOLDER: &str = "text";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The path of a row's snapshot image.
fn image_path(name: &str) -> PathBuf {
    root().join("fixtures/snapshots").join(name).with_extension("pfm")
}

/// The path of a row's snapshot text.
fn text_path(name: &str) -> PathBuf {
    root().join("tests/snapshots").join(TEXT_FOLDER).join(name).with_extension("snap")
}

/// Whether snapshots are to be updated: if insta is told to overwrite its texts, as in `scripts/bless`.
pub(crate) fn blesses() -> bool {
    env::var("INSTA_UPDATE").is_ok_and(|mode| ["always", "force"].contains(&mode.as_str()))
}

/// Compares a render of the reference with the snapshot image and text, after updating them if requested.
pub(crate) fn check_reference(row: &Row, engine: &impl Engine) {
    let path = image_path(row.name);
    if blesses() {
        image_file::write(&path, &engine.develop(), &Encoding::default()).unwrap();
    }
    // Compare the image before the text and fail only at the end, so that a difference in the image is always shown.
    let image = check_image(row.name, "reference", &engine.develop());
    insta::with_settings!(
        { snapshot_path => TEXT_FOLDER, prepend_module_to_snapshot => false, omit_expression => true },
        { insta::assert_snapshot!(row.name, summary(row, engine)) }
    );
    image.unwrap_or_else(|problem| panic!("{problem}"));
}

/// Compares a render of another engine with the snapshots, without ever writing them.
pub(crate) fn check_other(row: &Row, engine: &impl Engine, who: &str) {
    check_image(row.name, who, &engine.develop()).unwrap_or_else(|problem| panic!("{problem}"));
    let path = text_path(row.name);
    let file = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let blessed = without_header(&file);
    let actual = summary(row, engine);
    assert!(
        blessed.trim_end() == actual.trim_end(),
        "{who} renders {} unlike the reference did when it was blessed; only the reference may bless.\n\
         blessed:\n{blessed}\nactual:\n{actual}",
        row.name
    );
}

/// The text of a snapshot file, which follows a header between two lines of `---`.
fn without_header(file: &str) -> &str {
    file.splitn(3, "---\n").nth(2).unwrap_or_else(|| panic!("no snapshot file of insta: {file}"))
}

/// Compares an image with the snapshot bit for bit. The error names files that show the difference.
fn check_image(name: &str, who: &str, actual: &Film) -> Result<(), String> {
    let path = image_path(name);
    let expected = image_file::read(&path)
        .map_err(|error| format!("{error}; scripts/bless makes it, from the reference"))?;
    let different = differing_pixels(&expected, actual).map_err(|error| error.to_string())?;
    if different.is_empty() {
        return Ok(());
    }
    let [png, json] = difference::show(&format!("{name}-{who}"), &expected, actual, &different);
    Err(format!(
        "{who} renders {name} unlike {} in {} of {} pixels.\n  expected | difference | actual: {}\n  \
         the pixels that differ: {}\nIf that is meant, look at both, and then run scripts/bless.",
        path.display(),
        different.len(),
        actual.pixels.len(),
        png.display(),
        json.display()
    ))
}

#[test]
fn headers_are_cut_off_and_nothing_else() {
    assert_eq!(without_header("---\nsource: a\n---\ntext\n--- more\n"), "text\n--- more\n");
}

#[test]
fn every_snapshot_belongs_to_a_test() {
    // Removing a row would leave files behind that no test checks.
    let names = |folder: &str, extension: &str| -> Vec<String> {
        let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        let mut names: Vec<String> = entries
            .filter(|path| path.extension().is_some_and(|e| e == extension))
            .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let images = names("fixtures/snapshots", "pfm");
    assert_eq!(images, names(&format!("tests/snapshots/{TEXT_FOLDER}"), "snap"));
    let rows = include_str!("rows.rs");
    for name in images {
        assert!(
            rows.contains(&format!("    {name}: ")) || rows.contains(&format!("\"{name}\"")),
            "{name} is blessed, and no row renders it"
        );
    }
}

#[test]
fn an_image_that_differs_in_one_bit_is_shown() {
    let mut film = image_file::read(&image_path("cornell")).unwrap();
    assert_eq!(check_image("cornell", "test", &film), Ok(()));
    let pixel = &mut film.pixels[5 * 64 + 7];
    pixel.y = f32::from_bits(pixel.y.to_bits() ^ 1);
    let problem = check_image("cornell", "test", &film).unwrap_err();
    assert!(problem.contains("1 of 3072 pixels"), "{problem}");
    for (start, extension) in [("actual: ", "png"), ("differ: ", "json")] {
        let path = problem.split(start).nth(1).unwrap().lines().next().unwrap();
        assert!(path.ends_with(extension) && Path::new(path).is_file(), "{problem}");
    }
}

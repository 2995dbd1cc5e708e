//! Writes what helps to find a failure: an image (expected | difference | actual), and a list of the pixels that
//! differ.

use compare::difference_image;
use files::image_file::{self, Encoding};
use scene::{Film, Rgb};
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};

/// Magnification of the image, as snapshots are small.
const ZOOM: u32 = 4;

/// White columns between the three parts of the image.
const GAP: u32 = 4;

/// Writes both files into the temporary folder of cargo's tests, and returns their paths.
pub(crate) fn show(name: &str, expected: &Film, actual: &Film, different: &[usize]) -> [PathBuf; 2] {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("snapshots");
    fs::create_dir_all(&folder).unwrap();
    let [png, json] = ["png", "json"].map(|extension| folder.join(format!("{name}.{extension}")));
    image_file::write(&png, &picture(expected, actual), &Encoding::default()).unwrap();
    fs::write(&json, list(expected, actual, different)).unwrap();
    [png, json]
}

fn picture(expected: &Film, actual: &Film) -> Film {
    let [e, a] = [expected, actual].map(finite);
    let difference = difference_image(&a, &e).unwrap().film;
    let (width, height) = (expected.width, expected.height);
    let mut all = Film::new(3 * width * ZOOM + 2 * GAP, height * ZOOM);
    all.pixels.fill(Rgb::ONE);
    for (place, film) in [expected, &difference, actual].into_iter().enumerate() {
        let left = place as u32 * (width * ZOOM + GAP);
        for (y, x) in (0..height * ZOOM).flat_map(|y| (0..width * ZOOM).map(move |x| (y, x))) {
            all.pixels[(y * all.width + left + x) as usize] =
                film.pixels[(y / ZOOM * width + x / ZOOM) as usize];
        }
    }
    all
}

/// The image with pixels that are NaN or infinite set to black, as they cannot be shown as a difference.
fn finite(film: &Film) -> Film {
    let pixels = film.pixels.iter().map(|&p| if p.is_finite() { p } else { Rgb::ZERO }).collect();
    Film { pixels, ..*film }
}

fn list(expected: &Film, actual: &Film, different: &[usize]) -> String {
    let value = |p: Rgb| {
        let [values, bits] =
            [p.to_array().map(|v| format!("{v:?}")), p.to_array().map(|v| format!("{:08x}", v.to_bits()))];
        json!({ "value": values, "bits": bits })
    };
    let width = expected.width as usize;
    let pixels: Vec<_> = different
        .iter()
        .map(|&i| {
            let (e, a) = (expected.pixels[i], actual.pixels[i]);
            json!({ "x": i % width, "y": i / width, "expected": value(e), "actual": value(a) })
        })
        .collect();
    let size = [expected.width, expected.height];
    serde_json::to_string_pretty(&json!({ "size": size, "differing": pixels })).unwrap() + "\n"
}

#[test]
fn the_image_shows_expected_difference_and_actual() {
    let film = |values: [f32; 2]| Film { width: 2, height: 1, pixels: values.map(Rgb::splat).to_vec() };
    let (expected, actual) = (film([0.25, 0.5]), film([0.25, f32::NAN]));
    let shown = picture(&expected, &actual);
    assert_eq!((shown.width, shown.height), (3 * 2 * ZOOM + 2 * GAP, ZOOM));
    let at = |place: u32, pixel: u32| shown.pixels[(place * (2 * ZOOM + GAP) + pixel * ZOOM) as usize];
    assert_eq!((at(0, 0), at(0, 1), at(2, 0)), (Rgb::splat(0.25), Rgb::splat(0.5), Rgb::splat(0.25)));
    assert!(at(2, 1).is_nan());
    assert!(at(1, 1).element_sum() > at(1, 0).element_sum(), "the difference is not the brightest");
    let json: serde_json::Value = serde_json::from_str(&list(&expected, &actual, &[1])).unwrap();
    assert_eq!((&json["differing"][0]["x"], &json["differing"][0]["y"]), (&1.into(), &0.into()));
    assert_eq!(json["differing"][0]["expected"]["bits"][0], "3f000000");
}

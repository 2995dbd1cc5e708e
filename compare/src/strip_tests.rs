//! Tests that strips give what whole images do, and that FLIP is that of its authors' program.

use crate::metrics::measure;
use crate::strips::Pair;
use crate::{CompareError, DifferenceMap, Metrics, difference_image};
use scene::{Film, FilmRows, Rgb, RowReader, srgb};

/// Both compute in `f32`, in the same order but for what compilers change. Measured: 1.2e-8.
const FLIP_ERROR: f64 = 1e-7;
/// The crate's images are rounded to 8 bits at each exposure, ours are not. Measured: 2.6e-4.
const ROUNDED_HDR_FLIP_ERROR: f64 = 1e-3;

/// Smooth slopes, noise, edges and fireflies from a hash of the place; brightness over twelve stops if `hdr`.
fn film(width: u32, height: u32, seed: u32, hdr: bool) -> Film {
    let noise = |x: u32, y: u32, c: u32| {
        let mut h = x.wrapping_mul(0x9e37_79b9)
            ^ y.wrapping_mul(0x85eb_ca6b)
            ^ (seed + 7 * c).wrapping_mul(0xc2b2_ae35);
        h ^= h >> 15;
        h = h.wrapping_mul(0x2c1b_3c6d);
        h ^= h >> 13;
        h as f32 / u32::MAX as f32
    };
    Film::from_fn(width, height, |x, y| {
        let slope = Rgb::new(x as f32 / width as f32, y as f32 / height as f32, 0.3);
        let edge = if (x / 9 + y / 13) % 2 == 0 { 1.0 } else { 0.25 };
        let firefly = if noise(x, y, 5) > 0.995 { 30.0 } else { 1.0 };
        let color = (slope + 0.2 * Rgb::new(noise(x, y, 1), noise(x, y, 2), noise(x, y, 3))) * edge;
        if hdr { color * firefly * (x as f32 / width as f32 * 12.0 - 6.0).exp2() } else { color }
    })
}

fn in_strips(a: &Film, b: &Film, rows: usize) -> (Metrics, Vec<(u64, u64)>) {
    let mut told = Vec::new();
    let (mut a, mut b) = (FilmRows::new(a), FilmRows::new(b));
    let mut pair = Pair { a: &mut a, b: &mut b };
    let metrics = measure(&mut pair, true, rows, &mut |done, of| told.push((done, of))).unwrap();
    (metrics, told)
}

#[test]
fn strips_change_no_bit() {
    for (width, height) in [(37, 90), (5, 43), (1, 17), (64, 8)] {
        let (a, b) = (film(width, height, 1, true), film(width, height, 2, true));
        let (whole, _) = in_strips(&a, &b, 1000);
        assert!(whole.ssim.all < 1.0 && whole.flip > 0.0 && whole.hdr_flip.unwrap() > 0.0, "{whole:?}");
        for rows in [8, 16, 40] {
            let (metrics, told) = in_strips(&a, &b, rows);
            assert_eq!(metrics, whole, "{width} x {height} in strips of {rows}");
            assert!(told.is_sorted() && told.last() == Some(&(3 * u64::from(height), 3 * u64::from(height))));
        }
        assert_eq!(Metrics { hdr_flip: whole.hdr_flip, ..Metrics::of(&a, &b).unwrap() }, whole);
    }
}

fn codes(film: &Film) -> nv_flip::FlipImageRgb8 {
    let bytes: Vec<u8> =
        film.pixels.iter().flat_map(scene::Vec3::to_array).map(|v| srgb::encode_byte(v.into())).collect();
    nv_flip::FlipImageRgb8::with_data(film.width, film.height, &bytes)
}

/// The error map of the authors' program.
fn theirs(test: &Film, reference: &Film) -> Vec<f32> {
    nv_flip::flip(codes(reference), codes(test), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec()
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
}

#[test]
fn flip_is_that_of_its_authors() {
    for (width, height) in [(90, 70), (3, 50), (1, 1), (40, 2)] {
        let (a, b) = (film(width, height, 3, false), film(width, height, 4, false));
        let (ours, theirs) = (Metrics::of(&a, &b).unwrap().flip, mean(&theirs(&a, &b)));
        assert!((ours - theirs).abs() <= FLIP_ERROR, "{width} x {height}: {ours}, theirs {theirs}");
    }
}

#[test]
fn hdr_flip_is_the_worst_of_its_exposures() {
    let (width, height) = (60, 50);
    let (a, b) = (film(width, height, 5, true), film(width, height, 6, true));
    // The definition, in f64 and by whole images of 8 bits.
    let luminance = |p: &Rgb| 0.2126 * f64::from(p.x) + 0.7152 * f64::from(p.y) + 0.0722 * f64::from(p.z);
    let mut luminances: Vec<f64> = b.pixels.iter().map(luminance).collect();
    luminances.sort_by(f64::total_cmp);
    let median = f64::midpoint(luminances[1499], luminances[1500]);
    let curve = |v: f64| (0.9036 * v * v + 0.018 * v) / (0.8748 * v * v + 0.354 * v + 0.14);
    // Bisection for the value that is tone-mapped to 0.85.
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..100 {
        let middle = f64::midpoint(low, high);
        if curve(middle) < 0.85 { low = middle } else { high = middle }
    }
    let [first, last] = [luminances[2999], median].map(|luminance| (low / luminance).log2());
    let count = (last - first).ceil() as usize;
    assert!(count > 4, "{count}");
    let mut worst = vec![0.0_f32; 3000];
    for i in 0..count {
        let gain = (first + (last - first) * i as f64 / (count - 1) as f64).exp2();
        let mapped = |film: &Film| {
            let map =
                |p: &Rgb| Rgb::from_array(p.to_array().map(|v| curve(f64::from(v) * gain).min(1.0) as f32));
            Film { pixels: film.pixels.iter().map(map).collect(), ..*film }
        };
        for (worst, error) in worst.iter_mut().zip(theirs(&mapped(&a), &mapped(&b))) {
            *worst = worst.max(error);
        }
    }
    let (ours, expected) = (in_strips(&a, &b, 16).0.hdr_flip.unwrap(), mean(&worst));
    assert!((ours - expected).abs() <= ROUNDED_HDR_FLIP_ERROR, "{ours}, expected {expected}");
}

#[test]
fn hdr_flip_sees_what_is_white_on_a_screen() {
    let flat = |v: f32| Film { width: 30, height: 30, pixels: vec![Rgb::splat(v); 900] };
    let (metrics, _) = in_strips(&flat(40.0), &flat(20.0), 8);
    assert!(metrics.flip == 0.0 && metrics.hdr_flip.unwrap() > 0.02, "{metrics:?}");
    assert_eq!(in_strips(&flat(20.0), &flat(20.0), 8).0.hdr_flip, Some(0.0));
    assert_eq!(in_strips(&flat(1.0), &flat(0.0), 8).0.hdr_flip, None);
    // Values whose squares are no floats.
    let (extreme, _) = in_strips(&flat(f32::MAX), &flat(1e-38), 8);
    assert!(extreme.hdr_flip.unwrap().is_finite());
}

#[test]
fn pixels_that_are_not_finite_are_counted_in_all_strips() {
    let (mut a, b) = (film(9, 100, 1, false), film(9, 100, 2, false));
    for place in [9 * 40 + 5, 9 * 41, 9 * 99 + 8] {
        a.pixels[place].y = f32::NAN;
    }
    let (mut a, mut b) = (FilmRows::new(&a), FilmRows::new(&b));
    let error = measure(&mut Pair { a: &mut a, b: &mut b }, true, 8, &mut |_, _| {}).unwrap_err();
    assert_eq!(error, CompareError::NotFinite { image: 'A', count: 3, x: 5, y: 40 });
}

#[test]
fn of_pixels_that_are_not_finite_all_in_a_row_count_and_the_first_is_told() {
    let (a, mut b) = (film(9, 30, 1, false), film(9, 30, 2, false));
    for place in [9 * 7 + 2, 9 * 7 + 3, 9 * 7 + 8, 9 * 20, 9 * 20 + 1] {
        b.pixels[place].x = f32::INFINITY;
    }
    let error = difference_image(&a, &b).unwrap_err();
    assert_eq!(error, CompareError::NotFinite { image: 'B', count: 5, x: 2, y: 7 });
}

/// Images are read several times; to who waits this is one task, which goes on from strip to strip until all is done.
#[test]
fn progress_goes_on_until_all_is_done() {
    let (a, b) = (film(8000, 400, 1, false), film(8000, 400, 2, false));
    let mut told = vec![(0, 0)];
    let mut progress = |done, all| told.push((done, all));
    DifferenceMap::of_rows(&mut FilmRows::new(&a), &mut FilmRows::new(&b), &mut progress).unwrap();
    let all = told[1].1;
    assert!(told.len() > 4 && told[1..].iter().all(|step| step.1 == all), "{told:?}");
    assert!(told.is_sorted_by(|earlier, later| earlier.0 < later.0), "{told:?}");
    assert_eq!(told.last(), Some(&(all, all)));
}

/// An image whose rows end too early.
struct Cut;

impl RowReader for Cut {
    fn size(&self) -> [u32; 2] {
        [4, 900]
    }

    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        pixels.fill(Rgb::ONE);
        Err("cut.png: ends too early".into())
    }

    fn rewind(&mut self) -> Result<(), String> {
        Ok(())
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let film = film(4, 900, 1, false);
    let expected = CompareError::Unreadable("cut.png: ends too early".into());
    assert_eq!(expected.to_string(), "cut.png: ends too early");
    for hdr_flip in [false, true] {
        let error =
            Metrics::of_rows(&mut FilmRows::new(&film), &mut Cut, hdr_flip, &mut |_, _| {}).unwrap_err();
        assert_eq!(error, expected);
    }
    let error = DifferenceMap::of_rows(&mut Cut, &mut FilmRows::new(&film), &mut |_, _| {}).unwrap_err();
    assert_eq!(error, expected);
}

#[test]
fn the_difference_is_mapped_in_strips_as_a_whole() {
    let (a, b) = (film(300, 90, 1, true), film(300, 90, 2, true));
    let image = difference_image(&a, &b).unwrap();
    let mut worst: Vec<f32> =
        a.pixels.iter().zip(&b.pixels).map(|(p, q)| (*p - *q).abs().max_element()).collect();
    worst.sort_by(f32::total_cmp);
    assert_eq!(image.scale, worst[(26_999.0_f64 * 0.995).ceil() as usize]);
}

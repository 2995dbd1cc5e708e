//! Tests of the metrics on images with known results.

use crate::{Channels, LargestDifference, Metrics, Thresholds, difference_image};
use approx::assert_relative_eq;
use scene::{Film, Rgb, srgb};

fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> Rgb) -> Film {
    let pixels =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
    Film { width, height, pixels }
}

fn flat(width: u32, height: u32, value: [f32; 3]) -> Film {
    image(width, height, |_, _| value.into())
}

fn textured(x: u32, y: u32) -> Rgb {
    Rgb::new((x * 5 % 7) as f32, (y * 3 % 5) as f32, 1.0) * 0.2
}

#[test]
fn of_an_image_and_itself_nothing_differs() {
    for (width, height) in [(1, 1), (7, 3), (1, 40), (48, 27)] {
        let a = image(width, height, textured);
        let m = Metrics::of(&a, &a).unwrap();
        assert!(m.identical && m.differing_pixels == 0 && m.largest_difference.value == 0.0);
        for zero in [m.rmse, m.relative_mse, m.block_relative_mse] {
            assert_eq!(zero, Channels { red: 0.0, green: 0.0, blue: 0.0, all: 0.0 });
        }
        assert_eq!((m.psnr, m.ssim.all, m.flip), (f64::INFINITY, 1.0, 0.0));
        let table = m.table();
        assert!(
            table.contains("identical to the last bit") && !table.contains("largest difference"),
            "{table}"
        );
        let json = serde_json::to_value(m).unwrap();
        assert!(json["psnr"].is_null() && json["identical"] == true && json["rmse"]["all"] == 0.0);
    }
}

#[test]
fn a_constant_offset_is_measured_exactly() {
    let b = flat(20, 10, [0.5, 0.25, 0.0]);
    let a = flat(20, 10, [0.75, 0.25, 0.125]);
    let m = Metrics::of(&a, &b).unwrap();
    assert_eq!(m.mean_a.all, (0.75 + 0.25 + 0.125) / 3.0);
    assert_eq!((m.mean_b.red, m.mean_b.green, m.mean_b.blue), (0.5, 0.25, 0.0));
    assert_eq!((m.rmse.red, m.rmse.green, m.rmse.blue), (0.25, 0.0, 0.125));
    assert_relative_eq!(m.rmse.all, ((0.25_f64.powi(2) + 0.125_f64.powi(2)) / 3.0).sqrt());
    let relative = [0.0625 / 0.26, 0.0, 0.015_625 / 0.01];
    for of in [m.relative_mse, m.block_relative_mse] {
        assert_relative_eq!(of.red, relative[0], max_relative = 1e-12);
        assert_eq!(of.green, 0.0);
        assert_relative_eq!(of.blue, relative[2], max_relative = 1e-12);
        assert_relative_eq!(of.all, relative.iter().sum::<f64>() / 3.0, max_relative = 1e-12);
    }
    assert_eq!(m.differing_pixels, 200);
    assert_eq!(m.largest_difference, LargestDifference { value: 0.25, channel: "red", x: 0, y: 0 });
}

#[test]
fn psnr_is_of_the_srgb_image() {
    let of_code = |c: f64| [srgb::decode(c) as f32; 3];
    let m = Metrics::of(&flat(4, 4, of_code(0.5)), &flat(4, 4, of_code(0.4))).unwrap();
    assert_relative_eq!(m.psnr, 20.0, max_relative = 1e-6);
    let beyond_white = Metrics::of(&flat(4, 4, [5.0; 3]), &flat(4, 4, [9.0; 3])).unwrap();
    assert_eq!((beyond_white.psnr, beyond_white.rmse.all), (f64::INFINITY, 4.0));
}

#[test]
fn flip_of_the_farthest_colours_is_one() {
    // FLIP scales colour differences such that the one between sRGB green and blue is 1.
    let m = Metrics::of(&flat(40, 40, [0.0, 1.0, 0.0]), &flat(40, 40, [0.0, 0.0, 1.0])).unwrap();
    assert_relative_eq!(m.flip, 1.0, max_relative = 1e-3);
}

#[test]
fn noise_that_averages_out_leaves_the_blocks_alone() {
    let b = flat(16, 24, [0.5; 3]);
    let a = image(16, 24, |x, y| Rgb::splat(if (x + y) % 2 == 0 { 0.25 } else { 0.75 }));
    let m = Metrics::of(&a, &b).unwrap();
    assert_relative_eq!(m.relative_mse.all, 0.0625 / 0.26, max_relative = 1e-12);
    assert_eq!(m.block_relative_mse.all, 0.0);
}

#[test]
fn blocks_at_the_border_count_by_their_pixels() {
    // A whole block without error, beside a block of a single column that is off by 1 from black.
    let a = image(9, 1, |x, _| Rgb::splat(if x == 8 { 1.0 } else { 0.0 }));
    let m = Metrics::of(&a, &flat(9, 1, [0.0; 3])).unwrap();
    assert_relative_eq!(m.block_relative_mse.all, 100.0 / 9.0, max_relative = 1e-12);
}

#[test]
fn a_sign_of_zero_is_a_difference_of_bits_alone() {
    let m = Metrics::of(&flat(2, 1, [-0.0, 0.0, 0.0]), &flat(2, 1, [0.0; 3])).unwrap();
    assert!(
        !m.identical && m.differing_pixels == 2 && m.rmse.all == 0.0 && m.largest_difference.value == 0.0
    );
    // The table says so too, though it has no largest difference to tell.
    let table = m.table();
    assert!(table.starts_with("2 x 1 pixels, of which 2 differ (100.00 %)\n"), "{table}");
    assert!(!table.contains("largest difference"), "{table}");
}

#[test]
fn the_largest_difference_is_found() {
    let mut a = image(7, 5, textured);
    a.pixels[7 * 3 + 4].z -= 100.0;
    let m = Metrics::of(&a, &image(7, 5, textured)).unwrap();
    assert_eq!((m.differing_pixels, m.largest_difference.channel), (1, "blue"));
    assert_eq!((m.largest_difference.x, m.largest_difference.y), (4, 3));
    assert_relative_eq!(m.largest_difference.value, 100.0, max_relative = 1e-6);
    assert!(m.table().contains("blue at (4, 3)"), "{}", m.table());
}

#[test]
fn extreme_radiance_gives_finite_metrics() {
    let m = Metrics::of(&flat(2, 2, [f32::MAX; 3]), &flat(2, 2, [f32::MIN; 3])).unwrap();
    assert!(m.rmse.all.is_finite() && m.relative_mse.all.is_finite() && m.ssim.all.is_finite());
}

#[test]
fn images_that_do_not_match_are_refused() {
    let line = |a: &Film, b: &Film| Metrics::of(a, b).unwrap_err().to_string();
    let small = flat(2, 3, [0.0; 3]);
    assert_eq!(
        line(&small, &flat(3, 2, [0.0; 3])),
        "image A is 2 x 3 pixels and image B 3 x 2; they must have the same size"
    );
    assert_eq!(line(&Film::new(0, 0), &Film::new(0, 0)), "the images have no pixels");
    let mut broken = small.clone();
    broken.pixels[3].y = f32::NAN;
    broken.pixels[5].x = f32::INFINITY;
    let expected = "has 2 pixels with a NaN or an infinity, the first at (1, 1); all must be finite";
    assert_eq!(line(&small, &broken), format!("image B {expected}"));
    assert_eq!(difference_image(&broken, &small).unwrap_err().to_string(), format!("image A {expected}"));
}

#[test]
fn thresholds_are_exceeded_beyond_their_value_alone() {
    let m = Metrics::of(&flat(9, 9, [0.5; 3]), &flat(9, 9, [0.25; 3])).unwrap();
    let at = |slack: f64| Thresholds {
        max_rmse: Some(m.rmse.all + slack),
        max_relmse: Some(m.relative_mse.all + slack),
        max_block_relmse: Some(m.block_relative_mse.all + slack),
        max_flip: Some(m.flip + slack),
        max_hdr_flip: Some(slack),
        max_abs: Some(m.largest_difference.value + slack),
        min_ssim: Some(m.ssim.all - slack),
        min_psnr: Some(m.psnr - slack),
    };
    assert!(Thresholds::default().exceeded(&m).is_empty());
    assert!(at(0.0).exceeded(&m).is_empty());
    let exceeded = at(-1e-6).exceeded(&m);
    let fields = [
        "max_rmse",
        "max_relmse",
        "max_block_relmse",
        "max_flip",
        "max_hdr_flip",
        "max_abs",
        "min_ssim",
        "min_psnr",
    ];
    assert_eq!(exceeded.iter().map(|exceeded| exceeded.field).collect::<Vec<_>>(), fields);
    assert_eq!(
        exceeded[5].to_string(),
        format!("the largest difference is 0.25, above max_abs {}", 0.25 - 1e-6)
    );
    assert!(exceeded[7].to_string().contains(", below min_psnr "));
}

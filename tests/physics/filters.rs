//! The pixels' filters, as seen in images: a far lamp smaller than a pixel is spread by the filter's own shape, a uniform
//! field stays uniform, and all of the light is kept.

use crate::cases::tell;
use crate::harness::{BLACK, Build, empty_scene, pinhole, render_path, render_sppm, settings};
use scene::{Film, Filter, Rgb, Scene, Settings, Vec3};

const SIDE: u32 = 9;

/// Settings for a small image without photons that count.
fn filtered(filter: Filter, iterations: u32) -> Settings {
    Settings { filter, iterations, ..settings(SIDE, SIDE, 1, 2, 1.0) }
}

/// A lamp with a radius of a fifth of a pixel, at a place given in pixels from the image's centre.
fn speck([x, y]: [f64; 2]) -> Scene {
    // At distance 100 and 90 degrees of view the image is 200 wide.
    let pixel = 200.0 / f64::from(SIDE);
    let center = Vec3::new((x * pixel) as f32, (-y * pixel) as f32, -100.0);
    empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 90.0)).lamp(center, 0.2 * pixel as f32, BLACK, Rgb::ONE)
}

/// The mean of the red channel over all pixels.
fn total(film: &Film) -> f64 {
    film.pixels.iter().map(|pixel| f64::from(pixel.x)).sum()
}

/// Each pixel receives the share of the speck that the filter's value at its distance says.
#[test]
fn a_speck_is_spread_by_the_shape_of_the_filter() {
    /// Of the largest share, which is the mean of some thousand hits; the lamp's width blurs the others.
    const TOLERANCE: f64 = 0.05;
    const ITERATIONS: u32 = 16_000;
    let mut cases = 0;
    for filter in [Filter::Gaussian, Filter::Mitchell] {
        for place in [[0.0, 0.0], [0.3, -0.4]] {
            let scene = speck(place);
            let settings = filtered(filter, ITERATIONS);
            for film in [render_sppm(&scene, &settings), render_path(&scene, &settings)] {
                let total = total(&film);
                let value = |i: u32, at: f64| {
                    let distance = f64::from(i) - f64::from(SIDE / 2) - at;
                    let around = |shift: i32| filter.value(distance + f64::from(shift));
                    filter.value(distance) / (-8..=8).map(around).sum::<f64>()
                };
                for (index, pixel) in film.pixels.iter().enumerate() {
                    let (x, y) = (index as u32 % SIDE, index as u32 / SIDE);
                    let expected = value(x, place[0]) * value(y, place[1]);
                    let actual = f64::from(pixel.x) / total;
                    assert!(
                        (actual - expected).abs() < TOLERANCE * value(SIDE / 2, place[0]).abs(),
                        "{filter}, pixel ({x}, {y}): {actual}, not {expected}"
                    );
                    cases += 1;
                }
            }
        }
    }
    tell("physics", cases, "pixels around a speck of light, by two filters");
}

#[test]
fn every_filter_keeps_a_uniform_field() {
    /// The weights of Mitchell's filter vary by 0.3 about 1; over 4096 stratified samples their mean does by much less.
    const TOLERANCE: f32 = 2e-3;
    let shell =
        empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 60.0)).lamp(Vec3::ZERO, 10.0, BLACK, Rgb::splat(0.5));
    for filter in Filter::ALL {
        let settings = filtered(filter, 4096);
        for (film, tolerance) in
            [(render_sppm(&shell, &settings), TOLERANCE), (render_path(&shell, &settings), 10.0 * TOLERANCE)]
        {
            for pixel in &film.pixels {
                assert!((pixel.x - 0.5).abs() < tolerance, "{filter}: {pixel}");
            }
        }
    }
    tell("physics", 2 * 3 * (SIDE * SIDE) as usize, "pixels of a uniform field, by three filters");
}

/// Indirect light passes through the filter as direct light does: the weight of a sample is on its visible point as well.
#[test]
fn indirect_light_is_filtered_like_direct_light() {
    /// Of the mean. Photons are few, and both renders have the same.
    const TOLERANCE: f64 = 0.05;
    let scene = files::builtin::scene("cornell").unwrap();
    let with = |filter| {
        let settings = Settings { filter, ..settings(24, 18, 20_000, 5, 6.0) };
        let film = render_sppm(&scene, &Settings { iterations: 24, ..settings });
        total(&film)
    };
    let plain = with(Filter::Box);
    for filter in [Filter::Gaussian, Filter::Mitchell] {
        let ratio = with(filter) / plain;
        assert!((ratio - 1.0).abs() < TOLERANCE, "{filter}: {ratio}");
    }
    tell("physics", 2, "filtered images of as much light");
}

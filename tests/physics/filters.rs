//! The pixels' filters, as seen in images: a far lamp smaller than a pixel is spread by the filter's own shape, a uniform
//! field stays uniform, and all of the light is kept.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, diffuse, empty_scene, glass, pinhole, render_paths, render_photons, settings,
};
use reference::camera_pass::{CameraNumbers, camera_ray};
use scene::{Film, Filter, RadiusSchedule, Rgb, Scene, Settings, Vec3};

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

/// A filter by its definition, up to a factor: the Gaussian of deviation 1/2, less its value where it is cut off, and the cubic of
/// Mitchell and Netravali (1988, equation 8) with B = C = 1/3.
fn definition(filter: Filter, x: f64) -> f64 {
    const B: f64 = 1.0 / 3.0;
    const C: f64 = 1.0 / 3.0;
    let x = x.abs();
    match filter {
        Filter::Box => f64::from(x <= 0.5),
        _ if x >= 2.0 => 0.0,
        Filter::Gaussian => (-x * x / (2.0 * 0.25)).exp() - (-4.0_f64 / (2.0 * 0.25)).exp(),
        Filter::Mitchell if x < 1.0 => {
            (12.0 - 9.0 * B - 6.0 * C) * x.powi(3) + (-18.0 + 12.0 * B + 6.0 * C) * x * x + 6.0 - 2.0 * B
        }
        Filter::Mitchell => {
            (-B - 6.0 * C) * x.powi(3)
                + (6.0 * B + 30.0 * C) * x * x
                + (-12.0 * B - 48.0 * C) * x
                + 8.0 * B
                + 24.0 * C
        }
    }
}

/// Of 2048 even numbers, as many are mapped to each part of the axis as the size of the definition has there, and what they
/// count is its sign: so sums over a part are the integral of the definition.
#[test]
fn tables_have_the_shape_of_their_definitions() {
    /// Pieces of the table within a part, and the width of the samples that it is made of.
    const TOLERANCE: f64 = 2e-3;
    /// The width of those samples, times the largest density.
    const PIECE: f64 = 5e-5;
    const NUMBERS: u32 = 1 << 15;
    const PARTS: usize = 25;
    for filter in [Filter::Gaussian, Filter::Mitchell] {
        let table = filter.table().unwrap();
        let mut found = [0.0; PARTS];
        let width = 4.0 / PARTS as f64;
        for k in 0..NUMBERS {
            let (place, weight) = table.place((k as f32 + 0.5) / NUMBERS as f32);
            let part = (f64::from(place) + 1.5) / width;
            found[(part as usize).min(PARTS - 1)] += f64::from(weight) / f64::from(NUMBERS);
        }
        let integral = |from: f64, to: f64| {
            let step = (to - from) / 1000.0;
            (0..1000).map(|i| step * definition(filter, from + (f64::from(i) + 0.5) * step)).sum::<f64>()
        };
        let all = integral(-2.0, 0.0) + integral(0.0, 2.0);
        // Each piece has as much of the definition's size as others, also where that comes to nothing.
        let size = |to: f64| {
            let step = (to + 2.0) / 20_000.0;
            (0..20_000)
                .map(|i| step * definition(filter, -2.0 + (f64::from(i) + 0.5) * step).abs())
                .sum::<f64>()
        };
        let whole = size(2.0);
        for piece in [1, 2, 5, 100, 512, 900, 1023] {
            let share = size(f64::from(table.begins[piece]) - 0.5) / whole;
            let expected = piece as f64 / table.begins.len() as f64;
            assert!((share - expected).abs() < PIECE, "{filter}, piece {piece}: {share}, not {expected}");
        }
        for (part, found) in found.into_iter().enumerate() {
            let from = part as f64 * width - 2.0;
            let expected = integral(from, from + width) / all;
            assert!((found - expected).abs() < TOLERANCE, "{filter} from {from}: {found}, not {expected}");
        }
    }
    tell("physics", 2 * NUMBERS as usize, "places that two filters draw");
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
            for film in [render_photons(&scene, &settings), render_paths(&scene, &settings)] {
                let total = total(&film);
                let value = |i: u32, at: f64| {
                    let distance = f64::from(i) - f64::from(SIDE / 2) - at;
                    let around = |shift: i32| definition(filter, distance + f64::from(shift));
                    definition(filter, distance) / (-8..=8).map(around).sum::<f64>()
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
        let global = Settings { radius_schedule: RadiusSchedule::Global, ..settings };
        for (film, tolerance) in [
            (render_photons(&shell, &settings), TOLERANCE),
            (render_photons(&shell, &global), TOLERANCE),
            (render_paths(&shell, &settings), 10.0 * TOLERANCE),
        ] {
            for pixel in &film.pixels {
                assert!((pixel.x - 0.5).abs() < tolerance, "{filter}: {pixel}");
            }
        }
    }
    tell("physics", 3 * 3 * (SIDE * SIDE) as usize, "pixels of a uniform field, by three filters");
}

/// Indirect light passes through the filter as direct light does: the weight of a sample is on its visible point as well.
#[test]
fn indirect_light_is_filtered_like_direct_light() {
    /// Of the mean. Photons are few, and both renders have the same.
    const TOLERANCE: f64 = 0.05;
    let scene = files::builtin::scene("cornell").unwrap();
    let with = |filter| {
        let settings = Settings { filter, ..settings(24, 18, 20_000, 5, 6.0) };
        let film = render_photons(&scene, &Settings { iterations: 24, ..settings });
        total(&film)
    };
    let plain = with(Filter::Box);
    for filter in [Filter::Gaussian, Filter::Mitchell] {
        let ratio = with(filter) / plain;
        assert!((ratio - 1.0).abs() < TOLERANCE, "{filter}: {ratio}");
    }
    tell("physics", 2, "filtered images of as much light");
}

/// The light of photons counts by the filter's weight of the sample that they light, which may be negative. A disc is rendered under a
/// bare lamp, by direct light, and under the same lamp within glass of index 1, which stops shadow rays and bends nothing, so by
/// photons: both images are the same.
#[test]
fn light_by_photons_has_the_shape_of_the_filter() {
    /// Of the brightest pixel, for the noise of photons. If negative weights of Mitchell's filter counted as positive, pixels
    /// within the rim would differ by 0.06.
    const TOLERANCE: f64 = 0.03;
    // At distance 100 and 90 degrees of view the image is 200 wide. The disc is what a ball shows of itself in a black wall.
    let pixel = 200.0 / SIDE as f32;
    let (ball, disc) = (50.0 * pixel, 2.2 * pixel);
    let middle = -100.0 - (ball * ball - disc * disc).sqrt();
    let scene = empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 90.0))
        .ball(Vec3::Z * middle, ball, diffuse(0.5))
        .ball(Vec3::NEG_Z * 1e5, 1e5 - 100.0, BLACK);
    let lit = |scene: Scene| scene.lamp(Vec3::Z * 60.0, 20.0, BLACK, Rgb::ONE);
    let scenes = [lit(scene.clone()), lit(scene.ball(Vec3::Z * 60.0, 30.0, glass(1.0, 1.0)))];
    for filter in [Filter::Gaussian, Filter::Mitchell] {
        let settings = Settings {
            photons_per_iteration: 30_000,
            initial_radius: 0.4 * pixel,
            max_depth: 3,
            ..filtered(filter, 256)
        };
        let [direct, photons] = scenes.each_ref().map(|scene| folded(&render_photons(scene, &settings)));
        let brightest = direct.iter().copied().fold(0.0, f64::max);
        for (index, (photons, direct)) in photons.into_iter().zip(direct).enumerate() {
            let difference = (photons - direct).abs() / brightest;
            assert!(
                difference < TOLERANCE,
                "{filter}, pixel {index}: {photons} by photons, {direct} directly"
            );
        }
    }
    tell(
        "physics",
        2 * (SIDE * SIDE) as usize,
        "pixels of a disc by photons and by direct light, by two filters",
    );
}

/// The mean of a channel and of its seven mirror images, in the order of pixels.
fn folded(film: &Film) -> Vec<f64> {
    let at = |x: u32, y: u32| f64::from(film.pixels[(y * SIDE + x) as usize].x);
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let corners = [x, SIDE - 1 - x].into_iter().flat_map(|x| [y, SIDE - 1 - y].map(|y| (x, y)));
            corners.map(|(x, y)| at(x, y) + at(y, x)).sum::<f64>() / 8.0
        })
        .collect()
}

/// A filter reaches as far beyond the border of the image as within: whichever the pixel, what its rays count has the mean and the
/// variance of the definition around its middle.
#[test]
fn pixels_at_the_border_see_as_far_beyond_it_as_within() {
    /// Of some thousand numbers that are stratified along either axis, and whose products with the other's weight are not.
    const NEAR: f64 = 0.02;
    const ITERATIONS: u32 = 4096;
    const STEPS: i32 = 4000;
    let frame = speck([0.0, 0.0]).camera.frame(SIDE, SIDE);
    let mut cases = 0;
    for filter in Filter::ALL {
        let (settings, table) = (filtered(filter, 1), filter.table());
        let moment = |power: i32| -> f64 {
            let at = |step: i32| 2.0 * (f64::from(step) + 0.5) / f64::from(STEPS);
            (-STEPS..STEPS).map(|step| definition(filter, at(step)) * at(step).powi(power)).sum()
        };
        let variance = moment(2) / moment(0);
        for (x, y) in [(0, 0), (4, 4), (0, SIDE - 1), (SIDE - 1, 3), (SIDE - 1, SIDE - 1)] {
            let mut sums = [[0.0; 3]; 2];
            for iteration in 0..ITERATIONS {
                let numbers = CameraNumbers::new(&settings, iteration, x, y);
                let (ray, weight) = camera_ray(&frame, table, x, y, &numbers);
                let [right, up, forward] =
                    [frame.right, frame.up, frame.forward].map(|axis| f64::from(ray.direction.dot(axis)));
                let from_middle = |along: f64, pixel: u32| {
                    along / forward / f64::from(frame.pixel) + f64::from(SIDE) / 2.0 - f64::from(pixel) - 0.5
                };
                for (sums, place) in sums.iter_mut().zip([from_middle(right, x), from_middle(-up, y)]) {
                    for (power, sum) in (0..).zip(sums) {
                        *sum += f64::from(weight) * place.powi(power);
                    }
                }
            }
            for [all, first, second] in sums {
                let (mean, square) = (first / all, second / all);
                assert!(
                    mean.abs() < NEAR && (square - variance).abs() < NEAR,
                    "{filter} at {x}, {y}: {mean}, {square}"
                );
                cases += 1;
            }
        }
    }
    tell("physics", cases, "axes along which pixels are filtered");
}

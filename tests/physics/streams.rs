//! Random streams and Sobol points: uniform, and independent for neighbouring keys, pixels and iterations.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, SIGNIFICANCE, assert_uniform_square, chi_square_p, empty_scene, glass, pinhole, settings,
};
use reference::{PathTracer, Sppm};
use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::{DIMENSIONS, sobol};
use scene::{Engine, Rgb, Scene, Settings, Vec3};

const FAMILIES: [Family; 6] =
    [Family::Camera, Family::Tile, Family::Photon, Family::Emission, Family::Shutter, Family::Path];

const PAIRS: u32 = 1 << 18;

/// Allowed deviation of a correlation or a count of equal bits, in standard errors: as unlikely as [`SIGNIFICANCE`]
/// over all bits of a comparison.
const DEVIATIONS: f64 = 5.5;

/// The `n`th word (from 0) of a stream.
fn word(mut stream: Stream, n: u32) -> u32 {
    for _ in 0..n {
        stream.next_u32();
    }
    stream.next_u32()
}

/// Number of low bits of a word that are not used in floats. With some keys they show weak patterns between indices 512
/// apart.
const UNUSED_BITS: usize = 8;

/// Asserts that the two words of [`PAIRS`] pairs are independent.
fn assert_unrelated(pair: impl Fn(u32) -> [u32; 2], what: &str) {
    let unit = |x: u32| f64::from(x) / 4_294_967_296.0;
    assert_uniform_square((0..PAIRS).map(|i| pair(i).map(unit)), [64, 64], what);

    let (mut covariance, mut equal) = (0.0, [0_u32; 32]);
    for [a, b] in (0..PAIRS).map(pair) {
        covariance += (unit(a) - 0.5) * (unit(b) - 0.5);
        for (bit, count) in equal.iter_mut().enumerate() {
            *count += !(a ^ b) >> bit & 1;
        }
    }
    // The product of two centred uniform numbers has a variance of (1/12)^2.
    let correlation = covariance * 12.0 / f64::from(PAIRS).sqrt();
    assert!(correlation.abs() < DEVIATIONS, "{what}: correlated by {correlation:.1} standard errors");
    for (bit, &count) in equal.iter().enumerate().skip(UNUSED_BITS) {
        let excess = (2.0 * f64::from(count) - f64::from(PAIRS)) / f64::from(PAIRS).sqrt();
        assert!(excess.abs() < DEVIATIONS, "{what}: bit {bit} agrees {excess:.1} standard errors too often");
    }
}

#[test]
fn words_are_uniform_in_their_high_and_low_bits() {
    for family in FAMILIES {
        let key = StreamKey::new(5, family, 0);
        for n in [0, 1, 2, 7, 30] {
            let (mut high, mut low) = (vec![0; 4096], vec![0; 4096]);
            for index in 0..1 << 18 {
                let word = word(key.stream(index), n);
                high[(word >> 20) as usize] += 1;
                low[(word & 0xfff) as usize] += 1;
            }
            for (which, counts) in [("high", high), ("low", low)] {
                let p = chi_square_p(&counts);
                assert!(p > SIGNIFICANCE, "{family:?}, word {n}, {which} bits: p = {p:.1e}");
            }
        }
    }
    tell("physics", 2 * 5 * FAMILIES.len(), "histograms of words");
}

#[test]
fn floats_of_one_long_stream_are_uniform() {
    let mut counts = vec![0; 1024];
    let mut stream = StreamKey::new(6, Family::Photon, 0).stream(0);
    for _ in 0..1 << 20 {
        let u = stream.next_f32();
        assert!((0.0..1.0).contains(&u));
        counts[(u * 1024.0) as usize] += 1;
    }
    let p = chi_square_p(&counts);
    assert!(p > SIGNIFICANCE, "p = {p:.1e}");
}

#[test]
fn neighbouring_indices_are_unrelated() {
    for seed in [0, 1, u64::MAX] {
        let key = StreamKey::new(seed, Family::Camera, 0);
        for distance in [1, 2, 512] {
            let pair = |i: u32| [0, distance].map(|d| key.stream(i + d).next_u32());
            assert_unrelated(pair, &format!("seed {seed}, indices i and i + {distance}"));
        }
    }
    tell("physics", 9, "pairs of neighbouring indices");
}

#[test]
fn neighbouring_iterations_are_unrelated() {
    for iteration in [0, 1, 1000] {
        let keys = [iteration, iteration + 1].map(|i| StreamKey::new(1, Family::Photon, i));
        assert_unrelated(
            |i| keys.map(|k| k.stream(i).next_u32()),
            &format!("iteration {iteration} and the next"),
        );
    }
    // The same for one index over all iterations.
    let first = |i: u32| StreamKey::new(1, Family::Tile, i).stream(0).next_u32();
    assert_unrelated(|i| [first(i), first(i + 1)], "one index, iterations i and i + 1");
}

#[test]
fn neighbouring_seeds_are_unrelated() {
    for seed in [0, 1, 1 << 32] {
        let keys = [seed, seed + 1].map(|s| StreamKey::new(s, Family::Path, 0));
        assert_unrelated(|i| keys.map(|k| k.stream(i).next_u32()), &format!("seed {seed} and the next"));
    }
    let first = |seed: u32| StreamKey::new(u64::from(seed), Family::Emission, 0).stream(0).next_u32();
    assert_unrelated(|i| [first(i), first(i + 1)], "one index, seeds s and s + 1");
}

#[test]
fn families_are_unrelated() {
    for (a, first) in FAMILIES.into_iter().enumerate() {
        for second in FAMILIES.into_iter().skip(a + 1) {
            let keys = [first, second].map(|family| StreamKey::new(1, family, 0));
            assert_unrelated(|i| keys.map(|k| k.stream(i).next_u32()), &format!("{first:?} and {second:?}"));
        }
    }
    tell("physics", 15, "pairs of families");
}

#[test]
fn words_of_one_stream_are_unrelated() {
    let key = StreamKey::new(1, Family::Path, 0);
    for (m, n) in [(0, 1), (1, 2), (0, 2), (4, 5), (0, 16)] {
        let pair = |i: u32| [word(key.stream(i), m), word(key.stream(i), n)];
        assert_unrelated(pair, &format!("words {m} and {n}"));
    }
    tell("physics", 5, "pairs of words");
}

#[test]
fn shifted_sobol_points_are_uniform_in_every_two_dimensions() {
    // 16 random shifts of 2^14 points each, like the shifts of photons' points in each iteration.
    let mut cases = 0;
    for (a, b) in (0..DIMENSIONS).flat_map(|a| (a + 1..DIMENSIONS).map(move |b| (a, b))) {
        let points = (0..16).flat_map(|shift| {
            let mut words = StreamKey::new(9, Family::Emission, shift).stream(0);
            let shifts = [(); DIMENSIONS].map(|()| words.next_u32());
            (0..1 << 14).map(move |index| [a, b].map(|d| f64::from(unit_float(sobol(index, d) ^ shifts[d]))))
        });
        assert_uniform_square(points, [32, 32], &format!("dimensions {a} and {b}"));
        cases += 1;
    }
    tell("physics", cases, "pairs of Sobol dimensions");
}

/// Renders the inside of a glowing glass ball that reflects half of the light, seen from its centre. A pixel then shows
/// the number of reflections of its path plus one; the value k has a probability of 2^-k. Returns the values of all
/// pixels, row by row, for each iteration.
fn reflections(width: u32, height: u32, iterations: u32) -> Vec<Vec<i32>> {
    // The reflectance at right angles is ((n - 1) / (n + 1))^2.
    let ior = 3.0 + 8.0_f32.sqrt();
    let scene =
        empty_scene(pinhole(Vec3::ZERO, Vec3::X, 60.0)).lamp(Vec3::ZERO, 3.0, glass(1.0, ior), Rgb::ONE);
    let mut engine = Sppm::new(&scene, &settings(width, height, 1, 64, 1.0));
    let mut before = vec![0; (width * height) as usize];
    let mut shown = || {
        engine.iterate();
        let sums = engine.direct().unwrap().pixels.iter().map(|p| p.x.round() as i32).collect::<Vec<i32>>();
        let shown = sums.iter().zip(&before).map(|(sum, before)| sum - before).collect();
        before = sums;
        shown
    };
    (0..iterations).map(|_| shown()).collect()
}

/// The first segments of a path use stratified numbers; later ones use the path's own random stream.
const STRATIFIED: i32 = 4;

/// Each pixel has independent random numbers in each iteration. Of pairs of independent paths that are both longer than
/// the stratified segments, a third have equal length.
#[test]
fn paths_of_neighbouring_pixels_and_iterations_are_unrelated() {
    let (width, height) = (720, 560);
    let shown = reflections(width as u32, height as u32, 2);
    // The excess of pairs with equal values over a third, in standard errors.
    let excess = |other: &[i32], dx: i32, dy: i32| {
        let inner = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y)));
        let at = |x, y| (y * width + x) as usize;
        let pairs = inner.map(|(x, y)| (shown[0][at(x, y)], other[at(x + dx, y + dy)]));
        let long: Vec<_> = pairs.filter(|(a, b)| *a.min(b) > STRATIFIED).collect();
        let (total, equal) = (long.len() as f64, long.iter().filter(|(a, b)| a == b).count() as f64);
        assert!(total > 100.0, "only {total} pairs of long paths");
        (equal - total / 3.0) / (total * 2.0 / 9.0).sqrt()
    };
    for (dx, dy) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
        let excess = excess(&shown[0], dx, dy);
        assert!(excess.abs() < DEVIATIONS, "pixels and those {dx}, {dy} away: {excess:.1} standard errors");
    }
    let excess = excess(&shown[1], 0, 0);
    assert!(excess.abs() < DEVIATIONS, "iterations: {excess:.1} standard errors");
    tell("physics", 5, "pairs of neighbouring paths");
}

/// Half of the 64 pixels of a tile are reflected in each iteration, and each pixel is in half of the iterations.
#[test]
fn choices_at_glass_are_spread_evenly_over_tiles_and_iterations() {
    const ITERATIONS: u32 = 64;
    // With independent numbers, the counts would have a standard deviation of 4. The deviation allowed for a tile
    // covers the rounding of the reflectance by 2^-24.
    const OF_TILE: i32 = 1;
    const OF_PIXEL: i32 = 3;
    let side = 32;
    let shown = reflections(side, side, ITERATIONS);
    let (mut tiles, mut furthest) = (0, 0);
    let mut reflected = vec![0; (side * side) as usize];
    for shown in &shown {
        for corner in (0..side).step_by(8).flat_map(|y| (0..side).step_by(8).map(move |x| y * side + x)) {
            let pixels = (0..8).flat_map(|y| (0..8).map(move |x| (corner + y * side + x) as usize));
            let count = pixels.filter(|pixel| shown[*pixel] > 1).count() as i32;
            assert!((count - 32).abs() <= OF_TILE, "{count} of the 64 pixels of a tile are reflected");
            tiles += 1;
        }
        for (reflected, shown) in reflected.iter_mut().zip(shown) {
            *reflected += i32::from(*shown > 1);
        }
    }
    for count in reflected {
        furthest = furthest.max((count - ITERATIONS as i32 / 2).abs());
    }
    assert!(furthest <= OF_PIXEL, "a pixel is reflected {furthest} times too often or too seldom");
    tell("physics", tiles + (side * side) as usize, "counts of reflections");
}

/// Behind two balls that bend nothing, glass that reflects most of what meets it: whether a path comes through to the lamp is by
/// numbers that are the pixel's own, as the stratified ones are used up by then.
fn behind_glass() -> Scene {
    [(2.0, 1.0), (5.0, 1.0), (8.0, 8.0)].into_iter().fold(
        empty_scene(pinhole(Vec3::ZERO, Vec3::X, 0.1)).lamp(Vec3::X * 20.0, 5.0, BLACK, Rgb::ONE),
        |scene, (x, index)| scene.ball(Vec3::X * x, 1.0, glass(1.0, index)),
    )
}

/// Whatever the shape of an image, no two of its pixels see the same through glass all the time, by one ray or by further ones.
#[test]
fn no_two_pixels_of_wide_and_high_images_draw_the_same_numbers() {
    const ITERATIONS: u32 = 128;
    let scene = behind_glass();
    for (width, height) in [(13, 5), (5, 13), (9, 9)] {
        let settings = |glint_samples| Settings { glint_samples, ..settings(width, height, 1, 40, 0.1) };
        let (one, two) = (settings(1), settings(2));
        let engines: [(&str, Box<dyn Engine>); 4] = [
            ("photon mapping", Box::new(Sppm::new(&scene, &one))),
            ("path tracing", Box::new(PathTracer::new(&scene, &one))),
            ("photon mapping by two rays", Box::new(Sppm::new(&scene, &two))),
            ("path tracing by two rays", Box::new(PathTracer::new(&scene, &two))),
        ];
        for (name, mut engine) in engines {
            // The sum of what was seen rises in each iteration or not.
            let mut seen = vec![Vec::new(); (width * height) as usize];
            let mut sums = vec![0.0_f32; seen.len()];
            for iteration in 1..=ITERATIONS {
                engine.iterate();
                for (k, (seen, before)) in (0..).zip(seen.iter_mut().zip(&mut sums)) {
                    let sum = engine.probe(k % width, k / width).radiance.x * iteration as f32;
                    // Light that has come through twice is a hundred times what sums are rounded by.
                    seen.push(sum - *before > 1e-3);
                    *before = sum;
                }
            }
            let share = seen.iter().flatten().filter(|is_seen| **is_seen).count() as f64
                / f64::from(ITERATIONS * width * height);
            assert!((0.05..0.95).contains(&share), "{name}: {share}");
            for (k, one) in seen.iter().enumerate() {
                let same = seen[..k].iter().position(|other| other == one);
                assert_eq!(same, None, "{name}, {width} x {height}: pixel {k} is as another");
            }
        }
    }
}

//! First radii by pilots: what the pilots are, and that radii belong to the places of the image that ask for them.

use crate::cases::tell;
use crate::harness::settings;
use scene::{Film, Filter, FirstRadii, Rgb, Settings, Stop};

/// Pilots render what the render will, but smaller, with all pixels at a radius that is compared, and for seeds of their own. What
/// else is asked for is asked of them too.
#[test]
fn pilots_differ_from_the_render_in_size_radius_and_seed_alone() {
    let asked = Settings {
        radius_pilots: 5,
        radius_clearance: 0.7,
        filter: Filter::Mitchell,
        light_samples: 3,
        seed: 77,
        iterations: 900,
        ..settings(512, 384, 12_345, 9, 4.0)
    };
    let mut found = Vec::new();
    let radii = FirstRadii::choose(&asked, &Stop::new(), |pilot, _| {
        found.push(*pilot);
        Some(Film::from_fn(pilot.width, pilot.height, |_, _| Rgb::ONE))
    });
    let seeds: Vec<u64> = found.iter().map(|pilot| pilot.seed).collect();
    assert!(seeds[0] != seeds[4] && !seeds.contains(&asked.seed), "{seeds:?}");
    for (k, pilot) in found.iter().enumerate() {
        let expected = Settings {
            width: 256,
            height: 192,
            iterations: 5,
            radius_pilots: 0,
            radius_clearance: 0.0,
            initial_radius: [0.5, 1.0, 2.0, 4.0][k % 4],
            seed: seeds[k / 4 * 4],
            ..asked
        };
        assert_eq!(*pilot, expected, "pilot {k}");
    }
    assert_eq!(found.len(), 8);
    // Where nothing differs, the widest radius is as good as others.
    let radii = radii.unwrap();
    assert!([(0, 0), (511, 383)].iter().all(|&place| radii.at(place, (512, 384)) == 4.0));
}

/// A place in the image, from 0 to 1 along both axes.
type Place = (f64, f64);

/// The first radii of an image of `size` whose light is bent as `bias` says, with noise of photons in discs.
fn radii(size: (u32, u32), bias: impl Fn(Place) -> f64) -> FirstRadii {
    let asked = Settings { radius_pilots: 1, ..settings(size.0, size.1, 1000, 5, 1.0) };
    let chosen = FirstRadii::choose(&asked, &Stop::new(), |pilot, _| {
        let share = f64::from(pilot.initial_radius);
        let place = |i: u32, of: u32| (f64::from(i) + 0.5) / f64::from(of);
        let pixel = |x, y| {
            let place = (place(x, pilot.width), place(y, pilot.height));
            // The same at places that mirror each other or are transposed.
            let [a, b] = [place.0, place.1].map(|x| ((x - 0.5).abs() * 1e6).round() as u64);
            let mixed = (pilot.seed ^ (a * b + 31 * (a + b))).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let noise = 0.1 * ((mixed >> 40) as f64 / f64::from(1 << 24) - 0.5) / share;
            Rgb::splat((1.0 + bias(place) * share * share + noise) as f32)
        };
        Some(Film::from_fn(pilot.width, pilot.height, pixel))
    });
    chosen.unwrap()
}

/// The image is larger than the pilots, so radii are interpolated between their pixels: from the nearest ones, at the places
/// that pixels have. A mirrored image has mirrored radii, and a transposed one transposed radii.
#[test]
fn radii_of_mirrored_and_transposed_images_are_mirrored_and_transposed() {
    /// Rounding of means, which are summed in another order.
    const ROUNDING: f32 = 1e-4;
    let size = (380, 380);
    let bias = |(x, y): Place| 0.06 * x * x * (1.2 - y) + if x + 0.7 * y > 1.1 { 0.1 } else { 0.0 };
    let given = radii(size, bias);
    let across = radii(size, |(x, y)| bias((1.0 - x, y)));
    let down = radii(size, |(x, y)| bias((x, 1.0 - y)));
    let transposed = radii(size, |(x, y)| bias((y, x)));
    let (mut cases, mut uneven) = (0, 0);
    for (x, y) in (0..size.1).step_by(3).flat_map(|y| (0..size.0).step_by(3).map(move |x| (x, y))) {
        let expected = given.at((x, y), size);
        let others = [
            ("across", across.at((size.0 - 1 - x, y), size)),
            ("down", down.at((x, size.1 - 1 - y), size)),
            ("transposed", transposed.at((y, x), size)),
        ];
        for (what, found) in others {
            assert!((found / expected - 1.0).abs() < ROUNDING, "{what} at {x}, {y}: {found}, not {expected}");
            cases += 1;
        }
        let next = given.at(((x + 1).min(size.0 - 1), y), size);
        uneven += u32::from((next / expected - 1.0).abs() > 10.0 * ROUNDING);
    }
    assert!(uneven > 3000, "radii differ at {uneven} places");
    tell("physics", cases, "first radii of mirrored and transposed images");
}

/// The best radius, as a share of the largest, by the formulas at the top of `scene::first_radii`: for what radiance differs by
/// from one radius to the next, and the variance of photons in a disc of radius 1. Where pilots are long, no bias is doubted.
fn best(differences: [f64; 3], variance: f64) -> f64 {
    let mut biases = [0.0_f64; 4];
    for level in 1..4 {
        biases[level] = biases[level - 1].max(4.0 / 3.0 * differences[level - 1].abs());
    }
    biases[0] = biases[1] / 4.0;
    least_error(&biases, 30.0, variance)
}

/// Many iterations of pilots, so that little is doubted.
const PILOTS: u32 = 1 << 14;

/// The radius that is chosen for an image that is everywhere alike, and as much brighter at each radius as `levels` say. Noise is
/// along rows for the first seed and along columns for the other, so that it cancels in a window but for its squares.
fn radius_where(levels: [f64; 4], noise: f64) -> f64 {
    const PATTERN: [f64; 7] = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0];
    let asked = Settings { radius_pilots: PILOTS, ..settings(64, 48, 1000, 5, 1.0) };
    let mut first = None;
    let chosen = FirstRadii::choose(&asked, &Stop::new(), |pilot, _| {
        let is_first = *first.get_or_insert(pilot.seed) == pilot.seed;
        let level = levels[(8.0 * pilot.initial_radius).log2() as usize];
        let noise = noise / f64::from(pilot.initial_radius);
        let pixel = |x: u32, y: u32| {
            let place = if is_first { x } else { y } as usize % PATTERN.len();
            Rgb::splat((1.0 + level + noise * PATTERN[place]) as f32)
        };
        Some(Film::from_fn(pilot.width, pilot.height, pixel))
    });
    chosen.unwrap().at((32, 24), (64, 48)).into()
}

/// Radii are those of the least error: where light bends by the square of the radius, where narrow discs lose it, and where
/// wide ones do.
#[test]
fn first_radii_are_those_of_the_least_error() {
    /// Radii to choose from are a fourth root of two apart; films are of `f32`.
    const NEAR: f64 = 1e-3;
    /// By so much the variance may be off, for doubt of biases and windows that do not cancel.
    const UNSURE: f64 = 0.01;
    let noise = 1e-3;
    // Of the difference of two radii the pattern has the height 4 - 2, and 6/7 for its mean square.
    let variance = 4.0 / 3.0 * (6.0 / 7.0 * (2.0_f64 * noise).powi(2)) / 16.0 * f64::from(PILOTS);
    let (mut found_radii, mut cases) = (Vec::new(), 0);
    for step in 0..120 {
        let bend = (variance / 60.0).sqrt() * 2.0_f64.powf(f64::from(step) / 10.0);
        let even = [1.0, 4.0, 16.0, 64.0].map(|square| bend * square / 64.0);
        let early = [even[0], even[1], even[1] + 0.1 * bend, even[1] + 0.11 * bend];
        let late = [0.0, 0.0, 0.02 * bend, bend];
        for levels in [even, early, late] {
            let differences = [1, 2, 3].map(|level| levels[level] - levels[level - 1]);
            let expected = best(differences, variance);
            // Not where two radii are as good but for what is left.
            if [1.0 - UNSURE, 1.0 + UNSURE]
                .iter()
                .any(|factor| best(differences, variance * factor) != expected)
            {
                continue;
            }
            let found = radius_where(levels, noise);
            assert!((found / expected - 1.0).abs() < NEAR, "{found}, not {expected}, for {levels:?}");
            found_radii.push((expected * 1000.0) as u32);
            cases += 1;
        }
    }
    found_radii.sort_unstable();
    found_radii.dedup();
    assert!(cases > 250 && found_radii.len() >= 12, "{cases} cases with radii {found_radii:?}");
    tell("physics", cases, "first radii of least error");
}

/// The mean over a window that reaches so many pixels to each side, as far as the image does.
fn mean_around(size: (u32, u32), (x, y): (u32, u32), reach: u32, value: impl Fn(u32, u32) -> f64) -> f64 {
    let columns = x.saturating_sub(reach)..=(x + reach).min(size.0 - 1);
    let rows = y.saturating_sub(reach)..=(y + reach).min(size.1 - 1);
    let count = (columns.clone().count() * rows.clone().count()) as f64;
    rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| value(x, y)).sum::<f64>() / count
}

/// A number for each pixel, by what it is of its place.
fn each((width, height): (u32, u32), of: impl Fn(u32, u32) -> f64) -> Vec<f64> {
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| of(x, y)).collect()
}

/// The radii of the pilots' pixels by the formulas at the top of `scene::first_radii`, as shares of the largest. Pilots are in the
/// order in which they are rendered, and had so many iterations.
fn shares_by_definition(films: &[Film], iterations: u32) -> Vec<f64> {
    /// Of windows, in pixels to each side: for each of so many rows one, but no fewer; and for brightness.
    const ROWS_FOR_ONE: u32 = 32;
    const LEAST: u32 = 3;
    const OF_BRIGHTNESS: u32 = 2;
    /// Dark parts count as a tenth of the mean, and biases as far as they are larger than half a deviation.
    const DARK: f64 = 0.1;
    const DOUBT: f64 = 0.5;
    const WEIGHT: f64 = 30.0;
    let size @ (width, height) = (films[0].width, films[0].height);
    let reach = (height / ROWS_FOR_ONE).max(LEAST);
    let value =
        |film: usize, x: u32, y: u32, c: usize| f64::from(films[film].pixels[(y * width + x) as usize][c]);
    let bright = [0, 1, 2].map(|c| {
        let mean = |x, y| (0..8).map(|film| value(film, x, y, c)).sum::<f64>() / 8.0;
        each(size, |x, y| mean_around(size, (x, y), OF_BRIGHTNESS, mean))
    });
    let all = bright.iter().flatten().sum::<f64>() / f64::from(3 * width * height);
    let weight = |x, y, c: usize| 1.0 / (bright[c][(y * width + x) as usize].powi(2) + (DARK * all).powi(2));
    // What radiance differs by between a radius and the one before, for seed A or B.
    let step = |set: usize, level: usize, x, y, c| {
        value(4 * set + level, x, y, c) - value(4 * set + level - 1, x, y, c)
    };
    let mean = |level: usize, term: fn(f64, f64) -> f64| {
        let of_channel = |x, y, c| term(step(0, level, x, y, c), step(1, level, x, y, c)) * weight(x, y, c);
        let of = each(size, |x, y| (0..3).map(|c| of_channel(x, y, c)).sum::<f64>() / 3.0);
        each(size, |x, y| mean_around(size, (x, y), reach, |x, y| of[(y * width + x) as usize]))
    };
    let products = [1, 2, 3].map(|level| mean(level, |a, b| a * b));
    let variances = mean(2, |a, b| (a - b).powi(2) / 2.0);
    let best = |i: usize| {
        // Radii in units of the largest: those that are compared are 1/8, 1/4, 1/2 and 1. Noise falls as they grow.
        let variance_of = |level: i32| variances[i] * 4.0_f64.powi(2 - level);
        let noise = 4.0 / 3.0 * variances[i] / 16.0 * f64::from(iterations);
        let mut biases = [0.0_f64; 4];
        for level in 1..4 {
            let doubt = DOUBT * variance_of(level as i32) / f64::from(2 * reach + 1);
            let squared = 16.0 / 9.0 * (products[level - 1][i] - doubt);
            biases[level] = biases[level - 1].max(squared.max(0.0).sqrt());
        }
        biases[0] = biases[1] / 4.0;
        least_error(&biases, WEIGHT, noise)
    };
    let found: Vec<f64> = (0..products[0].len()).map(best).collect();
    each(size, |x, y| mean_around(size, (x, y), reach, |x, y| found[(y * width + x) as usize]))
}

/// The radius of the least error. Between radii that are compared the bias goes as the square of the radius.
fn least_error(biases: &[f64; 4], weight: f64, noise: f64) -> f64 {
    let bias = |radius: f64| {
        let level = [0.25, 0.5].into_iter().filter(|compared| radius >= *compared).count();
        let [low, high] = [level, level + 1].map(|level| 4.0_f64.powi(level as i32) / 64.0);
        biases[level] + (biases[level + 1] - biases[level]) * (radius * radius - low) / (high - low)
    };
    let error = |radius: f64| weight * bias(radius).powi(2) + noise / (radius * radius);
    let radii = (0..=12).map(|step| 2.0_f64.powf(-f64::from(step) / 4.0));
    radii.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap()
}

/// Whatever pilots look like, radii are those of the definition: in each channel other light, noise and bias, of images of any
/// shape, and of any number of iterations.
#[test]
fn first_radii_are_those_of_the_definition() {
    /// Roundings of `f32`.
    const ROUNDING: f64 = 1e-6;
    let mut cases = 0;
    for (size, pilots) in [((40, 30), 1), ((9, 60), 3), ((260, 200), 2), ((50, 5), 8)] {
        let asked = Settings { radius_pilots: pilots, ..settings(size.0, size.1, 1000, 5, 3.0) };
        let mut films: Vec<Film> = Vec::new();
        let radii = FirstRadii::choose(&asked, &Stop::new(), |pilot, _| {
            let share = f64::from(pilot.initial_radius / asked.initial_radius);
            let pixel = |x: u32, y: u32| {
                let (u, v) = (f64::from(x) / f64::from(pilot.width), f64::from(y) / f64::from(pilot.height));
                let channel = |c: u32| {
                    let mixed = (pilot.seed ^ u64::from(x * 131 + y * 57 + 7919 * c))
                        .wrapping_mul(0x9e37_79b9_7f4a_7c15);
                    let noise = (mixed >> 40) as f64 / f64::from(1 << 24) - 0.5;
                    let light = [1.0 + u, 0.3 + 2.0 * v, if u > 0.7 { 0.0 } else { 0.02 }][c as usize];
                    // Grows as the square of the radius here, and not so there.
                    let bent = [0.3 * u * share * share, 0.2 * v * share, -0.02 * share.powi(3)][c as usize];
                    (light + bent + 0.05 * light * noise / share) as f32
                };
                Rgb::new(channel(0), channel(1), channel(2))
            };
            films.push(Film::from_fn(pilot.width, pilot.height, pixel));
            films.last().cloned()
        });
        let (radii, shares) = (radii.unwrap(), shares_by_definition(&films, pilots));
        let of_pilot = (films[0].width, films[0].height);
        for (i, share) in shares.iter().enumerate() {
            let (x, y) = (i as u32 % of_pilot.0, i as u32 / of_pilot.0);
            // At the pilot's own size nothing lies between its pixels.
            let found = f64::from(radii.at((x, y), of_pilot));
            assert!(
                (found / (3.0 * share) - 1.0).abs() < ROUNDING,
                "{size:?} at {x}, {y}: {found}, not {}",
                3.0 * share
            );
            cases += 1;
        }
        let widths = || shares.iter().copied();
        let (least, most) = (widths().fold(1.0, f64::min), widths().fold(0.0, f64::max));
        assert!(most > 1.3 * least, "{size:?}: radii from {least} to {most}");
    }
    tell("physics", cases, "first radii by their definition");
}

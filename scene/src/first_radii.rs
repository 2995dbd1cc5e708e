//! First search radii, one for each pixel, chosen from small renders, the pilots: wide where light is even, narrow at the
//! rims of caustics, in corners and where balls touch the ground.
//!
//! With a radius `R`, the error of a pixel has two parts: the bias `b(R)`, as light is blurred over the disc, and the variance
//! `v / R^2`, as few photons land in it. While radii shrink, after `n` iterations (Knaus and Zwicker 2011, sections 4 and 5,
//! with alpha = 2/3) the squared bias is `9/4 b^2 n^(-2/3)` and the variance `3/4 v / R^2 n^(-2/3)`. So the radius that makes
//! the error least is the same for all `n`, the one for which `3 b(R)^2 + v / R^2` is least. That bias asks for a radius of
//! each place was put to use by Kaplanyan and Dachsbacher ("Adaptive progressive photon mapping", 2013), who estimate second
//! derivatives; here, two radii are compared.
//!
//! ```text
//! for two seeds A and B, and for radii R_0 = R/8, R_1 = R/4, R_2 = R/2, R_3 = R, R the initial radius:
//!     render the pilot: the same scene, fewer pixels
//! d_i  = I(R_i) - I(R_(i-1)), for A and for B: of the same photons and paths, so noise of the camera cancels
//! V     = mean((d_2^A - d_2^B)^2) / 2     variance of d_2; that of d_i is V R_1^2 / R_(i-1)^2
//! v     = 4/3 V R_1^2, times the iterations of a pilot
//! b_i^2 = (4/3)^2 (mean(d_i^A d_i^B) - doubt)     noise of A and B is independent; bias grows as the square of the radius
//! radius = the one of R, R/2^(1/4), ..., R/8 for which WEIGHT b^2 + v / radius^2 is least
//! ```
//!
//! Means are over a window around the pixel, relative to the brightness there. A wider disc has no less bias than a narrower
//! one, so `b_i` is at least `b_(i-1)`.
//!
//! The seeds of the pilots are not that of the render, so its photons do not depend on its radii, and nothing is biased by
//! the choice. All operations are exactly rounded, so every engine chooses the same radii.

use crate::color::Rgb;
use crate::film::Film;
use crate::settings::{RADIUS_RATIO, Settings};
use crate::stop::Stop;

/// Pixels of a pilot, at most.
const PILOT_PIXELS: u64 = 256 * 192;
/// Radii that are compared, each half of the next.
const LEVELS: usize = 4;
const _: () = assert!(RADIUS_RATIO == (1 << (LEVELS - 1)) as f32);
/// What the seeds of the pilots differ by from that of the render.
const SEEDS: [u64; 2] = [0x5851_f42d_4c95_7f2d, 0x1405_7b7e_f767_814f];
/// Radii to choose from between one that is compared and the next.
const STEPS: u32 = 4;
/// The weight of the squared bias against the variance: 3, as both fall; and ten times as much, as neighbours share their
/// bias but not their noise, and see docs/quality.md.
const WEIGHT: f64 = 30.0;
/// A bias counts as far as its square is larger than this many standard deviations of its estimate. Without, noise of narrow
/// radii would be taken for bias wherever light is even.
const DOUBT: f64 = 0.5;
/// Rows of the pilot for each pixel that the window of means reaches to each side.
const ROWS_PER_REACH: u32 = 32;
/// And the least, as means over fewer pixels are too noisy to tell a bias.
const LEAST_REACH: u32 = 3;
/// Pixels that the window of the brightness reaches to each side.
const BRIGHTNESS_REACH: usize = 2;
/// Added to the squared brightness, in squared means over the image: dark parts count as if they were a tenth as bright.
const FLOOR: f64 = 0.01;

/// The search radii with which the pixels of an image begin, in scene units.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstRadii {
    width: u32,
    height: u32,
    /// Of the pilot's pixels, row by row.
    radii: Vec<f32>,
}

impl FirstRadii {
    /// The same radius for all pixels.
    pub fn even(radius: f32) -> Self {
        Self { width: 1, height: 1, radii: vec![radius] }
    }

    /// The radii for a render with `settings`, whose `initial_radius` is the largest of them. `render` runs a pilot with the
    /// settings that it is given, and gives its image, or `None` if stopped by what it is given, a child of `stop`. Pilots
    /// count as preparation on the meter of `stop`.
    ///
    /// # Panics
    /// If an image has not the size that the settings ask for.
    pub fn choose(
        settings: &Settings,
        stop: &Stop,
        mut render: impl FnMut(&Settings, &Stop) -> Option<Film>,
    ) -> Option<Self> {
        stop.meter().prepare((SEEDS.len() * LEVELS) as u64);
        let aside = stop.child_aside();
        let pilot = pilot_settings(settings);
        let mut films = Vec::with_capacity(SEEDS.len() * LEVELS);
        for seed in SEEDS {
            for level in 0..LEVELS {
                let initial_radius = settings.initial_radius * level_radius(level) as f32;
                let film = render(&Settings { seed: settings.seed ^ seed, initial_radius, ..pilot }, &aside)?;
                stop.meter().advance(1);
                assert_eq!((film.width, film.height), (pilot.width, pilot.height), "another size");
                films.push(film.pixels);
            }
        }
        let plane = Plane { width: pilot.width as usize, height: pilot.height as usize };
        let shares = plane.shares(&films, pilot.iterations);
        let largest = settings.initial_radius;
        let radii = shares.iter().map(|share| (f64::from(largest) * share) as f32).map(|r| r.min(largest));
        Some(Self { width: pilot.width, height: pilot.height, radii: radii.collect() })
    }

    /// The radius of the pixel in column `x` and row `y` of an image of `width` x `height`: interpolated between those of the
    /// nearest four pixels of the pilot.
    pub fn at(&self, (x, y): (u32, u32), (width, height): (u32, u32)) -> f32 {
        let (left, right, u) = neighbours(x, width, self.width);
        let (top, bottom, v) = neighbours(y, height, self.height);
        let row = |y: u32| {
            let of = |x: u32| f64::from(self.radii[y as usize * self.width as usize + x as usize]);
            of(left) + (of(right) - of(left)) * u
        };
        let (above, below) = (row(top), row(bottom));
        (above + (below - above) * v) as f32
    }

    /// The same radii times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f32) -> Self {
        Self { radii: self.radii.iter().map(|radius| radius * factor).collect(), ..*self }
    }
}

/// The settings of the pilots, but for seed and radius.
pub fn pilot_settings(settings: &Settings) -> Settings {
    let (width, height) = settings.size_within(PILOT_PIXELS);
    let iterations = settings.radius_pilots;
    // Their radii are those that are compared, in all pixels.
    Settings { width, height, iterations, radius_pilots: 0, radius_clearance: 0.0, ..*settings }
}

/// The most bytes that [`FirstRadii::choose`] takes, besides those of a render with [`pilot_settings`].
pub fn bytes_at_most(settings: &Settings) -> u64 {
    if settings.radius_pilots == 0 {
        return 0;
    }
    let planes = 2 * LEVELS + 4;
    let bytes = SEEDS.len() * LEVELS * size_of::<Rgb>() + planes * size_of::<f64>();
    (pilot_settings(settings).pixels() * bytes) as u64
}

/// The radius of a level, where the largest is 1.
fn level_radius(level: usize) -> f64 {
    1.0 / f64::from(1_u32 << (LEVELS - 1 - level))
}

/// The pixels of a row or column of `to` on both sides of the centre of pixel `i` of `from`, and how far it is from the first
/// to the second.
fn neighbours(i: u32, from: u32, to: u32) -> (u32, u32, f64) {
    let place = (f64::from(i) + 0.5) * f64::from(to) / f64::from(from) - 0.5;
    let last = to - 1;
    let place = place.clamp(0.0, f64::from(last));
    let first = place as u32;
    (first, (first + 1).min(last), place - f64::from(first))
}

/// The size of images whose pixels are in a row.
#[derive(Clone, Copy)]
struct Plane {
    width: usize,
    height: usize,
}

impl Plane {
    /// The radius of every pixel as a share of the largest, from the images of [`FirstRadii::choose`] in their order.
    fn shares(self, films: &[Vec<Rgb>], iterations: u32) -> Vec<f64> {
        let reach = (self.height as u32 / ROWS_PER_REACH).max(LEAST_REACH) as usize;
        let weights = self.weights(films);
        let (a, b) = films.split_at(LEVELS);
        let difference = |set: &[Vec<Rgb>], level: usize, i: usize, channel: usize| {
            f64::from(set[level][i][channel]) - f64::from(set[level - 1][i][channel])
        };
        // The mean over channels of what `term` makes of the differences of both sets.
        let mean = |level: usize, term: fn(f64, f64) -> f64| {
            let of = |i: usize| -> f64 {
                let channel =
                    |c| term(difference(a, level, i, c), difference(b, level, i, c)) * weights[i][c];
                (channel(0) + channel(1) + channel(2)) / 3.0
            };
            self.windowed(&(0..self.width * self.height).map(of).collect::<Vec<_>>(), reach)
        };
        let products: Vec<Vec<f64>> = (1..LEVELS).map(|level| mean(level, |a, b| a * b)).collect();
        // In squares of level 0.
        let variance = mean(2, |a, b| (a - b) * (a - b) / 2.0);
        let scale = noise_scale(iterations);
        let side = (2 * reach + 1) as f64;
        let shares = (0..variance.len()).map(|i| {
            // The deviation of a mean over a window, at level 1; those of the others fall as the variance.
            let doubt = DOUBT * 4.0 * variance[i] / side;
            let squared = |level: usize| 16.0 / 9.0 * (products[level][i] - doubt * level_doubt(level));
            share([0, 1, 2].map(squared), variance[i] * scale)
        });
        self.windowed(&shares.collect::<Vec<_>>(), reach)
    }

    /// One over the square of the brightness around each pixel, for each channel.
    fn weights(self, films: &[Vec<Rgb>]) -> Vec<[f64; 3]> {
        let count = films.len() as f64;
        let channel = |c: usize| {
            let of = |i: usize| films.iter().map(|film| f64::from(film[i][c])).sum::<f64>() / count;
            self.windowed(&(0..self.width * self.height).map(of).collect::<Vec<_>>(), BRIGHTNESS_REACH)
        };
        let means = [0, 1, 2].map(channel);
        let sum: f64 = means.iter().map(|channel| channel.iter().sum::<f64>()).sum();
        let mean = sum / (3 * self.width * self.height) as f64;
        // So that nothing is divided by zero where all is black.
        let floor = (FLOOR * mean * mean).max(f64::MIN_POSITIVE);
        let of = |i: usize| [0, 1, 2].map(|c: usize| 1.0 / (means[c][i] * means[c][i] + floor));
        (0..self.width * self.height).map(of).collect()
    }

    /// The means of `values` over windows that reach so many pixels to each side, and end at the border.
    fn windowed(self, values: &[f64], reach: usize) -> Vec<f64> {
        let Self { width, height } = self;
        let along = |values: &[f64], x: usize, y: usize| {
            let (first, last) = (x.saturating_sub(reach), (x + reach).min(width - 1));
            values[y * width + first..=y * width + last].iter().sum::<f64>() / (last - first + 1) as f64
        };
        let rows: Vec<f64> = (0..width * height).map(|i| along(values, i % width, i / width)).collect();
        let across = |x: usize, y: usize| {
            let (first, last) = (y.saturating_sub(reach), (y + reach).min(height - 1));
            (first..=last).map(|y| rows[y * width + x]).sum::<f64>() / (last - first + 1) as f64
        };
        (0..width * height).map(|i| across(i % width, i / width)).collect()
    }
}

/// How many times `V` is `v`, in squares of the radius of level 0, for pilots of so many iterations: the squared radius of
/// level 1 is 4.
fn noise_scale(iterations: u32) -> f64 {
    16.0 / 3.0 * f64::from(iterations)
}

/// The variance of the difference of a level from the one before, where that of level 1 from level 0 is 1 and `level` counts
/// from there.
fn level_doubt(level: usize) -> f64 {
    1.0 / f64::from(1_u32 << (2 * level))
}

/// The best radius as a share of the largest, from the squared biases at levels 1 to 3, of which some may be less than
/// nothing, and the variance of an iteration times the squared radius, in squares of the radius of level 0.
fn share(squared_biases: [f64; LEVELS - 1], variance: f64) -> f64 {
    let mut biases = [0.0; LEVELS];
    for (level, squared) in squared_biases.into_iter().enumerate() {
        biases[level + 1] = squared.max(0.0).sqrt().max(biases[level]);
    }
    biases[0] = biases[1] / 4.0;
    let quarter_root = 2.0_f64.sqrt().sqrt();
    let (mut radius, mut best) = (f64::from(1_u32 << (LEVELS - 1)), (f64::INFINITY, 0.0));
    for step in (0..=(LEVELS as u32 - 1) * STEPS).rev() {
        let squared = radius * radius;
        let level = ((step / STEPS) as usize).min(LEVELS - 2);
        let [low, high] = [level, level + 1].map(|level| f64::from(1_u32 << (2 * level)));
        let bias = biases[level] + (biases[level + 1] - biases[level]) * ((squared - low) / (high - low));
        let error = WEIGHT * bias * bias + variance / squared;
        // What is not a number, of an image that overflows, is no better than anything.
        if error < best.0 {
            best = (error, radius);
        }
        radius /= quarter_root;
    }
    let largest = f64::from(1_u32 << (LEVELS - 1));
    if best.1 > 0.0 { best.1 / largest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Family, StreamKey};

    const SIZE: (u32, u32) = (64, 48);

    fn settings() -> Settings {
        let (width, height) = SIZE;
        Settings { width, height, initial_radius: 2.0, radius_pilots: 3, ..Settings::default() }
    }

    /// Radii for images whose bias is `bias(x, y)` at the largest radius and grows as its square, and whose noise is that of
    /// photons in a disc: `noise` is the standard deviation at the largest radius.
    fn chosen(bias: impl Fn(u32, u32) -> f32, noise: f32) -> FirstRadii {
        let settings = settings();
        let choose = |pilot: &Settings, _: &Stop| {
            let share = pilot.initial_radius / settings.initial_radius;
            // Rings of photons, from the inside out: a wider disc has those of the narrower ones and more.
            let noise_of = |index: u32| {
                let mut stream = StreamKey::new(pilot.seed, Family::Camera, 0).stream(index);
                let (mut sum, mut area) = (0.0, 0.0);
                for ring in [1.0 / 64.0, 3.0 / 64.0, 12.0 / 64.0, 48.0 / 64.0_f32] {
                    if area < share * share * 0.999 {
                        let uniform = (0..12).map(|_| stream.next_f32()).sum::<f32>() - 6.0;
                        sum += uniform * ring.sqrt();
                        area += ring;
                    }
                }
                noise * sum / area
            };
            let pixel = |x, y| Rgb::splat(1.0 + bias(x, y) * share * share + noise_of(y * SIZE.0 + x));
            Some(Film::from_fn(pilot.width, pilot.height, pixel))
        };
        FirstRadii::choose(&settings, &Stop::new(), choose).unwrap()
    }

    /// Of a bias that grows as the square of the radius, the least of `WEIGHT b^2 r^4 + v / r^2` is where
    /// `r^6 = v / (2 WEIGHT b^2)`, in units of the radius of level 0. A step is a quarter of an octave.
    #[test]
    fn radii_are_those_of_the_least_error() {
        const STEP: f64 = 1.1;
        for (bias, variance) in [(0.01_f64, 1.0), (0.001, 0.1), (0.3, 1.0), (1e-4, 1.0), (2.0, 0.1)] {
            let squared = [4.0, 16.0, 64.0].map(|area| (bias * area) * (bias * area));
            let expected = (variance / (2.0 * WEIGHT * bias * bias)).powf(1.0 / 6.0).clamp(1.0, 8.0) / 8.0;
            let found = share(squared, variance);
            assert!(
                found / expected < STEP && expected / found < STEP,
                "{found}, not {expected}, for {bias}"
            );
        }
        assert_eq!(share([-1.0, -0.5, -0.1], 1.0), 1.0);
    }

    /// Where nothing is blurred radii are wide, though not the widest, as some noise is taken for bias; none is larger or
    /// smaller than allowed.
    #[test]
    fn places_have_radii_of_their_own() {
        let radii = chosen(|x, _| if x < 32 { 2.0 } else { 0.0 }, 0.01);
        let (left, right) = (radii.at((8, 24), SIZE), radii.at((56, 24), SIZE));
        assert!(left < 0.4 && right > 0.8, "{left} where light is blurred, {right} where it is not");
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let radius = radii.at((x, y), SIZE);
                assert!((2.0 / RADIUS_RATIO..=2.0).contains(&radius), "{radius} at {x}, {y}");
            }
        }
    }

    /// In the middle of four pixels of the pilot, and where an image ends.
    #[test]
    fn between_pixels_of_the_pilot_radii_are_interpolated() {
        let radii = FirstRadii { width: 2, height: 2, radii: vec![1.0, 2.0, 5.0, 8.0] };
        let size = (6, 6);
        // Six pixels lie at -1/3, 0, 1/3, 2/3, 1, 4/3 of the way from one to the next; at most as far as that.
        for (place, radius) in [
            ((0, 0), 1.0),
            ((1, 1), 1.0),
            ((2, 1), 1.0 + 1.0 / 3.0),
            ((3, 5), 5.0 + 2.0),
            ((1, 2), 1.0 + 4.0 / 3.0),
            ((4, 3), 2.0 + 4.0),
            ((5, 5), 8.0),
        ] {
            approx::assert_relative_eq!(radii.at(place, size), radius, max_relative = 1e-6);
        }
    }

    #[test]
    fn means_are_those_of_the_part_of_the_window_that_is_in_the_image() {
        let plane = Plane { width: 5, height: 4 };
        let value = |x: usize, y: usize| f64::from(1 << x) + 100.0 * (y * y) as f64;
        let values: Vec<f64> = (0..20).map(|i| value(i % 5, i / 5)).collect();
        for reach in [0, 1, 2, 9] {
            let means = plane.windowed(&values, reach);
            for (i, mean) in means.into_iter().enumerate() {
                let (x, y) = (i % 5, i / 5);
                let is_in = |j: &usize| x.abs_diff(j % 5) <= reach && y.abs_diff(j / 5) <= reach;
                let within: Vec<f64> = (0..20).filter(is_in).map(|j| values[j]).collect();
                let expected = within.iter().sum::<f64>() / within.len() as f64;
                approx::assert_relative_eq!(mean, expected, max_relative = 1e-12);
            }
        }
    }

    /// Errors count relative to the brightness there, and in the dark to a tenth of the mean brightness of all.
    #[test]
    fn weights_are_those_of_the_brightness_there_and_at_least_a_tenth_of_the_mean() {
        let plane = Plane { width: 40, height: 3 };
        // Two films whose mean is 8 in the left half and 0 in the right one.
        let half =
            |bright: f32| (0..120).map(|i| Rgb::splat(if i % 40 < 20 { bright } else { 0.0 })).collect();
        let weights = plane.weights(&[half(6.0), half(10.0)]);
        let floor = FLOOR * 16.0;
        for (place, squared) in [(0, 64.0), (39, 0.0)] {
            for weight in weights[place] {
                approx::assert_relative_eq!(weight, 1.0 / (squared + floor), max_relative = 1e-12);
            }
        }
    }

    /// Of images without light, or with too much of it, nothing follows.
    #[test]
    fn images_that_tell_nothing_leave_the_largest_radius() {
        for value in [0.0, f32::INFINITY, f32::NAN] {
            let radii = FirstRadii::choose(&settings(), &Stop::new(), |pilot, _| {
                Some(Film::from_fn(pilot.width, pilot.height, |_, _| Rgb::splat(value)))
            });
            assert_eq!(radii.unwrap().at((5, 7), SIZE), 2.0, "{value}");
        }
    }

    #[test]
    fn pilots_are_small_and_differ_in_seed_and_radius() {
        let settings = Settings { width: 1920, height: 1080, radius_pilots: 5, ..Settings::default() };
        let (mut seen, stop) = (Vec::new(), Stop::new());
        FirstRadii::choose(&settings, &stop, |pilot, aside| {
            // What a pilot counts is no progress of the render.
            aside.meter().begin(1);
            aside.meter().advance(1);
            assert_eq!(
                (stop.meter().preparation(), stop.meter().share()),
                (Some(seen.len() as f64 / 8.0), 0.0)
            );
            pilot.validate().unwrap();
            assert!(pilot.pixels() as u64 <= PILOT_PIXELS && pilot.width > pilot.height);
            assert_eq!((pilot.iterations, pilot.radius_pilots), (5, 0));
            assert_ne!(pilot.seed, settings.seed);
            seen.push((pilot.seed, pilot.initial_radius));
            Some(Film::new(pilot.width, pilot.height))
        });
        assert_eq!(seen.len(), 8);
        assert!((0..8).all(|i| !seen[..i].contains(&seen[i])), "{seen:?}");
        assert_eq!(seen.iter().map(|(_, radius)| *radius).fold(0.0, f32::max), settings.initial_radius);
        assert!(FirstRadii::choose(&settings, &stop, |_, _| None).is_none());
    }

    #[test]
    fn noise_counts_with_the_iterations_that_it_is_of() {
        let of = [1, 3, 4].map(noise_scale);
        assert_eq!(of, [16.0 / 3.0, 16.0, 64.0 / 3.0]);
    }

    /// Of two renders no pilot has the seed of another.
    #[test]
    fn seeds_of_pilots_are_those_of_their_render_alone() {
        let seeds = |seed: u64| {
            let mut seen = Vec::new();
            FirstRadii::choose(&Settings { seed, ..settings() }, &Stop::new(), |pilot, _| {
                seen.push(pilot.seed);
                Some(Film::new(pilot.width, pilot.height))
            });
            seen.dedup();
            seen
        };
        let mut all: Vec<u64> = [0, 1, 2, u64::MAX].into_iter().flat_map(seeds).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 8);
    }

    /// Eight images are held until the radii are chosen, and beside them planes of the numbers that are made of them.
    #[test]
    fn bytes_are_those_of_all_images_and_planes() {
        for (width, height) in [(64, 48), (1920, 1080)] {
            let settings = Settings { width, height, radius_pilots: 3, ..Settings::default() };
            let pilot = pilot_settings(&settings);
            let images = 8 * size_of::<[f32; 3]>();
            let planes = 12 * size_of::<f64>();
            assert_eq!(bytes_at_most(&settings), (pilot.pixels() * (images + planes)) as u64);
            assert_eq!(bytes_at_most(&Settings { radius_pilots: 0, ..settings }), 0);
        }
    }

    /// Between the centres of the pilot's pixels, radii are on straight lines; beyond the outermost, they stay.
    #[test]
    fn radii_are_interpolated() {
        let radii = FirstRadii { width: 2, height: 1, radii: vec![1.0, 3.0] };
        let row: Vec<f32> = (0..8).map(|x| radii.at((x, 0), (8, 1))).collect();
        assert_eq!(row, [1.0, 1.0, 1.25, 1.75, 2.25, 2.75, 3.0, 3.0]);
        assert_eq!(FirstRadii::even(0.7).at((3, 2), (9, 9)), 0.7);
        assert_eq!(radii.scaled(0.5).at((0, 0), (8, 1)), 0.5);
    }

    /// With windows of the least width, and with such as reach a 32nd of the rows.
    #[test]
    fn radii_follow_from_the_formulas() {
        check_formulas((24, 100), 3);
        check_formulas((32, 192), 6);
    }

    /// The radii as the formulas at the top of this file state them, of images of noise, without any of the code above.
    fn check_formulas((width, height): (u32, u32), reach: usize) {
        let settings =
            Settings { width, height, initial_radius: 2.0, radius_pilots: 3, ..Settings::default() };
        let mut films: Vec<Film> = Vec::new();
        let radii = FirstRadii::choose(&settings, &Stop::new(), |pilot, _| {
            let mut stream = StreamKey::new(pilot.seed, Family::Camera, films.len() as u32).stream(0);
            let share = pilot.initial_radius / 2.0;
            let pixels = (0..width * height).map(|i| {
                let edge = if i % width < 8 { 0.5 * share * share } else { 0.0 };
                let noise = 0.02 + 0.2 * (i / width) as f32 / height as f32;
                Rgb::from_array(std::array::from_fn(|c| {
                    0.3 + 0.2 * c as f32 + edge + noise * (stream.next_f32() - 0.5) / share
                }))
            });
            films.push(Film { width, height, pixels: pixels.collect() });
            films.last().cloned()
        });
        let radii = radii.unwrap();
        let (w, h) = (width as usize, height as usize);
        let value =
            |seed: usize, level: usize, i: usize, c: usize| f64::from(films[4 * seed + level].pixels[i][c]);
        let window = |values: &dyn Fn(usize) -> f64, i: usize, reach: usize| {
            let within = |j: &usize| (i % w).abs_diff(j % w) <= reach && (i / w).abs_diff(j / w) <= reach;
            let all: Vec<f64> = (0..w * h).filter(within).map(values).collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        let planes = |of: &dyn Fn(usize) -> f64, reach: usize| {
            (0..w * h).map(|i| window(of, i, reach)).collect::<Vec<f64>>()
        };
        let mean = |i: usize, c: usize| (0..8).map(|k| value(k / 4, k % 4, i, c)).sum::<f64>() / 8.0;
        let brightness = [0, 1, 2].map(|c| planes(&|i| mean(i, c), 2));
        let all = brightness.iter().flatten().sum::<f64>() / (3 * w * h) as f64;
        let difference = |seed: usize, level: usize, i: usize, c: usize| {
            value(seed, level, i, c) - value(seed, level - 1, i, c)
        };
        let relative = |level: usize, term: &dyn Fn(f64, f64) -> f64| {
            let of = |i: usize| {
                (0..3)
                    .map(|c| {
                        let weight = 1.0 / (brightness[c][i].powi(2) + 0.01 * all * all);
                        term(difference(0, level, i, c), difference(1, level, i, c)) * weight
                    })
                    .sum::<f64>()
                    / 3.0
            };
            planes(&of, reach)
        };
        let products: Vec<Vec<f64>> = (1..4).map(|level| relative(level, &|a, b| a * b)).collect();
        let variance = relative(2, &|a, b| (a - b) * (a - b) / 2.0);
        let best = |i: usize| {
            // Of d_1 it is four times that of d_2, and the deviation of the mean over a window of 7 x 7 a seventh.
            let side = (2 * reach + 1) as f64;
            let deviation = |level: i32| 4.0 * variance[i] / 4.0_f64.powi(level - 1) / side;
            let mut biases = vec![0.0];
            for level in 1..4 {
                let squared =
                    (4.0_f64 / 3.0).powi(2) * (products[level - 1][i] - 0.5 * deviation(level as i32));
                biases.push(squared.max(0.0).sqrt().max(biases[level - 1]));
            }
            biases[0] = biases[1] / 4.0;
            let noise = 4.0 / 3.0 * variance[i] * 4.0 * 3.0;
            let error = |radius: f64| {
                let level = (radius.log2().floor() as usize).min(2);
                let [low, high] = [level, level + 1].map(|level| 4.0_f64.powi(level as i32));
                let [near, far] = [biases[level], biases[level + 1]];
                let bias = near + (far - near) * (radius * radius - low) / (high - low);
                30.0 * bias * bias + noise / (radius * radius)
            };
            let radii = (0..=12).map(|step| 8.0 * 0.5_f64.powf(f64::from(step) / 4.0) * (1.0 + 1e-12));
            radii.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap() / 8.0
        };
        let shares: Vec<f64> = (0..w * h).map(best).collect();
        let expected = planes(&|i| shares[i], reach);
        let (mut narrow, mut wide) = (0, 0);
        for (i, expected) in expected.into_iter().enumerate() {
            let found = f64::from(radii.at((i as u32 % width, i as u32 / width), (width, height)));
            assert!((found / (2.0 * expected) - 1.0).abs() < 1e-5, "{found} of {} at {i}", 2.0 * expected);
            narrow += u32::from(expected < 0.4);
            wide += u32::from(expected > 0.8);
        }
        assert!(narrow > 50 && wide > 50, "{narrow} and {wide}");
    }
}

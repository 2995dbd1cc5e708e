//! A small render that tells how noisy the render will be, and how much work it takes.
//!
//! It is repeated with other seeds. The variance among the images, relative to their mean, is that of one iteration; and
//! from two numbers of photons follows which part of it is due to photons:
//!
//! ```text
//! V(L) = camera + photons / L
//! ```
//!
//! It is looked at by pixels, and by blocks, in which the noise of photons lasts, as neighbours share them.

use crate::names::MethodName;
use fast::{DEPOSITS_OF_PILOTS, LaneKind, Parameters, Parts, PathTracer, Sppm};
use scene::{Engine, Film, FirstRadii, Rgb, Scene, Settings, Stats, Stop};
use std::mem::take;

/// Images that are compared.
pub(super) const SEEDS: u64 = 4;
/// The share of the noisiest terms that is left out: sparks, of which a few images tell nothing.
const SPARKS: f64 = 0.005;
/// Dark parts count as if they were this much brighter, relative to the mean of the image.
const FLOOR: f64 = 0.1;

/// Images of one iteration that differ in their seeds, and the work that they took.
pub(super) struct Pilot {
    pub(super) films: Vec<Film>,
    /// Of all images together.
    pub(super) stats: Stats,
}

/// A variance per pixel and one per block of pixels, each relative to the square of the brightness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variance {
    pub(super) pixel: f64,
    pub(super) block: f64,
}

/// Renders `seeds` images of one iteration with these settings, and with other first radii if some are given; `None` if
/// stopped.
pub(super) fn run(
    (method, lanes): (MethodName, LaneKind),
    scene: &Scene,
    settings: &Settings,
    seeds: u64,
    first_radii: Option<&FirstRadii>,
    stop: &Stop,
) -> Option<Pilot> {
    let is_hybrid = method == MethodName::Hybrid;
    let (mut films, mut stats, mut parts) = (Vec::new(), Stats::default(), Parts::default());
    for seed in 0..seeds {
        let settings = Settings { seed: settings.seed.wrapping_add(seed), ..*settings };
        let engine = Sppm::with_parts(scene, &settings, lanes, &Parameters::default(), take(&mut parts));
        let mut engine = engine.deposits_at_once(DEPOSITS_OF_PILOTS);
        if let Some(radii) = first_radii {
            engine = engine.beginning_with(radii.clone());
        }
        if is_hybrid {
            let mut engine = fast::hybrid(PathTracer::with_lanes(scene, &settings, lanes), engine);
            if !engine.iterate_unless(stop) {
                return None;
            }
            films.push(engine.develop());
            // A path asks for light at most once for each of its segments.
            let shadow_rays = engine.stats().camera_segments;
            stats = sum(&stats, &Stats { shadow_rays, ..*engine.stats() });
        } else {
            if !engine.iterate_unless(stop) {
                return None;
            }
            films.push(engine.develop());
            stats = sum(&stats, engine.stats());
            parts = engine.into_parts();
        }
    }
    Some(Pilot { films, stats })
}

/// Renders `seeds` images by path tracing with these settings; `None` if stopped.
pub(super) fn run_paths(
    lanes: LaneKind,
    scene: &Scene,
    settings: &Settings,
    seeds: u64,
    stop: &Stop,
) -> Option<Pilot> {
    let (mut films, mut stats) = (Vec::new(), Stats::default());
    for seed in 0..seeds {
        let settings = Settings { seed: settings.seed.wrapping_add(seed), ..*settings };
        let mut engine = PathTracer::with_lanes(scene, &settings, lanes);
        if !(0..settings.iterations).all(|_| engine.iterate_unless(stop)) {
            return None;
        }
        films.push(engine.develop());
        stats = sum(&stats, engine.stats());
    }
    Some(Pilot { films, stats })
}

/// The counts of both. Times and bytes are left out: nothing may depend on them.
fn sum(a: &Stats, b: &Stats) -> Stats {
    Stats {
        camera_segments: a.camera_segments + b.camera_segments,
        shadow_rays: a.shadow_rays + b.shadow_rays,
        photons: a.photons + b.photons,
        photon_segments: a.photon_segments + b.photon_segments,
        deposits: a.deposits + b.deposits,
        contributions: a.contributions + b.contributions,
        ..Stats::default()
    }
}

impl Pilot {
    /// The relative variance of one iteration, by pixels and by blocks of `side` pixels.
    pub(super) fn variance(&self, side: usize) -> Variance {
        let blocks: Vec<Vec<Rgb>> = self.films.iter().map(|film| blocks(film, side)).collect();
        let pixels: Vec<&[Rgb]> = self.films.iter().map(|film| &film.pixels[..]).collect();
        let blocks: Vec<&[Rgb]> = blocks.iter().map(|blocks| &blocks[..]).collect();
        Variance { pixel: variance(&pixels), block: variance(&blocks) }
    }
}

/// The variance among `images`, relative to the squared mean, on the average over places and channels.
fn variance(images: &[&[Rgb]]) -> f64 {
    let count = images.len() as f64;
    let floor = floor(images);
    let mut terms: Vec<f64> = Vec::with_capacity(3 * images[0].len());
    for place in 0..images[0].len() {
        for channel in 0..3 {
            let values = || images.iter().map(|image| f64::from(image[place][channel]));
            let mean = values().sum::<f64>() / count;
            let squares: f64 = values().map(|value| value - mean).map(|d| d * d).sum();
            terms.push(squares / (count - 1.0) / (mean * mean + floor * floor));
        }
    }
    trimmed_mean(terms)
}

/// How much darker `image` is than `other`, block by block: the mean of the relative difference.
pub(super) fn loss(image: &Film, other: &Film, side: usize) -> f64 {
    let (image, other) = (blocks(image, side), blocks(other, side));
    let floor = floor(&[&other]);
    let mut sum = 0.0;
    for (a, b) in image.iter().zip(&other) {
        for channel in 0..3 {
            let (a, b) = (f64::from(a[channel]), f64::from(b[channel]));
            sum += (b - a).abs() / (b + floor);
        }
    }
    sum / (3 * image.len()) as f64
}

fn floor(images: &[&[Rgb]]) -> f64 {
    let values = images.iter().flat_map(|image| *image).flat_map(Rgb::to_array);
    let count = 3 * images.len() * images[0].len();
    // So that nothing is divided by zero where all is black.
    (FLOOR * values.map(f64::from).sum::<f64>() / count as f64).max(f64::MIN_POSITIVE.sqrt())
}

/// The means of blocks of `side` x `side` pixels; those at the right and at the bottom may be smaller.
pub(super) fn blocks(film: &Film, side: usize) -> Vec<Rgb> {
    let (width, height) = (film.width as usize, film.height as usize);
    let mut blocks = Vec::new();
    for top in (0..height).step_by(side) {
        for left in (0..width).step_by(side) {
            let (bottom, right) = ((top + side).min(height), (left + side).min(width));
            let rows = (top..bottom).map(|y| &film.pixels[y * width + left..y * width + right]);
            let sum: Rgb = rows.flatten().sum();
            blocks.push(sum / ((bottom - top) * (right - left)) as f32);
        }
    }
    blocks
}

/// The mean without the largest terms, and without those that are not finite.
fn trimmed_mean(mut terms: Vec<f64>) -> f64 {
    terms.retain(|term| term.is_finite());
    terms.sort_unstable_by(f64::total_cmp);
    terms.truncate(terms.len() - (SPARKS * terms.len() as f64) as usize);
    terms.iter().sum::<f64>() / terms.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(width: u32, height: u32, value: impl Fn(u32) -> f32) -> Film {
        Film { width, height, pixels: (0..width * height).map(|i| Rgb::splat(value(i))).collect() }
    }

    #[test]
    fn blocks_are_means_and_those_at_the_border_of_fewer_pixels() {
        let film = film(3, 3, |i| i as f32);
        assert_eq!(blocks(&film, 2), [2.0, 3.5, 6.5, 8.0].map(Rgb::splat));
        assert_eq!(blocks(&film, 1), film.pixels);
        assert_eq!(blocks(&film, 9), [Rgb::splat(4.0)]);
    }

    /// Images that are 1 or 3 everywhere, as each of four seeds says: pixels and blocks vary by 4 / 3 about a mean of 2,
    /// and the floor is a tenth of that.
    #[test]
    fn the_variance_is_relative_to_the_mean() {
        let films: Vec<Film> = [1.0, 3.0, 1.0, 3.0].map(|value| film(4, 4, |_| value)).into();
        let pilot = Pilot { films, stats: Stats::default() };
        let exact = (4.0 / 3.0) / (4.0 + 0.2 * 0.2);
        let found = pilot.variance(2);
        assert!((found.pixel - exact).abs() < 1e-12 && (found.block - exact).abs() < 1e-12, "{found:?}");
    }

    /// Where neighbours differ at random, blocks vary less; where all is black, nothing does.
    #[test]
    fn independent_noise_averages_out_in_blocks() {
        let films = (0..4_u32)
            .map(|seed| film(4, 4, |i| if (i ^ seed).count_ones().is_multiple_of(2) { 1.0 } else { 0.0 }));
        let pilot = Pilot { films: films.collect(), stats: Stats::default() };
        let found = pilot.variance(4);
        assert!(found.pixel > 0.5 && found.block < 1e-12, "{found:?}");
        let black = Pilot { films: vec![film(2, 2, |_| 0.0); 4], stats: Stats::default() };
        assert_eq!(black.variance(1), Variance { pixel: 0.0, block: 0.0 });
    }

    #[test]
    fn counts_of_pilots_are_added_up_and_times_are_not() {
        let one = Stats {
            camera_segments: 1,
            shadow_rays: 2,
            photons: 3,
            photon_segments: 4,
            deposits: 5,
            contributions: 6,
            photon_seconds: 7.0,
            ..Stats::default()
        };
        let two = sum(&one, &sum(&Stats::default(), &one));
        let counts = [two.camera_segments, two.shadow_rays, two.photons, two.photon_segments];
        assert_eq!(counts, [2, 4, 6, 8]);
        assert_eq!((two.deposits, two.contributions, two.photon_seconds), (10, 12, 0.0));
    }

    /// By the method of the render, of which each segment of a path may ask for light.
    #[test]
    fn pilots_are_images_by_their_method() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (8, 6);
        scene.settings.photons_per_iteration = 2000;
        let (settings, lanes, stop) = (scene.settings, LaneKind::best(), Stop::new());
        let of = |method| run((method, lanes), &scene, &settings, 1, None, &stop).unwrap();
        let (mut photons, paths) = (Sppm::new(&scene, &settings), PathTracer::new(&scene, &settings));
        let mut hybrid = fast::hybrid(paths, Sppm::new(&scene, &settings));
        photons.iterate();
        hybrid.iterate();
        let (by_photons, by_both) = (of(MethodName::Sppm), of(MethodName::Hybrid));
        assert!(by_photons.films == [photons.develop()] && by_both.films == [hybrid.develop()]);
        assert_eq!(by_photons.stats.shadow_rays, photons.stats().shadow_rays);
        let segments = hybrid.stats().camera_segments;
        assert!(segments > 0);
        assert_eq!([by_both.stats.shadow_rays, by_both.stats.camera_segments], [segments; 2]);
    }

    #[test]
    fn loss_is_the_share_that_is_missing() {
        let (whole, dark) = (film(8, 8, |_| 2.0), film(8, 8, |_| 1.0));
        let exact = 1.0 / (2.0 + 0.2);
        assert!((loss(&dark, &whole, 4) - exact).abs() < 1e-12);
        assert_eq!(loss(&whole, &whole, 4), 0.0);
    }

    #[test]
    fn sparks_are_left_out_of_a_mean() {
        let terms =
            |sparks: usize, all: usize| (0..all).map(|i| if i < sparks { 1e9 } else { 2.0 }).collect();
        assert_eq!(trimmed_mean(terms(5, 1000)), 2.0);
        assert!(trimmed_mean(terms(6, 1000)) > 1e5);
        assert_eq!(trimmed_mean(terms(0, 3)), 2.0);
        assert_eq!(trimmed_mean(vec![f64::NAN, 3.0, f64::INFINITY]), 3.0);
        assert_eq!(trimmed_mean(Vec::new()), 0.0);
    }

    /// A tenth of the mean of all images and channels, and never 0.
    #[test]
    fn the_floor_is_a_share_of_the_mean() {
        let (dark, bright) = ([Rgb::ZERO, Rgb::X * 3.0], [Rgb::splat(1.0), Rgb::splat(2.0)]);
        assert!((floor(&[&dark, &bright]) - 0.1).abs() < 1e-12, "{}", floor(&[&dark, &bright]));
        assert!((floor(&[&bright]) - 0.15).abs() < 1e-12);
        assert!(floor(&[&[Rgb::ZERO]]) > 0.0);
    }

    /// Brighter and darker blocks do not make up for each other, nor do channels.
    #[test]
    fn loss_adds_up_whatever_its_sign() {
        let whole = film(4, 2, |_| 1.0);
        let other = film(4, 2, |i| if i % 4 < 2 { 0.5 } else { 1.5 });
        let exact = 0.5 / (1.0 + FLOOR);
        assert!((loss(&other, &whole, 2) - exact).abs() < 1e-12);
        assert_eq!(loss(&other, &whole, 4), 0.0);
        let red = Film { pixels: vec![Rgb::new(0.5, 1.0, 1.0); 8], ..whole.clone() };
        assert!((loss(&red, &whole, 2) - exact / 3.0).abs() < 1e-12);
    }
}

//! Estimates how noisy a render is from a sample of its pixels, which costs next to nothing.

use crate::estimate::{is_checked, relative_square};
use scene::radius_schedule::Shrinking;
use scene::{FirstRadii, Resumable, Rgb};

/// So many pixels are looked at, or all if there are fewer.
const SAMPLES: usize = 4096;
/// A prime number, so that pixels this many apart do not line up in columns.
const STRIDE: usize = 7919;

/// The radiance of some pixels after an earlier iteration, and the estimate by comparison with it.
#[derive(Debug, Default)]
pub(crate) struct Noise {
    past: Option<(u32, Vec<Rgb>)>,
    error: Option<f64>,
}

impl Noise {
    /// Updates the estimate after an iteration, as [`crate::Estimate`] does.
    pub(crate) fn update(&mut self, engine: &dyn Resumable) {
        let n = engine.iterations();
        if !is_checked(n) {
            return;
        }
        let now = sample(engine);
        if let Some((m, past)) = &self.past {
            let (m, n) = (f64::from(*m), f64::from(n));
            self.error = Some((relative_square(&now, past) * m / (n - m)).sqrt());
        }
        if self.past.is_none() || n.is_power_of_two() {
            self.past = Some((n, now));
        }
    }

    /// The last estimate of the relative error.
    pub(crate) fn estimate(&self) -> Option<f64> {
        self.error.filter(|error| error.is_finite())
    }
}

/// The radiance of pixels from all over the image.
fn sample(engine: &dyn Resumable) -> Vec<Rgb> {
    engine.radiance_of_each(&places(engine).collect::<Vec<_>>())
}

/// The mean square of the radii of pixels that photons counted at, each in units of the pixel's first radius; 1 if there are
/// none. Of first radii that clearance has limited nothing is kept, so with it, it is no less than where light is even.
pub(crate) fn mean_square_radius(engine: &dyn Resumable, first: &FirstRadii) -> f64 {
    let size = (engine.settings().width, engine.settings().height);
    let (mut sum, mut count) = (0.0, 0_u32);
    let probes = places(engine).map(|(x, y)| ((x, y), engine.probe(x, y)));
    for (place, probe) in probes.filter(|(_, probe)| probe.count > 0.0) {
        let radius = f64::from(probe.radius) / f64::from(first.at(place, size));
        (sum, count) = (sum + radius * radius, count + 1);
    }
    let is_limited = engine.settings().radius_clearance > 0.0;
    match count {
        0 => 1.0,
        _ if is_limited => (sum / f64::from(count)).max(evenly_shrunk(engine.iterations())),
        _ => sum / f64::from(count),
    }
}

/// The squared radius after so many iterations, at least one, in units of the first, of a pixel at which as many photons count
/// in each: the product of `(i - 1 + alpha) / i` over these.
fn evenly_shrunk(iterations: u32) -> f64 {
    // From i = 2 on it is that of global radii, i - 1 taken for i; alpha is 2/3.
    let global = Shrinking::default().radius_squared(1.0, iterations - 1);
    2.0 / 3.0 * f64::from(global)
}

/// Pixels from all over the image, by column and row.
fn places(engine: &dyn Resumable) -> impl Iterator<Item = (u32, u32)> {
    let (settings, pixels) = (engine.settings(), engine.settings().pixels());
    let count = pixels.min(SAMPLES);
    let place = move |i: usize| {
        if count == pixels { i } else { i * (pixels / count) + i * STRIDE % (pixels / count) }
    };
    let width = settings.width as usize;
    (0..count).map(move |i| ((place(i) % width) as u32, (place(i) / width) as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Estimate;
    use scene::{Engine, Settings};

    /// The most by which the estimate from a sample differs from that of all pixels, as a factor: some 12 000 terms give
    /// the mean to a few percent, of which a few bright outliers make more.
    const NEAR: f64 = 1.25;

    #[test]
    fn a_sample_tells_what_all_pixels_tell() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 160, height: 120, photons_per_iteration: 20_000, ..scene.settings };
        let mut engine = fast::Sppm::new(&scene, &settings);
        let (mut noise, mut estimate) = (Noise::default(), Estimate::default());
        for n in 1..=9 {
            engine.iterate();
            noise.update(&engine);
            estimate.update(n, || engine.develop());
            assert_eq!(noise.estimate().is_some(), n > 1);
        }
        let (sampled, whole) = (noise.estimate().unwrap(), estimate.error.unwrap());
        assert!(sampled / whole < NEAR && whole / sampled < NEAR, "{sampled} of {whole}");
    }

    /// A render that goes on after any number of iterations has noise to tell from its second one on.
    #[test]
    fn a_resumed_render_tells_its_noise_at_once() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 40, height: 30, photons_per_iteration: 5000, ..scene.settings };
        for first in 1..=9 {
            let mut engine = fast::Sppm::new(&scene, &settings);
            (0..first).for_each(|_| engine.iterate());
            let mut noise = Noise::default();
            noise.update(&engine);
            assert_eq!(noise.estimate(), None);
            let before = sample(&engine);
            engine.iterate();
            noise.update(&engine);
            let expected = (relative_square(&sample(&engine), &before) * f64::from(first)).sqrt();
            let found = noise.estimate().unwrap();
            assert!((found / expected - 1.0).abs() < 1e-9, "after {first}: {found}, not {expected}");
        }
    }

    /// Of each of as many runs of pixels one is looked at, and those do not line up.
    #[test]
    fn samples_are_spread_over_the_whole_image() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 1024, height: 64, photons_per_iteration: 10, ..scene.settings };
        let engine = fast::Sppm::new(&scene, &settings);
        let run = settings.pixels() / SAMPLES;
        let places: Vec<usize> =
            places(&engine).map(|(x, y)| y as usize * settings.width as usize + x as usize).collect();
        assert!(places.iter().enumerate().all(|(i, place)| place / run == i), "{places:?}");
        let mut within: Vec<usize> = places.iter().map(|place| place % run).collect();
        within.sort_unstable();
        within.dedup();
        assert_eq!(within.len(), run);
    }

    #[test]
    fn small_images_are_sampled_as_a_whole() {
        let scene = files::builtin::scene("cornell").unwrap();
        for (width, height) in [(1, 1), (7, 3), (64, 64), (65, 64), (4097, 3)] {
            let settings = Settings { width, height, photons_per_iteration: 10, ..scene.settings };
            let engine = fast::Sppm::new(&scene, &settings);
            assert_eq!(sample(&engine).len(), settings.pixels().min(SAMPLES));
        }
    }

    /// Radii are compared with the first of the pixel, not with the largest of all: at first nothing has shrunk, and after an
    /// iteration squares are 2/3 of the first where photons came.
    #[test]
    fn radii_shrink_from_the_first_of_their_pixel() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 40, height: 30, photons_per_iteration: 20_000, ..scene.settings };
        let first = FirstRadii::even(settings.initial_radius / 4.0);
        let mut engine = fast::Sppm::new(&scene, &settings).beginning_with(first.clone());
        assert_eq!(mean_square_radius(&engine, &first), 1.0);
        engine.iterate();
        let found = mean_square_radius(&engine, &first);
        assert!((found - 2.0 / 3.0).abs() < 1e-3, "{found}");
    }

    /// Where light is even they are those of pixels that count many photons: in the box, whose walls are lit from all sides.
    #[test]
    fn radii_shrink_evenly_where_light_is_even() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 40, height: 30, photons_per_iteration: 20_000, ..scene.settings };
        let first = FirstRadii::even(settings.initial_radius);
        let mut engine = fast::Sppm::new(&scene, &settings);
        for iterations in 1..=8 {
            engine.iterate();
            let (even, found) = (evenly_shrunk(iterations), mean_square_radius(&engine, &first));
            assert!((even / found - 1.0).abs() < 0.1, "{iterations} iterations: {even}, {found}");
        }
        // Clearance has narrowed the first radii of many: these have not shrunk.
        let limited = Settings { radius_clearance: 0.1, ..settings };
        let mut engine = fast::Sppm::new(&scene, &limited);
        engine.iterate();
        assert_eq!(mean_square_radius(&engine, &first), evenly_shrunk(1));
        assert!((evenly_shrunk(1) - 2.0 / 3.0).abs() < 1e-7);
        assert!((evenly_shrunk(2) - 2.0 / 3.0 * 5.0 / 6.0).abs() < 1e-7);
    }

    /// After every iteration from the second on, whatever its distance from the one before.
    #[test]
    fn a_sample_tells_it_after_any_iteration() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 64, height: 48, photons_per_iteration: 20_000, ..scene.settings };
        let mut engine = fast::Sppm::new(&scene, &settings);
        let (mut noise, mut estimate) = (Noise::default(), Estimate::default());
        for n in 1..=7 {
            engine.iterate();
            noise.update(&engine);
            estimate.update(n, || engine.develop());
            // All pixels are looked at.
            assert_eq!(noise.estimate().is_some(), n > 1);
            if let (Some(sampled), Some(whole)) = (noise.estimate(), estimate.error) {
                assert!((sampled / whole - 1.0).abs() < 1e-9, "{sampled} of {whole} after {n}");
            }
        }
    }
}

//! Path tracing and photon mapping in one image, each for the light that it finds well.
//!
//! Light that leaves a lamp meets a surface first. If that is diffuse, or the light is of a glowing enclosure such as the
//! sky, a path tracer finds it with little noise: by a shadow ray, or by chance. If it is a mirror or glass, and a diffuse
//! surface follows, the light is a caustic there, or what such a caustic lights: a path from the eye meets the lamp by
//! chance alone, and the smaller the lamp is, the noisier. Photons carry that light ([`Carried::Caustics`](crate::still::Carried)),
//! and nothing else. So every path of light between a lamp and the eye is counted by exactly one of both, and the image is
//! the sum of two images. Caustics are the use that photon maps were first proposed for (Jensen 1996).

use crate::color::Rgb;
use crate::engine::{Engine, Probe, Progress, Stats};
use crate::film::Film;
use crate::state::{PATH_WORDS, PhotonSums, Resumable, Sums};
use crate::stop::Stop;

/// A path tracer whose iterations come in two steps, so that another engine's can be done between them, or not at all.
pub trait Sampler: Resumable {
    /// Takes a sample of every pixel, and adds none of them; false if stopped.
    #[must_use]
    fn sample_unless(&mut self, stop: &Stop) -> bool;

    /// Adds the samples that [`Self::sample_unless`] took, which completes an iteration.
    fn add_samples(&mut self);

    /// Both steps: [`Engine::iterate_unless`]. Samples are added only when all are complete, so that an iteration can be
    /// abandoned.
    #[must_use]
    fn sample_and_add_unless(&mut self, stop: &Stop) -> bool {
        let is_whole = self.sample_unless(stop);
        if is_whole {
            self.add_samples();
        }
        is_whole
    }
}

/// The sum of a path tracer's image, without caustics, and of one of caustics alone.
pub struct Hybrid<P, C> {
    paths: P,
    caustics: C,
    progress: Progress,
    /// What was counted before this engine went on with a render that another had begun.
    before: Stats,
}

impl<P: Sampler, C: Resumable> Hybrid<P, C> {
    /// A render of both, which have not begun and have the same settings, with radii per pixel.
    pub fn new(paths: P, caustics: C) -> Self {
        let progress = Progress::new(paths.settings());
        Self { paths, caustics, progress, before: Stats::default() }
    }

    /// Room for the words of a row of either.
    fn rows(&self) -> [Vec<u32>; 2] {
        let width = self.progress.settings.width as usize;
        [PATH_WORDS, PhotonSums::WORDS].map(|words| vec![0; words * width])
    }
}

impl<P: Sampler, C: Resumable> Engine for Hybrid<P, C> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        // Samples are added only when the photons are done as well, so that an iteration can be abandoned.
        if !self.paths.sample_unless(stop) || !self.caustics.iterate_unless(stop) {
            return false;
        }
        self.paths.add_samples();
        self.progress.advance();
        let (paths, caustics) = (self.paths.stats(), self.caustics.stats());
        self.progress.stats = self.before;
        self.progress.stats.add(paths);
        self.progress.stats.add(caustics);
        self.progress.stats.bytes = paths.bytes + caustics.bytes;
        true
    }

    /// Direct light is not kept apart from other light of paths.
    fn direct(&self) -> Option<Film> {
        None
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        Probe { radiance: self.radiance(x, y), ..self.caustics.probe(x, y) }
    }

    fn radiance(&self, x: u32, y: u32) -> Rgb {
        self.paths.radiance(x, y) + self.caustics.radiance(x, y)
    }
}

impl<P: Sampler, C: Resumable> Resumable for Hybrid<P, C> {
    fn sums(&self) -> Sums {
        Sums::Hybrid
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let [mut paths, mut caustics] = self.rows();
        assert_eq!(words.len(), paths.len() + caustics.len(), "not a row");
        self.paths.save_row(y, &mut paths);
        self.caustics.save_row(y, &mut caustics);
        for (pixel, words) in words.chunks_exact_mut(Sums::Hybrid.words()).enumerate() {
            let (of_paths, of_caustics) = words.split_at_mut(PATH_WORDS);
            of_paths.copy_from_slice(&paths[pixel * PATH_WORDS..][..PATH_WORDS]);
            of_caustics.copy_from_slice(&caustics[pixel * PhotonSums::WORDS..][..PhotonSums::WORDS]);
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let [mut paths, mut caustics] = self.rows();
        assert_eq!(words.len(), paths.len() + caustics.len(), "not a row");
        for (pixel, words) in words.chunks_exact(Sums::Hybrid.words()).enumerate() {
            let (of_paths, of_caustics) = words.split_at(PATH_WORDS);
            paths[pixel * PATH_WORDS..][..PATH_WORDS].copy_from_slice(of_paths);
            caustics[pixel * PhotonSums::WORDS..][..PhotonSums::WORDS].copy_from_slice(of_caustics);
        }
        self.paths.load_row(y, &paths);
        self.caustics.load_row(y, &caustics);
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.before = stats;
        self.progress.go_on_after(iterations, stats);
        self.paths.go_on_after(iterations, Stats::default());
        self.caustics.go_on_after(iterations, Stats::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::settings::Settings;

    /// An engine whose words count its iterations and samples, and which may be told to abandon the next iteration.
    struct Fake {
        progress: Progress,
        sums: Sums,
        words: Vec<u32>,
        taken: u32,
        abandons: bool,
    }

    impl Fake {
        fn new(sums: Sums, first: u32) -> Self {
            let settings = Settings { width: 3, height: 2, ..Settings::default() };
            let words = (first..).take(3 * 2 * sums.words()).collect();
            Self { progress: Progress::new(&settings), sums, words, taken: 0, abandons: false }
        }

        fn row(&self, y: u32) -> std::ops::Range<usize> {
            let row = 3 * self.sums.words();
            y as usize * row..(y as usize + 1) * row
        }
    }

    impl Engine for Fake {
        fn progress(&self) -> &Progress {
            &self.progress
        }

        fn iterate_unless(&mut self, _: &Stop) -> bool {
            if !self.abandons {
                self.progress.advance();
                self.progress.stats.photons += 10;
                self.progress.stats.bytes = 500;
            }
            !self.abandons
        }

        fn probe(&self, x: u32, y: u32) -> Probe {
            let value = (10 * y + x + self.words[0]) as f32;
            let direct = Rgb::splat(99.0);
            Probe { radiance: Rgb::splat(value), direct, radius: value + 0.5, count: value + 0.25 }
        }
    }

    impl Resumable for Fake {
        fn sums(&self) -> Sums {
            self.sums
        }

        fn save_row(&self, y: u32, words: &mut [u32]) {
            words.copy_from_slice(&self.words[self.row(y)]);
        }

        fn load_row(&mut self, y: u32, words: &[u32]) {
            let row = self.row(y);
            self.words[row].copy_from_slice(words);
        }

        fn go_on_after(&mut self, iterations: u32, stats: Stats) {
            self.progress.go_on_after(iterations, stats);
        }
    }

    impl Sampler for Fake {
        fn sample_unless(&mut self, _: &Stop) -> bool {
            self.taken += u32::from(!self.abandons);
            !self.abandons
        }

        fn add_samples(&mut self) {
            self.progress.advance();
            self.progress.stats.camera_segments += 7;
            self.progress.stats.bytes = 300;
        }
    }

    fn both() -> Hybrid<Fake, Fake> {
        Hybrid::new(Fake::new(Sums::Paths, 1000), Fake::new(Sums::Photons, 5000))
    }

    /// Whichever part abandons an iteration, neither has done it.
    #[test]
    fn an_iteration_is_done_by_both_or_by_none() {
        let (mut engine, stop) = (both(), Stop::new());
        let done = |engine: &Hybrid<Fake, Fake>| {
            (engine.iterations(), engine.paths.iterations(), engine.caustics.iterations())
        };
        engine.caustics.abandons = true;
        assert!(!engine.iterate_unless(&stop) && engine.paths.taken == 1);
        assert_eq!((done(&engine), *engine.stats()), ((0, 0, 0), Stats::default()));
        (engine.caustics.abandons, engine.paths.abandons) = (false, true);
        assert!(!engine.iterate_unless(&stop));
        assert_eq!((done(&engine), *engine.stats()), ((0, 0, 0), Stats::default()));
        engine.paths.abandons = false;
        assert!(engine.iterate_unless(&stop));
        assert_eq!(done(&engine), (1, 1, 1));
    }

    /// Work of both, and what another engine had done before; memory of both at the same time.
    #[test]
    fn work_is_that_of_both_and_of_before() {
        let mut engine = both();
        let before = Stats { camera_segments: 100, photons: 1000, bytes: 9999, ..Stats::default() };
        engine.go_on_after(4, before);
        assert_eq!((*engine.stats(), engine.iterations(), engine.paths.iterations()), (before, 4, 4));
        engine.iterate();
        engine.iterate();
        let Stats { camera_segments, photons, bytes, .. } = *engine.stats();
        assert_eq!((camera_segments, photons, bytes), (114, 1020, 800));
        assert_eq!((engine.iterations(), engine.caustics.iterations(), engine.progress().next), (6, 6, 6));
    }

    #[test]
    fn light_is_the_sum_and_radii_are_the_photons() {
        let engine = both();
        let found = engine.probe(2, 1);
        assert_eq!(found.radiance, Rgb::splat(1012.0 + 5012.0));
        assert_eq!((found.radius, found.count), (5012.5, 5012.25));
        assert!(engine.has_photons() && engine.direct().is_none() && engine.radius().is_some());
    }

    /// Pixel by pixel the words of the path tracer come first.
    #[test]
    fn rows_hold_the_words_of_both() {
        let engine = both();
        assert_eq!((engine.sums(), Sums::Hybrid.words()), (Sums::Hybrid, 14));
        let mut words = vec![0; 3 * 14];
        engine.save_row(1, &mut words);
        for (pixel, words) in (0..).zip(words.chunks_exact(14)) {
            let (paths, caustics) = (1018 + 6 * pixel, 5024 + 8 * pixel);
            assert_eq!(words[..6], (paths..paths + 6).collect::<Vec<u32>>());
            assert_eq!(words[6..], (caustics..caustics + 8).collect::<Vec<u32>>());
        }
        let mut other = Hybrid::new(Fake::new(Sums::Paths, 0), Fake::new(Sums::Photons, 0));
        other.load_row(1, &words);
        assert_eq!(other.paths.words[18..], engine.paths.words[18..]);
        assert_eq!(other.caustics.words[24..], engine.caustics.words[24..]);
        assert_eq!((other.paths.words[17], other.caustics.words[23]), (17, 23));
    }
}

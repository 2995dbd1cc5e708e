//! Path tracing and photon mapping in one image, each for the light that it finds well.
//!
//! Light that leaves a lamp meets a surface first. If that is diffuse, or the light is of a glowing enclosure such as the
//! sky, a path tracer finds it with little noise: by a shadow ray, or by chance. If it is a mirror or glass, and a diffuse
//! surface follows, the light is a caustic there, or what such a caustic lights: a path from the eye meets the lamp by
//! chance alone, and the smaller the lamp is, the noisier. Photons carry that light ([`Carried::Caustics`](crate::still::Carried)),
//! and nothing else. So every path of light between a lamp and the eye is counted by exactly one of both, and the image is
//! the sum of two images. Caustics are the use that photon maps were first proposed for (Jensen 1996).

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
        let (paths, caustics) = (self.paths.probe(x, y), self.caustics.probe(x, y));
        Probe { radiance: paths.radiance + caustics.radiance, ..caustics }
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

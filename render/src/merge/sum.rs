//! The sum of parts: the state of a render that was computed elsewhere.

use scene::exact::Scale;
use scene::radius_schedule::Shrinking;
use scene::{
    Engine, ExactSums, Iterations, Probe, Progress, Resumable, Rgb, Scene, Settings, Stats, Stop, Sums,
};

/// The sum of parts, with what images and checkpoints need of an engine. It cannot iterate.
pub struct Sum {
    progress: Progress,
    scale: Scale,
    radius: f32,
    pixels: Vec<ExactSums>,
}

impl Sum {
    /// The sum of nothing.
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            progress: Progress::new(&scene.settings),
            scale: Scale::of(scene),
            radius: scene.settings.initial_radius,
            pixels: vec![ExactSums::default(); scene.settings.pixels()],
        }
    }

    /// Adds the words of a row.
    pub(super) fn add_row(&mut self, y: u32, words: &[u32]) {
        let width = self.progress.settings.width as usize;
        let row = &mut self.pixels[y as usize * width..][..width];
        for (sum, words) in row.iter_mut().zip(words.as_chunks().0) {
            sum.add(&ExactSums::from_words(*words));
        }
    }

    /// Sets which iterations were added, with their statistics.
    pub(super) fn set_done(&mut self, done: &Iterations, stats: &Stats) {
        self.progress.go_on_after(done.count(), *stats);
        self.progress.next = done.end();
        let first = self.progress.settings.initial_radius * self.progress.settings.initial_radius;
        self.radius = Shrinking::default().radius_squared(first, done.end()).sqrt();
    }
}

impl Engine for Sum {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn iterate_unless(&mut self, _: &Stop) -> bool {
        false
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        let Progress { settings: Settings { width, .. }, iterations, .. } = self.progress;
        let sums = &self.pixels[y as usize * width as usize + x as usize];
        let radiance = if iterations > 0 { sums.develop(self.scale, iterations) } else { Rgb::ZERO };
        Probe { radiance, direct: Rgb::ZERO, radius: self.radius, count: sums.photons as f32 }
    }
}

impl Resumable for Sum {
    fn sums(&self) -> Sums {
        Sums::Exact
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let width = self.progress.settings.width as usize;
        for (words, sum) in words.as_chunks_mut().0.iter_mut().zip(&self.pixels[y as usize * width..]) {
            *words = sum.to_words();
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let width = self.progress.settings.width as usize;
        self.pixels[y as usize * width..][..width].fill(ExactSums::default());
        self.add_row(y, words);
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.progress.go_on_after(iterations, stats);
    }
}

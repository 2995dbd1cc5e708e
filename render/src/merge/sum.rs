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

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings = Settings {
            width: 3,
            height: 2,
            // Its square is not its double, as that of 2 is.
            initial_radius: 0.5,
            radius_schedule: scene::RadiusSchedule::Global,
            ..scene.settings
        };
        scene
    }

    /// The words of a row of pixels that have seen so many photons, one more each.
    fn row(first: u64) -> Vec<u32> {
        let pixel = |k: u64| ExactSums { photons: first + k, ..ExactSums::default() }.to_words();
        (0..3).flat_map(pixel).collect()
    }

    fn saved(sum: &Sum, y: u32) -> Vec<u32> {
        let mut words = vec![0; 3 * ExactSums::WORDS];
        sum.save_row(y, &mut words);
        words
    }

    #[test]
    fn rows_are_added_and_loaded_in_their_place() {
        let mut sum = Sum::new(&scene());
        assert_eq!((sum.sums(), sum.iterate_unless(&Stop::new())), (Sums::Exact, false));
        sum.add_row(1, &row(10));
        sum.add_row(1, &row(100));
        sum.add_row(0, &row(1));
        let doubled: Vec<u32> = (0..3)
            .flat_map(|k| ExactSums { photons: 110 + 2 * k, ..ExactSums::default() }.to_words())
            .collect();
        assert_eq!((saved(&sum, 0), saved(&sum, 1)), (row(1), doubled));
        assert_eq!(sum.probe(2, 1).count, 114.0);
        // Whatever was there before.
        sum.load_row(1, &row(7));
        assert_eq!((saved(&sum, 0), saved(&sum, 1)), (row(1), row(7)));
    }

    #[test]
    fn a_sum_of_nothing_is_black_and_radii_are_those_of_its_end() {
        let scene = scene();
        let mut sum = Sum::new(&scene);
        assert_eq!(
            (sum.probe(0, 0).radiance, sum.probe(0, 0).radius),
            (Rgb::ZERO, scene.settings.initial_radius)
        );
        sum.set_done(&(2..5).into(), &Stats { photons: 9, ..Stats::default() });
        assert_eq!((sum.iterations(), sum.progress().next, sum.stats().photons), (3, 5, 9));
        let mut engine = fast::Sppm::new(&scene, &scene.settings);
        engine.skip_to(5);
        assert_eq!(sum.probe(2, 1).radius, engine.probe(2, 1).radius);
        assert_eq!(sum.probe(0, 0).radiance, Rgb::ZERO);
        sum.go_on_after(4, Stats::default());
        assert_eq!((sum.iterations(), sum.progress().next), (4, 4));
    }
}

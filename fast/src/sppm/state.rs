//! Stopping within an iteration, saving, and taking up again.

use super::{Prepared, Sppm};
use crate::camera_pass::slot_of;
use crate::consolidate::develop;
use crate::lanes::Row;
use scene::{Probe, Resumable, Rgb, Settings, Stats, Stop, Sums};
use std::mem::take;

impl Sppm<'_> {
    /// Forgets an iteration that was abandoned.
    fn abandon(&mut self, before: Stats) {
        self.stats = before;
        self.sums.clear();
        for worker in self.camera_workers.all() {
            (worker.occupancy, worker.segments, worker.visible_points) = (None, 0, 0);
        }
        for worker in self.photon_workers.all() {
            worker.out.clear();
            (worker.segments, worker.deposits) = (0, 0);
        }
    }
}

impl Resumable for Sppm<'_> {
    fn settings(&self) -> &Settings {
        &self.settings
    }

    fn sums(&self) -> Sums {
        Sums::Photons
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let width = self.settings.width;
        assert_eq!(words.len(), 8 * width as usize, "not a row");
        for (words, x) in words.chunks_exact_mut(8).zip(0..width) {
            words.copy_from_slice(&self.pixels[slot_of(width, x, y)].0.map(f32::to_bits));
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let width = self.settings.width;
        assert_eq!(words.len(), 8 * width as usize, "not a row");
        for (words, x) in words.chunks_exact(8).zip(0..width) {
            self.pixels[slot_of(width, x, y)] = Row(std::array::from_fn(|i| f32::from_bits(words[i])));
        }
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        assert!(x < self.settings.width && y < self.settings.height, "no such pixel");
        let pixel = &self.pixels[slot_of(self.settings.width, x, y)];
        let [.., n, radius_squared] = pixel.0;
        let radiance =
            if self.iterations > 0 { develop(pixel, &self.settings, self.iterations) } else { Rgb::ZERO };
        Probe { radiance, radius: radius_squared.sqrt(), count: n }
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        (self.iterations, self.stats) = (iterations, stats);
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        let before = self.stats;
        let prepared = take(&mut self.prepared);
        let done = if let Some(prepared) = &prepared {
            self.run_iteration(prepared, stop)
        } else {
            let time = self.scene.camera.shutter_time(self.settings.seed, self.iterations);
            self.run_iteration(&Prepared::new(self.scene.at(time), &self.parameters), stop)
        };
        self.prepared = prepared;
        if done.is_none() {
            self.abandon(before);
        }
        done.is_some()
    }
}

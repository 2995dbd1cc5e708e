//! The renderer as an engine: iterations that can be stopped, images, and state that can be saved and resumed.

use super::render::Sppm;
use crate::consolidate::develop;
use crate::pixels::{Pixel, slot_of};
use crate::prepared::Prepared;
use rayon::prelude::*;
use scene::{Engine, Film, Probe, Progress, Resumable, Rgb, Settings, Stats, Stop, Sums};
use std::mem::take;

impl Sppm<'_> {
    /// Clears what a stopped iteration has left.
    fn abandon(&mut self, before: Stats) {
        self.progress.stats = before;
        self.join.clear();
        self.camera_workers.clear();
        self.photon_workers.clear();
    }
}

impl Engine for Sppm<'_> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        let before = self.progress.stats;
        let prepared = take(&mut self.prepared);
        let done = if let Some(prepared) = &prepared {
            let emitters = take(&mut self.emitters).unwrap_or_else(|| self.new_emitters(prepared));
            let done = self.run_iteration(prepared, &emitters, stop);
            self.emitters = Some(emitters);
            done
        } else {
            let time = self.scene.camera.shutter_time(self.progress.settings.seed, self.progress.iterations);
            let prepared = Prepared::new(self.scene.at(time), &self.parameters, None);
            let emitters = self.new_emitters(&prepared);
            self.run_iteration(&prepared, &emitters, stop)
        };
        self.prepared = prepared;
        if done.is_none() {
            self.abandon(before);
        }
        done.is_some()
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        assert!(x < self.progress.settings.width && y < self.progress.settings.height, "no such pixel");
        let pixel = &self.pixels[slot_of(self.progress.settings.width, x, y)];
        let radiance = if self.progress.iterations > 0 {
            develop(pixel, &self.progress.settings, self.progress.iterations)
        } else {
            Rgb::ZERO
        };
        Probe { radiance, direct: Rgb::from_array(pixel.direct), radius: pixel.radius(), count: pixel.n }
    }

    /// By all threads.
    fn develop(&self) -> Film {
        let Settings { width, height, .. } = self.progress.settings;
        let mut film = Film::new(width, height);
        if self.progress.iterations > 0 {
            let rows = film.pixels.par_chunks_mut(width as usize).enumerate();
            rows.for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    let slot = slot_of(width, x as u32, y as u32);
                    *pixel = develop(&self.pixels[slot], &self.progress.settings, self.progress.iterations);
                }
            });
        }
        film
    }
}

impl Resumable for Sppm<'_> {
    fn sums(&self) -> Sums {
        Sums::Photons
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let (width, words) = (self.progress.settings.width, words.as_chunks_mut().0);
        assert_eq!(words.len(), width as usize, "not a row");
        for (words, x) in words.iter_mut().zip(0..width) {
            *words = self.pixels[slot_of(width, x, y)].words();
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let (width, words) = (self.progress.settings.width, words.as_chunks().0);
        assert_eq!(words.len(), width as usize, "not a row");
        for (words, x) in words.iter().zip(0..width) {
            self.pixels[slot_of(width, x, y)] = Pixel::from_words(*words);
        }
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        (self.progress.iterations, self.progress.stats) = (iterations, stats);
    }
}

//! The renderer as an engine: iterations that can be stopped, images, and state that can be saved and resumed.

use super::render::Sppm;
use crate::consolidate::develop;
use crate::pixels::{Pixel, TILE, slot_of};
use crate::prepared::Prepared;
use lanes::prefetch;
use rayon::prelude::*;
use scene::film::{TILE_SIDE, Tile, tile_of};
use scene::{Engine, Film, Plane, Probe, Progress, Resumable, Rgb, Settings, Stats, Stop, Sums};
use std::mem::take;
use std::{array, iter};

/// A pixel is prefetched when the one this many places before it is read.
const AHEAD: u32 = 16;

impl Sppm<'_> {
    /// Clears what a stopped iteration has left.
    fn abandon(&mut self, before: Stats) {
        self.progress.stats = before;
        self.begin_again();
        self.join.clear();
        self.camera_workers.clear();
        self.photon_workers.clear();
    }

    /// The radiance of the pixel in a slot, one of these; black before the first iteration.
    #[inline(always)]
    fn radiance_of(&self, pixels: &[Pixel], slot: usize) -> Rgb {
        let Progress { settings, iterations, .. } = &self.progress;
        match &self.global {
            Some(global) => global.develop(slot, *iterations),
            None if *iterations > 0 => develop(&pixels[slot], settings, *iterations),
            None => Rgb::ZERO,
        }
    }

    /// The slot of a pixel of the image.
    #[inline(always)]
    fn slot(&self, x: u32, y: u32) -> usize {
        let Settings { width, height, .. } = self.progress.settings;
        assert!(x < width && y < height, "no such pixel");
        slot_of(width, x, y)
    }

    /// A value of every pixel by its slot, row by row. By all threads. Slots of a row lie apart, so they are prefetched.
    fn every<T: Send + Sync + Copy + Default>(&self, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let Settings { width, height, .. } = self.progress.settings;
        let mut values = vec![T::default(); width as usize * height as usize];
        let pixels = &self.pixels[..];
        values.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            for (x, place) in row.iter_mut().enumerate() {
                prefetch(pixels, slot_of(width, x as u32 + AHEAD, y as u32));
                *place = value(slot_of(width, x as u32, y as u32));
            }
        });
        values
    }

    fn plane(&self, value: impl Fn(usize) -> f32 + Sync) -> Plane {
        let Settings { width, height, .. } = self.progress.settings;
        Plane { width, height, values: self.every(value) }
    }
}

impl Engine for Sppm<'_> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        if !self.begin(stop) {
            return false;
        }
        let before = self.progress.stats;
        let prepared = take(&mut self.prepared);
        let done = if let Some(prepared) = &prepared {
            let emitters = take(&mut self.emitters).unwrap_or_else(|| self.new_emitters(prepared));
            let done = self.run_iteration(prepared, &emitters, stop);
            self.emitters = Some(emitters);
            done
        } else {
            let time = self.scene.camera.shutter_time(self.progress.settings.seed, self.progress.next);
            let prepared = Prepared::new(self.scene.at_for(time, self.carried), &self.parameters, None);
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
        let slot = self.slot(x, y);
        let pixels = &self.pixels[..];
        let (pixel, radiance) = (&pixels[slot], self.radiance_of(pixels, slot));
        if let Some(global) = &self.global {
            let (radius, count) = (global.radius_squared.sqrt(), global.sums(slot).photons as f32);
            return Probe { radiance, direct: Rgb::ZERO, radius, count };
        }
        Probe { radiance, direct: Rgb::from_array(pixel.direct), radius: pixel.radius(), count: pixel.n }
    }

    fn radiance(&self, x: u32, y: u32) -> Rgb {
        let (slot, pixels) = (self.slot(x, y), &self.pixels[..]);
        // Who asks for pixel after pixel may do so in the order of their slots.
        prefetch(pixels, slot + AHEAD as usize);
        self.radiance_of(pixels, slot)
    }

    fn radiance_of_each(&self, places: &[(u32, u32)]) -> Vec<Rgb> {
        let pixels = &self.pixels[..];
        let ahead = places.iter().skip(AHEAD as usize).map(Some).chain(iter::repeat(None));
        let radiance = |((x, y), later): (&(u32, u32), Option<&(u32, u32)>)| {
            if let Some((x, y)) = later {
                prefetch(pixels, self.slot(*x, *y));
            }
            self.radiance_of(pixels, self.slot(*x, *y))
        };
        places.iter().zip(ahead).map(radiance).collect()
    }

    fn radiance_of_tile(&self, left: u32, top: u32) -> Tile<Rgb> {
        let Progress { settings, iterations, .. } = &self.progress;
        let is_tile = left.is_multiple_of(TILE_SIDE) && top.is_multiple_of(TILE_SIDE);
        if !is_tile || *iterations == 0 || self.global.is_some() {
            return tile_of(left, top, |x, y| self.radiance(x, y));
        }
        let Settings { width, height, .. } = *settings;
        assert!(left + TILE_SIDE <= width && top + TILE_SIDE <= height, "no such tile");
        let pixels = &self.pixels[slot_of(width, left, top)..][..TILE];
        array::from_fn(|k| develop(&pixels[k], settings, *iterations))
    }

    fn develop(&self) -> Film {
        let Settings { width, height, .. } = self.progress.settings;
        let pixels = &self.pixels[..];
        Film { width, height, pixels: self.every(|slot| self.radiance_of(pixels, slot)) }
    }

    fn radius(&self) -> Option<Plane> {
        Some(match &self.global {
            Some(global) => self.plane(|_| global.radius_squared.sqrt()),
            None => self.plane(|slot| self.pixels[slot].radius()),
        })
    }

    fn count(&self) -> Option<Plane> {
        Some(match &self.global {
            Some(global) => self.plane(|slot| global.sums(slot).photons as f32),
            None => self.plane(|slot| self.pixels[slot].n),
        })
    }
}

impl Resumable for Sppm<'_> {
    fn sums(&self) -> Sums {
        if self.global.is_some() { Sums::Exact } else { Sums::Photons }
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let width = self.progress.settings.width;
        assert_eq!(words.len(), width as usize * self.sums().words(), "not a row");
        if let Some(global) = &self.global {
            for (words, x) in words.as_chunks_mut().0.iter_mut().zip(0..width) {
                *words = global.words(slot_of(width, x, y));
            }
            return;
        }
        for (words, x) in words.as_chunks_mut().0.iter_mut().zip(0..width) {
            *words = self.pixels[slot_of(width, x, y)].words();
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let width = self.progress.settings.width;
        assert_eq!(words.len(), width as usize * self.sums().words(), "not a row");
        if let Some(global) = &mut self.global {
            for (words, x) in words.as_chunks().0.iter().zip(0..width) {
                global.set_words(slot_of(width, x, y), *words);
            }
            return;
        }
        self.radii = None;
        for (words, x) in words.as_chunks().0.iter().zip(0..width) {
            self.pixels[slot_of(width, x, y)] = Pixel::from_words(*words);
        }
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.progress.go_on_after(iterations, stats);
        self.shrink();
    }

    fn skip_to(&mut self, next: u32) {
        assert!(self.global.is_some(), "iteration {next} depends on those before it");
        self.progress.next = next;
        self.shrink();
    }
}

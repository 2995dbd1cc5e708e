//! Pixels with global radii: the radius of each iteration, and exact sums of what pixels gain.

use crate::pages::Pages;
use crate::pixels::{Pixel, slots};
use rayon::prelude::*;
use scene::exact::Scale;
use scene::radius_schedule::{RadiusSchedule, Shrinking};
use scene::{ExactSums, Rgb, Scene, Settings};

/// Pixels of a work item.
const PIXELS_AT_ONCE: usize = 4096;

/// The sums of a pixel: [`ExactSums`] as words.
type Words = [u32; ExactSums::WORDS];

/// Bytes per pixel.
pub(crate) const BYTES_OF_GLOBAL: usize = size_of::<Words>();

/// The state of a render with global radii.
pub(crate) struct Global {
    scale: Scale,
    shrinking: Shrinking,
    /// The squared radius of the next iteration.
    pub(crate) radius_squared: f32,
    /// In tile order.
    sums: Pages<Words>,
}

impl Global {
    /// Before the first iteration; `None` if radii are per pixel.
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Option<Self> {
        (settings.radius_schedule == RadiusSchedule::Global).then(|| Self {
            scale: Scale::of(scene),
            shrinking: Shrinking::default(),
            radius_squared: Pixel::new(settings.initial_radius).radius_squared,
            sums: Pages::zeros(slots(settings)),
        })
    }

    /// Sets the radius to that of iteration `next`.
    pub(crate) fn shrink(&mut self, settings: &Settings, next: u32) {
        let first = Pixel::new(settings.initial_radius).radius_squared;
        self.radius_squared = self.shrinking.radius_squared(first, next);
    }

    /// Gives all pixels the radius of the next iteration, by which they gather.
    pub(crate) fn prepare(&self, pixels: &mut [Pixel]) {
        let blank = Pixel { radius_squared: self.radius_squared, ..Pixel::new(0.0) };
        pixels.par_chunks_mut(PIXELS_AT_ONCE).for_each(|pixels| pixels.fill(blank));
    }

    /// Adds what pixels have gained in an iteration, as [`crate::consolidate::estimate_group`] leaves it.
    pub(crate) fn add(&mut self, pixels: &[Pixel]) {
        let scale = self.scale;
        let jobs = self.sums.par_chunks_mut(PIXELS_AT_ONCE).zip(pixels.par_chunks(PIXELS_AT_ONCE));
        jobs.for_each(|(sums, pixels)| {
            for (words, pixel) in sums.iter_mut().zip(pixels) {
                let mut sum = ExactSums::from_words(*words);
                sum.gain(scale, Rgb::from_array(pixel.direct), pixel.n.to_bits());
                *words = sum.to_words();
            }
        });
    }

    /// Radiance in a slot after so many iterations; black before the first.
    pub(crate) fn develop(&self, slot: usize, iterations: u32) -> Rgb {
        if iterations > 0 { self.sums(slot).develop(self.scale, iterations) } else { Rgb::ZERO }
    }

    /// The sums of a slot.
    pub(crate) fn sums(&self, slot: usize) -> ExactSums {
        ExactSums::from_words(self.sums[slot])
    }

    /// The words of a slot.
    pub(crate) fn words(&self, slot: usize) -> Words {
        self.sums[slot]
    }

    /// Sets the words of a slot.
    pub(crate) fn set_words(&mut self, slot: usize, words: Words) {
        self.sums[slot] = words;
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.sums[..])
    }
}

//! A render between two iterations, as numbers that any engine can take up.
//!
//! What an engine keeps from one iteration to the next is, for every pixel, a few words: see [`Sums`]. They are the
//! same whichever engine, lanes or threads computed them, so a render that one engine began another may go on with,
//! and the image is the one of a render that never stopped.

use crate::{Engine, Rgb, Settings, Stats};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a pixel's words are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sums {
    /// Of photon mapping: eight `f32` by their bits: the sum of direct light r g b over all iterations, `tau` r g b,
    /// `N`, and the squared search radius.
    Photons,
    /// Of path tracing: the sums of radiance r g b over all iterations, three `f64` by their bits, of each the lower
    /// word first.
    Paths,
}

impl Sums {
    /// What no engine leaves of a pixel, if its words are of that kind: a count that is none, or a radius that is none
    /// or has grown.
    pub fn fault(self, words: &[u32], initial_radius: f32) -> Option<&'static str> {
        let (Self::Photons, [.., n, radius_squared]) = (self, words) else {
            return None;
        };
        let (n, radius_squared) = (f32::from_bits(*n), f32::from_bits(*radius_squared));
        if !(n >= 0.0 && n.is_finite()) {
            return Some("has a pixel whose count of photons is none");
        }
        let is_radius = radius_squared > 0.0 && radius_squared <= initial_radius * initial_radius;
        (!is_radius).then_some("has a pixel whose radius is none, or larger than the first")
    }

    /// Words per pixel.
    pub fn words(self) -> usize {
        match self {
            Self::Photons => 8,
            Self::Paths => 6,
        }
    }
}

impl fmt::Display for Sums {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Photons => "photon mapping",
            Self::Paths => "path tracing",
        })
    }
}

/// A request, from another thread or a signal, to abandon the iteration in progress.
///
/// Clones are the same request.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// No request yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The flag itself, for handlers of signals: setting it makes the request.
    pub fn shared(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    /// Makes the request.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was made.
    #[inline]
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe {
    /// As in [`Engine::develop`].
    pub radiance: Rgb,
    /// As in [`Engine::radius`]; 0 without photons.
    pub radius: f32,
    /// As in [`Engine::count`]; 0 without photons.
    pub count: f32,
}

/// An engine whose render can be stopped within an iteration, saved and taken up again.
pub trait Resumable: Engine + Sync {
    /// What was asked for.
    fn settings(&self) -> &Settings;

    /// What it keeps of a pixel.
    fn sums(&self) -> Sums;

    /// Copies the words of row `y`, pixel by pixel from the left, into `words`.
    ///
    /// # Panics
    /// If there is no such row, or `words` is not as long as a row.
    fn save_row(&self, y: u32, words: &mut [u32]);

    /// The reverse of [`Self::save_row`].
    ///
    /// # Panics
    /// Like that.
    fn load_row(&mut self, y: u32, words: &[u32]);

    /// What the pixel in column `x` and row `y` shows as it stands, for images that are written without being held.
    ///
    /// # Panics
    /// If there is no such pixel.
    fn probe(&self, x: u32, y: u32) -> Probe;

    /// Goes on as if `iterations` iterations had been run and `stats` were their account; their sums are loaded by
    /// [`Self::load_row`].
    fn go_on_after(&mut self, iterations: u32, stats: Stats);

    /// Runs a whole iteration, or abandons it soon after `stop` is requested. True if it was run: what was abandoned
    /// leaves no trace.
    #[must_use]
    fn iterate_unless(&mut self, stop: &Stop) -> bool;
}

/// Copies all words of a render from one engine to another of the same kind and size.
///
/// # Panics
/// If they are not of the same kind and size.
pub fn transfer(from: &dyn Resumable, to: &mut dyn Resumable) {
    let (width, height) = size(from);
    assert!(from.sums() == to.sums() && size(to) == (width, height), "engines of different renders");
    let mut words = vec![0; width as usize * from.sums().words()];
    for y in 0..height {
        from.save_row(y, &mut words);
        to.load_row(y, &words);
    }
    to.go_on_after(from.iterations(), *from.stats());
}

fn size(engine: &dyn Resumable) -> (u32, u32) {
    let settings = engine.settings();
    (settings.width, settings.height)
}

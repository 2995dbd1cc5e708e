//! The state of a render between two iterations, in a form that every engine can save and load.
//!
//! From one iteration to the next an engine keeps a few words per pixel: see [`Sums`]. They do not depend on engine,
//! lanes or threads. So one engine can resume a render that another began, and the image is the same as that of a
//! render without a pause.

use crate::color::Rgb;
use crate::engine::{Engine, Stats};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The version of the light transport, raised whenever a scene with its settings and seed gets another image. Iterations
/// of two versions are never added up.
///
/// 2: shadow rays choose their light by what it may send to the point. 3: photons are aimed.
pub const TRANSPORT: u32 = 3;

/// The meaning of a pixel's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sums {
    /// Photon mapping: the eight words of [`PhotonSums`].
    Photons,
    /// Path tracing: the radiance of red, green and blue, each summed over all iterations, as the bits of three `f64`,
    /// lower word first.
    Paths,
}

impl Sums {
    /// Finds words that no engine could have written: an invalid count, or a radius that is invalid or has grown.
    /// Returns the end of an error message.
    pub fn fault(self, words: &[u32], initial_radius: f32) -> Option<&'static str> {
        let (Self::Photons, Ok(words)) = (self, words.try_into()) else {
            return None;
        };
        let PhotonSums { n, radius_squared, .. } = PhotonSums::from_words(words);
        if !(n >= 0.0 && n.is_finite()) {
            return Some("has a pixel whose count of photons is none");
        }
        let is_radius = radius_squared > 0.0 && radius_squared <= initial_radius * initial_radius;
        (!is_radius).then_some("has a pixel whose radius is none, or larger than the first")
    }

    /// Words per pixel.
    pub fn words(self) -> usize {
        match self {
            Self::Photons => PhotonSums::WORDS,
            Self::Paths => 6,
        }
    }
}

/// The state of a pixel in photon mapping, from one iteration to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonSums {
    /// Direct light, including that of visible lamps, summed over all iterations: radiance times iterations.
    pub direct: Rgb,
    /// `tau`, the flux gathered so far, scaled down as the radius shrinks.
    pub tau: Rgb,
    /// `N`, the photons counted so far, weighted by alpha.
    pub n: f32,
    /// The squared search radius, in square scene units.
    pub radius_squared: f32,
}

impl PhotonSums {
    /// Words per pixel.
    pub const WORDS: usize = 8;

    /// The bits of every number, in the order of the fields.
    pub fn to_words(self) -> [u32; Self::WORDS] {
        let ([dr, dg, db], [tr, tg, tb]) = (self.direct.to_array(), self.tau.to_array());
        [dr, dg, db, tr, tg, tb, self.n, self.radius_squared].map(f32::to_bits)
    }

    /// The inverse of [`Self::to_words`].
    pub fn from_words(words: [u32; Self::WORDS]) -> Self {
        let [dr, dg, db, tr, tg, tb, n, radius_squared] = words.map(f32::from_bits);
        Self { direct: Rgb::new(dr, dg, db), tau: Rgb::new(tr, tg, tb), n, radius_squared }
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

/// An engine whose render can be saved and resumed.
pub trait Resumable: Engine + Send + Sync {
    /// The kind of words that it keeps per pixel.
    fn sums(&self) -> Sums;

    /// Copies the words of row `y`, pixel by pixel from the left, into `words`.
    ///
    /// # Panics
    /// If there is no such row, or `words` is not as long as a row.
    fn save_row(&self, y: u32, words: &mut [u32]);

    /// Loads words that [`Self::save_row`] copied.
    ///
    /// # Panics
    /// As [`Self::save_row`].
    fn load_row(&mut self, y: u32, words: &[u32]);

    /// Sets the number of iterations done and their statistics, after the sums have been loaded by [`Self::load_row`].
    fn go_on_after(&mut self, iterations: u32, stats: Stats);
}

/// Copies the state of a render from one engine to another of the same kind and size.
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

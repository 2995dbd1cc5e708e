//! A render between two iterations, as numbers that any engine can take up.
//!
//! What an engine keeps from one iteration to the next is, for every pixel, a few words: see [`Sums`]. They are the
//! same whichever engine, lanes or threads computed them, so a render that one engine began another may go on with,
//! and the image is the one of a render that never stopped.

use crate::color::Rgb;
use crate::engine::{Engine, Stats};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a pixel's words are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sums {
    /// Of photon mapping: the eight words of [`PhotonSums`].
    Photons,
    /// Of path tracing: the sums of radiance r g b over all iterations, three `f64` by their bits, of each the lower
    /// word first.
    Paths,
}

impl Sums {
    /// What is wrong with the words of a pixel that no engine leaves so: an invalid count, or a radius that is invalid
    /// or has grown.
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

/// What photon mapping keeps of a pixel from one iteration to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonSums {
    /// The sum of direct light over all iterations, lamps seen among it: radiance times iterations.
    pub direct: Rgb,
    /// `tau`, the flux that counts, scaled with the radius as that shrinks.
    pub tau: Rgb,
    /// `N`, the photons that counted, each past iteration's weighted by alpha.
    pub n: f32,
    /// The squared search radius, in square scene units.
    pub radius_squared: f32,
}

impl PhotonSums {
    /// Words of a pixel.
    pub const WORDS: usize = 8;

    /// Every number by its bits, in the order of the fields.
    pub fn to_words(self) -> [u32; Self::WORDS] {
        let ([dr, dg, db], [tr, tg, tb]) = (self.direct.to_array(), self.tau.to_array());
        [dr, dg, db, tr, tg, tb, self.n, self.radius_squared].map(f32::to_bits)
    }

    /// The reverse of [`Self::to_words`].
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

/// An engine whose render can be saved and taken up again.
pub trait Resumable: Engine + Send + Sync {
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

    /// Goes on as if `iterations` iterations had been run and `stats` were their account; their sums are loaded by
    /// [`Self::load_row`].
    fn go_on_after(&mut self, iterations: u32, stats: Stats);
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

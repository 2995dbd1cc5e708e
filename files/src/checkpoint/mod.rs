//! Checkpoints: a render between two iterations as a file, from which any engine goes on.
//!
//! A file is a header and sections, all numbers little-endian:
//!
//! | bytes | header |
//! |---|---|
//! | 8 | `89 53 50 50 4d 0d 0a 1a`, which a transfer as text would break |
//! | 4 | version of the format, [`FORMAT`] |
//! | 8 | length of the file |
//! | 4 | CRC-32 of the 20 bytes before |
//!
//! | bytes | section |
//! |---|---|
//! | 4 | name |
//! | 8 | length of the content |
//! | | content |
//! | 4 | CRC-32 of name, length and content |
//!
//! The sections, in this order:
//!
//! | name | content |
//! |---|---|
//! | `SCEN` | the scene file ([`crate::scene_file::to_text`]), whose settings are those of the render |
//! | `RNDR` | a JSON object, see [`Account`] |
//! | `NOTE` | a text of the program that renders: where its outputs go |
//! | `SUMS` | the words of every pixel ([`scene::Sums`]), row by row from the top, 4 bytes each |
//! | `PAST` | only if it is asked for: an earlier image, `u32` iterations and 3 `f32` per pixel |
//!
//! Readers check every length against that of the file before they hold any memory for it, and every checksum before
//! they believe anything.

mod damage;
mod read;
mod sections;
mod store;
#[cfg(test)]
mod tests;
mod write;

pub use damage::Damage;
pub use read::Checkpoint;
pub use store::{Loaded, Lock, Store};
pub use write::{Contents, length, write};

use scene::{Film, Stats, Sums};
use serde::{Deserialize, Serialize};

/// The version of the format that is written, and the only one that is read.
pub const FORMAT: u32 = 1;

/// What a render has done: section `RNDR`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Account {
    /// Of the program that wrote it.
    pub version: String,
    /// Of the scene, as [`crate::scene_file::digest`].
    pub scene: String,
    /// What the sums are.
    pub sums: Sums,
    /// Whole iterations that the sums hold.
    pub iterations: u32,
    /// Counted work and seconds so far.
    pub stats: Stats,
}

/// An image that the render was at an earlier iteration: section `PAST`.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    /// Which iteration.
    pub iterations: u32,
    /// The image then.
    pub film: Film,
}

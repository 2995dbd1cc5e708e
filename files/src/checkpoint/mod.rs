//! Checkpoints: the state of a render between two iterations, in a file from which any engine of the same algorithm
//! can resume it.
//!
//! A file is a header followed by sections. All numbers are little-endian.
//!
//! | bytes | header |
//! |---|---|
//! | 8 | magic number `89 53 50 50 4d 0d 0a 1a`, chosen so that a transfer in text mode would alter it |
//! | 4 | format version, [`FORMAT`] |
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
//! | `SCEN` | the scene file with the settings of the render, without materials and spheres |
//! | `MATL` | 5 words per material: kind (0 diffuse, 1 specular, 2 dielectric), albedo, index of refraction |
//! | `BALL` | 5 words per sphere: centre, radius, index of its material |
//! | `GLOW` | 4 words per sphere that emits: its index, its emission |
//! | `MOVE` | 4 words per sphere that moves: its index, its velocity |
//! | `RNDR` | a JSON object, see [`Account`] |
//! | `NOTE` | free text for the program that renders, such as the paths of its outputs |
//! | `SUMS` | the words of every pixel ([`scene::Sums`]), row by row from the top, 4 bytes each |
//! | `PAST` | optional: an earlier image, as `u32` iterations and 3 `f32` per pixel |
//!
//! Version 2 is as this, but without sums of [`scene::Sums::Exact`] and without [`Account::which`].
//!
//! Words are `u32` or `f32` of 4 bytes. In files of version 1 `SCEN` is the whole scene file, and the four sections after it
//! are absent. Such files can be described, but not resumed: all are from before version 2 of the light transport
//! ([`scene::TRANSPORT`]).
//!
//! Readers check every length against the length of the file before they allocate memory for it, and check a section's
//! checksum before they use its content.

mod account;
mod arrays;
mod damage;
mod read;
mod sections;
mod store;
#[cfg(test)]
mod tests;
mod write;

pub use account::{Account, FORMAT, Past};
pub use damage::Damage;
pub use read::Checkpoint;
pub use store::{Loaded, Store};
pub use write::{Contents, length, write};

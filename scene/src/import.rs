//! Spheres that a scene takes from a file of particles.

use std::ops::Range;
use std::path::PathBuf;

/// Spheres of a scene that were made of a file of particles. Scene files, checkpoints and images name the file instead of
/// the spheres. A program that changes such spheres must remove the import: then they are written out one by one.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// The file, as it was opened.
    pub file: PathBuf,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub digest: String,
    /// How spheres were made of it: the rest of its table `[[particles]]` in a scene file, in TOML.
    pub table: String,
    /// The spheres.
    pub spheres: Range<usize>,
    /// Their materials, which no other sphere has.
    pub materials: Range<usize>,
}

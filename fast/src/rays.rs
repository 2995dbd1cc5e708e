//! The rays of a batch, as a search reads them.

use crate::paths::{ROOM, Vectors, Words};
use scene::ray::NO_SPHERE;

/// The rays of a batch.
pub(crate) struct Rays<'a> {
    pub(crate) origin: &'a Vectors,
    pub(crate) direction: &'a Vectors,
    /// The sphere that each ray leaves.
    pub(crate) leaves: &'a Words,
    /// A sphere that each ray ignores, such as the lamp that a shadow ray aims at; or [`NO_SPHERE`].
    pub(crate) ignores: &'a Words,
    pub(crate) count: usize,
}

/// For rays that ignore nothing.
pub(crate) static IGNORES_NONE: Words = [NO_SPHERE; ROOM];

/// The distance of a shadow ray that is blocked.
pub(crate) const BLOCKED: f32 = f32::NEG_INFINITY;

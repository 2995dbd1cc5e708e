//! The rays of a batch, as a search reads them.

use crate::paths::{ROOM, Vectors, Words};
use scene::ray::{NO_SPHERE, SphereId};

/// The rays of a batch.
pub(crate) struct Rays<'a> {
    pub(crate) origin: &'a Vectors,
    pub(crate) direction: &'a Vectors,
    /// The sphere that each ray leaves.
    pub(crate) leaves: &'a Words,
    /// A sphere that each ray ignores, such as the lamp that a shadow ray aims at; or [`NO_SPHERE`].
    pub(crate) ignores: &'a Words,
    pub(crate) count: usize,
    /// True if they are likely to run close together.
    pub(crate) are_close: bool,
}

impl Rays<'_> {
    /// The sphere that all of them ignore, if there is one: the only lamp of a scene.
    #[inline(always)]
    pub(crate) fn ignored_by_all(&self) -> Option<SphereId> {
        let sphere = self.ignores[0];
        let mut are_same = sphere != NO_SPHERE;
        for ignored in &self.ignores[..self.count] {
            are_same &= *ignored == sphere;
        }
        are_same.then_some(sphere)
    }
}

/// For rays that ignore nothing.
pub(crate) static IGNORES_NONE: Words = [NO_SPHERE; ROOM];

/// The distance of a shadow ray that is blocked.
pub(crate) const BLOCKED: f32 = f32::NEG_INFINITY;

//! The trait of all spatial indices.

use super::tuning::Tuning;
use crate::pixels::Pixels;
use crate::vector::Vector;
use lanes::Lanes;
use scene::Vec3;
use scene::ray::SphereId;

/// Search radii are widened by this factor, because the distance test rounds (see `reference::grid`).
pub(crate) const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

/// A spatial index.
pub(crate) trait Index {
    /// The candidates of a lookup that are still to be read.
    type Cursor<'a>
    where
        Self: 'a;

    /// An empty index for this number of pixels.
    fn new(pixels: usize, tuning: &Tuning) -> Self;

    /// Enters the visible points of `count` pixels, replacing those of the previous iteration.
    fn build<V: Vector, P: Pixels>(&mut self, pixels: &P, count: usize);

    /// Looks up the visible points whose radius may contain `point`.
    fn open(&self, point: Vec3) -> Self::Cursor<'_>;

    /// The next candidates, one per lane, and which lanes hold one.
    fn next<L: Lanes>(cursor: &mut Self::Cursor<'_>) -> Option<(L::U, L::M)>;

    /// The sphere that all of the last candidates lie on, if the index sorts points by sphere.
    #[inline(always)]
    fn shared_sphere(_: &Self::Cursor<'_>) -> Option<SphereId> {
        None
    }

    /// Bytes held.
    fn bytes(&self) -> usize;
}

//! What every spatial index can do.

use super::tuning::Tuning;
use crate::pixels::Pixels;
use crate::vector::Vector;
use lanes::Lanes;
use scene::Vec3;
use scene::ray::SphereId;

/// The sphere of search is widened by so much, as the test of the distance rounds (see `reference::grid`).
pub(crate) const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

/// A spatial index.
pub(crate) trait Index {
    /// The candidates of a place that are still to come.
    type Cursor<'a>
    where
        Self: 'a;

    /// For so many pixels; nothing is in it.
    fn new(pixels: usize, tuning: &Tuning) -> Self;

    /// Enters the visible points of `count` pixels, in place of those of the iteration before.
    fn build<V: Vector, P: Pixels>(&mut self, pixels: &P, count: usize);

    /// Looks up what may lie within reach of a point.
    fn open(&self, point: Vec3) -> Self::Cursor<'_>;

    /// The next candidates, as many as there are lanes, and which lanes hold one.
    fn next<L: Lanes>(cursor: &mut Self::Cursor<'_>) -> Option<(L::U, L::M)>;

    /// The sphere that the last candidates lie on, if the index sees to it that it is one.
    #[inline(always)]
    fn shared_sphere(_: &Self::Cursor<'_>) -> Option<SphereId> {
        None
    }

    /// Bytes held.
    fn bytes(&self) -> usize;
}

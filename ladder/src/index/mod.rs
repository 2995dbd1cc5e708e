//! Spatial indices over visible points: which of them may a photon reach?
//!
//! Every index may offer more candidates than are in reach, but each of these exactly once; whoever asks tests the
//! distance. So all of them give the same `M`.

mod bins;
mod grid;
mod kdtree;
mod partitioned;

pub(crate) use bins::{ByteBins, LinkedBins, TypedBins};
pub(crate) use grid::HashGrid;
pub(crate) use kdtree::{Kiddo, Tree};
pub(crate) use partitioned::{ByBlock, BySphere, Partitioned};

use crate::pixels::Pixels;
use crate::vector::Vector;
use lanes::Lanes;
use scene::Vec3;
use scene::ray::SphereId;

/// The sphere of search is widened by so much, as the test of the distance rounds (see `reference::grid`).
const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

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

/// What an index leaves open to tuning. The image does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Size of the grid's cells over the largest radius.
    pub cell_size: f32,
    /// Room that a growable bin is given at first, in entries.
    pub first_capacity: usize,
    /// Pixels of a block of the blocked table.
    pub block: usize,
}

impl Tuning {
    /// The published program's cells and bins; blocks of which lines and sums take 192 KiB.
    pub const PAPER: Self = Self { cell_size: 2.0, first_capacity: 20, block: 4096 };
}

//! Spatial indices that find the visible points near a photon.
//!
//! An index may return more candidates than are within reach, but it returns every point within reach exactly once. The
//! caller tests the distance. So all indices give the same photon count `M`.

mod bins;
mod grid;
mod kdtree;
mod lookup;
mod partitioned;
mod tuning;

pub(crate) use bins::{ByteBins, LinkedBins, TypedBins};
pub(crate) use grid::HashGrid;
pub(crate) use kdtree::{Kiddo, Tree};
pub(crate) use lookup::Index;
pub(crate) use partitioned::{ByBlock, BySphere, Partitioned};
pub use tuning::Tuning;

//! Spatial indices over visible points: which of them may a photon reach?
//!
//! Every index may offer more candidates than are in reach, but each of these exactly once; whoever asks tests the
//! distance. So all of them give the same `M`.

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

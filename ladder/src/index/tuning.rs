//! The free parameters of indices.

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

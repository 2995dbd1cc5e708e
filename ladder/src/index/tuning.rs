//! The free parameters of the spatial indices.

/// The free parameters of an index. The image does not depend on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Size of the grid's cells, in units of the largest radius.
    pub cell_size: f32,
    /// Initial capacity of a growable bin, in entries.
    pub first_capacity: usize,
    /// Pixels of a block of the blocked table.
    pub block: usize,
}

impl Tuning {
    /// The cells and bins of the published program, and blocks whose lines and sums take 192 KiB.
    pub const PAPER: Self = Self { cell_size: 2.0, first_capacity: 20, block: 4096 };
}

//! The pixels' filter in lanes, as `scene::filter::Table`.

use lanes::Lanes;
use scene::filter::{Filter, PIECES, Table};

/// The table of a filter, as words to gather from.
pub(super) struct PixelFilter {
    begins: Vec<u32>,
    lengths: Vec<u32>,
    weights: Vec<u32>,
}

impl PixelFilter {
    /// `None` for the box.
    pub(super) fn new(filter: Filter) -> Option<Self> {
        let bits = |floats: &[f32]| floats.iter().map(|x| x.to_bits()).collect();
        let words = |table: &Table| Self {
            begins: bits(&table.begins),
            lengths: bits(&table.lengths),
            weights: bits(&table.weights),
        };
        filter.table().map(words)
    }

    /// As `scene::filter::Table::place`, along both axes: the place in the pixel, and what a sample there counts.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, [u, v]: [L::F; 2]) -> ([L::F; 2], L::F) {
        let ((x, weight_x), (y, weight_y)) = (self.along::<L>(u), self.along::<L>(v));
        ([x, y], weight_x * weight_y)
    }

    #[inline(always)]
    fn along<L: Lanes>(&self, u: L::F) -> (L::F, L::F) {
        let scaled = u * L::f(PIECES as f32);
        let piece = L::truncate(scaled);
        let read = |table: &[u32]| L::from_bits(L::gather_u(table, piece));
        let place = read(&self.begins) + (scaled - L::to_float(piece)) * read(&self.lengths);
        (place, read(&self.weights))
    }
}

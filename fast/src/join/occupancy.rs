//! Where visible points are: a bit per bucket of coarse cells, by which most photons that nobody sees are dropped.

use super::cells::{Bounds, Cells};
use crate::lanes::Lanes;
use crate::vec3::V3;

/// The occupancy of space by visible points.
pub(crate) struct Occupancy {
    cells: Cells,
    words: Vec<u32>,
}

impl Occupancy {
    /// An empty map of cells of the given size, of so many bits, a power of two.
    pub(crate) fn new(size: f32, bits: u32) -> Self {
        Self { cells: Cells::new(size, bits as usize), words: vec![0; bits as usize / 32] }
    }

    /// Marks the cells within reach of a box, if they fit into a window; else does nothing and gives false.
    #[inline(always)]
    pub(crate) fn mark<L: Lanes>(&mut self, bounds: &Bounds) -> bool {
        let span = self.cells.span(bounds);
        if !span.fits() {
            return false;
        }
        let query = self.cells.query::<L>(span, bounds);
        for z in query.slabs() {
            let mut rows = query.rows(z);
            while let Some(run) = rows.next() {
                for i in 0..run.length {
                    let bucket = run.bucket.wrapping_add(i) & self.cells.mask;
                    self.words[(bucket / 32) as usize] |= 1 << (bucket % 32);
                }
            }
        }
        true
    }

    /// Marks all cells.
    pub(crate) fn mark_all(&mut self) {
        self.words.fill(u32::MAX);
    }

    /// Takes over the marks of another map of the same cells.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (word, theirs) in self.words.iter_mut().zip(&other.words) {
            *word |= theirs;
        }
    }

    /// The lanes whose point lies in a marked cell.
    #[inline(always)]
    pub(crate) fn touches<L: Lanes>(&self, p: V3<L>) -> L::M {
        let bucket = self.cells.buckets::<L>(p);
        let words = L::gather_u(&self.words, L::shr::<5>(bucket));
        let mut bits = [0; crate::lanes::MOST_LANES];
        let mut chosen = [0; crate::lanes::MOST_LANES];
        L::store_u(bucket, &mut bits);
        L::store_u(words, &mut chosen);
        let mut mask = 0;
        for lane in 0..L::N {
            mask |= ((chosen[lane] >> (bits[lane] & 31)) & 1) << lane;
        }
        L::mask_from_bits(mask)
    }
}

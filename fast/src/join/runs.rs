//! Looking up the photons of a query, or near a single point.

use super::cells::{NearPoints, Query, Run, WINDOW};
use super::sorted::Deposits;
use lanes::Lanes;
use std::ops::Range;

/// The photons of a query, as ranges of the sorted deposits.
pub(crate) struct Runs {
    /// Rows that have photons, and how many these are, while they are looked up.
    filled: [Run; Self::MOST],
    filled_count: usize,
    ranges: [(u32, u32); Self::MOST],
    count: usize,
}

impl Runs {
    /// Each row of cells is one range, but one row may wrap around the table and is two. It is one row at most, as rows of
    /// a window share no bucket.
    const MOST: usize = (WINDOW * WINDOW) as usize + 1;

    pub(crate) fn new() -> Self {
        Self { filled: [Run::default(); Self::MOST], filled_count: 0, ranges: [(0, 0); Self::MOST], count: 0 }
    }

    /// Looks up a query: first which rows have photons, then where these are. Each is asked for from memory as soon as it is
    /// known, so that it arrives while the other rows are looked up.
    #[inline(always)]
    pub(crate) fn look_up<L: Lanes>(&mut self, deposits: &Deposits, query: &Query<L>) {
        self.list(deposits, query);
        self.locate(deposits);
    }

    /// The first half of [`Self::look_up`]: which rows have photons?
    #[inline(always)]
    pub(crate) fn list<L: Lanes>(&mut self, deposits: &Deposits, query: &Query<L>) {
        let mut filled = 0;
        for z in query.slabs() {
            let mut rows = query.rows(z);
            while let Some(row) = rows.next() {
                if !deposits.is_empty(row) {
                    deposits.prefetch_start(row);
                    self.filled[filled] = row;
                    filled += 1;
                }
            }
        }
        self.filled_count = filled;
    }

    /// The same for the point in a lane.
    #[inline(always)]
    pub(crate) fn list_near(&mut self, deposits: &Deposits, near: &NearPoints, lane: usize) {
        let mut filled = 0;
        for number in 0..NearPoints::ROWS {
            if let Some(row) = near.row(number, lane)
                && !deposits.is_empty(row)
            {
                deposits.prefetch_start(row);
                self.filled[filled] = row;
                filled += 1;
            }
        }
        self.filled_count = filled;
    }

    /// The second half: where are they?
    #[inline(always)]
    pub(crate) fn locate(&mut self, deposits: &Deposits) {
        self.count = 0;
        for row in &self.filled[..self.filled_count] {
            for Range { start, end } in deposits.photons(*row) {
                if start < end {
                    deposits.prefetch_points(start);
                    self.ranges[self.count] = (start as u32, end as u32);
                    self.count += 1;
                }
            }
        }
    }

    /// The number of ranges.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Range number `k`.
    #[inline(always)]
    pub(crate) fn range(&self, k: usize) -> Range<usize> {
        self.ranges[k].0 as usize..self.ranges[k].1 as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::join::bins::{Binned, bin_shift};
    use crate::join::cells::Cells;
    use crate::join::chunk::Slabs;
    use crate::join::deposit::Record;
    use crate::join::region::Region;
    use crate::join::sorted::Sorted;
    use lanes::Emulated;
    use scene::Vec3;
    use std::sync::Arc;

    /// Nothing that is found may be lost for want of room.
    #[test]
    fn the_runs_of_a_full_window_have_room() {
        let (cells, wide) = (Cells::new(1.0, 1 << 12), WINDOW as f32);
        let pool = Arc::new(Slabs::new());
        let mut binned = Binned::new(&pool);
        for bucket in 0..=cells.mask {
            let record = Record { bucket, ..Record::default() };
            binned.writer(1).push(record, [0.0; 4], bin_shift(cells));
        }
        let mut sorted = Sorted::new();
        sorted.fill(&mut [&mut binned], &pool, cells);
        let chunks = sorted.chunks();
        let deposits = sorted.deposits(&chunks);
        let (mut runs, mut most) = (Runs::new(), 0);
        for x in (0..=cells.mask).step_by(WINDOW as usize - 1) {
            // All but the outermost thousandth of a window of cells.
            let low = Vec3::new(x as f32, 0.0, 0.0) + 1e-3;
            let region = Region { low, high: low + wide - 2e-3, reach: 1e-4 };
            let span = cells.span(&region);
            assert!(span.fits());
            runs.look_up(&deposits, &cells.query::<Emulated>(span, &region));
            let ranges = (0..runs.count).map(|k| runs.range(k));
            let pieces = ranges.flat_map(|range| deposits.pieces(range));
            let found: usize = pieces.map(|piece| piece.indices.len()).sum();
            assert_eq!(found, (WINDOW * WINDOW * WINDOW) as usize);
            most = most.max(runs.count);
        }
        assert_eq!(most, Runs::MOST, "no row that wraps around the table was looked up");
    }
}

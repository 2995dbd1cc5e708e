//! Occupancy: which cells do visible points reach? Photons that land in other cells are dropped.

use super::cells::{Cells, NearPoints, Run};
use super::region::{ReachLanes, Region};
use crate::pixels::{GROUP, PixelRow, TILE};
use lanes::{Lanes, V3};

/// A bit per bucket of coarse cells, set if some visible point reaches the cell.
pub(crate) struct Occupancy {
    cells: Cells,
    words: Vec<u32>,
}

impl Occupancy {
    /// An empty map of cells of the given size, with so many bits, a power of two.
    pub(crate) fn new(size: f32, bits: u32) -> Self {
        Self { cells: Cells::new(size, bits as usize), words: vec![0; bits as usize / 32] }
    }

    /// Marks the cells within reach of a region. If they do not fit into a window, marks none and returns false.
    #[inline(always)]
    pub(crate) fn mark<L: Lanes>(&mut self, region: &Region) -> bool {
        let span = self.cells.span(region);
        if !span.fits() {
            return false;
        }
        let query = self.cells.query::<L>(span, region);
        for z in query.slabs() {
            let mut rows = query.rows(z);
            while let Some(run) = rows.next() {
                self.mark_run(run);
            }
        }
        true
    }

    /// Marks a row of cells. It has as many bits as a window cells, so it ends in the same word or in the next.
    #[inline(always)]
    fn mark_run(&mut self, run: Run) {
        let bits = ((1_u64 << run.length) - 1) << (run.bucket % u32::BITS);
        let (word, last) = ((run.bucket / u32::BITS) as usize, self.words.len() - 1);
        self.words[word & last] |= bits as u32;
        self.words[(word + 1) & last] |= (bits >> u32::BITS) as u32;
    }

    /// Marks the cells that the visible points of a tile reach: at once, if they fit into a window, or else by groups. What
    /// lies between groups of a tile is mostly within reach of some.
    #[inline(always)]
    pub(crate) fn mark_tile<L: Lanes>(&mut self, rows: &[PixelRow]) {
        let (mut groups, mut all) = ([Region::EMPTY; TILE / GROUP], Region::EMPTY);
        for (region, rows) in groups.iter_mut().zip(rows.chunks(GROUP)) {
            *region = Region::of_all(rows);
            all = all.and(region);
        }
        if all.is_empty() || self.mark::<L>(&all) {
            return;
        }
        for (region, rows) in groups.iter().zip(rows.chunks(GROUP)) {
            if !region.is_empty() && !self.mark::<L>(region) {
                self.mark_apart::<L>(rows);
            }
        }
    }

    /// Marks the cells that each visible point of a group reaches.
    #[inline(always)]
    fn mark_apart<L: Lanes>(&mut self, rows: &[PixelRow]) {
        for rows in rows.chunks(L::N) {
            let points = ReachLanes::<L>::load(rows);
            let Some(near) = self.cells.near_points::<L>(points.point, points.reach, points.are_there) else {
                self.mark_one_by_one::<L>(rows);
                continue;
            };
            for number in 0..NearPoints::ROWS {
                for lane in 0..L::N {
                    if let Some(run) = near.row(number, lane) {
                        self.mark_run(run);
                    }
                }
            }
        }
    }

    /// The same whatever the number of cells.
    fn mark_one_by_one<L: Lanes>(&mut self, rows: &[PixelRow]) {
        for row in rows {
            if let Some(one) = Region::of_one(row)
                && !self.mark::<L>(&one)
            {
                self.mark_all();
            }
        }
    }

    /// Marks all cells.
    fn mark_all(&mut self) {
        self.words.fill(u32::MAX);
    }

    /// Adds the marks of another map of the same cells.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (word, theirs) in self.words.iter_mut().zip(&other.words) {
            *word |= theirs;
        }
    }

    /// The lanes whose point is in a marked cell.
    #[inline(always)]
    pub(crate) fn touches<L: Lanes>(&self, p: V3<L>) -> L::M {
        let bucket = self.cells.buckets::<L>(p);
        let words = L::gather_u(&self.words, L::shr::<5>(bucket));
        let one = L::u(1);
        L::eq(L::shr_by(words, bucket & L::u(u32::BITS - 1)) & one, one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lanes::Emulated;

    type L8 = Emulated<8>;

    /// Marks what one visible point reaches among cells of size 1. Returns whether a place near its reach, and one far away, are
    /// marked.
    fn marked<L: Lanes>(radius: f32) -> [bool; 2] {
        let mut occupancy = Occupancy::new(1.0, 1 << 19);
        let mut rows = [PixelRow::NOTHING; TILE];
        (rows[0].sphere, rows[0].point, rows[0].radius_squared) = (0, [0.5; 3], radius * radius);
        occupancy.mark_tile::<L>(&rows);
        let is_marked = |x: f32| L::any(occupancy.touches::<L>(V3::new(L::f(x), L::f(0.5), L::f(0.5))));
        [is_marked(0.5 + 0.99 * radius), is_marked(5000.5)]
    }

    /// What lies between groups that are far apart is not marked.
    #[test]
    fn tiles_are_marked_at_once_or_by_groups() {
        let is_marked = |apart: f32, x: f32| {
            let mut occupancy = Occupancy::new(1.0, 1 << 19);
            let mut rows = [PixelRow::NOTHING; TILE];
            for (number, group) in rows.chunks_mut(GROUP).enumerate() {
                (group[3].sphere, group[3].radius_squared) = (0, 0.25);
                group[3].point = [0.5 + number as f32 * apart, 0.5, 0.5];
            }
            occupancy.mark_tile::<Emulated<8>>(&rows);
            L8::any(occupancy.touches::<Emulated<8>>(V3::new(L8::f(x), L8::f(0.5), L8::f(0.5))))
        };
        for apart in [0.0_f32, 1.0, 2.0, 300.0] {
            let marked = [0.0, 1.0, 2.0, 3.0].map(|number| is_marked(apart, 0.5 + number * apart));
            assert_eq!(marked, [true; 4], "{apart} apart");
        }
        assert_eq!([2.0, 300.0].map(|apart| is_marked(apart, 0.5 + 1.5 * apart)), [true, false]);
    }

    /// Points of a group that are far apart: around each is marked what it reaches, and nothing between.
    #[test]
    fn points_far_apart_are_marked_each_by_itself() {
        for radius in [0.4_f32, 0.7, 1.5] {
            let mut occupancy = Occupancy::new(1.0, 1 << 19);
            let mut rows = [PixelRow::NOTHING; TILE];
            let place = |k: usize| [0.3 + 100.0 * k as f32, 0.6, 0.9];
            for (k, row) in rows.iter_mut().enumerate().take(GROUP).skip(1) {
                (row.sphere, row.point, row.radius_squared) = (0, place(k), radius * radius);
            }
            occupancy.mark_tile::<Emulated<8>>(&rows);
            let is_marked = |[x, y, z]: [f32; 3]| {
                L8::any(occupancy.touches::<Emulated<8>>(V3::new(L8::f(x), L8::f(y), L8::f(z))))
            };
            for k in 1..GROUP {
                let [x, y, z] = place(k);
                for way in [-0.99 * radius, 0.0, 0.99 * radius] {
                    assert!(
                        is_marked([x + way, y, z])
                            && is_marked([x, y + way, z])
                            && is_marked([x, y, z + way])
                    );
                }
                assert!(!is_marked([x + 50.0, y, z]));
            }
            assert!(!is_marked(place(0)));
        }
    }

    #[test]
    fn a_point_that_reaches_more_cells_than_a_window_has_marks_all() {
        assert_eq!(marked::<Emulated<8>>(1.0), [true, false]);
        assert_eq!(marked::<Emulated<8>>(3.0), [true, false]);
        assert_eq!(marked::<Emulated<8>>(40.0), [true, true]);
    }
}

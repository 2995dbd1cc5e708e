//! Cells: which bucket does a point of space fall into, and which buckets hold the points near a region?
//!
//! Space is cut into cubic cells. Cell (x, y, z) goes to bucket `x + y * stride_y + z * stride_z`, modulo the number of
//! buckets. So a row of cells along x is a run of buckets, and its photons, once sorted by bucket, are consecutive: one
//! look-up finds the photons of a row. The strides are chosen so that no two rows within any window of [`WINDOW`]^3 cells
//! share a bucket. A query that fits into the window meets no photon twice, although all of space is folded onto a small
//! table.

use super::region::Region;
use lanes::{Lanes, V3};
use scene::Vec3;

/// Cells along each axis of the window, within which buckets are distinct: the most that a query may span.
pub(crate) const WINDOW: u32 = 8;

/// Coordinates in cells are clamped to this, as integers would wrap around.
const FARTHEST: f32 = 1_073_741_824.0;

/// A map from points to buckets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells {
    inverse_size: f32,
    stride_y: u32,
    stride_z: u32,
    /// The number of buckets, a power of two, less one.
    pub(crate) mask: u32,
}

/// The number of buckets of a table for which `buckets` are asked.
pub(crate) fn table_size(buckets: usize) -> usize {
    buckets.next_power_of_two().clamp(1 << 12, 1 << 22)
}

/// A box of cells, both corners included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    low: [i32; 3],
    high: [i32; 3],
}

impl Cells {
    /// A map of cells of the given size onto at least `buckets` buckets.
    pub(crate) fn new(size: f32, buckets: usize) -> Self {
        let buckets = table_size(buckets) as u32;
        let mask = buckets - 1;
        // Odd numbers near irrational fractions of the table (fractional parts of the square roots of 5 and 2), whose
        // multiples are well apart: a test tries them in tables of every size.
        let stride_y = (f64::from(buckets) * 0.236_067_977) as u32 | 1;
        let stride_z = (f64::from(buckets) * 0.414_213_562) as u32 | 1;
        Self { inverse_size: 1.0 / size, stride_y, stride_z, mask }
    }

    #[inline(always)]
    fn coordinate(self, x: f32) -> i32 {
        let scaled = x * self.inverse_size;
        let below = if scaled < FARTHEST { scaled } else { FARTHEST };
        let within = if below > -FARTHEST { below } else { -FARTHEST };
        within.floor() as i32
    }

    #[inline(always)]
    fn coordinates<L: Lanes>(self, x: L::F) -> L::U {
        let (scaled, far) = (x * L::f(self.inverse_size), L::f(FARTHEST));
        L::truncate(L::floor(L::max(L::min(scaled, far), -far)))
    }

    /// The buckets of points in lanes.
    #[inline(always)]
    pub(crate) fn buckets<L: Lanes>(self, p: V3<L>) -> L::U {
        let (x, y, z) = (self.coordinates::<L>(p.x), self.coordinates::<L>(p.y), self.coordinates::<L>(p.z));
        (x + y * L::u(self.stride_y) + z * L::u(self.stride_z)) & L::u(self.mask)
    }

    /// The cells that may hold a point within reach of a region.
    #[inline(always)]
    pub(crate) fn span(self, region: &Region) -> Span {
        let (low, high) = (region.low - Vec3::splat(region.reach), region.high + Vec3::splat(region.reach));
        Span {
            low: [self.coordinate(low.x), self.coordinate(low.y), self.coordinate(low.z)],
            high: [self.coordinate(high.x), self.coordinate(high.y), self.coordinate(high.z)],
        }
    }

    /// The rows of a span that fits, without the cells that are out of reach of the region.
    #[inline(always)]
    pub(crate) fn query<L: Lanes>(self, span: Span, region: &Region) -> Query<L> {
        // Clamped like coordinates: what is beyond lies in the last cell.
        let farthest = Vec3::splat(FARTHEST);
        let [low, high] =
            [region.low, region.high].map(|corner| (corner * self.inverse_size).clamp(-farthest, farthest));
        // The reach in cells, and enough for rounding. Coordinates and corners of the box, in cells, and their differences
        // err by e = 2.4e-7 of the largest in sum. If the gaps along y and z are too large by that, and the one along x too
        // small by twice that, the sum of the three squares exceeds the square of a distance R by less than
        // 5 e R + 6 e^2, which is less than (R + 2.5 e)^2 - R^2.
        let rounding = 1e-3 + 1e-6 * low.abs().max(high.abs()).max_element();
        let reach = region.reach * self.inverse_size + rounding;
        let mut cells = [0.0; WINDOW as usize];
        for (y, cell) in (span.low[1]..).zip(&mut cells) {
            *cell = gap(y, low.y, high.y);
        }
        let gap_y = L::Eight::load(&cells);
        let y = L::Eight::iota() + L::Eight::u(span.low[1] as u32);
        Query {
            cells: self,
            span,
            low,
            high,
            reach,
            gap_y_squared: gap_y * gap_y,
            row_y: y * L::Eight::u(self.stride_y),
        }
    }
}

/// The rows of cells within reach of a region, a slab of equal z at a time.
pub(crate) struct Query<L: Lanes> {
    cells: Cells,
    span: Span,
    low: Vec3,
    high: Vec3,
    reach: f32,
    /// For up to [`WINDOW`] values of y: the squared distance from the box along y.
    gap_y_squared: <L::Eight as Lanes>::F,
    /// The part of the bucket that these values of y contribute.
    row_y: <L::Eight as Lanes>::U,
}

impl<L: Lanes> Query<L> {
    /// The values of z.
    #[inline(always)]
    pub(crate) fn slabs(&self) -> std::ops::RangeInclusive<i32> {
        self.span.low[2]..=self.span.high[2]
    }

    /// The rows of one z, as runs of buckets that may wrap around the table.
    #[inline(always)]
    pub(crate) fn rows(&self, z: i32) -> SlabRows {
        let gap_z = gap(z, self.low.z, self.high.z);
        let across = L::Eight::f(self.reach * self.reach - gap_z * gap_z) - self.gap_y_squared;
        let is_near = L::Eight::le(L::Eight::f(0.0), across);
        let along = L::Eight::sqrt(across);
        // The ends of a span are whole numbers that came from floats.
        let first = L::Eight::floor(L::Eight::f(self.low.x) - along);
        let first = L::Eight::max(first, L::Eight::f(self.span.low[0] as f32));
        let last = L::Eight::floor(L::Eight::f(self.high.x) + along);
        let last = L::Eight::min(last, L::Eight::f(self.span.high[0] as f32));
        let length = last - first + L::Eight::f(1.0);
        let in_span = L::Eight::first((self.span.high[1] - self.span.low[1] + 1) as usize);
        let is_row = is_near & in_span & L::Eight::lt(L::Eight::f(0.0), length);
        let row = self.row_y + L::Eight::u((z as u32).wrapping_mul(self.cells.stride_z));
        let bucket = (L::Eight::truncate(first) + row) & L::Eight::u(self.cells.mask);
        let mut rows = SlabRows { buckets: [0; _], lengths: [0; _], rest: L::Eight::mask_bits(is_row) };
        L::Eight::store_u(bucket, &mut rows.buckets);
        L::Eight::store_u(L::Eight::truncate(length), &mut rows.lengths);
        rows
    }
}

/// Consecutive buckets; the last bucket of the table is followed by the first.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Run {
    pub(crate) bucket: u32,
    pub(crate) length: u32,
}

/// The rows of a slab.
pub(crate) struct SlabRows {
    buckets: [u32; WINDOW as usize],
    lengths: [u32; WINDOW as usize],
    /// Bit k is set if row k has cells and is still to come.
    rest: u32,
}

impl SlabRows {
    /// The next row.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<Run> {
        if self.rest == 0 {
            return None;
        }
        let row = self.rest.trailing_zeros() as usize % WINDOW as usize;
        self.rest &= self.rest - 1;
        Some(Run { bucket: self.buckets[row], length: self.lengths[row] })
    }
}

impl Span {
    /// True if the span fits into a window.
    #[inline(always)]
    pub(crate) fn fits(self) -> bool {
        (0..3).all(|axis| i64::from(self.high[axis]) - i64::from(self.low[axis]) < i64::from(WINDOW))
    }
}

/// The distance from an interval to the cell that begins at `cell`, in cells.
#[inline(always)]
fn gap(cell: i32, low: f32, high: f32) -> f32 {
    let below = low - (cell as f32 + 1.0);
    let above = cell as f32 - high;
    below.max(above).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// A photon in a bucket that two rows share would count twice.
    #[test]
    fn no_two_cells_of_a_window_share_a_bucket() {
        let mut sizes = HashSet::new();
        for buckets in (0..24).map(|k| 1 << k) {
            let cells = Cells::new(1.0, buckets);
            sizes.insert(cells.mask);
            let window = 0..WINDOW;
            let buckets: HashSet<u32> = window
                .clone()
                .flat_map(|z| window.clone().flat_map(move |y| (0..WINDOW).map(move |x| (x, y, z))))
                .map(|(x, y, z)| {
                    (x + y.wrapping_mul(cells.stride_y)).wrapping_add(z.wrapping_mul(cells.stride_z))
                        & cells.mask
                })
                .collect();
            assert_eq!(buckets.len() as u32, WINDOW.pow(3), "{cells:?}");
        }
        assert_eq!(sizes.len(), 11);
    }
}

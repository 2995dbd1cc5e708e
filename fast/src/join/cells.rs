//! Which bucket a point of space falls into.
//!
//! Space is cut into cubic cells, and cell (x, y, z) goes to bucket `x + y * stride_y + z * stride_z`, modulo the
//! number of buckets. So a row of cells along x is a run of buckets, and the photons of a row, once sorted by bucket,
//! lie together: one look-up finds a whole row. The strides are chosen such that within any window of
//! [`WINDOW`]^3 cells no two rows share a bucket; so a query no larger than the window meets no photon twice, though
//! the whole of space is folded onto a small table.

use crate::lanes::Lanes;
use crate::vec3::V3;
use scene::Vec3;

/// Cells along each axis within which buckets are distinct, and the most that a query may span.
pub(crate) const WINDOW: u32 = 8;

/// Beyond so many cells from the origin, coordinates are clamped: an order that saturates, where integers would wrap.
const FARTHEST: f32 = 1_073_741_824.0;

/// A map from points to buckets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells {
    inverse_size: f32,
    stride_y: u32,
    stride_z: u32,
    /// Number of buckets less one; the number is a power of two.
    pub(crate) mask: u32,
}

/// The size of a table of at least `buckets` buckets, within reason.
pub(crate) fn table_size(buckets: usize) -> usize {
    buckets.next_power_of_two().clamp(1 << 12, 1 << 22)
}

/// The cells between two corners, both included.
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
        // Shares of the table whose multiples stay apart (square roots of small primes), odd: by them the rows of a
        // window are apart in a table of any size.
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
        let below = L::select(L::lt(scaled, far), scaled, far);
        let within = L::select(L::lt(-far, below), below, -far);
        L::truncate(L::floor(within))
    }

    /// The buckets of points in lanes.
    #[inline(always)]
    pub(crate) fn buckets<L: Lanes>(self, p: V3<L>) -> L::U {
        let (x, y, z) = (self.coordinates::<L>(p.x), self.coordinates::<L>(p.y), self.coordinates::<L>(p.z));
        (x + y * L::u(self.stride_y) + z * L::u(self.stride_z)) & L::u(self.mask)
    }

    /// The cells that may hold a point within `reach` of a box.
    #[inline(always)]
    pub(crate) fn span(self, bounds: &Bounds) -> Span {
        let (low, high) = (bounds.low - Vec3::splat(bounds.reach), bounds.high + Vec3::splat(bounds.reach));
        Span {
            low: [self.coordinate(low.x), self.coordinate(low.y), self.coordinate(low.z)],
            high: [self.coordinate(high.x), self.coordinate(high.y), self.coordinate(high.z)],
        }
    }

    /// The rows of a span that fits, without those cells that lie farther than `reach` from the box.
    #[inline(always)]
    pub(crate) fn query<L: Lanes>(self, span: Span, bounds: &Bounds) -> Query<L> {
        // Clamped as coordinates are: what is beyond lies in the last cell.
        let farthest = Vec3::splat(FARTHEST);
        let [low, high] =
            [bounds.low, bounds.high].map(|corner| (corner * self.inverse_size).clamp(-farthest, farthest));
        // What is within `reach` but for rounding is within this. Coordinates and ends of the box, in cells, and their
        // differences err by e = 2.4e-7 of the largest in sum. With gaps along y and z too large by that, and one along x
        // too small by twice that, the squares of the three exceed the square of a distance R by less than
        // 5 e R + 6 e^2: less than (R + 2.5 e)^2 - R^2.
        let rounding = 1e-3 + 1e-6 * low.abs().max(high.abs()).max_element();
        let reach = bounds.reach * self.inverse_size + rounding;
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

/// The rows of cells near a box, a slab of equal z at a time.
pub(crate) struct Query<L: Lanes> {
    cells: Cells,
    span: Span,
    low: Vec3,
    high: Vec3,
    reach: f32,
    /// For up to [`WINDOW`] values of y: the squared distance from the box along y.
    gap_y_squared: <L::Eight as Lanes>::F,
    /// The same values' part of the bucket.
    row_y: <L::Eight as Lanes>::U,
}

impl<L: Lanes> Query<L> {
    /// The values of z.
    #[inline(always)]
    pub(crate) fn slabs(&self) -> std::ops::RangeInclusive<i32> {
        self.span.low[2]..=self.span.high[2]
    }

    /// The rows of one z, as runs of buckets (in which the last bucket is followed by the first).
    #[inline(always)]
    pub(crate) fn rows(&self, z: i32) -> Rows {
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
        let mut rows = Rows { buckets: [0; _], lengths: [0; _], rest: L::Eight::mask_bits(is_row) };
        L::Eight::store_u(bucket, &mut rows.buckets);
        L::Eight::store_u(L::Eight::truncate(length), &mut rows.lengths);
        rows
    }
}

/// A box of points and the distance within which photons matter to them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
    pub(crate) reach: f32,
}

impl Bounds {
    /// The bounds of nothing.
    pub(crate) const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, reach: 0.0 };

    /// True of the bounds of nothing; else something is within reach.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.reach <= 0.0
    }

    /// The bounds of both, as far as either reaches.
    #[inline(always)]
    pub(crate) fn and(&self, other: &Self) -> Self {
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        Self { low, high, reach: self.reach.max(other.reach) }
    }
}

/// Consecutive buckets.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Run {
    pub(crate) bucket: u32,
    pub(crate) length: u32,
}

/// The rows of a slab.
pub(crate) struct Rows {
    buckets: [u32; WINDOW as usize],
    lengths: [u32; WINDOW as usize],
    /// Bit k: row k has cells.
    rest: u32,
}

impl Rows {
    /// The buckets of the next row.
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
    /// True if the span is within the window.
    #[inline(always)]
    pub(crate) fn fits(self) -> bool {
        (0..3).all(|axis| i64::from(self.high[axis]) - i64::from(self.low[axis]) < i64::from(WINDOW))
    }
}

/// Distance of the cell that begins at `cell` from an interval, in cells.
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

//! Cells: which bucket does a point of space fall into, and which buckets hold the points near a region?
//!
//! Space is cut into cubic cells. Cell (x, y, z) goes to bucket `x + y * stride_y + z * stride_z`, modulo the number of
//! buckets. So a row of cells along x is a run of buckets, and its photons, once sorted by bucket, are consecutive: one
//! look-up finds the photons of a row. The strides are chosen so that no two rows within any window of [`WINDOW`]^3 cells
//! share a bucket. A query that fits into the window meets no photon twice, although all of space is folded onto a small
//! table.

use super::region::Region;
use lanes::{Lanes, MOST_LANES, V3};
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

    /// Coordinates in cells.
    #[inline(always)]
    fn scaled<L: Lanes>(self, x: L::F) -> L::F {
        let far = L::f(FARTHEST);
        L::max(L::min(x * L::f(self.inverse_size), far), -far)
    }

    #[inline(always)]
    fn coordinates<L: Lanes>(self, x: L::F) -> L::U {
        L::truncate(L::floor(self.scaled::<L>(x)))
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

    /// The rows of cells that may hold a point within reach of points in lanes; `None` unless each of those that are `live` reaches
    /// at most two cells along each axis.
    #[inline(always)]
    pub(crate) fn near_points<L: Lanes>(self, p: V3<L>, reach: L::F, live: L::M) -> Option<NearPoints> {
        let [x, y, z] =
            [self.two_cells::<L>(p.x, reach), self.two_cells(p.y, reach), self.two_cells(p.z, reach)];
        let widest = L::max(L::max(x.high - x.low, y.high - y.low), z.high - z.low);
        if L::any(live & !L::le(widest, L::f(1.0))) {
            return None;
        }
        // With the same margin as `Self::query`.
        let farthest = L::max(L::max(L::abs(x.place), L::abs(y.place)), L::abs(z.place));
        let rounding = L::f(1e-3) + L::f(1e-6) * farthest;
        let reach = reach * L::f(self.inverse_size) + rounding;
        let mut near = NearPoints { buckets: [[0; _]; _], lengths: [[0; _]; _], are_near: [0; _] };
        let one = L::u(1);
        for number in 0..NearPoints::ROWS {
            let (is_high_y, is_high_z) = (number % 2 == 1, number / 2 == 1);
            let (y, gap_y, is_own_y) = y.cell(is_high_y);
            let (z, gap_z, is_own_z) = z.cell(is_high_z);
            let along = reach * reach - (gap_y + gap_z);
            let (low, high) = (L::le(x.gap_low, along), L::le(x.gap_high, along));
            let row = y * L::u(self.stride_y) + z * L::u(self.stride_z);
            let bucket = (L::truncate(L::select(low, x.low, x.high)) + row) & L::u(self.mask);
            let are_two = low & high & L::lt(x.low, x.high);
            L::store_u(bucket, &mut near.buckets[number]);
            L::store_u(L::add_where(are_two, one, one), &mut near.lengths[number]);
            near.are_near[number] = L::mask_bits(live & (low | high) & is_own_y & is_own_z);
        }
        Some(near)
    }

    /// The cells that points reach along an axis, at most two.
    #[inline(always)]
    fn two_cells<L: Lanes>(self, x: L::F, reach: L::F) -> TwoCells<L> {
        let place = self.scaled::<L>(x);
        let low = L::floor(self.scaled::<L>(x - reach));
        let high = L::floor(self.scaled::<L>(x + reach));
        let below = L::max(place - (low + L::f(1.0)), L::f(0.0));
        let above = L::max(high - place, L::f(0.0));
        TwoCells { place, low, high, gap_low: below * below, gap_high: above * above }
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

/// The cells that points in lanes reach along an axis, at most two.
struct TwoCells<L: Lanes> {
    /// The coordinate in cells.
    place: L::F,
    /// The lower cell, and the higher one if it is another.
    low: L::F,
    high: L::F,
    /// The squared distance to either, in cells.
    gap_low: L::F,
    gap_high: L::F,
}

impl<L: Lanes> TwoCells<L> {
    /// The lower or the higher cell: its number, the squared distance to it, and the lanes in which it is one of its own.
    #[inline(always)]
    fn cell(&self, is_high: bool) -> (L::U, L::F, L::M) {
        if is_high {
            (L::truncate(self.high), self.gap_high, L::lt(self.low, self.high))
        } else {
            (L::truncate(self.low), self.gap_low, L::first(L::N))
        }
    }
}

/// The rows of cells within reach of points in lanes, each of one cell or two.
pub(crate) struct NearPoints {
    buckets: [[u32; MOST_LANES]; Self::ROWS],
    lengths: [[u32; MOST_LANES]; Self::ROWS],
    /// A bit per lane, set if the point has the row.
    are_near: [u32; Self::ROWS],
}

impl NearPoints {
    /// The most rows of a point.
    pub(crate) const ROWS: usize = 4;

    /// Row `number` of the point in a lane, if it has that.
    #[inline(always)]
    pub(crate) fn row(&self, number: usize, lane: usize) -> Option<Run> {
        let is_near = self.are_near[number] >> lane & 1 == 1;
        is_near.then(|| Run { bucket: self.buckets[number][lane], length: self.lengths[number][lane] })
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
    use crate::join::region::{ReachLanes, Region};
    use crate::pixels::PixelRow;
    use lanes::{Kernel, LaneKind, dispatch};
    use scene::ray::NO_SPHERE;
    use scene::rng::{Family, StreamKey};
    use std::collections::HashSet;

    impl Cells {
        /// The bucket of a cell.
        fn bucket(self, cell: [i32; 3]) -> u32 {
            let [x, y, z] = cell.map(|x| x as u32);
            x.wrapping_add(y.wrapping_mul(self.stride_y)).wrapping_add(z.wrapping_mul(self.stride_z))
                & self.mask
        }
    }

    /// The buckets near each of these points, or `None`.
    struct Near<'a>(Cells, &'a [PixelRow; MOST_LANES]);

    impl Kernel for Near<'_> {
        type Output = Option<Vec<Vec<u32>>>;
        fn run<L: Lanes>(self) -> Self::Output {
            let Self(cells, rows) = self;
            let mut all = Vec::new();
            for rows in rows.chunks(L::N) {
                let points = ReachLanes::<L>::load(rows);
                let near = cells.near_points::<L>(points.point, points.reach, points.are_there)?;
                for lane in 0..L::N {
                    let runs = (0..NearPoints::ROWS).filter_map(|number| near.row(number, lane));
                    let buckets = runs.flat_map(|run| run.bucket..run.bucket + run.length);
                    all.push(buckets.map(|bucket| bucket & cells.mask).collect());
                }
            }
            Some(all)
        }
    }

    /// What a point reaches is in the cells near it, each of which is of its span and is there once; and cells out of reach are left
    /// out.
    #[test]
    fn cells_near_points_hold_what_they_reach() {
        let mut stream = StreamKey::new(1, Family::Survey, 0).stream(0);
        let mut uniform = move || stream.next_f32();
        let (mut reached, mut left_out) = (0, 0);
        for round in 0..200 {
            let (radius, far) = (0.5 * uniform(), [0.0, 100.0, 3e4][round % 3]);
            let cells = Cells::new(2.0 * radius + 0.01 + uniform(), 1 << 12);
            let mut rows = [PixelRow::NOTHING; MOST_LANES];
            for row in &mut rows[1..] {
                *row = PixelRow { sphere: 0, radius_squared: radius * radius, ..*row };
                row.point = [0; 3].map(|_| far + 4.0 * uniform() - 2.0);
            }
            for lanes in LaneKind::ALL {
                // Coordinates far away are rounded, and a third cell may be within reach.
                let Some(near) = dispatch(lanes, Near(cells, &rows)) else {
                    assert!(far > 1e3, "{cells:?}");
                    continue;
                };
                assert!(near[0].is_empty());
                for (row, near) in rows.iter().zip(&near).skip(1) {
                    let once: HashSet<u32> = near.iter().copied().collect();
                    assert_eq!(once.len(), near.len());
                    let Span { low, high } = cells.span(&Region::of_one(row).unwrap());
                    let span: HashSet<u32> = (low[2]..=high[2])
                        .flat_map(|z| (low[1]..=high[1]).map(move |y| (y, z)))
                        .flat_map(|(y, z)| (low[0]..=high[0]).map(move |x| cells.bucket([x, y, z])))
                        .collect();
                    assert!(once.is_subset(&span));
                    left_out += span.len() - once.len();
                    for _ in 0..20 {
                        let place = Vec3::from(row.point)
                            + Vec3::from([0; 3].map(|_| 2.0 * uniform() - 1.0)) * radius;
                        if place.distance_squared(row.point.into()) < row.radius_squared {
                            let bucket = cells.bucket(place.to_array().map(|x| cells.coordinate(x)));
                            assert!(once.contains(&bucket), "{place} near {row:?}");
                            reached += 1;
                        }
                    }
                }
            }
        }
        assert!(reached > 10_000 && left_out > 1000, "{reached}, {left_out}");
    }

    #[test]
    fn points_that_reach_three_cells_are_left_to_a_query() {
        let mut rows = [PixelRow::NOTHING; MOST_LANES];
        let cells = Cells::new(1.0, 1 << 12);
        for (radius, is_near) in [(0.45_f32, true), (0.9, false)] {
            (rows[5].point, rows[5].radius_squared) = ([0.5; 3], radius * radius);
            for lanes in LaneKind::ALL {
                rows[5].sphere = NO_SPHERE;
                assert!(dispatch(lanes, Near(cells, &rows)).is_some());
                rows[5].sphere = 3;
                assert_eq!(dispatch(lanes, Near(cells, &rows)).is_some(), is_near, "{lanes:?}");
            }
        }
    }

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
                .map(|(x, y, z)| cells.bucket([x, y, z].map(|x| x as i32)))
                .collect();
            assert_eq!(buckets.len() as u32, WINDOW.pow(3), "{cells:?}");
        }
        assert_eq!(sizes.len(), 11);
    }
}

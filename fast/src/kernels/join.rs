//! The join, and what it needs: cells, occupancy, sorting.

use super::consolidation::Gathered;
use super::maps::{Map, OverColumns};
use crate::join::{
    self, Arrival, Binned, Flux, GroupSums, HEAVY, JoinBuffers, JoinCounts, Record, Region, SAFE, SPHERE,
    Slabs, Sorted, bin_shift, gather_group,
};
use crate::parameters::Parameters;
use crate::pixels::{GROUP, GroupColumns, PixelRow};
use bytemuck::Zeroable;
use lanes::{Kernel, LaneKind, Lanes, V3, dispatch};
use scene::Vec3;
use scene::ray::SphereId;
use std::sync::Arc;

/// A map from points of space to buckets.
#[derive(Clone, Copy, Debug)]
pub struct Cells(pub(super) join::Cells);

/// A box of points, and the distance from it within which photons may count.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// The lower corner.
    pub low: Vec3,
    /// The upper corner.
    pub high: Vec3,
    /// The distance.
    pub reach: f32,
}

/// Consecutive buckets; the last bucket is followed by the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The first.
    pub bucket: u32,
    /// How many.
    pub length: u32,
}

impl Query {
    fn region(self) -> Region {
        Region { low: self.low, high: self.high, reach: self.reach }
    }
}

impl Cells {
    /// Cells of the given size on at least `buckets` buckets.
    pub fn new(size: f32, buckets: usize) -> Self {
        Self(join::Cells::new(size, buckets))
    }

    /// The number of buckets.
    pub fn count(self) -> u32 {
        self.0.mask + 1
    }

    /// The buckets (words) of points.
    pub fn buckets(self, lanes: LaneKind, points: [&[f32]; 3], buckets: &mut [f32]) {
        OverColumns { map: self.0, inputs: points, outputs: [buckets] }.on(lanes);
    }

    /// The runs of buckets in which the points near a box lie; `None` if there are more cells than a window has.
    pub fn runs(self, lanes: LaneKind, near: Query) -> Option<Vec<Run>> {
        dispatch(lanes, Runs { cells: self.0, region: near.region() })
    }
}

struct Runs {
    cells: join::Cells,
    region: Region,
}

impl Kernel for Runs {
    type Output = Option<Vec<Run>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let span = self.cells.span(&self.region);
        if !span.fits() {
            return None;
        }
        let query = self.cells.query::<L>(span, &self.region);
        let mut runs = Vec::new();
        for z in query.slabs() {
            let mut rows = query.rows(z);
            while let Some(join::Run { bucket, length }) = rows.next() {
                runs.push(Run { bucket, length });
            }
        }
        Some(runs)
    }
}

impl Map<3, 1> for join::Cells {
    #[inline(always)]
    fn apply<L: Lanes>(&self, [x, y, z]: [L::F; 3]) -> [L::F; 1] {
        [L::from_bits(self.buckets::<L>(V3::new(x, y, z)))]
    }
}

/// A map of the cells that visible points reach.
pub struct Occupancy(pub(super) join::Occupancy);

impl Occupancy {
    /// An empty map.
    pub fn new(cell_size: f32) -> Self {
        Self(join::Occupancy::new(cell_size, Parameters::default().occupancy_bits))
    }

    /// Marks the cells near a box and returns true, unless they do not fit into a window.
    pub fn mark(&mut self, lanes: LaneKind, near: Query) -> bool {
        dispatch(lanes, Mark { occupancy: &mut self.0, region: near.region() })
    }

    /// Adds the marks of another map with cells of the same size.
    pub fn merge(&mut self, other: &Self) {
        self.0.merge(&other.0);
    }

    /// For each point 1 where its cell is marked, else 0.
    pub fn touches(&self, lanes: LaneKind, points: [&[f32]; 3], touched: &mut [f32]) {
        OverColumns { map: &self.0, inputs: points, outputs: [touched] }.on(lanes);
    }
}

struct Mark<'a> {
    occupancy: &'a mut join::Occupancy,
    region: Region,
}

impl Kernel for Mark<'_> {
    type Output = bool;
    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        self.occupancy.mark::<L>(&self.region)
    }
}

impl Map<3, 1> for &join::Occupancy {
    #[inline(always)]
    fn apply<L: Lanes>(&self, [x, y, z]: [L::F; 3]) -> [L::F; 1] {
        [L::select(self.touches::<L>(V3::new(x, y, z)), L::f(1.0), L::f(0.0))]
    }
}

/// A photon at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where.
    pub point: Vec3,
    /// The direction that it comes from.
    pub wi: Vec3,
    /// On which sphere.
    pub sphere: SphereId,
    /// True if it arrives on the visible side of all points of the sphere within the radius.
    pub is_safe: bool,
    /// Its flux: units per channel, each at most 2^21.
    pub flux: [u32; 3],
    /// The exponent of 2 that multiplies them.
    pub shift: u32,
}

/// A visible point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where.
    pub point: Vec3,
    /// The normal on the visible side.
    pub normal: Vec3,
    /// On which sphere.
    pub sphere: SphereId,
    /// Squared search radius.
    pub radius_squared: f32,
}

/// Sorted photons, and visible points in groups of 16.
pub struct Join {
    count: usize,
    cells: join::Cells,
    sorted: Sorted,
    rows: Vec<PixelRow>,
    columns: Vec<GroupColumns>,
}

impl Join {
    /// Sorts the photons of several workers by cells of the given size on at least `buckets` buckets. Pixels without a
    /// visible point are `None`.
    pub fn new(
        lanes: LaneKind,
        parts: &[&[Photon]],
        points: &[Option<Point>],
        cell_size: f32,
        buckets: usize,
    ) -> Self {
        let cells = join::Cells::new(cell_size, buckets);
        let pool = Arc::new(Slabs::new());
        let mut parts: Vec<Binned> = parts.iter().map(|part| bin(lanes, part, cells, &pool)).collect();
        let mut sorted = Sorted::new();
        sorted.fill(&mut parts.iter_mut().collect::<Vec<_>>(), &pool, cells);
        let slots = points.len().next_multiple_of(GROUP);
        let mut rows = vec![PixelRow::NOTHING; slots];
        let mut columns = vec![GroupColumns::zeroed(); slots / GROUP];
        for (k, (row, point)) in rows.iter_mut().zip(points).enumerate() {
            // A pixel keeps its radius where nothing is seen.
            row.radius_squared = 1.0;
            if let Some(Point { point, normal, sphere, radius_squared }) = *point {
                (row.point, row.sphere) = (point.into(), sphere);
                columns[k / GROUP].set_normal(k % GROUP, normal);
                row.radius_squared = radius_squared;
            }
        }
        Self { count: points.len(), cells, sorted, rows, columns }
    }

    /// The photons in sorted order, each with its bucket.
    pub fn photons(&self) -> Vec<(Photon, u32)> {
        sorted_photons(&self.sorted)
    }

    /// Per bucket, the index of its first photon; and at the end the number of photons.
    pub fn starts(&self) -> Vec<u32> {
        let chunks = self.sorted.chunks();
        let deposits = self.sorted.deposits(&chunks);
        let mut count = 0;
        let mut starts = vec![0];
        for bucket in 0..=self.cells.mask {
            let all = deposits.photons(join::Run { bucket, length: 1 }).into_iter().flatten();
            count += all.filter(|index| deposits.deposit(*index).is_some()).count() as u32;
            starts.push(count);
        }
        starts
    }

    /// What each visible point gathers, and the number of pairs that were tested.
    pub fn gather(&self, lanes: LaneKind) -> (Vec<Gathered>, u64) {
        let (sums, counts) = dispatch(lanes, Gather(self));
        let gathered = |k: usize| {
            let sums: &GroupSums = &sums[k / GROUP];
            Gathered { m: sums.m[k % GROUP], flux: std::array::from_fn(|c| sums.total(c, k % GROUP)) }
        };
        let all: Vec<Gathered> = (0..self.count).map(gathered).collect();
        let total: u64 = all.iter().map(|gathered| u64::from(gathered.m)).sum();
        assert_eq!(counts.contributions, total, "the count of contributions is not their number");
        (all, counts.candidates)
    }
}

struct Gather<'a>(&'a Join);

impl Kernel for Gather<'_> {
    type Output = (Vec<GroupSums>, JoinCounts);
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Join { cells, sorted, rows, columns, .. } = self.0;
        let chunks = sorted.chunks();
        let deposits = sorted.deposits(&chunks);
        let mut all = Vec::with_capacity(rows.len() / GROUP);
        let (mut counts, mut buffers) = (JoinCounts::default(), JoinBuffers::new());
        for seen in rows.chunks(GROUP).zip(columns) {
            let mut sums = GroupSums::default();
            gather_group::<L>(&deposits, *cells, seen, &mut buffers, &mut sums, &mut counts);
            all.push(sums);
        }
        (all, counts)
    }
}

/// Photons in bins, by the buckets that the kernel computes.
fn bin(lanes: LaneKind, photons: &[Photon], cells: join::Cells, pool: &Arc<Slabs>) -> Binned {
    let column = |axis: usize| photons.iter().map(|photon| photon.point[axis]).collect::<Vec<f32>>();
    let [x, y, z] = [column(0), column(1), column(2)];
    let mut buckets = vec![0.0; photons.len()];
    Cells(cells).buckets(lanes, [&x, &y, &z], &mut buckets);
    let mut binned = Binned::new(pool);
    for (photon, bucket) in photons.iter().zip(buckets) {
        let Photon { point, wi, sphere, is_safe, flux, shift } = *photon;
        let surface = sphere | if is_safe { SAFE } else { 0 } | if shift > 0 { HEAVY } else { 0 };
        let (flux, bucket) = (Flux { units: flux, shift }.pack(), bucket.to_bits());
        let record = Record { point: point.into(), surface, flux, bucket };
        binned.writer(1).push(record, [wi.x, wi.y, wi.z, 0.0], bin_shift(cells));
    }
    binned
}

/// The photons in sorted order, each with its bucket.
pub(super) fn sorted_photons(sorted: &Sorted) -> Vec<(Photon, u32)> {
    let photon = |(point, arrival): (Vec3, &Arrival)| {
        let Arrival { surface, flux, wi, bucket } = *arrival;
        let Flux { units, shift } = Flux::unpack(flux);
        let photon = Photon {
            point,
            wi: wi.into(),
            sphere: surface & SPHERE,
            is_safe: surface & SAFE != 0,
            flux: units,
            shift,
        };
        (photon, bucket)
    };
    let chunks = sorted.chunks();
    let deposits = sorted.deposits(&chunks);
    deposits.all().filter_map(|index| deposits.deposit(index)).map(photon).collect()
}

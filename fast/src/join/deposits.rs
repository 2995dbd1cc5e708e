//! Photons on their way from the lights to the visible points: deposited in bins, sorted by bucket.
//!
//! Deposits are thrown into [`BINS`] bins by the top bits of their bucket as they come, and each bin is then
//! put in order by counting. Both steps write to few places at a time, where one sort of all would scatter over
//! megabytes; and the bins are the units of parallel work.

use super::cells::Cells;
use crate::lanes::{MOST_LANES, Row};
use rayon::prelude::*;

/// Number of bins.
pub(crate) const BINS: usize = 64;

/// The bit of a record's surface that says: for any visible point on that sphere within the largest radius, the
/// photon arrives on the visible side.
pub(crate) const SAFE: u32 = 1 << 31;

/// A deposit: words point x y z, surface (sphere, and perhaps [`SAFE`]), flux r g b, bucket.
pub(crate) type Record = Row;

/// Where a photon comes from; the last word is unused.
pub(crate) type Direction = [f32; 4];

/// The deposits of some photons, in bins.
pub(crate) struct Binned {
    bins: Vec<Bin>,
    /// How many there are.
    pub(crate) count: usize,
}

/// Deposits in no particular order, and the directions that belong to them.
#[derive(Clone, Default)]
struct Bin {
    records: Vec<Record>,
    directions: Vec<Direction>,
}

/// The deposits of all photons, in order of their buckets.
pub(crate) struct Sorted {
    /// Records, followed by room for vectors that read past the end.
    pub(crate) records: Vec<Record>,
    /// Directions, in the order of the records.
    pub(crate) directions: Vec<Direction>,
    /// The deposits of bucket b are those from `starts[b]` to `starts[b + 1]`.
    pub(crate) starts: Vec<u32>,
}

impl Binned {
    pub(crate) fn new() -> Self {
        Self { bins: vec![Bin::default(); BINS], count: 0 }
    }

    /// Forgets all deposits and keeps the memory.
    pub(crate) fn clear(&mut self) {
        for bin in &mut self.bins {
            bin.records.clear();
            bin.directions.clear();
        }
        self.count = 0;
    }

    /// Adds a deposit; `shift` takes a bucket to its bin.
    #[inline(always)]
    pub(crate) fn push(&mut self, record: Record, direction: Direction, shift: u32) {
        let bin = &mut self.bins[(record.0[7].to_bits() >> shift) as usize & (BINS - 1)];
        bin.records.push(record);
        bin.directions.push(direction);
        self.count += 1;
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let each = size_of::<Record>() + size_of::<Direction>();
        self.bins.iter().map(|bin| bin.records.capacity() * each).sum()
    }
}

/// What takes a bucket of `cells` to its bin.
pub(crate) fn bin_shift(cells: Cells) -> u32 {
    (cells.mask + 1).trailing_zeros() - BINS.trailing_zeros()
}

impl Sorted {
    pub(crate) fn new() -> Self {
        Self { records: Vec::new(), directions: Vec::new(), starts: Vec::new() }
    }

    /// How many deposits there are.
    pub(crate) fn count(&self) -> usize {
        self.starts.last().map_or(0, |end| *end as usize)
    }

    /// Forgets all deposits and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.starts.fill(0);
    }

    /// Sorts the deposits of `parts`.
    pub(crate) fn fill(&mut self, parts: &[&Binned], cells: Cells) {
        let total: usize = parts.iter().map(|part| part.count).sum();
        self.records.resize(total + MOST_LANES, Row::default());
        self.directions.resize(total + MOST_LANES, [0.0; 4]);
        self.starts.resize(cells.mask as usize + 2, 0);
        let buckets = self.starts.len() / BINS;
        let mut work = Vec::with_capacity(BINS);
        let (mut records, mut directions) = (&mut self.records[..], &mut self.directions[..]);
        let mut first = 0;
        for (bin, starts) in self.starts[..buckets * BINS].chunks_mut(buckets).enumerate() {
            let count = parts.iter().map(|part| part.bins[bin].records.len()).sum();
            let (mine, rest) = records.split_at_mut(count);
            let (my_directions, rest_directions) = directions.split_at_mut(count);
            (records, directions) = (rest, rest_directions);
            work.push(BinWork { bin, first, records: mine, directions: my_directions, starts });
            first += count as u32;
        }
        work.into_par_iter().for_each(|bin| bin.sort(parts));
        self.starts[buckets * BINS] = total as u32;
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.records[..]) + size_of_val(&self.directions[..]) + size_of_val(&self.starts[..])
    }
}

/// A bin to be sorted into its part of the output.
struct BinWork<'a> {
    bin: usize,
    first: u32,
    records: &'a mut [Record],
    directions: &'a mut [Direction],
    starts: &'a mut [u32],
}

impl BinWork<'_> {
    fn sort(self, parts: &[&Binned]) {
        let bins = || parts.iter().map(|part| &part.bins[self.bin]);
        let local = self.starts.len() as u32 - 1;
        let bucket = |record: &Record| (record.0[7].to_bits() & local) as usize;
        self.starts.fill(0);
        bins().flat_map(|bin| &bin.records).for_each(|record| self.starts[bucket(record)] += 1);
        let mut end = 0;
        for start in self.starts.iter_mut() {
            end += *start;
            *start = end;
        }
        // Filled from the back, each bucket's end becomes its start.
        for (record, direction) in bins().flat_map(|bin| bin.records.iter().zip(&bin.directions)) {
            let place = &mut self.starts[bucket(record)];
            *place -= 1;
            self.records[*place as usize] = *record;
            self.directions[*place as usize] = *direction;
        }
        self.starts.iter_mut().for_each(|start| *start += self.first);
    }
}

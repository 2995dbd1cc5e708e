//! The deposits of all photons, sorted by bucket: sorting, and looking up a run of buckets.

use super::bins::{BINS, Binned, CHUNK, with_margin};
use super::cells::{Cells, Run, WINDOW};
use super::deposit::{Arrival, Direction, Record};
use crate::pages::Pages;
use crate::work_items::singly;
use lanes::{Lanes, MOST_LANES, V3, prefetch};
use rayon::prelude::*;
use scene::Vec3;
use std::array;
use std::ops::Range;

/// So many deposits before its turn, one that lies anywhere is asked for from memory.
const AHEAD: usize = 16;

/// The same of deposits that follow each other: processors fetch these ahead by themselves, but not across pages.
const FAR_AHEAD: usize = 64;

// A run and the bits before it in its byte fit into the two bytes that `Deposits::is_empty` reads.
const _: () = assert!(WINDOW <= 9);

/// The deposits of all photons, in order of their buckets.
pub(crate) struct Sorted {
    /// Their points, which the search reads: a column per axis, each with room for more and for vectors that read past the end.
    points: Pages<f32>,
    /// The numbers of a column.
    column: usize,
    /// What they bring, which is read once they are found.
    arrivals: Pages<Arrival>,
    /// The deposits of bucket b are those from `starts[b]` to `starts[b + 1]`.
    starts: Pages<u32>,
    /// A bit per bucket, set if it has deposits; the lowest bit of the first byte is bucket 0, and the first byte is
    /// repeated at the end. Most buckets that are looked up are empty, and this stays in the cache where `starts` does not.
    filled: Vec<u8>,
}

impl Sorted {
    pub(crate) fn new() -> Self {
        let (points, arrivals, starts) = (Pages::zeros(0), Pages::zeros(0), Pages::zeros(0));
        Self { points, column: 0, arrivals, starts, filled: Vec::new() }
    }

    /// How many deposits there are.
    pub(crate) fn count(&self) -> usize {
        self.deposits().count()
    }

    /// What is read of these to gather.
    pub(crate) fn deposits(&self) -> Deposits<'_> {
        let points = array::from_fn(|axis| &self.points[axis * self.column..][..self.column]);
        Deposits { points, arrivals: &self.arrivals, starts: &self.starts, filled: &self.filled }
    }

    /// The point of a deposit.
    pub(crate) fn point(&self, index: usize) -> Vec3 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.points[axis * self.column + index]);
        Vec3::new(x, y, z)
    }

    /// Per bucket, the index of its first deposit; and at the end the number of deposits.
    pub(crate) fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// Replaces the deposits by those of `parts`, sorted.
    pub(crate) fn fill(&mut self, parts: &[&Binned], cells: Cells) {
        let total: usize = parts.iter().map(|part| part.count).sum();
        self.make_room(total);
        let buckets = cells.mask as usize + 1;
        if self.starts.len() != buckets + 1 {
            self.starts = Pages::zeros(0);
            self.starts = Pages::zeros(buckets + 1);
        }
        self.filled.resize(buckets / 8 + 1, 0);
        let (xs, others) = self.points.split_at_mut(self.column);
        let (ys, zs) = others.split_at_mut(self.column);
        let mut columns = [xs, ys, zs];
        let mut arrivals = &mut self.arrivals[..];
        let per_bin = buckets / BINS;
        let places = self.starts[..buckets].chunks_mut(per_bin).zip(self.filled.chunks_mut(per_bin / 8));
        let mut work = Vec::with_capacity(BINS);
        let mut first = 0;
        for (bin, (starts, filled)) in places.enumerate() {
            let count = parts.iter().map(|part| part.count_of(bin)).sum();
            let points = columns.each_mut().map(|column| column.split_off_mut(..count).unwrap_or_default());
            let mine = arrivals.split_off_mut(..count).unwrap_or_default();
            work.push(BinWork { bin, first, points, arrivals: mine, starts, filled });
            first += count as u32;
        }
        singly(work.into_par_iter()).for_each(|bin| bin.sort(parts));
        self.starts[buckets] = total as u32;
        self.filled[buckets / 8] = self.filled[0];
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let deposits = size_of_val(&self.points[..]) + size_of_val(&self.arrivals[..]);
        deposits + size_of_val(&self.starts[..]) + self.filled.len()
    }

    /// Makes room for so many deposits and some more, if there is none. Frees the old first, so that both are never held.
    fn make_room(&mut self, count: usize) {
        if count > self.arrivals.len() || self.column == 0 {
            let room = with_margin(count as u64) as usize;
            (self.points, self.arrivals) = (Pages::zeros(0), Pages::zeros(0));
            self.column = room + MOST_LANES;
            self.points = Pages::zeros(3 * self.column);
            self.arrivals = Pages::zeros(room);
        }
    }
}

/// The coordinates of points, in columns.
pub(crate) type Coordinates<'a> = ((&'a [f32], &'a [f32]), &'a [f32]);

/// The first `L::N` points.
#[inline(always)]
pub(crate) fn points<L: Lanes>(((xs, ys), zs): Coordinates) -> V3<L> {
    V3::new(L::load(xs), L::load(ys), L::load(zs))
}

/// Sorted deposits as slices: [`Pages`] and vectors would be dereferenced for every packet of photons.
#[derive(Clone, Copy)]
pub(crate) struct Deposits<'a> {
    points: [&'a [f32]; 3],
    /// What each deposit brings.
    pub(crate) arrivals: &'a [Arrival],
    starts: &'a [u32],
    filled: &'a [u8],
}

impl Deposits<'_> {
    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.starts.last().map_or(0, |end| *end as usize)
    }

    /// True if a run of buckets, which may wrap around the table, has no deposits.
    #[inline(always)]
    pub(crate) fn is_empty(&self, run: Run) -> bool {
        let byte = run.bucket as usize / 8;
        let bits = u32::from(self.filled[byte]) | u32::from(self.filled[byte + 1]) << 8;
        (bits >> (run.bucket % 8)) & ((1 << run.length) - 1) == 0
    }

    /// The deposits of a run of buckets: two ranges, if the run wraps around the table.
    #[inline(always)]
    pub(crate) fn photons(&self, run: Run) -> [Range<usize>; 2] {
        let buckets = self.starts.len() - 1;
        let (first, end) = (run.bucket as usize, run.bucket as usize + run.length as usize);
        let start = |bucket: usize| self.starts[bucket] as usize;
        if end <= buckets {
            [start(first)..start(end), 0..0]
        } else {
            [start(first)..start(buckets), 0..start(end - buckets)]
        }
    }

    /// Prefetches where the deposits of a run are.
    #[inline(always)]
    pub(crate) fn prefetch_start(&self, run: Run) {
        prefetch(self.starts, run.bucket as usize);
    }

    /// Prefetches the points of deposits from `at` on.
    #[inline(always)]
    pub(crate) fn prefetch_points(&self, at: usize) {
        self.points.iter().for_each(|column| prefetch(column, at));
    }

    /// The points of a run of deposits, `L::N` at a time, each with the index of the first; the last ones may be of others.
    /// A closure that loads them would not be inlined (rule 1 of [`lanes`]), so they are [`Coordinates`].
    #[inline(always)]
    pub(crate) fn packets<L: Lanes>(
        &self,
        run: Range<usize>,
    ) -> impl Iterator<Item = (usize, Coordinates<'_>)> {
        let whole = run.len().next_multiple_of(L::N);
        let [xs, ys, zs] = self.points.map(|column| column[run.start..][..whole].chunks_exact(L::N));
        run.step_by(L::N).zip(xs.zip(ys).zip(zs))
    }

    /// Prefetches what `L::N` deposits from `at` on bring.
    #[inline(always)]
    pub(crate) fn prefetch_arrivals<L: Lanes>(&self, at: usize) {
        /// Two rows share a cache line.
        const STEP: usize = 2;
        for k in (0..L::N).step_by(STEP) {
            prefetch(self.arrivals, at + k);
        }
    }
}

/// A bin to be sorted into its part of the output.
struct BinWork<'a> {
    bin: usize,
    first: u32,
    points: [&'a mut [f32]; 3],
    arrivals: &'a mut [Arrival],
    starts: &'a mut [u32],
    filled: &'a mut [u8],
}

/// The deposits of a bin, chunk by chunk. A deposit's number is [`CHUNK`] times that of its chunk, and its place there.
type ChunksOfBin<'a> = Vec<(&'a [Record], &'a [Direction])>;

impl BinWork<'_> {
    /// Sorts numbers of deposits, which stay in the first-level cache, and then fetches the deposits in their order. So what is
    /// far apart is read, which can be asked for long before, and what is written is consecutive: few stores wait for
    /// memory at a time.
    fn sort(mut self, parts: &[&Binned]) {
        let chunks = parts.iter().flat_map(|part| part.bin(self.bin)).collect();
        self.count(&chunks);
        let order = self.order(&chunks);
        self.starts.iter_mut().for_each(|start| *start += self.first);
        self.fetch(&chunks, &order);
    }

    /// The place of a deposit's bucket among those of the bin.
    fn bucket(&self, record: &Record) -> usize {
        (record.bucket & (self.starts.len() as u32 - 1)) as usize
    }

    /// Counts the deposits of each bucket, and sets its start to where the next begins.
    fn count(&mut self, chunks: &ChunksOfBin) {
        self.starts.fill(0);
        for (records, _) in chunks {
            for (k, record) in records.iter().enumerate() {
                prefetch(records, k + FAR_AHEAD);
                self.starts[self.bucket(record)] += 1;
            }
        }
        let mut end = 0;
        for (starts, filled) in self.starts.chunks_mut(8).zip(&mut *self.filled) {
            *filled = 0;
            for (k, start) in starts.iter_mut().enumerate() {
                *filled |= u8::from(*start > 0) << k;
                end += *start;
                *start = end;
            }
        }
    }

    /// The numbers of the deposits in order of their buckets. These are filled from the back: so the end of each becomes
    /// its start.
    fn order(&mut self, chunks: &ChunksOfBin) -> Vec<u32> {
        let mut order = vec![0; self.arrivals.len()];
        for (first, (records, _)) in (0..).step_by(CHUNK).zip(chunks) {
            for (number, record) in (first..).zip(*records) {
                let start = &mut self.starts[self.bucket(record)];
                *start -= 1;
                order[*start as usize] = number;
            }
        }
        order
    }

    /// Writes the deposits in this order.
    fn fetch(self, chunks: &ChunksOfBin, order: &[u32]) {
        let [xs, ys, zs] = self.points;
        let places = xs.iter_mut().zip(ys).zip(zs).zip(self.arrivals);
        for (k, (((x, y), z), arrival)) in places.enumerate() {
            let ahead = order[(k + AHEAD).min(order.len() - 1)] as usize;
            let (records, directions) = chunks[ahead / CHUNK];
            prefetch(records, ahead % CHUNK);
            prefetch(directions, ahead % CHUNK);
            let (chunk, place) = (order[k] as usize / CHUNK, order[k] as usize % CHUNK);
            let (records, directions) = chunks[chunk];
            let record = records[place];
            [*x, *y, *z] = record.point;
            *arrival = record.arrival(directions[place]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::join::bins::{Slabs, bin_shift};
    use std::sync::Arc;

    #[test]
    fn sorted_deposits_have_room_for_vectors_that_read_past_the_end() {
        let mut sorted = Sorted::new();
        assert_eq!(sorted.bytes(), 0);
        let cells = Cells::new(1.0, 1 << 12);
        sorted.fill(&[], cells);
        let coordinates = 3 * size_of::<f32>() * MOST_LANES;
        let of_buckets = size_of::<u32>() * ((1 << 12) + 1) + (1 << 12) / 8 + 1;
        assert_eq!((sorted.count(), sorted.bytes()), (0, coordinates + of_buckets));
    }

    /// Of the buckets that are looked up most are empty, and so few of `starts` are read.
    #[test]
    fn runs_are_empty_where_no_bucket_has_a_deposit() {
        let cells = Cells::new(1.0, 1 << 12);
        let is_filled = |bucket: u32| bucket.is_multiple_of(61) || bucket % 64 == 17 || bucket == cells.mask;
        let mut binned = Binned::new(&Arc::new(Slabs::new()));
        for bucket in (0..=cells.mask).filter(|bucket| is_filled(*bucket)) {
            let record = Record { bucket, ..Record::default() };
            binned.writer(1).push(record, [0.0; 4], bin_shift(cells));
        }
        let mut sorted = Sorted::new();
        sorted.fill(&[&binned], cells);
        for bucket in 0..=cells.mask {
            for length in 1..=WINDOW {
                let expected = !(0..length).any(|k| is_filled((bucket + k) & cells.mask));
                assert_eq!(
                    sorted.deposits().is_empty(Run { bucket, length }),
                    expected,
                    "{length} from {bucket}"
                );
            }
        }
        sorted.fill(&[], cells);
        assert!((0..=cells.mask).all(|bucket| sorted.deposits().is_empty(Run { bucket, length: WINDOW })));
    }
}

//! The deposits of all photons, sorted by bucket: sorting, and looking up a run of buckets.
//!
//! ```text
//! for each bin, on any thread:
//!     count the deposits of each bucket
//!     list the numbers of the deposits in order of their buckets
//!     take chunks that are not in use; write the deposits to them in this order
//!     give back the chunks that the bin had, which are not in use now
//! ```

use super::bins::{BINS, Binned, Part, reserve};
use super::cells::{Cells, Run, WINDOW};
use super::chunk::{CHUNK, Chunk, InOrder, Place, SLAB, Slab, Slabs, bytes_of_slabs, new_slab};
use super::deposit::{Arrival, Direction, Record};
use crate::pages::Pages;
use crate::work_items::singly;
use lanes::{Lanes, V3, prefetch};
use rayon::current_num_threads;
use rayon::prelude::*;
use scene::Vec3;
use std::array;
use std::mem::take;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// So many deposits before its turn, one that lies anywhere is asked for from memory.
const AHEAD: usize = 16;

// A run and the bits before it in its byte fit into the two bytes that `Deposits::is_empty` reads.
const _: () = assert!(WINDOW <= 9);

/// The deposits of all photons, in order of their buckets. Each bin begins a chunk, so there are places without a deposit
/// between bins.
pub(crate) struct Sorted {
    slabs: Vec<Slab>,
    /// The chunks in order, and how many deposits each holds.
    parts: Vec<Part>,
    /// How many deposits there are.
    count: usize,
    /// The deposits of bucket b are those from `starts[b]` to `starts[b + 1]`; of the last of a bin, with the places after them.
    starts: Pages<u32>,
    /// A bit per bucket, set if it has deposits; the lowest bit of the first byte is bucket 0, and the first byte is
    /// repeated at the end. Most buckets that are looked up are empty, and this stays in the cache where `starts` does not.
    filled: Vec<u8>,
}

impl Sorted {
    pub(crate) fn new() -> Self {
        Self { slabs: Vec::new(), parts: Vec::new(), count: 0, starts: Pages::zeros(0), filled: Vec::new() }
    }

    /// How many deposits there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The chunks, in order.
    pub(crate) fn chunks(&self) -> Vec<SortedChunk<'_>> {
        let slabs: Vec<&[Chunk]> = self.slabs.iter().map(|slab| &slab[..]).collect();
        let chunk = |(place, count): &Part| SortedChunk {
            deposits: slabs[place.slab as usize][place.chunk as usize].in_order(),
            count: *count,
        };
        self.parts.iter().map(chunk).collect()
    }

    /// What is read to gather; `chunks` are [`Sorted::chunks`].
    pub(crate) fn deposits<'a>(&'a self, chunks: &'a [SortedChunk<'a>]) -> Deposits<'a> {
        Deposits { chunks, starts: &self.starts, filled: &self.filled }
    }

    /// Drops the deposits, and returns their room to the pool. They must be filled in again before others look them up.
    pub(crate) fn clear(&mut self, pool: &Slabs) {
        pool.put_all(self.slabs.drain(..));
        self.parts.clear();
        self.count = 0;
    }

    /// Replaces the deposits by those of `parts`, sorted, and empties these. Room comes from the pool, and from `parts`.
    pub(crate) fn fill(&mut self, parts: &mut [&mut Binned], pool: &Slabs, cells: Cells) {
        self.clear(pool);
        self.count = parts.iter().map(|part| part.count).sum();
        let mut bins: [Vec<Part>; BINS] = array::from_fn(|_| Vec::new());
        for part in parts {
            part.hand_over(&mut self.slabs, &mut bins);
        }
        self.take_room(&bins, pool);
        let buckets = cells.mask as usize + 1;
        if self.starts.len() != buckets + 1 {
            self.starts = Pages::zeros(0);
            self.starts = Pages::zeros(buckets + 1);
        }
        self.filled.resize(buckets / 8 + 1, 0);
        let (mut used, free) = divide(&mut self.slabs, &bins);
        let per_bin = buckets / BINS;
        let places = self.starts[..buckets].chunks_mut(per_bin).zip(self.filled.chunks_mut(per_bin / 8));
        let mut work = Vec::with_capacity(BINS);
        let mut first = 0;
        for ((starts, filled), (parts, chunks)) in places.zip(bins.iter().zip(&mut used)) {
            let counts = parts.iter().map(|(_, count)| *count).collect();
            work.push(BinWork { chunks: take(chunks), counts, first, buckets: Buckets { starts, filled } });
            first += deposits_of(parts).next_multiple_of(CHUNK) as u32;
        }
        let parts: Vec<Vec<Part>> = singly(work.into_par_iter()).map(|bin| bin.sort(&free)).collect();
        self.parts.extend(parts.into_iter().flatten());
        self.starts[buckets] = first;
        self.filled[buckets / 8] = self.filled[0];
        reserve(pool, self.slabs.len(), self.count);
    }

    /// Takes slabs from the pool, so that there is room for the bins that all threads sort at a time.
    fn take_room(&mut self, bins: &[Vec<Part>], pool: &Slabs) {
        let mut sizes: Vec<usize> = bins.iter().map(|parts| deposits_of(parts).div_ceil(CHUNK)).collect();
        sizes.sort_unstable_by(|a, b| b.cmp(a));
        // A bin gives back no fewer chunks than it takes, so this is enough for all others as well.
        let at_once: usize = sizes.iter().take(current_num_threads()).sum();
        let used: usize = bins.iter().map(Vec::len).sum();
        while self.slabs.len() * SLAB < used + at_once {
            self.slabs.push(pool.take(new_slab));
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        bytes_of_slabs(self.slabs.len()) + size_of_val(&self.starts[..]) + self.filled.len()
    }
}

/// The number of deposits of a bin.
fn deposits_of(parts: &[Part]) -> usize {
    parts.iter().map(|(_, count)| count).sum()
}

/// A chunk, and where it is.
struct Room<'a> {
    place: Place,
    chunk: &'a mut Chunk,
}

/// The chunks of each bin, and those that are not in use.
fn divide<'a>(slabs: &'a mut [Slab], bins: &[Vec<Part>]) -> (Vec<Vec<Room<'a>>>, Mutex<Vec<Room<'a>>>) {
    let chunks = slabs.iter_mut().flat_map(|slab| slab.iter_mut()).enumerate();
    let mut all: Vec<Option<Room>> =
        chunks.map(|(number, chunk)| Some(Room { place: Place::of(number), chunk })).collect();
    let mut take_all =
        |parts: &Vec<Part>| parts.iter().filter_map(|(place, _)| all[place.number()].take()).collect();
    let used = bins.iter().map(&mut take_all).collect();
    (used, Mutex::new(all.into_iter().flatten().collect()))
}

/// The coordinates of points, in columns.
pub(crate) type Coordinates<'a> = [&'a [f32]; 3];

/// The first `L::N` points.
#[inline(always)]
pub(crate) fn points<L: Lanes>([xs, ys, zs]: Coordinates) -> V3<L> {
    V3::new(L::load(xs), L::load(ys), L::load(zs))
}

/// A chunk of sorted deposits, and how many it holds.
pub(crate) struct SortedChunk<'a> {
    deposits: &'a InOrder,
    count: usize,
}

/// Sorted deposits as slices: [`Pages`] and vectors would be dereferenced for every packet of photons.
#[derive(Clone, Copy)]
pub(crate) struct Deposits<'a> {
    chunks: &'a [SortedChunk<'a>],
    starts: &'a [u32],
    filled: &'a [u8],
}

/// Consecutive deposits of a chunk.
pub(crate) struct Piece<'a> {
    chunk: &'a InOrder,
    /// Their indices among all.
    pub(crate) indices: Range<usize>,
}

impl<'a> Deposits<'a> {
    /// The indices of all, with places in between that have none.
    pub(crate) fn all(&self) -> Range<usize> {
        0..self.starts.last().map_or(0, |end| *end as usize)
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
        self.chunks[at / CHUNK].deposits.points.iter().for_each(|column| prefetch(column, at % CHUNK));
    }

    /// The point of a deposit, and what it brings; `None` where there is none.
    pub(crate) fn deposit(&self, index: usize) -> Option<(Vec3, &'a Arrival)> {
        let SortedChunk { deposits, count } = &self.chunks[index / CHUNK];
        let point = Vec3::from(deposits.points.map(|column| column[index % CHUNK]));
        (index % CHUNK < *count).then_some((point, &deposits.arrivals[index % CHUNK]))
    }

    /// What a deposit brings.
    #[inline(always)]
    pub(crate) fn arrival(&self, index: u32) -> &'a Arrival {
        &self.chunks[index as usize / CHUNK].deposits.arrivals[index as usize % CHUNK]
    }

    /// A run of deposits, chunk by chunk.
    #[inline(always)]
    pub(crate) fn pieces(&self, run: Range<usize>) -> Pieces<'a> {
        Pieces { chunks: self.chunks, left: run }
    }
}

/// See [`Deposits::pieces`].
pub(crate) struct Pieces<'a> {
    chunks: &'a [SortedChunk<'a>],
    left: Range<usize>,
}

impl<'a> Iterator for Pieces<'a> {
    type Item = Piece<'a>;

    #[inline(always)]
    fn next(&mut self) -> Option<Piece<'a>> {
        let Range { start, end } = self.left;
        if start >= end {
            return None;
        }
        let first = start / CHUNK * CHUNK;
        let SortedChunk { deposits, count } = &self.chunks[start / CHUNK];
        self.left.start = first + CHUNK;
        Some(Piece { chunk: deposits, indices: start..end.min(first + count) })
    }
}

impl Piece<'_> {
    /// The points of `L::N` deposits from index `at` on; the last ones may be none of this piece.
    #[inline(always)]
    pub(crate) fn coordinates(&self, at: usize) -> Coordinates<'_> {
        self.chunk.points.each_ref().map(|column| &column[at % CHUNK..])
    }

    /// Prefetches what `L::N` deposits from `at` on bring.
    #[inline(always)]
    pub(crate) fn prefetch_arrivals<L: Lanes>(&self, at: usize) {
        /// Two rows share a cache line.
        const STEP: usize = 2;
        for k in (0..L::N).step_by(STEP) {
            prefetch(&self.chunk.arrivals, at % CHUNK + k);
        }
    }
}

/// A bin to be sorted.
struct BinWork<'a> {
    /// Its chunks, and how many deposits each holds.
    chunks: Vec<Room<'a>>,
    counts: Vec<usize>,
    /// The index of its first deposit among all.
    first: u32,
    buckets: Buckets<'a>,
}

/// The buckets of a bin.
struct Buckets<'a> {
    starts: &'a mut [u32],
    filled: &'a mut [u8],
}

/// The deposits of a bin, chunk by chunk. A deposit's number is [`CHUNK`] times that of its chunk, and its place there.
type ChunksOfBin<'a> = Vec<(&'a [Record], &'a [Direction])>;

impl<'a> BinWork<'a> {
    /// Sorts numbers of deposits, which stay in the first-level cache, and then fetches the deposits in their order. So what is
    /// far apart is read, which can be asked for long before, and what is written is consecutive: few stores wait for
    /// memory at a time. Returns where the deposits are then.
    fn sort(mut self, free: &Mutex<Vec<Room<'a>>>) -> Vec<Part> {
        let loose =
            self.chunks.iter().zip(&self.counts).map(|(room, count)| room.chunk.loose().first(*count));
        let loose: ChunksOfBin = loose.collect();
        self.buckets.count(&loose);
        let order = self.buckets.order(&loose, self.counts.iter().sum());
        self.buckets.starts.iter_mut().for_each(|start| *start += self.first);
        let mut sorted = take_last(&mut lock(free), order.len().div_ceil(CHUNK));
        fetch(&loose, &order, &mut sorted);
        lock(free).append(&mut self.chunks);
        sorted.iter().zip(order.chunks(CHUNK)).map(|(room, numbers)| (room.place, numbers.len())).collect()
    }
}

/// Takes the last `count` chunks.
fn take_last<'a>(chunks: &mut Vec<Room<'a>>, count: usize) -> Vec<Room<'a>> {
    chunks.split_off(chunks.len() - count)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Buckets<'_> {
    /// The place of a deposit's bucket among those of the bin.
    fn of(&self, record: &Record) -> usize {
        (record.bucket & (self.starts.len() as u32 - 1)) as usize
    }

    /// Counts the deposits of each bucket, and sets its start to where the next begins.
    fn count(&mut self, chunks: &ChunksOfBin) {
        self.starts.fill(0);
        for (at, (records, _)) in chunks.iter().enumerate() {
            let (next, from) = chunks[(at + 1).min(chunks.len() - 1)];
            for (k, record) in records.iter().enumerate() {
                // Directions are read when deposits are fetched in order.
                prefetch(next, k);
                prefetch(from, k);
                self.starts[self.of(record)] += 1;
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

    /// The numbers of all `count` deposits in order of their buckets. These are filled from the back: so the end of each
    /// becomes its start.
    fn order(&mut self, chunks: &ChunksOfBin, count: usize) -> Vec<u32> {
        let mut order = vec![0; count];
        for (first, (records, _)) in (0..).step_by(CHUNK).zip(chunks) {
            for (number, record) in (first..).zip(*records) {
                let bucket = self.of(record);
                let start = &mut self.starts[bucket];
                *start -= 1;
                order[*start as usize] = number;
            }
        }
        order
    }
}

/// Writes the deposits in this order.
fn fetch(chunks: &ChunksOfBin, order: &[u32], sorted: &mut [Room]) {
    let mut aheads = order.iter().skip(AHEAD);
    for (numbers, room) in order.chunks(CHUNK).zip(sorted) {
        let InOrder { arrivals, points: [xs, ys, zs], .. } = room.chunk.in_order_mut();
        for ((((number, x), y), z), arrival) in numbers.iter().zip(xs).zip(ys).zip(zs).zip(arrivals) {
            let ahead = *aheads.next().unwrap_or(number) as usize;
            let (records, directions) = chunks[ahead / CHUNK];
            prefetch(records, ahead % CHUNK);
            prefetch(directions, ahead % CHUNK);
            let (chunk, place) = (*number as usize / CHUNK, *number as usize % CHUNK);
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
    use crate::join::bins::bin_shift;
    use std::sync::Arc;

    #[test]
    fn without_deposits_buckets_alone_take_room() {
        let mut sorted = Sorted::new();
        assert_eq!(sorted.bytes(), 0);
        let cells = Cells::new(1.0, 1 << 12);
        sorted.fill(&mut [], &Slabs::new(), cells);
        let of_buckets = size_of::<u32>() * ((1 << 12) + 1) + (1 << 12) / 8 + 1;
        assert_eq!((sorted.count(), sorted.bytes()), (0, of_buckets));
    }

    /// Each thread sorts a bin at a time, and these may be the largest.
    #[test]
    fn there_is_room_for_the_bins_that_all_threads_sort() {
        let slabs_for = |threads, bins: &[Vec<Part>]| {
            let threads = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut sorted = Sorted::new();
            threads.install(|| sorted.take_room(bins, &Slabs::new()));
            sorted.slabs.len()
        };
        // Bins of half a slab, of 30 chunks, and of nothing.
        let bin = |chunks| vec![(Place::default(), CHUNK); chunks];
        let bins = [bin(30), bin(SLAB / 2), bin(0), bin(SLAB / 2), bin(30)];
        assert_eq!([1, 2, 3].map(|threads| slabs_for(threads, &bins)), [2, 3, 3]);
        assert_eq!(slabs_for(1, &[]), 0);
        // Chunks that are nearly empty are sorted into few.
        assert_eq!(slabs_for(1, &[vec![(Place::default(), 1); SLAB]]), 2);
    }

    /// Of the buckets that are looked up most are empty, and so few of `starts` are read.
    #[test]
    fn runs_are_empty_where_no_bucket_has_a_deposit() {
        let cells = Cells::new(1.0, 1 << 12);
        let is_filled = |bucket: u32| bucket.is_multiple_of(61) || bucket % 64 == 17 || bucket == cells.mask;
        let pool = Arc::new(Slabs::new());
        let mut binned = Binned::new(&pool);
        for bucket in (0..=cells.mask).filter(|bucket| is_filled(*bucket)) {
            let record = Record { bucket, ..Record::default() };
            binned.writer(1).push(record, [0.0; 4], bin_shift(cells));
        }
        let mut sorted = Sorted::new();
        sorted.fill(&mut [&mut binned], &pool, cells);
        let chunks = sorted.chunks();
        for bucket in 0..=cells.mask {
            for length in 1..=WINDOW {
                let expected = !(0..length).any(|k| is_filled((bucket + k) & cells.mask));
                assert_eq!(
                    sorted.deposits(&chunks).is_empty(Run { bucket, length }),
                    expected,
                    "{length} from {bucket}"
                );
            }
        }
        sorted.fill(&mut [], &pool, cells);
        assert!((0..=cells.mask).all(|bucket| sorted.deposits(&[]).is_empty(Run { bucket, length: WINDOW })));
    }
}

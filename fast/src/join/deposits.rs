//! Photons on their way from the lights to the visible points: deposited in bins, sorted by bucket.
//!
//! Deposits are thrown into [`BINS`] bins by the top bits of their bucket as they come, and each bin is then
//! put in order by counting. Both steps write to few places at a time, where one sort of all would scatter over
//! megabytes; and the bins are the units of parallel work.
//!
//! Bins are lists of chunks out of one pool: which thread deposits how much differs from iteration to iteration, and
//! what grew with each thread's largest share would grow as long as the render lasts.

use super::cells::{Cells, Run, WINDOW};
use crate::jobs::singly;
use crate::lanes::{MOST_LANES, Row};
use crate::pages::Pages;
use crate::pool::Pool;
use bytemuck::Pod;
use rayon::prelude::*;
use std::array;
use std::iter::once;
use std::mem::{replace, size_of};
use std::sync::Arc;

/// Number of bins.
pub(crate) const BINS: usize = 64;

/// A share of the deposits: room for so many more is kept.
const MARGIN: u64 = 16;

/// The bit of a record's surface that says: for any visible point on that sphere within the largest radius, the
/// photon arrives on the visible side.
pub(crate) const SAFE: u32 = 1 << 31;

/// A deposit: words point x y z, surface (sphere, and perhaps [`SAFE`]), flux r g b, bucket.
pub(crate) type Record = Row;

// A run and the bits before it in its byte fit into the two bytes that `Sorted::is_empty` reads.
const _: () = assert!(WINDOW <= 9);

/// Where a photon comes from; the last word is unused.
pub(crate) type Direction = [f32; 4];

/// Deposits of a chunk: 12 KiB. The pool is locked once for so many, and every thread holds [`BINS`] chunks.
const CHUNK: usize = 256;

/// Room for some deposits.
pub(crate) struct Chunk {
    records: [Record; CHUNK],
    directions: [Direction; CHUNK],
}

/// Bytes of empty bins.
pub(crate) const BYTES_OF_BINS: usize = BINS * size_of::<Chunk>();

/// Chunks at rest, shared by all that bin for one render.
pub(crate) type Chunks = Pool<Box<Chunk>>;

/// The deposits of some photons, in bins.
pub(crate) struct Binned {
    bins: Box<[Bin; BINS]>,
    chunks: Arc<Chunks>,
    /// How many there are.
    pub(crate) count: usize,
}

/// Deposits in no particular order, and the directions that belong to them.
struct Bin {
    /// The chunk that is being filled, and how far it is. It stays when the bin is emptied.
    open: Box<Chunk>,
    used: usize,
    full: Vec<Box<Chunk>>,
}

/// The deposits of all photons, in order of their buckets.
pub(crate) struct Sorted {
    /// Where they lie, for searching: a column per axis, followed by room for more, and for vectors that read past
    /// the end.
    pub(crate) points: [Pages<f32>; 3],
    /// What they bring, for those that have been found: words surface, flux r g b, direction x y z, bucket.
    pub(crate) arrivals: Pages<Row>,
    /// The deposits of bucket b are those from `starts[b]` to `starts[b + 1]`.
    pub(crate) starts: Vec<u32>,
    /// A bit per bucket that has deposits, from the lowest bit of the first byte on; the first byte stands at the end
    /// once more. Most of what is looked up is empty, and this stays in the cache, where `starts` does not.
    filled: Vec<u8>,
}

impl Chunk {
    fn new() -> Box<Self> {
        Box::new(Self { records: [Row::default(); CHUNK], directions: [[0.0; 4]; CHUNK] })
    }

    /// The first `count` deposits.
    fn first(&self, count: usize) -> (&[Record], &[Direction]) {
        (&self.records[..count], &self.directions[..count])
    }
}

impl Bin {
    /// Another chunk to fill, in the place of a full one.
    #[cold]
    #[inline(never)]
    fn go_on(&mut self, chunks: &Chunks) {
        self.full.push(replace(&mut self.open, chunks.take(Chunk::new)));
        self.used = 0;
    }

    fn count(&self) -> usize {
        self.full.len() * CHUNK + self.used
    }

    /// The deposits, chunk by chunk.
    fn runs(&self) -> impl Iterator<Item = (&[Record], &[Direction])> {
        self.full.iter().map(|chunk| chunk.first(CHUNK)).chain(once(self.open.first(self.used)))
    }
}

impl Binned {
    /// Empty bins that take their chunks from `chunks`.
    pub(crate) fn new(chunks: &Arc<Chunks>) -> Self {
        let bin = |_| Bin { open: chunks.take(Chunk::new), used: 0, full: Vec::new() };
        Self { bins: Box::new(array::from_fn(bin)), chunks: Arc::clone(chunks), count: 0 }
    }

    /// Forgets all deposits, and gives back all chunks but one per bin.
    pub(crate) fn clear(&mut self) {
        self.chunks.put_all(self.bins.iter_mut().flat_map(|bin| bin.full.drain(..)));
        self.bins.iter_mut().for_each(|bin| bin.used = 0);
        self.count = 0;
    }

    /// Adds a deposit; `shift` takes a bucket to its bin.
    #[inline(always)]
    pub(crate) fn push(&mut self, record: Record, direction: Direction, shift: u32) {
        let bin = &mut self.bins[(record.0[7].to_bits() >> shift) as usize & (BINS - 1)];
        if bin.used == CHUNK {
            bin.go_on(&self.chunks);
        }
        let place = bin.used % CHUNK; // it is less, but the compiler does not know
        bin.open.records[place] = record;
        bin.open.directions[place] = direction;
        bin.used += 1;
        self.count += 1;
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        BYTES_OF_BINS + self.bins.iter().map(|bin| bin.full.len() * size_of::<Chunk>()).sum::<usize>()
    }
}

/// Makes sure that as many deposits as these, and some more, find chunks at rest, whichever bins they go to: so the
/// first round takes what all later ones will need.
pub(crate) fn reserve(chunks: &Chunks, deposits: usize) {
    chunks.fill((with_margin(deposits as u64) as usize).div_ceil(CHUNK), Chunk::new);
}

/// Bytes of all chunks at rest.
pub(crate) fn bytes_at_rest(chunks: &Chunks) -> usize {
    chunks.count() * size_of::<Chunk>()
}

/// What takes a bucket of `cells` to its bin.
pub(crate) fn bin_shift(cells: Cells) -> u32 {
    (cells.mask + 1).trailing_zeros() - BINS.trailing_zeros()
}

impl Sorted {
    pub(crate) fn new() -> Self {
        let points = array::from_fn(|_| Pages::zeros(0));
        Self { points, arrivals: Pages::zeros(0), starts: Vec::new(), filled: Vec::new() }
    }

    /// How many deposits there are.
    pub(crate) fn count(&self) -> usize {
        self.starts.last().map_or(0, |end| *end as usize)
    }

    /// Forgets all deposits and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.starts.fill(0);
        self.filled.fill(0);
    }

    /// Sorts the deposits of `parts`.
    pub(crate) fn fill(&mut self, parts: &[&Binned], cells: Cells) {
        let total: usize = parts.iter().map(|part| part.count).sum();
        self.points.iter_mut().for_each(|column| make_room(column, total + MOST_LANES));
        make_room(&mut self.arrivals, total);
        let buckets = cells.mask as usize + 1;
        self.starts.resize(buckets + 1, 0);
        self.filled.resize(buckets / 8 + 1, 0);
        let mut columns = self.points.each_mut().map(|column| &mut column[..]);
        let mut arrivals = &mut self.arrivals[..];
        let per_bin = buckets / BINS;
        let places = self.starts[..buckets].chunks_mut(per_bin).zip(self.filled.chunks_mut(per_bin / 8));
        let mut work = Vec::with_capacity(BINS);
        let mut first = 0;
        for (bin, (starts, filled)) in places.enumerate() {
            let count = parts.iter().map(|part| part.bins[bin].count()).sum();
            let points = columns.each_mut().map(|column| column.split_off_mut(..count).unwrap_or_default());
            let mine = arrivals.split_off_mut(..count).unwrap_or_default();
            work.push(BinWork { bin, first, points, arrivals: mine, starts, filled });
            first += count as u32;
        }
        singly(work.into_par_iter()).for_each(|bin| bin.sort(parts));
        self.starts[buckets] = total as u32;
        self.filled[buckets / 8] = self.filled[0];
    }

    /// True if some buckets, in which the last is followed by the first, have no deposits.
    #[inline(always)]
    pub(crate) fn is_empty(&self, run: Run) -> bool {
        let byte = run.bucket as usize / 8;
        let bits = u32::from(self.filled[byte]) | u32::from(self.filled[byte + 1]) << 8;
        (bits >> (run.bucket % 8)) & ((1 << run.length) - 1) == 0
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let points: usize = self.points.iter().map(|column| size_of_val(&column[..])).sum();
        points + size_of_val(&self.arrivals[..]) + size_of_val(&self.starts[..]) + self.filled.len()
    }
}

/// Lengthens `values` if they are fewer than `count`.
fn make_room<T: Pod + Send + Sync>(values: &mut Pages<T>, count: usize) {
    if count > values.len() {
        // The old ones first, so that there are never both.
        *values = Pages::zeros(0);
        *values = Pages::zeros(with_margin(count as u64) as usize);
    }
}

/// What is held for so many deposits: iterations differ by some percent.
pub(crate) fn with_margin(deposits: u64) -> u64 {
    deposits + deposits / MARGIN
}

/// A bin to be sorted into its part of the output.
struct BinWork<'a> {
    bin: usize,
    first: u32,
    points: [&'a mut [f32]; 3],
    arrivals: &'a mut [Row],
    starts: &'a mut [u32],
    filled: &'a mut [u8],
}

impl BinWork<'_> {
    fn sort(self, parts: &[&Binned]) {
        let runs = || parts.iter().flat_map(|part| part.bins[self.bin].runs());
        let local = self.starts.len() as u32 - 1;
        let bucket = |record: &Record| (record.0[7].to_bits() & local) as usize;
        self.starts.fill(0);
        for (records, _) in runs() {
            for record in records {
                self.starts[bucket(record)] += 1;
            }
        }
        let mut end = 0;
        for (starts, filled) in self.starts.chunks_mut(8).zip(self.filled) {
            *filled = 0;
            for (k, start) in starts.iter_mut().enumerate() {
                *filled |= u8::from(*start > 0) << k;
                end += *start;
                *start = end;
            }
        }
        let [xs, ys, zs] = self.points;
        // Filled from the back, each bucket's end becomes its start.
        for (records, directions) in runs() {
            for (record, direction) in records.iter().zip(directions) {
                let start = &mut self.starts[bucket(record)];
                *start -= 1;
                let place = *start as usize;
                let ([x, y, z, surface, r, g, b, number], [wx, wy, wz, _]) = (record.0, *direction);
                (xs[place], ys[place], zs[place]) = (x, y, z);
                self.arrivals[place] = Row([surface, r, g, b, wx, wy, wz, number]);
            }
        }
        self.starts.iter_mut().for_each(|start| *start += self.first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorted_deposits_take_their_room_and_what_vectors_read_behind() {
        let mut sorted = Sorted::new();
        assert_eq!(sorted.bytes(), 0);
        let cells = Cells::new(1.0, 1 << 12);
        sorted.fill(&[], cells);
        let coordinates = 3 * size_of::<f32>() * with_margin(MOST_LANES as u64) as usize;
        let of_buckets = size_of::<u32>() * ((1 << 12) + 1) + (1 << 12) / 8 + 1;
        assert_eq!((sorted.count(), sorted.bytes()), (0, coordinates + of_buckets));
    }

    /// Of the buckets that are looked up most are empty, and so few of `starts` are read.
    #[test]
    fn runs_are_empty_where_no_bucket_has_a_deposit() {
        let cells = Cells::new(1.0, 1 << 12);
        let is_filled = |bucket: u32| bucket.is_multiple_of(61) || bucket % 64 == 17 || bucket == cells.mask;
        let mut binned = Binned::new(&Arc::new(Chunks::new()));
        for bucket in (0..=cells.mask).filter(|bucket| is_filled(*bucket)) {
            let record = Row([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::from_bits(bucket)]);
            binned.push(record, [0.0; 4], bin_shift(cells));
        }
        let mut sorted = Sorted::new();
        sorted.fill(&[&binned], cells);
        for bucket in 0..=cells.mask {
            for length in 1..=WINDOW {
                let expected = !(0..length).any(|k| is_filled((bucket + k) & cells.mask));
                assert_eq!(sorted.is_empty(Run { bucket, length }), expected, "{length} from {bucket}");
            }
        }
        sorted.clear();
        assert!((0..=cells.mask).all(|bucket| sorted.is_empty(Run { bucket, length: WINDOW })));
    }
}

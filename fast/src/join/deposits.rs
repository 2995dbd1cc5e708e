//! Photons on their way from the lights to the visible points: deposited in bins, sorted by bucket.
//!
//! Deposits are thrown into [`BINS`] bins by the top bits of their bucket as they come, and each bin is then
//! put in order by counting. Both steps write to few places at a time, where one sort of all would scatter over
//! megabytes; and the bins are the units of parallel work.
//!
//! Bins are lists of chunks out of one pool: which thread deposits how much differs from iteration to iteration, and
//! what grew with each thread's largest share would grow as long as the render lasts.

use super::cells::Cells;
use crate::lanes::{MOST_LANES, Row};
use crate::pool::Pool;
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
    /// Records, followed by room for more, and for vectors that read past the end.
    pub(crate) records: Vec<Record>,
    /// Directions, in the order of the records.
    pub(crate) directions: Vec<Direction>,
    /// The deposits of bucket b are those from `starts[b]` to `starts[b + 1]`.
    pub(crate) starts: Vec<u32>,
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
        make_room(&mut self.records, total + MOST_LANES, Row::default());
        make_room(&mut self.directions, total + MOST_LANES, [0.0; 4]);
        self.starts.resize(cells.mask as usize + 2, 0);
        let buckets = self.starts.len() / BINS;
        let mut work = Vec::with_capacity(BINS);
        let (mut records, mut directions) = (&mut self.records[..], &mut self.directions[..]);
        let mut first = 0;
        for (bin, starts) in self.starts[..buckets * BINS].chunks_mut(buckets).enumerate() {
            let count = parts.iter().map(|part| part.bins[bin].count()).sum();
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

/// Lengthens `values` if they are fewer than `count`.
fn make_room<T: Copy>(values: &mut Vec<T>, count: usize, value: T) {
    if count > values.len() {
        let room = with_margin(count as u64) as usize;
        values.clear();
        values.reserve_exact(room);
        values.resize(room, value);
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
    records: &'a mut [Record],
    directions: &'a mut [Direction],
    starts: &'a mut [u32],
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
        for start in self.starts.iter_mut() {
            end += *start;
            *start = end;
        }
        // Filled from the back, each bucket's end becomes its start.
        for (records, directions) in runs() {
            for (record, direction) in records.iter().zip(directions) {
                let place = &mut self.starts[bucket(record)];
                *place -= 1;
                self.records[*place as usize] = *record;
                self.directions[*place as usize] = *direction;
            }
        }
        self.starts.iter_mut().for_each(|start| *start += self.first);
    }
}

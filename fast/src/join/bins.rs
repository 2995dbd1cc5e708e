//! Bins: where the photon pass puts deposits, by the top bits of their bucket.
//!
//! Sorting takes two steps, each of which writes to few places at a time: deposits go into [`BINS`] bins as they come, and
//! then each bin is sorted by itself ([`super::sorted`]). One sort of all would scatter over megabytes.
//!
//! Bins are lists of chunks from one pool. Which thread deposits how much differs from iteration to iteration: bins that
//! grew to the largest share of each thread would grow as long as the render lasts.

use super::cells::Cells;
use super::deposit::{Direction, Record};
use crate::pool::Pool;
use lanes::prefetch;
use std::array;
use std::iter::once;
use std::mem::{replace, size_of};
use std::sync::Arc;

/// Number of bins.
pub(crate) const BINS: usize = 64;

/// Room is kept for one in so many deposits more than there were, as iterations differ by some percent.
const MARGIN: u64 = 16;

/// Deposits of a chunk, which takes 12 KiB. The pool is locked once per chunk, and every thread holds at least [`BINS`] of
/// them.
pub(super) const CHUNK: usize = 256;

/// So many deposits before its turn, the room for one is asked for from memory.
const AHEAD: usize = 12;

/// Room for [`CHUNK`] deposits.
pub(crate) struct Chunk {
    records: [Record; CHUNK],
    directions: [Direction; CHUNK],
}

/// Bytes of empty bins.
pub(crate) const BYTES_OF_BINS: usize = BINS * size_of::<Chunk>();

/// Chunks that are not in use, shared by all threads of a render.
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
    /// The chunk that is being filled, and how many deposits it holds. It stays when the bin is cleared.
    open: Box<Chunk>,
    used: usize,
    full: Vec<Box<Chunk>>,
}

impl Chunk {
    fn new() -> Box<Self> {
        Box::new(Self { records: [Record::default(); CHUNK], directions: [[0.0; 4]; CHUNK] })
    }

    /// The first `count` deposits.
    fn first(&self, count: usize) -> (&[Record], &[Direction]) {
        (&self.records[..count], &self.directions[..count])
    }
}

impl Bin {
    /// Replaces a full chunk by an empty one.
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
    fn chunks(&self) -> impl Iterator<Item = (&[Record], &[Direction])> {
        self.full.iter().map(|chunk| chunk.first(CHUNK)).chain(once(self.open.first(self.used)))
    }
}

impl Binned {
    /// Empty bins that take their chunks from `chunks`.
    pub(crate) fn new(chunks: &Arc<Chunks>) -> Self {
        let bin = |_| Bin { open: chunks.take(Chunk::new), used: 0, full: Vec::new() };
        Self { bins: Box::new(array::from_fn(bin)), chunks: Arc::clone(chunks), count: 0 }
    }

    /// Drops all deposits, and returns all chunks but one per bin to the pool.
    pub(crate) fn clear(&mut self) {
        self.chunks.put_all(self.bins.iter_mut().flat_map(|bin| bin.full.drain(..)));
        self.bins.iter_mut().for_each(|bin| bin.used = 0);
        self.count = 0;
    }

    /// Adds a deposit; `shift` is [`bin_shift`].
    #[inline(always)]
    pub(crate) fn push(&mut self, record: Record, direction: Direction, shift: u32) {
        let bin = &mut self.bins[(record.bucket >> shift) as usize & (BINS - 1)];
        if bin.used == CHUNK {
            bin.go_on(&self.chunks);
        }
        let place = bin.used % CHUNK; // it is less already; this spares the check of the index
        // Chunks have left the cache since they were last in use, and few stores wait for memory at a time.
        prefetch(&bin.open.records, place + AHEAD);
        prefetch(&bin.open.directions, place + AHEAD);
        bin.open.records[place] = record;
        bin.open.directions[place] = direction;
        bin.used += 1;
        self.count += 1;
    }

    /// The deposits of one bin, chunk by chunk.
    pub(crate) fn bin(&self, bin: usize) -> impl Iterator<Item = (&[Record], &[Direction])> {
        self.bins[bin].chunks()
    }

    /// The number of deposits of one bin.
    pub(crate) fn count_of(&self, bin: usize) -> usize {
        self.bins[bin].count()
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        BYTES_OF_BINS + self.bins.iter().map(|bin| bin.full.len() * size_of::<Chunk>()).sum::<usize>()
    }
}

/// Fills the pool with chunks for so many deposits and some more, so that later rounds need no new memory.
pub(crate) fn reserve(chunks: &Chunks, deposits: usize) {
    chunks.fill((with_margin(deposits as u64) as usize).div_ceil(CHUNK), Chunk::new);
}

/// Bytes of all chunks that are not in use.
pub(crate) fn bytes_at_rest(chunks: &Chunks) -> usize {
    chunks.count() * size_of::<Chunk>()
}

/// The number of bits by which a bucket of `cells` is shifted to give its bin.
pub(crate) fn bin_shift(cells: Cells) -> u32 {
    (cells.mask + 1).trailing_zeros() - BINS.trailing_zeros()
}

/// The room that is kept for so many deposits.
pub(crate) fn with_margin(deposits: u64) -> u64 {
    deposits + deposits / MARGIN
}

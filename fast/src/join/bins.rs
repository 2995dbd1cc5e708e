//! Bins: where the photon pass puts deposits, by the top bits of their bucket.
//!
//! Sorting takes two steps, each of which writes to few places at a time: deposits go into [`BINS`] bins as they come, and
//! then each bin is sorted by itself ([`super::sorted`]). One sort of all would scatter over megabytes.
//!
//! Bins are lists of chunks, and chunks are parts of slabs from one pool. Which thread deposits how much differs from iteration
//! to iteration: bins that grew to the largest share of each thread would grow as long as the render lasts.

use super::cells::Cells;
use super::deposit::{Direction, Record};
use crate::pages::{LARGE, Pages};
use crate::pool::Pool;
use bytemuck::{Pod, Zeroable};
use lanes::prefetch;
use std::array;
use std::iter::once;
use std::mem::{replace, size_of};
use std::sync::Arc;

/// Number of bins.
pub(crate) const BINS: usize = 64;

/// Room is kept for one in so many deposits more than there were, as iterations differ by some percent.
const MARGIN: u64 = 16;

/// Deposits of a chunk, which takes 12 KiB. Every thread holds at least [`BINS`] of them.
pub(super) const CHUNK: usize = 256;

/// So many deposits before its turn, the room for one is asked for from memory.
const AHEAD: usize = 12;

/// Room for [`CHUNK`] deposits.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Chunk {
    records: [Record; CHUNK],
    directions: [Direction; CHUNK],
}

/// Chunks of a slab, which fills a large page.
const SLAB: usize = LARGE / size_of::<Chunk>();

/// Room for many chunks.
type Slab = Pages<Chunk>;

/// What a thread's bins take beside what full chunks take: a chunk for each, and the rest of the last slab, a page of which
/// the system gives all or nothing.
pub(crate) const BYTES_OF_BINS: usize = (BINS + SLAB) * size_of::<Chunk>();

// A slab has a chunk for each bin.
const _: () = assert!(BINS <= SLAB);

/// Slabs that are not in use, shared by all threads of a render.
pub(crate) type Slabs = Pool<Slab>;

/// The deposits of some photons, in bins.
pub(crate) struct Binned {
    bins: Box<[Bin; BINS]>,
    /// Room for the chunks, which are numbered through.
    slabs: Vec<Slab>,
    /// Where further slabs come from.
    pool: Arc<Slabs>,
    /// The number of the first chunk that is not in use.
    next: usize,
    /// How many deposits there are.
    pub(crate) count: usize,
}

/// Deposits in no particular order, and the directions that belong to them.
#[derive(Default)]
struct Bin {
    /// The chunk that is being filled, and how many deposits it holds.
    open: Place,
    used: usize,
    full: Vec<Place>,
}

/// Where a chunk is: the slab, and its place there.
#[derive(Clone, Copy, Default)]
struct Place {
    slab: u32,
    chunk: u32,
}

/// Bins with room for some more deposits.
pub(crate) struct Writer<'a> {
    bins: &'a mut [Bin; BINS],
    slabs: Vec<&'a mut [Chunk]>,
    next: &'a mut usize,
    count: &'a mut usize,
}

impl Chunk {
    /// The first `count` deposits.
    fn first(&self, count: usize) -> (&[Record], &[Direction]) {
        (&self.records[..count], &self.directions[..count])
    }
}

impl Place {
    fn of(number: usize) -> Self {
        Self { slab: (number / SLAB) as u32, chunk: (number % SLAB) as u32 }
    }
}

impl Bin {
    /// Goes on in chunk `next`, the first that is not in use.
    #[cold]
    #[inline(never)]
    fn go_on(&mut self, next: &mut usize) {
        self.full.push(replace(&mut self.open, Place::of(*next)));
        self.used = 0;
        *next += 1;
    }

    fn count(&self) -> usize {
        self.full.len() * CHUNK + self.used
    }
}

impl Binned {
    /// Empty bins that take their slabs from `pool`.
    pub(crate) fn new(pool: &Arc<Slabs>) -> Self {
        let (bins, slabs) = (Box::new(array::from_fn(|_| Bin::default())), vec![pool.take(new_slab)]);
        let mut binned = Self { bins, slabs, pool: Arc::clone(pool), next: 0, count: 0 };
        binned.clear();
        binned
    }

    /// Drops all deposits, and returns all slabs but one to the pool.
    pub(crate) fn clear(&mut self) {
        self.pool.put_all(self.slabs.drain(1..));
        for (number, bin) in self.bins.iter_mut().enumerate() {
            bin.full.clear();
            (bin.open, bin.used) = (Place::of(number), 0);
        }
        (self.next, self.count) = (BINS, 0);
    }

    /// For as many as `most` deposits more.
    pub(crate) fn writer(&mut self, most: usize) -> Writer<'_> {
        let Self { bins, slabs, pool, next, count } = self;
        // If each bin needs another chunk for a few of them.
        let chunks = *next + BINS + most / CHUNK;
        while slabs.len() * SLAB < chunks {
            slabs.push(pool.take(new_slab));
        }
        Writer { bins, slabs: slabs.iter_mut().map(|slab| &mut slab[..]).collect(), next, count }
    }

    /// The deposits of one bin, chunk by chunk.
    pub(crate) fn bin(&self, bin: usize) -> impl Iterator<Item = (&[Record], &[Direction])> {
        let Bin { open, used, full } = &self.bins[bin];
        let chunks = full.iter().map(|place| (place, CHUNK)).chain(once((open, *used)));
        chunks.map(|(place, count)| self.slabs[place.slab as usize][place.chunk as usize].first(count))
    }

    /// The number of deposits of one bin.
    pub(crate) fn count_of(&self, bin: usize) -> usize {
        self.bins[bin].count()
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.slabs.iter().map(|slab| size_of_val(&slab[..])).sum()
    }
}

impl Writer<'_> {
    /// Adds a deposit; `shift` is [`bin_shift`].
    #[inline(always)]
    pub(crate) fn push(&mut self, record: Record, direction: Direction, shift: u32) {
        let bin = &mut self.bins[(record.bucket >> shift) as usize & (BINS - 1)];
        if bin.used == CHUNK {
            bin.go_on(self.next);
        }
        let place = bin.used % CHUNK; // it is less already; this spares the check of the index
        let chunk = &mut self.slabs[bin.open.slab as usize][bin.open.chunk as usize];
        // Chunks have left the cache since they were last in use, and few stores wait for memory at a time.
        prefetch(&chunk.records, place + AHEAD);
        prefetch(&chunk.directions, place + AHEAD);
        chunk.records[place] = record;
        chunk.directions[place] = direction;
        bin.used += 1;
        *self.count += 1;
    }
}

fn new_slab() -> Slab {
    Pages::unwritten(SLAB)
}

/// Fills the pool with slabs for so many deposits and some more, so that later rounds need no new memory.
pub(crate) fn reserve(slabs: &Slabs, deposits: usize) {
    slabs.fill((with_margin(deposits as u64) as usize).div_ceil(CHUNK * SLAB), new_slab);
}

/// Bytes of all slabs that are not in use.
pub(crate) fn bytes_at_rest(slabs: &Slabs) -> usize {
    slabs.count() * SLAB * size_of::<Chunk>()
}

/// The number of bits by which a bucket of `cells` is shifted to give its bin.
pub(crate) fn bin_shift(cells: Cells) -> u32 {
    (cells.mask + 1).trailing_zeros() - BINS.trailing_zeros()
}

/// The room that is kept for so many deposits.
pub(crate) fn with_margin(deposits: u64) -> u64 {
    deposits + deposits / MARGIN
}

//! Bins: where the photon pass puts deposits, by the top bits of their bucket.
//!
//! Sorting takes two steps, each of which writes to few places at a time: deposits go into [`BINS`] bins as they come, and
//! then each bin is sorted by itself ([`super::sorted`]). One sort of all would scatter over megabytes.
//!
//! Bins are lists of chunks ([`super::chunk`]) from one pool. Which thread deposits how much differs from iteration to
//! iteration: bins that grew to the largest share of each thread would grow as long as the render lasts.

use super::cells::Cells;
use super::chunk::{CHUNK, Chunk, Place, SLAB, Slab, Slabs, bytes_of_slabs, new_slab};
use super::deposit::{Direction, Record};
use lanes::prefetch;
use std::array;
use std::iter::once;
use std::mem::{replace, size_of, take};
use std::sync::Arc;

/// Number of bins.
pub(crate) const BINS: usize = 64;

/// Room is kept for one in so many deposits more than there were, as iterations differ by some percent.
const MARGIN: u64 = 16;

/// So many deposits before its turn, the room for one is asked for from memory.
const AHEAD: usize = 12;

/// What a thread's bins take beside what full chunks take: a chunk for each, and the rest of the last slab, a page of which
/// the system gives all or nothing.
pub(crate) const BYTES_OF_BINS: usize = (BINS + SLAB) * size_of::<Chunk>();

// A slab has a chunk for each bin.
const _: () = assert!(BINS <= SLAB);

/// The deposits of some photons, in bins.
pub(crate) struct Binned {
    bins: Box<[Bin; BINS]>,
    /// Room for the chunks, which are numbered through. Empty until there are deposits.
    slabs: Vec<Slab>,
    /// Where slabs come from.
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

/// A chunk of a bin, and how many deposits it holds.
pub(super) type Part = (Place, usize);

/// Bins with room for some more deposits.
pub(crate) struct Writer<'a> {
    bins: &'a mut [Bin; BINS],
    slabs: Vec<&'a mut [Chunk]>,
    next: &'a mut usize,
    count: &'a mut usize,
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

    /// Empties the bin. Returns its chunks, the slabs of which come after `slabs` others.
    fn take(&mut self, slabs: u32) -> impl Iterator<Item = Part> {
        let last = (self.open, take(&mut self.used));
        let parts = self.full.drain(..).map(|place| (place, CHUNK)).chain(once(last));
        parts.filter(|(_, count)| *count > 0).map(move |(place, count)| (place.after(slabs), count))
    }
}

impl Binned {
    /// Empty bins that take their slabs from `pool`.
    pub(crate) fn new(pool: &Arc<Slabs>) -> Self {
        let bins = Box::new(array::from_fn(|_| Bin::default()));
        Self { bins, slabs: Vec::new(), pool: Arc::clone(pool), next: 0, count: 0 }
    }

    /// Drops all deposits, and returns all slabs to the pool.
    pub(crate) fn clear(&mut self) {
        self.pool.put_all(self.slabs.drain(..));
        for bin in self.bins.iter_mut() {
            bin.full.clear();
            bin.used = 0;
        }
        (self.next, self.count) = (0, 0);
    }

    /// Empties the bins. Adds the slabs to others, and the chunks of each bin to those of the same bin.
    pub(super) fn hand_over(&mut self, slabs: &mut Vec<Slab>, of_bins: &mut [Vec<Part>; BINS]) {
        let before = slabs.len() as u32;
        slabs.append(&mut self.slabs);
        for (bin, others) in self.bins.iter_mut().zip(of_bins) {
            others.extend(bin.take(before));
        }
        (self.next, self.count) = (0, 0);
    }

    /// For as many as `most` deposits more.
    pub(crate) fn writer(&mut self, most: usize) -> Writer<'_> {
        let Self { bins, slabs, pool, next, count } = self;
        if slabs.is_empty() {
            bins.iter_mut().enumerate().for_each(|(number, bin)| bin.open = Place::of(number));
            *next = BINS;
        }
        // If each bin needs another chunk for a few of them.
        let chunks = *next + BINS + most / CHUNK;
        while slabs.len() * SLAB < chunks {
            slabs.push(pool.take(new_slab));
        }
        Writer { bins, slabs: slabs.iter_mut().map(|slab| &mut slab[..]).collect(), next, count }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        bytes_of_slabs(self.slabs.len())
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
        let chunk = self.slabs[bin.open.slab as usize][bin.open.chunk as usize].loose_mut();
        // Chunks have left the cache since they were last in use, and few stores wait for memory at a time.
        prefetch(&chunk.records, place + AHEAD);
        prefetch(&chunk.directions, place + AHEAD);
        chunk.records[place] = record;
        chunk.directions[place] = direction;
        bin.used += 1;
        *self.count += 1;
    }
}

/// Fills the pool, beside `used` slabs, up to as many as so many deposits and some more take, so that later rounds need no new
/// memory.
pub(super) fn reserve(slabs: &Slabs, used: usize, deposits: usize) {
    let wanted = (with_margin(deposits as u64) as usize).div_ceil(CHUNK * SLAB);
    slabs.fill(wanted.saturating_sub(used), new_slab);
}

/// Bytes of all slabs that are not in use.
pub(crate) fn bytes_at_rest(slabs: &Slabs) -> usize {
    bytes_of_slabs(slabs.count())
}

/// The number of bits by which a bucket of `cells` is shifted to give its bin.
pub(crate) fn bin_shift(cells: Cells) -> u32 {
    (cells.mask + 1).trailing_zeros() - BINS.trailing_zeros()
}

/// The room that is kept for so many deposits.
pub(crate) fn with_margin(deposits: u64) -> u64 {
    deposits + deposits / MARGIN
}

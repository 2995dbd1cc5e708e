//! Chunks: room for some deposits, which lie in it as they came, or sorted.
//!
//! Chunks are parts of slabs, which come from one pool and fill a large page each. Sorting reads chunks and writes others, and
//! those that were read are written next. So deposits take their room once, and a bin's, and not twice: a short render spends
//! much of its time on memory that it writes for the first time.

use super::deposit::{Arrival, Direction, Record};
use crate::pages::{LARGE, Pages};
use crate::pool::Pool;
use bytemuck::{Pod, Zeroable, cast_mut, cast_ref};
use lanes::MOST_LANES;
use std::mem::size_of;

/// Deposits of a chunk, which takes 12 KiB.
pub(super) const CHUNK: usize = 256;

/// The coordinates of a chunk along an axis, with room for vectors that read past the end.
const COLUMN: usize = CHUNK + MOST_LANES;

/// The words of a chunk that directions take before deposits are sorted, and points after that.
const WORDS: usize = CHUNK * size_of::<Direction>() / size_of::<f32>();

/// Room for [`CHUNK`] deposits.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Chunk([[u64; 8]; size_of::<Loose>() / 64]);

/// Deposits as they came.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Loose {
    pub(super) records: [Record; CHUNK],
    pub(super) directions: [Direction; CHUNK],
}

/// Deposits in order of their buckets.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct InOrder {
    /// What they bring, which is read once they are found.
    pub(super) arrivals: [Arrival; CHUNK],
    /// Their points, which the search reads: a column per axis.
    pub(super) points: [[f32; COLUMN]; 3],
    unused: [f32; WORDS - 3 * COLUMN],
}

/// Chunks of a slab.
pub(super) const SLAB: usize = LARGE / size_of::<Chunk>();

/// Room for many chunks.
pub(super) type Slab = Pages<Chunk>;

/// Slabs that are not in use, shared by all threads of a render.
pub(crate) type Slabs = Pool<Slab>;

/// Where a chunk is: the slab, and its place there.
#[derive(Clone, Copy, Default)]
pub(super) struct Place {
    pub(super) slab: u32,
    pub(super) chunk: u32,
}

impl Chunk {
    #[inline(always)]
    pub(super) fn loose(&self) -> &Loose {
        cast_ref(self)
    }

    #[inline(always)]
    pub(super) fn loose_mut(&mut self) -> &mut Loose {
        cast_mut(self)
    }

    pub(super) fn in_order(&self) -> &InOrder {
        cast_ref(self)
    }

    pub(super) fn in_order_mut(&mut self) -> &mut InOrder {
        cast_mut(self)
    }
}

impl Loose {
    /// The first `count` deposits.
    pub(super) fn first(&self, count: usize) -> (&[Record], &[Direction]) {
        (&self.records[..count], &self.directions[..count])
    }
}

impl Place {
    /// The place of a chunk of slabs that are numbered through.
    pub(super) fn of(number: usize) -> Self {
        Self { slab: (number / SLAB) as u32, chunk: (number % SLAB) as u32 }
    }

    /// The same chunk if its slab comes after `slabs` others.
    pub(super) fn after(self, slabs: u32) -> Self {
        Self { slab: self.slab + slabs, ..self }
    }

    /// The chunk's number.
    pub(super) fn number(self) -> usize {
        self.slab as usize * SLAB + self.chunk as usize
    }
}

pub(super) fn new_slab() -> Slab {
    Pages::zeros(SLAB)
}

/// Bytes of so many slabs.
pub(super) fn bytes_of_slabs(count: usize) -> usize {
    count * SLAB * size_of::<Chunk>()
}

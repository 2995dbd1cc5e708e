//! Lists of photons that a first test has found.

use super::runs::Runs;
use crate::paths::Vectors;
use crate::pixels::GROUP;
use lanes::{Lanes, MOST_LANES, V3};
use std::array::from_fn;

/// The most photons that are found before they are tested: their flux fits into a 32-bit sum ([`FLUSH`]).
pub(crate) const MOST_FOUND: usize = 1024;

/// The length of the lists: vectors write past the last photon.
const FOUND_ROOM: usize = MOST_FOUND + MOST_LANES;

/// Photons of at most 2^21 that a 32-bit sum of fluxes holds: 2047 * 2^21 < 2^32.
const FLUSH: usize = 2047;

const _: () = assert!(MOST_FOUND <= FLUSH);

/// Photons that have been found.
pub(crate) struct Found {
    /// Their points, if these were stored.
    pub(crate) points: Box<Vectors<FOUND_ROOM>>,
    /// Their indices among the sorted deposits.
    pub(crate) indices: Box<[u32; FOUND_ROOM]>,
    /// Which of them may arrive on the side that is not seen.
    pub(crate) doubtful: Box<[u32; FOUND_ROOM]>,
    pub(crate) count: usize,
}

impl Found {
    fn new() -> Self {
        let words = || Box::new([0; FOUND_ROOM]);
        Self { points: Box::new(Vectors::ZERO), indices: words(), doubtful: words(), count: 0 }
    }

    /// True if another vector may not fit.
    #[inline(always)]
    pub(crate) fn is_full<L: Lanes>(&self) -> bool {
        self.count > MOST_FOUND - L::N
    }

    /// Where the next photon goes. The count is less than the most; this spares the check of the place.
    #[inline(always)]
    fn end(&self) -> usize {
        self.count % MOST_FOUND
    }

    /// Appends the lanes `near` of the photons from index `from` on, which lie at `p`.
    #[inline(always)]
    pub(crate) fn append<L: Lanes>(&mut self, near: L::M, p: V3<L>, from: usize) {
        self.points.compress(near, p, self.end());
        self.append_indices::<L>(near, from);
    }

    /// The same without points.
    #[inline(always)]
    pub(crate) fn append_indices<L: Lanes>(&mut self, near: L::M, from: usize) {
        let end = self.end();
        L::compress_u(near, L::u(from as u32) + L::iota(), &mut self.indices[end..]);
        self.count += L::mask_bits(near).count_ones() as usize;
    }
}

/// Buffers of the join, kept from group to group.
pub(crate) struct JoinBuffers {
    /// What each point of a group has looked up; of a group that looks up once, the first.
    pub(crate) runs: Box<[Runs; GROUP]>,
    /// A list for each half of a group.
    pub(crate) found: [Found; 2],
}

impl JoinBuffers {
    pub(crate) fn new() -> Self {
        Self { runs: Box::new(from_fn(|_| Runs::new())), found: [Found::new(), Found::new()] }
    }
}

//! Lists of photons that a first test has found.

use super::runs::Runs;
use crate::paths::Vectors;
use lanes::{Lanes, V3};

/// The most photons that are found before they are tested: their flux fits into a 32-bit sum ([`FLUSH`]).
pub(crate) const MOST_FOUND: usize = 1024;

/// Photons of at most 2^21 that a 32-bit sum of fluxes holds: 2047 * 2^21 < 2^32.
const FLUSH: usize = 2047;

const _: () = assert!(MOST_FOUND <= FLUSH);

/// Photons that have been found.
pub(crate) struct Found {
    /// Their points, if these were stored.
    pub(crate) points: Box<Vectors<MOST_FOUND>>,
    /// Their indices among the sorted deposits.
    pub(crate) indices: Box<[u32; MOST_FOUND]>,
    pub(crate) count: usize,
}

impl Found {
    fn new() -> Self {
        Self { points: Box::new(Vectors::ZERO), indices: Box::new([0; MOST_FOUND]), count: 0 }
    }

    /// True if another vector may not fit.
    #[inline(always)]
    pub(crate) fn is_full<L: Lanes>(&self) -> bool {
        self.count > MOST_FOUND - L::N
    }

    /// Appends the lanes `near` of the photons from index `from` on, which lie at `p`.
    #[inline(always)]
    pub(crate) fn append<L: Lanes>(&mut self, near: L::M, p: V3<L>, from: usize) {
        self.points.compress(near, p, self.count);
        self.append_indices::<L>(near, from);
    }

    /// The same without points.
    #[inline(always)]
    pub(crate) fn append_indices<L: Lanes>(&mut self, near: L::M, from: usize) {
        L::compress_u(near, L::u(from as u32) + L::iota(), &mut self.indices[self.count..]);
        self.count += L::mask_bits(near).count_ones() as usize;
    }
}

/// Buffers of the join, kept from group to group.
pub(crate) struct JoinBuffers {
    pub(crate) runs: Runs,
    /// A list for each half of a group.
    pub(crate) found: [Found; 2],
}

impl JoinBuffers {
    pub(crate) fn new() -> Self {
        Self { runs: Runs::new(), found: [Found::new(), Found::new()] }
    }
}

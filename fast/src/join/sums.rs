//! What the pixels of a group gather from the photons of an iteration.

use crate::pixels::GROUP;
use lanes::{Lanes, MOST_LANES};

/// The sums of a group's pixels: `reference::consolidate::Gathered`, for each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupSums {
    /// Photons that count: `M`.
    pub(crate) m: [u32; GROUP],
    /// Fluxes per channel, in units of `FLUX_ONE` to the nominal power.
    pub(crate) flux: [[u64; GROUP]; 3],
}

/// Counted work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JoinCounts {
    /// Pairs of a photon and a visible point that were tested.
    pub(crate) candidates: u64,
    /// Pairs that count.
    pub(crate) contributions: u64,
}

impl GroupSums {
    /// Adds to the pixels from `first` on; returns how many photons that are.
    #[inline(always)]
    pub(crate) fn add<L: Lanes>(&mut self, first: usize, m: L::U, flux: [L::U; 3]) -> u64 {
        let (mut values, mut count) = ([0; MOST_LANES], 0);
        L::store_u(m, &mut values);
        for k in 0..L::N {
            self.m[first + k] += values[k];
            count += u64::from(values[k]);
        }
        for channel in 0..3 {
            L::store_u(flux[channel], &mut values);
            for k in 0..L::N {
                self.flux[channel][first + k] += u64::from(values[k]);
            }
        }
        count
    }
}

//! Gathering for a single visible point, with a look-up of its own: for groups whose points are far apart.
//!
//! ```text
//! for each photon of the runs looked up, in lanes:
//!     if it is within the point's radius: append it to a list
//! for each photon of the list, one by one:
//!     if it arrives on the visible side: add its flux
//! ```
//!
//! How the loop below differs, and why:
//!
//! 1. The list is also added up when it is full, so that it stays in the cache.
//! 2. What photons bring is prefetched while their points are tested.
//! 3. Sums are of 64 bits in scalar registers: few photons count, and a sum per lane would be added across lanes.

use super::deposit::{Arrival, Flux, HEAVY, safe_surface};
use super::found::{Found, JoinBuffers};
use super::sorted::{Deposits, points};
use super::sums::{GroupSums, JoinCounts};
use crate::pixels::PixelRow;
use lanes::{Lanes, V3};
use scene::Vec3;
use std::ops::Range;

/// The visible point of one pixel.
pub(crate) struct SinglePoint<'a> {
    pub(crate) row: &'a PixelRow,
    /// Unit normal on the visible side.
    pub(crate) normal: Vec3,
    pub(crate) sums: &'a mut GroupSums,
    /// The place of the pixel in its group.
    pub(crate) lane: usize,
}

impl SinglePoint<'_> {
    /// Adds up what the point gathers from the runs that have been looked up.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(
        &mut self,
        deposits: &Deposits,
        buffers: &mut JoinBuffers,
        counts: &mut JoinCounts,
    ) {
        let JoinBuffers { runs, found: [found, _] } = buffers;
        let runs = &runs[self.lane];
        found.count = 0;
        for k in 0..runs.count() {
            self.find::<L>(deposits, runs.range(k), found, counts);
        }
        self.add(deposits, found, counts);
    }

    /// Adds up what the point gathers from all photons.
    #[inline(always)]
    pub(crate) fn run_on_all<L: Lanes>(
        &mut self,
        deposits: &Deposits,
        buffers: &mut JoinBuffers,
        counts: &mut JoinCounts,
    ) {
        let [found, _] = &mut buffers.found;
        found.count = 0;
        self.find::<L>(deposits, deposits.all(), found, counts);
        self.add(deposits, found, counts);
    }

    /// Finds the photons of a run that are within the radius.
    #[inline(always)]
    fn find<L: Lanes>(
        &mut self,
        deposits: &Deposits,
        run: Range<usize>,
        found: &mut Found,
        counts: &mut JoinCounts,
    ) {
        let point = V3::<L>::splat(Vec3::from_array(self.row.point));
        for piece in deposits.pieces(run) {
            counts.candidates += piece.indices.len() as u64;
            for at in piece.indices.clone().step_by(L::N) {
                let d = points::<L>(piece.coordinates(at)) - point;
                let near = L::lt(d.dot(d), L::f(self.row.radius_squared)) & L::first(piece.indices.end - at);
                piece.prefetch_arrivals::<L>(at);
                found.append_indices::<L>(near, at);
                if found.is_full::<L>() {
                    self.add(deposits, found, counts);
                }
            }
        }
    }

    /// Adds up the photons found that arrive on the visible side, and empties the list.
    #[inline(always)]
    fn add(&mut self, deposits: &Deposits, found: &mut Found, counts: &mut JoinCounts) {
        let (safe, normal) = (safe_surface(self.row.sphere), self.normal);
        let (mut m, mut sums) = (0, [0_u64; 3]);
        for index in &found.indices[..found.count] {
            let Arrival { surface, flux, wi, .. } = *deposits.arrival(*index);
            if surface & !HEAVY == safe || Vec3::from_array(wi).dot(normal) > 0.0 {
                m += 1;
                if surface & HEAVY != 0 {
                    self.sums.add_heavy(1 << self.lane, Flux::unpack(flux));
                    continue;
                }
                for (sum, flux) in sums.iter_mut().zip(flux) {
                    *sum += u64::from(flux.to_bits());
                }
            }
        }
        self.sums.m[self.lane] += m;
        counts.contributions += u64::from(m);
        for (channel, more) in sums.into_iter().enumerate() {
            self.sums.add_flux(channel, self.lane, u128::from(more));
        }
        found.count = 0;
    }
}

//! Gathering for a group: 16 visible points that are near each other, with one look-up for all.
//!
//! ```text
//! for each part of the group (its halves with 8 lanes, all of it with 16):
//!     for each photon of the runs looked up, in lanes:
//!         if it is within reach of the part's bounding box: append it to the part's list
//!     for each photon of the list, one by one, broadcast to all lanes:
//!         for each visible point of the part, in lanes:
//!             if it is within the point's radius and arrives on the visible side: add its flux
//! ```
//!
//! How the loop below differs, and why:
//!
//! 1. The parts share the loop over photons, so that each photon is loaded once.
//! 2. A list is also tested when it is full, so that it stays in the cache and sums fit into 32 bits.
//! 3. What photons bring is prefetched while their points are tested against the box.
//! 4. The side is tested only for photons that are not safe for all points of the part ([`SAFE`]).
//! 5. Heavy photons ([`HEAVY`]) are added up apart, in 128 bits: they are few, and exist only where photons are aimed.

use super::deposit::{Arrival, Flux, HEAVY, SAFE, safe_surface};
use super::found::{Found, JoinBuffers};
use super::region::Region;
use super::sorted::Deposits;
use super::sums::{GroupSums, JoinCounts};
use crate::pixels::{GROUP, PixelRows, PixelRowsLanes};
use lanes::{Lanes, V3};
use scene::Vec3;
use scene::ray::NO_SPHERE;
use std::mem::take;
use std::ops::Range;

/// The pixels of a group, with the regions that their visible points reach.
pub(crate) struct Group<'a> {
    pub(crate) rows: &'a [PixelRows],
    /// The region of each half.
    pub(crate) halves: [Region; 2],
    /// The region of all.
    pub(crate) all: Region,
}

/// All that can count at the points of a part: what is within reach of their bounding box.
///
/// Why it refuses no photon that counts. The distance along each axis from the box is at most that from any point in it.
/// So each difference, square and sum here is of terms no larger than in the test of a point, and rounding keeps that
/// order: what this test refuses, the test of every point refuses, bit for bit.
#[derive(Clone, Copy)]
struct BoxInReach<L: Lanes> {
    low: V3<L>,
    high: V3<L>,
    reach_squared: L::F,
}

impl<L: Lanes> BoxInReach<L> {
    #[inline(always)]
    fn new(region: &Region) -> Self {
        // The reach was widened by more than its square may be rounded by.
        let reach_squared = L::f(region.reach * region.reach);
        Self { low: V3::splat(region.low), high: V3::splat(region.high), reach_squared }
    }

    #[inline(always)]
    fn contains(&self, p: V3<L>) -> L::M {
        let (below, above, zero) = (self.low - p, p - self.high, L::f(0.0));
        let d = V3::<L>::new(
            L::max(L::max(below.x, above.x), zero),
            L::max(L::max(below.y, above.y), zero),
            L::max(L::max(below.z, above.z), zero),
        );
        L::lt(d.dot(d), self.reach_squared)
    }
}

/// As many visible points of a group as there are lanes.
#[derive(Clone, Copy)]
struct Part<L: Lanes> {
    point: V3<L>,
    normal: V3<L>,
    /// Squared radius; negative where there is no point, so that no photon is within it.
    radius_squared: L::F,
    /// Per point, the surface of photons that are safe for it.
    safe: L::U,
    /// The same if all points share it; else [`NO_SPHERE`].
    shared: u32,
    in_reach: BoxInReach<L>,
}

impl<L: Lanes> Part<L> {
    /// The first `L::N` pixels, whose points are in this region.
    #[inline(always)]
    fn new(rows: &[PixelRows], region: &Region) -> Self {
        let PixelRowsLanes { point, sphere, normal, radius_squared, .. } = PixelRowsLanes::<L>::load(rows);
        let is_nothing = L::eq(sphere, L::u(NO_SPHERE));
        Self {
            point,
            normal,
            radius_squared: L::select(is_nothing, L::f(-1.0), radius_squared),
            safe: sphere | L::u(SAFE),
            shared: shared_safe_surface(&rows[..L::N]),
            in_reach: BoxInReach::new(region),
        }
    }
}

/// The surface of photons that are safe for all visible points of these pixels; [`NO_SPHERE`] if there is none.
#[inline(always)]
fn shared_safe_surface(rows: &[PixelRows]) -> u32 {
    let (mut shared, mut is_shared) = (NO_SPHERE, true);
    for PixelRows { sphere, .. } in rows {
        is_shared &= *sphere == NO_SPHERE || shared == NO_SPHERE || *sphere == shared;
        shared = if *sphere == NO_SPHERE { shared } else { *sphere };
    }
    if is_shared { safe_surface(shared) } else { NO_SPHERE }
}

/// A group that gathers photons.
pub(crate) struct Gathering<'a, L: Lanes> {
    parts: [Part<L>; 2],
    deposits: &'a Deposits<'a>,
    found: &'a mut [Found; 2],
    sums: &'a mut GroupSums,
    counts: &'a mut JoinCounts,
}

impl<'a, L: Lanes> Gathering<'a, L> {
    /// The number of parts: one vector of 16, or two of 8. If it is one, the second repeats the first and is not used.
    const PARTS: usize = GROUP / L::N;

    /// Adds to `sums` what a group gathers from the runs that have been looked up.
    #[inline(always)]
    pub(crate) fn run(
        group: &Group,
        deposits: &'a Deposits<'a>,
        buffers: &'a mut JoinBuffers,
        sums: &'a mut GroupSums,
        counts: &'a mut JoinCounts,
    ) {
        let Group { rows, halves, all } = group;
        let first = Part::new(rows, if Self::PARTS == 1 { all } else { &halves[0] });
        let second = if Self::PARTS == 1 { first } else { Part::new(&rows[L::N..], &halves[1]) };
        let JoinBuffers { runs, found } = buffers;
        (found[0].count, found[1].count) = (0, 0);
        let mut this = Self { parts: [first, second], deposits, found, sums, counts };
        for k in 0..runs.count() {
            this.find(runs.range(k));
        }
        for part in 0..Self::PARTS {
            this.test(part);
        }
    }

    /// Finds the photons of a run that are within reach of the parts' boxes.
    #[inline(always)]
    fn find(&mut self, run: Range<usize>) {
        for at in run.clone().step_by(L::N) {
            let p = self.deposits.load_points::<L>(at);
            self.deposits.prefetch_arrivals::<L>(at);
            let in_run = L::first(run.end - at);
            for k in 0..Self::PARTS {
                let near = self.parts[k].in_reach.contains(p) & in_run;
                self.found[k].append(near, p, at);
                if self.found[k].is_full::<L>() {
                    self.test(k);
                }
            }
        }
    }

    /// Tests the photons found against the points of a part, adds up those that count, and empties the list.
    #[inline(always)]
    fn test(&mut self, part: usize) {
        let Found { points, indices, count } = &mut self.found[part];
        let (Part { point, normal, radius_squared, safe, shared, .. }, count) =
            (self.parts[part], take(count));
        let (xs, ys, zs) = (&points.x[..count], &points.y[..count], &points.z[..count]);
        let (indices, arrivals) = (&indices[..count], self.deposits.arrivals);
        let (mut m, mut sums) = (L::u(0), [L::u(0); 3]);
        for k in 0..count {
            let Arrival { surface, flux, wi, .. } = arrivals[indices[k] as usize];
            let d = V3::splat(Vec3::new(xs[k], ys[k], zs[k])) - point;
            let mut counts = L::lt(d.dot(d), radius_squared);
            if surface != shared {
                let wi = V3::splat(Vec3::from_array(wi));
                let is_safe = L::eq(safe, L::u(surface & !HEAVY));
                counts = counts & (is_safe | L::lt(L::f(0.0), wi.dot(normal)));
                if surface & HEAVY != 0 {
                    m = L::add_where(counts, m, L::u(1));
                    self.sums.add_heavy(L::mask_bits(counts) << (part * L::N), Flux::unpack(flux));
                    continue;
                }
            }
            m = L::add_where(counts, m, L::u(1));
            for channel in 0..3 {
                // Broadcast as a float, see `Record::flux`.
                sums[channel] = L::add_where(counts, sums[channel], L::bits(L::f(flux[channel])));
            }
        }
        self.counts.candidates += (count * L::N) as u64;
        if count > 0 {
            self.counts.contributions += self.sums.add::<L>(part * L::N, m, sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_shared_where_no_other_is_seen() {
        let shared = |spheres: &[u32]| {
            let mut rows = vec![PixelRows::NOTHING; spheres.len()];
            rows.iter_mut().zip(spheres).for_each(|(row, sphere)| row.sphere = *sphere);
            shared_safe_surface(&rows)
        };
        for sphere in [0, 1, 7] {
            assert_eq!(shared(&[sphere, sphere]), sphere | SAFE);
            assert_eq!(shared(&[NO_SPHERE, sphere, NO_SPHERE, sphere]), sphere | SAFE);
            assert_eq!(shared(&[sphere, sphere, sphere + 1]), NO_SPHERE);
            assert_eq!(shared(&[sphere + 1, NO_SPHERE, sphere, sphere]), NO_SPHERE);
        }
        assert_eq!(shared(&[NO_SPHERE; 3]), NO_SPHERE);
    }
}

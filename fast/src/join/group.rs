//! Gathering for a group: 16 visible points that are near each other, with one look-up for all.
//!
//! ```text
//! for each part of the group (its halves with 8 lanes; all of it with 16, or with a pair of vectors of 8):
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
//! 4. The side is tested only for photons that are not safe for all points of the part ([`SAFE`]). They are put off until the
//!    others are done: a loop that also tests sides needs more registers than there are.
//! 5. Heavy photons ([`HEAVY`]) are added up apart, in 128 bits: they are few, and exist only where photons are aimed.

use super::deposit::{Arrival, Flux, HEAVY, SAFE, safe_surface};
use super::found::{Found, JoinBuffers};
use super::region::Region;
use super::sorted::{Deposits, points};
use super::sums::{GroupSums, JoinCounts};
use crate::pixels::{GROUP, GroupColumns, PixelRow, PixelRowLanes};
use lanes::{Kernel, Lanes, V3};
use scene::Vec3;
use scene::ray::NO_SPHERE;
use std::mem::take;
use std::ops::Range;

/// The pixels of a group, with the regions that their visible points reach.
pub(crate) struct Group<'a> {
    pub(crate) rows: &'a [PixelRow],
    pub(crate) columns: &'a GroupColumns,
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

/// A group that gathers photons. It runs on a pair of vectors, so that a photon is tested against one box, not against two.
pub(crate) struct Gathering<'a, L: Lanes> {
    rows: &'a [PixelRow],
    columns: &'a GroupColumns,
    /// What counts at each part. The parts are one vector of 16 points, or two of 8; if it is one, the second repeats the
    /// first and is not used.
    boxes: [BoxInReach<L>; 2],
    deposits: &'a Deposits<'a>,
    found: &'a mut [Found; 2],
    sums: &'a mut GroupSums,
    counts: &'a mut JoinCounts,
}

impl<'a, L: Lanes> Gathering<'a, L> {
    /// The number of parts.
    const PARTS: usize = GROUP / L::N;

    /// Adds to `sums` what a group gathers from the runs that have been looked up.
    #[inline(always)]
    pub(crate) fn run(
        group: &Group<'a>,
        deposits: &'a Deposits<'a>,
        buffers: &'a mut JoinBuffers,
        sums: &'a mut GroupSums,
        counts: &'a mut JoinCounts,
    ) {
        let Group { rows, columns, halves, all } = group;
        let first = BoxInReach::new(if Self::PARTS == 1 { all } else { &halves[0] });
        let second = if Self::PARTS == 1 { first } else { BoxInReach::new(&halves[1]) };
        let JoinBuffers { runs, found } = buffers;
        (found[0].count, found[1].count) = (0, 0);
        let mut this = Self { rows, columns, boxes: [first, second], deposits, found, sums, counts };
        for k in 0..runs[0].count() {
            this.find(runs[0].range(k));
        }
        for part in 0..Self::PARTS {
            if this.found[part].count > 0 {
                this.test(part);
            }
        }
    }

    /// Finds the photons of a run that are within reach of the parts' boxes.
    #[inline(always)]
    fn find(&mut self, run: Range<usize>) {
        for piece in self.deposits.pieces(run) {
            for at in piece.indices.clone().step_by(L::N) {
                let p = points::<L>(piece.coordinates(at));
                piece.prefetch_arrivals::<L>(at);
                let in_run = L::first(piece.indices.end - at);
                for part in 0..Self::PARTS {
                    let near = self.boxes[part].contains(p) & in_run;
                    self.found[part].append(near, p, at);
                    if self.found[part].is_full::<L>() {
                        self.test(part);
                    }
                }
            }
        }
    }

    /// Tests the photons found against the points of a part, adds up those that count, and empties the list.
    #[inline(always)]
    fn test(&mut self, part: usize) {
        let first = part * L::N;
        L::call(Test {
            rows: &self.rows[first..][..L::N],
            columns: self.columns,
            first,
            deposits: self.deposits,
            found: &mut self.found[part],
            sums: self.sums,
            counts: self.counts,
        });
    }
}

/// The test of the photons found against the visible points of a part. It is called, so that both it and the search have all
/// registers.
struct Test<'a> {
    /// The part's pixels.
    rows: &'a [PixelRow],
    /// Those of the group.
    columns: &'a GroupColumns,
    /// The place of the first in the group.
    first: usize,
    deposits: &'a Deposits<'a>,
    found: &'a mut Found,
    sums: &'a mut GroupSums,
    counts: &'a mut JoinCounts,
}

impl Kernel for Test<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self {
            rows,
            columns,
            first,
            deposits,
            found: Found { points: places, indices, doubtful, count },
            sums,
            counts,
        } = self;
        let points = PointLanes::<L>::load(rows);
        let shared = shared_safe_surface(rows);
        let mut gathered = Gathered::<L>::nothing();
        let (count, mut doubts) = (take(count), 0);
        for k in 0..count {
            let arrival = deposits.arrival(indices[k]);
            if arrival.surface != shared {
                doubtful[doubts] = k as u32;
                doubts += 1;
                continue;
            }
            gathered.add(points.reach(places.broadcast(k)), arrival);
        }
        if doubts > 0 {
            let sides = SideLanes::<L>::new(rows, columns.normals(first));
            for k in doubtful[..doubts].iter().map(|k| *k as usize) {
                let arrival = deposits.arrival(indices[k]);
                let counts = points.reach(places.broadcast(k)) & sides.see(arrival);
                if arrival.surface & HEAVY == 0 {
                    gathered.add(counts, arrival);
                } else {
                    gathered.count(counts);
                    sums.add_heavy(L::mask_bits(counts) << first, Flux::unpack(arrival.flux));
                }
            }
        }
        counts.candidates += (count * L::N) as u64;
        counts.contributions += sums.add::<L>(first, gathered.m(), gathered.flux);
    }
}

/// As many visible points as there are lanes.
struct PointLanes<L: Lanes> {
    point: V3<L>,
    /// Squared radius; negative where there is no point, so that no photon is within it.
    radius_squared: L::F,
}

impl<L: Lanes> PointLanes<L> {
    #[inline(always)]
    fn load(rows: &[PixelRow]) -> Self {
        let PixelRowLanes { point, sphere, radius_squared, .. } = PixelRowLanes::<L>::load(rows);
        let is_nothing = L::eq(sphere, L::u(NO_SPHERE));
        Self { point, radius_squared: L::select(is_nothing, L::f(-1.0), radius_squared) }
    }

    /// The points within whose radius a photon is.
    #[inline(always)]
    fn reach(&self, photon: V3<L>) -> L::M {
        let d = photon - self.point;
        L::lt(d.dot(d), self.radius_squared)
    }
}

/// Which sides of surfaces points see.
struct SideLanes<L: Lanes> {
    /// The surface of photons that are safe for each point.
    safe: L::U,
    normal: V3<L>,
}

impl<L: Lanes> SideLanes<L> {
    #[inline(always)]
    fn new(rows: &[PixelRow], normal: V3<L>) -> Self {
        let PixelRowLanes { sphere, .. } = PixelRowLanes::<L>::load(rows);
        Self { safe: sphere | L::u(SAFE), normal }
    }

    /// The points on whose visible side a photon arrives.
    #[inline(always)]
    fn see(&self, arrival: &Arrival) -> L::M {
        let wi = V3::splat(Vec3::from_array(arrival.wi));
        let is_safe = L::eq(self.safe, L::u(arrival.surface & !HEAVY));
        is_safe | L::lt(L::f(0.0), wi.dot(self.normal))
    }
}

/// What as many points as there are lanes gather.
struct Gathered<L: Lanes> {
    /// Less the number of photons: what is added where a photon counts then has all bits set, and needs no constant.
    minus_m: L::U,
    flux: [L::U; 3],
}

impl<L: Lanes> Gathered<L> {
    #[inline(always)]
    fn nothing() -> Self {
        Self { minus_m: L::u(0), flux: [L::u(0); 3] }
    }

    #[inline(always)]
    fn add(&mut self, counts: L::M, arrival: &Arrival) {
        self.count(counts);
        for (sum, flux) in self.flux.iter_mut().zip(arrival.flux) {
            // Broadcast as a float, see `Record::flux`.
            *sum = L::add_where(counts, *sum, L::bits(L::f(flux)));
        }
    }

    #[inline(always)]
    fn count(&mut self, counts: L::M) {
        self.minus_m = L::add_where(counts, self.minus_m, L::u(u32::MAX));
    }

    #[inline(always)]
    fn m(&self) -> L::U {
        (self.minus_m ^ L::u(u32::MAX)) + L::u(1)
    }
}

/// The surface of photons that are safe for all visible points of these pixels; [`NO_SPHERE`] if there is none.
#[inline(always)]
fn shared_safe_surface(rows: &[PixelRow]) -> u32 {
    let (mut shared, mut is_shared) = (NO_SPHERE, true);
    for PixelRow { sphere, .. } in rows {
        is_shared &= *sphere == NO_SPHERE || shared == NO_SPHERE || *sphere == shared;
        shared = if *sphere == NO_SPHERE { shared } else { *sphere };
    }
    if is_shared { safe_surface(shared) } else { NO_SPHERE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_shared_where_no_other_is_seen() {
        let shared = |spheres: &[u32]| {
            let mut rows = vec![PixelRow::NOTHING; spheres.len()];
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

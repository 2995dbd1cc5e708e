//! The top of a tree: the boxes among which every ray begins.
//!
//! A root is a poor place to begin: it may have any number of children, and where these are few, few boxes are tested at a
//! time; and a ray that hits nothing in the nearest child goes through the others in any order, each of which is a large part
//! of the scene. Here all boxes of the lowest level that has no more than 32 are tested at the start, and each ray visits
//! those that it enters from the nearest to the farthest:
//!
//! ```text
//! for each packet of rays:
//!     for each box: a key of the distance at which the rays enter it, zero if they do not     (a lane per ray)
//!     for each ray: keep the keys that are not zero                                           (a lane per box)
//!     sort the first eight keys of all rays                                                   (a lane per ray)
//!     for each ray: push the boxes, the farthest first                                        (a lane per box)
//! ```
//!
//! How it differs from visits of nodes ([`super::tree`]), and why:
//!
//! 1. Every ray tests the same boxes, so the rays stand in the lanes, and a plane is read once for a packet. The test of a box
//!    takes some thirty operations for all rays of the packet.
//! 2. Boxes are sorted, by a network without branches. Among a million balls a third fewer boxes are visited for it. In nodes,
//!    whose boxes are small, it would save 4 % of the visits, and among fewer balls less than 1 %. If a ray enters more than
//!    eight boxes, the others come last.
//! 3. If there are no more than eight boxes the keys are sorted where they are.
//! 4. A key is a distance whose lowest bits are the number of the box: one word is sorted.

use super::boxes::{BoundingBox, SlabLanes};
use lanes::{Lanes, MOST_LANES, Row};

/// Keys of a row.
const PER_ROW: usize = 8;
/// The most boxes of a top.
pub(super) const MOST_TOP: usize = 32;
/// Low bits of a key: one more than the number of the box, so that no key is zero.
const NUMBER: u32 = (MOST_TOP as u32 + 1).next_power_of_two() - 1;
/// Rows of keys of all boxes.
const GROUPS: usize = MOST_TOP / PER_ROW;
/// Rows of the keys that are not zero, with one for what vectors write past the end.
const KEPT: usize = GROUPS + 1;
/// Comparisons that sort eight (Batcher's odd-even merge sort): by stages, within which they are independent.
const NETWORK: [(usize, usize); 19] = [
    (0, 1),
    (2, 3),
    (4, 5),
    (6, 7),
    (0, 2),
    (1, 3),
    (4, 6),
    (5, 7),
    (1, 2),
    (5, 6),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
    (2, 4),
    (3, 5),
    (1, 2),
    (3, 4),
    (5, 6),
];
/// Where the kept keys of each ray begin.
const FIRST_KEPT: [u32; MOST_LANES] = {
    let mut first = [0; MOST_LANES];
    let mut lane = 0;
    while lane < MOST_LANES {
        first[lane] = (lane * KEPT) as u32;
        lane += 1;
    }
    first
};

const _: () = assert!(MOST_TOP.is_multiple_of(PER_ROW));

/// The keys of the boxes of a top, for the rays of a packet.
pub(super) struct Entries {
    /// Per eight boxes and ray.
    all: [[Row; MOST_LANES]; GROUPS],
    /// Per ray, those that are not zero.
    kept: [Row; KEPT * MOST_LANES],
    /// How many these are: lanes compare no integers.
    counts: [f32; MOST_LANES],
    /// Per ray, the first eight that were kept, the greatest first; zeros follow them.
    sorted: [Row; MOST_LANES],
}

impl Entries {
    pub(super) const EMPTY: Self = Self {
        all: [[Row([0.0; 8]); MOST_LANES]; GROUPS],
        kept: [Row([0.0; 8]); KEPT * MOST_LANES],
        counts: [0.0; MOST_LANES],
        sorted: [Row([0.0; 8]); MOST_LANES],
    };

    /// Tests the boxes for a packet of rays that end at `t`, and sorts them.
    #[inline(always)]
    pub(super) fn test<L: Lanes>(&mut self, top: &[BoundingBox], rays: &SlabLanes<L>, t: L::F) {
        let (mut number, mut count, groups) = (0, L::f(0.0), top.len().div_ceil(PER_ROW));
        for (boxes, rows) in top.chunks(PER_ROW).zip(&mut self.all) {
            let mut columns = [L::f(0.0); PER_ROW];
            for (column, bounds) in columns.iter_mut().zip(boxes) {
                number += 1;
                let (distance, enters) = rays.entry(bounds, t);
                // Where a distance is infinite nothing is hit, and its key would be no number.
                let enters = enters & L::lt(distance, L::f(f32::INFINITY));
                let key = L::bits(distance) & L::u(!NUMBER) | L::u(number);
                *column = L::select(enters, L::from_bits(key), L::f(0.0));
                count = L::select(enters, count + L::f(1.0), count);
            }
            L::store(count, &mut self.counts);
            if groups == 1 {
                return self.sort::<L>(columns);
            }
            L::transpose(columns, rows);
        }
        for lane in 0..L::N {
            self.keep::<L::Eight>(lane, groups);
        }
        self.sort_kept::<L>();
    }

    /// Keeps the keys of a ray that are not zero.
    #[inline(always)]
    fn keep<L: Lanes>(&mut self, lane: usize, groups: usize) {
        let kept = bytemuck::cast_slice_mut(&mut self.kept[lane * KEPT..][..KEPT]);
        let mut count = 0;
        for rows in self.all.iter().take(groups) {
            let row = L::load(&rows[lane].0);
            let enters = L::lt(L::f(0.0), row);
            L::compress(enters, row, &mut kept[count..]);
            count += L::mask_bits(enters).count_ones() as usize;
        }
    }

    /// Sorts the first eight keys that each ray has kept.
    #[inline(always)]
    fn sort_kept<L: Lanes>(&mut self) {
        let mut keys = L::gather_rows(&self.kept, &FIRST_KEPT[..L::N]);
        let counts = L::load(&self.counts);
        for (k, key) in keys.iter_mut().enumerate() {
            *key = L::select(L::lt(L::f(k as f32), counts), *key, L::f(0.0));
        }
        self.sort::<L>(keys);
    }

    /// Sorts eight keys of each ray.
    #[inline(always)]
    fn sort<L: Lanes>(&mut self, mut keys: [L::F; PER_ROW]) {
        for (a, b) in NETWORK {
            (keys[a], keys[b]) = (L::max(keys[a], keys[b]), L::min(keys[a], keys[b]));
        }
        L::transpose(keys, &mut self.sorted);
    }

    /// Writes the boxes that a ray of the packet enters to the start of `places` and `distances`, the nearest last. Returns
    /// how many these are. The place of a box is its number plus `first`.
    #[inline(always)]
    pub(super) fn push<L: Lanes>(
        &self,
        lane: usize,
        first: u32,
        places: &mut [u32],
        distances: &mut [f32],
    ) -> usize {
        let count = self.counts[lane] as usize;
        let begin = count.saturating_sub(PER_ROW);
        let others: &[u32] = bytemuck::cast_slice(&self.kept[lane * KEPT + 1..][..KEPT - 1]);
        for (k, key) in others.iter().take(begin).enumerate() {
            places[k] = first + (key & NUMBER) - 1;
            distances[k] = f32::from_bits(key & !NUMBER);
        }
        let keys = L::bits(L::load(&self.sorted[lane].0));
        L::store_u((keys & L::u(NUMBER)) + L::u(first.wrapping_sub(1)), &mut places[begin..]);
        L::store(L::from_bits(keys & L::u(!NUMBER)), &mut distances[begin..]);
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lanes::{Emulated, V3};
    use scene::Vec3;

    /// The boxes of a top of so many that a ray along z enters, the nearest last; of these, every third is at an infinite
    /// distance.
    fn entered(count: usize) -> Vec<u32> {
        type L = Emulated<8>;
        let bounds = |k: usize| {
            let far = if k.is_multiple_of(3) { 1e25 } else { 0.0 };
            let low = Vec3::new(far - 1.0, -1.0, 1.0 + k as f32);
            BoundingBox { low, high: low + Vec3::new(2.0, 2.0, 0.5) }
        };
        let top: Vec<BoundingBox> = (0..count).map(bounds).collect();
        let rays = SlabLanes::<L>::new(V3::splat(Vec3::ZERO), V3::splat(Vec3::new(0.0, 0.0, 1.0)), 64.0);
        let mut entries = Entries::EMPTY;
        entries.test(&top, &rays, L::f(f32::INFINITY));
        let (mut places, mut distances) = ([0; 2 * MOST_TOP], [0.0; 2 * MOST_TOP]);
        let count = entries.push::<L>(0, 0, &mut places, &mut distances);
        assert!(distances[..count].iter().all(|distance| distance.is_finite()));
        places[..count].to_vec()
    }

    /// Of more than eight that are entered, only the first eight are sorted, and come last.
    #[test]
    fn boxes_at_an_infinite_distance_are_not_entered_and_move_no_other() {
        for count in 1..=MOST_TOP as u32 {
            let finite: Vec<u32> = (0..count).filter(|k| !k.is_multiple_of(3)).collect();
            let (first, others) = finite.split_at(finite.len().min(PER_ROW));
            let expected: Vec<u32> = others.iter().chain(first.iter().rev()).copied().collect();
            assert_eq!(entered(count as usize), expected, "{count} boxes");
        }
    }
}

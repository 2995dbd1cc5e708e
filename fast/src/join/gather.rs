//! The two loops of the join: many points against one photon, and one point against many photons.

use super::cells::{Bounds, Query, Run, WINDOW};
use super::deposits::{SAFE, Sorted};
use super::{GROUP, JoinCounts, safe_surface};
use crate::camera_pass::PixelRows;
use crate::lanes::{Lanes, MOST_LANES, Row, prefetch};
use crate::paths::Vectors;
use crate::vec3::V3;
use scene::Vec3;
use scene::ray::NO_SPHERE;
use std::ops::Range;

/// Photons that a 32-bit sum of fluxes surely holds: 2047 * 2^21 < 2^32.
const FLUSH: usize = 2047;

/// What a group's pixels have gathered.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// `M`.
    pub(crate) m: [u32; GROUP],
    /// Fluxes, per channel.
    pub(crate) flux: [[u64; GROUP]; 3],
}

/// The photons that a query is to look at, as ranges of the sorted deposits.
pub(crate) struct Runs {
    ranges: [(u32, u32); Self::MOST],
    count: usize,
}

impl Runs {
    /// A row of cells is one run, or two where the last bucket is passed: one row at most, as rows share no bucket.
    const MOST: usize = (WINDOW * WINDOW) as usize + 1;

    pub(crate) fn new() -> Self {
        Self { ranges: [(0, 0); Self::MOST], count: 0 }
    }

    /// Looks up a query. What is found is asked for at once: memory answers while the other rows are looked up.
    #[inline(always)]
    pub(crate) fn look_up<L: Lanes>(&mut self, sorted: &Sorted, query: &Query<L>) {
        self.count = 0;
        for z in query.slabs() {
            let mut rows = query.rows(z);
            while let Some(row) = rows.next() {
                if sorted.is_empty(row) {
                    continue;
                }
                for Range { start, end } in sorted.photons(row) {
                    if start < end {
                        sorted.points.iter().for_each(|column| prefetch(column, start));
                        self.ranges[self.count] = (start as u32, end as u32);
                        self.count += 1;
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn range(&self, k: usize) -> Range<usize> {
        self.ranges[k].0 as usize..self.ranges[k].1 as usize
    }
}

impl Sorted {
    /// The photons of some buckets: in two ranges, where the last bucket is passed.
    #[inline(always)]
    fn photons(&self, run: Run) -> [Range<usize>; 2] {
        let buckets = self.starts.len() - 1;
        let (first, end) = (run.bucket as usize, run.bucket as usize + run.length as usize);
        let start = |bucket: usize| self.starts[bucket] as usize;
        if end <= buckets {
            [start(first)..start(end), 0..0]
        } else {
            [start(first)..start(buckets), 0..start(end - buckets)]
        }
    }

    /// Photons from `at` on, as lanes.
    #[inline(always)]
    fn load_points<L: Lanes>(&self, at: usize) -> V3<L> {
        let [xs, ys, zs] = &self.points;
        V3::new(L::load(&xs[at..]), L::load(&ys[at..]), L::load(&zs[at..]))
    }

    /// Asks for what `L::N` photons from `at` on bring.
    #[inline(always)]
    fn prefetch_arrivals<L: Lanes>(&self, at: usize) {
        /// Two rows share a cache line.
        const STEP: usize = 2;
        for k in (0..L::N).step_by(STEP) {
            prefetch(&self.arrivals, at + k);
        }
    }
}

/// What gathering needs, kept from group to group.
pub(crate) struct Scratch {
    pub(crate) runs: Runs,
    found: [Found; 2],
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self { runs: Runs::new(), found: [Found::new(), Found::new()] }
    }
}

/// So many photons are found before they are tested; no more than [`FLUSH`].
const MOST_FOUND: usize = 1024;

/// Photons that may count at some point of a part of a group.
struct Found {
    points: Box<Vectors<MOST_FOUND>>,
    indices: Box<[u32; MOST_FOUND]>,
    count: usize,
}

impl Found {
    fn new() -> Self {
        Self { points: Box::new(Vectors::ZERO), indices: Box::new([0; MOST_FOUND]), count: 0 }
    }

    /// True if no other vector fits.
    #[inline(always)]
    fn is_full<L: Lanes>(&self) -> bool {
        self.count > MOST_FOUND - L::N
    }

    /// Takes the lanes `near` of photons `from` on, which lie at `p`.
    #[inline(always)]
    fn append<L: Lanes>(&mut self, near: L::M, p: V3<L>, from: usize) {
        self.points.compress(near, p, self.count);
        self.append_indices::<L>(near, from);
    }

    /// The same, but not where they lie.
    #[inline(always)]
    fn append_indices<L: Lanes>(&mut self, near: L::M, from: usize) {
        L::compress_u(near, L::u(from as u32) + L::iota(), &mut self.indices[self.count..]);
        self.count += L::mask_bits(near).count_ones() as usize;
    }
}

/// The sphere of search around all points of a part: nothing outside counts at any of them.
///
/// With the box's distance from a photon instead of a point's, each difference, square and sum is of terms no larger
/// than before, and rounding keeps that order: so what this refuses the test of the points refuses, bit for bit.
#[derive(Clone, Copy)]
struct Around<L: Lanes> {
    low: V3<L>,
    high: V3<L>,
    reach_squared: L::F,
}

impl<L: Lanes> Around<L> {
    #[inline(always)]
    fn new(bounds: &Bounds) -> Self {
        // The reach has been widened by more than its square may be rounded by.
        let reach_squared = L::f(bounds.reach * bounds.reach);
        Self { low: V3::splat(bounds.low), high: V3::splat(bounds.high), reach_squared }
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
    /// Squared radius; negative where there is no point, so that nothing is nearer.
    radius_squared: L::F,
    /// The surface whose photons need no test of the side, per point.
    safe: L::U,
    /// The same of all points, if they share one; else [`NO_SPHERE`].
    shared: u32,
    around: Around<L>,
}

impl<L: Lanes> Part<L> {
    /// The first `L::N` pixels, which have these bounds.
    #[inline(always)]
    fn new(rows: &[PixelRows], pixels: &[Row], bounds: &Bounds) -> Self {
        let ([x, y, z, sphere, ..], [nx, ny, nz, ..]) = load_pixel_rows::<L>(rows);
        let [.., radius_squared] = L::load_rows(pixels);
        let is_nothing = L::eq(L::bits(sphere), L::u(NO_SPHERE));
        Self {
            point: V3::new(x, y, z),
            normal: V3::new(nx, ny, nz),
            radius_squared: L::select(is_nothing, L::f(-1.0), radius_squared),
            safe: L::bits(sphere) | L::u(SAFE),
            shared: shared_safe_surface(&rows[..L::N]),
            around: Around::new(bounds),
        }
    }
}

/// The surface whose photons need no test of the side at any pixel that sees something; [`NO_SPHERE`] if there is none.
#[inline(always)]
fn shared_safe_surface(rows: &[PixelRows]) -> u32 {
    let (mut shared, mut is_shared) = (NO_SPHERE, true);
    for row in rows {
        let sphere = row.visible.0[3].to_bits();
        is_shared &= sphere == NO_SPHERE || shared == NO_SPHERE || sphere == shared;
        shared = if sphere == NO_SPHERE { shared } else { sphere };
    }
    if is_shared { safe_surface(shared) } else { NO_SPHERE }
}

/// The two rows of `L::N` pixels, as columns.
#[inline(always)]
pub(crate) fn load_pixel_rows<L: Lanes>(rows: &[PixelRows]) -> ([L::F; 8], [L::F; 8]) {
    let (mut visible, mut light) = ([Row::default(); MOST_LANES], [Row::default(); MOST_LANES]);
    for k in 0..L::N {
        visible[k] = rows[k].visible;
        light[k] = rows[k].light;
    }
    (L::load_rows(&visible), L::load_rows(&light))
}

/// A group that gathers photons.
pub(crate) struct Gathering<'a, L: Lanes> {
    parts: [Part<L>; 2],
    sorted: &'a Sorted,
    found: &'a mut [Found; 2],
    sums: &'a mut Sums,
    counts: &'a mut JoinCounts,
}

/// The pixels of a group, and what of them the search needs to know.
pub(crate) struct Group<'a> {
    pub(crate) rows: &'a [PixelRows],
    pub(crate) pixels: &'a [Row],
    /// The bounds of its halves.
    pub(crate) halves: [Bounds; 2],
    /// The bounds of all.
    pub(crate) all: Bounds,
}

impl<'a, L: Lanes> Gathering<'a, L> {
    /// How many parts there are: one vector of 16, or two of 8. With one, the second repeats it and is not used.
    const PARTS: usize = GROUP / L::N;

    /// Adds up what a group gathers from the runs that have been looked up.
    #[inline(always)]
    pub(crate) fn run(
        group: &Group,
        sorted: &'a Sorted,
        scratch: &'a mut Scratch,
        sums: &'a mut Sums,
        counts: &'a mut JoinCounts,
    ) {
        let Group { rows, pixels, halves, all } = group;
        let first = Part::new(rows, pixels, if Self::PARTS == 1 { all } else { &halves[0] });
        let second =
            if Self::PARTS == 1 { first } else { Part::new(&rows[L::N..], &pixels[L::N..], &halves[1]) };
        let Scratch { runs, found } = scratch;
        (found[0].count, found[1].count) = (0, 0);
        let mut this = Self { parts: [first, second], sorted, found, sums, counts };
        for k in 0..runs.count {
            this.find(runs.range(k));
        }
        for part in 0..Self::PARTS {
            this.test(part);
        }
    }

    /// Finds those photons of a run that are near.
    #[inline(always)]
    fn find(&mut self, run: Range<usize>) {
        for at in run.clone().step_by(L::N) {
            let p = self.sorted.load_points::<L>(at);
            self.sorted.prefetch_arrivals::<L>(at);
            let in_run = L::first(run.end - at);
            for k in 0..Self::PARTS {
                let near = self.parts[k].around.contains(p) & in_run;
                self.found[k].append(near, p, at);
                if self.found[k].is_full::<L>() {
                    self.test(k);
                }
            }
        }
    }

    /// Tests what has been found against the points of a part, and adds up what counts.
    #[inline(always)]
    fn test(&mut self, part: usize) {
        let Found { points, indices, count } = &mut self.found[part];
        let (Part { point, normal, radius_squared, safe, shared, .. }, count) =
            (self.parts[part], std::mem::take(count));
        let (xs, ys, zs) = (&points.x[..count], &points.y[..count], &points.z[..count]);
        let (indices, arrivals) = (&indices[..count], &self.sorted.arrivals[..]);
        let (mut m, mut sums) = (L::u(0), [L::u(0); 3]);
        for k in 0..count {
            let [surface, flux @ .., wx, wy, wz, _] = arrivals[indices[k] as usize].0;
            let d = V3::splat(Vec3::new(xs[k], ys[k], zs[k])) - point;
            let mut counts = L::lt(d.dot(d), radius_squared);
            if surface.to_bits() != shared {
                let wi = V3::splat(Vec3::new(wx, wy, wz));
                let own = L::eq(safe, L::u(surface.to_bits()));
                counts = counts & (own | L::lt(L::f(0.0), wi.dot(normal)));
            }
            m = L::add_where(counts, m, L::u(1));
            for channel in 0..3 {
                // As a float: a broadcast from memory, where an integer would pass through a scalar register.
                sums[channel] = L::add_where(counts, sums[channel], L::bits(L::f(flux[channel])));
            }
        }
        self.counts.candidates += (count * L::N) as u64;
        if count > 0 {
            self.add(part * L::N, m, sums);
        }
    }

    /// Adds to the 64-bit sums of the pixels from `first` on.
    #[inline(always)]
    fn add(&mut self, first: usize, m: L::U, flux: [L::U; 3]) {
        let mut lanes = [0; MOST_LANES];
        L::store_u(m, &mut lanes);
        for k in 0..L::N {
            self.sums.m[first + k] += lanes[k];
            self.counts.contributions += u64::from(lanes[k]);
        }
        for channel in 0..3 {
            L::store_u(flux[channel], &mut lanes);
            for k in 0..L::N {
                self.sums.flux[channel][first + k] += u64::from(lanes[k]);
            }
        }
    }
}

/// The visible point of one pixel that gathers photons by itself.
pub(crate) struct Single<'a> {
    pub(crate) row: &'a PixelRows,
    pub(crate) radius_squared: f32,
    pub(crate) sums: &'a mut Sums,
    /// Which pixel of the group this is.
    pub(crate) lane: usize,
}

impl Single<'_> {
    /// Adds up what the point gathers from the runs that have been looked up.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(&mut self, sorted: &Sorted, scratch: &mut Scratch, counts: &mut JoinCounts) {
        let Scratch { runs, found: [found, _] } = scratch;
        found.count = 0;
        for k in 0..runs.count {
            self.find::<L>(sorted, runs.range(k), found, counts);
        }
        self.add(sorted, found, counts);
    }

    /// Adds up what the point gathers from all photons.
    #[inline(always)]
    pub(crate) fn run_on_all<L: Lanes>(
        &mut self,
        sorted: &Sorted,
        scratch: &mut Scratch,
        counts: &mut JoinCounts,
    ) {
        let [found, _] = &mut scratch.found;
        found.count = 0;
        self.find::<L>(sorted, 0..sorted.count(), found, counts);
        self.add(sorted, found, counts);
    }

    /// Finds those photons of a run that are within the radius, these in lanes.
    #[inline(always)]
    fn find<L: Lanes>(
        &mut self,
        sorted: &Sorted,
        run: Range<usize>,
        found: &mut Found,
        counts: &mut JoinCounts,
    ) {
        let [x, y, z, ..] = self.row.visible.0;
        let point = V3::<L>::splat(Vec3::new(x, y, z));
        counts.candidates += run.len() as u64;
        for at in run.clone().step_by(L::N) {
            let d = sorted.load_points::<L>(at) - point;
            let near = L::lt(d.dot(d), L::f(self.radius_squared)) & L::first(run.end - at);
            sorted.prefetch_arrivals::<L>(at);
            found.append_indices::<L>(near, at);
            if found.is_full::<L>() {
                self.add(sorted, found, counts);
            }
        }
    }

    /// Adds up the photons found, but for those that arrive on the side that is not seen; and forgets them.
    #[inline(always)]
    fn add(&mut self, sorted: &Sorted, found: &mut Found, counts: &mut JoinCounts) {
        let ([.., sphere, _, _, _, _], [nx, ny, nz, ..]) = (self.row.visible.0, self.row.light.0);
        let (safe, normal) = (safe_surface(sphere.to_bits()), Vec3::new(nx, ny, nz));
        let (mut m, mut sums) = (0, [0; 3]);
        for index in &found.indices[..found.count] {
            let [surface, r, g, b, wx, wy, wz, _] = sorted.arrivals[*index as usize].0;
            if surface.to_bits() == safe || Vec3::new(wx, wy, wz).dot(normal) > 0.0 {
                m += 1;
                for (sum, flux) in sums.iter_mut().zip([r, g, b]) {
                    *sum += u64::from(flux.to_bits());
                }
            }
        }
        self.sums.m[self.lane] += m;
        counts.contributions += u64::from(m);
        for (sum, more) in self.sums.flux.iter_mut().zip(sums) {
            sum[self.lane] += more;
        }
        found.count = 0;
    }
}

const _: () = assert!(MOST_FOUND <= FLUSH);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::join::cells::Cells;
    use crate::join::deposits::{Binned, Chunks, bin_shift};
    use crate::lanes::Emulated;
    use std::sync::Arc;

    /// Nothing that is found may be lost for want of room.
    #[test]
    fn the_runs_of_a_full_window_have_room() {
        let (cells, wide) = (Cells::new(1.0, 1 << 12), WINDOW as f32);
        let mut binned = Binned::new(&Arc::new(Chunks::new()));
        for bucket in 0..=cells.mask {
            let record = Row([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::from_bits(bucket)]);
            binned.push(record, [0.0; 4], bin_shift(cells));
        }
        let mut sorted = Sorted::new();
        sorted.fill(&[&binned], cells);
        let (mut runs, mut most) = (Runs::new(), 0);
        for x in (0..=cells.mask).step_by(WINDOW as usize - 1) {
            // All but the outermost thousandth of a window of cells.
            let low = Vec3::new(x as f32, 0.0, 0.0) + 1e-3;
            let bounds = Bounds { low, high: low + wide - 2e-3, reach: 1e-4 };
            let span = cells.span(&bounds);
            assert!(span.fits());
            runs.look_up(&sorted, &cells.query::<Emulated>(span, &bounds));
            let found: usize = (0..runs.count).map(|k| runs.range(k).len()).sum();
            assert_eq!(found, (WINDOW * WINDOW * WINDOW) as usize);
            most = most.max(runs.count);
        }
        assert_eq!(most, Runs::MOST, "no row that passes the last bucket was looked up");
    }

    #[test]
    fn a_surface_is_shared_where_no_other_is_seen() {
        let shared = |spheres: &[u32]| {
            let rows: Vec<PixelRows> = spheres
                .iter()
                .map(|sphere| {
                    let mut rows = PixelRows::NOTHING;
                    rows.visible.0[3] = f32::from_bits(*sphere);
                    rows
                })
                .collect();
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

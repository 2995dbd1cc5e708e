//! The two loops of the join: many points against one photon, and one point against many photons.

use super::cells::Run;
use super::deposits::{SAFE, Sorted};
use super::{GROUP, JoinCounts, safe_surface};
use crate::camera_pass::PixelRows;
use crate::lanes::{Lanes, MOST_LANES, Row};
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

/// The sums of one pixel.
pub(crate) struct LaneSums<'a> {
    sums: &'a mut Sums,
    lane: usize,
}

impl Sums {
    pub(crate) fn lane(&mut self, lane: usize) -> LaneSums<'_> {
        LaneSums { sums: self, lane }
    }
}

impl Sorted {
    /// The photons of some buckets: in two ranges, where the last bucket is passed.
    #[inline(always)]
    pub(crate) fn photons(&self, run: Run) -> [Range<usize>; 2] {
        let buckets = self.starts.len() - 1;
        let (first, end) = (run.bucket as usize, run.bucket as usize + run.length as usize);
        let start = |bucket: usize| self.starts[bucket] as usize;
        if end <= buckets {
            [start(first)..start(end), 0..0]
        } else {
            [start(first)..start(buckets), 0..start(end - buckets)]
        }
    }
}

/// The visible points of a group as lanes: one vector of 16, or two of 8.
pub(crate) struct Group<L: Lanes> {
    parts: [Part<L>; 2],
    /// The surface whose photons need no test of the side: that of all points, if they share one.
    safe: u32,
}

#[derive(Clone, Copy)]
struct Part<L: Lanes> {
    point: V3<L>,
    normal: V3<L>,
    /// The surface whose photons need no test of the side.
    safe: L::U,
    /// Squared radius; negative where there is no point, so that nothing is nearer.
    radius_squared: L::F,
}

impl<L: Lanes> Group<L> {
    /// How many vectors a group takes.
    const PARTS: usize = GROUP / L::N;

    #[inline(always)]
    pub(crate) fn new(rows: &[PixelRows], pixels: &[Row]) -> Self {
        let mut shared = NO_SPHERE;
        let mut is_shared = true;
        for row in &rows[..GROUP] {
            let sphere = row.visible.0[3].to_bits();
            is_shared &= sphere == NO_SPHERE || shared == NO_SPHERE || sphere == shared;
            shared = if sphere == NO_SPHERE { shared } else { sphere };
        }
        let safe = if is_shared { safe_surface(shared) } else { NO_SPHERE };
        Self {
            parts: [Part::new(rows, pixels), Part::new(&rows[GROUP - L::N..], &pixels[GROUP - L::N..])],
            safe,
        }
    }
}

impl<L: Lanes> Part<L> {
    /// The first `L::N` pixels.
    #[inline(always)]
    fn new(rows: &[PixelRows], pixels: &[Row]) -> Self {
        let ([x, y, z, sphere, ..], [nx, ny, nz, ..]) = load_pixel_rows::<L>(rows);
        let [.., radius_squared] = L::load_rows(pixels);
        let is_nothing = L::eq(L::bits(sphere), L::u(NO_SPHERE));
        let radius_squared = L::select(is_nothing, L::f(-1.0), radius_squared);
        let safe = L::bits(sphere) | L::u(SAFE);
        Self { point: V3::new(x, y, z), normal: V3::new(nx, ny, nz), safe, radius_squared }
    }
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
    group: &'a Group<L>,
    sorted: &'a Sorted,
    sums: &'a mut Sums,
    counts: &'a mut JoinCounts,
    m: [L::U; 2],
    flux: [[L::U; 2]; 3],
    pending: usize,
}

impl<'a, L: Lanes> Gathering<'a, L> {
    #[inline(always)]
    pub(crate) fn new(
        group: &'a Group<L>,
        sorted: &'a Sorted,
        sums: &'a mut Sums,
        counts: &'a mut JoinCounts,
    ) -> Self {
        let zero = L::u(0);
        Self { group, sorted, sums, counts, m: [zero; 2], flux: [[zero; 2]; 3], pending: 0 }
    }

    /// Takes in a run of photons.
    #[inline(always)]
    pub(crate) fn take(&mut self, run: Range<usize>) {
        self.counts.candidates += (run.len() * GROUP) as u64;
        for index in run {
            if self.pending == FLUSH {
                self.flush();
            }
            self.pending += 1;
            let record = &self.sorted.records[index].0;
            let [x, y, z, surface, flux @ .., _] = *record;
            let point = V3::splat(Vec3::new(x, y, z));
            let is_safe = surface.to_bits() == self.group.safe;
            for k in 0..Group::<L>::PARTS {
                let part = self.group.parts[k];
                let d = point - part.point;
                let mut counts = L::lt(d.dot(d), part.radius_squared);
                if !is_safe {
                    let [wx, wy, wz, _] = self.sorted.directions[index];
                    let wi = V3::splat(Vec3::new(wx, wy, wz));
                    let own = L::eq(part.safe, L::u(surface.to_bits()));
                    counts = counts & (own | L::lt(L::f(0.0), wi.dot(part.normal)));
                }
                self.m[k] = L::add_where(counts, self.m[k], L::u(1));
                for channel in 0..3 {
                    // As a float: a broadcast from memory, where an integer would pass through a scalar register.
                    let flux = L::bits(L::f(flux[channel]));
                    self.flux[channel][k] = L::add_where(counts, self.flux[channel][k], flux);
                }
            }
        }
    }

    /// Moves the 32-bit sums to where they cannot overflow.
    #[inline(always)]
    fn flush(&mut self) {
        let mut lanes = [0; GROUP];
        for k in 0..Group::<L>::PARTS {
            L::store_u(self.m[k], &mut lanes[k * L::N..]);
        }
        for (sum, lane) in self.sums.m.iter_mut().zip(lanes) {
            *sum += lane;
            self.counts.contributions += u64::from(lane);
        }
        for channel in 0..3 {
            for k in 0..Group::<L>::PARTS {
                L::store_u(self.flux[channel][k], &mut lanes[k * L::N..]);
            }
            for (sum, lane) in self.sums.flux[channel].iter_mut().zip(lanes) {
                *sum += u64::from(lane);
            }
        }
        self.m = [L::u(0); 2];
        self.flux = [[L::u(0); 2]; 3];
        self.pending = 0;
    }

    /// Gives the sums.
    #[inline(always)]
    pub(crate) fn finish(mut self) {
        self.flush();
    }
}

/// One visible point against a run of photons, these in lanes.
#[inline(always)]
pub(crate) fn single<L: Lanes>(
    sorted: &Sorted,
    run: Range<usize>,
    row: &PixelRows,
    radius_squared: f32,
    sums: &mut LaneSums,
    counts: &mut JoinCounts,
) {
    let [x, y, z, sphere, ..] = row.visible.0;
    let point = V3::<L>::splat(Vec3::new(x, y, z));
    let safe = L::u(safe_surface(sphere.to_bits()));
    counts.candidates += run.len() as u64;
    let mut at = run.start;
    while at < run.end {
        let end = run.end.min(at + FLUSH / MOST_LANES * L::N);
        let mut flux = [L::u(0); 3];
        let mut m = 0;
        while at < end {
            let [px, py, pz, surface, r, g, b, _] = L::load_rows(&sorted.records[at..]);
            let d = V3::<L>::new(px, py, pz) - point;
            let near = L::lt(d.dot(d), L::f(radius_squared)) & L::first(end - at);
            let mut bits = L::mask_bits(near);
            if bits != 0 {
                let doubtful = L::mask_bits(near & !L::eq(L::bits(surface), safe));
                bits &= !hidden(&sorted.directions[at..], row, doubtful);
                let counted = L::mask_from_bits(bits);
                m += bits.count_ones();
                flux[0] = L::add_where(counted, flux[0], L::bits(r));
                flux[1] = L::add_where(counted, flux[1], L::bits(g));
                flux[2] = L::add_where(counted, flux[2], L::bits(b));
            }
            at += L::N;
        }
        at = end;
        counts.contributions += u64::from(m);
        sums.sums.m[sums.lane] += m;
        for channel in 0..3 {
            let mut lanes = [0; MOST_LANES];
            L::store_u(flux[channel], &mut lanes);
            for lane in &lanes[..L::N] {
                sums.sums.flux[channel][sums.lane] += u64::from(*lane);
            }
        }
    }
}

/// Those of the doubtful photons that arrive on the side that is not seen.
#[inline(always)]
fn hidden(directions: &[[f32; 4]], row: &PixelRows, doubtful: u32) -> u32 {
    let [nx, ny, nz, ..] = row.light.0;
    let (mut rest, mut hidden) = (doubtful, 0);
    while rest != 0 {
        let lane = rest.trailing_zeros();
        rest &= rest - 1;
        let [x, y, z, _] = directions[lane as usize];
        let faces = Vec3::new(x, y, z).dot(Vec3::new(nx, ny, nz)) > 0.0;
        hidden |= u32::from(!faces) << lane;
    }
    hidden
}

//! The join: which photons count at which visible points, and what do they bring?
//!
//! ```text
//! for each work item of 1024 pixels, on any thread:
//!     for each group of 16 pixels (a block of 4x4):
//!         if the region of the group's visible points fits into a window of cells:
//!             look up the photons of the region; gather for all points at once            (group.rs)
//!         else, for each point:
//!             look up the photons of the point's own region; gather for it alone          (point.rs)
//!         in the last round of the iteration: consolidate                                 (consolidate.rs)
//! ```
//!
//! How it differs from the reference's hash grid, and why:
//!
//! 1. Photons are sorted and visible points look them up, not the other way round: so sums stay in registers.
//! 2. Points of a group are near each other, so they share the look-up. Photons are culled by the bounding box of the
//!    points, with photons in lanes. Each that remains is loaded once for up to 16 tests, with points in lanes: a
//!    broadcast, with no gather, no scatter and no sum across lanes. Behind a glass ball neighbours in the picture are
//!    far apart in space; such points gather by themselves.
//! 3. Rows of cells hold several times the photons that are within reach of the box. The test of the box costs a tenth of
//!    the test of the points.
//! 4. The side on which a photon arrives is tested only where it is in doubt ([`SAFE`]).
//! 5. Sums are integers, so their order does not matter. A sum of 32 bits holds 2047 photons of at most 2^21; it is
//!    emptied before that.

mod bins;
mod cells;
mod chunk;
mod deposit;
mod found;
mod group;
mod occupancy;
mod point;
mod radii;
mod region;
mod runs;
mod sorted;
pub(crate) mod sums;

use crate::consolidate::{consolidate_group, estimate_group};
use crate::pixels::{GROUP, GroupColumns, PER_LINE, Pixel, PixelRow, Seen};
use crate::pool::Pool;
use crate::work_items::singly;
pub(crate) use bins::{BYTES_OF_BINS, Binned, Writer, bin_shift, bytes_at_rest, with_margin};
pub(crate) use cells::{Cells, Run, table_size};
pub(crate) use chunk::Slabs;
pub(crate) use deposit::{Arrival, Direction, EXPONENT_SHIFT, Flux, HEAVY, Record, SAFE, SPHERE};
pub(crate) use found::JoinBuffers;
use group::{Gathering, Group};
use lanes::{Kernel, LaneKind, Lanes, dispatch, prefetch};
pub(crate) use occupancy::Occupancy;
use point::SinglePoint;
pub(crate) use radii::{Radii, RadiiSums};
use rayon::prelude::*;
use region::ReachLanes;
pub(crate) use region::Region;
use runs::Runs;
use scene::film::FluxUnit;
use scene::{Stats, Stop};
pub(crate) use sorted::{Deposits, Sorted};
use std::mem::take;
pub(crate) use sums::{GroupSums, JoinCounts, MOST_BYTES_OF_SUMS};

/// So many groups before its turn, a group is asked for from memory.
const AHEAD: usize = 2;

/// A join of more pairs than this is long.
const LONG_JOIN: u64 = 1 << 29;
/// Until a join has been counted, one of more deposits than this counts as long.
const MANY_DEPOSITS: usize = 1 << 20;

/// Joins of a render. Those that take long can be stopped: they add up the photons of all pixels first, and consolidate
/// after that. The others consolidate each group at once, which takes less time and memory.
pub(crate) struct Join {
    /// This iteration's sums of all groups, in tile order. Empty while no join is long and one round of photons suffices.
    sums: Vec<GroupSums>,
    /// The number of pairs from which on a join is long.
    long_from: u64,
    /// Whether the last join was long.
    was_long: Option<bool>,
    buffers: Pool<JoinBuffers>,
}

/// The photons and cells of a round.
#[derive(Clone, Copy)]
pub(crate) struct Round<'a> {
    /// The photons to be gathered; `None` if all are in the sums.
    pub(crate) sorted: Option<&'a Sorted>,
    pub(crate) cells: Cells,
    /// True if no round of this iteration follows.
    pub(crate) is_last: bool,
    /// What fluxes count in.
    pub(crate) unit: FluxUnit,
    /// If radii are global, the density of the iteration: see [`estimate_group`].
    pub(crate) density: Option<f32>,
}

/// What a round has come to.
pub(crate) struct Joined {
    /// The radii of the pixels, if they have been consolidated.
    pub(crate) radii: Option<Radii>,
}

impl Join {
    pub(crate) fn new() -> Self {
        Self { sums: Vec::new(), long_from: LONG_JOIN, was_long: None, buffers: Pool::new() }
    }

    /// Sets the number of pairs from which on a join is long.
    pub(crate) fn set_long(&mut self, pairs: u64) {
        (self.long_from, self.was_long) = (pairs, (pairs == 0).then_some(true));
    }

    /// Joins the photons of a round with the visible points of all pixels; in the last round, consolidates the pixels.
    /// `None` if stopped, and then no pixel has changed.
    pub(crate) fn run(
        &mut self,
        round: Round,
        (lanes, per_job): (LaneKind, usize),
        pixels: &mut [Pixel],
        seen: &Seen,
        stats: &mut Stats,
        stop: &Stop,
    ) -> Option<Joined> {
        let before = stats.candidates;
        let is_long =
            self.was_long.unwrap_or(round.sorted.is_some_and(|sorted| sorted.count() > MANY_DEPOSITS));
        let joined = if round.is_last && !is_long {
            self.run_round(round, (lanes, per_job), pixels, seen, stats, &Stop::new())
        } else {
            self.sums.resize(pixels.len() / GROUP, GroupSums::default());
            let joined = self.run_round(
                Round { is_last: false, ..round },
                (lanes, per_job),
                pixels,
                seen,
                stats,
                stop,
            );
            if stop.is_requested() {
                return None;
            }
            if round.is_last {
                let round = Round { sorted: None, ..round };
                self.run_round(round, (lanes, per_job), pixels, seen, stats, &Stop::new())
            } else {
                joined
            }
        };
        // By counted work and not by the clock, so that memory does not depend on how busy the machine is.
        self.was_long = Some(stats.candidates - before >= self.long_from);
        Some(joined)
    }

    /// Adds the photons of a round to the sums, if these are kept; in the last round, consolidates.
    fn run_round(
        &mut self,
        round: Round,
        (lanes, per_job): (LaneKind, usize),
        pixels: &mut [Pixel],
        seen: &Seen,
        stats: &mut Stats,
        stop: &Stop,
    ) -> Joined {
        let chunks = round.sorted.map(Sorted::chunks).unwrap_or_default();
        let deposits = round.sorted.map(|sorted| sorted.deposits(&chunks));
        // Empty slices, if no sums are kept.
        let mut sums: Vec<&mut [GroupSums]> = self.sums.chunks_mut(per_job / GROUP).collect();
        sums.resize_with(pixels.len().div_ceil(per_job), Default::default);
        let seen = seen.rows.par_chunks(per_job).zip(seen.columns.par_chunks(per_job / GROUP));
        let jobs = pixels.par_chunks_mut(per_job).zip(seen).zip(sums);
        let done: Vec<(JoinCounts, RadiiSums)> = singly(jobs)
            .map(|((pixels, seen), sums)| {
                if stop.is_requested() {
                    return Default::default();
                }
                let mut buffers = self.buffers.take(JoinBuffers::new);
                let done =
                    dispatch(lanes, JoinJob { round, deposits, pixels, seen, sums, buffers: &mut buffers });
                self.buffers.put(buffers);
                done
            })
            .collect();
        for (counts, _) in &done {
            stats.candidates += counts.candidates;
            stats.contributions += counts.contributions;
        }
        let is_consolidated = round.is_last && round.density.is_none();
        Joined { radii: is_consolidated.then(|| Radii::of_sums(done.iter().map(|(_, radii)| radii))) }
    }

    /// Clears the sums after an iteration.
    pub(crate) fn clear(&mut self) {
        self.sums.clear();
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.sums[..])
    }
}

/// A work item: some pixels.
struct JoinJob<'a> {
    round: Round<'a>,
    deposits: Option<Deposits<'a>>,
    pixels: &'a mut [Pixel],
    seen: (&'a [PixelRow], &'a [GroupColumns]),
    /// The sums of earlier rounds; empty if none are kept.
    sums: &'a mut [GroupSums],
    buffers: &'a mut JoinBuffers,
}

impl Kernel for JoinJob<'_> {
    type Output = (JoinCounts, RadiiSums);
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Round { cells, is_last, unit, density, .. } = self.round;
        let (mut counts, mut radii) = (JoinCounts::default(), RadiiSums::default());
        let (all_rows, columns) = self.seen;
        let groups = self.pixels.chunks_mut(GROUP).zip(all_rows.chunks(GROUP).zip(columns));
        for (number, (pixels, seen)) in groups.enumerate() {
            let (rows, _) = seen;
            let mut sums = self.sums.get_mut(number).map(take).unwrap_or_default();
            // A group may have no photons, and take no longer than memory does to answer.
            GroupColumns::prefetch(columns, number + AHEAD);
            for k in (0..GROUP).step_by(PER_LINE) {
                prefetch(pixels, AHEAD * GROUP + k);
                prefetch(rows, AHEAD * GROUP + k);
            }
            if let Some(deposits) = &self.deposits {
                gather_group::<L>(deposits, cells, seen, self.buffers, &mut sums, &mut counts);
            }
            if is_last && let Some(density) = density {
                estimate_group::<L>(pixels, seen, &sums, unit, density);
            } else if is_last {
                consolidate_group::<L>(pixels, seen, &sums, unit, &mut radii);
            } else if let Some(kept) = self.sums.get_mut(number) {
                *kept = sums;
            }
        }
        (counts, radii)
    }
}

/// Adds up the photons that count at each pixel of a group.
#[inline(always)]
pub(crate) fn gather_group<L: Lanes>(
    deposits: &Deposits,
    cells: Cells,
    (rows, columns): (&[PixelRow], &GroupColumns),
    buffers: &mut JoinBuffers,
    sums: &mut GroupSums,
    counts: &mut JoinCounts,
) {
    let halves = [Region::of_all(&rows[..GROUP / 2]), Region::of_all(&rows[GROUP / 2..][..GROUP / 2])];
    let all = halves[0].and(&halves[1]);
    if all.is_empty() {
        return;
    }
    let span = cells.span(&all);
    if span.fits() {
        buffers.runs[0].look_up(deposits, &cells.query::<L>(span, &all));
        let group = Group { rows, columns, halves, all };
        Gathering::<L::Pair>::run(&group, deposits, buffers, sums, counts);
        return;
    }
    // All points take each step before the first takes the next, so that memory answers in the meantime.
    let mut fits = [false; GROUP];
    let parts = rows.chunks(L::N).zip(buffers.runs.chunks_mut(L::N)).zip(fits.chunks_mut(L::N));
    for ((rows, runs), fits) in parts {
        list_apart::<L>(deposits, cells, rows, runs, fits);
    }
    for (runs, _) in buffers.runs.iter_mut().zip(fits).filter(|(_, fits)| *fits) {
        runs.locate(deposits);
    }
    for ((lane, row), fits) in rows.iter().enumerate().zip(fits) {
        let mut point = SinglePoint { row, normal: columns.normal(lane), sums, lane };
        if fits {
            point.run::<L>(deposits, buffers, counts);
        } else if row.visible().is_some() {
            // Coordinates are so large that they round to many cells.
            point.run_on_all::<L>(deposits, buffers, counts);
        }
    }
}

/// Lists the rows of cells near each of `L::N` points by itself, and tells which points have no more cells than a window.
#[inline(always)]
fn list_apart<L: Lanes>(
    deposits: &Deposits,
    cells: Cells,
    rows: &[PixelRow],
    runs: &mut [Runs],
    fits: &mut [bool],
) {
    let points = ReachLanes::<L>::load(rows);
    if let Some(near) = cells.near_points::<L>(points.point, points.reach, points.are_there) {
        let are_there = L::mask_bits(points.are_there);
        for (lane, (runs, fits)) in runs.iter_mut().zip(fits).enumerate() {
            *fits = are_there >> lane & 1 == 1;
            if *fits {
                runs.list_near(deposits, &near, lane);
            }
        }
        return;
    }
    for ((row, runs), fits) in rows.iter().zip(runs).zip(fits) {
        if let Some(region) = Region::of_one(row) {
            let span = cells.span(&region);
            *fits = span.fits();
            if *fits {
                runs.list(deposits, &cells.query::<L>(span, &region));
            }
        }
    }
}

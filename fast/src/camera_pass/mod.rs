//! Camera pass: a ray through every pixel, to its visible point and direct light. `reference::camera_pass`, over batches
//! of pixels.
//!
//! ```text
//! for each work item of 1024 pixels, on any thread:
//!     for each batch of 256 pixels (four tiles of 8x8):
//!         make the rays
//!         until no path is left, at most max_depth times:
//!             intersect all; shade all: paths that end go to a list, the others to the front of the batch
//!         direct light for all on the list, in full packets
//!         write the visible point and direct light of every pixel
//!     give each pixel its search radius of this iteration
//!     mark the cells that the visible points reach in the thread's occupancy map
//! merge the occupancy maps of all threads
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. Stages over a batch: see [`crate::paths`].
//! 2. Pixels are in tile order: see [`crate::pixels`].
//! 3. The occupancy map lets the photon pass drop deposits that no visible point can reach.

mod batch;

use crate::join::Occupancy;
use crate::pixels::{GROUP, GroupColumns, Pixel, PixelRow, Seen, TILE};
use crate::pool::Pool;
use crate::work_items::singly;
pub(crate) use batch::{CameraBatch, CameraCounts, CameraPass};
use lanes::{Kernel, LaneKind, Lanes, dispatch, prefetch};
use rayon::current_num_threads;
use rayon::prelude::*;
use scene::{Stats, Stop};
use std::mem::take;

/// How a pass is divided into work items and batches, and what its occupancy map is like.
#[derive(Clone, Copy)]
pub(crate) struct CameraPlan {
    pub(crate) pixels_per_job: usize,
    pub(crate) pixels_per_batch: usize,
    /// The size of the occupancy map's cells.
    pub(crate) occupancy_cell: f32,
    pub(crate) occupancy_bits: u32,
}

/// Buffers of all threads.
pub(crate) struct CameraWorkers(Pool<CameraWorker>);

/// Buffers of a thread, and what it has counted in this pass.
struct CameraWorker {
    batch: CameraBatch,
    /// Made for each pass, as the size of cells changes.
    occupancy: Option<Occupancy>,
    counts: CameraCounts,
}

impl CameraWorker {
    fn new() -> Self {
        Self { batch: CameraBatch::new(), occupancy: None, counts: CameraCounts::default() }
    }
}

impl CameraWorkers {
    pub(crate) fn new() -> Self {
        Self(Pool::new())
    }

    /// Runs the pass on all threads: fills `seen` and adds to `stats`. Returns the cells that visible points reach;
    /// `None` if stopped.
    pub(crate) fn run(
        &mut self,
        pass: &CameraPass,
        (lanes, plan): (LaneKind, CameraPlan),
        seen: &mut Seen,
        pixels: &[Pixel],
        stats: &mut Stats,
        stop: &Stop,
    ) -> Option<Occupancy> {
        let new_map = || Occupancy::new(plan.occupancy_cell, plan.occupancy_bits);
        let per_job = plan.pixels_per_job;
        let Seen { rows, columns } = seen;
        let seen = rows.par_chunks_mut(per_job).zip(columns.par_chunks_mut(per_job / GROUP));
        let jobs = seen.zip(pixels.par_chunks(per_job)).enumerate();
        let workers = &self.0;
        workers.fill(jobs.len().min(current_num_threads()), CameraWorker::new);
        singly(jobs).for_each(|(job, ((rows, columns), pixels))| {
            if stop.is_requested() {
                return;
            }
            let mut worker = workers.take(CameraWorker::new);
            let CameraWorker { batch, occupancy, .. } = &mut worker;
            let occupancy = occupancy.get_or_insert_with(new_map);
            let (at_once, first) = (plan.pixels_per_batch, job * per_job);
            let counts =
                dispatch(lanes, CameraJob { pass, batch, at_once, first, rows, columns, pixels, occupancy });
            worker.counts.add(counts);
            workers.put(worker);
            stop.meter().advance(pixels.len() as u64);
        });
        let mut all = new_map();
        for worker in self.0.all() {
            worker.occupancy.take().iter().for_each(|occupancy| all.merge(occupancy));
            let CameraCounts { segments, visible_points } = take(&mut worker.counts);
            stats.camera_segments += segments;
            if pass.has_direct() {
                stats.shadow_rays += visible_points * u64::from(pass.settings.light_samples);
            }
            stats.visible_points += visible_points;
        }
        (!stop.is_requested()).then_some(all)
    }

    /// Clears what a stopped pass has left.
    pub(crate) fn clear(&mut self) {
        for worker in self.0.all() {
            (worker.occupancy, worker.counts) = (None, CameraCounts::default());
        }
    }
}

/// A work item: the pixels of the slots from `first` on.
pub(crate) struct CameraJob<'a> {
    pub(crate) pass: &'a CameraPass<'a>,
    pub(crate) batch: &'a mut CameraBatch,
    /// Pixels of a batch.
    pub(crate) at_once: usize,
    pub(crate) first: usize,
    pub(crate) rows: &'a mut [PixelRow],
    pub(crate) columns: &'a mut [GroupColumns],
    pub(crate) pixels: &'a [Pixel],
    pub(crate) occupancy: &'a mut Occupancy,
}

impl Kernel for CameraJob<'_> {
    type Output = CameraCounts;
    #[inline(always)]
    fn run<L: Lanes>(self) -> CameraCounts {
        let mut counts = CameraCounts::default();
        let seen = self.rows.chunks_mut(self.at_once).zip(self.columns.chunks_mut(self.at_once / GROUP));
        for (number, seen) in seen.enumerate() {
            counts.add(self.pass.run::<L>(self.batch, self.first + number * self.at_once, seen));
        }
        for (rows, pixels) in self.rows.chunks_mut(TILE).zip(self.pixels.chunks(TILE)) {
            for (k, (row, pixel)) in rows.iter_mut().zip(pixels).enumerate() {
                prefetch(pixels, k + TILE); // of the next tile, perhaps past the end of this slice
                row.radius_squared = self.pass.radius_squared(row, pixel);
            }
            self.occupancy.mark_tile::<L>(rows);
        }
        counts
    }
}

//! Photon pass: photons from the lights to their deposits. `reference::photon_pass`, over batches of photons.
//!
//! ```text
//! for each work item of 1024 photons, on any thread, until there are enough deposits for a join:
//!     for each batch of up to 256 photons:
//!         emit all
//!         until none is left, at most max_depth times:
//!             intersect all
//!             for each packet: fetch surface and material; deposit; roulette; scatter; survivors to the front
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. Stages over a batch: see [`crate::paths`].
//! 2. A deposit is dropped at once unless some visible point reaches its cell ([`Occupancy`](crate::join::Occupancy)):
//!    what cannot count need not be sorted. The others go into the thread's bins ([`Binned`]).
//! 3. Whether a photon arrives on the visible side is mostly known from its own surface: on the same sphere, within
//!    reach, normals differ little. Such deposits are marked as safe, and the join skips the test.

mod aiming;
mod batch;
mod emission;
mod guiding;

use crate::join::{Binned, Cells, Slabs, Sorted, bytes_at_rest};
use crate::pool::Pool;
use crate::work_items::singly;
pub(crate) use batch::{PhotonBatch, PhotonCounts, PhotonPass, Rounding, quantise, quantise_aimed, survive};
pub(crate) use emission::{Emission, Emitters};
use lanes::{Kernel, LaneKind, Lanes, dispatch};
use rayon::current_num_threads;
use rayon::prelude::*;
use scene::{Stats, Stop};
use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

/// The work of tracing a photon in units of that of a pixel of the camera pass, about; for [`scene::Meter`].
pub(crate) const PHOTON_WORK: u64 = 2;

/// Buffers of all threads, with the deposits that they hold in bins.
pub(crate) struct PhotonWorkers {
    workers: Pool<PhotonWorker>,
    /// Room for deposits in bins.
    slabs: Arc<Slabs>,
}

/// Buffers of a thread, its deposits, and what it has counted.
struct PhotonWorker {
    batch: PhotonBatch,
    out: Binned,
    counts: PhotonCounts,
}

impl PhotonWorker {
    fn new(slabs: &Arc<Slabs>) -> Self {
        Self { batch: PhotonBatch::new(), out: Binned::new(slabs), counts: PhotonCounts::default() }
    }
}

/// The photons of a round, and how they are divided.
#[derive(Clone, Copy)]
pub(crate) struct PhotonPlan {
    /// The round begins at this photon.
    pub(crate) from: u32,
    /// The photons of the iteration.
    pub(crate) total: u32,
    /// The round ends once there are so many deposits.
    pub(crate) deposits_at_once: u32,
    pub(crate) photons_per_job: u32,
}

impl PhotonWorkers {
    pub(crate) fn new() -> Self {
        Self { workers: Pool::new(), slabs: Arc::new(Pool::new()) }
    }

    /// Traces the photons of a round on all threads, into the workers' bins, and adds to `stats`. Returns where the next
    /// round begins; `None` if stopped.
    pub(crate) fn run(
        &mut self,
        pass: &PhotonPass,
        (lanes, plan): (LaneKind, PhotonPlan),
        stats: &mut Stats,
        stop: &Stop,
    ) -> Option<u32> {
        let PhotonPlan { total, deposits_at_once, photons_per_job: per_job, .. } = plan;
        let (mut next, mut deposits) = (plan.from, 0);
        // So many photons are traced, again and again, as fill what is left of the round if every photon is deposited at every
        // bounce, so that it never overflows. What is left shrinks; a quarter is not worth the wait for the last thread.
        let bounces = (pass.max_depth - 1).max(1);
        let enough = (deposits_at_once as usize / 4 * 3).max(1);
        while next < total && deposits < enough {
            let left = deposits_at_once - deposits as u32;
            let most = (left / bounces / per_job).max(1) * per_job;
            let end = total.min(next.saturating_add(most));
            self.trace(pass, (lanes, per_job), next..end, stop);
            deposits = self.workers.all().iter().map(|worker| worker.out.count).sum();
            stats.photons += u64::from(end - next);
            next = end;
        }
        for worker in self.workers.all() {
            let PhotonCounts { segments, deposits } = take(&mut worker.counts);
            stats.photon_segments += segments;
            stats.deposits += deposits;
        }
        (!stop.is_requested()).then_some(next)
    }

    /// Traces a range of photons.
    fn trace(&self, pass: &PhotonPass, (lanes, per_job): (LaneKind, u32), photons: Range<u32>, stop: &Stop) {
        let jobs: Vec<u32> = photons.clone().step_by(per_job as usize).collect();
        let Self { workers, slabs } = self;
        workers.fill(jobs.len().min(current_num_threads()), || PhotonWorker::new(slabs));
        singly(jobs.into_par_iter()).for_each(|start| {
            if stop.is_requested() {
                return;
            }
            let mut worker = workers.take(|| PhotonWorker::new(slabs));
            let photons = start..photons.end.min(start.saturating_add(per_job));
            let count = photons.len() as u64;
            let (batch, out) = (&mut worker.batch, &mut worker.out);
            let counts = dispatch(lanes, PhotonJob { pass, batch, photons, out });
            worker.counts.segments += counts.segments;
            worker.counts.deposits += counts.deposits;
            workers.put(worker);
            stop.meter().advance(PHOTON_WORK * count);
        });
    }

    /// Sorts the deposits in the workers' bins by the buckets of `cells`, and empties the bins.
    pub(crate) fn sort_into(&mut self, sorted: &mut Sorted, cells: Cells) {
        let mut parts: Vec<&mut Binned> =
            self.workers.all().iter_mut().map(|worker| &mut worker.out).collect();
        sorted.fill(&mut parts, &self.slabs, cells);
    }

    /// Drops what is sorted, and takes its room back.
    pub(crate) fn take_back(&self, sorted: &mut Sorted) {
        sorted.clear(&self.slabs);
    }

    /// Clears what a stopped pass has left.
    pub(crate) fn clear(&mut self) {
        for worker in self.workers.all() {
            worker.out.clear();
            worker.counts = PhotonCounts::default();
        }
    }

    /// Bytes of bins and slabs.
    pub(crate) fn bytes(&mut self) -> usize {
        let bins: usize = self.workers.all().iter().map(|worker| worker.out.bytes()).sum();
        bins + bytes_at_rest(&self.slabs)
    }
}

/// A work item: some photons.
pub(crate) struct PhotonJob<'a> {
    pub(crate) pass: &'a PhotonPass<'a>,
    pub(crate) batch: &'a mut PhotonBatch,
    pub(crate) photons: Range<u32>,
    pub(crate) out: &'a mut Binned,
}

impl Kernel for PhotonJob<'_> {
    type Output = PhotonCounts;
    #[inline(always)]
    fn run<L: Lanes>(self) -> PhotonCounts {
        self.pass.run::<L>(self.batch, self.photons, self.out)
    }
}

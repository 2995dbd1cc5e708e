//! Samples of all pixels, by all threads.

use super::batch::{PathBatch, PathPass};
use crate::pool::Pool;
use crate::work_items::singly;
use lanes::{Kernel, LaneKind, Lanes, dispatch};
use rayon::current_num_threads;
use rayon::prelude::*;
use scene::Stop;

/// How a pass is divided into work items and batches.
#[derive(Clone, Copy)]
pub(super) struct PathPlan {
    pub(super) pixels_per_job: usize,
    pub(super) paths_per_batch: usize,
}

/// Buffers of all threads.
pub(super) struct PathWorkers(Pool<PathBatch>);

impl PathWorkers {
    pub(super) fn new() -> Self {
        Self(Pool::new())
    }

    /// Takes a sample of each pixel, in tile order; returns the number of segments traced. `None` if stopped: then some
    /// samples are of this iteration and some are not.
    pub(super) fn run(
        &self,
        pass: &PathPass,
        (lanes, plan): (LaneKind, PathPlan),
        samples: &mut [[f32; 3]],
        stop: &Stop,
    ) -> Option<u64> {
        let per_job = plan.pixels_per_job;
        let jobs = samples.par_chunks_mut(per_job).enumerate();
        self.0.fill(jobs.len().min(current_num_threads()), PathBatch::new);
        let segments = singly(jobs).map(|(job, samples)| {
            if stop.is_requested() {
                return None;
            }
            let mut batch = self.0.take(PathBatch::new);
            let pixels = samples.len() as u64;
            let (first, at_once) = (job * per_job, plan.paths_per_batch);
            let segments = dispatch(lanes, PathJob { pass, batch: &mut batch, at_once, first, samples });
            self.0.put(batch);
            stop.meter().advance(pixels);
            Some(segments)
        });
        segments.sum()
    }
}

/// A work item: the pixels of the slots from `first` on.
struct PathJob<'a> {
    pass: &'a PathPass<'a>,
    batch: &'a mut PathBatch,
    /// Paths of a batch.
    at_once: usize,
    first: usize,
    samples: &'a mut [[f32; 3]],
}

impl Kernel for PathJob<'_> {
    /// Segments traced.
    type Output = u64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        self.pass.run::<L>(self.batch, self.first, self.at_once, self.samples)
    }
}

//! Parallel work, job by job.

use rayon::iter::{IndexedParallelIterator, MaxLen};

/// Jobs that idle threads take one at a time.
///
/// Rayon by itself hands out runs of jobs, which it divides only when a thread comes to ask; the last runs of a pass then
/// keep one thread busy while others wait, a tenth of the time of short passes on two threads.
pub(crate) fn singly<J: IndexedParallelIterator>(jobs: J) -> MaxLen<J> {
    jobs.with_max_len(1)
}

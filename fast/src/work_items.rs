//! Parallel work, item by item.

use rayon::iter::{IndexedParallelIterator, MaxLen};

/// Work items that idle threads take one at a time.
///
/// Rayon by itself gives threads runs of items and splits a run only when another thread is idle. The last runs of a pass
/// then keep one thread busy while others wait: a tenth of the time of short passes on two threads.
pub(crate) fn singly<J: IndexedParallelIterator>(items: J) -> MaxLen<J> {
    items.with_max_len(1)
}

//! Buffers that are kept for later iterations. Memory that is returned to the system must be faulted in again, which takes
//! half a millisecond per megabyte.

use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Buffers that are not in use. Each work item takes one, and puts it back.
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Pool<T> {
    /// An empty pool.
    pub(crate) fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// Takes a buffer, or makes one if there is none.
    pub(crate) fn take(&self, new: impl FnOnce() -> T) -> T {
        let kept = self.lock().pop();
        kept.unwrap_or_else(new)
    }

    /// Puts a buffer back.
    pub(crate) fn put(&self, buffer: T) {
        self.lock().push(buffer);
    }

    /// Puts many buffers back.
    pub(crate) fn put_all(&self, buffers: impl Iterator<Item = T>) {
        self.lock().extend(buffers);
    }

    /// Makes buffers, on all threads, until there are `count`.
    pub(crate) fn fill(&self, count: usize, new: impl Fn() -> T + Sync)
    where
        T: Send,
    {
        let missing = count.saturating_sub(self.count());
        let made: Vec<T> = (0..missing).into_par_iter().map(|_| new()).collect();
        self.put_all(made.into_iter());
    }

    /// The number of buffers that are not in use.
    pub(crate) fn count(&self) -> usize {
        self.lock().len()
    }

    /// All buffers that are not in use.
    pub(crate) fn all(&mut self) -> &mut Vec<T> {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<T>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

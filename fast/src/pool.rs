//! Buffers that outlive an iteration: memory that goes back to the system has to be faulted in again, at half a
//! millisecond a megabyte.

use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Buffers at rest. One is taken or made per unit of parallel work that needs it.
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Pool<T> {
    /// An empty pool.
    pub(crate) fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// A buffer that is not in use, or a new one.
    pub(crate) fn take(&self, new: impl FnOnce() -> T) -> T {
        let rested = self.lock().pop();
        rested.unwrap_or_else(new)
    }

    /// Puts a buffer to rest.
    pub(crate) fn put(&self, buffer: T) {
        self.lock().push(buffer);
    }

    /// Puts many to rest.
    pub(crate) fn put_all(&self, buffers: impl Iterator<Item = T>) {
        self.lock().extend(buffers);
    }

    /// Makes sure that so many are at rest. All threads make new ones.
    pub(crate) fn fill(&self, count: usize, new: impl Fn() -> T + Sync)
    where
        T: Send,
    {
        let missing = count.saturating_sub(self.count());
        let made: Vec<T> = (0..missing).into_par_iter().map(|_| new()).collect();
        self.put_all(made.into_iter());
    }

    /// How many are at rest.
    pub(crate) fn count(&self) -> usize {
        self.lock().len()
    }

    /// All buffers at rest.
    pub(crate) fn all(&mut self) -> &mut Vec<T> {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<T>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
